"""The command line: from frames and measurements to depth, and from an instrument to a measurement.

Exit codes: 0; 1 for bad input, a failed check or a failed frame (one line on stderr); 2 for a
wrong command line; 130 for Ctrl-C.
"""

import signal
import sys
import warnings

from typer import Typer

from cmtof.cli import depths, learning, measuring
from cmtof.cli.options import as_command
from cmtof.terminal import complain, error_line, prepare_streams

app = Typer(
    name="cmtof",
    help="Centimetre-wave time-of-flight: from scenes and measurements to depth. With --debug an "
    "error shows its traceback.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)

for command in (
    measuring.simulate,
    depths.unwrap,
    depths.evaluate,
    depths.methods,
    measuring.info,
    depths.replicate,
    learning.render,
    learning.train,
    measuring.scan,
):
    app.command()(as_command(command))


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; an error becomes one line on stderr and exit code 1."""
    prepare_streams()
    # an exit by exception removes unfinished files
    for ending in signal.Signals:
        if ending.name in ("SIGTERM", "SIGHUP", "SIGQUIT"):
            signal.signal(ending, lambda number, _: sys.exit(128 + number))
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        # the libraries' own are for their developers; ours are one line
        with warnings.catch_warnings(action="ignore"):
            warnings.filterwarnings(
                "default", ".* is (untrained|left out)|.*NUMBA_CACHE_DIR", UserWarning
            )
            warnings.showwarning = lambda text, *_: complain(text)
            app(args=[word for word in words if word != "--debug"])
    except Exception as error:
        if "--debug" in words:
            raise
        complain(error_line(error))
        sys.exit(1)
