"""Two methods on one image, with a divider that the reader moves, and their errors on demand."""

from io import BytesIO
from itertools import product

import matplotlib.pyplot as plt
import numpy as np

from cmtof_book.comparison import Scene
from cmtof_book.provenance import letters

LAYERS = {"wraps": "viridis", "errors": "magma"}
WORST = 10  # wraps off, from where on an error is drawn alike
MOVE = "this.closest('figure').style.setProperty('--at', this.value + '%')"


def show_swipe(scene: Scene, left: str, right: str) -> None:
    """Put the wraps by two methods on the page, left and right of a divider."""
    from IPython.display import HTML, display

    both = product(((left, ""), (right, "over")), LAYERS)
    pictures = [_picture(scene, label, kind, place) for (label, place), kind in both]
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
        values = scene.error(label)
        low, high = 0, WORST
    scale = plt.get_cmap(LAYERS[kind]).with_extremes(bad="0.6")
    written = BytesIO()
    plt.imsave(written, scale(np.ma.masked_invalid((values - low) / (high - low))))
    text = f"{kind.capitalize()} of {label}."
    source = f"data:image/png;base64,{letters(written.getvalue())}"
    return f'<img class="{kind} {place}" alt="{text}" src="{source}">'
