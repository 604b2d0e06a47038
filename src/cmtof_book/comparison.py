"""Methods side by side on the same scenes (Fig. 10): the wraps of each and their errors."""

from collections.abc import Sequence
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cmtof.correlation import wrap_count_from_depth
from cmtof.measurement import Measurement
from cmtof.scenes import Frame
from cmtof_book.plotting import image


class Scene(NamedTuple):
    """One scene and the answers of methods, as `cmtof.unwrap` returns them, by label."""

    frame: Frame
    measurement: Measurement
    answers: dict[str, xr.Dataset]

    def count(self, label: str = "") -> NDArray[np.floating]:
        """Wraps (H, W) by one method or of the true depth, NaN where not scored."""
        depth = np.nan_to_num(self.measurement.depth).astype(float)
        truth = wrap_count_from_depth(depth, self.measurement.frequencies[0])
        found = self.answers[label]["wrap_count"] if label else truth
        return np.where(self.measurement.mask, found, np.nan)

    @property
    def limits(self) -> tuple[float, float]:
        """Wraps between which the colours run."""
        low, high = np.nanpercentile(self.count(), (1, 99))
        return float(low), float(high)

    def right(self, label: str) -> float:
        """Share of the scored pixels in the right wrap."""
        error = np.abs(self.count(label) - self.count())
        return float(np.mean(error[self.measurement.mask] < 1))


def comparison_figure(scenes: Sequence[Scene], labels: Sequence[str]) -> Figure:
    """Fig. 10: two rows a scene, its brightness and true wraps, then methods and their errors."""
    height, width = scenes[0].measurement.shape
    columns = 1 + len(labels)
    side = 1.2  # inches
    size = (side * columns + 0.6, 2 * len(scenes) * (side * height / width + 0.2) + 0.2)
    figure, axes = plt.subplots(2 * len(scenes), columns, figsize=size, squeeze=False)
    for scene, pair in zip(scenes, axes.reshape(len(scenes), 2, columns), strict=True):
        _draw_scene(scene, *pair[:, 0])
        for label, above, below in zip(labels, *pair[:, 1:], strict=True):
            _draw_method(scene, label, above, below, bar=label == labels[-1])
    for ax in figure.axes:
        ax.title.set_size(9)
    return figure


def _draw_scene(scene: Scene, above: Axes, below: Axes) -> None:
    """Brightness of a scene above its true wraps."""
    room = scene.frame.name.partition("/")[0]
    brightness = np.sqrt(np.clip(np.nan_to_num(scene.frame.intensity), 0, 1))
    image(above, brightness, label="", cmap="gray", title=room, bar=False)
    image(below, scene.count(), label="", limits=scene.limits, title="true wraps", bar=False)


def _draw_method(scene: Scene, label: str, above: Axes, below: Axes, *, bar: bool) -> None:
    """Wraps of a method above their errors; with colour bars or without."""
    found = scene.count(label)
    name = label.replace("reference-", "reference\n")
    image(above, found, label="wraps n", limits=scene.limits, title=name, bar=bar)
    error = np.abs(found - scene.count())
    share = f"{100 * scene.right(label):.0f} % right"
    image(below, error, label="error δ", cmap="magma", limits=(0, 10), title=share, bar=bar)
