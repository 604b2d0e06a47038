"""Wrong physics is found: each mistake in the source fails the test that names it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from pytest import fixture, mark

from cmtof_book import ROOT


class Mistake(NamedTuple):
    """A line of a module as it is and as it would be wrong, and the test that fails."""

    module: str
    right: str
    wrong: str
    test: str


MISTAKES = {
    "factor 2 in Eq. 4": Mistake(
        "waveform.py",
        "return mean + 2 * np.tensordot(",
        "return mean + np.tensordot(",
        "test_correlation.py::test_harmonic_sum_equals_the_time_integral_of_any_waveforms",
    ),
    "sign of psi": Mistake(
        "simulation.py",
        "means -= y * s",
        "means += y * s",
        "test_simulation.py::test_noise_free_correlations_are_equation_8",
    ),
    "half of eta": Mistake(
        "modulator.py",
        "self.eta * np.sin(phase), self.eta * np.sin(second)",
        "self.eta / 2 * np.sin(phase), self.eta / 2 * np.sin(second)",
        "test_modulator.py::test_harmonics_equal_bessel_values",
    ),
    "one Bessel order": Mistake(
        "modulator.py",
        "np.where(k % 2, 0.5j * bessel, 0)",
        "np.where(k % 2, 0.5j * jv(k + 1, 2 * np.expand_dims(eta, -1)), 0)",
        "test_modulator.py::test_harmonics_equal_bessel_values",
    ),
    "Poisson without gain": Mistake(
        "simulation.py",
        "means = poisson_gaussian(means, ",
        "means = poisson_gaussian(means / np.float32(GAIN), ",
        "test_simulation.py::test_noise_of_a_flat_wall_has_the_mean_and_variance_of_the_model",
    ),
    "photons counted before the gain": Mistake(
        "detector.py",
        "gaussian += rng.poisson(mean)",
        "gaussian += 20 * rng.poisson(mean / 20)",
        "test_detector.py::test_poisson_gaussian_has_both_variances_in_the_given_precision",
    ),
}


def run_with(source, line):
    """Run a program with the packages of a folder."""
    return subprocess.run(
        [sys.executable, *line.split()],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": source, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
    )


def failures(test, source):
    """What pytest says of a test with the packages of a folder."""
    return run_with(source, f"-m pytest -p no:cacheprovider -rf {test}").stdout


@fixture
def source(tmp_path):
    """A copy of the packages."""
    left_out = shutil.ignore_patterns("weights", "test")
    return Path(shutil.copytree(ROOT / "src", tmp_path / "src", ignore=left_out))


def make(mistake, source):
    """Write the wrong line in place of the right one."""
    module = source / "cmtof" / mistake.module
    text = module.read_text("utf-8")
    assert text.count(mistake.right) == 1
    module.write_text(text.replace(mistake.right, mistake.wrong), "utf-8")


@mark.slow
@mark.parametrize("name", MISTAKES)
def test_a_mistake_fails_the_test_that_names_it(name, source):
    test = f"tests/{MISTAKES[name].test}"
    assert "FAILED" not in failures(test, source)
    make(MISTAKES[name], source)
    assert f"FAILED {test}" in failures(test, source)


@mark.slow
@mark.parametrize("name", ["sign of psi", "Poisson without gain"])
def test_a_mistake_in_the_chain_fails_replicate(name, source, tmp_path):
    make(MISTAKES[name], source)
    done = run_with(source, f"-m cmtof.cli replicate -o {tmp_path}/fig10.png")
    assert done.returncode == 1
    assert "FAIL  " in done.stdout
