"""Hostile inputs for the command line, made from a seed, and what must hold for each.

    python tests/hostile/fuzz.py COUNT [FIRST]

A case is a number: it decides the kind of input, how it is damaged, and the command that reads it.
Each runs in a process of its own. It must end with 0, 1 or 2, say at most one line on standard
error, show no traceback, leave no file where it failed and every input as it was, and stay within
`SECONDS` and `MEGABYTES`. The report is ``book/results/fuzz.json``; a piece that does not begin
with case 0 goes on with it.
"""

import contextlib
import gc
import json
import os
import random
import signal
import sys
import tempfile
import warnings
from functools import cache
from importlib import import_module
from pathlib import Path

from contents import whole_journal, whole_measurement
from hostile_inputs import KINDS, journal

from cmtof_book import RESULTS

REPORT = RESULTS / "fuzz.json"
SECONDS = 20  # of the processor
MEGABYTES = 1500  # of memory at its peak
STUCK = 300  # s after which a case that uses no processor, either, has failed


def started(command, folder, err):
    """Run a command in a process of its own, in a folder; return its number."""
    from cmtof.cli import main

    loaded()
    if (child := os.fork()) == 0:
        code = 99
        try:
            os.chdir(folder)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            os.dup2(err.fileno(), 2)
            sys.stdout = os.fdopen(1, "w")
            sys.stderr = os.fdopen(2, "w", buffering=1)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            signal.setitimer(signal.ITIMER_PROF, 20 * SECONDS)
            signal.alarm(STUCK)
            if torch := sys.modules.get("torch"):
                torch.set_num_threads(
                    1
                )  # a fork does not copy OpenMP's threads, and would wait
            main(command)
            code = 0
        except KeyboardInterrupt:
            code = 130
        except SystemExit as stop:
            code = (
                stop.code if isinstance(stop.code, int) else int(stop.code is not None)
            )
        finally:
            gc.collect()  # what destructors have to say
            sys.stderr.flush()
            os._exit(code)
    return child


def run(case):
    """Run a case in a process of its own; return what is wrong, each with its command."""
    kind = KINDS[case % len(KINDS)]
    files, command = kind(random.Random(case))
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+") as err:
        for name, content in files.items():
            path = Path(folder, name)
            os.mkfifo(path) if content is None else path.write_bytes(content)
        _, status, usage = os.wait4(started(command, folder, err), 0)
        code = os.waitstatus_to_exitcode(status)
        err.seek(0)
        faults = [*faults_of_process(code, err.read(), usage)]
        if not (code == 0 and kind is journal):  # which goes on, and away
            faults += faults_of_folder(code, Path(folder), files)
    return [f"case {case}, {' '.join(command)!r}: {fault}" for fault in faults]


def faults_of_process(code, said, usage):
    """What is wrong with how a process ended, what it said, and what it took."""
    if code not in (0, 1, 2):
        yield f"ended with {code}"
    is_line = said.count("\n") == 1 and said.startswith("cmtof: Expected ")
    if (code == 1 and not is_line) or "Traceback" in said or "a defect" in said:
        yield f"said {said[-400:]!r}"
    if code == 0 and said.strip() and "is untrained" not in said:
        yield f"succeeded and said {said[-400:]!r}"
    seconds = usage.ru_utime + usage.ru_stime
    if seconds > SECONDS:
        yield f"took {seconds:.0f} s"
    if usage.ru_maxrss > 1024 * MEGABYTES:
        yield f"held {usage.ru_maxrss / 1024:.0f} MB"


def faults_of_folder(code, folder, files):
    """What is wrong with the files that a process left."""
    left = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    left -= files.keys()
    if code != 0 and left:
        yield f"left {sorted(left)}"
    for name, content in files.items():
        if content and (folder / name).read_bytes() != content:
            yield f"changed {name}"


@cache
def loaded():
    """Import what cases need, and compile, once for all of them."""
    # a fork does not copy threads, and would wait for them
    os.environ |= {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
    from cmtof.measurement import Measurement
    from cmtof.methods import METHODS
    from cmtof.unwrapping import unwrap

    with warnings.catch_warnings(action="ignore"):
        for name in ("evaluation", "hardware.scan", "network.training"):
            with contextlib.suppress(ImportError):
                import_module(f"cmtof.{name}")
        for name in METHODS:
            with contextlib.suppress(ValueError):
                unwrap(Measurement(whole_measurement()), method=name)
    whole_journal()
    gc.collect()
    gc.freeze()  # or every process would look at all of it again


def main(count, first=0):
    """Run cases, write the report, and return the exit code."""
    failures = json.loads(REPORT.read_text("utf-8"))["failures"] if first else []
    for case in range(first, first + count):
        for line in run(case):
            print(line, flush=True)
            failures.append(line)
    report = {"cases": first + count, "failures": failures}
    REPORT.write_text(json.dumps(report, indent=1, sort_keys=True) + "\n", "utf-8")
    print(f"{first + count} cases, {len(failures)} failures")
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
