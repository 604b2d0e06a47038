"""Two methods on one image, with a divider that the reader moves, and their errors on demand."""

from base64 import b64encode
from io import BytesIO

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from cmtof_book.comparison import Scene

LAYERS = {"wraps": "viridis", "errors": "magma"}
WORST = 10  # wraps off, from where on an error is drawn alike
MOVE = "this.closest('figure').style.setProperty('--at', this.value + '%')"


def show_swipe(scene: Scene, left: str, right: str) -> None:
    """Put the wraps by two methods on the page, left and right of a divider."""
    from IPython.display import HTML, display

    pictures = [_picture(scene, left, kind, "") for kind in LAYERS]
    pictures += [_picture(scene, right, kind, "over") for kind in LAYERS]
    sides = f"{_share(scene, left)} at the left, {_share(scene, right)} at the right"
    display(
        HTML(
            f'<figure class="swipe" style="--at:50%"><div>{"".join(pictures)}'
            f'<input type="range" aria-label="Divider: {left} at its left, {right} at its right" '
            f'oninput="{MOVE}"></div><label><input type="checkbox"> errors</label>'
            f"<figcaption>{sides}; the divider moves by pointer and by arrow keys.</figcaption>"
            "</figure>"
        )
    )


def _share(scene: Scene, label: str) -> str:
    return f"<code>{label}</code> ({100 * scene.right(label):.0f} % right)"


def _picture(scene: Scene, label: str, kind: str, place: str) -> str:
    """Map of a method as an image of HTML."""
    values = scene.count(label)
    low, high = scene.limits
    if kind == "errors":
        values = np.abs(values - scene.count())
        low, high = 0, WORST
    source = b64encode(_png(values, low, high, LAYERS[kind])).decode()
    text = f"{kind.capitalize()} of {label}."
    return f'<img class="{kind} {place}" alt="{text}" src="data:image/png;base64,{source}">'


def _png(values: NDArray[np.floating], low: float, high: float, colours: str) -> bytes:
    """PNG of an image; grey where it is NaN."""
    written = BytesIO()
    scale = plt.get_cmap(colours).with_extremes(bad="0.6")
    shown = scale(np.ma.masked_invalid((values - low) / (high - low)))
    plt.imsave(written, shown)
    return written.getvalue()
