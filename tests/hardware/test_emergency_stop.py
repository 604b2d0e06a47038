"""The emergency stop, in processes of their own that end in every way a process can end."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from cmtof.hardware.errors import InstrumentTimeout, Unsafe
from cmtof.hardware.safety import EmergencyStop

PROGRAM = """
import os, signal, sys, time
from cmtof.hardware.safety import EmergencyStop

class Device:
    def __init__(self, name, fails=False, during=None):
        self.name, self.fails, self.during = name, fails, during
    def safe_state(self):
        if self.during is not None:
            os.kill(os.getpid(), self.during)
            time.sleep(0.01)
        if self.fails:
            raise OSError("Expected an answer, got none. Switch it off.")
        print("safe", self.name, flush=True)

devices = [Device("shutter"), Device("rf", fails={fails}, during={during}), Device("stage")]
{body}
"""

WITH = """
with EmergencyStop(*devices):
    {inside}
print("after", flush=True)
"""

READY = "print('ready', flush=True); "
WAIT = "time.sleep(30)"


def program(inside, *, fails=False, during=None, template=WITH):
    body = template.format(inside=inside if READY in inside else READY + inside)
    return PROGRAM.format(fails=fails, during=during, body=body)


def outcome(text, number=None):
    """Lines behind the first, standard error and exit code of a program that may get a signal."""
    command = [sys.executable, "-c", text]
    with subprocess.Popen(command, stdout=-1, stderr=-1, text=True) as process:
        assert process.stdout.readline() == "ready\n"
        if number is not None:
            process.send_signal(number)
        out, err = process.stdout.read(), process.stderr.read()
        return out.splitlines(), err, process.wait(20)


SAFE = ["safe shutter", "safe rf", "safe stage"]

# what happens inside, signal sent from outside, exit code, words on stderr, whether it goes on
ENDS = {
    "the end": ("pass", None, 0, "", True),
    "an exception": ("raise RuntimeError('oops')", None, 1, "RuntimeError: oops", False),
    "sys.exit": ("sys.exit(3)", None, 3, "", False),
    "Ctrl-C": (WAIT, signal.SIGINT, -signal.SIGINT, "KeyboardInterrupt", False),
    "SIGTERM": (WAIT, signal.SIGTERM, 128 + signal.SIGTERM, "", False),
    "a suppressed Ctrl-C": (
        f"try: {READY}{WAIT}\n    except KeyboardInterrupt: pass",
        signal.SIGINT,
        0,
        "",
        True,
    ),
}


@pytest.mark.parametrize("end", ENDS)
def test_every_end_is_safe(end):
    inside, number, code, words, goes_on = ENDS[end]
    out, err, found = outcome(program(inside), number)
    assert out == SAFE + ["after"] * goes_on
    assert found == code
    assert words in err
    assert bool(words) == bool(err)


def test_the_end_of_the_program_stops_what_the_context_did_not():
    text = program("", template="EmergencyStop(*devices).__enter__(); print('ready', flush=True)")
    assert outcome(text) == (SAFE, "", 0)


@pytest.mark.parametrize(
    ("inside", "number", "code"),
    [
        ("pass", None, 1),
        ("raise OSError('oops')", None, 1),
        ("sys.exit(3)", None, 3),
        (WAIT, signal.SIGTERM, 128 + signal.SIGTERM),
    ],
)
def test_a_device_that_fails_is_named_and_does_not_stop_the_others(inside, number, code):
    out, err, found = outcome(program(inside, fails=True), number)
    assert out == ["safe shutter", "safe stage"]
    assert "1 that are not: rf: Expected an answer, got none" in err
    assert found == code
    if "oops" in inside:
        assert "oops Then: Expected every device in its safe state" in err


@pytest.mark.parametrize(
    ("during", "code"),
    [(signal.SIGINT, -signal.SIGINT), (signal.SIGTERM, 128 + signal.SIGTERM)],
)
def test_a_signal_during_the_stop_waits_for_its_end(during, code):
    out, _, found = outcome(program("pass", during=int(during)))
    assert (out, found) == (SAFE, code)


# --- in this process ---------------------------------------------------------------------------


class Device:
    def __init__(self, name, log, error=None):
        self.name, self.log, self.error = name, log, error

    def safe_state(self):
        self.log.append(self.name)
        if self.error is not None:
            raise self.error


def test_order_and_repetition():
    log = []
    stop = EmergencyStop(Device("a", log), Device("b", log))
    stop.add(Device("c", log))
    with stop:
        assert stop.stop() == []
    assert log == ["a", "b", "c"] * 2
    with stop:  # and again
        pass
    assert log == ["a", "b", "c"] * 3


def test_all_failures_are_reported_together():
    log = []
    devices = [
        Device("a", log, InstrumentTimeout("Expected x, got y. Do z.")),
        Device("b", log),
        Device("c", log, ValueError("strange")),
    ]
    words = r"2 that are not: a: Expected x, got y\. Do z\. \| c: strange Switch"
    with pytest.raises(Unsafe, match=words), EmergencyStop(*devices):
        pass
    assert log == ["a", "b", "c"]


def test_signal_handlers_are_given_back():
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with EmergencyStop():
        assert signal.getsignal(signal.SIGTERM) not in before
        with EmergencyStop():
            pass
        assert signal.getsignal(signal.SIGTERM) not in before
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_another_thread_leaves_signals_alone():
    log = []

    def work():
        with EmergencyStop(Device("a", log)):
            log.append(signal.getsignal(signal.SIGTERM))

    before = signal.getsignal(signal.SIGTERM)
    thread = threading.Thread(target=work)
    thread.start()
    thread.join(5)
    assert log == [before, "a"]


def test_ctrl_c_in_this_process():
    log = []
    with pytest.raises(KeyboardInterrupt), EmergencyStop(Device("a", log)):
        os.kill(os.getpid(), signal.SIGINT)
        threading.Event().wait(5)
    assert log == ["a"]
