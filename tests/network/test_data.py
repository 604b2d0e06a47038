"""Training data: measurements with the simulator's statistics, leaves, rooms, sharing."""

import numpy as np
import torch
from pytest import approx, mark, raises, warns

import cmtof
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, centred, wrap_length
from cmtof.frame import Source
from cmtof.network import data
from cmtof.network.features import CLASSES
from cmtof.network.losses import IGNORED
from cmtof.scenes import Frame


def flat(depth, intensity, sigma, side=200, seed=0):
    whole = np.ones((side, side))
    return data.batch_of(
        [(depth * whole, intensity * whole, sigma, np.random.default_rng(seed))]
    )


def test_noise_free_phases_are_those_of_the_depth_and_their_offsets():
    offset = np.array([0.01, -0.02])
    batch = flat(7.1, 0.7, 0.0, 1)._replace(
        noise=torch.zeros(1, 4, 2, 1, 1), offset=torch.from_numpy(offset)[None]
    )
    phase = data.phasors(batch)[0].numpy().squeeze()
    expected = TAU * 7.1 / wrap_length(np.array(FREQUENCIES)) + offset
    # single precision would lose 0.3 mrad over 700 wraps
    assert phase == approx(expected % TAU, abs=1e-4)


def test_offsets_spread_as_told_and_change_nothing_else(config):
    apart = config.model_copy(update={"offset": 0.01})
    batches = [data.Steps(apart, None)[step] for step in range(30)]
    offsets = torch.cat([batch.offset for batch in batches]).numpy().ravel()
    # five standard errors of a standard deviation
    assert offsets.std() == approx(0.01, rel=5 / np.sqrt(2 * offsets.size))
    plain = data.Steps(config, None)[0]
    assert torch.equal(plain.noise, batches[0].noise)
    assert not plain.offset.any()


def test_images_have_the_simulators_mean_and_noise(flat_wall):
    """Means within 5 standard errors, variances within 4 %, of images drawn one by one."""
    frame = flat_wall(200, 0.93, 0.4)
    # its farthest depth is brought to 1.195 m if it lies beyond, and 0.93 m does not
    drawn = (
        cmtof.simulate(frame, noise=1200.0, seed=2).dataset["correlation"].to_numpy()
    )
    ours = data.phasors(flat(0.93, 0.4, 1200.0))[2][0].numpy()
    pixels = (-2, -1)
    error = np.sqrt(ours.var(pixels) / frame.depth.size * 2)
    assert (np.abs(ours.mean(pixels) - drawn.mean(pixels)) < 5 * error).all()
    assert ours.var(pixels).mean(1) == approx(drawn.var(pixels).mean(1), rel=0.04)


def test_noisy_images_decode_to_their_phasor():
    phase, amplitude, images = data.phasors(flat(0.93, 0.5, 800.0, 30))
    z = (
        images[:, :, 0] - images[:, :, 2] + 1j * (images[:, :, 3] - images[:, :, 1])
    ).numpy()
    assert np.abs(centred(np.angle(z) - phase.numpy())).max() < 1e-3
    assert np.allclose(np.abs(z) / 2, amplitude.numpy(), rtol=1e-3)


@mark.parametrize("protocol", ["released", "full"])
def test_labels_are_wraps_and_mask_what_lies_outside(protocol):
    first, _ = CLASSES[protocol]
    depth = torch.tensor(
        [[first * data.WRAP - 1e-4, (first + 3.5) * data.WRAP, 7.6, np.nan]]
    )
    batch = data.Batch(
        depth[None].double(),
        torch.ones(1, 1, 4),
        torch.ones(1),
        torch.zeros(1, 4, 2, 1, 4),
        torch.zeros(1, 2),
    )
    sample = data.measure(batch, inputs="phase", protocol=protocol)
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
    assert inside.mean() > 0.5
    counts, _ = np.histogram(turns[inside], 7, (0, classes))
    assert counts.max() < 2.5 * counts.min()
    assert abs(np.corrcoef(turns[inside], np.log(shade[inside] + 1e-3))[0, 1]) < 0.2


def test_room_crops_are_staged_and_mostly_in_range():
    rng = np.random.default_rng(0)
    depth = rng.uniform(2, 6, (3, 1, 1)) + 0.01 * np.arange(80) + np.zeros((3, 80, 80))
    light = rng.uniform(0, 1, depth.shape).astype(np.float16)
    pack = data.Pack(depth.astype(np.float32), light, depth.max((1, 2)))
    staged, _ = pack.staged(0, "released")
    assert staged.max() == approx(1.195, rel=1e-3)
    crops = [data.room_crop(rng, pack, 32, "released") for _ in range(30)]
    depth, light = np.swapaxes(crops, 0, 1)
    assert depth.shape == light.shape == (30, 32, 32)
    first, classes = CLASSES["released"]
    turns = depth / data.WRAP - first
    assert np.mean((turns >= 0) & (turns < classes)) > 0.6
    assert light.max() <= 1


def test_steps_depend_on_their_number_alone_and_share_out(config):
    alone = data.Steps(config, None)[3]
    shares = [data.Steps(config, None, rank, 2)[3] for rank in (0, 1)]
    joined = data.Batch(*map(torch.cat, zip(*shares, strict=True)))
    for same in (data.Steps(config, None)[3], joined):
        torch.testing.assert_close(same, alone, rtol=0, atol=0, equal_nan=True)
    assert not torch.equal(alone.noise, data.Steps(config, None)[4].noise)


def source(name, size=(10, 12), fill=2.0):
    """View of a made-up tree."""
    depth = np.full(size, fill)
    depth[0, 0] = np.nan
    return Source(name, lambda: Frame(depth, np.full(size, 1.7), None, name, ""))


def broken():
    raise OSError("Expected HDF5, got a torn file.")


def test_broken_views_are_left_out():
    views = [source("a"), Source("torn", broken), source("b"), source("small", (8, 8))]
    with warns(UserWarning) as caught:
        pack = data.pack_views([*views, source("empty", fill=np.nan)])
    said = [str(one.message) for one in caught]
    assert said[0] == "torn is left out. Expected HDF5, got a torn file."
    assert [line.split()[0] for line in said] == ["torn", "small", "empty"]
    assert pack.depth.shape == (2, 10, 12)
    assert np.isnan(pack.depth[0, 0, 0])
    assert pack.intensity.max() == 1
    assert pack.far.tolist() == [2, 2]


def test_a_training_without_views_is_refused():
    with raises(ValueError, match="Expected views to train"):
        data.pack_views([])
