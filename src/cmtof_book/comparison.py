"""Methods side by side on the same scene: the error of each (Fig. 10), and two on one image.

The script of the book's pages moves the divider of `show_swipe`, and tells of a pixel what both
methods say of it.
"""

import json
from collections.abc import Iterator, Sequence
from io import BytesIO
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cmtof.correlation import TAU, wrap_count_from_depth, wrap_length
from cmtof.measurement import Measurement
from cmtof.scenes import Frame
from cmtof.types import Array, Pair
from cmtof_book import live
from cmtof_book.plotting import grid, image
from cmtof_book.provenance import letters

WORST = 10  # wraps off, from where on an error is drawn alike


class Scene(NamedTuple):
    """One scene and the answers of methods, as `cmtof.unwrap` returns them, by label."""

    frame: Frame
    measurement: Measurement
    answers: dict[str, xr.Dataset]

    def count(self, label: str = "") -> Array:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Wraps (H, W) by one method or of the true depth, NaN where not scored."""
        depth = np.nan_to_num(self.measurement.depth).astype(float)  # pyright: ignore[reportArgumentType, reportCallIssue]
        found = (
            self.answers[label]["wrap_count"]
            if label
            else wrap_count_from_depth(depth, self.measurement.frequencies[0])
        )
        return np.where(self.measurement.mask, found, np.nan)

    def error(self, label: str) -> Array:
        """Wraps (H, W) by which a method is off, NaN where not scored."""
        return abs(self.count(label) - self.count())

    @property
    def limits(self) -> Pair:
        """Wraps between which the colours run."""
        return tuple(np.nanpercentile(self.count(), (1, 99)))

    def right(self, label: str) -> float:
        """Share of the scored pixels in the right wrap."""
        return float(np.mean(self.error(label)[self.measurement.mask] < 1))


def comparison_figure(scene: Scene, labels: Sequence[str]) -> Figure:
    """Fig. 10: brightness and true wraps of a scene, then the errors of each method."""
    height, width = scene.measurement.shape
    figure, axes = grid(2 + len(labels), 3, height / width)
    light, truth, *others = axes
    brightness = np.sqrt(np.minimum(scene.frame.intensity, 1))
    image(light, brightness, cmap="gray", title="the room", bar=False)
    image(truth, scene.count(), limits=scene.limits, title="true wraps", bar=False)
    for ax, label in zip(others, labels, strict=True):
        image(
            ax,
            scene.error(label),
            title=f"{label}: {100 * scene.right(label):.0f} %",
            cmap="magma",
            limits=(0, WORST),
            bar=False,
        )
    figure.colorbar(others[0].images[0], ax=axes[:6], label="wraps off")
    return figure


def show_swipe(scene: Scene, left: str, right: str) -> None:
    """Put the wraps by two methods on the page, left and right of a divider."""
    pictures = [*_pictures(scene, left, ""), *_pictures(scene, right, "over")]
    first, second = (
        f"<code>{label}</code> ({100 * scene.right(label):.0f} % right)"
        for label in (left, right)
    )
    wrap = 1e3 * wrap_length(scene.measurement.frequencies[0])
    live.show(
        f'<figure class="swipe" data-wrap="{wrap}" data-names=\'{json.dumps([left, right])}\'>'
        f"<div>{''.join(pictures)}{_image(_encode_wraps(scene, left, right), 'told')}"
        f'<input type="range" aria-label="Divider: {left} at its left, {right} at its right">'
        '</div><label><input type="checkbox"> errors</label> <output></output>'
        f"<figcaption>{first} at the left, {second} at the right. "
        "Move the divider with the pointer or the arrow keys. Brighter is farther, and of "
        "errors more wraps off; black is right. The line "
        "above tells of the pixel under the pointer; shift and arrow keys move it."
        "</figcaption></figure>"
    )


def _encode_wraps(scene: Scene, *labels: str) -> NDArray[np.uint8]:
    """Image (H, 2 W, 3): wraps, true and by two methods; beside them phase, confidences × 255."""
    counts = np.dstack([scene.count(), *map(scene.count, labels)])
    shares = np.dstack(
        [
            scene.measurement.phase[0] / TAU,
            *(scene.answers[label]["confidence"] for label in labels),
        ]
    )
    return np.nan_to_num(np.hstack([counts, 255 * shares])).astype(np.uint8)


def _pictures(scene: Scene, label: str, place: str) -> Iterator[str]:
    """Wraps and errors of a method as images of HTML."""
    for kind, scale, values, (low, high) in (
        ("wraps", "viridis", scene.count(label), scene.limits),
        ("errors", "magma", scene.error(label), (0, WORST)),
    ):
        yield _image(
            values,
            f"{kind} {place}",
            f"{kind.capitalize()} of {label}.",
            cmap=plt.get_cmap(scale).with_extremes(bad="0.6"),
            vmin=low,
            vmax=high,
        )


def _image(values: NDArray, kind: str, text: str = "", **look: Any) -> str:
    written = BytesIO()
    plt.imsave(written, values, **look)
    return (
        f'<img class="dark-light {kind}" alt="{text}" '
        f'src="data:image/png;base64,{letters(written.getvalue())}">'
    )
