"""Build the staged book to HTML, strictly: every warning is an error.

python tools/render.py STAGE HTML

It builds from nothing each time, since pages that Sphinx takes from its cache repeat no warning.
The full log lies beside ``HTML`` as ``book.log``.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path


def main(stage: Path, html: Path) -> int:
    """Build ``stage`` and put the pages at ``html``; return the exit code."""
    work, log = html.with_name("sphinx"), html.with_name("book.log")
    shutil.rmtree(work, ignore_errors=True)
    build = ["jupyter-book", "build", str(stage), "-W", "-n", "--keep-going", "-q"]
    done = subprocess.run(
        [str(Path(sys.executable).with_name(build[0])), *build[1:], "--path-output", str(work)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    # colours are for a terminal, not for a file
    lines = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout).splitlines()
    log.write_text("\n".join(lines) + "\n", encoding="utf-8")
    if done.returncode:
        told = [line for line in lines if "WARNING" in line or "ERROR" in line]
        print("\n".join(told or lines), file=sys.stderr)
        print(f"The book did not build; warnings count as errors. Log: {log}", file=sys.stderr)
        return 1
    shutil.rmtree(html, ignore_errors=True)
    (work / "_build" / "html").replace(html)
    shutil.rmtree(work)
    print(f"book: {html / 'index.html'}", file=sys.stderr, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
