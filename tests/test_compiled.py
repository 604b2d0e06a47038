"""Compiled functions where Numba finds no folder, or no space, for what it compiles."""

import os
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

from numba.core.caching import IndexDataCacheFile
from pytest import warns

from cmtof import compiled


def test_a_command_runs_uncached_and_says_so_once(own_folder, measurement_file):
    # as in a read-only installation of a user without a home: no place but NUMBA_CACHE_DIR is tried
    changes = {
        "NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator",
        "NUMBA_CACHE_DIR": "",
    }
    line = f"-m cmtof.cli unwrap {measurement_file} -o out.nc --method mrf"
    done = subprocess.run(
        [sys.executable, *line.split()],
        env=os.environ | changes,
        capture_output=True,
        text=True,
    )
    (line,) = done.stderr.splitlines()
    assert "Set NUMBA_CACHE_DIR" in line
    assert done.returncode == 0
    assert Path("out.nc").is_file()


def test_a_full_disk_ends_no_command(monkeypatch):
    full = OSError(28, "No space left on device")
    monkeypatch.setattr(IndexDataCacheFile, "save", Mock(side_effect=full))
    compiled._warn_uncached.cache_clear()

    @compiled.njit()
    def doubled(x):
        return 2 * x

    with warns(UserWarning, match="Set NUMBA_CACHE_DIR"):
        assert doubled(3) == 6
