"""Methods side by side on the same scene (Fig. 10): the error of each."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from cmtof.correlation import wrap_count_from_depth
from cmtof.measurement import Measurement
from cmtof.scenes import Frame
from cmtof.types import Array, Pair
from cmtof_book.plotting import grid, image


class Scene(NamedTuple):
    """One scene and the answers of methods, as `cmtof.unwrap` returns them, by label."""

    frame: Frame
    measurement: Measurement
    answers: dict[str, xr.Dataset]

    def count(self, label: str = "") -> Array:
        """Wraps (H, W) by one method or of the true depth, NaN where not scored."""
        depth = np.nan_to_num(self.measurement.depth).astype(float)
        truth = wrap_count_from_depth(depth, self.measurement.frequencies[0])
        found = self.answers[label]["wrap_count"] if label else truth
        return np.where(self.measurement.mask, found, np.nan)

    def error(self, label: str) -> Array:
        """Wraps (H, W) by which a method is off, NaN where not scored."""
        return np.abs(self.count(label) - self.count())

    @property
    def limits(self) -> Pair:
        """Wraps between which the colours run."""
        return tuple(np.nanpercentile(self.count(), (1, 99)))

    def right(self, label: str) -> float:
        """Share of the scored pixels in the right wrap."""
        return np.mean(self.error(label)[self.measurement.mask] < 1)


def comparison_figure(scene: Scene, labels: Sequence[str]) -> Figure:
    """Fig. 10: brightness and true wraps of a scene, then the errors of each method."""
    height, width = scene.measurement.shape
    figure, axes = grid(2 + len(labels), 3, height / width)
    light, truth, *others = axes
    brightness = np.sqrt(np.clip(np.nan_to_num(scene.frame.intensity), 0, 1))
    image(light, brightness, label="", cmap="gray", title="the room", bar=False)
    image(
        truth,
        scene.count(),
        label="",
        limits=scene.limits,
        title="true wraps",
        bar=False,
    )
    for ax, label in zip(others, labels, strict=True):
        title = f"{label}: {100 * scene.right(label):.0f} %"
        look = {"cmap": "magma", "limits": (0, 10), "bar": False}
        image(ax, scene.error(label), label="", title=title, **look)
    figure.colorbar(others[0].images[0], ax=axes[:6], label="wraps off")
    return figure
