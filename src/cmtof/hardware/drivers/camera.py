"""Cameras: what the stereo pair has to be able to do, and a camera that plays files."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

SUFFIXES = (".npy", ".png", ".tif", ".tiff")
"""Files that a `FileCamera` reads."""


class Camera(Protocol):
    """A camera.

    A driver for another one needs this method, and may have `close`.
    """

    def frame(self) -> NDArray[Any]:
        """Take an image (H, W): grey levels, as the camera gives them."""
        ...


class FileCamera:
    """Plays images from files, one a call.

    Parameters
    ----------
    source : path or sequence of paths
        A folder, whose images come in the order of the numbers in their names, or files.
    repeat : bool
        Begin anew after the last.

    Raises
    ------
    FileNotFoundError
        If there is no such folder or file, or no image in it.
    """

    def __init__(self, source: str | Path | Sequence[str | Path], *, repeat: bool = False) -> None:
        if isinstance(source, str | Path):
            folder = Path(source)
            paths = sorted(
                (one for one in folder.glob("*") if one.suffix.lower() in SUFFIXES), key=_natural
            )
        else:
            paths = [Path(one) for one in source]
        missing = [str(path) for path in paths if not path.is_file()]
        if missing or not paths:
            raise FileNotFoundError(
                f"Expected images ({', '.join(SUFFIXES)}), got {missing[0] if missing else 'none'}"
                f" in {source}. Name a folder of images."
            )
        self.paths = paths
        self._repeat = repeat
        self._next = 0

    def __len__(self) -> int:
        return len(self.paths)

    def frame(self) -> NDArray[Any]:
        """Return the next image (H, W); colours are averaged to grey.

        Raises
        ------
        EOFError
            After the last image.
        ValueError
            If a file holds no image.
        """
        if self._next == len(self.paths):
            if not self._repeat:
                raise EOFError(
                    f"Expected one of {len(self.paths)} images, got to the end. Add images."
                )
            self._next = 0
        path = self.paths[self._next]
        self._next += 1
        return _read(path)


class GenicamCamera:
    """A GenICam camera (GigE Vision, USB3 Vision) through the package harvesters.

    Written from its documentation; not verified with a camera.

    Parameters
    ----------
    producer : path
        GenTL producer, a ``.cti`` file of the camera's maker or of a free project.
    index : int
        Which of the cameras that it finds.
    timeout : float
        For an image, s.

    Raises
    ------
    FileNotFoundError
        If there is no such file, or no camera.
    """

    def __init__(self, producer: str | Path, index: int = 0, *, timeout: float = 2.0) -> None:
        path = Path(producer)
        if not path.is_file():
            raise FileNotFoundError(f"Expected a GenTL producer, got no file {path}. Install one.")
        try:
            from harvesters.core import Harvester  # type: ignore[import-not-found]
        except ImportError:
            raise ImportError(
                "Expected the package harvesters for GenICam cameras, got none. "
                "pip install harvesters."
            ) from None
        self._timeout = timeout
        self._harvester = Harvester()
        self._harvester.add_file(str(path))
        self._harvester.update()
        found = len(self._harvester.device_info_list)
        if not 0 <= index < found:
            self._harvester.reset()
            raise FileNotFoundError(
                f"Expected camera {index}, got {found} cameras. Check cable and network."
            )
        self._camera = self._harvester.create(index)
        self._camera.start()

    def frame(self) -> NDArray[Any]:
        """Take an image (H, W)."""
        with self._camera.fetch(timeout=self._timeout) as buffer:
            image = buffer.payload.components[0]
            # the memory goes back to the camera when the block ends
            return image.data.reshape(image.height, image.width).copy()

    def close(self) -> None:
        """Stop the camera."""
        self._camera.destroy()
        self._harvester.reset()


def _natural(path: Path) -> list[tuple[int, int, str]]:
    """Key that puts frame_10 behind frame_9."""
    parts = re.split(r"(\d+)", path.name.lower())
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in parts]


def _read(path: Path) -> NDArray[Any]:
    try:
        image = np.load(path, allow_pickle=False) if path.suffix == ".npy" else _read_picture(path)
    except (OSError, ValueError, EOFError) as error:
        raise ValueError(f"Expected an image in {path}, got {error}. Replace it.") from error
    if image.ndim == 3 and image.shape[2] in (3, 4):
        image = image[..., :3].mean(axis=2)
    if image.ndim != 2:
        raise ValueError(f"Expected an image (H, W) in {path}, got {image.shape}. Replace it.")
    return image


def _read_picture(path: Path) -> NDArray[Any]:
    from PIL import Image

    with Image.open(path) as picture:
        return np.asarray(picture)
