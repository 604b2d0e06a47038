"""Run the ci profile and test its numbers as other machines would, each in its own process.

    python -m cmtof_book.machines [MACHINE...] [--tests TESTS]

Without names: all machines of ``configs/machines.yml`` that this processor can imitate. Without
tests: all that are not slow, but for those of pages and packages.
"""

import os
import shlex
import subprocess
import sys
import time
from pathlib import Path
from typing import Annotated

import typer
import yaml

from cmtof_book import ROOT, Values
from cmtof_book.reference import stored_numbers

# Tests that no processor can change.
APART = ("hostile", "reader", "test_wheel.py", "test_house.py", "book/test_book.py")

USUAL = " ".join(["-m 'not slow'", *(f"--ignore=tests/{name}" for name in APART)])


def read_machines() -> dict[str, Values]:
    """What each machine needs of the processor, and the variables that imitate it."""
    text = (ROOT / "configs" / "machines.yml").read_text("utf-8")
    return {name: held for name, held in yaml.safe_load(text).items() if name[0] != "_"}


def possible() -> list[str]:
    """Machines that this processor can imitate."""
    about = Path("/proc/cpuinfo")
    flags = about.read_text("utf-8").split() if about.is_file() else []
    return [name for name, held in read_machines().items() if held["needs"] in flags]


def passes(machine: str, tests: str) -> bool:
    """Run the chapters that are compared, and the tests, as on a machine; both print."""
    build = f"build/machines/{machine}"
    settings = {**os.environ, "CMTOF_RESULTS": str(ROOT / build / "results")}
    settings.pop("OPENBLAS_CORETYPE", None)
    settings |= read_machines()[machine]["variables"]
    chapters = sorted({name.partition("/")[0] for name in stored_numbers()})
    results = " ".join(f"{build}/results/{chapter}" for chapter in chapters)
    commands = (
        f"snakemake --nolock --quiet all --cores {os.cpu_count()} --rerun-incomplete"
        f" --config profile=ci build={build} -- {results}",
        f"pytest {tests}",
    )
    return not any(
        subprocess.call(
            [sys.executable, "-m", *shlex.split(command)], cwd=ROOT, env=settings
        )
        for command in commands
    )


def main(
    machines: Annotated[list[str], typer.Argument(default_factory=possible)],
    tests: str = USUAL,
) -> None:
    """Run the machines one after the other."""
    if not machines or not read_machines().keys() >= set(machines):
        got = " ".join(machines) or "a processor that is none"
        known = ", ".join(possible())
        raise typer.BadParameter(
            f"Expected some of {known}, got {got}. Choose among those."
        )
    failed = False
    for machine in machines:
        started = time.monotonic()
        said = "PASS" if passes(machine, tests) else "FAIL"
        failed |= said == "FAIL"
        print(f"{said}  {machine}: {time.monotonic() - started:.0f} s", flush=True)
    raise typer.Exit(failed)


if __name__ == "__main__":
    typer.run(main)
