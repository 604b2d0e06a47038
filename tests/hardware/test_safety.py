"""The emergency stop, in processes of their own that end in every way a process can end."""

import signal
import subprocess
import sys

import pytest

PROGRAM = """
import os, signal, sys, time
from cmtof.hardware.safety import EmergencyStop

class Device:
    def __init__(self, name, fails=False, during=None):
        self.name, self.fails, self.during = name, fails, during
    def safe_state(self):
        if self.during is not None:
            os.kill(os.getpid(), self.during)
        if self.fails:
            raise OSError("Expected an answer, got none. Switch it off.")
        print("safe", self.name, flush=True)

with EmergencyStop([Device("shutter"), Device("rf", {fails}, {during}), Device("stage")]):
    print("ready", flush=True)
    {inside}
print("after", flush=True)
"""
SAFE = ["safe shutter", "safe rf", "safe stage"]
WAIT = "time.sleep(30)"


def outcome(inside, number=None, *, fails=False, during=None):
    """Lines behind the first, standard error and exit code of a program that may get a signal."""
    text = PROGRAM.format(inside=inside, fails=fails, during=during)
    with subprocess.Popen([sys.executable, "-c", text], stdout=-1, stderr=-1, text=True) as one:
        assert one.stdout.readline() == "ready\n"
        if number is not None:
            one.send_signal(number)
        out, err = one.stdout.read(), one.stderr.read()
        return out.splitlines(), err, one.wait(20)


@pytest.mark.parametrize(
    ("inside", "number", "code", "words"),
    [
        ("pass", None, 0, ""),
        ("raise RuntimeError('oops')", None, 1, "RuntimeError: oops"),
        ("sys.exit(3)", None, 3, ""),
        (WAIT, signal.SIGINT, -signal.SIGINT, "KeyboardInterrupt"),
        *[(WAIT, one, 128 + one, "") for one in (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)],
    ],
    ids=["end", "exception", "sys.exit", "Ctrl-C", "SIGTERM", "SIGHUP", "SIGQUIT"],
)
def test_every_end_is_safe(inside, number, code, words):
    lines, err, found = outcome(inside, number)
    assert (lines, found) == (SAFE + ["after"] * (code == 0), code)
    assert words in err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_during_the_stop_waits_for_its_end(number):
    lines, _, code = outcome("pass", during=int(number))
    assert lines == SAFE
    assert code == (128 + number if number == signal.SIGTERM else -number)


@pytest.mark.parametrize("first", ["", "first Then: "])
def test_a_device_that_fails_keeps_no_other_from_its_safe_state(first):
    lines, err, code = outcome("raise OSError('first')" if first else "pass", fails=True)
    assert lines == ["safe shutter", "safe stage"]
    assert f"Unsafe: {first}Expected every device in its safe state, got 1" in err
    assert "Switch them off by hand" in err
    assert code == 1
