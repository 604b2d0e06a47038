"""What the package declares and what acts in its name: imports, extras, lock and workflows."""

import re
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions
from itertools import chain

import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from pytest import mark
from refusals import HOUSE

from cmtof.terminal import EXTRAS
from cmtof_book import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
PACKAGES = HOUSE["extras"]
# Requirements that are found by their name and never imported.
BACKENDS = {"pyusb", "pyvisa-py"}
DISTRIBUTIONS = packages_distributions()
# the package that a line imports, or imports from
IMPORT = r"(?m)^ *(?:import|from(?=.* import)) (\w+)"


def required(*extras):
    """Requirements of the package without extras, or of extras, by their normalised name."""
    chosen = [PROJECT["optional-dependencies"][extra] for extra in extras]
    found = {}
    for line in chain(*chosen) if extras else PROJECT["dependencies"]:
        requirement = Requirement(line)
        if requirement.name == PROJECT["name"]:
            found |= required(*requirement.extras)
        else:
            found[canonicalize_name(requirement.name)] = requirement
    return found


@cache
def imports(folder):
    """Foreign modules that a folder imports, each with a file that does."""
    own = {path.name for path in (ROOT / "src").iterdir()}
    found = {}
    for path in (ROOT / folder).rglob("*.py"):
        names = re.findall(IMPORT, path.read_text("utf-8"))
        found |= dict.fromkeys({*names} - sys.stdlib_module_names - own, path)
    return found


def providers(module):
    """Distributions that a module may come from."""
    return {canonicalize_name(name) for name in DISTRIBUTIONS.get(module, [])}


@mark.parametrize("folder", PACKAGES)
def test_every_import_is_declared(folder):
    declared = required() | required(*PACKAGES[folder])
    assert not [
        (name, path)
        for name, path in imports(folder).items()
        if not providers(name) & declared.keys()
    ]


def test_the_core_declares_nothing_that_it_does_not_import():
    assert not required().keys() - set().union(*map(providers, imports("src/cmtof")))


@mark.parametrize(
    "extra", ["hardware", "lab", "networks", "plot", "rooms", "train", "view"]
)
def test_an_extra_declares_nothing_that_is_not_imported(extra):
    used = set().union(*map(providers, set().union(*map(imports, PACKAGES)))) | BACKENDS
    assert not required(extra).keys() - used


def test_the_drivers_back_ends_are_declared():
    assert required("hardware").keys() >= BACKENDS


@mark.parametrize("folder", ["src/cmtof", "src/cmtof_rooms", "src/cmtof_lab"])
def test_the_command_line_knows_every_module_of_an_extra(folder):
    foreign = {
        name for name in imports(folder) if not providers(name) & required().keys()
    }
    assert foreign <= EXTRAS.keys()


@mark.parametrize("module, extra", EXTRAS.items())
def test_the_command_line_names_the_extra_of_a_module(module, extra):
    assert providers(module) & required(extra).keys()


def test_the_lock_holds_what_is_declared():
    text = (ROOT / "environment.lock").read_text("utf-8")
    locked = {}
    for pin in map(Requirement, re.findall(r"(?m)^[a-z0-9].*?(?= *\\?$)", text)):
        (version,) = pin.specifier
        locked.setdefault(canonicalize_name(pin.name), []).append(version.version)
    for name, requirement in (required() | required("all")).items():
        if name != "torch":  # its builds share a version, not a hash
            assert all(map(requirement.specifier.contains, locked[name])), requirement


@mark.parametrize(
    "path",
    sorted((ROOT / ".github/workflows").glob("*.yml")),
    ids=lambda path: path.name,
)
def test_actions_are_pinned_by_commit_and_may_only_read(path):
    text = path.read_text("utf-8")
    for action in re.findall(r"uses: (?!\./)(.*)", text):
        assert re.fullmatch(r"[\w./-]+@[0-9a-f]{40} # v\d+(\.\d+)*", action), action
    assert yaml.safe_load(text)["permissions"] == {"contents": "read"}


def test_only_the_job_that_publishes_may_sign_for_it():
    jobs = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text("utf-8"))[
        "jobs"
    ]
    assert jobs["publish"]["environment"]["name"] == "pypi"
    assert [name for name, job in jobs.items() if "permissions" in job] == ["publish"]
    assert jobs["publish"]["permissions"] == {"id-token": "write"}
    assert "secrets." not in str(jobs)
