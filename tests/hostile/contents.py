"""Content of files as the programs that write them leave it."""

import contextlib
import io
import tempfile
from functools import cache
from pathlib import Path

import h5py
import numpy as np
import xarray as xr
from PIL import Image

from cmtof.simulation import QUADRATURES


def npz(**arrays):
    """Content of an ``.npz``."""
    np.savez(buffer := io.BytesIO(), **arrays)
    return buffer.getvalue()


def netcdf(data):
    """Content of a ``.nc``."""
    return bytes(data.to_netcdf(engine="h5netcdf", invalid_netcdf=True))


def plain_arrays(data):
    """Content of an ``.npz`` with the arrays of a measurement."""
    return npz(**{k: v for k, v in data.variables.items() if v.dtype.kind in "biuf"})


def netcdf_3(data):
    """Content of a netCDF-3 file, which has no halves."""
    data["correlation"] = data["correlation"].astype(
        np.result_type(data["correlation"], "f4")
    )
    return bytes(data.to_netcdf(engine="scipy"))


def plain_hdf5(data):
    """Content of an HDF5 file whose dimensions have no names."""
    with h5py.File(buffer := io.BytesIO(), "w") as file:
        for name, variable in data.variables.items():
            file[name] = variable.to_numpy()
        file.attrs.update(data.attrs)
    return buffer.getvalue()


def external_link(file, other):
    """Have an HDF5 file take a variable out of another one."""
    file["dark"] = h5py.ExternalLink(other, "/dark")


def virtual_dataset(file, other):
    """Have an HDF5 file take the numbers of a variable out of another one."""
    layout = h5py.VirtualLayout((8,), "u1")
    layout[:] = h5py.VirtualSource(other, "dark", (8,))
    file.create_virtual_dataset("dark", layout)


def reaching_out(rng, data):
    """Content of a file that takes a variable out of another one, or out of a pipe."""
    other = rng.choice(["pipe.nc", "/etc/hostname", "m.nc"])
    with h5py.File(buffer := io.BytesIO(netcdf(data)), "r+") as file:
        reach = external_link if rng.random() < 0.5 else virtual_dataset
        reach(file, other)
    return buffer.getvalue()


def png(pixels):
    """Content of a PNG."""
    Image.fromarray(pixels).save(buffer := io.BytesIO(), "png")
    return buffer.getvalue()


def whole_measurement():
    """Measurement of 6 x 8 px."""
    psi = np.tile(QUADRATURES, (2, 1))
    counts = 9000 + 6000 * np.cos(psi[..., None, None] + np.zeros((2, 4, 6, 8)))
    return xr.Dataset(
        {"correlation": (("frequency", "step", "y", "x"), counts.astype(np.float32))},
        {"frequency": [7.15e9, 14.32e9], "psi": (("frequency", "step"), psi)},
        {"range_min": 0.755, "range_max": 1.19},
    )


@cache
def whole_journal():
    """Journal of a scan of 2 x 2 px that was stopped before its last lines."""
    from cmtof.hardware.plan import plan_scan
    from cmtof.hardware.rig import Rig
    from cmtof.hardware.scan import scan
    from cmtof_lab.rehearsal import simulated_bench

    def stop(line):
        if line.index == 30:
            raise KeyboardInterrupt

    rig = Rig.default()
    bench = simulated_bench(rig, "still_life")
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder, "out.nc")
        with contextlib.suppress(KeyboardInterrupt):
            scan(plan_scan(rig, size=2), lambda: bench, output, report=stop)
        return output.with_name("out.nc.journal").read_bytes()
