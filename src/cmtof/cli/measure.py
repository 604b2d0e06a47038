"""Frames to measurements to depth: simulate, unwrap, evaluate."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from cmtof.cli.app import app
from cmtof.cli.options import (
    Frequencies,
    Noise,
    NoiseFree,
    Output,
    ProtocolName,
    Quiet,
    Seed,
    tones,
)
from cmtof.console import print_report, print_scores, progress_bar, write_json

if TYPE_CHECKING:
    import xarray as xr

    from cmtof.measurement import Measurement
    from cmtof.simulation import Protocol


@app.command()
def simulate(
    frame: Annotated[
        str,
        typer.Argument(
            help="Frame .npz, depth .png, Hypersim depth .hdf5, a folder of frames (its first is "
            "taken), or an embedded one (see `cmtof info`)."
        ),
    ],
    output: Output,
    protocol: ProtocolName = "released",
    frequencies: Frequencies = "7.15e9,14.32e9",
    noise: Noise = 1200.0,
    noise_free: NoiseFree = False,
    seed: Seed = 0,
    intensity: Annotated[
        Path | None, typer.Option(help="Colour or grey PNG that belongs to a depth PNG.")
    ] = None,
    depth_scale: Annotated[float, typer.Option(help="Depth PNG: levels per metre.")] = 1000.0,
    planar: Annotated[
        bool, typer.Option("--planar", help="Depth PNG holds distance along the optical axis.")
    ] = False,
    camera: Annotated[
        tuple[float, float, float, float] | None, typer.Option(help="fx fy cx cy in pixels.")
    ] = None,
) -> None:
    """Turn an RGB-D frame into correlation images.

    Example: [bold]cmtof simulate still_life -o m.nc --protocol full --seed 3[/bold]
    """
    from cmtof.scenes import load_frame
    from cmtof.simulation import simulate as simulate_frame

    loaded = load_frame(
        frame,
        intensity=intensity,
        depth_scale=depth_scale,
        planar=planar,
        camera=camera,
    )
    measurement = simulate_frame(
        loaded,
        protocol=cast("Protocol", protocol),
        frequencies=tones(frequencies),
        noise=noise,
        noise_free=noise_free,
        seed=seed,
    )
    measurement.save(output)
    print(f"{output}: {measurement}, {measurement.mask.mean():.1%} of pixels scored")
    if loaded.note:
        print(f"{loaded.name}: {loaded.note}")


@app.command()
def unwrap(
    measurement: Annotated[Path, typer.Argument(help="Measurement .nc, .npz or *_phase.csv.")],
    output: Output,
    method: Annotated[
        str | None,
        typer.Option(help="Name out of `cmtof methods`, which marks the one taken by default."),
    ] = None,
    range: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="MIN MAX", help="Depths to choose from in m, MIN <= z < MAX."),
    ] = None,
    window: Annotated[
        int | None, typer.Option(help="Side of the averaging window in px (method beat).")
    ] = None,
    weights: Annotated[
        Path | None, typer.Option(help="Own trained .safetensors (learned methods).")
    ] = None,
    ply: Annotated[
        Path | None, typer.Option(help="Also write a point cloud; the file needs a camera.")
    ] = None,
) -> None:
    """Turn correlation images into wrap count, depth and confidence.

    Prints how many wraps are right when the file holds the truth.

    Example: [bold]cmtof unwrap m.nc -o out.nc --ply cloud.ply[/bold]
    """
    from cmtof.methods import DEFAULT
    from cmtof.measurement import open_measurement, save_dataset
    from cmtof.unwrapping import unwrap as unwrap_measurement

    opened = open_measurement(measurement)
    if ply is not None and opened.camera is None:
        raise ValueError(
            f"Expected a camera in {measurement} for --ply, got none. Leave --ply out or add it."
        )
    given: dict[str, Any] = {"window": window, "weights": weights}
    options = {name: value for name, value in given.items() if value is not None}
    chosen = method or DEFAULT
    result = unwrap_measurement(opened, method=chosen, range=range, **options)
    save_dataset(result, output)
    print(f"{output}: method {chosen}, {int(opened.mask.sum())} of {opened.mask.size} pixels")
    if ply is not None:
        print(f"{ply}: {_write_cloud(ply, result, opened)} points")
    if opened.depth is not None:
        print_scores(result, opened)


def _write_cloud(path: Path, result: "xr.Dataset", measurement: "Measurement") -> int:
    from cmtof.pointcloud import write_ply

    assert measurement.camera is not None  # unwrap has made sure
    return write_ply(
        path,
        result["depth"].to_numpy(),
        measurement.camera,
        brightness=measurement.amplitude[0],
        confidence=result["confidence"].to_numpy(),
    )


@app.command()
def evaluate(
    frames: Annotated[
        list[str],
        typer.Argument(
            help="Frames: files, embedded names, or folders (TUM, NYU and ScanNet style, .npz, "
            "Hypersim trees: their test frames)."
        ),
    ],
    method: Annotated[
        str,
        typer.Option(help="Names out of `cmtof methods`, parted by commas, or all that are ready."),
    ] = "all",
    protocol: ProtocolName = "released",
    noise: Noise = 1200.0,
    noise_free: NoiseFree = False,
    seed: Seed = 0,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write the table as JSON.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Compare methods on the same frames and the same noise.

    Example: [bold]cmtof evaluate still_life room --method crt,beat --json scores.json[/bold]
    """
    from cmtof.evaluation import Evaluation
    from cmtof.methods import find_method, names_of

    names = names_of(method, protocol)
    evaluation = Evaluation(
        names, protocol=cast("Protocol", protocol), noise=noise, noise_free=noise_free, seed=seed
    )
    skipped = _run(evaluation, frames, quiet)
    report = evaluation.report()
    if json_file is not None:
        write_json(json_file, report)
    print_report(report)
    for name in names:
        if tones_of := find_method(name).tones:
            print(f"{name}: measured at {' and '.join(f'{f / 1e9:g}' for f in tones_of)} GHz")
    for name, reason in skipped.items():
        print(f"skipped {name}: {reason}")


def _run(evaluation: Any, frames: list[str], quiet: bool) -> dict[str, str]:
    """Add every frame behind a progress bar.

    A frame that was named itself must load; of a folder those that do not are returned with the
    reason.
    """
    from cmtof.scenes.folders import frames_in
    from cmtof.scenes.frame import Frames

    listed = [frames_in(name) for name in frames]
    skipped: dict[str, str] = {}
    with progress_bar(quiet) as bar:
        task = bar.add_task("", total=sum(map(len, listed)) * len(evaluation.methods))
        for name, sources in zip(frames, listed, strict=True):
            several = Frames(sources)
            for frame in several if Path(name).is_dir() else (one.load() for one in sources):
                for done in evaluation.add(frame):
                    bar.update(task, advance=1, description=f"{frame.name}: {done}")
            skipped |= several.skipped
    return skipped
