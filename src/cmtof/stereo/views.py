"""What two cameras see of a scan (simulated): spots on a frame's surfaces, hidden or not, in noise.

A frame is seen from the scanner, so its depth says what stands before what only from there. Behind
each surface it is taken for solid: a spot counts as hidden from a camera wherever the line between
both passes behind anything that the scanner sees.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.pointcloud import normals_from_points, points_from_depth
from cmtof.scenes.frame import Frame
from cmtof.stereo.rig import StereoRig
from cmtof.stereo.sensor import LASER_POWER, OFFSET, Sensor, gaussian_spot
from cmtof.stereo.spot import CHUNK, WINDOW, Spots, Status, fit_spots

Array = NDArray[np.floating]


@dataclass(frozen=True)
class Lighting:
    """How spots are made and recorded.

    Attributes
    ----------
    power : float
        Of the beam, W (Sec. 7.1).
    beam : float
        Standard deviation of the spot on a surface across the beam, m: the paper defocuses it
        slightly, without a number (Sec. 7.1); this one is ours.
    blur : float
        Standard deviation of the lens's blur, px.
    exposure : float or None
        s; by default such that the 99th percentile of spots peaks at 70 % of the full well.
    ambient : float
        Electrons in a green pixel from other light: a dark laboratory.
    contrast : float
        Of the speckle; 1 / sqrt 2 for a diffuse surface that depolarises.
    """

    power: float = LASER_POWER
    beam: float = 0.6e-3
    blur: float = 0.8
    exposure: float | None = None
    ambient: float = 5.0
    contrast: float = float(np.sqrt(0.5))


@dataclass(frozen=True, eq=False)
class Scene:
    """A frame as both cameras see it, before any noise; arrays (2, H, W) for left and right.

    Attributes
    ----------
    points : ndarray, shape (H, W, 3)
        In the scanner's frame, m.
    pixels : ndarray, shape (2, H, W, 2)
        Where spots lie in the images.
    inside, visible : ndarray of bool
        Whether in the image; whether nothing stands before it.
    brightness, width : ndarray
        Electrons of a spot as green pixels have them; standard deviation, px.
    """

    points: Array
    pixels: Array
    inside: NDArray[np.bool_]
    visible: NDArray[np.bool_]
    brightness: Array
    width: Array
    sensor: Sensor = field(default_factory=Sensor)
    lighting: Lighting = field(default_factory=Lighting)

    @property
    def lit(self) -> NDArray[np.bool_]:
        """Where light comes back to the scanner, (H, W)."""
        return np.asarray(np.isfinite(self.points).all(axis=-1))


def visible_from(
    depth: ArrayLike, camera: ArrayLike, centre: ArrayLike, *, slack: float = 2e-3
) -> NDArray[np.bool_]:
    """Pixels (H, W) of a frame whose point is not hidden from a place.

    The line from a point to the place is followed from pixel to pixel of the frame. Inverse planar
    depth is linear along a line and over a plane alike, so that no plane hides itself.

    Parameters
    ----------
    depth : array_like, shape (H, W)
        Range along the ray, m; NaN hides nothing, and is not visible.
    camera : array_like, shape (4,) or (5,)
        fx, fy, cx, cy, px, of the frame.
    centre : array_like, shape (3,)
        The place in the frame's axes, m.
    slack : float
        Share of the distance by which something must stand before the line.

    Raises
    ------
    ValueError
        If the place does not lie before all that is seen.
    """
    from scipy.ndimage import map_coordinates

    points = points_from_depth(depth, camera)
    centre = np.asarray(centre, float)
    known = np.isfinite(points).all(axis=-1)
    near = float(points[known][:, 2].min())
    if centre[2] > 0.9 * near:
        raise ValueError(
            f"Expected a camera before the nearest surface at {near:.2f} m, got one "
            f"{centre[2]:.2f} m ahead of the scanner. Move it back, or the scene away."
        )
    inverse = np.where(known, 1 / np.where(known, points[..., 2], 1.0), 0.0)
    fx, fy, cx, cy, *skew = np.asarray(camera, float)
    # the farthest that a line runs over the image before it is nearer than everything
    reach = np.abs(centre[:2] * [fx, fy]).max() * (1 / near) * 2 + 2
    hidden = np.zeros(known.shape, bool)
    target = 1.05 * inverse.max()
    count = int(2 * reach) + 2
    start = np.where(known, inverse, 1.0)
    for share in np.linspace(0, 1, count + 1)[1:]:
        level = start + share * np.maximum(target - start, 0)
        # z falls from the point's to 1 / level on the way to the centre
        along = (points[..., 2] - 1 / level) / (points[..., 2] - centre[2])
        place = points + along[..., None] * (centre - points)
        y = place[..., 1] / place[..., 2]
        u = fx * place[..., 0] / place[..., 2] + sum(skew) * y + cx - 0.5
        v = fy * y + cy - 0.5
        at = np.stack([np.where(known, v, -9), np.where(known, u, -9)])
        surface = map_coordinates(inverse, at, order=1, mode="constant", cval=0.0)
        hidden |= surface > level * (1 + slack)
    return known & ~hidden


def view_scene(
    frame: Frame,
    rig: StereoRig,
    *,
    sensor: Sensor | None = None,
    lighting: Lighting | None = None,
) -> Scene:
    """Where both cameras see the spot of every pixel of a frame, how bright and how large.

    Parameters
    ----------
    frame : Frame
        With a camera; its intensity is taken for the reflectance.
    rig : StereoRig
        As it really is.
    sensor : Sensor, optional
    lighting : Lighting, optional

    Raises
    ------
    ValueError
        If the frame has no camera, or a camera of the rig stands within the scene.
    """
    if frame.camera is None:
        raise ValueError(
            f"Expected a frame with a camera, got none in {frame.name or 'the frame'}. State fx, "
            "fy, cx, cy."
        )
    sensor, lighting = sensor or Sensor(), lighting or Lighting()
    points = points_from_depth(frame.depth, frame.camera)
    normals = normals_from_points(points)
    pixels = np.stack(rig.project(points))
    inside = np.stack(
        [one.sees(at, WINDOW) for one, at in zip((rig.left, rig.right), pixels, strict=True)]
    )
    centres = rig.centres()[:2]
    visible = np.stack([visible_from(frame.depth, frame.camera, one) for one in centres])
    away = centres[:, None, None] - points
    distance = np.linalg.norm(away, axis=-1)
    cosine = np.clip(np.sum(normals * away, -1) / distance, 0.02, 1.0)
    reflectance = np.clip(frame.intensity, 0, 1)
    rate = sensor.flux(reflectance, distance, cosine, lighting.power)
    focal = np.array([rig.left.intrinsics[0], rig.right.intrinsics[0]])[:, None, None]
    width = np.hypot(lighting.blur, lighting.beam * focal / distance)
    exposure = lighting.exposure or _exposure(rate, width, inside & visible, sensor)
    return Scene(points, pixels, inside, visible, rate * exposure, width, sensor, lighting)


def _exposure(rate: Array, width: Array, seen: NDArray[np.bool_], sensor: Sensor) -> float:
    """Exposure at which the brightest hundredth of spots peaks above 70 % of the full well, s."""
    peaks = (rate / (2 * np.pi * width**2))[seen & np.isfinite(rate)]
    if peaks.size == 0:
        return 1e-3
    return float(0.7 * sensor.full_well / max(np.percentile(peaks, 99), 1e-30))


def record(
    scene: Scene, *, rng: np.random.Generator, noise_free: bool = False
) -> tuple[Spots, Spots]:
    """Record and find every spot of a scan in both cameras: shot, read noise and speckle.

    Of each image only the window about the spot is drawn. A hidden spot leaves its window dark.

    Parameters
    ----------
    scene : Scene
    rng : Generator
    noise_free : bool
        Return the true places, where they can be seen, with the covariance of noise.

    Returns
    -------
    left, right : Spots
    """
    left, right = (_record(scene, camera, rng, noise_free) for camera in (0, 1))
    return left, right


def _record(scene: Scene, camera: int, rng: np.random.Generator, noise_free: bool) -> Spots:
    shape = scene.lit.shape
    looked = scene.inside[camera] & scene.lit
    at, width = scene.pixels[camera][looked], scene.width[camera][looked]
    bright = np.where(scene.visible[camera], scene.brightness[camera], 0.0)[looked]
    found = [
        _chunk(
            at[i : i + CHUNK], width[i : i + CHUNK], bright[i : i + CHUNK], scene, rng, noise_free
        )
        for i in range(0, len(at), CHUNK)
    ]
    spots = Spots(
        np.full((*shape, 2), np.nan),
        np.full((*shape, 2, 2), np.nan),
        np.full(shape, np.nan),
        np.full(shape, np.nan),
        np.full(shape, Status.OUTSIDE, np.int8),
    )
    for whole, parts in zip(spots, zip(*found, strict=True), strict=False):
        whole[looked] = np.concatenate(parts)
    return spots


def _chunk(
    at: Array, width: Array, bright: Array, scene: Scene, rng: np.random.Generator, noise_free: bool
) -> Spots:
    """Some of the spots: draw their windows and fit them."""
    sensor, lighting = scene.sensor, scene.lighting
    speckle = sensor.speckle(lighting.contrast)
    # windows lie on whole pixels, where a first look at the image would put them
    corners = np.floor(at).astype(int) - WINDOW // 2
    moved = at if noise_free else at + speckle * rng.standard_normal(at.shape)
    response = sensor.response(corners, WINDOW)
    share = gaussian_spot(WINDOW, moved - corners, width)[0]
    mean = response * (bright[:, None, None] * share + lighting.ambient)
    dark = response * lighting.ambient / sensor.gain + OFFSET
    counts = mean / sensor.gain + OFFSET if noise_free else sensor.counts(mean, rng)
    return fit_spots(
        counts,
        sensor,
        corners=corners,
        background=dark,
        ground=lighting.ambient,
        speckle=speckle,
    )
