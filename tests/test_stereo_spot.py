"""Laser spots: what a camera makes of them, how well they are placed, and when they are refused."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.stereo.sensor import OFFSET, Sensor, gaussian_spot, speckled_centroids
from cmtof.stereo.spot import WINDOW, Status, find_spot, fit_spots, spot_bound

SENSOR = Sensor()
AMBIENT = 5.0


def windows(rng, *, brightness, width=1.1, count=1500, ambient=AMBIENT, sensor=SENSOR):
    """Noisy windows (N, S, S), their true places in them, and their corners in the image."""
    corners = rng.integers(0, 2, (count, 2)) + 100
    places = WINDOW / 2 + rng.uniform(-0.5, 0.5, (count, 2))
    share = gaussian_spot(WINDOW, places, np.full(count, width))[0]
    mean = sensor.response(corners, WINDOW) * (brightness * share + ambient)
    return sensor.counts(mean, rng), places, corners


def fitted(counts, corners, sensor=SENSOR, ambient=AMBIENT, **options):
    dark = sensor.response(corners, WINDOW) * ambient / sensor.gain + OFFSET
    return fit_spots(counts, sensor, corners=corners, background=dark, ground=ambient, **options)


# --- sensor ------------------------------------------------------------------------------------


def test_a_spot_shares_its_light_among_pixels():
    share, by_x, by_y, by_width = gaussian_spot(21, [10.3, 9.8], 1.4)
    assert share.sum() == pytest.approx(1, abs=1e-9)
    centre = np.arange(21) + 0.5
    assert share.sum(0) @ centre == pytest.approx(10.3, abs=1e-6)
    assert share.sum(1) @ centre == pytest.approx(9.8, abs=1e-6)
    step = 1e-5
    for slope, (dx, dy, dw) in ((by_x, (1, 0, 0)), (by_y, (0, 1, 0)), (by_width, (0, 0, 1))):
        ahead, back = (
            gaussian_spot(21, [10.3 + s * dx, 9.8 + s * dy], 1.4 + s * dw)[0] for s in (step, -step)
        )
        assert np.allclose(slope, (ahead - back) / (2 * step), atol=1e-8)


def test_counts_have_the_noise_of_photons_and_read_out(rng):
    counts = SENSOR.counts(np.full(200_000, 400.0), rng)
    assert (counts.mean() - OFFSET) * SENSOR.gain == pytest.approx(400, rel=2e-3)
    assert counts.var() * SENSOR.gain**2 == pytest.approx(400 + SENSOR.variance, rel=0.02)
    assert SENSOR.counts(np.array([1e6]), rng) == SENSOR.top


def test_the_mosaic_repeats_from_any_corner():
    tile = SENSOR.response((0, 0), 4)
    assert tile.tolist() == np.tile(SENSOR.mosaic, (2, 2)).tolist()
    assert SENSOR.response((3, 2), 2).tolist() == [[1.0, 0.1], [0.2, 1.0]]
    assert SENSOR.response(np.zeros((5, 2), int), 3).shape == (5, 3, 3)


def test_flux_is_that_of_a_lambertian_surface():
    # 3 mW, all of it spread over the half sphere with cos/pi, through an aperture of 2 mm at 2 m
    photons = 3e-3 / (6.62607015e-34 * 299792458 / 532e-9)
    share = np.pi * 1e-3**2 / 2.0**2 / np.pi
    found = SENSOR.flux(1.0, 2.0, 1.0, 3e-3)
    assert found == pytest.approx(photons * share * SENSOR.efficiency, rel=1e-9)


@pytest.mark.parametrize(("polarisations", "width"), [(1, 1.6), (2, 1.6), (1, 2.4)])
def test_speckle_moves_the_centroid_as_the_formula_says(polarisations, width, rng):
    drawn = speckled_centroids(
        SENSOR,
        width=width,
        draws=120,
        rng=rng,
        polarisations=polarisations,
        side=128 if width < 2 else 160,
    )
    foretold = SENSOR.speckle(1 / np.sqrt(polarisations))
    # 240 coordinates: the standard deviation is known to 4.6 %; three of them, and the small
    # number of speckles in a spot, which the formula takes for many
    assert drawn.std() == pytest.approx(foretold, rel=0.15)


def test_speckle_must_be_resolved(rng):
    with pytest.raises(ValueError, match="Sample finer"):
        speckled_centroids(replace(SENSOR, f_number=1.4), width=1.0, draws=1, rng=rng, finer=1)


# --- the fit -----------------------------------------------------------------------------------


@pytest.mark.parametrize("brightness", [1500, 8000, 30_000])
@pytest.mark.parametrize("width", [0.8, 1.5])
def test_the_fit_reaches_its_bound(brightness, width, rng):
    """3000 coordinates: their standard deviation is known to 1.3 %; the margin is 6 %."""
    counts, places, corners = windows(rng, brightness=brightness, width=width)
    found = fitted(counts, corners)
    good = found.status == Status.FOUND
    assert good.mean() > 0.98
    error = (found.pixels - corners - places)[good]
    bound = spot_bound(
        SENSOR, centre=places, brightness=brightness, width=width, ground=AMBIENT, corners=corners
    )[good]
    ideal = np.sqrt(np.trace(bound, axis1=1, axis2=2).mean() / 2)
    assert error.std() == pytest.approx(ideal, rel=0.06)
    assert np.abs(error.mean(axis=0)).max() < 4 * ideal / np.sqrt(good.sum())
    told = np.einsum("ni,nij,nj->n", error, np.linalg.inv(found.covariance[good]), error)
    assert told.mean() == pytest.approx(2, rel=0.12)
    assert np.median(found.width[good]) == pytest.approx(width, rel=0.05)


def test_a_colour_mosaic_costs_precision_but_brings_no_bias(rng):
    plain = replace(SENSOR, mosaic=((1.0, 1.0), (1.0, 1.0)))
    ask = {"centre": [7.5, 7.5], "brightness": 5000.0, "width": 1.1}
    grey, green = (np.trace(spot_bound(s, **ask)) for s in (plain, SENSOR))
    assert 1.5 < green / grey < 3


def test_speckle_is_added_to_the_covariance(rng):
    counts, _, corners = windows(rng, brightness=20_000, count=3)
    bare, rough = (fitted(counts, corners, speckle=s) for s in (0.0, 0.2))
    assert np.allclose(rough.covariance - bare.covariance, 0.04 * np.eye(2))


# --- refusals ----------------------------------------------------------------------------------


def test_nothing_is_found_where_there_is_nothing(rng):
    counts, _, corners = windows(rng, brightness=0.0)
    found = fitted(counts, corners)
    assert (found.status == Status.ABSENT).mean() > 0.998
    assert np.isnan(found.pixels[found.status == Status.ABSENT]).all()


def test_saturation_is_told(rng):
    counts, _, corners = windows(rng, brightness=4e5, count=20)
    assert (fitted(counts, corners).status == Status.SATURATED).all()


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_two_spots_in_a_window_are_told(share, rng):
    angle = rng.uniform(0, 2 * np.pi, 200)
    aside = 5.5 * np.stack([np.cos(angle), np.sin(angle)], 1)
    first = np.full((200, 2), WINDOW / 2) - aside / 2
    light = 8000 * (
        gaussian_spot(WINDOW, first, np.ones(200))[0]
        + share * gaussian_spot(WINDOW, first + aside, np.ones(200))[0]
    )
    counts = SENSOR.counts(light * SENSOR.response((0, 0), WINDOW), rng)
    found = fit_spots(counts, SENSOR)
    assert (found.status == Status.FOUND).mean() < 0.02


def picture(rng, *spots, shape=(120, 160)):
    """Image of spots (x, y, brightness) on ambient light."""
    light = np.full(shape, AMBIENT)
    for x, y, brightness in spots:
        share = gaussian_spot(max(shape), [x, y], 1.1)[0]
        light = light + brightness * share[: shape[0], : shape[1]]
    return SENSOR.counts(light * SENSOR.response((0, 0), max(shape))[: shape[0], : shape[1]], rng)


@pytest.mark.parametrize(
    ("spots", "status"),
    [
        ([(70.3, 41.8, 6000)], Status.FOUND),
        ([], Status.ABSENT),
        ([(70.3, 41.8, 4e5)], Status.SATURATED),
        ([(70.3, 41.8, 6000), (120.1, 90.2, 4000)], Status.DOUBLE),
        ([(70.3, 41.8, 6000), (76.5, 41.8, 5000)], Status.DOUBLE),
        ([(70.3, 41.8, 6000), (120.1, 90.2, 500)], Status.FOUND),
        ([(0.7, 41.8, 6000)], Status.ABSENT),
    ],
)
def test_a_spot_is_found_in_a_whole_image_or_not(spots, status, rng):
    image = picture(rng, *spots)
    dark = np.mean([picture(rng) for _ in range(16)], axis=0)
    found = find_spot(image, SENSOR, background=dark, ground=AMBIENT)
    assert found.status == status
    if status == Status.FOUND:
        assert np.hypot(*(found.pixels - spots[0][:2])) < 5 * np.sqrt(found.covariance[0, 0])
    else:
        assert np.isnan(found.pixels).all()


def test_bad_images_are_refused():
    with pytest.raises(ValueError, match="Expected square windows"):
        fit_spots(np.zeros((3, 5, 9)), SENSOR)
    with pytest.raises(ValueError, match="Expected an image of at least"):
        find_spot(np.zeros((5, 400)), SENSOR)
    assert fit_spots(np.zeros((0, 15, 15)), SENSOR).pixels.shape == (0, 2)
