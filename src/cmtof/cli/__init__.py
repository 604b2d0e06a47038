"""The command line: from simulate and unwrap to replicate, scan and twin.

Exit codes: 0; 1 for bad input, a failed check or a failed frame (one line on stderr); 2 for a
wrong command line; 130 for Ctrl-C.
"""

import sys

# in the order in which --help lists their commands
from cmtof.cli import measure, ask, make, instrument  # isort: skip  # noqa: F401
from cmtof.cli.app import app

__all__ = ["app", "main"]


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; bad input becomes one line on stderr and exit code 1."""
    try:
        app(args=arguments)
    except (ValueError, OSError) as error:
        message = " ".join(str(error).split())
        if isinstance(error, OSError) and error.filename and error.strerror:
            message = (
                f"Expected to read or write {error.filename}, got «{error.strerror}». "
                "Check path and permissions."
            )
        print(f"cmtof: {message}", file=sys.stderr)
        sys.exit(1)
