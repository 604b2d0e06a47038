"""Cameras of the stereo pair, through OpenCV: USB cameras and recorded images."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


class Camera:
    """A camera, or what stands for one.

    Parameters
    ----------
    source : int or str
        Number of a USB camera (UVC), or a pattern of image files, as ``left/frame_%04d.png``.

    Raises
    ------
    FileNotFoundError
        If nothing is there.
    """

    def __init__(self, source: int | str) -> None:
        import cv2

        self._capture: Any = cv2.VideoCapture(source)
        if not self._capture.isOpened():
            raise FileNotFoundError(f"Expected a camera or images at {source}, got none. Plug in.")

    def frame(self) -> NDArray[np.float64]:
        """Next image (H, W), grey, as the camera gives it; `EOFError` behind the last."""
        good, image = self._capture.read()
        if not good:
            raise EOFError("Expected another image, got to the end. Add images.")
        return image.astype(float).mean(axis=-1) if image.ndim == 3 else image.astype(float)

    def close(self) -> None:
        """Release the camera."""
        self._capture.release()
