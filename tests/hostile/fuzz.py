"""Hostile inputs for the command line, made from a seed, and what must hold for each.

    python tests/hostile/fuzz.py COUNT [FIRST]

A case is a number: it decides the kind of input, how it is damaged, and the command that reads it.
Each runs in a process of its own. It must end with 0, 1 or 2, say at most one line on standard
error, show no traceback, leave no file where it failed, and stay within `SECONDS` and `MEGABYTES`.
"""

import io
import json
import os
import signal
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr

SECONDS, MEGABYTES = 20, 1500
Files = dict[str, bytes]
Made = tuple[Files, list[str]]
"""Files by name, and the command line that reads them from their folder."""


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Bytes with flipped bits, a lost end, a blanked or doubled piece, or a header written over."""
    out = bytearray(data)
    first, second = sorted(int(i) for i in rng.integers(0, len(out) + 1, 2))
    match int(rng.integers(5)):
        case 0:
            for place in rng.integers(0, len(out), int(rng.integers(1, 30))):
                out[place] ^= 1 << int(rng.integers(8))
        case 1:
            del out[first:]
        case 2:
            out[first : min(second, first + 4096)] = bytes(min(second, first + 4096) - first)
        case 3:
            out[first:first] = out[first : min(second, first + 4096)]
        case 4:
            out[: min(64, len(out))] = rng.bytes(min(64, len(out)))
    return bytes(out)


def strange_array(rng: np.random.Generator) -> np.ndarray:
    """An array of a kind or shape that no frame has."""
    shape = [(), (0,), (3,), (4, 5), (1, 1), (2, 3, 4), (0, 7)][rng.integers(7)]
    kinds = ["U3", "S2", "c16", "M8[s]", "m8[s]", "V4", "i1,f4", "?", "f2", "u8", "f8", "O"]
    kind = kinds[rng.integers(len(kinds))]
    if kind in ("f2", "f8"):
        return rng.choice([np.nan, np.inf, -1.0, 0.0, 1e300, 1.0], shape).astype(kind)
    return np.zeros(shape, kind)


def strange_value(rng: np.random.Generator) -> object:
    """A value that no setting has."""
    values = [
        "",
        "text",
        "nan",
        -1,
        0,
        1.5,
        1e308,
        -1e308,
        10**400,
        True,
        None,
        [],
        {},
        [[1]],
        {1: 2},
    ]
    return values[rng.integers(len(values))]


def document(rng: np.random.Generator, known: dict) -> bytes:
    """YAML or JSON: deep, aliased, of wrong kinds, of unknown names, or no text at all."""
    match int(rng.integers(7)):
        case 0:
            return ("[" * 20_000 + "]" * 20_000).encode()
        case 1:
            lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
            lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 12)]
            return "\n".join(lines).encode()
        case 2:
            return rng.bytes(int(rng.integers(0, 300)))
        case 3:
            return json.dumps({str(strange_value(rng)): 1, **known}, default=str).encode()
        case 4:
            return f"{next(iter(known))}: {'9' * 5000}\n".encode()
        case 5:
            return b"1: 2\n? [a, b]\n: c\n"
        case _:
            name = list(known)[rng.integers(len(known))]
            return json.dumps(known | {name: strange_value(rng)}, default=str).encode()


# --- kinds of input -------------------------------------------------------------------------------


def frame(rng: np.random.Generator) -> Made:
    """A frame whose arrays are strange or whose file is damaged."""
    depth = rng.uniform(0.8, 1.1, (12, 16)).astype(np.float32)
    arrays = {"depth": depth, "intensity": np.full_like(depth, 0.5), "camera": np.ones(4) * 20}
    if rng.uniform() < 0.7:
        arrays[str(rng.choice(list(arrays)))] = strange_array(rng)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    data = buffer.getvalue()
    data = damaged(data, rng) if rng.uniform() < 0.5 else data
    command = [["simulate", "f.npz", "-o", "out.nc"], ["info", "f.npz"]][rng.integers(2)]
    return {"f.npz": data}, command


def measurement(rng: np.random.Generator) -> Made:
    """A measurement with strange variables, attributes or bytes."""
    psi = np.tile(np.arange(4) * np.pi / 2, (2, 1))
    counts = 9000 + 6000 * np.cos(psi[..., None, None] + np.zeros((2, 4, 6, 8)))
    data = xr.Dataset(
        {"correlation": (("frequency", "step", "y", "x"), counts.astype(np.float32))},
        {"frequency": [7.15e9, 14.32e9], "psi": (("frequency", "step"), psi)},
        {"range_min": 0.75, "range_max": 1.19},
    )
    match int(rng.integers(5)):
        case 0:
            names = ["correlation", "frequency", "psi", "mask", "depth", "camera", "phase"]
            array = strange_array(rng)
            if array.dtype.kind not in "OVmM":
                dims = [f"d{i}" for i in range(array.ndim)]
                data = data.drop_vars("psi").assign({str(rng.choice(names)): (dims, array)})
        case 1:
            value = rng.choice([np.nan, np.inf, -1.0, 0.0, 1e6, 1e30])
            data.attrs[str(rng.choice(["range_min", "range_max"]))] = value
        case 2:
            tones = [1e15, 1e300, 1e-300, -1.0, np.nan, 7.15e9][rng.integers(6)]
            data = data.assign_coords(frequency=[7.15e9, tones])
        case 3:
            data["mask"] = (("y", "x"), np.zeros((6, 8), bool))
        case _:
            data = data * rng.choice([np.nan, -1.0, 1e30, 0.0])
            data.attrs = {"range_min": 0.75, "range_max": 1.19}
    encoded = io.BytesIO()
    data.to_netcdf(encoded, engine="h5netcdf", invalid_netcdf=True)
    raw = encoded.getvalue()
    raw = damaged(raw, rng) if rng.uniform() < 0.5 else raw
    name = str(rng.choice(["surfaces", "beat", "crt", "kde", "mrf", "middle", "region"]))
    return {"m.nc": raw}, ["unwrap", "m.nc", "-o", "out.nc", "--method", name]


def rig(rng: np.random.Generator) -> Made:
    """A description of an instrument."""
    known = {"devices": {}, "phases": 16, "field_of_view_deg": [9, 9], "twin": {}}
    return {"rig.yml": document(rng, known)}, ["scan", "rig.yml", "-o", "out.nc", "--size", "2"]


def configuration(rng: np.random.Generator) -> Made:
    """A configuration of a training."""
    known = {"model": "fast-scnn", "protocol": "released", "seed": 1, "stages": [], "rooms": {}}
    return {"c.yml": document(rng, known)}, ["train", "c.yml", "-o", "run", "--data", "none"]


def capture(rng: np.random.Generator) -> Made:
    """A published capture as CSV."""
    text = ",".join(str(strange_value(rng)) for _ in range(int(rng.integers(1, 20))))
    rows = "\n".join([text] * int(rng.integers(0, 5))).encode()
    rows = rng.bytes(50) if rng.uniform() < 0.3 else rows
    return {"scene_x_phase.csv": rows}, ["unwrap", "scene_x_phase.csv", "-o", "out.nc"]


def options(rng: np.random.Generator) -> Made:
    """A command line with extreme options."""
    numbers = ["nan", "inf", "-1", "0", "1e300", "9" * 400, "1000000001", "x", "", "1e-320"]
    value = str(rng.choice(numbers))
    commands = [
        ["simulate", "still_life", "-o", "out.nc", "--noise", value],
        ["simulate", "still_life", "-o", "out.nc", "--frequencies", f"7.15e9,{value}"],
        ["simulate", "still_life", "-o", "out.nc", "--seed", value],
        ["unwrap", "none.nc", "-o", "out.nc", "--range", value, "2"],
        ["evaluate", "still_life", "--method", value],
        ["evaluate", "still_life", "--method", "middle", "--json", "no/such.json"],
        ["render", "--scenes", "1", "--views", "1", "--size", f"{value}x8", "-o", "set"],
        ["render", "--scenes", "1", "--views", "1", "--size", "8x8", "--focal", value, "-o", "set"],
        ["scan", "--twin", "--size", value, "-o", "out.nc"],
        ["info", value],
        ["simulate", "\udcff.npz", "-o", "out.nc"],
    ]
    return {}, commands[rng.integers(len(commands))]


KINDS: list[Callable[[np.random.Generator], Made]] = [
    frame, measurement, measurement, rig, configuration, capture, options,
]  # fmt: skip


# --- one case -------------------------------------------------------------------------------------


def run(case: int) -> list[str]:
    """Run a case in a process of its own; return what is wrong, with its command."""
    from cmtof.cli import main

    files, command = KINDS[case % len(KINDS)](np.random.default_rng(case))
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+") as err:
        for name, content in files.items():
            (Path(folder) / name).write_bytes(content)
        child = os.fork()
        if child == 0:
            code = 99
            try:
                os.chdir(folder)
                os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
                os.dup2(err.fileno(), 2)
                sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w", buffering=1)
                signal.setitimer(signal.ITIMER_PROF, 2 * SECONDS)  # of the processor
                main(command)
                code = 0
            except SystemExit as stop:
                code = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
            finally:
                sys.stderr.flush()
                os._exit(code)
        _, status, usage = os.wait4(child, 0)
        err.seek(0)
        said = err.read()
        left = {p.name for p in Path(folder).iterdir()} - files.keys()
        code = os.waitstatus_to_exitcode(status)
    wrong = []
    if code not in (0, 1, 2):
        wrong.append(f"ended with {code}")
    if (code == 1 and said.count("\n") != 1) or "Traceback" in said or "a defect" in said:
        wrong.append(f"said {said[-400:]!r}")
    if code == 0 and said.strip():
        wrong.append(f"succeeded and said {said[-400:]!r}")
    if code != 0 and left:
        wrong.append(f"left {sorted(left)}")
    if usage.ru_utime + usage.ru_stime > SECONDS:
        wrong.append(f"took {usage.ru_utime + usage.ru_stime:.0f} s")
    if usage.ru_maxrss > 1024 * MEGABYTES:
        wrong.append(f"held {usage.ru_maxrss / 1024:.0f} MB")
    return [f"case {case}, {' '.join(command)!r}: {one}" for one in wrong]


if __name__ == "__main__":
    count, first = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    failed = 0
    for number in range(first, first + count):
        for line in run(number):
            failed += 1
            print(line, flush=True)
    print(f"{count} cases from {first}, {failed} failures")
    sys.exit(int(failed > 0))
