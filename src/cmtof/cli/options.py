"""Options that several commands share, and what they are turned into."""

from pathlib import Path
from typing import Annotated

import typer

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
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]


def tones(text: str) -> list[float]:
    """Frequencies, Hz, of a text that parts them by commas."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError as error:
        raise ValueError(
            f"Expected frequencies in Hz parted by commas, got {text}. Try 7.15e9,14.32e9."
        ) from error
