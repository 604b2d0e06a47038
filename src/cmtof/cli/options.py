"""Commands for Typer out of plain functions, whose options `options.toml` describes."""

import tomllib
from collections.abc import Callable, Sequence
from functools import wraps
from inspect import Parameter, Signature, signature
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

from cmtof.files import check_output

File = Path | None
Options = dict[str, Any]  # of a group, by name

LINES = tomllib.loads(Path(__file__).with_name("options.toml").read_text("utf-8"))
TYPES = {
    "bool": bool,
    "int": int,
    "float": float,
    "str": str,
    "path": Path,
    "pair": tuple[float, float],
    "four": tuple[float, float, float, float],
}


def as_command(function: Callable[..., None]) -> Callable[..., None]:
    """The function with its parameters, and those of each group that it takes, as options."""
    plain = []
    groups = {}
    lines = LINES["every"] | LINES[function.__name__]
    for name, one in signature(function).parameters.items():
        if one.annotation == Options:
            groups[name] = [_of_group(key, **line) for key, line in LINES[name].items()]
        else:
            plain.append(_option(name, one.annotation, one.default, **lines[name]))

    @wraps(function)
    def command(**given: Any) -> None:
        for group, options in groups.items():
            given[group] = {one.name: given.pop(one.name) for one in options}
        function(**given)

    vars(command)["__signature__"] = Signature([*plain, *chain(*groups.values())])
    return command


def _of_group(name: str, *, type: str, default: Any = None, **line: Any) -> Parameter:
    """Option of a group, of a type out of `TYPES`."""
    return _option(name, TYPES[type] | None, default, **line)


def _option(
    name: str,
    kind: Any,
    default: Any,
    *,
    argument: bool = False,
    flags: Sequence[str] = (),
    suffix: str = "",
    **more: Any,
) -> Parameter:
    """Parameter of a command with a line of `options.toml`."""
    if suffix:
        more["callback"] = check_of_file(suffix)
    flags = flags or [f"--{name.replace('_', '-')}"]
    about = Argument(**more) if argument else Option(*flags, **more)
    return Parameter(
        name,
        Parameter.KEYWORD_ONLY,
        default=default,
        annotation=Annotated[kind, about],
    )


def check_of_file(suffix: str) -> Callable[[File], File]:
    """Check of a file to write, before anything is computed."""

    def check(path: File) -> File:
        # a file is replaced only if its name has the suffix
        free = suffix != ".nc" and path and not path.exists()
        return path and check_output(path, "" if free else suffix) and path

    return check
