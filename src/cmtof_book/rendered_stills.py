"""Still lifes of made-up things, rendered rather than scanned, on which a network learns first.

A scan takes the simulated instrument ten seconds. Rays of its spot and the law of its noise take
one, and tell the true wraps, so that there can be as many as a network needs.
"""

import numpy as np
from numpy.random import Generator, default_rng
from trimesh import Trimesh
from xarray import Dataset

from cmtof.constants import FREQUENCIES, FREQUENCY_SINGLE
from cmtof.correlation import (
    consistent_wrap_count,
    depth_from_wraps,
    phase_from_depth,
    wrap_length,
    wrapped,
)
from cmtof.hardware.plan import plan_scan
from cmtof.measurement import Measurement
from cmtof.types import Array, Complex, Fields, Numbers
from cmtof_lab.finishes import CATALOGUE
from cmtof_lab.instrument import with_noise
from cmtof_lab.objects import still_life
from cmtof_lab.optics import trace
from cmtof_lab.rehearsal import rig_of
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import MeshTarget

QUIET = TwinSettings()
MIXED = 0.3 * wrap_length(FREQUENCY_SINGLE)  # departure that mixes two surfaces, m

MADE_UP = CATALOGUE["made_up"]
SIZES = MADE_UP["sizes"]


def rendered_still(number: int, size: int) -> Measurement:
    """Noisy still life with ``wraps``, -1 where surfaces mix, and depth as ``labels``, m."""
    rng = default_rng([number, 77])
    things = [made_up_thing(rng) for _ in range(1 + number % 3)]
    phasor, true = rendered_scene(*still_life(things, rng), size, number)
    seen = with_noise(phasor, rng)
    phase = wrapped(np.angle(seen))
    wraps = consistent_wrap_count(true, phase[0], FREQUENCY_SINGLE)
    depth = depth_from_wraps(phase[0], wraps, FREQUENCY_SINGLE)
    wraps[abs(depth - true) > MIXED] = -1
    still = Measurement.from_phase(phase, FREQUENCIES, amplitude=abs(seen))
    return labelled(still.dataset, wraps, depth)


def labelled(data: Dataset, wraps: Numbers, depth: Array) -> Measurement:
    """Measurement with its wraps, -1 where unknown, and the depth that they give, m."""
    image = ("y", "x")
    return Measurement(data.assign(wraps=(image, wraps), labels=(image, depth)))


def rendered_scene(
    mesh: Trimesh, view: float, size: int, seed: int
) -> tuple[Complex, Array]:
    """Phasors (2, H, W) of a mesh, over the emitted light, and its optical range (H, W), m."""
    angle = np.rad2deg(view)
    plan = plan_scan(rig_of("", field_of_view_deg=(angle, angle)), size=size)
    paths = trace(MeshTarget.from_mesh(mesh), plan.angles.reshape(-1, 2), QUIET, seed)
    reach = QUIET.group_index * paths.range
    phase = phase_from_depth(reach, np.reshape(FREQUENCIES, (2, 1, 1)))
    phasor = (paths.fraction * np.exp(1j * phase)).sum(-1)
    return phasor.reshape(2, size, size), reach[:, 0].reshape(size, size)


def made_up_thing(rng: Generator) -> list[Fields]:
    """One to four pieces of random shapes, as ``objects.yml`` states those of its objects."""
    return [_piece(rng) for _ in range(rng.integers(1, 5))]


def _piece(rng: Generator) -> Fields:
    """A piece of a random shape, look and place."""
    piece = {
        "look": np.exp(rng.uniform(-3.2, -0.15)),
        "mirrored": rng.choice(MADE_UP["mirrored"]),
        "turn": rng.uniform(-np.pi, np.pi),
        "at": rng.uniform(*MADE_UP["at"]),
    }
    if rng.uniform() < 0.5:
        kind = rng.choice(list(SIZES))
        return piece | {kind: rng.uniform(*SIZES[kind])}
    piece["at"][2] = 0
    waves = rng.normal(0, MADE_UP["waves"], (3, 6))
    waves[:, 4] = rng.integers(0, 20, 3)
    piece |= {"body": _profile(rng), "relief": waves}
    if rng.uniform() < 0.5:
        piece["holes"] = [_opening(rng) for _ in range(rng.integers(1, 9))]
    return piece


def _profile(rng: Generator) -> Array:
    """Sections of a body from foot to top: height, half breadth, front and back, m."""
    count = rng.integers(3, 9)
    height = np.sort(rng.uniform(0, rng.uniform(0.1, 0.28), count))
    breadth = rng.uniform(0.03, 0.11) * np.exp(rng.normal(0, 0.25, count).cumsum())
    reach = breadth * np.exp(rng.normal(0, 0.2, (2, 1)))
    sides = np.clip([breadth, *reach], 0.012, 0.13)
    return np.vstack([np.transpose([height, *sides]), [height[-1] + 0.01, 0, 0, 0]])


def _opening(rng: Generator) -> tuple:
    """An opening of a body, as ``objects.yml`` states those of the helmet."""
    *middle, width, height = rng.uniform(*MADE_UP["openings"])
    half = np.exp([width, height])
    return (*middle, *half, *rng.choice([2, 4], 2), rng.normal(0, 0.2))
