"""The emergency stop, in processes of their own that end in every way a process can end."""

import signal
import subprocess
import sys
import threading
from types import SimpleNamespace

from pytest import mark

from cmtof.hardware.safety import EmergencyStop

PROGRAM = """
import contextlib, os, signal, sys, time
from cmtof.hardware import safety
from cmtof.hardware.safety import EmergencyStop

class Device:
    def __init__(self, name, fails=False, during=None):
        self.name, self.fails, self.during = name, fails, during
    def safe_state(self):
        if self.during is not None:
            os.kill(os.getpid(), self.during)
        if self.fails:
            raise OSError("Expected an answer, got none. Switch it off.")
        print(f"safe {{self.name}}\\n", end="", flush=True)

with EmergencyStop([Device("shutter"), Device("rf", {fails}, {during}), Device("stage")]):
    print("ready", flush=True)
    {inside}
print("after", flush=True)
"""
SAFE = ["safe rf", "safe shutter", "safe stage"]
WAIT = "time.sleep(30)"
# what the first signal raises is lost, as in a method that Python calls by itself
SWALLOWED = """
    safety.PAUSE = 0.0
    for suppressed in (SystemExit, ()):
        with contextlib.suppress(suppressed):
            signal.raise_signal(signal.SIGTERM)
"""


def outcome(inside, number=None, *, fails=False, during=None):
    """Lines behind the first, standard error and exit code of a program that may get a signal."""
    text = PROGRAM.format(inside=inside, fails=fails, during=during)
    with subprocess.Popen(
        [sys.executable, "-c", text], stdout=-1, stderr=-1, text=True
    ) as one:
        assert one.stdout.readline() == "ready\n"
        if number is not None:
            one.send_signal(number)
        return sorted(one.stdout.read().splitlines()), one.stderr.read(), one.wait(20)


@mark.parametrize(
    "inside, number, code, words",
    [
        ("pass", None, 0, ""),
        ("raise RuntimeError('oops')", None, 1, "RuntimeError: oops"),
        (WAIT, signal.SIGINT, -signal.SIGINT, "KeyboardInterrupt"),
        (WAIT, signal.SIGTERM, 128 + signal.SIGTERM, ""),
        (WAIT, signal.SIGHUP, 128 + signal.SIGHUP, ""),
        (SWALLOWED, None, 128 + signal.SIGTERM, ""),
    ],
    ids=["end", "exception", "Ctrl-C", "SIGTERM", "SIGHUP", "swallowed"],
)
def test_every_end_is_safe(inside, number, code, words):
    lines, err, found = outcome(inside, number)
    assert (lines, found) == (["after"] * (code == 0) + SAFE, code)
    assert words in err


def test_a_signal_does_not_cut_the_stop_short():
    lines, _, code = outcome("pass", during=int(signal.SIGTERM))
    assert (lines, code) == (["after", *SAFE], 0)


@mark.parametrize("first", ["", "first Then: "])
def test_a_device_that_fails_keeps_no_other_from_its_safe_state(first):
    lines, err, code = outcome(
        "raise OSError('first')" if first else "pass", fails=True
    )
    assert (lines, code) == (["safe shutter", "safe stage"], 1)
    assert f"Unsafe: {first}Expected every device in its safe state, got 1" in err
    assert "Switch them off by hand" in err


def test_all_devices_are_stopped_at_the_same_time():
    """None gets on before all have begun: one that hangs delays no other."""
    begun = threading.Barrier(3)
    devices = [
        SimpleNamespace(name=name, safe_state=lambda: begun.wait(20)) for name in "abc"
    ]
    with EmergencyStop(devices):
        pass
    assert not begun.broken
