"""What the extra `view` promises: surfaces in space, as pictures (without OpenGL it says so)."""

import numpy as np

from cmtof_book.views import show_scene, still

if __name__ == "__main__":
    y, x = np.mgrid[:1:9j, :1:9j]
    drawn = still(np.dstack([x, y, x + 2]), np.dstack([x, y, x]), longest=1.0, eye=(0.5, 0.5, 0.0))
    assert drawn is None or drawn.max() > 0
    show_scene("wall", title="A wall")
