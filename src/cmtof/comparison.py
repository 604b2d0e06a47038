"""Methods side by side on the same scenes: what each makes of them, how far it is off (Fig. 10).

Each scene takes two rows: wraps above, their errors below; each method one column.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cmtof.correlation import wrap_count_from_depth
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LARGEST_ERROR = 10
"""Wraps off at which the colours of an error map end; beyond it Table 2 counts a far outlier."""


class Scene(NamedTuple):
    """One scene and what methods say of it."""

    frame: Frame
    measurement: Measurement
    answers: Mapping[str, xr.Dataset]
    """By the method's label, as `cmtof.unwrap` returns them."""

    @property
    def true_count(self) -> NDArray[np.floating]:
        """Wraps of the true depth (H, W), NaN where not scored."""
        depth, scored = self.measurement.depth, self.measurement.mask
        assert depth is not None  # simulated
        known = np.nan_to_num(depth).astype(float)
        return np.where(
            scored, wrap_count_from_depth(known, self.measurement.frequencies[0]), np.nan
        )

    def found_count(self, label: str) -> NDArray[np.floating]:
        """Wraps by one method (H, W), NaN where not scored."""
        found = self.answers[label]["wrap_count"].to_numpy()
        return np.where(self.measurement.mask, found, np.nan)

    def error(self, label: str) -> NDArray[np.floating]:
        """Wraps off, |n - n_true| (H, W), NaN where not scored."""
        return np.abs(self.found_count(label) - self.true_count)

    def right(self, label: str) -> float:
        """Share of the scored pixels in the right wrap; NaN if none is scored."""
        error = self.error(label)[self.measurement.mask]
        return float(np.mean(error < 1)) if error.size else float("nan")


def comparison_figure(scenes: Sequence[Scene], titles: Mapping[str, str]) -> "Figure":
    """Draw Fig. 10: for each scene its brightness and true wraps, then methods and their errors.

    Parameters
    ----------
    scenes : sequence of Scene
    titles : dict of str
        Columns: what to write above each method, by its label.

    Raises
    ------
    ValueError
        If there is no scene.
    """
    import matplotlib.pyplot as plt

    if not scenes or not titles:
        raise ValueError(
            f"Expected at least one scene and method, got {len(scenes)} and {len(titles)}. "
            "Load a frame, name a method."
        )
    height, width = scenes[0].measurement.shape
    across, side = 1 + len(titles), 1.35
    size = (side * across + 0.6, 2 * len(scenes) * (side * height / width + 0.17) + 0.2)
    figure, axes = plt.subplots(2 * len(scenes), across, figsize=size, squeeze=False)
    for scene, (above, below) in zip(scenes, axes.reshape(len(scenes), 2, across), strict=True):
        truth = scene.true_count
        limits = tuple(np.nanpercentile(truth, (1, 99))) if scene.measurement.mask.any() else (0, 1)
        brightness = np.sqrt(np.clip(np.nan_to_num(scene.frame.intensity), 0, 1))
        _tile(above[0], brightness, "gray", (0, 1), scene.frame.name)
        wraps = _tile(below[0], truth, "cividis", limits, "true wraps")
        errors = wraps
        for column, (label, title) in enumerate(titles.items(), start=1):
            _tile(above[column], scene.found_count(label), "cividis", limits, title)
            share = f"{100 * scene.right(label):.0f} % right"
            errors = _tile(below[column], scene.error(label), "magma", (0, LARGEST_ERROR), share)
        _bar(above[-1], wraps, "wraps n")
        _bar(below[-1], errors, "error δ")
    return figure


def _tile(ax, image, cmap, limits, title):  # type: ignore[no-untyped-def]
    """One picture of the grid, without a frame; NaN is grey."""
    import matplotlib as mpl

    colours = mpl.colormaps[cmap].with_extremes(bad="#E6E9EC")  # unlike any colour of the maps
    drawn = ax.imshow(image, cmap=colours, vmin=limits[0], vmax=limits[1], interpolation="nearest")
    ax.set(xticks=[], yticks=[])
    ax.set_title(title, fontsize=7, pad=2)
    ax.grid(visible=False)
    ax.spines[:].set_visible(False)
    return drawn


def _bar(ax, drawn, label):  # type: ignore[no-untyped-def]
    """Colour bar beside the last picture of a row."""
    bar = ax.figure.colorbar(drawn, cax=ax.inset_axes((1.04, 0, 0.05, 1)))
    bar.set_label(label, fontsize=7)
    bar.ax.tick_params(labelsize=7)
