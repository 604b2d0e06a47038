"""Options that several commands have."""

from pathlib import Path
from typing import Annotated, Any

from typer import Option

from cmtof.files import check_output

File = Path | None


def to_write(named: str, *flags: str, text: str) -> Any:
    """Option of a file to write, which is checked before anything is computed for it."""

    def check(path: File) -> File:
        free = (
            named != ".nc" and path and not path.exists()
        )  # what is replaced must be alike
        return path and check_output(path, *[] if free else [named]) and path

    return Option(*flags, help=text, callback=check)


Output = Annotated[
    Path,
    to_write(".nc", "--output", "-o", text="File to write, [bold]*.nc[/bold]."),
]
Protocol = Annotated[
    str,
    Option(
        help="released: scene shrunk to 1.195 m, 21 wraps; full: all of the 7.5 m range."
    ),
]
Noise = Annotated[float, Option(help="Gaussian noise, counts; photon noise stays on.")]
NoiseFree = Annotated[bool, Option("--noise-free", help="No noise of either kind.")]
SEED = Option(min=0, max=2**63 - 1, help="Seed of the random numbers.")
Seed = Annotated[int, SEED]
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
