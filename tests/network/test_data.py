"""Training data: measurements with the simulator's statistics, leaves, rooms, sharing."""

from unittest.mock import Mock

import numpy as np
import torch
from pytest import approx, mark, warns
from walls import WRAP, flat_wall

import cmtof
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, centred, phase_from_depth
from cmtof.frame import Source
from cmtof.network import data
from cmtof.network.features import CLASSES
from cmtof.network.losses import IGNORED
from cmtof.scenes import Frame


def batch_of_one(depth, light, sigma):
    """Batch of one crop of even brightness."""
    rng = np.random.default_rng(0)
    return data.batch_of([(np.array(depth), np.full_like(depth, light), sigma, rng)])


def flat(side, light, sigma):
    """Batch of one square wall at 0.93 m."""
    return batch_of_one(np.full((side, side), 0.93), light, sigma)


def turns_and_range(depth, protocol):
    """Depth above the first class, wraps, and whether it has a class."""
    first, classes = CLASSES[protocol]
    turns = depth / WRAP - first
    return turns, (turns >= 0) & (turns < classes)


def test_noise_free_phases_are_those_of_the_depth_and_their_offsets():
    offset = torch.tensor([[0.01, -0.02]])
    batch = batch_of_one([[7.1]], 0.7, 0.0)
    batch = batch._replace(noise=torch.zeros_like(batch.noise), offset=offset)
    phase, *_ = data.phasors(batch)
    expected = phase_from_depth(7.1, np.array(FREQUENCIES)) + offset[0].numpy()
    # single precision would lose 0.3 mrad over 700 wraps
    assert phase.numpy().ravel() == approx(expected % TAU, abs=1e-4)


def test_offsets_spread_as_told_and_change_nothing_else(config):
    apart = config.model_copy(update={"offset": 0.01})
    steps = [data.batch_at(number, apart, None) for number in range(30)]
    offsets = torch.cat([one.offset for one in steps]).numpy()
    # five standard errors of a standard deviation
    assert offsets.std() == approx(0.01, rel=5 / np.sqrt(2 * offsets.size))
    plain = data.batch_at(0, config, None)
    first = steps[0]
    assert torch.equal(plain.noise, first.noise)
    assert not plain.offset.any()


def test_images_have_the_simulators_mean_and_noise():
    """Means within 5 standard errors, variances within 4 %, of images drawn one by one."""
    frame = flat_wall(200, 0.93, 0.4)
    # its farthest depth is brought to 1.195 m if it lies beyond, and 0.93 m does not
    drawn = cmtof.simulate(frame).dataset["correlation"].to_numpy()
    *_, images = data.phasors(flat(200, 0.4, 1200.0))
    ours = images[0].numpy()
    pixels = (-2, -1)
    variance = ours.var(pixels)
    error = np.sqrt(variance / frame.depth.size * 2)
    off = ours.mean(pixels) - drawn.mean(pixels)
    assert (abs(off) < 5 * error).all()
    assert variance.mean(1) == approx(drawn.var(pixels).mean(1), rel=0.04)


def test_noisy_images_decode_to_their_phasor():
    found = data.phasors(flat(30, 0.5, 800.0))
    phase, amplitude, images = (one[0].numpy() for one in found)
    z = np.tensordot(images, [1, -1j, -1, 1j], (1, 0))
    assert abs(centred(np.angle(z) - phase)).max() < 1e-3
    assert np.allclose(abs(z) / 2, amplitude, rtol=1e-3)


@mark.parametrize("protocol", ["released", "full"])
def test_labels_are_wraps_and_mask_what_lies_outside(protocol):
    first, _ = CLASSES[protocol]
    least = first * WRAP
    nearer = least - 1e-4
    inside = least + 3.5 * WRAP
    batch = batch_of_one([[nearer, inside, 7.6, np.nan]], 1.0, 1.0)
    sample = data.measure(batch, inputs="phase", protocol=protocol)
    assert sample.label[0, 0].tolist() == [IGNORED, 3, IGNORED, IGNORED]
    assert sample.turns[0, 0, 1] == approx(3.5)
    assert torch.isfinite(sample.inputs).all()


@mark.parametrize("protocol", ["released", "full"])
def test_leaves_cover_all_classes_and_hide_them_from_brightness(protocol):
    rngs = map(np.random.default_rng, range(150))
    drawn = [data.dead_leaves(rng, 48, protocol) for rng in rngs]
    depth, light = np.array(drawn)[:, :, ::8, ::8].swapaxes(0, 1)
    turns, inside = turns_and_range(depth, protocol)
    assert inside.mean() > 0.5
    classes = CLASSES[protocol][1]
    counts, _ = np.histogram(turns[inside], 7, (0, classes))
    assert counts.max() < 2.5 * counts.min()
    shade = np.log(light[inside] + 1e-3)
    correlation = np.corrcoef(turns[inside], shade)[0, 1]
    assert abs(correlation) < 0.2


def test_room_crops_are_staged_and_mostly_in_range(rng):
    slope = np.broadcast_to(0.01 * np.arange(80), (3, 80, 80))
    depth = rng.uniform(2, 6, (3, 1, 1)) + slope
    light = rng.uniform(0, 1, depth.shape).astype(np.float16)
    pack = data.Pack(depth.astype(np.float32), light, depth.max((1, 2)))
    staged, _ = pack.staged_window(0, "released")
    assert staged.max() == approx(1.195, rel=1e-3)
    crops = [data.room_crop(rng, pack, 32, "released") for _ in range(30)]
    depth, light = np.swapaxes(crops, 0, 1)
    assert depth.shape == light.shape == (30, 32, 32)
    assert light.max() <= 1
    _, inside = turns_and_range(depth, "released")
    assert inside.mean() > 0.6


def test_steps_depend_on_their_number_alone_and_share_out(config):
    alone = data.batch_at(3, config, None)
    shares = [data.batch_at(3, config, None, rank, 2) for rank in (0, 1)]
    joined = data.Batch(*map(torch.cat, zip(*shares, strict=True)))
    for same in (data.batch_at(3, config, None), joined):
        torch.testing.assert_close(same, alone, rtol=0, atol=0, equal_nan=True)
    other = data.batch_at(4, config, None)
    assert not torch.equal(alone.noise, other.noise)


def source(name, size=(10, 12), fill=2.0):
    """View of a made-up tree."""
    depth = np.full(size, fill)
    depth[0, 0] = np.nan
    return Source(name, lambda: Frame(depth, np.full(size, 1.7), name=name))


def test_broken_views_are_left_out():
    torn = Mock(side_effect=OSError("Expected HDF5, got a torn file."))
    views = [
        source("a"),
        Source("torn", torn),
        source("b"),
        source("small", (8, 8)),
        source("empty", fill=np.nan),
    ]
    with warns(UserWarning) as caught:
        pack = data.pack_views(views)
    said = [str(one.message) for one in caught]
    assert said[0] == "torn is left out. Expected HDF5, got a torn file."
    assert [line.split()[0] for line in said] == ["torn", "small", "empty"]
    assert pack.depth.shape == (2, 10, 12)
    assert np.isnan(pack.depth[0, 0, 0])
    assert pack.intensity.max() == 1
    assert pack.far.tolist() == [2, 2]
