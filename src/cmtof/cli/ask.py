"""What there is: methods, info."""

import json
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from cmtof.cli.app import app
from cmtof.console import describe


@app.command()
def methods(
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List every unwrapping method with its kind, source and whether its weights are there."""
    from cmtof.methods import DEFAULT, METHODS

    if as_json:
        keys = ("name", "kind", "source", "summary", "frequencies", "tones", "knows_truth")
        listed = [
            {key: getattr(entry, key) for key in keys}
            | {"state": entry.state(), "default": entry.name == DEFAULT}
            for entry in METHODS.values()
        ]
        print(json.dumps(listed, indent=2, ensure_ascii=False))
        return
    from rich.console import Console
    from rich.table import Table

    table = Table()
    table.add_column("method", no_wrap=True)
    for heading in ("kind", "tones", "state", "what it does", "source"):
        table.add_column(heading)
    for entry in METHODS.values():
        name = f"{entry.name} *" if entry.name == DEFAULT else entry.name
        row = (name, entry.kind, str(entry.frequencies), entry.state(), entry.summary, entry.source)
        table.add_row(*row)
    Console().print(table)
    print("* the default; tones: frequencies needed; state: of weights for the released protocol")


@app.command()
def info(
    file: Annotated[Path | None, typer.Argument(help="Measurement, result or frame.")] = None,
) -> None:
    """Print version, devices and embedded frames, or what a file holds."""
    if file is not None:
        describe(file)
        return
    from importlib.util import find_spec

    from cmtof import __version__
    from cmtof.scenes.captures import data_root
    from cmtof.scenes.frame import embedded_frames

    print(f"cmtof {__version__}, Python {sys.version.split()[0]}, {os.cpu_count()} processors")
    if find_spec("torch"):
        import torch

        gpus = [torch.cuda.get_device_name(i) for i in range(torch.cuda.device_count())]
        print(f"torch {torch.__version__}, {', '.join(gpus) if gpus else 'no GPU'}")
    else:
        print("torch is not installed (only learned methods need it)")
    print(f"embedded frames: {', '.join(embedded_frames())}")
    print(f"published captures: {data_root() or 'not on this machine'}")
