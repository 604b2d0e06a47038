"""Methods side by side on the same scenes (Fig. 10): the wraps of each and their errors."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cmtof.correlation import wrap_count_from_depth
from cmtof.measurement import Measurement
from cmtof.scenes import Frame

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Scene(NamedTuple):
    """One scene and the answers of methods, as `cmtof.unwrap` returns them, by label."""

    frame: Frame
    measurement: Measurement
    answers: dict[str, xr.Dataset]

    @property
    def true_count(self) -> NDArray[np.floating]:
        """Wraps of the true depth (H, W), NaN where not scored."""
        depth = np.nan_to_num(self.measurement.depth).astype(float)
        count = wrap_count_from_depth(depth, self.measurement.frequencies[0])
        return np.where(self.measurement.mask, count, np.nan)

    def found_count(self, label: str) -> NDArray[np.floating]:
        """Wraps by one method (H, W), NaN where not scored."""
        return np.where(self.measurement.mask, self.answers[label]["wrap_count"], np.nan)

    def error(self, label: str) -> NDArray[np.floating]:
        """Wraps off, |n - n_true| (H, W), NaN where not scored."""
        return np.abs(self.found_count(label) - self.true_count)

    def right(self, label: str) -> float:
        """Share of the scored pixels in the right wrap; NaN if none is scored."""
        error = self.error(label)[self.measurement.mask]
        return float(np.mean(error < 1)) if error.size else float("nan")


def comparison_figure(scenes: Sequence[Scene], labels: Sequence[str]) -> "Figure":
    """Fig. 10: two rows a scene, its brightness and true wraps, then methods and their errors.

    Raises
    ------
    ValueError
        If there is no scene or no label.
    """
    import matplotlib.pyplot as plt

    if not scenes or not labels:
        raise ValueError(
            f"Expected at least one scene and method, got {len(scenes)} and {len(labels)}. "
            "Load a frame, name a method."
        )
    height, width = scenes[0].measurement.shape
    columns, side = 1 + len(labels), 1.35
    size = (side * columns + 0.6, 2 * len(scenes) * (side * height / width + 0.17) + 0.2)
    figure, axes = plt.subplots(2 * len(scenes), columns, figsize=size, squeeze=False)
    for scene, (above, below) in zip(scenes, axes.reshape(len(scenes), 2, columns), strict=True):
        truth = scene.true_count
        limits = tuple(np.nanpercentile(truth, (1, 99))) if scene.measurement.mask.any() else (0, 1)
        brightness = np.sqrt(np.clip(np.nan_to_num(scene.frame.intensity), 0, 1))
        _tile(above[0], brightness, "gray", (0, 1), scene.frame.name)
        wraps = errors = _tile(below[0], truth, "cividis", limits, "true wraps")
        for column, label in enumerate(labels, start=1):
            _tile(above[column], scene.found_count(label), "cividis", limits, label)
            share = f"{100 * scene.right(label):.0f} % right"
            errors = _tile(below[column], scene.error(label), "magma", (0, 10), share)
        for ax, drawn, label in ((above[-1], wraps, "wraps n"), (below[-1], errors, "error δ")):
            bar = figure.colorbar(drawn, cax=ax.inset_axes((1.04, 0, 0.05, 1)))
            bar.set_label(label, fontsize=7)
            bar.ax.tick_params(labelsize=7)
    return figure


def _tile(ax, image, cmap, limits, title):  # type: ignore[no-untyped-def]
    """One picture of the grid, without a frame; NaN is grey."""
    import matplotlib as mpl

    colours = mpl.colormaps[cmap].with_extremes(bad="#E6E9EC")
    drawn = ax.imshow(image, cmap=colours, vmin=limits[0], vmax=limits[1], interpolation="nearest")
    ax.set(xticks=[], yticks=[])
    ax.set_title(title, fontsize=7, pad=2)
    ax.grid(visible=False)
    ax.spines[:].set_visible(False)
    return drawn
