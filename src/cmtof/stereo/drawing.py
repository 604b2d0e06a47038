"""Picture of the rig before its scene (Fig. 9a), drawn to scale from their numbers."""

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from cmtof.book.plotting import PALETTE
from cmtof.pointcloud import points_from_depth
from cmtof.scenes.frame import Frame
from cmtof.stereo.camera import PinholeCamera
from cmtof.stereo.pose import Pose
from cmtof.stereo.rig import StereoRig

Array = NDArray[np.floating]

COLOURS = (PALETTE["blue"], PALETTE["vermillion"])
"""Of the left and the right camera."""

BEAM = "#00A86B"  # what 532 nm looks like, darkened to be seen on white


def draw_rig(
    ax: Axes,
    frame: Frame,
    rig: StereoRig,
    spot: tuple[int, int],
    *,
    viewpoint: ArrayLike = (-0.9, -0.75, -0.55),
) -> None:
    """Draw scene, scanner, beam and both cameras in perspective.

    Parameters
    ----------
    ax : Axes
    frame : Frame
        With a camera; drawn as points in its brightness.
    rig : StereoRig
    spot : (int, int)
        Row and column of the pixel that the beam points at.
    viewpoint : array_like, shape (3,)
        From where it is seen, in median depths of the scene: x right, y down, z forward.
    """
    points = points_from_depth(frame.depth, frame.camera if frame.camera is not None else ())
    far = float(np.nanmedian(points[..., 2]))
    pose = Pose.looking(far * np.asarray(viewpoint, float), (0, 0, 0.55 * far))
    lens = PinholeCamera(np.array([1, 1, 0, 0, 0, 0, 0, 0, 0.0]), (1, 1))

    def seen(places: ArrayLike) -> Array:
        return lens.project(pose.apply(places))

    _draw_points(ax, points, frame.intensity, pose, seen)
    centres, target = rig.centres(), points[spot]
    ax.plot(*seen([centres[2], target]).T, color=BEAM, lw=2.2, zorder=4)
    for centre, colour, name in zip(centres[:2], COLOURS, ("left", "right"), strict=True):
        ax.plot(*seen([target, centre]).T, color=colour, lw=1.2, ls="--", zorder=5)
        _name(ax, name, seen(centre), colour)
    ax.plot(*seen(centres[:2]).T, color="0.35", lw=2.5, zorder=3)
    for outline, colour in zip(_bodies(rig, 0.09 * far), COLOURS, strict=True):
        ax.plot(*seen(outline).T, color=colour, lw=1.3, zorder=6)
    x, y = seen(centres[2])
    ax.plot(x, y, "s", color="0.2", ms=6, zorder=6)
    _name(ax, "scanner", seen(centres[2]), "0.2")
    ax.plot(*seen(target), "o", color=BEAM, mec="white", ms=7, zorder=7)
    ax.set_aspect("equal")
    ax.invert_yaxis()
    ax.axis("off")


def _name(ax: Axes, name: str, place: Array, colour: str) -> None:
    ax.annotate(name, tuple(place), (7, -9), textcoords="offset points", color=colour, va="center")


def _draw_points(ax: Axes, points: Array, light: Array, pose: Pose, seen) -> None:
    """Points of the scene, the far ones first."""
    known = np.isfinite(points).all(axis=-1)
    order = np.argsort(-pose.apply(points[known])[:, 2])
    grey = 0.35 + 0.6 * np.clip(light[known][order], 0, 1) ** (1 / 2.2)
    x, y = seen(points[known][order]).T
    ax.scatter(x, y, c=grey, s=3, cmap="gray", vmin=0, vmax=1, lw=0, rasterized=True, zorder=1)


def _bodies(rig: StereoRig, length: float) -> list[Array]:
    """Pyramids of what both cameras see, as one line each, in the scanner's frame."""
    outlines = []
    for camera, pose in ((rig.left, Pose.none()), (rig.right, rig.right_from_left)):
        height, width = camera.shape
        corners = [[0, 0], [width, 0], [width, height], [0, height]]
        rim = length * camera.rays(np.array(corners, float))
        apex = np.zeros(3)
        path = [apex, rim[0], rim[1], apex, rim[2], rim[3], apex, rim[0], rim[3], rim[2], rim[1]]
        outlines.append(rig.scanner_from_left.apply(pose.inverse.apply(np.array(path))))
    return outlines
