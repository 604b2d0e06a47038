"""Plans, sums and calibration: pure functions."""

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx, mark

from cmtof.correlation import phase_from_depth
from cmtof.hardware.plan import plan_scan
from cmtof.hardware.reduction import (
    calibrate,
    nominal_psi,
    sums_from_counts,
)
from cmtof.hardware.rig import Rig

RIG = Rig.default()
PLAN = plan_scan(RIG, size=4)


def test_every_burst_has_its_own_label():
    labels = [label for line in PLAN.lines for label in line.labels]
    assert labels == list(range(1, len(labels) + 1))
    kinds = [line.kind for line in PLAN.lines if line.mode == "single"]
    assert kinds == ["dark", *8 * ["reference"], *4 * ["scan"], *8 * ["reference"]]


def test_rays_are_those_of_a_pinhole():
    width = 2 * np.tan(np.deg2rad(10))
    slopes = np.tan(plan_scan(RIG, size=(3, 5)).angles)
    assert_allclose(np.diff(slopes[..., 0], axis=1), width / 5)
    assert slopes[0, 0, 1] == approx(-width / 3)


def test_sums_drop_the_settling_samples_and_count_what_clips():
    counts = np.arange(320).reshape(16, 20)
    counts[3, 5] = 0
    counts[4, 19] = 65535
    counts[5, 0] = 65535
    sums, clipped = sums_from_counts(counts.reshape(1, -1), [3, *15 * [16]])
    assert sums[0, 0] == counts[0, 17:].sum()
    assert sums[0, 3] == counts[3, 4:].sum()
    assert clipped.tolist() == [2]


@mark.parametrize("stray", [0.0, 0.3])
def test_calibration_finds_the_offset_behind_stray_light(stray):
    z = 0.6 + 299792458 / (2 * 7.15e9) * np.arange(8) / 8
    psi = nominal_psi(16)
    seen = (
        3
        + np.cos(phase_from_depth(z, 7.15e9)[:, None] + psi - 1.2)
        + stray * np.cos(psi)
    )
    offset, drift = calibrate(np.stack([seen, seen]), z, 7.15e9)
    assert offset == approx(-1.2, abs=1e-6 + 0.02 * stray)
    assert drift == approx(0, abs=1e-9)
