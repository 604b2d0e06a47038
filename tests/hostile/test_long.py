"""Kills, full disks and thousands of calls: nothing is lost or left over."""

import itertools
import json
import os
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import fuzz
import numpy as np
from pytest import fixture, mark, skip

from cmtof.unwrapping import unwrap_file

pytestmark = mark.slow
# kills of a kind, and calls; in full 30 and 2000
MOMENTS, CALLS = json.loads(os.environ.get("CMTOF_LONG", "[5, 500]"))
RECIPE = """
{model: fast-scnn-light, precision: 32-true, rooms: null, save_every: 2, validate_every: 2,
validation_views: 3, stages: [{name: leaves, crops: 24, crop: 32, batch: 2, noise: [30, 60],
rate: [1.0e-3, 1.0e-4]}]}
"""
COMMANDS = {
    "simulate": "simulate still_life -o m.nc",
    "unwrap": "unwrap in.nc -o out.nc --method crt --quiet",
    "render": "render --scenes=2 --views=3 --size=48x64 -o set --quiet",
    "scan": "scan --twin --size 16 -o m.nc --quiet",
    "train": "train recipe.yml -o run --quiet",
}


@fixture
def folder(tmp_path, measurement_file):
    """Maker of a folder with what the commands read."""

    def made(name):
        (path := tmp_path / name).mkdir(exist_ok=True)
        (path / "recipe.yml").write_text(RECIPE)
        (path / "in.nc").write_bytes(measurement_file.read_bytes())
        return path

    return made


def start(name, path, resume=False):
    """Start a command in a folder; what is returned waits for its exit code and its lines."""
    said = tempfile.TemporaryFile("w+")  # noqa: SIM115
    more = ["--resume"] if resume and name in ("scan", "train") else []
    child = fuzz.started([*COMMANDS[name].split(), *more], path, said)

    def end(number=None, after=0.0):
        if number:
            time.sleep(after)
            os.kill(child, number)
        code = os.waitstatus_to_exitcode(os.wait4(child, 0)[1])
        with said:
            said.seek(0)
            return code, said.readlines()

    return end


def contents(path, lost=()):
    """Bytes by name, but of files that are lost, and of what holds the minutes of a training."""
    timed = {path / "run/last.ckpt", path / "run/fast-scnn-light.released.json"}
    return {
        one.relative_to(path): b"" if one in timed else one.read_bytes()
        for one in path.rglob("*")
        if one.is_file() and one not in lost
    }


@mark.parametrize(
    "name, kill",
    [
        *itertools.product(
            ["render", "scan", "train"], ["SIGINT", "SIGTERM", "SIGKILL"]
        ),
        ("scan", "SIGHUP"),
    ],
)
def test_killed_at_any_moment_it_resumes_to_equal_bytes(folder, name, kill):
    number = getattr(signal, kill)
    assert start(name, folder("first"))() == (0, [])  # compiles
    whole = folder("whole")
    begin = time.monotonic()
    assert start(name, whole)() == (0, [])
    took = time.monotonic() - begin
    rng = np.random.default_rng(int(number))
    cut = 0
    for moment in map(str, range(MOMENTS)):
        path = folder(moment)
        code, lines = start(name, path)(number, rng.uniform(0, took))
        assert code in (0, -number, 128 + number)
        # a kill in the middle of writing leaves a part, which later runs clear after minutes
        lost = {*path.rglob(".*.part-*")}
        assert kill == "SIGKILL" or not (lines[1:] or lost)
        cut += code != 0
        assert start(name, path, resume=True)() == (0, [])
        assert contents(path, lost) == contents(whole), moment
    assert cut


def test_thousands_of_calls_take_no_more_memory_or_files(tmp_path, measurement_file):
    methods = itertools.cycle(
        ["crt", "beat", "spatial", "kde", "crt-ml", "region", "surfaces"]
    )

    def call(times):
        """MiB and files that are held after so many calls."""
        for method in itertools.islice(methods, times):
            list(unwrap_file(measurement_file, tmp_path / "out.nc", method=method))
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 2**20, len(
            [*Path("/dev/fd").iterdir()]
        )

    memory, files = call(CALLS // 20)
    more, files_then = call(CALLS - CALLS // 20)
    assert more < memory + 8
    assert files_then == files


@fixture
def resized(tmp_path):
    """A small disk, and what sets its size."""
    disk = tmp_path / "disk"
    disk.mkdir()

    def resize(size):
        command = ["mount", "-t", "tmpfs", "-o", f"{size}k", "cmtof", disk]
        return subprocess.run(command, capture_output=True).returncode

    if resize("size=1000"):
        skip("only root mounts a small disk")
    yield disk, lambda size: resize(f"remount,size={size:.0f}")
    subprocess.run(["umount", "-l", disk], check=True)


@mark.parametrize("name", COMMANDS)
def test_a_full_disk_is_one_line_and_the_run_goes_on(resized, folder, name):
    disk, resize = resized
    inputs = contents(folder("disk"))
    whole = folder("whole")
    assert start(name, whole)() == (0, [])
    used = sum(-(-len(content) // 4096) * 4 for content in inputs.values())
    full = 0
    for room in np.geomspace(4, 20_000, 25):  # KiB
        assert resize(used + room) == 0
        code, lines = start(name, disk, resume=True)()
        if code == 0:
            break
        full += 1
        assert (code, len(lines)) == (1, 1), lines
        assert "No space left" in lines[0]
        assert not list(disk.rglob(".*.part-*")), room
        assert name in ("render", "scan", "train") or contents(disk) == inputs
    assert full
    assert contents(disk) == contents(whole)
