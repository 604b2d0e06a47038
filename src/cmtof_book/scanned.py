"""Scanned scenes, and the paper's network fine-tuned on scans of other objects (Sec. 6.4, 8.2).

    python -m cmtof_book.scanned

Everything is simulated. Still lifes go to build/scanned; what is there, or among the stored rates,
is not computed again. Rates and fine-tuned weights go where the chapters read them: book/results.
What is taken out of book/results/scanned.json or book/results/scanned is counted or trained again.
"""

import gc
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import chain, product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import cmtof
from cmtof.constants import FREQUENCIES
from cmtof.correlation import wrap_length
from cmtof.frame import Frame
from cmtof.measurement import Measurement
from cmtof.network.weights import read_card, weights_path
from cmtof.simulation import QUADRATURES, RELEASED_WRAPS
from cmtof.types import Fields
from cmtof_book import RESULTS, package_data
from cmtof_book.counts import Counts, counts_of
from cmtof_book.rendered_stills import labelled, rendered_still
from cmtof_lab.objects import FIELD_OF_VIEW, OBJECTS, TRAINING, still_life
from cmtof_lab.optics import directions_from_angles
from cmtof_lab.rehearsal import scan_scene
from cmtof_lab.settings import NOISE, TwinSettings
from cmtof_lab.targets import MeshTarget, Plane, Target, scene_from

FOLDER = Path("build/scanned")  # of still lifes, and of weights between legs
TUNED = RESULTS / "scanned"  # folder of the fine-tuned weights

STUDY = package_data("scanned")
SHOWN = STUDY["shown"]
HELD_OUT = STUDY["held_out"]
METHODS = STUDY["methods"]
TOLD = STUDY["told"]
TUNED_ROWS = STUDY["tuned"]
CURVE = STUDY["curve"]
LEGS = STUDY["legs"]
LEVELS = STUDY["levels"]

# Things on whose scans the network is fine-tuned: one, two or three of them in a scan.
LEARNT = [name for name in TRAINING if name not in HELD_OUT]


ENDS = wrap_length(FREQUENCIES[0]) * np.array(
    RELEASED_WRAPS
)  # range of the released protocol, m

SIZE = 200
RENDERED = 2  # group of still lifes that are rendered rather than scanned
COVERED = 20  # side, points, of a scan of stray light, whose beam a black cap covers
CAP = Plane(0.1, reflectance=0.0)
SEEDS = (0, 1, 2)
VALIDATED = 9  # scans of held-out things
BASELINE = 0.06  # between the cameras, m: side by side they see what the beam sees
NETWORK = "fast-scnn"
DEPTH_WEIGHT = 0.005  # weight of the distance in depth, 1/mm, as where the network was trained last

# Settings of the instrument by name: its noise, also a multiple of the captures', or a sharp spot.
NOISES = NOISE | {
    f"{by}": NOISE["captures"]
    | {"phase_noise": tuple(np.multiply(by, NOISE["captures"]["phase_noise"]))}
    for by in (0.5, 2.0)
}
NOISES["sharp"] = STUDY["sharp"]

STRIDES = (1, 2, 4)
SWEPT = ("bust", "owl")  # scenes of which fewer points and other noise are tried


def scan_object(name: str, noise: str, **view: Any) -> Measurement:
    """Scan of an object by name, as `scan_target` has it."""
    target = scene_from({"kind": "object", "name": name})
    return scan_target(target, noise, field_of_view=FIELD_OF_VIEW[name], **view)


def scan_target(
    target: Target, noise: str, *, size: int = SIZE, stray=False, **view: Any
) -> Measurement:
    """Scan of a target, its ranges optical, among the wraps 36 to 56 of the released protocol.

    ``noise`` is one of `NOISES`. The zero of the beat is that of a short scan at the photon limit.
    Without ``stray`` light: what comes back while a cap covers the beam is taken away.
    """
    noisy = TwinSettings(**NOISES[noise])
    scan = scan_scene(noisy, target, size=size, **view)
    if not stray:
        scan = scan.without_stray_light(scan_scene(noisy, CAP, size=COVERED, **view))
    if "phase_noise" in NOISES[noise]:
        short = scan_scene(TwinSettings(), target, size=1, **view)
        scan = Measurement(scan.dataset.assign(psi=short.dataset["psi"]))
    return scan.between(*ENDS)


def close_pair(scan: Measurement, other: Measurement) -> Measurement:
    """Measurement at two close frequencies, as `phasor` needs it: the single modes of two scans."""
    single = [one.dataset.isel(frequency=[0]) for one in (scan, other)]
    return Measurement(
        xr.concat(
            single,
            "frequency",
            data_vars="minimal",
            coords="minimal",
            compat="override",
        )
    )


def four_phases(scan: Measurement) -> Measurement:
    """Scan as a network of raw correlations takes it: four quadratures, in counts.

    Sixteen phases are decoded and put back, with the mean of an ideal correlation, pi/2 of the
    amplitude, and the brightest tenth as bright as a white surface.
    """
    from cmtof.network.features import FULL_AMPLITUDE

    bright = np.quantile(scan.amplitude, 0.9, axis=(1, 2), keepdims=True)
    amplitude = scan.amplitude * (FULL_AMPLITUDE / bright)
    psi = np.asarray(QUADRATURES)
    angle = scan.phase[:, None] + psi[:, None, None]
    made = amplitude[:, None] * (np.pi / 2 + np.cos(angle))
    return Measurement.from_arrays(
        made, psi, scan.frequencies, depth=scan.depth, mask=scan.mask
    ).between(*scan.range)


def frame_of(target: Target, scan: Measurement) -> Frame:
    """True range, m, and reflectance of a target at the points of a scan."""
    hits = target.look(directions_from_angles(scan.dataset["angle"].to_numpy()))
    return Frame(hits.range, hits.reflectance, scan.camera)


# one after another, rows of a table read the same scans
kept_scan = lru_cache(maxsize=32)(scan_object)


def examples(numbers: Iterable[int], group: int = 0) -> Iterator[Any]:
    """Still lifes of a group, their wraps, -1 where unknown, and depth, m; kept in files.

    They come one by one, so that only what is learnt from them is held.
    """
    for number in numbers:
        path = FOLDER / f"still_{group}_{number}.nc"
        if not path.exists():
            still_of_group(number, group).save(path)
            gc.collect()  # cycles of meshes, which hold more memory than Python sees
            print(path.stem, flush=True)
        still = cmtof.open(path)
        yield still, *(still.dataset[key].to_numpy() for key in ("wraps", "labels"))


def still_of_group(number: int, group: int) -> Measurement:
    """Still life with labels: rendered, or a scan of a group of things, labelled by stereo."""
    if group == RENDERED:
        return rendered_still(number, SIZE)

    from cmtof_lab import stereo

    rng = np.random.default_rng([number, group])
    names = rng.permutation((LEARNT, HELD_OUT)[group])[: 1 + number % 3]
    mesh, view = still_life([OBJECTS[name]["pieces"] for name in names], rng)
    target = MeshTarget.from_mesh(mesh)
    seed = 1000 + 5000 * group + number
    scan = scan_target(target, "captures", field_of_view=view, seed=seed)
    rig = stereo.simulated_rig(baseline=BASELINE)
    spots = stereo.scan_spots(
        frame_of(target, scan), rig, rng=np.random.default_rng(number)
    )
    found = stereo.truth_from_spots(spots, rig, phase=scan.phase[0])
    return labelled(scan.dataset.drop_vars("raw_counts"), found.wraps, found.depth)


def tuned_weights(scans: int) -> Path:
    """File of the weights trained on rooms and then tuned on labelled scans alone."""
    folder = FOLDER / f"tuned_{scans}_1"
    return train_into(folder, 0, examples(range(scans)), seed=1, **STUDY["tuning"])


def best_weights(legs: int = len(LEGS)) -> Path:
    """File of the weights after the first ``legs`` of `LEGS`; for 0, of those trained on rooms.

    On scans alone a network forgets the still lifes. So a leg with scans has both, and what is kept
    is the mean of the weights before and after it; for the mean see Wortsman et al. (CVPR 2022).
    """
    if not legs:
        return weights_path(NETWORK, "released")
    folder = TUNED if legs == len(LEGS) else FOLDER / f"leg_{legs}"
    first, last, scans = LEGS[legs - 1]
    stills = examples(range(first, last), RENDERED)
    # ten times, or stills would outnumber them
    both = chain(stills, examples([*range(scans)] * 10))
    # a number of its own, though a leg with scans learns the still lifes of the one before
    seed = last // 400 + (scans > 0)
    how = STUDY["learning"]
    return train_into(folder, legs - 1, both, mean=scans > 0, seed=seed, **how)


def train_into(
    folder: Path, legs: int, learnt: Iterable[Any], *, mean=False, **options: Any
) -> Path:
    """File of weights in a folder; if there is none, those after ``legs`` learn from examples.

    With ``mean`` it holds the mean of both. Options are those of `cmtof.network.tuning.fine_tune`.
    The learning rate falls to zero; in half precision where the processor can.
    """
    path = weights_path(NETWORK, "released", folder)
    if path.exists():
        return path

    import torch

    from cmtof.network import weights
    from cmtof.network.training import average_into, multiplies_bfloat16
    from cmtof.network.tuning import fine_tune

    before = weights.load_weights(best_weights(legs))
    model = before.network.model
    before.network.model = model._replace(depth_weight=DEPTH_WEIGHT)
    torch.set_num_threads(1)
    half = multiplies_bfloat16()
    # without a cache, which would keep the first step's weights for the whole block
    with torch.autocast("cpu", torch.bfloat16, half, cache_enabled=False):
        (network, card), losses = fine_tune(before, learnt, **options)
    print(folder.name, np.mean(losses[-50:]), flush=True)
    if mean:  # of weights as files hold them
        network.load_state_dict(weights.half_precision_weights(network))
        average_into(network, before.network, step=9, most=0.5)
    folder.mkdir(exist_ok=True)
    weights.save_weights(path, network, card)
    return path


def scan_for_row(row: str, name: str, noise: str, seed: int) -> Measurement:
    """Scan as a row reads it: four phases for `rapid`, two close frequencies for `phasor`."""
    scan = kept_scan(name, noise, seed=seed, stray=row.startswith("stray"))
    if row == "rapid":
        return four_phases(scan)
    if row == "phasor":
        other = kept_scan(name, noise, seed=seed + 100, frequency_single=7.16e9)
        return close_pair(scan, other)
    return scan


def options_of(row: str) -> Fields:
    """Options of `cmtof.unwrap` for a row: its method, and weights, trained if need be."""
    if row in TUNED_ROWS:
        method, legs = TUNED_ROWS[row]
        return {"method": method, "weights": best_weights(legs)}
    if row.endswith(" scans"):
        return {"method": NETWORK, "weights": tuned_weights(int(row.split()[0]))}
    return {"method": row.removeprefix("stray ")}


def wraps_off(row: str, scans: Iterable[Measurement]) -> list[list[int]]:
    """Of each scan: scored pixels, and how many are off by fewer wraps than 1, 2, 3 and 10."""
    counts = counts_of(scans, **options_of(row))
    return [[one["pixels"], *one["below"]] for one in counts]


def validation_rates(legs: int) -> list[float]:
    """Share of right wraps, after ``legs`` of `LEGS`, on each scan of the things held out."""
    scans = (scan for scan, *_ in examples(range(VALIDATED), 1))
    counts = counts_of(scans, method=NETWORK, weights=best_weights(legs))
    return [round(one["below"][0] / one["pixels"], 4) for one in counts]


def compare(counts: Counts, noise: str, rows: Iterable[str]) -> None:
    """Count right wraps by each row's method and weights, on three scans of each shown scene."""
    for row, scene in product(rows, SHOWN):
        scans = (scan_for_row(row, scene, noise, seed) for seed in SEEDS)
        counts.keep(("counts", noise, row, scene), wraps_off, row, scans)


def sweep(counts: Counts, row: str, name: str) -> None:
    """Count right wraps at each noise of `LEVELS`, with all, each second and each fourth point."""
    for level, stride in product(LEVELS, STRIDES):
        scans = (kept_scan(scene, LEVELS[level], seed=0).dataset for scene in SWEPT)
        thin = (one.thin(x=stride, y=stride).drop_vars("camera") for one in scans)
        keys = ("sweep", level, str(SIZE // stride), name)
        counts.keep(keys, wraps_off, row, map(Measurement, thin))


def main() -> None:
    """Compute what is missing, and store it."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    counts = Counts(RESULTS / "scanned.json")
    for legs in range(len(LEGS) + 1):
        counts.keep(("validation", f"{legs} legs"), validation_rates, legs)
    counts.store(
        settings={"size": SIZE, "seeds": SEEDS, "baseline": BASELINE},
        legs=LEGS,
        training=[STUDY["tuning"], STUDY["learning"]],
        weights=read_card(best_weights()).sha256,
    )
    rows = [*METHODS, *TOLD, *TUNED_ROWS]
    compare(counts, "captures", [*rows, *(f"{n} scans" for n in CURVE)])
    clear = [row for row in rows if row not in ("phasor", "rendered")]
    compare(counts, "photon", [*clear, *STUDY["stray"]])
    for row, name in STUDY["swept"].items():
        sweep(counts, row, name)
    sharp = (kept_scan(name, "sharp", seed=0, stray=True) for name in ["helmet"])
    counts.keep(("sharp", "helmet"), wraps_off, *TOLD, sharp)


if __name__ == "__main__":
    main()
