"""Ctrl-C, which a terminal sends to a command and to its workers."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

# in the background of a shell, as tests may run, Ctrl-C would be ignored
COMMAND = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
from cmtof.cli import main
main()
"""


def children(process):
    threads = Path(f"/proc/{process}/task").glob(
        "*/children"
    )  # one of them begins workers too
    return [child for thread in threads for child in thread.read_text().split()]


def test_render_ends_in_silence_when_its_whole_group_is_interrupted(tmp_path):
    arguments = ["render", "--scenes=40", "--size=48x64", "--workers=2", "-oset"]
    run = subprocess.Popen(
        [sys.executable, "-c", COMMAND, *arguments],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while (
        run.poll() is None and len(children(run.pid)) < 3
    ):  # two workers and their tracker
        time.sleep(0.01)
    os.killpg(run.pid, signal.SIGINT)
    said = run.communicate()[1]
    assert run.returncode == 130
    assert len(said.splitlines()) < 2
