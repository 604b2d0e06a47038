"""Things that several tests lean on."""

import numpy as np
from hypothesis import settings
from pytest import fixture, raises, skip

import cmtof
from cmtof.captures import data_root
from cmtof.cli import main
from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth
from cmtof.frame import Frame

collect_ignore_glob = ["alone/*"]  # programs that test_wheel runs in other environments

settings.register_profile("cmtof", deadline=None, max_examples=50, derandomize=True)
settings.load_profile("cmtof")


@fixture
def rng():
    return np.random.default_rng(20230217)


@fixture(scope="session")
def tilted_wall():
    """A wall from 0.80 to 1.15 m, bright, so that its depth is known in closed form."""
    x, y = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 48))
    return Frame(
        0.8 + 0.25 * x + 0.1 * y, 0.2 + 0.8 * x, [80.0, 80.0, 32.0, 24.0], "wall"
    )


@fixture(scope="session")
def stepped_wall():
    """A slanted wall within the released wraps, with a step in the middle."""
    y, x = np.mgrid[:40, :56]
    depth = 0.9 + 0.0004 * x + 0.0002 * y + 0.12 * (x > 30)
    return Frame(depth * 1.195 / np.percentile(depth, 99.9), 0.6 + 0.004 * y)


@fixture(scope="session")
def measured(tilted_wall):
    """The wall with the paper's noise."""
    return cmtof.simulate(tilted_wall, seed=3)


@fixture(scope="session")
def measurement_file(measured, tmp_path_factory):
    path = tmp_path_factory.mktemp("measured") / "wall.nc"
    measured.save(path)
    return path


@fixture(scope="session")
def shared_data():
    """Folder with real captures and path-traced frames; the test is skipped without it."""
    root = data_root()
    if root is None:
        skip("no captures on this machine")
    return root


@fixture
def own_folder(tmp_path, monkeypatch):
    """The folder of a test, where it works."""
    monkeypatch.chdir(tmp_path)


@fixture
def run(capsys, own_folder):
    """Run a command in the test's folder; return exit code, standard output and error."""

    def runner(*words):
        with raises(SystemExit) as stop:
            main(" ".join(map(str, words)).split())
        captured = capsys.readouterr()
        return stop.value.code or 0, captured.out, captured.err

    return runner


@fixture
def succeeds(run):
    """Run a command that must succeed; return its standard output."""

    def runner(*words):
        code, out, err = run(*words)
        assert code == 0, err
        return out

    return runner


@fixture
def fails(run):
    """Run a command that must fail; return its one line."""

    def runner(*words):
        code, _, err = run(*words)
        assert code == 1
        assert err.count("\n") == 1, err
        assert err.startswith("cmtof: Expected ")
        return err

    return runner


@fixture(scope="session")
def exact():
    """Measurement of exact phases of depths; as ``depth`` another truth may be claimed."""

    def measure(true, frequencies=FREQUENCIES, **claimed):
        true = np.asarray(true, float)
        phase = [phase_from_depth(true, f) for f in frequencies]
        return cmtof.Measurement.from_phase(
            phase, frequencies, **{"depth": true} | claimed
        )

    return measure
