"""Nothing from the wire is evaluated, and nothing of ours listens but the twin on loopback."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

import cmtof.hardware
from cmtof.hardware import rig

HARDWARE = Path(cmtof.hardware.__file__).parent
FILES = sorted(HARDWARE.rglob("*.py"))

EVALUATES = {"eval", "exec", "compile", "__import__", "literal_eval", "execfile", "input"}
"""Calls that make code of data, or may."""
UNSAFE_MODULES = {"pickle", "cPickle", "dill", "cloudpickle", "joblib", "marshal", "shelve"}
"""Modules whose formats run code when they are read."""
SHELLS = {"subprocess", "pty.spawn", "os.system", "os.popen", "os.execv", "os.execvp", "os.spawnl"}
LISTENS = {"bind", "listen", "create_server", "start_server", "serve_forever"}
MAY_LISTEN = {"twin/lines.py"}
"""It refuses every address but the loopback interface's, which the twin's tests check."""


def name_of(node: ast.expr) -> str:
    """Dotted name of what is called."""
    if isinstance(node, ast.Attribute):
        return f"{name_of(node.value)}.{node.attr}".lstrip(".")
    return node.id if isinstance(node, ast.Name) else ""


def modules(node: ast.AST) -> list[str]:
    """Modules that a statement imports."""
    if isinstance(node, ast.Import):
        return [one.name for one in node.names]
    if isinstance(node, ast.ImportFrom):
        return [f"{node.module}.{one.name}" for one in node.names] + [node.module or ""]
    return []


def findings(source: str) -> Iterator[str]:
    """What evaluates data, runs a shell or reads a format that runs code."""
    for node in ast.walk(ast.parse(source)):
        for module in modules(node):
            if module.split(".")[0] in UNSAFE_MODULES or module in SHELLS:
                yield f"import {module}"
        if not isinstance(node, ast.Call):
            continue
        name = name_of(node.func)
        last = name.rpartition(".")[2]
        options = {one.arg: one.value for one in node.keywords}
        if last in EVALUATES and name != "re.compile":
            yield name
        if name in SHELLS or "shell" in options:
            yield name
        if isinstance(allowed := options.get("allow_pickle"), ast.Constant) and allowed.value:
            yield f"{name} with allow_pickle"
        if last == "load" and name.startswith(("np.", "numpy.")) and "allow_pickle" not in options:
            yield f"{name} without allow_pickle=False"
        if name.startswith("yaml.") and not safe_yaml(last, node):
            yield name


def safe_yaml(function: str, call: ast.Call) -> bool:
    """Whether a function of yaml makes plain values only."""
    if function != "load":
        return function in ("safe_load", "safe_dump", "dump", "YAMLError")
    loaders = [*call.args[1:], *(one.value for one in call.keywords if one.arg == "Loader")]
    return [name_of(one) for one in loaders] in (["_StrictLoader"], ["yaml.SafeLoader"])


def test_the_loader_of_rig_files_makes_plain_values():
    assert issubclass(rig._StrictLoader, yaml.SafeLoader)
    with pytest.raises(ValueError, match="Expected YAML in"):
        rig._settings_from_text("name: !!python/object/apply:os.getcwd []", "rig.yml")


def test_every_module_is_looked_at():
    found = {path.relative_to(HARDWARE).as_posix() for path in FILES}
    assert {"rig.py", "codecs/scpi.py", "drivers/labjack_t7.py", "twin/world.py"} <= found


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(HARDWARE).as_posix())
def test_nothing_is_evaluated(path: Path):
    assert not list(findings(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(HARDWARE).as_posix())
def test_only_the_twin_listens(path: Path):
    calls = {
        name_of(node.func).rpartition(".")[2]
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
    }
    here = path.relative_to(HARDWARE).as_posix()
    assert bool(calls & LISTENS) == (here in MAY_LISTEN)


@pytest.mark.parametrize(
    "source",
    [
        "eval(line)",
        "exec(line.decode())",
        "builtins.eval(x)",
        "import pickle",
        "from pickle import loads",
        "import subprocess",
        "from os import system",
        "import os; os.system(line)",
        "run(line, shell=True)",
        "np.load(path)",
        "np.load(path, allow_pickle=True)",
        "yaml.load(text)",
        "yaml.load(text, yaml.Loader)",
        "yaml.load(text, Loader=yaml.UnsafeLoader)",
        "yaml.unsafe_load(text)",
        "__import__(name)",
    ],
)
def test_the_search_finds_what_it_is_for(source: str):
    assert list(findings(source))


@pytest.mark.parametrize(
    "source",
    ["re.compile(x)", "yaml.safe_load(x)", "yaml.load(x, yaml.SafeLoader)", "import os, struct"],
)
def test_the_search_lets_the_rest_pass(source: str):
    assert not list(findings(source))
