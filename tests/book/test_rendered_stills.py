"""Rendered still lifes: the phases of a scan, and the noise of the captures."""

import numpy as np
import pytest
from numpy.random import default_rng
from pytest import approx

pytest.importorskip("embreex")

from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, centred, phase_from_depth
from cmtof_book.rendered_stills import (
    made_up_thing,
    rendered_scene,
    rendered_still,
)
from cmtof_lab.budget import ideal_but_for
from cmtof_lab.instrument import with_noise
from cmtof_lab.objects import still_life
from cmtof_lab.rehearsal import scan_scene
from cmtof_lab.settings import NOISE
from cmtof_lab.targets import MeshTarget


def test_a_rendered_scene_has_phases_and_range_of_a_scan_without_noise():
    rng = default_rng(4)
    mesh, view = still_life([made_up_thing(rng), made_up_thing(rng)], rng)
    phasor, reach = rendered_scene(mesh, view, 12, seed=3)
    settings = ideal_but_for("divergence", "exit_radius", "pressure", "speckle")
    target = MeshTarget.from_mesh(mesh)
    scan = scan_scene(settings, target, size=12, field_of_view=view, seed=3)
    # the mirrors' steps move the beam, on slopes by some micrometres
    off = centred(np.angle(phasor) - scan.phase)
    assert np.median(abs(off)) < 0.03
    assert abs(np.median(off, axis=(1, 2))).max() < 0.01
    assert reach == approx(scan.depth)


def test_the_noise_is_that_of_the_captures_and_shared_by_neighbours():
    turn = np.angle(with_noise(np.full((2, 300, 300), 1e-3 + 0j), default_rng(1)))
    # five deviations of 90,000 correlated pixels
    assert turn.std((1, 2)) == approx(NOISE["captures"]["phase_noise"], rel=5 / 400)
    both = (turn[..., 1:] * turn[..., :-1]).mean((1, 2)) / turn.var((1, 2))
    assert both == approx([NOISE["captures"]["grain"]] * 2, abs=5 / 300)


def test_labels_are_the_wraps_that_turn_phases_into_ranges():
    still = rendered_still(1, 24)
    wraps, depth = (still.dataset[key].to_numpy() for key in ("wraps", "labels"))
    known = wraps >= 0
    assert known.mean() > 0.9
    turns = (phase_from_depth(depth, FREQUENCIES[0]) - still.phase[0]) / TAU
    assert turns[known] == approx(wraps[known])
