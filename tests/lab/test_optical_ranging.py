"""The all-optical range finder: counts of a scan, noise at its bound, errors by closed forms."""

import numpy as np
from numpy.testing import assert_array_equal
from pytest import approx, mark

from cmtof.correlation import TAU, wrap_length
from cmtof_lab.budget import back_ratio, ideal_but_for
from cmtof_lab.electronics import volts_from_counts
from cmtof_lab.instrument import BURST_INTERVAL, SimulatedInstrument
from cmtof_lab.optical_ranging import OpticalRanger
from cmtof_lab.rehearsal import scan_scene
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import MIRROR, PLATE, Plane

STEPS = np.linspace(0, 1e-3, 5)
STILL = {"stage_error": 0.0, "air_change": (0.0, 0.0)}


@mark.parametrize("mode", ["single", "doubled"])
def test_counts_are_those_of_a_scan(mode):
    """A plane in the scene and the target on the stage, at one moment of one seed."""
    settings = TwinSettings(speckle=False)
    scan = scan_scene(settings, Plane(0.6), size=1, field_of_view=0.01, seed=5).dataset
    ranger = OpticalRanger(settings, mode)
    row = int(mode == "doubled")
    bursts = scan["time"].data[row, 0] / BURST_INTERVAL
    instrument = SimulatedInstrument(ranger.before(PLATE), seed=5)
    counts = ranger.counts(instrument, np.zeros(1), np.rint(bursts).astype(int))
    means = counts.reshape(16, 20)[:, 4:].mean(-1)
    # a scan drops more of the first phase, in which the mirrors may still move
    assert_array_equal(means[1:], scan["raw_counts"][row, 1:, 0, 0])


@mark.parametrize("mode, target", [("single", PLATE), ("doubled", MIRROR)])
def test_noise_alone_meets_the_bound(mode, target):
    """5000 estimates and the zeros of 50 days fix a standard deviation to 1.5 %."""
    ranger = OpticalRanger(TwinSettings.ideal(noise=True), mode, visits=8, **STILL)
    places = np.linspace(0, 1e-3, 100)
    errors = ranger.sweep(target, places, repeats=50, seed=2) - 0.6 - places
    pulls = errors / ranger.bound(target, places)
    assert np.sqrt((pulls**2).mean()) == approx(1, abs=0.045)


@mark.parametrize("mode, most", [("single", 1e-6), ("doubled", 3e-6)])
def test_without_errors_the_range_is_right(mode, most):
    """Of a plate's light the doubled mode leaves 280 counts of amplitude, and they are rounded."""
    ranger = OpticalRanger(
        TwinSettings.ideal(pressure=101325.0), mode, visits=8, **STILL
    )
    assert abs(ranger.sweep(PLATE, STEPS, repeats=1, seed=0) - 0.6 - STEPS).max() < most


def test_coaxial_light_makes_a_cyclic_error():
    """To first order its share of the light, as a phase, at the crest of a wrap."""
    ranger = OpticalRanger(ideal_but_for("back_fraction"), **STILL)
    places = np.linspace(0, wrap_length(ranger.frequency), 24, endpoint=False)
    errors = ranger.sweep(PLATE, places, repeats=1, seed=0)[0] - 0.6 - places
    crest = back_ratio(TwinSettings(), PLATE) * wrap_length(ranger.frequency) / TAU
    turn = np.exp(1j * TAU * places / wrap_length(ranger.frequency))
    assert 2 * abs((errors * turn).mean()) == approx(crest, rel=0.15)


def test_the_grey_filter_keeps_a_mirror_within_range():
    ranger = OpticalRanger(TwinSettings.ideal(), "doubled")
    counts = ranger.counts(
        SimulatedInstrument(ranger.before(MIRROR)),
        np.linspace(0, 0.02, 30),
        np.arange(30),
    )
    assert volts_from_counts(counts).max() == approx(0.5 * 4.1, rel=0.03)
    assert ranger.before(MIRROR).efficiency < 1e-3 * TwinSettings().efficiency
    assert ranger.before(PLATE).efficiency == TwinSettings().efficiency
