"""Compiled functions where Numba finds no folder, or no space, for what it compiles."""

import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

from numba.core.caching import IndexDataCacheFile
from pytest import warns

from cmtof import compiled


def test_a_command_runs_uncached_and_says_so_once(
    own_folder, measurement_file, monkeypatch
):
    # as in a read-only installation of a user without a home: no place but NUMBA_CACHE_DIR is tried
    monkeypatch.setenv("NUMBA_CACHE_LOCATOR_CLASSES", "UserProvidedCacheLocator")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    line = f"-m cmtof unwrap {measurement_file} -o out.nc --method mrf"
    done = subprocess.run(
        [sys.executable, *line.split()], stderr=subprocess.PIPE, check=True
    )
    (line,) = done.stderr.splitlines()
    assert b"Set NUMBA_CACHE_DIR" in line
    assert Path("out.nc").is_file()


def test_a_full_disk_ends_no_command_and_a_terminal_says_why_it_waits(
    monkeypatch, capsys
):
    full = OSError(28, "No space left on device")
    monkeypatch.setattr(IndexDataCacheFile, "save", Mock(side_effect=full))
    monkeypatch.setattr(sys.stderr, "isatty", Mock(return_value=True))
    monkeypatch.delenv("CI", raising=False)
    compiled._warn_uncached.cache_clear()
    compiled._say_compiling.cache_clear()

    @compiled.njit()
    def doubled(x):
        return 2 * x

    with warns(UserWarning, match="Set NUMBA_CACHE_DIR"):
        assert doubled(3) == 6
    assert "Compiling loops" in capsys.readouterr().err
