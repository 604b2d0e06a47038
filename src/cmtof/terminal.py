"""Output of the command line: tables, a progress bar, errors, and text safe for any terminal."""

import codecs
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from shutil import get_terminal_size

# Replacements of characters that the output's encoding lacks.
PLAIN = str.maketrans(
    {
        "δ": "d",
        "σ": "sigma",
        "≥": ">=",
        "«": '"',
        "»": '"',
        "…": "...",
        "°": " deg",
        "−": "-",
    }
)

# Extra of each module that comes with none of the package's own dependencies.
EXTRAS = {
    "pyvisa": "hardware",
    "serial": "hardware",
    "thorlabs_apt_protocol": "hardware",
    "cv2": "lab",
    "pandas": "lab",
    "onnxruntime": "networks",
    "safetensors": "networks",
    "cycler": "plot",
    "matplotlib": "plot",
    "embreex": "rooms",
    "trimesh": "rooms",
    "lightning": "train",
    "torch": "train",
    "IPython": "view",
    "pyvista": "view",
}


def prepare_streams() -> None:
    """Let output work in encodings that lack some characters, and where streams are closed."""
    codecs.register_error("cmtof", _replace_unencodable)  # pyright: ignore[reportArgumentType] - for writing alone
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed, as some schedulers start a command
            setattr(sys, name, Path(os.devnull).open("w"))  # noqa: SIM115 - it stays open
        else:
            stream.reconfigure(errors="cmtof")


def _replace_unencodable(error: UnicodeEncodeError) -> tuple[str, int]:
    """Replacement of characters that cannot be encoded, and the position after them."""
    plain = error.object[error.start : error.end].translate(PLAIN)
    return plain.encode("ascii", "backslashreplace").decode(), error.end


def escape_controls(text: object) -> str:
    r"""Text in which control characters, which would steer a terminal, are escaped.

    >>> escape_controls("a\x1b[31mb")
    'a\\x1b[31mb'
    """
    return "".join(
        c if c.isprintable() or c in "\n\t" else repr(c)[1:-1] for c in str(text)
    )


def say(text: object) -> None:
    """Print text with its control characters escaped."""
    print(escape_controls(text), flush=True)


def complain(text: object) -> None:
    """Print a line of the command on stderr, with its control characters escaped."""
    print(f"cmtof: {escape_controls(text)}", file=sys.stderr)


def error_line(error: Exception) -> str:
    """One-line message for an error; called a defect unless its kind or wording is foreseen."""
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
def delay_interrupts() -> Iterator[None]:
    """Context that delays Ctrl-C to its end; processes started inside ignore it.

    Packages catch it while they load, and a terminal sends it to workers too.
    """
    previous_mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous_mask)


@contextmanager
def progress(total: int, quiet: bool) -> Iterator[Callable[..., None]]:
    """Context of a progress bar on stderr: a function that advances it, with a text."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    with Progress(
        console=Console(stderr=True), disable=quiet or progress_is_hidden()
    ) as bar:
        task = bar.add_task("", total=total)

        def advance(text: str, share: float = 1.0) -> None:
            bar.update(task, advance=share, description=escape(escape_controls(text)))

        yield advance


def progress_is_hidden() -> bool:
    """Whether to hide the bar: in CI, and where standard error is no terminal."""
    return bool(os.environ.get("CI")) or not sys.stderr.isatty()


def print_table(title: str, rows: Sequence[Mapping[str, object]]) -> None:
    """Print a table of rows, each a mapping from titles of columns to cells."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    head = dict.fromkeys(title for row in rows for title in row)
    table = Table(*head, title=Text(escape_controls(title)))
    table.columns[0].no_wrap = True
    for row in rows:
        texts = (escape_controls(row.get(title, "")) for title in head)
        table.add_row(*(Text(text, overflow="fold") for text in texts))
    # a narrower one would leave out numbers
    Console(width=max(80, get_terminal_size().columns)).print(table)
