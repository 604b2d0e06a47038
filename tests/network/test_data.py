"""Training data: measurements with the simulator's statistics, leaves, rooms, sharing."""

import numpy as np
import torch
from pytest import approx, mark, raises, warns

import cmtof
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, centred, decode, wrap_length
from cmtof.frame import Source
from cmtof.network import data
from cmtof.network.features import CLASSES
from cmtof.network.losses import IGNORED
from cmtof.simulation import QUADRATURES


def flat(depth, intensity, sigma, side=200, seed=0):
    whole = np.ones((side, side))
    return data.batch_of(
        [(depth * whole, intensity * whole, sigma, np.random.default_rng(seed))]
    )


def test_noise_free_phases_are_those_of_the_depth_and_their_offsets():
    offset = np.array([0.01, -0.02])
    silent = {
        "noise": torch.zeros(1, 4, 2, 1, 1),
        "offset": torch.from_numpy(offset)[None],
    }
    batch = flat(7.1, 0.7, 0.0, 1)._replace(**silent)
    phase = data.phasors(batch)[0].numpy().squeeze()
    expected = TAU * 7.1 / wrap_length(np.array(FREQUENCIES)) + offset
    # single precision would lose 0.3 mrad over 700 wraps
    assert phase == approx(expected % TAU, abs=1e-4)


def test_offsets_spread_as_told_and_change_nothing_else(config):
    apart = config.model_copy(update={"offset": 0.01})
    batches = [data.Steps(apart, None)[step] for step in range(30)]
    offsets = torch.cat([batch.offset for batch in batches]).flatten()
    # five standard errors of a standard deviation
    assert float(offsets.std()) == approx(0.01, rel=5 / np.sqrt(2 * len(offsets)))
    assert torch.equal(data.Steps(config, None)[0].noise, batches[0].noise)


def test_images_have_the_simulators_mean_and_noise(flat_wall):
    """Means within 5 standard errors, variances within 4 %, of images drawn one by one."""
    frame = flat_wall(200, 0.93, 0.4)
    # its farthest depth is brought to 1.195 m if it lies beyond, and 0.93 m does not
    drawn = cmtof.simulate(frame, seed=2).dataset["correlation"].to_numpy()
    ours = data.phasors(flat(0.93, 0.4, 1200.0))[2][0].numpy()
    pixels = (-2, -1)
    variance = ours.var(pixels)
    error = np.sqrt(variance / frame.depth.size * 2)
    assert (np.abs(ours.mean(pixels) - drawn.mean(pixels)) < 5 * error).all()
    assert variance.mean(1) == approx(drawn.var(pixels).mean(1), rel=0.04)


def test_noisy_images_decode_to_their_phasor():
    held = [x[0].numpy() for x in data.phasors(flat(0.93, 0.5, 800.0, 30))]
    for phase, amplitude, images in zip(*held, strict=True):
        found = decode(images, QUADRATURES)
        assert np.abs(centred(found.phase - phase)).max() < 1e-3
        assert found.amplitude == approx(amplitude, rel=1e-3)


@mark.parametrize("protocol", ["released", "full"])
def test_labels_are_wraps_and_mask_what_lies_outside(protocol):
    first, _ = CLASSES[protocol]
    depth = [[first * data.WRAP - 1e-4, (first + 3.5) * data.WRAP, 7.6, np.nan]]
    crop = np.array(depth), np.ones((1, 4)), 1.0, np.random.default_rng(0)
    sample = data.measure(data.batch_of([crop]), inputs="phase", protocol=protocol)
    assert sample.label[0, 0].tolist() == [IGNORED, 3, IGNORED, IGNORED]
    assert float(sample.turns[0, 0, 1]) == approx(3.5)
    assert torch.isfinite(sample.inputs).all()


@mark.parametrize("protocol", ["released", "full"])
def test_leaves_cover_all_classes_and_hide_them_from_brightness(protocol):
    first, classes = CLASSES[protocol]
    drawn = [data.leaves(np.random.default_rng(k), 48, protocol) for k in range(150)]
    depth, shade = np.array(drawn)[:, :, ::8, ::8].swapaxes(0, 1)
    turns = depth / data.WRAP - first
    inside = (turns >= 0) & (turns < classes)
    counts, _ = np.histogram(turns[inside], 7, (0, classes))
    assert counts.sum() > 0.5 * turns.size
    assert counts.max() < 2.5 * counts.min()
    assert abs(np.corrcoef(turns[inside], np.log(shade[inside] + 1e-3))[0, 1]) < 0.2


def test_room_crops_are_staged_and_mostly_in_range(rng):
    depth = rng.uniform(2, 6, (3, 1, 1)) + 0.01 * np.arange(80) + np.zeros((3, 80, 80))
    pack = data.Pack(depth, rng.uniform(0, 1, depth.shape), depth.max((1, 2)))
    assert pack.staged(0, "released")[0].max() == approx(1.195, rel=1e-3)
    crops = [data.room_crop(rng, pack, 32, "released") for _ in range(30)]
    depth, light = np.swapaxes(crops, 0, 1)
    assert depth.shape == (30, 32, 32)
    low, high = np.cumsum(CLASSES["released"]) * data.WRAP
    assert np.mean((depth >= low) & (depth < high)) > 0.6
    assert light.max() <= 1


def test_steps_depend_on_their_number_alone_and_share_out(config):
    alone = data.Steps(config, None)[3]
    shares = [data.Steps(config, None, rank, 2)[3] for rank in (0, 1)]
    joined = data.Batch(*map(torch.cat, zip(*shares, strict=True)))
    for same in (data.Steps(config, None)[3], joined):
        torch.testing.assert_close(same, alone, rtol=0, atol=0, equal_nan=True)
    assert not torch.equal(alone.noise, data.Steps(config, None)[4].noise)


def torn():
    raise OSError("Expected HDF5, got a torn file.")


def test_broken_views_are_left_out(flat_wall):
    views = [Source("torn", torn), Source("a", lambda: flat_wall(8, 2.0, 1.7))]
    with warns(UserWarning, match="torn is left out. Expected HDF5, got a torn file"):
        pack = data.pack_views(views)
    assert pack.depth.shape == (1, 8, 8)
    assert pack.intensity.max() == 1
    assert pack.far.tolist() == [2]


def test_a_training_without_views_is_refused():
    with raises(ValueError, match="Expected views to train"):
        data.pack_views([])
