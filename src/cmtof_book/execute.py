"""Run one notebook with the parameters of a profile.

    python -m cmtof_book.execute NOTEBOOK PARAMETERS RESULT

``NOTEBOOK`` is the percent-format source, ``PARAMETERS`` a JSON object, ``RESULT`` the executed
notebook. `tools/execute.sh` sets the variables that make a run repeatable: few threads, nobody's
start-up, and ``CMTOF_OUTPUT``, the folder for figures and checks. It keeps results when they are
whole; the Snakefile puts what a failed run leaves into ``build/PROFILE/failed``, with its log.
"""

import json
import subprocess
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import papermill
from papermill.exceptions import PapermillExecutionError

from cmtof.types import Fields
from cmtof_book.pairs import notebook_from_script

# the short commit of the checkout, marked where files differ from it, or nothing
COMMIT = "git describe --always --dirty '--exclude=*' 2>/dev/null"
LIBRARIES = ("numpy", "scipy", "numba", "scikit-image", "sympy", "xarray", "matplotlib")


def execute(script: Path, parameters: Fields, result: Path) -> None:
    """Run a notebook; ``result`` shows how far it came."""
    notebook = notebook_from_script(script)
    defaults = {
        name: one["default"]
        for name, one in papermill.inspect_notebook(notebook).items()
    }
    if unknown := parameters.keys() - defaults:  # a misspelt size would be ignored
        raise ValueError(
            f"Expected parameters of {script.name} ({', '.join(sorted(defaults))}), got "
            f"{', '.join(sorted(unknown))}. Correct P or configs/{parameters['profile']}.yml."
        )
    # what the last block of the page tells about this run, beside papermill's own notes
    notebook.metadata["cmtof"] = {
        "parameters": {**defaults, **parameters},
        "version": metadata.version("cmtof"),
        "commit": subprocess.getoutput(COMMIT),
        "libraries": {name: metadata.version(name) for name in LIBRARIES},
    }
    executed: Any = papermill.execute_notebook(
        notebook,
        result,
        parameters=parameters,
        kernel_name="python3",
        cwd=script.parent,
        progress_bar=False,
        start_timeout=600,  # s; a busy machine takes more than the usual minute
    )
    print(
        f"{script.stem}: {executed.metadata.papermill.duration:.1f} s", file=sys.stderr
    )


if __name__ == "__main__":
    SCRIPT, GIVEN, RESULT = sys.argv[1:]
    try:
        execute(Path(SCRIPT), json.loads(GIVEN), Path(RESULT))
    except (PapermillExecutionError, ValueError) as error:
        sys.exit(f"{SCRIPT}: {error}\nThe run as far as it came: {Path(RESULT).parent}")
