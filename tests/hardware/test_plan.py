"""Plans, sums, calibration and journals: pure functions and crafted bytes."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cmtof.correlation import centred, phase_from_depth
from cmtof.hardware.journal import (
    MAGIC,
    Journal,
    bytes_from_record,
    framed,
    journal_path,
    read_journal,
)
from cmtof.hardware.plan import Plan, Record, raster
from cmtof.hardware.reduction import Sampling, calibrate, drive_phases, nominal_psi
from cmtof.hardware.rig import Rig, simulated
from cmtof.hardware.scan import Bench, header_of, planned, sampling_of

RIG = Rig.default()
PLAN = planned(RIG, size=4)


@pytest.fixture(scope="module")
def header():
    """Header of a simulated scan of 4 x 4 px."""
    with simulated(RIG, "still_life") as instruments:
        bench = Bench(instruments, RIG, sampling_of(RIG, PLAN))
        return header_of(bench, PLAN, seed=0, scene="still_life")


def record(index, level=1):
    """Record of a line of the plan."""
    shape = (PLAN.lines[index].bursts, 16)
    clipped = np.zeros(shape[0], np.uint16)
    return Record(index, 7e-3, np.full(shape, level, np.uint32), clipped)


def test_every_burst_has_its_own_label():
    labels = [label for line in PLAN.lines for label in line.labels]
    assert labels == list(range(1, PLAN.bursts + 1))
    kinds = [line.kind for line in PLAN.lines if line.mode == "single"]
    assert kinds == ["dark", "reference", *4 * ["scan"], "reference"]


def test_rays_are_those_of_a_pinhole():
    plan = raster((3, 5), field_of_view=(0.5, 0.3))
    across = np.tan(plan.angles[..., 0])
    np.testing.assert_allclose(np.diff(across, axis=1), 2 * np.tan(0.25) / 5)
    assert np.tan(plan.angles[:, 0, 1])[0] == pytest.approx(-2 * np.tan(0.15) / 3)


def test_a_plan_survives_its_plain_values():
    again = Plan.from_dict(json.loads(json.dumps(PLAN.as_dict())))
    assert np.array_equal(again.angles, PLAN.angles)
    assert again.lines == PLAN.lines


def test_points_beyond_the_mirrors_are_refused():
    wide = replace(RIG, galvo=replace(RIG.galvo, offset_x_volts=9.0))
    with pytest.raises(ValueError, match="within 10 V of the mirrors"):
        planned(wide)
    with pytest.raises(ValueError, match="Expected 1 to 4096 px"):
        planned(RIG, size=100000)


def test_sums_drop_the_settling_samples_and_count_what_clips():
    counts = np.arange(320).reshape(16, 20)
    counts[3, 5], counts[4, 19], counts[5, 0] = 0, 65535, 65535
    sums, clipped = Sampling(16, 20, 4, 17).sums(counts.reshape(1, -1))
    assert sums[0, 0] == counts[0, 17:].sum()
    assert sums[0, 3] == counts[3, 4:].sum()
    assert clipped.tolist() == [2]


@pytest.mark.parametrize("mode", ["single", "doubled"])
def test_drive_steps_psi_through_one_turn(mode):
    psi = -drive_phases(16, mode) * (2 if mode == "doubled" else 1)
    np.testing.assert_allclose(centred(psi - nominal_psi(16)), 0, atol=1e-12)


@pytest.mark.parametrize("stray", [0.0, 0.3])
def test_calibration_finds_the_offset_behind_stray_light(stray):
    wrap = 299792458 / (2 * 7.15e9)
    z = 0.6 + wrap * np.arange(8) / 8
    psi = nominal_psi(16)
    seen = 3 + np.cos(phase_from_depth(z, 7.15e9)[:, None] + psi - 1.2) + stray * np.cos(psi)
    found = calibrate(np.stack([seen, seen]), z, frequency=7.15e9, group_index=1.0)
    assert found.offset == pytest.approx(-1.2, abs=1e-6 + 0.02 * stray)
    assert found.drift == pytest.approx(0, abs=1e-9)
    with pytest.raises(ValueError, match="contrast above 0.001"):
        calibrate(np.full((1, 8, 16), 3.0), z, frequency=7.15e9, group_index=1.0)


# --- journals ------------------------------------------------------------------------------------


def test_a_torn_tail_is_cut_and_the_rest_goes_on(tmp_path, header):
    path = journal_path(tmp_path / "m.nc")
    with Journal(path, header) as journal:
        for index in range(3):
            journal.append(record(index))
    whole = path.read_bytes()
    for cut in (1, 9, len(framed(3, bytes_from_record(record(2)))) - 1):
        path.write_bytes(whole[:-cut])
        assert len(read_journal(path)[1]) == 2
    with Journal(path, header) as journal:
        journal.append(record(2))
        with pytest.raises(ValueError, match="Expected line 3 next"):
            journal.append(record(2))
    assert path.read_bytes() == whole


def test_two_writers_and_other_settings_are_refused(tmp_path, header):
    path = journal_path(tmp_path / "m.nc")
    with Journal(path, header), pytest.raises(ValueError, match="another scan writes"):
        Journal(path, header)
    before = path.read_bytes()
    with pytest.raises(ValueError, match="got seed = 0 where now it is 1"):
        Journal(path, header | {"seed": 1})
    assert path.read_bytes() == before


CRAFTED = {
    "no header": lambda header: [b"{}"],
    "no JSON": lambda header: [b"\xff"],
    "deep JSON": lambda header: [b"[" * 100000],
    "missing key": lambda header: [json.dumps({k: header[k] for k in header if k != "gain"})],
    "other kind": lambda header: [json.dumps(header | {"group_index": "one"})],
    "huge plan": lambda header: [
        json.dumps(header | {"plan": header["plan"] | {"shape": [10**9, 10**9]}})
    ],
    "no plan": lambda header: [json.dumps(header | {"plan": {}})],
    "no distance": lambda header: [json.dumps(header | {"settings": {}})],
    "negative samples": lambda header: [
        json.dumps(header | {"sampling": header["sampling"] | {"samples_per_phase": -1}})
    ],
    "other modes": lambda header: [json.dumps(header | {"frequencies": {"single": 1.0}})],
    "record of another line": lambda header: [json.dumps(header), bytes_from_record(record(1))],
    "short arrays": lambda header: [json.dumps(header), bytes_from_record(record(0))[:-2]],
    "shape that lies": lambda header: [
        json.dumps(header),
        bytes_from_record(record(0)).replace(b"[16, 16]", b"[16, -1]"),
    ],
    "no number": lambda header: [json.dumps(header), b'{"line": 0}\n'],
    "power of zero": lambda header: [
        json.dumps(header), bytes_from_record(record(0)._replace(power=0.0))
    ],
    "too many": lambda header: [
        json.dumps(header), *[bytes_from_record(record(n)) for n in range(len(PLAN.lines))], b"{}\n"
    ],
}  # fmt: skip


def test_a_crafted_journal_is_one_line_and_untouched(tmp_path, header):
    path, crafted = journal_path(tmp_path / "m.nc"), [b"", b"cmtofJ1\n", b"netCDF" * 9]
    for make in CRAFTED.values():
        parts = [p.encode() if isinstance(p, str) else p for p in make(header)]
        crafted.append(MAGIC + b"".join(framed(n, part) for n, part in enumerate(parts)))
    for data in crafted:
        path.write_bytes(data)
        for read in (read_journal, lambda path: Journal(path, header)):
            with pytest.raises(ValueError, match="Expected a journal of a scan") as error:
                read(path)
            assert "\n" not in str(error.value)
        assert path.read_bytes() == data
