"""Methods side by side on the same scenes (Fig. 10): the wraps of each and their errors."""

from collections.abc import Sequence
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
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

    def right(self, label: str) -> float:
        """Share of the scored pixels in the right wrap."""
        error = np.abs(self.count(label) - self.count())
        return float(np.mean(error[self.measurement.mask] < 1))


def comparison_figure(scenes: Sequence[Scene], labels: Sequence[str]) -> Figure:
    """Fig. 10: two rows a scene, its brightness and true wraps, then methods and their errors."""
    height, width = scenes[0].measurement.shape
    columns, side = 1 + len(labels), 1.2
    size = (side * columns + 0.6, 2 * len(scenes) * (side * height / width + 0.2) + 0.2)
    figure, axes = plt.subplots(2 * len(scenes), columns, figsize=size, squeeze=False)
    for scene, (above, below) in zip(scenes, axes.reshape(len(scenes), 2, columns), strict=True):
        truth, room = scene.count(), scene.frame.name.partition("/")[0]
        low, high = np.nanpercentile(truth, (1, 99))
        brightness = np.sqrt(np.clip(np.nan_to_num(scene.frame.intensity), 0, 1))
        image(above[0], brightness, label="", cmap="gray", title=room, bar=False)
        image(below[0], truth, label="", limits=(low, high), title="true wraps", bar=False)
        for up, down, label in zip(above[1:], below[1:], labels, strict=True):
            last, found = label == labels[-1], scene.count(label)
            name = label.replace("reference-", "reference\n")
            image(up, found, label="wraps n", limits=(low, high), title=name, bar=last)
            share, error = f"{100 * scene.right(label):.0f} % right", np.abs(found - truth)
            image(down, error, label="error δ", cmap="magma", limits=(0, 10), title=share, bar=last)
    for ax in figure.axes:
        ax.title.set_size(9)
    return figure
