"""Two methods on one image, with a divider that the reader moves, and their errors on demand.

The script of the book's pages moves the divider, and tells of a pixel what both methods say of it.
"""

import json
from collections.abc import Iterator
from io import BytesIO
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from cmtof.correlation import TAU, wrap_length
from cmtof_book import live
from cmtof_book.comparison import Scene
from cmtof_book.provenance import letters

WORST = 10  # wraps off, from where on an error is drawn alike


def show_swipe(scene: Scene, left: str, right: str) -> None:
    """Put the wraps by two methods on the page, left and right of a divider."""
    pictures = [*_pictures(scene, left, ""), *_pictures(scene, right, "over")]
    sides = f"{_share(scene, left)} at the left, {_share(scene, right)} at the right"
    wrap = 1e3 * wrap_length(scene.measurement.frequencies[0])
    live.show(
        f'<figure class="swipe" data-wrap="{wrap}" data-names=\'{json.dumps([left, right])}\'>'
        f"<div>{''.join(pictures)}{_image(_told(scene, left, right), 'told')}"
        f'<input type="range" aria-label="Divider: {left} at its left, {right} at its right">'
        '</div><label><input type="checkbox"> errors</label> <output></output>'
        f"<figcaption>{sides}. Move the divider with the pointer or the arrow keys. The line "
        "above tells of the pixel under the pointer; shift and arrow keys move it."
        "</figcaption></figure>"
    )


def _share(scene: Scene, label: str) -> str:
    return f"<code>{label}</code> ({100 * scene.right(label):.0f} % right)"


def _told(scene: Scene, *labels: str) -> NDArray[np.uint8]:
    """True wraps and those by two methods, beside them phase and odds, 255 for one, as colours."""
    counts = np.dstack([scene.count(), *map(scene.count, labels)])
    odds = [scene.answers[label]["confidence"] for label in labels]
    shares = np.dstack([scene.measurement.phase[0] / TAU, *odds])
    return np.nan_to_num(np.hstack([counts, 255 * shares])).astype(np.uint8)


def _pictures(scene: Scene, label: str, place: str) -> Iterator[str]:
    """Wraps and errors of a method as images of HTML."""
    wraps = "wraps", "viridis", scene.count(label), scene.limits
    errors = "errors", "magma", scene.error(label), (0, WORST)
    for kind, scale, values, (low, high) in (wraps, errors):
        colours = plt.get_cmap(scale).with_extremes(bad="0.6")
        text = f"{kind.capitalize()} of {label}."
        yield _image(values, f"{kind} {place}", text, cmap=colours, vmin=low, vmax=high)


def _image(values: NDArray, kind: str, text: str = "", **look: Any) -> str:
    written = BytesIO()
    plt.imsave(written, values, **look)
    source = f"data:image/png;base64,{letters(written.getvalue())}"
    return f'<img class="dark-light {kind}" alt="{text}" src="{source}">'
