"""What the command line says: tables, a bar, errors, and text that any terminal can show."""

import codecs
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

# What stands for a character where the output's encoding has none.
PLAIN = {
    "δ": "d",
    "σ": "sigma",
    "≥": ">=",
    "«": '"',
    "»": '"',
    "…": "...",
    "°": " deg",
    "−": "-",
}

MODULES = {
    "hardware": "pyvisa serial thorlabs_apt_protocol",
    "lab": "cv2 pandas",
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


def prepare_streams() -> None:
    """Make output survive an encoding without our characters, and streams that are closed."""
    codecs.register_error("cmtof", _plainer)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed, as some schedulers start a command
            setattr(sys, name, Path(os.devnull).open("w"))  # noqa: SIM115 - it stays open
        else:
            stream.reconfigure(errors="cmtof")


def _plainer(error: UnicodeError) -> tuple[str, int]:
    """Plain text for what could not be encoded, and where to go on."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    missing = error.object[error.start : error.end]
    plain = "".join(PLAIN.get(one, one) for one in missing)
    return plain.encode("ascii", "backslashreplace").decode(), error.end


def shown(text: object) -> str:
    r"""Text of a file or a name, with what would steer a terminal written out.

    >>> shown("a\x1b[31mb")
    'a\\x1b[31mb'
    """
    return "".join(
        c if c.isprintable() or c in "\n\t" else repr(c)[1:-1] for c in str(text)
    )


def error_line(error: Exception) -> str:
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


@contextmanager
def later() -> Iterator[None]:
    """Delay Ctrl-C to the end of the block; processes begun inside never hear it.

    Packages catch it while they load, and a terminal sends it to workers too.
    """
    heard = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, heard)


@contextmanager
def progress(total: int, quiet: bool) -> Iterator[Callable[..., None]]:
    """Bar on stderr, advanced by each call; hidden when asked for, in CI, and in a pipe."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), disable=quiet or hidden()) as bar:
        task = bar.add_task("", total=total)

        def advance(text: str, share: float = 1.0) -> None:
            bar.update(task, advance=share, description=escape(shown(text)))

        yield advance


def hidden() -> bool:
    """Whether to hide the bar: in CI, and where standard error is no terminal."""
    return bool(os.environ.get("CI")) or not sys.stderr.isatty()


def print_table(title: str, rows: Sequence[Mapping[str, object]]) -> None:
    """Print a table of rows by the titles of their columns, their cells as they are."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    head = dict.fromkeys(title for row in rows for title in row)
    table = Table(*head, title=Text(shown(title)) if title else None)
    table.columns[0].no_wrap = True
    for row in rows:
        table.add_row(*(Text(shown(row.get(title, ""))) for title in head))
    Console().print(table)
