"""Run one notebook with the parameters of a profile, on a copy, and keep it only when it is whole.

    python -m cmtof_book.execute NOTEBOOK PARAMETERS RESULT FOLDER

``NOTEBOOK`` is the percent-format source, ``PARAMETERS`` a JSON object, ``RESULT`` the executed
notebook and ``FOLDER`` where its figures and checks go. Both appear only after the last cell, where
Snakemake has made room for them; what a failed run leaves lies in ``build/PROFILE/failed`` together
with its log.
"""

import json
import os
import shutil
import subprocess
import sys
import time
from importlib import metadata
from pathlib import Path
from typing import Any

# jsonschema, by which notebooks are checked and numbers glued, would compile a grammar of
# internationalised URIs for seconds, here and in the kernel; it does without when there is none
NO_GRAMMAR = "import sys; sys.modules['rfc3987_syntax'] = None"
exec(NO_GRAMMAR)

import nbformat  # noqa: E402
import papermill  # noqa: E402
from papermill.exceptions import PapermillExecutionError  # noqa: E402

from cmtof_book import THREADS, Values  # noqa: E402
from cmtof_book.pairs import notebook_from_script  # noqa: E402

LIBRARIES = ("numpy", "scipy", "numba", "scikit-image", "sympy", "xarray", "matplotlib")


def environment(work: Path) -> dict[str, str]:
    """Return the variables that make a run repeatable: this Python, few threads, nobody's start-up.

    The kernel's settings lie in the folder ``work``; they silence its remarks on its own workings
    and spare it the grammar.
    """
    settings = work / "ipython" / "profile_default"
    settings.mkdir(parents=True)
    (settings / "ipython_kernel_config.py").write_text(
        "c = get_config()\nc.Application.log_level = 50\n"
        f"c.InteractiveShellApp.exec_lines = [{NO_GRAMMAR!r}]\n",
        encoding="utf-8",
    )
    return {
        "CMTOF_OUTPUT": str(work / "results"),
        "IPYTHONDIR": str(work / "ipython"),
        **{name: os.environ.get(name, "1") for name in THREADS},
        "PYTHONHASHSEED": "0",
        "JUPYTER_PATH": "",
        "JUPYTER_PREFER_ENV_PATH": "1",
        "PYDEVD_DISABLE_FILE_VALIDATION": "1",
    }


def commit() -> str:
    """Return the short commit of the checkout, marked where files differ from it, or ''."""
    command = "git describe --always --dirty '--exclude=*' 2>/dev/null"
    return subprocess.getoutput(command)


def provenance(parameters: Values, started: float) -> Values:
    """Return what the last block of the page tells about this run."""
    return {
        "parameters": parameters,
        "version": metadata.version("cmtof"),
        "commit": commit(),
        "date": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime(started)),
        "seconds": round(time.time() - started, 1),
        "python": sys.version.split()[0],
        "libraries": {name: metadata.version(name) for name in LIBRARIES},
    }


def execute(script: Path, parameters: Values, work: Path) -> None:
    """Run the notebook in the folder ``work``; its copy there shows how far it came."""
    started = time.time()
    staged = work / script.with_suffix(".ipynb").name
    nbformat.write(notebook_from_script(script), staged)
    defaults = {
        name: one["default"] for name, one in papermill.inspect_notebook(staged).items()
    }
    if unknown := sorted(
        parameters.keys() - defaults
    ):  # a misspelt size would be ignored
        raise ValueError(
            f"Expected parameters of {script.name} ({', '.join(sorted(defaults))}), got "
            f"{', '.join(unknown)}. Correct P or configs/{parameters['profile']}.yml."
        )
    executed: Any = papermill.execute_notebook(
        staged,
        staged,
        parameters=parameters,
        kernel_name="python3",
        cwd=str(script.parent),
        progress_bar=False,
        start_timeout=600,  # s; a busy machine takes more than the usual minute
    )
    executed.metadata["cmtof"] = provenance({**defaults, **parameters}, started)
    nbformat.write(executed, staged)


def main(notebook: str, parameters: str, *places: str) -> None:
    """Run one notebook; ``places`` are RESULT and FOLDER. Exit code 1 where it fails."""
    script, result, folder = (Path(name).resolve() for name in (notebook, *places))
    work = result.parents[1] / "failed" / script.stem
    shutil.rmtree(work, ignore_errors=True)
    (work / "results").mkdir(parents=True)
    os.environ.update(environment(work))
    started = time.time()
    try:
        execute(script, json.loads(parameters), work)
    except (PapermillExecutionError, ValueError) as error:
        text = f"{script.name}: {error}"
        (work / "log.txt").write_text(text, "utf-8")
        sys.exit(f"{text}\nThis again, and the notebook as far as it came: {work}")
    (work / "results").replace(folder)
    (work / result.name).replace(result)
    shutil.rmtree(work)
    print(f"{script.stem}: {time.time() - started:.1f} s", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
