"""A journal becomes a measurement at any time, the same one each time."""

import numpy as np
import pytest
from fake_instruments import FakeRig

import cmtof
from cmtof.hardware.bench import Bench
from cmtof.hardware.errors import Unsafe
from cmtof.hardware.export import SLOT, export, measurement_from_journal
from cmtof.hardware.journal import Journal, journal_path, read_journal
from cmtof.hardware.reduction import Sampling, calibrate, drive_phases, nominal_psi
from cmtof.hardware.scan import planned, run, sampling_of, scan
from cmtof.hardware.scan_header import header_of


@pytest.fixture(scope="module")
def journal(tmp_path_factory):
    """Journal of a whole scan."""
    path = tmp_path_factory.mktemp("scan") / "m.nc.journal"
    rig = FakeRig(noise=0.01)
    plan = planned(rig.settings, size=5)
    with rig.open() as instruments:
        bench = Bench(instruments, rig.settings, sampling_of(rig.settings, plan))
        with Journal(path, header_of(bench, plan, seed=3)) as opened:
            run(bench, plan, opened, lambda line: None)
    return path


def test_two_exports_are_the_same_bytes(journal, tmp_path):
    for name in ("a.nc", "b.nc"):
        export(journal, tmp_path / name)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_the_file_opens_and_unwraps(journal, tmp_path):
    export(journal, tmp_path / "m.nc")
    opened = cmtof.open(tmp_path / "m.nc")
    assert opened.mask.all()
    result = cmtof.unwrap(opened, method="beat", window=5)
    group = opened.dataset.attrs["group_index"]
    depth = result["depth"].to_numpy() / group
    np.testing.assert_allclose(np.median(depth), 1.2, atol=2e-3)


@pytest.mark.parametrize("lines", range(16))
def test_every_beginning_of_a_journal_is_a_measurement(journal, lines):
    header, records = read_journal(journal)
    whole = measurement_from_journal(header, records).dataset
    begun = measurement_from_journal(header, records[:lines])
    assert begun.dataset.attrs["complete"] == int(lines == len(records))
    assert begun.dataset["mask"].sum() == 5 * max(0, min(lines, 15) - 10)  # rows in both modes
    seen = begun.dataset["raw_counts"].to_numpy()
    filled = seen != 0
    np.testing.assert_array_equal(seen[filled], whole["raw_counts"].to_numpy()[filled])
    assert filled.sum() == 16 * 5 * (np.clip(lines - 2, 0, 5) + np.clip(lines - 10, 0, 5))


def test_the_journal_of_a_running_scan_can_be_exported(tmp_path):
    rig = FakeRig(break_at=160)
    with pytest.raises(Unsafe):
        scan(rig, planned(rig.settings, size=5), tmp_path / "m.nc")
    with Journal(path := journal_path(tmp_path / "m.nc"), read_journal(path)[0]):
        begun = export(path, tmp_path / "m.nc")
    assert not begun.dataset.attrs["complete"]


def test_time_is_the_plans(journal):
    header, records = read_journal(journal)
    time = measurement_from_journal(header, records).dataset["time"].to_numpy()
    plan = planned(FakeRig().settings, size=5)
    first = next(line.first for line in plan.lines if line.kind == "scan")
    np.testing.assert_allclose(time[0].ravel(), SLOT * (first + np.arange(25)))
    assert time[1].min() > time[0].max()


def test_the_settle_samples_do_not_count():
    sampling = Sampling(4, 10, 3, 6)
    counts = np.full((4, 10), 40000)
    counts[:, :3], counts[0, :6] = 0, 65535
    sums, clipped = sampling.sums(counts.ravel())
    assert sums.tolist() == [4 * 40000, 7 * 40000, 7 * 40000, 7 * 40000]
    assert clipped == 0


def test_sums_of_full_scale_do_not_overflow():
    sums, clipped = Sampling(1, 1000, 0, 0).sums(np.full(1000, 65535))
    assert (sums[0], clipped) == (65535 * 1000, 1000)


@pytest.mark.parametrize(("mode", "order"), [("single", 1), ("doubled", 2)])
def test_the_drive_steps_psi_through_one_turn_upwards(mode, order):
    psi = -order * drive_phases(16, mode)
    np.testing.assert_allclose(np.exp(1j * psi), np.exp(1j * nominal_psi(16)), atol=1e-12)


def test_a_constant_phasor_does_not_move_the_offset():
    z = 0.6 + 0.02096 * (np.arange(8) + 0.5) / 8
    phase = 4 * np.pi * 7.15e9 * 1.0003 * z / 299792458.0
    stray = 0.3 * np.cos(nominal_psi(16) + 1.0)
    seen = 2 + np.cos(phase[:, None] + nominal_psi(16) - 2.0) + stray
    found = calibrate(seen[None], z, frequency=7.15e9, group_index=1.0003)
    assert abs(found.offset + 2.0) < 1e-3


def test_drift_between_two_looks_is_told_and_halved():
    psi = nominal_psi(16)
    looks = [2 + np.cos(psi + offset) for offset in (0.1, 0.3)]
    found = calibrate(np.array(looks)[:, None], np.zeros(1), frequency=7.15e9, group_index=1.0)
    assert found.drift == pytest.approx(0.2)
    assert found.offset == pytest.approx(0.2)
