"""Scanned scenes, and the paper's network fine-tuned on scans of other objects (Sec. 6.4, 8.2).

    python -m cmtof_book.scanned

Everything is simulated. Scans go to build/scanned; what is there, or among the stored rates, is not
computed again. Rates and fine-tuned weights go where the chapters read them: book/results. What is
taken out of book/results/scanned.json or book/results/scanned is counted or trained again.
"""

import gc
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import chain, product
from pathlib import Path
from typing import Any

import numpy as np

import cmtof
from cmtof import __version__
from cmtof.constants import FREQUENCIES
from cmtof.correlation import wrap_length
from cmtof.frame import Frame
from cmtof.measurement import Measurement
from cmtof.network.weights import read_card, weights_path
from cmtof.simulation import QUADRATURES, RELEASED_WRAPS
from cmtof.types import Fields, Named
from cmtof_book import RESULTS
from cmtof_book.counts import Counts, counts_of
from cmtof_book.rendered_stills import labelled, rendered_still
from cmtof_lab.objects import FIELD_OF_VIEW, OBJECTS, TRAINING, still_life
from cmtof_lab.optics import directions_from_angles
from cmtof_lab.rehearsal import scan_scene
from cmtof_lab.settings import NOISE, TwinSettings
from cmtof_lab.targets import MeshTarget, Plane, Target, scene_from

FOLDER = Path("build/scanned")  # of the scans
TUNED = RESULTS / "scanned"  # folder of the fine-tuned weights

SHOWN = ("bust", "helmet", "owl", "table")
# Things on whose scans the recipe of the fine-tuning was chosen.
HELD_OUT = ("glasses", "column", "radio")

# Things on whose scans the network is fine-tuned: one, two or three of them in a scan.
LEARNT = tuple(name for name in TRAINING if name not in HELD_OUT)


ENDS = wrap_length(FREQUENCIES[0]) * np.array(
    RELEASED_WRAPS
)  # range of the released protocol, m

SIZE = 200
RENDERED = 2  # group of still lifes that are rendered rather than scanned
COVERED = 20  # side, points, of a scan of stray light, whose beam a black cap covers
CAP = Plane(0.1, reflectance=0.0)
SEEDS = (0, 1, 2)
METHODS = (
    "kde",
    "region",
    "phasor",
    "rapid",
    "surfaces",
    "surfaces-mirrored",
    "fast-scnn",
)
# Methods that are counted at the photon limit with stray light, too
STRAY = ("kde", "surfaces")
# A reference, which knows the shape of every surface and which of them touch.
TOLD = ("reference-contact",)

CURVE = (1, 3, 10, 40, 136, 300)  # labelled scans whose worth is compared

VALIDATED = 9  # scans of held-out things

BASELINE = 0.06  # between the cameras, m: side by side they see what the beam sees
# Legs of training, the first without labels: the first rendered still life that is learnt, the
# last, and labelled scans among them.
LEGS = (
    (0, 400, 0),
    (0, 800, 0),
    (0, 1200, 0),
    (0, 1600, 0),
    (0, 1600, 40),
    (1600, 2000, 0),
    (1600, 2400, 0),
    (1600, 2800, 0),
)

NETWORK = "fast-scnn"
# Rows with the fine-tuned weights, and their methods.
TUNED_ROWS = {
    "tuned": NETWORK,
    "tuned mirrored": "fast-scnn-mirrored",
    "tuned hybrid": "hybrid",
}
# Options of `cmtof.network.tuning.fine_tune`, on scans and on rendered still lifes.
TUNING: Fields = {"steps": 600, "learning_rate": 5e-4, "crop": 192, "batch": 2}
LEARNING: Fields = TUNING | {"steps": 2500}

DEPTH_WEIGHT = 0.005  # weight of the distance in depth, 1/mm, as where the network was trained last

Weights = Callable[[], Path]  # finds the file, or trains it
Noise = str | float  # one of `cmtof_lab.settings.NOISE`, or a multiple of the captures'

# Phase noise over that of the captures, and its name.
LEVELS: dict[str, Noise] = {"0": "photon", "0.5": 0.5, "1": "captures", "2": 2.0}

STRIDES = (1, 2, 4)
SWEPT = ("bust", "owl")  # scenes of which fewer points and other noise are tried


def scan_object(name: str, noise: Noise, **view: Any) -> Measurement:
    """Scan of an object by name, as `scan_target` has it."""
    return scan_target(
        scene_from({"kind": "object", "name": name}),
        noise,
        field_of_view=FIELD_OF_VIEW[name],
        **view,
    )


def scan_target(
    target: Target, noise: Noise, *, size: int = SIZE, stray=False, **view: Any
) -> Measurement:
    """Scan of a target, its ranges optical, among the wraps 36 to 56 of the released protocol.

    The zero of the beat is that of a short scan at the photon limit. Without ``stray`` light: what
    comes back while a cap covers the beam is taken away.
    """
    noisy = TwinSettings(**noise_settings(noise))
    scan = scan_scene(noisy, target, size=size, **view)
    if not stray:
        scan = scan.without_stray_light(scan_scene(noisy, CAP, size=COVERED, **view))
    data = scan.dataset
    if noise != "photon":
        short = scan_scene(TwinSettings(), target, size=1, **view)
        data = data.assign(psi=short.dataset["psi"])
    return Measurement(data).between(*ENDS)


def noise_settings(noise: Noise) -> Fields:
    """Settings of the instrument for a noise by name, or a multiple of the captures'."""
    if isinstance(noise, str):
        return NOISE[noise]
    usual = NOISE["captures"]
    return {**usual, "phase_noise": tuple(np.multiply(noise, usual["phase_noise"]))}


def close_pair(scan: Measurement, other: Measurement) -> Measurement:
    """Measurement at two close frequencies, as `phasor` needs it: the single modes of two scans."""
    both = (scan, other)
    return Measurement.from_phase(
        [one.phase[0] for one in both],
        [one.frequencies[0] for one in both],
        amplitude=[one.amplitude[0] for one in both],
        depth=scan.depth,
        mask=scan.mask,
    ).between(*scan.range)


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


def load_or_make(name: str, made: Callable[[], Measurement]) -> Measurement:
    """Measurement of a file by name, which is computed if there is none."""
    path = FOLDER / f"{name}.nc"
    if not path.exists():
        made().save(path)
        gc.collect()  # cycles of meshes, which hold more memory than Python sees
        print("scanned", name, flush=True)
    return cmtof.open(path)


def kept_scan(
    name: str, noise: Noise, seed: int = 0, *, kind: str = "scan", **options: Any
) -> Measurement:
    """Scan by `scan_object` with options, kept in a file whose name has ``kind`` for options."""
    return load_or_make(
        f"{kind}_{name}_{noise}_{seed}",
        partial(scan_object, name, noise, seed=seed, **options),
    )


def examples(numbers: Iterable[int], group: int = 0) -> Iterator[Any]:
    """Still lifes of a group, scanned or rendered, their wraps, -1 where unknown, and depth, m.

    They come one by one, so that only what is learnt from them is held.
    """
    for number in numbers:
        make = (
            partial(rendered_still, number, SIZE)
            if group == RENDERED
            else partial(labelled_scan, number, group)
        )
        scan = load_or_make(f"still_{group}_{number}", make)
        yield scan, *(scan.dataset[key].to_numpy() for key in ("wraps", "labels"))


def labelled_scan(number: int, group: int) -> Measurement:
    """Scan of a still life of a group of things, with the captures' noise and labels by stereo."""
    from cmtof_lab import stereo

    rng = np.random.default_rng([number, group])
    things = rng.permutation((LEARNT, HELD_OUT)[group])
    things = [OBJECTS[name]["pieces"] for name in things[: 1 + number % 3]]
    mesh, view = still_life(things, rng)
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
    path = weights_path(NETWORK, "released", FOLDER / f"tuned_{scans}_1")
    return trained_leg(path, best_weights(0), examples(range(scans)), seed=1, **TUNING)


def best_weights(legs: int = len(LEGS)) -> Path:
    """File of the weights after the first ``legs`` of `LEGS`; for 0, of those trained on rooms.

    On scans alone a network forgets the still lifes. So a leg with scans has both, and what is kept
    is the mean of the weights before and after it; for the mean see Wortsman et al. (CVPR 2022).
    """
    if not legs:
        return weights_path(NETWORK, "released")
    folder = FOLDER / f"leg_{legs}"
    path = weights_path(NETWORK, "released", TUNED if legs == len(LEGS) else folder)
    if path.exists():
        return path

    from cmtof.network.training import average_into
    from cmtof.network.weights import load_weights, save_weights

    first, last, scans = LEGS[legs - 1]
    trained = folder / "trained.safetensors"
    start = best_weights(legs - 1)
    among = examples([*range(scans)] * 10)  # ten times, or stills would outnumber them
    both = chain(examples(range(first, last), RENDERED), among)
    # a number of its own, though a leg with scans learns the still lifes of the one before
    trained_leg(trained, start, both, seed=last // 400 + (scans > 0), **LEARNING)
    mean, card = load_weights(trained)
    if scans:
        average_into(mean, load_weights(start).network, step=9, most=0.5)
    save_weights(path, mean, card)
    return path


def trained_leg(
    path: Path,
    start: Path,
    learnt: Iterable[Any],
    **options: Any,
) -> Path:
    """File of weights, which are trained on examples, starting from others, unless it is there.

    Options are those of `cmtof.network.tuning.fine_tune`. The learning rate falls to zero; in half
    precision where the processor can.
    """
    import torch

    from cmtof.network.training import multiplies_bfloat16
    from cmtof.network.tuning import fine_tune
    from cmtof.network.weights import load_weights, save_weights

    if not path.exists():
        trained = load_weights(start)
        model = trained.network.model
        trained.network.model = model._replace(depth_weight=DEPTH_WEIGHT)
        torch.set_num_threads(1)
        half = multiplies_bfloat16()
        # without a cache, which would keep the first step's weights for the whole block
        with torch.autocast("cpu", torch.bfloat16, half, cache_enabled=False):
            tuned, losses = fine_tune(trained, learnt, **options)
        path.parent.mkdir(exist_ok=True)
        save_weights(path, tuned.network, tuned.card)
        print(path.parent.name, np.mean(losses[-50:]), flush=True)
    return path


def wraps_off(
    scans: Iterable[Measurement], method: str, trained: Weights | None = None
) -> list:
    """Of each scan: scored pixels, and how many are off by fewer wraps than 1, 2, 3 and 10.

    ``trained`` finds or trains weights of the method, if it has others than the shipped ones.
    """
    options = {"weights": trained()} if trained else {}
    return [
        [one["pixels"], *one["below"]]
        for one in counts_of(scans, method=method, **options)
    ]


def scan_for_row(row: str, name: str, noise: Noise, seed: int) -> Measurement:
    """Scan as a row reads it: four phases for `rapid`, two close frequencies for `phasor`."""
    if row.startswith("stray"):
        return kept_scan(name, noise, seed, kind="stray", stray=True)
    scan = kept_scan(name, noise, seed)
    if row == "rapid":
        return four_phases(scan)
    if row == "phasor":
        return close_pair(
            scan,
            kept_scan(name, noise, seed + 100, kind="close", frequency_single=7.16e9),
        )
    return scan


def validation_rates(legs: int) -> list[float]:
    """Share of right wraps, after ``legs`` of `LEGS`, on each scan of the things held out."""
    scans = (scan for scan, *_ in examples(range(VALIDATED), 1))
    return [
        round(right / pixels, 4)
        for pixels, right, *_ in wraps_off(scans, NETWORK, partial(best_weights, legs))
    ]


def compare(counts: Counts, noise: str, rows: Named) -> None:
    """Count right wraps by each row's method and weights, on three scans of each shown scene."""
    for (name, row), scene in product(rows.items(), SHOWN):
        given = (scan_for_row(name, scene, noise, seed) for seed in SEEDS)
        counts.keep("counts", noise, name, scene, of=partial(wraps_off, given, *row))


def sweep(counts: Counts, rows: Named) -> None:
    """Count right wraps at each noise of `LEVELS`, with all, each second and each fourth point."""
    for level, stride, (name, row) in product(LEVELS, STRIDES, rows.items()):
        scans = (kept_scan(scene, LEVELS[level]).dataset for scene in SWEPT)
        thin = (one.thin(x=stride, y=stride).drop_vars("camera") for one in scans)
        counts.keep(
            "sweep",
            level,
            str(SIZE // stride),
            name,
            of=partial(wraps_off, map(Measurement, thin), *row),
        )


def main() -> None:
    """Compute what is missing, and store it."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    counts = Counts(RESULTS / "scanned.json")
    for legs in range(len(LEGS) + 1):
        counts.keep("validation", f"{legs} legs", of=partial(validation_rates, legs))
    counts.store(
        command="python -m cmtof_book.scanned",
        version=__version__,
        settings={"size": SIZE, "seeds": SEEDS, "baseline": BASELINE},
        legs=LEGS,
        training=[TUNING, LEARNING],
        weights=read_card(best_weights()).sha256,
    )
    rows: Fields = {name: (name,) for name in (*METHODS, *TOLD)}
    phasor = rows.pop("phasor")
    rows |= {name: (method, best_weights) for name, method in TUNED_ROWS.items()}
    compare(counts, "photon", rows | {f"stray {name}": (name,) for name in STRAY})
    swept = {name: rows[name] for name in ("kde", *TOLD)}
    sweep(counts, {NETWORK: rows["tuned"]} | swept)
    rows |= {"phasor": phasor, "rendered": (NETWORK, partial(best_weights, 4))}
    rows |= {f"{n} scans": (NETWORK, partial(tuned_weights, n)) for n in CURVE}
    compare(counts, "captures", rows)


if __name__ == "__main__":
    main()
