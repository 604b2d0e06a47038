"""The application that commands are added to."""

import typer

app = typer.Typer(
    name="cmtof",
    help="Centimetre-wave time-of-flight: from scenes and measurements to depth.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)
