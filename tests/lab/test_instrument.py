"""Bursts of the whole instrument: modulators, drives, drift and noise against closed forms."""

import json
from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx, mark

from cmtof.correlation import centred, decode, phase_from_depth
from cmtof.hardware.reduction import nominal_psi
from cmtof_book import ROOT
from cmtof_lab.electronics import volts_from_counts
from cmtof_lab.instrument import (
    BURST_INTERVAL,
    DRIFT_RMS,
    SimulatedInstrument,
    drift,
)
from cmtof_lab.optical_ranging import OpticalRanger
from cmtof_lab.settings import CAPTURES, NOISE, TwinSettings
from cmtof_lab.sweep import FREQUENCY
from cmtof_lab.targets import Plane

IDEAL = TwinSettings.ideal()
EDGES = np.arange(320) // 20
PSI = nominal_psi(16)


def profile(instrument, mode, labels=(1,), **knobs):
    """Mean volts (N, 16) of the phases of bursts of the scene, behind the settling samples."""
    panel = replace(OpticalRanger(mode=mode).panel(), target_in_beam=False, **knobs)
    angles = np.zeros((len(labels), 2))
    counts = instrument.bursts(panel, angles, labels=np.array(labels), pulses=EDGES)
    return volts_from_counts(counts.reshape(-1, 16, 20)[..., 8:].mean(-1))


def decode_plane(settings, z, mode):
    """Decoded burst of a plane at a distance, m."""
    return decode(profile(SimulatedInstrument(settings, Plane(z)), mode)[0], PSI)


@mark.parametrize("mode, frequency", FREQUENCY.items())
def test_phase_grows_with_the_range_and_with_air(mode, frequency):
    slow = replace(IDEAL, pressure=101325.0)
    near = decode_plane(IDEAL, 0.6, mode).phase
    for settings, z, longer in (
        (IDEAL, 0.601, 1e-3),
        (IDEAL, 0.612, 12e-3),
        (slow, 0.6, 0.6 * (slow.group_index - 1)),
    ):
        turned = decode_plane(settings, z, mode).phase - near
        assert abs(centred(turned - phase_from_depth(longer, frequency))) < 3e-3


def test_light_and_modulation_need_their_switches():
    instrument = SimulatedInstrument(IDEAL, Plane(0.6))
    for knob in ("laser_on", "shutter_open", "interlock_closed"):
        assert not profile(instrument, "single", **{knob: False}).round(3).any()
    seen = profile(instrument, "single", clock_on=False)
    assert np.ptp(seen) < 1e-3 < seen.mean()


def test_drift_is_bounded_with_its_rms_and_follows_the_labels():
    long = drift(0, 1, np.linspace(0, 36000, 200001))
    assert abs(long).max() <= 1
    assert long.std() == approx(DRIFT_RMS, rel=0.05)
    drifting = replace(IDEAL, phase_drift=0.1)
    labels = np.array([1, 2000, 40000])
    instrument = SimulatedInstrument(drifting, Plane(0.6), seed=2)
    times = BURST_INTERVAL * labels + EDGES.size / 24000 / 2
    lag = 0.1 / DRIFT_RMS * drift(2, 1, times)
    phases = decode(profile(instrument, "single", labels).T, PSI).phase
    assert_allclose(centred(np.diff(phases + lag)), 0, atol=5e-3)


# --- the noise of the published captures


def test_captures_noise_is_what_chapter_7_found():
    text = (ROOT / "figures" / "noise_matching_spectra.json").read_text("utf-8")
    found = json.loads(text)["numbers"]["line_noise"]
    for name, (level, correlation) in CAPTURES.items():
        assert level == round(found[name]["white"], 3)
        assert correlation == round(found[name]["down"], 2)
    assert NOISE["captures"]["phase_noise"][0] == approx(0.117, abs=1e-3)


@mark.parametrize("mode", FREQUENCY)
def test_disturbance_has_its_level_and_grain(mode):
    """2000 points tell a deviation to 1.6 % and a correlation to 0.022; four of these."""
    instrument = SimulatedInstrument(
        replace(IDEAL, **NOISE["captures"]), Plane(0.8), seed=1
    )
    seen = decode(profile(instrument, mode, range(1, 2001)).T, PSI).phase
    error = centred(seen - np.angle(np.exp(1j * seen).mean()))
    assert error.std() == approx(NOISE["captures"]["phase_noise"][0], rel=0.08)
    correlations = [np.corrcoef(error[:-lag], error[lag:])[0, 1] for lag in (1, 2)]
    assert_allclose(correlations, [NOISE["captures"]["grain"], 0], atol=0.09)
