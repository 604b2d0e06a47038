"""Votes of single pixels: where they decide, where they must not, and what they get right."""

import numpy as np
import pytest

import cmtof
from cmtof.bounds import wrap_noise
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame, ray_lengths
from cmtof.surfaces import unwrapping
from cmtof.surfaces.field import field_from_measurement
from cmtof.surfaces.unwrapping import stages
from cmtof.surfaces.votes import DOUBT, Votes, voted, wrap_doubt

SIDE = 96


def pebbles(seed=0):
    """Spheres of a few pixels before a wall: too small for surfaces of cells."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:SIDE, :SIDE]
    camera = np.array([130.0, 130.0, SIDE / 2, SIDE / 2])
    depth = 1.15 * ray_lengths((SIDE, SIDE), camera)
    for _ in range(40):
        radius = rng.uniform(4, 7)
        v, u = rng.uniform(8, SIDE - 8, 2)
        height = radius**2 - (y - v) ** 2 - (x - u) ** 2
        front = rng.uniform(0.85, 1.05) - 1e-3 * np.sqrt(np.maximum(height, 0))
        depth = np.where(height > 0, np.minimum(depth, front), depth)
    return Frame(depth=depth, intensity=np.full(depth.shape, 0.8), camera=camera)


def measured(sigma, seed=0):
    return cmtof.simulate(pebbles(), protocol="full", noise=sigma, seed=seed)


def truth_of(measurement):
    assert measurement.depth is not None
    return measurement.depth.astype(float)


def test_doubt_is_the_spread_of_a_single_wrap_count():
    measurement = measured(60.0)
    field = field_from_measurement(measurement)
    low, high = (1 / np.sqrt(field.information[f].astype(float)) for f in (0, 1))
    foretold = wrap_noise(low, high, frequencies=tuple(measurement.frequencies))
    np.testing.assert_allclose(wrap_doubt(field), foretold, rtol=1e-6)


def test_nobody_votes_in_the_noise_of_the_paper():
    assert not stages(measured(1200.0)).votes.share.any()


def silent(field, depth, explained):
    return Votes(np.full(depth.shape, np.nan), np.zeros(depth.shape))


@pytest.mark.parametrize("sigma", [0.0, 40.0])
def test_votes_find_what_surfaces_miss(sigma, monkeypatch):
    """Small bodies at low noise: with surfaces alone their neighbours' wraps would be taken."""
    measurement = measured(sigma)
    truth = truth_of(measurement)
    asked = (stages(measurement).votes.share > 0)[:SIDE, :SIDE]
    assert 0.2 < asked.mean() < 0.5
    right = {}
    for name, how in (("votes", voted), ("none", silent)):
        monkeypatch.setattr(unwrapping, "voted", how)
        found = stages(measurement)
        off = np.abs(found.depth[:SIDE, :SIDE] - truth)[asked] / found.field.period
        right[name] = (off < 0.5).mean()
    assert right["votes"] > 0.65
    assert right["votes"] > right["none"] + 0.25


def test_votes_do_not_depend_on_the_images_orientation():
    """Away from ties, which the order of pixels may break."""
    measurement = measured(40.0)
    turned = Measurement.from_arrays(
        measurement.dataset["correlation"].to_numpy().swapaxes(2, 3),
        measurement.dataset["psi"].to_numpy(),
        measurement.frequencies,
    )
    nothing = np.zeros((SIDE, SIDE), bool), np.full((SIDE, SIDE), np.nan)
    straight, other = (
        voted(field_from_measurement(one)._replace(limits=(0.5, 1.5)), nothing[1], nothing[0])
        for one in (measurement, turned)
    )
    same = np.abs(straight.depth - other.depth.T) < 1e-6
    decided = straight.share > 0
    assert decided.mean() > 0.5
    assert same[decided].mean() > 0.999


def test_a_pixel_on_a_surface_that_fits_is_left_alone():
    measurement = measured(40.0)
    field = field_from_measurement(measurement)
    everywhere = np.ones((SIDE, SIDE), bool)
    found = voted(field, truth_of(measurement), everywhere)
    assert (wrap_doubt(field) < DOUBT).all()
    assert (found.share > 0).mean() < 0.02
