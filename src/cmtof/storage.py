"""Files of datasets: read from netCDF4, netCDF-3 and plain HDF5, written as netCDF4."""

import gc
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from xarray import Dataset, open_dataset

from cmtof.contract import VARIABLES
from cmtof.files import (
    AnyPath,
    atomic_output,
    check_heaps,
    check_input,
    check_links,
    reading,
)
from cmtof.types import Fields
from cmtof.validation import check_claim

_PLAIN = (str, int, float, np.number, np.ndarray)


def save_dataset(dataset: Dataset, path: AnyPath) -> None:
    """Write a dataset as compressed netCDF4, whole or not at all.

    The file is built in memory: HDF5 written to a full disk would end the process.
    """
    encoding = {name: {"zlib": True, "complevel": 1} for name in dataset.data_vars}
    stored = dataset.copy()
    for holder in (stored, *stored.variables.values()):
        holder.attrs = {name: storable(value) for name, value in holder.attrs.items()}
    with atomic_output(path, ".nc") as part:
        part.write_bytes(stored.to_netcdf(engine="h5netcdf", encoding=encoding))


def storable(value: Any) -> Any:
    """The value as netCDF can store it: numbers and text kept, flags 0 or 1, others as JSON."""
    if isinstance(value, bool | np.bool_):
        return int(value)
    if isinstance(value, np.ndarray) and value.dtype.kind not in "iuf":
        value = value.tolist()
    if isinstance(value, list | tuple):
        kinds = {type(one) for one in value}
        if value and (kinds <= {int, float} or kinds == {str}):
            return list(value)
    if isinstance(value, list | tuple | dict):
        return json.dumps(value, default=str)
    return value if isinstance(value, _PLAIN) else str(value)


@contextmanager
def open_netcdf(path: AnyPath) -> Iterator[Dataset]:
    """Open a netCDF file without loading its arrays; a ValueError for whatever is wrong."""
    path = check_input(path, "a measurement file")
    hook, sys.unraisablehook = sys.unraisablehook, lambda _: None
    reason = None
    try:  # h5netcdf's destructor would print a traceback of its own for a damaged file
        with reading("a whole netCDF4 file", path):
            handle = _open_handle(path)
    except ValueError as error:
        reason = ValueError(*error.args)  # without the traceback, which holds the file
    finally:
        if reason:
            gc.collect()
        sys.unraisablehook = hook
    if reason:
        raise reason
    with handle:  # pyright: ignore[reportGeneralTypeIssues, reportPossiblyUnboundVariable]
        yield _with_dimension_names(handle)  # pyright: ignore[reportPossiblyUnboundVariable]


def _open_handle(path: Path) -> Dataset:
    """Open a file as netCDF-3 or HDF5, by its first bytes; a ValueError if it links to others."""
    import h5py

    with path.open("rb") as file:
        is_netcdf3 = file.read(3) == b"CDF"
    if is_netcdf3:
        options: Fields = {"engine": "scipy"}
    else:
        options = {"engine": "h5netcdf", "phony_dims": "access"}
        check_heaps(path)
        with h5py.File(path, "r") as whole:
            check_links(whole)
    handle = open_dataset(path, decode_times=False, **options)
    check_claim(handle.nbytes, path)
    return handle


def _with_dimension_names(handle: Dataset) -> Dataset:
    """The dataset with the dimensions of `VARIABLES` where plain HDF5 does not name them."""
    variables = {}
    for name, variable in handle.variables.items():
        dims = VARIABLES[str(name)].dims if name in VARIABLES else None
        nameless = all(str(dim).startswith("phony_dim") for dim in variable.dims)
        variables[name] = variable.copy(deep=False)
        if dims and nameless and len(dims) == variable.ndim:
            variables[name].dims = dims
    dataset = Dataset(variables, attrs=handle.attrs).set_coords(list(handle.coords))
    dataset.encoding = handle.encoding
    return dataset


def load_into_memory(dataset: Dataset) -> Dataset:
    """An opened dataset, or a part of one, read into memory; a ValueError for a damaged file."""
    with reading(
        "a whole netCDF4 file", dataset.encoding.get("source", "a part of it")
    ):
        return dataset.load()
