"""Files written whole or not at all, by renaming a temporary file; reading and checks of files."""

import os
import re
import shutil
import struct
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

AnyPath = str | Path
_NUMBER = count()  # of the files that this process writes beside others
# s after which a temporary file without a process here is no other machine's, either
_LEFTOVER_AGE = 600


def check_input(path: AnyPath, what: str = "a file to read") -> Path:
    """The path of a regular file; FileNotFoundError else, also for pipes and devices."""
    if not Path(path).is_file():
        raise FileNotFoundError(
            f"Expected {what}, got no file at {path}. Check the path."
        )
    return Path(path)


@contextmanager
def reading(
    expected: str, path: object, advice: str = "Fetch or write it again."
) -> Iterator[None]:
    """Context of reading a file: any error in it becomes a ValueError of one line."""
    try:
        yield
    except Exception as error:  # each package raises half a dozen kinds
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise ValueError(
            f"Expected {expected}, got {path} ({reason}). {advice}"
        ) from error


def check_heaps(path: Path) -> None:
    """Raise a ValueError if an HDF5 file has a heap that HDF5 would read in an endless loop.

    A collection ``GCOL`` holds objects with a number, a size, and that many bytes; number 0 is the
    free space, whose size counts its own 16 bytes of header.
    """
    with path.open("rb") as file, mmap(file.fileno(), 0, access=ACCESS_READ) as content:
        for found in re.finditer(rb"GCOL\x01\0{3}(.{8})", content, re.DOTALL):
            position = found.end()
            end = found.start() + int.from_bytes(found[1], "little")
            while position + 16 <= min(end, len(content)):
                number, size = struct.unpack_from("<H6xQ", content, position)
                position += 16 * (number > 0) + (size + 7) // 8 * 8
                if not number + size:
                    raise ValueError("a heap without an end")


def check_links(file: Any) -> None:
    """Raise a ValueError if an open HDF5 file links to data in another file."""
    from h5py import ExternalLink

    def name_if_outside(name: str, item: Any) -> str | None:
        external = isinstance(item, ExternalLink) or getattr(item, "external", None)
        return name if external or getattr(item, "is_virtual", None) else None

    # a visit ends at the first item for which it is given a name
    outside = file.visititems_links(name_if_outside) or file.visititems(name_if_outside)
    if outside:
        raise ValueError(f"{outside} lies in another file")


def check_output(path: AnyPath, suffix: str = "") -> Path:
    """Check that a file can be written, before anything is computed; return its real path.

    A ValueError if its name, or that of the file that a link leads to, lacks a given suffix; an
    OSError if the folder is missing, if it or the file may not be written, or for no regular file.
    """
    target = Path(path)
    if target.is_symlink():  # what it points to is replaced, not the link
        target = Path(os.path.realpath(target))
    if suffix and target.suffix != suffix:
        raise ValueError(
            f"Expected an output named *{suffix}, got {target.name}. Rename it."
        )
    if target.is_dir():
        raise IsADirectoryError(
            f"Expected a file to write, got the folder {target}. Name a file."
        )
    if not target.parent.is_dir():
        raise FileNotFoundError(
            f"Expected an existing folder to write into, got {target.parent}. Create it first."
        )
    if os.path.lexists(target) and not target.is_file():
        raise FileExistsError(
            f"Expected a file, got a device, pipe or circle of links, {target}. Name a file."
        )
    probe = _temporary_path(target)
    try:
        probe.touch()
        probe.unlink()
        if target.exists():  # a temporary file has its permissions
            target.open("ab").close()
    except OSError as error:
        raise PermissionError(
            f"Expected a place that can be written to, got {target} ({error.strerror}). "
            "Choose another."
        ) from error
    return target


def _temporary_path(target: Path) -> Path:
    """Unused path of a temporary file beside a file, with the same suffix."""
    # a name of 255 bytes has no room for more
    return target.with_name(
        f".{target.stem[:50]}.part-{os.getpid()}-{next(_NUMBER)}{target.suffix}"
    )


def _remove_leftovers(target: Path) -> None:
    """Remove temporary files of killed processes beside a file, if they are some minutes old."""
    for part in target.parent.glob(".*.part-*"):
        process = re.search(r"\.part-(\d+)-\d+$", part.stem)
        if process and not Path("/proc", process[1]).exists():
            with suppress(OSError):
                if time.time() - part.stat().st_mtime > _LEFTOVER_AGE:
                    part.unlink()


@contextmanager
def atomic_output(path: AnyPath, suffix: str = "") -> Iterator[Path]:
    """Yield a temporary path beside ``path`` that is renamed onto it when the block succeeds.

    Raises the errors of `check_output`, before the block.

    >>> import tempfile
    >>> target = Path(tempfile.mkdtemp()) / "a.txt"
    >>> with atomic_output(target) as part:
    ...     _ = part.write_text("whole")
    >>> target.read_text()
    'whole'
    """
    target = check_output(path, suffix)
    _remove_leftovers(target)
    part = _temporary_path(target)
    try:
        if target.exists():  # keep its permissions
            part.touch(0o600)
            shutil.copymode(target, part)
        yield part
        part.replace(target)
    except OSError as error:
        if error.errno:  # of the system, which names no file on a full disk
            error.filename = error.filename or target
        raise
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def exclusive_lock(path: Path, *, wait: bool = False) -> Iterator[None]:
    """Lock a file or folder for this process; if another has it, wait or raise a ValueError."""
    import fcntl  # Windows has none

    handle = os.open(path, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            raise ValueError(
                f"Expected {path} to be free, got a process that is writing it. "
                "Wait until it ends."
            ) from None
        yield
    finally:
        os.close(handle)


# Largest size and depth of nesting of a document that is read.
MOST_BYTES, MOST_DEPTH = 2**20, 20


def read_small_file(path: AnyPath) -> bytes:
    """Bytes of a file; a ValueError if there are more than `MOST_BYTES`."""
    size = check_input(path).stat().st_size
    if size > MOST_BYTES:
        raise ValueError(
            f"Expected at most {MOST_BYTES} bytes in {path}, got {size}. Name another file."
        )
    return Path(path).read_bytes()


def read_document(path: AnyPath) -> dict[str, Any]:
    """Names and values of a YAML or JSON file; nothing in it is executed.

    A ValueError if it is too large, too deep, has aliases, or names that are no text.

    >>> import tempfile
    >>> target = Path(tempfile.mkdtemp()) / "a.yml"
    >>> _ = target.write_text("name: rig\\nsize: {height: 3}\\n")
    >>> read_document(target)
    {'name': 'rig', 'size': {'height': 3}}
    """
    import yaml

    data = read_small_file(path)
    # libyaml, where there is one, takes a tenth of the time
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    with reading("YAML", path, "Correct it."):
        depth = 0
        for event in yaml.parse(data, loader):
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if isinstance(event, yaml.AliasEvent) or depth > MOST_DEPTH:
                raise ValueError(f"aliases or a depth above {MOST_DEPTH}")
        found = yaml.load(data, loader) or {}
    if not isinstance(found, dict) or not all(isinstance(name, str) for name in found):
        raise ValueError(
            f"Expected names and values in {path}, got something else. Correct it."
        )
    return found
