"""Kill a scan at any moment, resume it, and hold the file against the uninterrupted one."""

import multiprocessing
import os
import signal
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cmtof.hardware.journal import journal_path, read_journal
from cmtof.hardware.plan import raster
from cmtof.hardware.rig import Rig
from cmtof.hardware.rig_settings import DetectionSettings
from cmtof.hardware.scan import scan

SIZE = 12
KILLS = 20


def take(output: str, resume: bool) -> None:
    """Scan a twin with short bursts, in a process of its own."""
    from cmtof.hardware.twin.run import Twin

    tempfile.tempdir = str(Path(output).parent)  # a killed twin cannot remove its links
    rig = Rig.default()
    detection = DetectionSettings(phases=4, samples_per_phase=14, settle_samples=2)
    rig = replace(rig, settings=replace(rig.settings, detection=detection))
    with Twin(rig, seed=4, scene="still_life", private=True, pace=1e-3) as twin:
        view = twin.rig.settings.scan.field_of_view
        plan = raster(SIZE, field_of_view=view, sweep=(-3e-3, 2e-3))
        scan(twin.rig, plan, output, resume=resume, seed=4)


def take_by_command(output: str, resume: bool) -> None:
    """Scan as a user does."""
    from cmtof.cli import main

    arguments = ["scan", "--twin", "--size", "4", "--seed", "4", "-o", output, "--quiet"]
    try:
        main(arguments + ["--resume"] * resume)
    except SystemExit as end:
        os._exit(int(end.code or 0))


@pytest.fixture(scope="module")
def server():
    """Processes that are forked from one that has imported all: fresh, and at once."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(
        ["cmtof.cli", "cmtof.hardware.scan", "cmtof.hardware.twin.run", "h5netcdf", __name__]
    )
    return context


def start(context, output, *, resume, target=take):
    process = context.Process(target=target, args=(str(output), resume))
    process.start()
    return process


def finish(process):
    process.join(120)
    code = process.exitcode
    process.close()
    return code


def lines_in(journal: Path) -> int:
    return len(read_journal(journal)[1]) if journal.exists() else -1


@pytest.mark.slow
def test_kill_at_twenty_moments_and_resume_gives_the_same_bytes(server, tmp_path, rng):
    whole = tmp_path / "m.nc"
    assert finish(start(server, whole, resume=False)) == 0  # what is cached is cached now
    expected = whole.read_bytes()
    whole.unlink()
    began = time.monotonic()
    assert finish(start(server, whole, resume=False)) == 0
    length = time.monotonic() - began
    assert whole.read_bytes() == expected

    def kill_and_resume(moment: float) -> int:
        output = tmp_path / f"{moment:.6f}" / "m.nc"
        output.parent.mkdir()
        process = start(server, output, resume=False)
        time.sleep(moment)
        process.kill()  # SIGKILL: nothing of the scan runs any more
        finish(process)
        journal = journal_path(output)
        reached = lines_in(journal)
        if output.exists():
            assert output.read_bytes() == expected  # whole, or not there
        assert finish(start(server, output, resume=True)) == 0
        assert output.read_bytes() == expected, f"killed after {moment:.2f} s in line {reached}"
        assert not journal.exists()
        return reached

    with ThreadPoolExecutor(2) as pool:
        reached = list(pool.map(kill_and_resume, rng.uniform(0, length, KILLS).tolist()))
    assert len({lines for lines in reached if lines > 0}) >= 3, reached


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, 128 + signal.SIGTERM), (signal.SIGINT, 130)]
)
def test_sigterm_and_ctrl_c_leave_a_journal_that_goes_on(server, tmp_path, number, code):
    output = tmp_path / "m.nc"
    process = start(server, output, resume=False, target=take_by_command)
    for _ in range(3000):
        if lines_in(journal_path(output)) > 1:
            break
        time.sleep(0.01)
    os.kill(process.pid, number)
    assert finish(process) == code
    assert journal_path(output).exists()
    assert not output.exists()
    assert finish(start(server, output, resume=True, target=take_by_command)) == 0
    again = tmp_path / "again.nc"
    assert finish(start(server, again, resume=False, target=take_by_command)) == 0
    assert np.array_equal(
        np.frombuffer(again.read_bytes(), np.uint8), np.frombuffer(output.read_bytes(), np.uint8)
    )
