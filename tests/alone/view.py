"""What the extra `view` promises: surfaces in space, as pictures (without OpenGL it says so)."""

import numpy as np

from cmtof_book.views import Layer, show_scene, still

if __name__ == "__main__":
    y, x = np.mgrid[:1:9j, :1:9j]
    points = np.dstack([x, y, x + 2])
    wall = Layer(points, x, "viridis", (0, 1), "width (m)")
    drawn = still(wall, longest=1.0, eye=(0.5, 0.5, 0.0))
    assert drawn is None or drawn.max() > 0
    show_scene("wall", title="A wall")
