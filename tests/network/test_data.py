"""Crops: decided by their number alone, staged as the simulator stages, shared out exactly."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from tiny_rooms import write_rooms

from cmtof.constants import FREQUENCIES
from cmtof.network.configuration import Config, Rooms
from cmtof.network.data import LEAST_VALID, Crops, Data, EpochSampler, Views, cut, in_range
from cmtof.network.frames import Pack
from cmtof.scenes.hypersim import Hypersim
from cmtof.simulation import Protocol, staged_depth

H, W, CROP = 24, 32, 12
CONFIG = Config(rooms=Rooms(height=H, width=W), crop=CROP, crops=10, batch=2)
CALM = replace(CONFIG, flips=False, brightness_jitter=0.0, noise_jitter=0.0)


def pack(count: int = 5) -> Pack:
    """Frames whose every pixel is told apart by its depth: frame, row and column."""
    frame, y, x = np.meshgrid(*(np.arange(n) for n in (count, H, W)), indexing="ij")
    depth = (1 + frame + y / 100 + x / 10_000).astype(np.float32)
    depth[:, 0, 0] = np.nan
    intensity = np.full(depth.shape, 0.5, np.float16)
    far = np.array([np.nanpercentile(one, 99.9) for one in depth])
    return Pack(depth, intensity, far, [str(n) for n in range(count)])


PACK = pack()


def unstaged(depth: torch.Tensor, config: Config, frame: int) -> np.ndarray:
    """Depth as it was before the protocol shrunk it."""
    scale = min(1.195 / PACK.far[frame], 1.0) if config.protocol == "released" else 1.0
    return depth.numpy() / scale


def same(one, other) -> bool:
    return all(
        torch.equal(a.nan_to_num(-1), b.nan_to_num(-1)) for a, b in zip(one, other, strict=True)
    )


def test_an_index_always_gives_the_same_crop():
    for index in (0, 3, 12_345):
        assert same(Crops(PACK, CONFIG)[index], Crops(pack(), replace(CONFIG))[index])


def test_indices_and_seeds_give_different_crops():
    crops = [Crops(PACK, CONFIG)[index] for index in range(40)]
    assert len({float(one.depth.nan_to_num(0).sum()) for one in crops}) > 35
    assert len({float(one.sigma) for one in crops}) == 40
    other = Crops(PACK, replace(CONFIG, seed=1))
    assert not any(same(crops[index], other[index]) for index in range(40))


@pytest.mark.parametrize("protocol", ["released", "full"])
@pytest.mark.parametrize("frame", range(5))
def test_a_crop_is_a_window_of_its_frame(protocol: Protocol, frame: int):
    config = replace(CALM, protocol=protocol)
    for seed in range(8):
        depth, intensity = cut(PACK, frame, config, np.random.default_rng(seed))
        assert depth.shape == intensity.shape == (CROP, CROP)
        assert depth.dtype == np.float32
        found = unstaged(torch.from_numpy(depth), config, frame)
        last = round(float(found[-1, -1] - 1 - frame) * 10_000)
        y, x = (corner - CROP + 1 for corner in divmod(last, 100))
        window = PACK.depth[frame, y : y + CROP, x : x + CROP]
        np.testing.assert_allclose(found, window, rtol=1e-6)


def test_crops_reach_every_corner_of_every_frame():
    corners = set()
    for seed in range(600):
        depth, _ = cut(PACK, seed % 5, replace(CALM, protocol="full"), np.random.default_rng(seed))
        corners.add(round(float(depth[-1, 0]) * 10_000))
    rows = {(value % 10_000) // 100 for value in corners}
    assert rows == set(range(CROP - 1, H))
    assert {value % 100 for value in corners} == set(range(W - CROP + 1))
    assert {value // 10_000 for value in corners} == {1, 2, 3, 4, 5}


def test_half_of_the_crops_are_mirrored_left_to_right():
    crops = Crops(PACK, replace(CONFIG, protocol="full"))
    rising = [
        float(one.depth[-1, -1] - one.depth[-1, 0]) > 0
        for one in map(crops.__getitem__, range(400))
    ]
    assert 160 < sum(rising) < 240  # four sigma of a fair coin
    kept = Crops(PACK, replace(CONFIG, protocol="full", flips=False))
    assert all(float(kept[i].depth[-1, -1] - kept[i].depth[-1, 0]) > 0 for i in range(50))
    assert all(float(crops[i].depth[-1, 0] - crops[i].depth[1, 0]) > 0 for i in range(50))


def test_a_mirrored_crop_is_the_same_crop_turned():
    mirrored, kept = (Crops(PACK, replace(CONFIG, flips=f)) for f in (True, False))
    alike = turned = 0
    for index in range(20):
        one, other = mirrored[index].depth.nan_to_num(0), kept[index].depth.nan_to_num(0)
        alike += torch.equal(one, other)
        turned += torch.equal(one, other.flip(1))
    assert alike + turned == 20 and alike and turned


def test_jitter_is_a_quarter_to_either_side():
    """Of the noise's variance, and of the intensity."""
    crops = [Crops(PACK, CONFIG)[index] for index in range(400)]
    variance = np.array([float(one.sigma) for one in crops]) ** 2 / 1200**2
    brightness = np.array([float(one.intensity[5, 5]) for one in crops]) / 0.5
    for jitter in (variance, brightness):
        assert 0.75 <= jitter.min() < 0.77 and 1.23 < jitter.max() <= 1.25
        assert jitter.mean() == pytest.approx(1, abs=0.03)  # four sigma
    assert abs(np.corrcoef(variance, brightness)[0, 1]) < 0.2


def test_without_jitter_there_is_none():
    one = Crops(PACK, CALM)[3]
    assert float(one.sigma) == 1200
    assert torch.equal(one.intensity, torch.full((CROP, CROP), 0.5))


def test_brightened_intensities_stay_below_one():
    bright = replace_intensity(1.0)
    found = torch.stack([Crops(bright, CONFIG)[index].intensity for index in range(50)])
    assert found.max() == 1 and found.min() >= 0.75


def replace_intensity(value: float) -> Pack:
    intensity = np.full(PACK.depth.shape, value, np.float16)
    return Pack(PACK.depth, intensity, PACK.far, PACK.names)


# --- protocols ---------------------------------------------------------------------------------


@pytest.mark.parametrize("protocol", ["released", "full"])
@pytest.mark.parametrize("scale", [0.8, 1.0, 9.0])
def test_a_whole_frame_is_staged_as_the_simulator_stages_it(protocol: Protocol, scale: float):
    depth = np.linspace(0.5, 1.5, 400).reshape(20, 20).astype(np.float32) * np.float32(scale)
    depth[3, 3] = np.nan
    far = np.array([float(np.nanpercentile(depth, 99.9))])
    one = Pack(depth[None], np.ones((1, 20, 20), np.float16), far, ["one"])
    config = Config(rooms=Rooms(height=20, width=20), crop=20, protocol=protocol)
    found, _ = cut(one, 0, config, np.random.default_rng(0))
    tones = np.asarray(FREQUENCIES)
    expected, mask, limits = staged_depth(depth, protocol=protocol, frequencies=tones)
    np.testing.assert_allclose(found, expected, rtol=3e-7)
    if found[~np.isnan(found)].max() < limits[1]:
        assert in_range(found, protocol) == pytest.approx(mask.mean(), abs=1 / 400)


def test_of_four_draws_one_with_enough_in_range_is_taken():
    """Half of each frame is unknown: crops of nothing are drawn again."""
    depth = PACK.depth.copy()
    depth[:, :, : W // 2] = np.nan
    sparse = Pack(depth, PACK.intensity, PACK.far, PACK.names)
    config = replace(CONFIG, protocol="full")
    rates = [in_range(Crops(sparse, config)[i].depth.numpy(), "full") for i in range(200)]
    once = [
        in_range(cut(sparse, i % 5, config, np.random.default_rng(i))[0], "full")
        for i in range(200)
    ]
    assert np.mean(np.array(once) < LEAST_VALID) > 0.2
    assert np.mean(np.array(rates) < LEAST_VALID) < 0.03


# --- validation --------------------------------------------------------------------------------


def test_views_are_the_same_every_time():
    for index in range(5):
        (one, noise), (other, again) = (Views(pack(), CONFIG)[index] for _ in range(2))
        assert same(one, other) and torch.equal(noise, again)
        assert noise.shape == (2, 2, CROP, CROP) and float(one.sigma) == 1200
        assert torch.equal(one.intensity, torch.full((CROP, CROP), 0.5))  # no jitter


def test_noise_of_each_view_is_its_own():
    views = Views(PACK, CONFIG)
    assert len({float(views[index][1].sum()) for index in range(len(views))}) == 5
    assert not torch.equal(Views(PACK, replace(CONFIG, seed=1))[0][1], views[0][1])


@pytest.mark.parametrize(
    ("wanted", "chosen"), [(0, range(5)), (9, range(5)), (1, [0]), (2, [0, 4]), (3, [0, 2, 4])]
)
def test_few_views_are_spread_over_the_set(wanted: int, chosen):
    views = Views(PACK, replace(CONFIG, validation_views=wanted))
    assert views.chosen.tolist() == list(chosen) and len(views) == len(list(chosen))


# --- processes ---------------------------------------------------------------------------------


@given(st.integers(1, 60), st.integers(1, 8), st.integers(0, 9))
def test_processes_share_an_epoch_out_exactly(count: int, world: int, epoch: int):
    samplers = [EpochSampler(count, rank, world) for rank in range(world)]
    for one in samplers:
        one.set_epoch(epoch)
    shares = [list(one) for one in samplers]
    assert {len(share) for share in shares} == {count // world} == {len(one) for one in samplers}
    together = sorted(index for share in shares for index in share)
    first = epoch * count
    assert together == list(range(first, first + count // world * world))


def test_steps_of_many_processes_see_the_crops_of_one():
    """The k-th batch of all processes together is the k-th batch of a single one."""
    alone = list(EpochSampler(12))
    shares = [list(EpochSampler(12, rank, 2)) for rank in range(2)]
    for k in range(3):
        together = {index for share in shares for index in share[2 * k : 2 * k + 2]}
        assert together == set(alone[4 * k : 4 * k + 4])


def test_no_crop_is_seen_twice():
    sampler, seen = EpochSampler(7), []
    for epoch in range(4):
        sampler.set_epoch(epoch)
        seen += list(sampler)
    assert seen == list(range(28))


def test_a_tree_that_is_there_is_packed_and_not_rendered(tmp_path):
    data = Data(write_rooms(tmp_path / "rooms", (H, W)), CONFIG, quiet=True)
    data.prepare_data()
    data.setup("fit")
    assert (len(data.train), len(data.validate)) == (16, 2)
    assert data.packed == tmp_path / "rooms.packed"
    batches = list(data.train_dataloader())
    assert [len(batch.depth) for batch in batches] == [2] * 5
    assert batches[0].sigma.shape == (2,)
    validation = list(data.val_dataloader())
    assert [noise.shape for _, noise in validation] == [(1, 2, 2, CROP, CROP)] * 2
    tested = Hypersim(data.tree).split()["test"][0].name
    assert tested not in {*data.train.names, *data.validate.names}
