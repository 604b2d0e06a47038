"""Measurements larger than memory: tiles against the whole, seams against the inside."""

import os
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.testing import assert_allclose
from pytest import approx, fixture, mark
from refusals import refused

import cmtof
from cmtof.evaluation import scored_pixels
from cmtof.network.weights import weights_path
from cmtof.unwrapping import unwrap_file
from cmtof_rooms.rendering import Settings, render_views

pytestmark = mark.usefixtures("own_folder")
SIDE = int(os.environ.get("CMTOF_SIDE", "1024"))  # px; 4000 takes minutes


@fixture
def stack(own_folder):
    """A measurement of 240 x 320 px; its last tile of 96 px is masked altogether."""
    held = cmtof.simulate(cmtof.load_frame("room"), protocol="full").dataset
    held["mask"][192:, 288:] = 0
    path = Path("m.nc")
    cmtof.Measurement(held).save(path)
    return path


@mark.parametrize(
    "method, margin, engine",
    [("crt", {"margin": 0}, "h5netcdf"), ("beat", {}, "scipy")],
)
def test_tiles_equal_the_whole(stack, method, margin, engine):
    """Those of a method of windows by what each sees beyond its own pixels."""
    measurement = cmtof.open(stack)
    measurement.dataset.to_netcdf(stack, engine=engine)
    tiles = [*unwrap_file(stack, "t.nc", tile=96, method=method, **margin)]
    assert len(tiles) == 12
    assert sum(share for share, *_ in tiles) == approx(1)
    whole = cmtof.unwrap(measurement, method=method)
    found = xr.load_dataset("t.nc")
    # confidences differ in their noise, which is estimated from each tile
    names = ["wrap_count", "depth"]
    xr.testing.assert_equal(found[names], whole[names])
    assert found.attrs["range_max"] == whole.attrs["range_max"]
    assert found.depth.attrs["units"] == "m"


def test_every_tile_has_the_rays_of_the_whole(stack):
    weights = weights_path("fast-scnn", "full")
    tiles = unwrap_file(stack, "t.nc", tile=160, method="fast-scnn", weights=weights)
    centres = [tile.camera[2:4] for _, tile, _ in tiles]
    corners = [[0, 0], [32, 0], [0, 32], [32, 32]]  # x, y of what each of them saw
    assert_allclose(centres, cmtof.open(stack).camera[2:4] - corners)


def test_nothing_is_written_unless_all_tiles_are_whole(stack):
    tiles = unwrap_file(stack, "t.nc", tile=128, method="crt")
    next(tiles)
    tiles.close()
    assert [*Path().iterdir()] == [stack]


def test_many_files_make_a_table(succeeds, fails, stack):
    Path("n.nc").write_bytes(stack.read_bytes())
    text = succeeds("unwrap m.nc n.nc -o out --method crt --tile 256")
    assert text.count("δ<1") == 1
    assert all(f"{name}.nc" in text for name in "mn")
    assert {path.name for path in Path("out").iterdir()} == {"m.nc", "n.nc"}
    assert "for --ply" in fails("unwrap m.nc n.nc -o out --ply a.ply")


@mark.slow
def test_seams_are_no_worse_than_the_inside():
    (view,) = render_views(Settings(812, 1, 1, SIDE, SIDE))
    cmtof.simulate(view.frame, protocol="full").save("m.nc")
    tile = min(1024, SIDE // 2)
    wrong = []
    near = []
    for _, measurement, result in unwrap_file("m.nc", "t.nc", tile=tile):
        pixels = scored_pixels(result, measurement)
        places = np.argwhere(measurement.mask & np.isfinite(measurement.depth))
        wrong.extend(pixels["consistent"] != pixels["true_consistent"])
        near.extend(np.minimum(places, tile - 1 - places).min(1) < 16)
    wrong = np.array(wrong)
    near = np.array(near)
    assert wrong[near].mean() < wrong[~near].mean() + 0.02


@mark.parametrize(
    "spoil, message",
    [
        (lambda path: path.write_text("no measurement"), "a whole netCDF4"),
        (lambda path: path.write_bytes(path.read_bytes()[:200_000]), "a whole netCDF4"),
        (lambda path: path.unlink() or os.mkfifo(path), "a measurement"),
        (lambda path: xr.Dataset().to_netcdf(path, engine="h5netcdf"), "a variable"),
    ],
)
def test_what_is_no_measurement_is_refused_in_tiles_too(stack, spoil, message):
    spoil(stack)
    with refused(f"^Expected {message}", (ValueError, OSError)):
        list(unwrap_file(stack, "t.nc", tile=128, method="crt"))
    assert [*Path().iterdir()] == [stack]
