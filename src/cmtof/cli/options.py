"""Options that several commands share."""

from collections.abc import Callable
from functools import wraps
from inspect import signature
from pathlib import Path
from typing import Annotated, Any

from typer import Option

from cmtof.files import check_output

File = Path | None
Options = dict[str, Any]  # of a group, by name


def output_option(named: str, *flags: str, text: str) -> Any:
    """Option of a file to write, which is checked before anything is computed."""

    def check(path: File) -> File:
        free = (
            named != ".nc" and path and not path.exists()
        )  # a file is replaced only if its name has the suffix
        return path and check_output(path, *[] if free else [named]) and path

    return Option(*flags, help=text, callback=check)


Output = Annotated[
    Path,
    output_option(".nc", "--output", "-o", text="File to write, [bold]*.nc[/bold]."),
]
SEED = Option(min=0, max=2**63 - 1, help="Seed of the random numbers.")
Seed = Annotated[int, SEED]
AnySeed = Annotated[int | None, SEED]
Quiet = Annotated[bool, Option("--quiet", "-q", help="No progress bar.")]


def conditions(
    protocol: Annotated[
        str,
        Option(
            help="released: scene shrunk to 1.195 m, 21 wraps; "
            "full: all of the 7.5 m range."
        ),
    ] = "released",
    noise: Annotated[
        float, Option(help="Gaussian noise, counts; photon noise stays on.")
    ] = 1200.0,
    noise_free: Annotated[
        bool, Option("--noise-free", help="No noise of either kind.")
    ] = False,
    seed: Seed = 0,
) -> None:
    """Options of a simulation."""


def reading(
    intensity: Annotated[
        File, Option(help="Image of the light of a depth image.")
    ] = None,
    depth_scale: Annotated[
        float | None,
        Option(help="Depth image: levels per metre. Default: 1000, of TUM 5000."),
    ] = None,
    planar: Annotated[
        bool, Option("--planar", help="Depth image is along the axis.")
    ] = False,
    camera: Annotated[
        tuple[float, float, float, float] | None, Option(help="fx fy cx cy in pixels.")
    ] = None,
    linear: Annotated[
        bool, Option("--linear", help="Light of a depth image is linear, no sRGB.")
    ] = False,
) -> None:
    """Options for reading a depth image: its light, scale, kind and camera."""


def group_options(*groups: Callable[..., None]) -> Callable[[Callable], Callable]:
    """Decorator: a command takes each group's parameters as options, and gets them as one dict."""
    options = {group.__name__: signature(group).parameters for group in groups}

    def decorated(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def run(**given: Any) -> None:
            for group, names in options.items():
                given[group] = {name: given.pop(name) for name in names}
            command(**given)

        own_signature = signature(command)
        plain = [
            one for name, one in own_signature.parameters.items() if name not in options
        ]
        shared = [one for names in options.values() for one in names.values()]
        vars(run)["__signature__"] = own_signature.replace(parameters=[*plain, *shared])
        return run

    return decorated
