"""Run the ci profile and test its numbers as other machines would, each in its own process.

    python -m cmtof_book.machines [MACHINE...] [-- TESTS...]

Without names: all machines of ``configs/machines.yml`` that this processor can imitate. Without
tests: all that are not slow, but for those of pages and packages.
"""

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import yaml

from cmtof_book.reference import ROOT, stored_numbers

APART = ("hostile", "reader", "test_wheel.py", "test_house.py", "book/test_book.py")
"""Tests that no processor can change."""


def read_machines() -> dict[str, dict[str, Any]]:
    """What each machine needs of the processor, and the variables that imitate it."""
    text = (ROOT / "configs" / "machines.yml").read_text("utf-8")
    return {name: held for name, held in yaml.safe_load(text).items() if name[0] != "_"}


def passes(machine: str, variables: dict[str, str], tests: list[str]) -> bool:
    """Run the chapters that are compared, and the tests, as on a machine; both print."""
    build = f"build/machines/{machine}"
    usual = {name: value for name, value in os.environ.items() if name != "OPENBLAS_CORETYPE"}
    settings = usual | variables | {"CMTOF_RESULTS": str(ROOT / build / "results")}
    chapters = sorted({name.partition("/")[0] for name in stored_numbers()})
    snakemake = [sys.executable, "-m", "snakemake", "--nolock", "--quiet", "all"]
    snakemake += ["--cores", str(os.cpu_count()), "--rerun-incomplete"]
    snakemake += ["--config", "profile=ci", f"build={build}", "--"]
    snakemake += [f"{build}/results/{chapter}" for chapter in chapters]
    return all(
        subprocess.run(command, cwd=ROOT, env=settings, check=False).returncode == 0
        for command in (snakemake, [sys.executable, "-m", "pytest", *tests])
    )


def main(words: list[str]) -> int:
    """Run the machines one after the other; return the exit code."""
    place = words.index("--") if "--" in words else len(words)
    machines = read_machines()
    about = Path("/proc/cpuinfo")
    flags = about.read_text("utf-8").split() if about.is_file() else []
    possible = [name for name in machines if machines[name]["needs"] in flags]
    named = words[:place] or possible
    if not named or not machines.keys() >= set(named):
        got = " ".join(words[:place]) or "a processor that is none"
        print(
            f"Expected some of {', '.join(possible)}, got {got}. Choose among those.",
            file=sys.stderr,
        )
        return 2
    tests = words[place + 1 :] or ["-m", "not slow", *(f"--ignore=tests/{name}" for name in APART)]
    failed = 0
    for machine in named:
        started = time.monotonic()
        good = passes(machine, machines[machine]["variables"], tests)
        failed += not good
        said = "PASS" if good else "FAIL"
        print(f"{said}  {machine}: {time.monotonic() - started:.0f} s", flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
