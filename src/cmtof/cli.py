"""The command line: from frames and measurements to depth, and from an instrument to a measurement.

Exit codes: 0; 1 for bad input, a failed check or a failed frame (one line on stderr); 2 for a
wrong command line; 130 for Ctrl-C.
"""

import json
import os
import signal
import sys
import warnings
from collections.abc import Callable, Mapping
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option, Typer

from cmtof.files import check_output
from cmtof.terminal import hidden, later, prepare_streams, print_table, progress, shown

app = Typer(
    name="cmtof",
    help="Centimetre-wave time-of-flight: from scenes and measurements to depth. With --debug an "
    "error shows its traceback.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)

MODULES = {
    "hardware": "pyvisa serial thorlabs_apt_protocol",
    "lab": "cv2",
    "networks": "onnxruntime safetensors",
    "plot": "cycler matplotlib",
    "rooms": "embreex trimesh",
    "train": "lightning torch",
    "view": "IPython pyvista",
}
# Extra of each module that comes with none of the package's own dependencies.
EXTRAS = {
    module: extra for extra, modules in MODULES.items() for module in modules.split()
}


File = Path | None
PICTURES = (".png", ".pdf", ".svg", ".jpg")


def _file(named: str, *flags: str, text: str) -> Any:
    """Option of a file to write, which is checked before anything is computed for it."""

    def check(path: File) -> File:
        free = (
            named != ".nc" and path and not path.exists()
        )  # what is replaced must be alike
        return path and check_output(path, *[] if free else [named]) and path

    return Option(*flags, help=text, callback=check)


Output = Annotated[
    Path, _file(".nc", "--output", "-o", text="File to write, [bold]*.nc[/bold].")
]
Protocol = Annotated[
    str,
    Option(
        help="released: scene shrunk to 1.195 m, 21 wraps; full: all of the 7.5 m range."
    ),
]
Noise = Annotated[float, Option(help="Gaussian noise, counts; photon noise stays on.")]
NoiseFree = Annotated[bool, Option("--noise-free", help="No noise of either kind.")]
_SEED = Option(min=0, max=2**63 - 1, help="Seed of the random numbers.")
Seed = Annotated[int, _SEED]
Intensity = Annotated[File, Option(help="Image of the light of a depth image.")]
DepthScale = Annotated[
    float | None,
    Option(help="Depth image: levels per metre. Default: 1000, of TUM 5000."),
]
Planar = Annotated[bool, Option("--planar", help="Depth image is along the axis.")]
Camera = Annotated[
    tuple[float, float, float, float] | None, Option(help="fx fy cx cy in pixels.")
]
Linear = Annotated[
    bool, Option("--linear", help="Light of a depth image is linear, no sRGB.")
]
Quiet = Annotated[bool, Option("--quiet", "-q", help="No progress bar.")]


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; an error becomes one line on stderr and exit code 1."""
    prepare_streams()
    for name in (
        "SIGTERM",
        "SIGHUP",
        "SIGQUIT",
    ):  # an exit by exception removes unfinished files
        if hasattr(signal, name):
            signal.signal(
                getattr(signal, name), lambda number, _: sys.exit(128 + number)
            )
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        with warnings.catch_warnings():
            # the libraries' own are for their developers; ours are one line
            warnings.simplefilter("ignore")
            warnings.filterwarnings(
                "always", ".* is (untrained|left out)|.*NUMBA_CACHE_DIR", UserWarning
            )
            warnings.showwarning = lambda text, *_: print(
                f"cmtof: {text}", file=sys.stderr
            )
            app(args=[word for word in words if word != "--debug"])
    except Exception as error:
        if "--debug" in words:
            raise
        print(f"cmtof: {shown(_line(error))}", file=sys.stderr)
        sys.exit(1)


def _line(error: Exception) -> str:
    """One line for an error: bad input as it says itself, anything else as a defect."""
    if isinstance(error, OSError) and error.strerror:
        return (
            f"Expected to read or write {error.filename or 'a file'}, got «{error.strerror}». "
            "Check disk, path and permissions."
        )
    if isinstance(error, ModuleNotFoundError) and (
        extra := EXTRAS.get(f"{error.name}")
    ):
        return f"Expected {error.name}, got none. Install it: pip install 'cmtof[{extra}]'."
    text = " ".join(str(error).split())
    if isinstance(error, ImportError) or text.startswith("Expected"):
        return text
    if isinstance(error, MemoryError):
        return f"Expected enough memory, got none left. Take a smaller input. {text}".strip()
    return (
        f"{type(error).__name__}: {text} (a defect, please report; --debug shows where)"
    )


@app.command()
def simulate(
    frame: Annotated[
        str,
        Argument(
            help=".npz, depth .png, Hypersim .hdf5, folder (its first), or embedded."
        ),
    ],
    output: Output,
    protocol: Protocol = "released",
    frequencies: Annotated[
        str,
        Option(help="Modulation frequencies in Hz, lowest first, separated by commas."),
    ] = "7.15e9,14.32e9",
    noise: Noise = 1200.0,
    noise_free: NoiseFree = False,
    seed: Seed = 0,
    intensity: Intensity = None,
    depth_scale: DepthScale = None,
    planar: Planar = False,
    camera: Camera = None,
    linear: Linear = False,
) -> None:
    """Turn an RGB-D frame into correlation images. `cmtof info` lists the embedded ones.

    Example: [bold]cmtof simulate still_life -o m.nc --protocol full --seed 3[/bold]
    """
    from cmtof.scenes import load_frame
    from cmtof.simulation import simulate as simulate_frame
    from cmtof.validation import checked

    tones = checked(list[float], frequencies.split(","), "--frequencies HZ,HZ")
    loaded = load_frame(
        frame,
        intensity=intensity,
        depth_scale=depth_scale,
        planar=planar,
        camera=camera,
        linear=linear,
    )
    measurement = simulate_frame(
        loaded,
        frequencies=tones,
        protocol=protocol,  # type: ignore[arg-type]
        noise=noise,
        noise_free=noise_free,
        seed=seed,
    )
    measurement.save(output)
    print(f"{output}: {measurement}, {measurement.mask.mean():.1%} of pixels scored")
    if loaded.note:
        print(shown(f"{loaded.name}: {loaded.note}"))


@app.command()
def unwrap(
    measurement: Annotated[
        list[Path], Argument(help="Measurements .nc, .npz or *_phase.csv.")
    ],
    output: Annotated[
        Path, Option("--output", "-o", help="File, *.nc; a folder for several.")
    ],
    method: Annotated[str, Option(help="Name out of `cmtof methods`.")] = "surfaces",
    range: Annotated[
        tuple[float, float] | None,
        Option(metavar="MIN MAX", help="Depths, m: MIN <= z < MAX."),
    ] = None,
    min_confidence: Annotated[
        float, Option(help="Mask pixels below it, from 0 to 1.")
    ] = 0.0,
    window: Annotated[
        int | None, Option(help="Side of the window, px (method beat).")
    ] = None,
    weights: Annotated[File, Option(help="Own .safetensors (learned methods).")] = None,
    ply: Annotated[File, _file(".ply", "--ply", text="Point cloud (camera).")] = None,
    tile: Annotated[
        int, Option(min=0, help="Side of tiles, px, of a .nc above memory.")
    ] = 0,
    quiet: Quiet = False,
) -> None:
    """Turn correlation images into wrap count, depth and confidence.

    Prints how many wraps are right when the file holds the truth.

    Example: [bold]cmtof unwrap m.nc -o out.nc --ply cloud.ply[/bold]
    """
    several = len(measurement) > 1
    targets = (
        [output / f"{path.stem}.nc" for path in measurement] if several else [output]
    )
    _check_distinct([*measurement, *targets, *([ply] if ply else [])])
    one = not (tile or several)
    if ply is not None and not one:
        raise ValueError(
            "Expected one file, seen at once, for --ply, got more. Leave --ply out."
        )
    given = {
        "method": method,
        "range": range,
        "min_confidence": min_confidence,
        "window": window,
        "weights": weights,
        "tile": tile,
    }
    how = {name: value for name, value in given.items() if value is not None}
    if several:
        output.mkdir(exist_ok=True)
    for target in targets:
        check_output(target, ".nc")
    with progress(len(targets), quiet or one) as advance:
        pairs = zip(measurement, targets, strict=True)
        rows = [_unwrapped(*pair, ply, how, advance) for pair in pairs]
    head = dict.fromkeys(title for _, rates in rows for title in rates)
    cells = (
        [*names, *(rates.get(title, "") for title in head)] for names, rates in rows
    )
    print_table(f"method {method}, into {output}", ("file", "valid", *head), cells)


def _check_distinct(paths: list[Path]) -> None:
    """Raise a ValueError if two of inputs and outputs are one file."""
    real = {os.path.realpath(path) for path in paths}  # of a circle of links, too
    if len(real) < len(paths):
        raise ValueError(
            f"Expected another file for each of inputs and outputs, got {paths[0].name} twice. "
            "Name another."
        )


def _unwrapped(
    path: Path,
    target: Path,
    ply: Path | None,
    how: dict[str, Any],
    advance: Callable[..., None],
) -> tuple[list[str], dict[str, str]]:
    """Unwrap a file; return its name and share of valid pixels, and its rates by their titles."""
    from cmtof.evaluation import Tally, scored_pixels
    from cmtof.pointcloud import write_ply
    from cmtof.unwrapping import unwrap_file

    tally = Tally()
    valid = 0
    size = 0
    for share, opened, result in unwrap_file(path, target, **how):
        kept = int(result.depth.notnull().sum())
        valid += kept
        size += opened.mask.size
        if opened.depth is not None and kept:
            tally.add(scored_pixels(result, opened))
        if ply is not None:
            points = write_ply(
                ply,
                result["depth"].to_numpy(),
                opened.camera,
                brightness=opened.amplitude[0],
                confidence=result["confidence"].to_numpy(),
            )
            print(f"{ply}: {points} points")
        advance(path.name, share)
    return [path.name, f"{valid / size:.1%}"], _rates(
        tally.score()
    ) if tally.frames else {}


@app.command()
def evaluate(
    frames: Annotated[
        list[str],
        Argument(
            help="Files, embedded names, folders (pairs of images, .npz, Hypersim's tests)"
        ),
    ],
    method: Annotated[
        str, Option(help="Out of `cmtof methods`, with commas, or all.")
    ] = "all",
    protocol: Protocol = "released",
    noise: Noise = 1200.0,
    noise_free: NoiseFree = False,
    seed: Seed = 0,
    json_file: Annotated[File, _file(".json", "--json", text="Table as JSON.")] = None,
    intensity: Intensity = None,
    depth_scale: DepthScale = None,
    planar: Planar = False,
    camera: Camera = None,
    linear: Linear = False,
    quiet: Quiet = False,
) -> None:
    """Compare methods on the same frames and the same noise.

    Example: [bold]cmtof evaluate still_life room --method crt,beat --json scores.json[/bold]
    """
    from cmtof.evaluation import Evaluation
    from cmtof.files import written_whole
    from cmtof.frame import Frames
    from cmtof.methods import names_of
    from cmtof.scenes import frames_in

    names = names_of(method, protocol)
    image = {
        "intensity": intensity,
        "depth_scale": depth_scale,
        "planar": planar,
        "camera": camera,
        "linear": linear,
    }
    sets = [Frames(frames_in(name, **image)) for name in frames]
    evaluation = Evaluation(
        names, protocol=protocol, noise=noise, noise_free=noise_free, seed=seed
    )
    with progress(sum(len(one.sources) for one in sets) * len(names), quiet) as advance:
        for one in sets:
            for frame in one:
                try:
                    for done in evaluation.add(frame):
                        advance(f"{frame.name}: {done}")
                except ValueError as error:
                    one.skipped[frame.name] = str(error)
            evaluation.notes |= {
                f"skipped {name}": why for name, why in one.skipped.items()
            }
    if evaluation.frames:
        report = evaluation.report()
        if json_file is not None:
            with written_whole(json_file) as part:
                part.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
        _print_report(report)
    for one in sets:
        if len(one.skipped) == len(
            one.sources
        ):  # what was named must hold a frame that loads
            raise ValueError(next(iter(one.skipped.values())))
    _name_missing(evaluation.missing)
    if evaluation.missing and method != "all":
        sys.exit(1)


def _name_missing(missing: Mapping[str, ModuleNotFoundError]) -> None:
    """Say in one line for each package which methods need it."""
    users: dict[str, list[str]] = {}
    for name, error in missing.items():
        users.setdefault(_line(error), []).append(name)
    for line, names in users.items():
        print(shown(f"cmtof: left out {', '.join(names)}. {line}"), file=sys.stderr)


@app.command()
def methods(
    as_json: Annotated[bool, Option("--json", help="Print JSON.")] = False,
) -> None:
    """List every unwrapping method with its kind, source and state."""
    from cmtof.methods import DEFAULT, METHODS

    keys = ("kind", "source", "summary", "frequencies", "tones", "knows_truth")
    rows = [
        {"name": name, "state": entry.state(), "default": name == DEFAULT}
        | {key: getattr(entry, key) for key in keys}
        for name, entry in METHODS.items()
    ]
    if as_json:
        print(json.dumps(rows, indent=2, ensure_ascii=False))
        return
    head = ("name", "kind", "state", "summary", "source")
    print_table("", head, ([row[key] for key in head] for row in rows))
    print(f"Default: {DEFAULT}. State: of weights for the released protocol.")


@app.command()
def info(
    file: Annotated[File, Argument(help="Measurement, result or frame.")] = None,
) -> None:
    """Print versions and embedded frames, or what a file holds."""
    from importlib.metadata import version
    from importlib.util import find_spec

    from cmtof import __version__
    from cmtof.captures import data_root
    from cmtof.frame import embedded_frames, listed_npz
    from cmtof.measurement import open_measurement
    from cmtof.storage import opened_dataset

    if file is not None:
        path = embedded_frames().get(str(file), file)
        if path.suffix == ".npz":
            lines = [f"{name} {kind}" for name, kind in listed_npz(path).items()]
            print(shown("\n".join(lines)))
            return
        text = StringIO()
        if path.suffix == ".nc":
            with opened_dataset(path) as held:
                held.info(text)
                if "component_odds" in held:
                    odds = (
                        held["component_odds"].sel(offset=slice(-2, 2))[:10].to_pandas()
                    )
                    print(
                        "Odds of the largest components to lie so many wraps farther:"
                    )
                    print(odds.round(3))
        else:
            open_measurement(path).dataset.info(text)
        print(shown(text.getvalue()))
        return
    print(
        f"cmtof {__version__}, Python {sys.version.split()[0]}, {os.cpu_count()} processors"
    )
    for name, needed in (
        ("onnxruntime", "learned methods need"),
        ("torch", "training needs"),
    ):
        print(
            name,
            version(name)
            if find_spec(name)
            else f"is not installed (only {needed} it)",
        )
    print(f"embedded frames: {', '.join(embedded_frames())}")
    print(f"published captures: {data_root() or 'not on this machine'}")


@app.command()
def replicate(
    output: Annotated[
        Path, Option("--output", "-o", help="Where to draw Fig. 10.")
    ] = Path("build/replicate/fig10_comparison.png"),
) -> None:
    """Draw Fig. 10, and check the chain from frame to depth against stored values.

    Methods side by side on the embedded frames, in a few minutes. Ends with 1 if a line says FAIL.
    """
    from cmtof_book.replication import replicate as outcomes

    if output.suffix not in PICTURES:
        raise ValueError(
            f"Expected a picture named {', '.join(PICTURES)}, got {output.name}. Rename it."
        )
    output.parent.mkdir(parents=True, exist_ok=True)
    failed = 0
    for outcome in outcomes(output):
        print(outcome, flush=True)
        failed += not outcome.passed
    print(f"{output}: Fig. 10, {'drawn' if output.is_file() else 'needs cmtof[plot]'}")
    if failed:
        raise ValueError(
            f"Expected every line to pass, got {failed} FAIL. Compare versions."
        )


@app.command()
def render(
    output: Annotated[
        Path, Option("--output", "-o", help="Folder to write the set into.")
    ],
    scenes: Annotated[int, Option(min=1, max=100_000, help="How many rooms.")] = 20,
    views: Annotated[int, Option(min=1, max=1000, help="Views of each.")] = 5,
    seed: Seed = 0,
    size: Annotated[str, Option(help="Height x width, px.")] = "512x512",
    focal: Annotated[
        float | None, Option(help="Focal length, px. Default: 35 to 60°.")
    ] = None,
    workers: Annotated[
        int | None, Option(min=1, help="Processes. Default: one a core.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Render furnished rooms, in Hypersim's layout.

    The same seed gives the same bytes. A stopped run continues, and a set may
    grow: ask for more scenes or views in the same folder. Needs the extra [bold]rooms[/bold].

    Example: [bold]cmtof render --scenes 20 --views 5 --seed 1 -o rooms[/bold]
    """
    with later():
        from cmtof_rooms.rendering import Settings, render_rooms, shape_from_text

    settings = Settings(seed, scenes, views, *shape_from_text(size), focal)
    with progress(scenes, quiet) as advance:
        done = render_rooms(
            output, settings, workers=workers, progress=lambda one: advance(one.scene)
        )
    rendered = sum(one.rendered for one in done)
    print(f"{output}: {scenes} rooms, {views} views each; {rendered} views rendered")


@app.command()
def train(
    config: Annotated[str, Argument(help="A recipe by name, or a YAML file.")],
    output: Annotated[File, Option("--output", "-o", help="Folder of the run.")] = None,
    model: Annotated[
        str | None, Option(help="Learned method, such as fast-scnn.")
    ] = None,
    protocol: Annotated[str | None, Option(help="released or full.")] = None,
    data: Annotated[File, Option(help="Hypersim's layout. Default: rooms.")] = None,
    init: Annotated[File, Option(help="Weights to begin with.")] = None,
    resume: Annotated[
        bool, Option("--resume", help="Go on from its checkpoint.")
    ] = False,
    minutes: Annotated[
        float | None, Option(help="Stop after; --resume goes on.")
    ] = None,
    seed: Annotated[int | None, _SEED] = None,
    accelerator: Annotated[str, Option(help="Lightning's: auto, cpu, gpu.")] = "auto",
    devices: Annotated[str, Option(help="How many, or auto.")] = "auto",
    num_nodes: Annotated[int, Option(min=1, help="Machines.")] = 1,
    strategy: Annotated[str, Option(help="Lightning's: auto, ddp.")] = "auto",
    quiet: Quiet = False,
) -> None:
    """Train an unwrapping network and write its weights and their card.

    A run that was killed and resumed ends with the same weights. Needs the extras
    [bold]train[/bold] and [bold]rooms[/bold].

    Example: [bold]cmtof train miniature -o runs/miniature[/bold]
    """
    from cmtof.network.recipe import read_config
    from cmtof.network.training import train as train_network

    chosen = read_config(config, model=model, protocol=protocol, seed=seed)
    folder = output or Path("runs") / f"{chosen.name}-{chosen.model}-{chosen.protocol}"
    written = train_network(
        chosen,
        folder,
        quiet=quiet or hidden(),
        tree=data,
        init=init,
        resume=resume,
        minutes=minutes,
        accelerator=accelerator,
        num_nodes=num_nodes,
        strategy=strategy,
        devices=int(devices) if devices.isdigit() else devices,
    )
    print(written or f"{folder}: stopped before its last step; --resume goes on")


@app.command()
def scan(
    output: Annotated[File, Option("--output", "-o", help="Measurement, *.nc.")] = None,
    rig: Annotated[File, Argument(help="RIG file, *.yml.")] = None,
    twin: Annotated[
        bool, Option("--twin", help="Simulate the instrument, by RIG's twin.")
    ] = False,
    scene: Annotated[str | None, Option(help="Its frame. Default: still_life.")] = None,
    seed: Annotated[int | None, _SEED] = None,
    size: Annotated[int, Option(min=1, max=4096, help="Height and width, px.")] = 64,
    resume: Annotated[
        bool, Option("--resume", help="Go on with a scan that was stopped.")
    ] = False,
    check: Annotated[
        bool, Option("--check", help="Ask every device, move nothing.")
    ] = False,
    log: Annotated[File, Option(help="File of all requests and replies.")] = None,
    quiet: Quiet = False,
) -> None:
    """Scan with the instrument, or with its simulation, into a measurement.

    Every line goes to the disk, into a journal beside the output, until the file is whole. After a
    stop of any kind, [bold]--resume[/bold] goes on at the first line that is missing.

    Example: [bold]cmtof scan --twin --scene still_life --size 64 --seed 0 -o m.nc[/bold]
    """
    from cmtof.hardware.connect import connected_bench
    from cmtof.hardware.journal import journal_path
    from cmtof.hardware.plan import planned
    from cmtof.hardware.rig import Rig
    from cmtof.hardware.scan import scan as run_scan

    if not twin and rig is None:
        raise ValueError("Expected either a RIG file or --twin, got neither. Name one.")
    if not twin and (seed, scene) != (None, None):
        raise ValueError(
            "Expected --scene and --seed with --twin, got a RIG file. Leave them out."
        )
    plan = planned(Rig.default() if rig is None else Rig.load(rig), size=size)
    bench = partial(
        connected_bench, plan.rig, log.open("w", encoding="utf-8") if log else None
    )
    if twin:
        from cmtof_lab.rehearsal import simulated_bench

        scene = scene or (None if rig else "still_life")
        bench = partial(simulated_bench, plan.rig, scene, seed=seed or 0)
    if check:
        _check_up(bench)
    if output is None:
        raise ValueError("Expected an output, got none. Add -o m.nc.")
    try:
        with progress(len(plan.lines), quiet) as advance:
            measurement = run_scan(
                plan,
                bench,
                output,
                resume=resume,
                report=lambda line: advance(f"{line.mode}: {line.kind}"),
            )
    except (KeyboardInterrupt, SystemExit):
        print(
            f"cmtof: stopped; {journal_path(output)} goes on with --resume",
            file=sys.stderr,
        )
        raise
    print(f"{output}: {measurement}, {measurement.mask.mean():.1%} of pixels valid")


def _check_up(bench: Callable[[], Any]) -> None:
    """Print what every device reports, and end with exit code 1 where one is not as expected."""
    from cmtof.hardware.checkup import states_of

    with bench() as on:
        states = list(states_of(on))
    print_table("", ("device", "reports"), states)
    raise SystemExit(any("Expected" in text for _, text in states))


def _rates(scores: dict[str, float]) -> dict[str, str]:
    """Rates and error of a method as they are printed, by their title."""
    titles = {f"δ<{k}": f"delta_lt_{k}" for k in (1, 2, 3)}
    titles |= {"δ≥10": "delta_ge_10", "consistent": "consistent_lt_1"}
    found = {title: f"{scores[key]:.1%}" for title, key in titles.items()}
    return found | {"median error": f"{1e3 * scores['depth_median_error_m']:.1f} mm"}


def _print_report(report: dict[str, Any]) -> None:
    title = (
        f"{len(report['frames'])} frame(s), protocol {report['protocol']}, "
        f"σ = {report['noise']:g}, seed {report['seed']}, {report['coverage']:.1%} scored"
    )
    found = {name: _rates(scores) for name, scores in report["methods"].items()}
    clock = {
        name: f"{one['seconds_per_frame']:.2f}"
        for name, one in report["methods"].items()
    }
    print_table(
        title,
        ("method", *next(iter(found.values())), "s/frame"),
        ([name, *cells.values(), clock[name]] for name, cells in found.items()),
    )
    for name, remark in report["notes"].items():
        print(shown(f"{name}: {remark}"))


if __name__ == "__main__":
    main()
