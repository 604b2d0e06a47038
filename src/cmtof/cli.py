"""The command line: simulate, unwrap, evaluate, methods, render, replicate, info.

Exit codes: 0; 1 for bad input, a failed check or a failed frame (one line on stderr); 2 for a
wrong command line; 130 for Ctrl-C.
"""

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from cmtof.console import (
    describe,
    print_render_costs,
    print_report,
    print_scores,
    progress_bar,
    write_json,
)

if TYPE_CHECKING:
    import xarray as xr

    from cmtof.measurement import Measurement
    from cmtof.simulation import Protocol

app = typer.Typer(
    name="cmtof",
    help="Centimetre-wave time-of-flight: from scenes and measurements to depth.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; bad input becomes one line on stderr and exit code 1."""
    try:
        app(args=arguments)
    except (ValueError, OSError) as error:
        message = " ".join(str(error).split())
        if isinstance(error, OSError) and error.filename and error.strerror:
            message = (
                f"Expected to read or write {error.filename}, got «{error.strerror}». "
                "Check path and permissions."
            )
        print(f"cmtof: {message}", file=sys.stderr)
        sys.exit(1)


# --- options that several commands share -------------------------------------------------------

Output = Annotated[Path, typer.Option("--output", "-o", help="File to write, [bold]*.nc[/bold].")]
ProtocolName = Annotated[
    str,
    typer.Option(
        "--protocol",
        help="[bold]released[/bold]: scene shrunk to 1.195 m, 21 wraps, as the authors' code does. "
        "[bold]full[/bold]: nothing scaled, every wrap of the 7.5 m range.",
    ),
]
Frequencies = Annotated[
    str, typer.Option(help="Modulation frequencies in Hz, lowest first, parted by commas.")
]
Noise = Annotated[
    float, typer.Option(help="Gaussian noise sigma in counts; photon noise stays on.")
]
NoiseFree = Annotated[bool, typer.Option("--noise-free", help="No noise of either kind.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the noise.")]
Smooth = Annotated[
    bool, typer.Option("--smooth", help="Smooth Hypersim's 16-bit depth within its own steps.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]


def _tones(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError as error:
        raise ValueError(
            f"Expected frequencies in Hz parted by commas, got {text}. Try 7.15e9,14.32e9."
        ) from error


# --- commands ----------------------------------------------------------------------------------


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
    depth_scale: Annotated[
        float | None,
        typer.Option(
            help="Depth PNG: levels per metre. Default: 1000, or what the folder's style has."
        ),
    ] = None,
    planar: Annotated[
        bool, typer.Option("--planar", help="Depth PNG holds distance along the optical axis.")
    ] = False,
    camera: Annotated[
        tuple[float, float, float, float] | None, typer.Option(help="fx fy cx cy in pixels.")
    ] = None,
    smooth: Smooth = False,
) -> None:
    """Turn an RGB-D frame into correlation images.

    Example: [bold]cmtof simulate still_life -o m.nc --protocol full --seed 3[/bold]
    """
    from cmtof.scenes.rgbd import load_frame
    from cmtof.simulation import simulate as simulate_frame

    loaded = load_frame(
        frame,
        intensity=intensity,
        depth_scale=depth_scale,
        planar=planar,
        camera=camera,
        smooth=smooth,
    )
    measurement = simulate_frame(
        loaded,
        protocol=cast("Protocol", protocol),
        frequencies=_tones(frequencies),
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
    method: Annotated[str, typer.Option(help="Name out of `cmtof methods`.")] = "beat",
    range: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="MIN MAX", help="Depths to choose from in m, MIN <= z < MAX."),
    ] = None,
    window: Annotated[
        int | None, typer.Option(help="Side of the averaging window in px (method beat).")
    ] = None,
    ply: Annotated[
        Path | None, typer.Option(help="Also write a point cloud; the file needs a camera.")
    ] = None,
) -> None:
    """Turn correlation images into wrap count, depth and confidence.

    Prints how many wraps are right when the file holds the truth.

    Example: [bold]cmtof unwrap m.nc -o out.nc --method beat --ply cloud.ply[/bold]
    """
    from cmtof.measurement import open_measurement, save_dataset
    from cmtof.unwrapping import unwrap as unwrap_measurement

    opened = open_measurement(measurement)
    if ply is not None and opened.camera is None:
        raise ValueError(
            f"Expected a camera in {measurement} for --ply, got none. Leave --ply out or add it."
        )
    options = {} if window is None else {"window": window}
    result = unwrap_measurement(opened, method=method, range=range, **options)
    save_dataset(result, output)
    print(f"{output}: method {method}, {int(opened.mask.sum())} of {opened.mask.size} pixels")
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
        str, typer.Option(help="Names out of `cmtof methods`, parted by commas, or all.")
    ] = "all",
    protocol: ProtocolName = "released",
    noise: Noise = 1200.0,
    noise_free: NoiseFree = False,
    seed: Seed = 0,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write the table as JSON.")
    ] = None,
    smooth: Smooth = False,
    quiet: Quiet = False,
) -> None:
    """Compare methods on the same frames and the same noise.

    Example: [bold]cmtof evaluate still_life room --method crt,beat --json scores.json[/bold]
    """
    from cmtof.baselines import METHODS
    from cmtof.evaluation import Evaluation

    names = list(METHODS) if method == "all" else [name.strip() for name in method.split(",")]
    evaluation = Evaluation(
        names, protocol=cast("Protocol", protocol), noise=noise, noise_free=noise_free, seed=seed
    )
    skipped = _run(evaluation, frames, smooth, quiet)
    report = evaluation.report()
    if json_file is not None:
        write_json(json_file, report)
    print_report(report)
    for name, reason in skipped.items():
        print(f"skipped {name}: {reason}")


def _run(evaluation: Any, frames: list[str], smooth: bool, quiet: bool) -> dict[str, str]:
    """Add every frame behind a progress bar.

    A frame that was named itself must load; of a folder those that do not are returned with the
    reason.
    """
    from cmtof.scenes.folders import frames_in
    from cmtof.scenes.sources import Frames

    listed = [frames_in(name, smooth=smooth) for name in frames]
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


@app.command()
def methods(
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List every unwrapping method with its kind, source and whether its weights are there."""
    from dataclasses import asdict

    from cmtof.baselines import DEFAULT, METHODS

    if as_json:
        listed = [
            {key: value for key, value in asdict(entry).items() if key != "where"}
            | {"weights": None, "default": entry.name == DEFAULT}
            for entry in METHODS.values()
        ]
        print(json.dumps(listed, indent=2, ensure_ascii=False))
        return
    from rich.console import Console
    from rich.table import Table

    table = Table()
    table.add_column("method", no_wrap=True)
    for heading in ("kind", "tones", "weights", "what it does", "source"):
        table.add_column(heading)
    for entry in METHODS.values():
        name = f"{entry.name} *" if entry.name == DEFAULT else entry.name
        row = (name, entry.kind, str(entry.frequencies), "none", entry.summary, entry.source)
        table.add_row(*row)
    Console().print(table)
    print("* the default; tones: frequencies needed; weights none: nothing was learned")


@app.command()
def info(
    file: Annotated[Path | None, typer.Argument(help="Measurement, result or frame.")] = None,
) -> None:
    """Print version, devices and embedded frames, or what a file holds."""
    if file is not None:
        describe(file)
        return
    from importlib.util import find_spec

    from cmtof import __version__
    from cmtof.scenes.captures import data_root
    from cmtof.scenes.rgbd import embedded_frames

    print(f"cmtof {__version__}, Python {sys.version.split()[0]}, {os.cpu_count()} processors")
    if find_spec("torch"):
        import torch

        gpus = [torch.cuda.get_device_name(i) for i in range(torch.cuda.device_count())]
        print(f"torch {torch.__version__}, {', '.join(gpus) if gpus else 'no GPU'}")
    else:
        print("torch is not installed (only learned methods need it)")
    print(f"embedded frames: {', '.join(embedded_frames())}")
    print(f"published captures: {data_root() or 'not on this machine'}")


@app.command()
def render(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write the set into.")],
    scenes: Annotated[int, typer.Option(min=1, help="How many rooms.")] = 20,
    views: Annotated[int, typer.Option(min=1, help="Views of each; a third are close-ups.")] = 5,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the set.")] = 0,
    size: Annotated[str, typer.Option(help="Height x width, px.")] = "512x512",
    focal: Annotated[
        float | None,
        typer.Option(help="Focal length, px. Default: each scene has its own, 35 to 60° across."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes. Default: one a core.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Render furnished rooms, in Hypersim's layout.

    The same seed gives the same bytes. A run that was stopped goes on where it was, and a set may
    grow: ask for more scenes or views in the same folder. Needs the extra [bold]rooms[/bold].

    Example: [bold]cmtof render --scenes 20 --views 5 --seed 1 -o rooms[/bold]
    """
    from time import perf_counter

    from cmtof.scenes.rooms.rendering import Settings, render_rooms, shape_from_text

    height, width = shape_from_text(size)
    settings = Settings(seed, scenes, views, height, width, focal)
    start = perf_counter()
    with progress_bar(quiet) as bar:
        task = bar.add_task("rooms", total=scenes)
        done = render_rooms(
            output,
            settings,
            workers=workers,
            progress=lambda one: bar.update(task, advance=1, description=one.scene),
        )
    seconds = perf_counter() - start
    rendered = sum(one.rendered for one in done)
    print(f"{output}: {scenes} rooms, {views} views each; {rendered} views rendered", end="")
    if not rendered:
        print(", the others were there")
        return
    print(f" in {seconds:.1f} s, {rendered / seconds:.2f} views/s")
    print_render_costs(done)


@app.command()
def replicate(
    output: Annotated[Path, typer.Option("--output", "-o", help="Where to draw Fig. 3.")] = Path(
        "fig03_precision.png"
    ),
) -> None:
    """Draw Fig. 3 anew and hold the chain from frame to depth against stored values.

    Ends with 1 if a line says FAIL. No arguments, under a minute on a CPU.
    """
    from cmtof.replication import replicate as outcomes

    failed = 0
    for outcome in outcomes(output):
        print(outcome, flush=True)
        failed += not outcome.passed
    print(f"{output}: Fig. 3, drawn on this machine")
    if failed:
        raise ValueError(f"Expected every line to pass, got {failed} FAIL. Compare versions.")


if __name__ == "__main__":
    main()
