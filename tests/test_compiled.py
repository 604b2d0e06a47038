"""Compiled functions where Numba finds no folder for what it compiles."""

import os
import subprocess
import sys


def test_a_command_runs_uncached_and_says_so_once(tmp_path, measurement_file):
    # as in a read-only installation of a user without a home: no place but NUMBA_CACHE_DIR is tried
    changes = {"NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"}
    words = ["unwrap", measurement_file, "-o", tmp_path / "out.nc", "--method", "mrf"]
    done = subprocess.run(
        [sys.executable, "-m", "cmtof.cli", *map(str, words)],
        env={name: os.environ[name] for name in os.environ if name != "NUMBA_CACHE_DIR"} | changes,
        capture_output=True,
        text=True,
    )
    (line,) = done.stderr.splitlines()
    assert "Set NUMBA_CACHE_DIR" in line
    assert done.returncode == 0
    assert (tmp_path / "out.nc").is_file()
