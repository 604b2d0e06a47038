"""Hostile inputs for the command line, made from a seed, and what must hold for each.

    python tests/hostile/fuzz.py COUNT [FIRST]

A case is a number: it decides the kind of input, how it is damaged, and the command that reads it.
Each runs in a process of its own. It must end with 0, 1 or 2, say at most one line on standard
error, show no traceback, leave no file where it failed and every input as it was, and stay within
`SECONDS` and `MEGABYTES`. Cases that are done are kept in build/fuzz, so that a run goes on where
it was stopped while the code is the same; the report is ``book/results/fuzz.json``.
"""

import contextlib
import gc
import hashlib
import io
import json
import os
import signal
import sys
import tempfile
import warnings
import zlib
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import IO

import h5py
import numpy as np
import xarray as xr
from PIL import Image

ROOT = Path(__file__).parents[2]
SECONDS = 20
MEGABYTES = 1500  # of the processor, and of memory at its peak
STUCK = 300  # s after which a case that uses no processor, either, has failed
Files = dict[str, bytes | None]  # None is a pipe
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
    values = ["", "text", "nan", -1, 0, 1.5, 1e308, -1e308, 10**400, True, None, [], {}, [[1]]]
    values.append({1: 2})
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


def npz(**arrays: np.ndarray) -> bytes:
    """Content of an ``.npz``."""
    np.savez(buffer := io.BytesIO(), **arrays)
    return buffer.getvalue()


@cache
def whole_measurement() -> xr.Dataset:
    """Measurement of 6 x 8 px."""
    psi = np.tile(np.arange(4) * np.pi / 2, (2, 1))
    counts = 9000 + 6000 * np.cos(psi[..., None, None] + np.zeros((2, 4, 6, 8)))
    return xr.Dataset(
        {"correlation": (("frequency", "step", "y", "x"), counts.astype(np.float32))},
        {"frequency": [7.15e9, 14.32e9], "psi": (("frequency", "step"), psi)},
        {"range_min": 0.755, "range_max": 1.19},
    )


def netcdf(data: xr.Dataset) -> bytes:
    """Content of a ``.nc``."""
    data.to_netcdf(buffer := io.BytesIO(), engine="h5netcdf", invalid_netcdf=True)
    return buffer.getvalue()


def frame(rng: np.random.Generator) -> Made:
    """A frame whose arrays are strange or whose file is damaged."""
    depth = rng.uniform(0.8, 1.1, (12, 16)).astype(np.float32)
    arrays = {"depth": depth, "intensity": np.full_like(depth, 0.5), "camera": np.ones(4) * 20}
    if rng.uniform() < 0.7:
        arrays[str(rng.choice(list(arrays)))] = strange_array(rng)
    data = npz(**arrays)
    data = damaged(data, rng) if rng.uniform() < 0.5 else data
    commands = [
        ["simulate", "f.npz", "-o", "out.nc"],
        ["info", "f.npz"],
        ["evaluate", "f.npz", "--method", "middle", "--json", "f.npz"],
        ["evaluate", ".", "--method", "crt", "--json", "out.json"],
        ["scan", "--twin", "--scene", "f.npz", "--size", "2", "-o", "out.nc"],
    ]
    return {"f.npz": data}, commands[rng.integers(len(commands))]


def measurement(rng: np.random.Generator) -> Made:
    """A measurement with strange variables, attributes or bytes."""
    data = whole_measurement().copy(deep=True)
    match int(rng.integers(6)):
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
        case 4:
            data.attrs["saturation"] = [np.nan, "x", [1, 2], -1.0][rng.integers(4)]
            data.attrs["protocol"] = ["full", "x", 3, [1, 2]][rng.integers(4)]
        case _:
            data = data * rng.choice([np.nan, -1.0, 1e30, 0.0])
            data.attrs = {"range_min": 0.75, "range_max": 1.19}
    raw = netcdf(data)
    name = "m.nc"
    if rng.uniform() < 0.2:  # as plain arrays
        held = {k: v.to_numpy() for k, v in data.variables.items() if v.dtype.kind in "biuf"}
        raw = npz(**{str(k): v for k, v in held.items()})
        name = "m.npz"
    raw = damaged(raw, rng) if rng.uniform() < 0.5 else raw
    if rng.uniform() < 0.1:
        return {name: raw}, ["info", name]
    methods = ["surfaces", "beat", "beat-guided", "crt", "crt-ml", "kde", "mrf", "mrf-graphcut"]
    methods += ["middle", "region", "spatial", "mode", "fast-scnn-light", "phasor"]
    outputs = [["-o", "out.nc"]] * 4 + [["-o", "m.nc"], ["-o", "out.nc", "--ply", "out.ply"]]
    chosen = ["--method", str(rng.choice(methods)), *outputs[rng.integers(len(outputs))]]
    return {name: raw}, ["unwrap", name, *chosen]


def foreign(rng: np.random.Generator) -> Made:
    """A measurement as other programs write it, or one that was made to harm."""
    data = whole_measurement().copy(deep=True)
    valid = rng.uniform(size=(6, 8)) < 0.7
    name = "m.nc"
    match int(rng.integers(8)):
        case 0:
            data["mask"] = (("y", "x"), np.where(valid, 1.0, np.nan))
            fill = rng.choice([0.0, np.nan, 9.97e36, -1e30])
            data["correlation"] = data["correlation"].where(valid, fill)
        case 1:
            kind = rng.choice(["u2", "i4", "f2", "f8", "i2"])
            data["correlation"] = (data["correlation"] - 9000 * (kind == "i2")).astype(kind)
        case 2:
            data["psi"].attrs["units"] = str(rng.choice(["degree", "rad", "\x1b[2J", "K"]))
            data["frequency"].attrs["units"] = str(rng.choice(["GHz", "Hz", ""]))
        case 3:
            data = data.assign_coords(frequency=[16e6, float(rng.choice([80e6, 32e6, 17e6]))])
            data.attrs = {"range_min": 0.0, "range_max": float(rng.choice([0.1, 9.0, 60.0]))}
        case 4:
            data = data.drop_vars("psi").assign(psi=data["psi"].variable)
        case _:
            data.attrs["note"] = "\x1b[31m[red]\u202e" * int(rng.integers(1, 4))
    raw = netcdf(data)
    match int(rng.integers(4)):
        case 0:
            raw = data.to_netcdf(engine="scipy") if rng.uniform() < 0.5 else plain_hdf5(data)
        case 1:
            raw = reaching_out(raw, rng)
    raw = damaged(bytes(raw), rng) if rng.uniform() < 0.2 else bytes(raw)
    files: Files = {name: raw, "pipe.nc": None}
    if rng.uniform() < 0.2:
        return files, ["info", name]
    method = str(rng.choice(["beat", "region", "crt", "kde", "mrf", "surfaces", "spatial"]))
    tile = ["--tile", "4"] if rng.uniform() < 0.4 else []
    return files, ["unwrap", name, "-o", "out.nc", "--method", method, *tile]


def plain_hdf5(data: xr.Dataset) -> bytes:
    """Content of an HDF5 file whose dimensions have no names."""
    with h5py.File(buffer := io.BytesIO(), "w") as file:
        for name, variable in data.variables.items():
            file[str(name)] = variable.to_numpy()
    return buffer.getvalue()


def reaching_out(raw: bytes, rng: np.random.Generator) -> bytes:
    """A file that takes a variable out of another one, or out of a pipe."""
    with h5py.File(buffer := io.BytesIO(raw), "r+") as file:
        other = str(rng.choice(["pipe.nc", "/etc/hostname", "m.nc"]))
        if rng.uniform() < 0.5:
            file["dark"] = h5py.ExternalLink(other, "/dark")
        else:
            layout = h5py.VirtualLayout((8,), "u1")
            layout[:] = h5py.VirtualSource(other, "dark", (8,))
            file.create_virtual_dataset("dark", layout)
    return buffer.getvalue()


def pictures(rng: np.random.Generator) -> Made:
    """Images of depth and light of odd levels, kinds and sizes, alone or as a TUM sequence."""
    depth = rng.integers(800, 1100, (12, 16)) * int(rng.choice([1, 5, 8]))
    depth = np.where(rng.uniform(size=depth.shape) < 0.2, rng.choice([0, 65535]), depth)
    light = rng.integers(0, 256, [(12, 16, 3), (24, 32, 3), (12, 16)][rng.integers(3)])
    kinds = [np.uint16, np.uint8, np.float32]
    files: Files = {
        "d.png": png(depth.astype(kinds[rng.integers(2)])),
        "c.png": png(light.astype(np.uint8 if light.ndim > 2 else kinds[rng.integers(2)])),
        "rgb.txt": rng.choice([b"1.0 c.png\n", b"", b"x\n", b"nan c.png\n", b"1 /dev/zero\n"]),
        "depth.txt": b"1.01 d.png\n",
    }
    np.save(buffer := io.BytesIO(), depth.astype(kinds[rng.integers(3)]))
    files["d.npy"] = buffer.getvalue()
    broken = str(rng.choice(["d.png", "c.png", "d.npy"]))
    if rng.uniform() < 0.3:
        files[broken] = damaged(files[broken] or b"", rng)
    scale = ["--depth-scale", str(rng.choice(["1000", "8000", "5000", "nan", "1e-300"]))]
    source = str(rng.choice(["d.png", "d.npy", "."]))
    how = [*scale, *(["--linear"] if rng.uniform() < 0.5 else [])]
    light_of = ["--intensity", "c.png"] if source != "." else []
    if rng.uniform() < 0.5:
        return files, ["simulate", source, "-o", "out.nc", *light_of, *how]
    scores = ["--method", "middle", "--json", "out.json"]
    return files, ["evaluate", source, *light_of, *how, *scores]


def png(pixels: np.ndarray) -> bytes:
    """Content of a PNG."""
    Image.fromarray(pixels).save(buffer := io.BytesIO(), "png")
    return buffer.getvalue()


def card(rng: np.random.Generator) -> Made:
    """Weights whose card or whose numbers are not theirs."""
    path = ROOT / "src/cmtof/weights/fast-scnn-light.released.safetensors"
    known = json.loads(path.with_suffix(".json").read_text("utf-8"))
    content = path.read_bytes()
    files: Files = {"m.nc": netcdf(whole_measurement()), "w.json": json.dumps(known).encode()}
    match int(rng.integers(3)):
        case 0:
            files["w.json"] = document(rng, known)
        case 1:
            content = damaged(content, rng)
            known["sha256"] = hashlib.sha256(content).hexdigest()
            files["w.json"] = json.dumps(known).encode()
        case 2:
            known[str(rng.choice(["classes", "first_wrap", "model", "protocol"]))] = [
                -1, 0.5, [1], 10**9, "full", "fast-scnn", None, {},
            ][rng.integers(8)]  # fmt: skip
            files["w.json"] = json.dumps(known).encode()
    method = "u-net" if rng.uniform() < 0.2 else "fast-scnn-light"
    command = ["unwrap", "m.nc", "-o", "out.nc", "--method", method, "--weights", "w.safetensors"]
    return files | {"w.safetensors": content}, command


def rig(rng: np.random.Generator) -> Made:
    """A description of an instrument."""
    import yaml

    known = yaml.safe_load((ROOT / "src/cmtof/hardware/rig.yml").read_text("utf-8"))
    known |= {"phases": 16, "field_of_view_deg": [9, 9], "twin": {"scene": {"kind": "plane"}}}
    known["rate"] = 24000.0
    return {"rig.yml": document(rng, known)}, ["scan", "rig.yml", "-o", "out.nc", "--size", "2"]


@cache
def whole_journal() -> bytes:
    """Journal of a scan of 2 x 2 px that was stopped before its last lines."""
    from cmtof.hardware.plan import planned
    from cmtof.hardware.rig import Rig
    from cmtof.hardware.scan import scan
    from cmtof_lab.rehearsal import simulated_bench

    def stop(line):
        if line.index == 30:
            raise KeyboardInterrupt

    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder, "out.nc")
        settings = Rig.default()
        bench = simulated_bench(settings, "still_life", seed=0)
        with contextlib.suppress(KeyboardInterrupt):
            scan(planned(settings, size=2), lambda: bench, output, report=stop)
        return output.with_name("out.nc.journal").read_bytes()


def journal(rng: np.random.Generator) -> Made:
    """A scan that was begun, whose journal was damaged or made up."""
    lines = whole_journal().splitlines(keepends=True)
    if rng.uniform() < 0.4:
        data = damaged(b"".join(lines), rng)
    else:
        k = int(rng.integers(len(lines)))
        held = json.loads(lines[k][9:])
        name = list(held)[rng.integers(len(held))]
        if rng.uniform() < 0.2:
            del held[name]
        else:
            held[name] = strange_value(rng)
        content = json.dumps(held, default=str).encode()
        content = b"[" * 5000 if rng.uniform() < 0.05 else content
        lines[k] = b"%08x %s\n" % (zlib.crc32(content), content)
        data = b"".join(lines + lines[1:] * int(rng.integers(2)))
    resume = ["--resume"] if rng.uniform() < 0.9 else []
    return {"out.nc.journal": data}, ["scan", "--twin", "--size", "2", "-o", "out.nc", *resume]


def configuration(rng: np.random.Generator) -> Made:
    """A configuration of a training."""
    stage = {"name": "a", "crops": 8, "crop": 32, "batch": 2, "noise": [30, 60], "rate": [1e-3, 1]}
    known = {"model": "fast-scnn", "protocol": "released", "seed": 1, "rooms": {}, "name": "n"}
    if rng.uniform() < 0.4:
        stage[str(rng.choice(list(stage)))] = strange_value(rng)
    known |= {"stages": [stage], "precision": "bf16-mixed", "save_every": 10}
    return {"c.yml": document(rng, known)}, ["train", "c.yml", "-o", "run", "--data", "none"]


def options(rng: np.random.Generator) -> Made:
    """A command line with extreme options, or with files that are no regular ones."""
    numbers = ["nan", "inf", "-1", "0", "1e300", "9" * 400, "1000000001", "x", "", "1e-320"]
    numbers += [str(10**23), str(2**63), "pipe.yml", "/dev/zero", "/dev/null", "/", "\udcff"]
    value = str(rng.choice(numbers))
    simulate = ["simulate", "still_life"]
    unwrap = ["unwrap", "m.nc", "-o", "out.nc"]
    render = ["render", "--scenes", "1", "--views", "1", "--workers", "1", "-o", "set"]
    commands = [
        [*simulate, "-o", "out.nc", "--noise", value],
        [*simulate, "-o", "out.nc", "--frequencies", f"7.15e9,{value}"],
        [*simulate, "-o", "out.nc", "--seed", value],
        [*simulate, "-o", value],
        ["simulate", value, "-o", "out.nc"],
        [*unwrap, "--range", value, "2"],
        [*unwrap, "--method", "beat", "--window", value],
        [*unwrap, "--method", "fast-scnn", "--weights", value],
        [*unwrap, "--ply", value],
        ["unwrap", value, "-o", "out.nc"],
        ["evaluate", "still_life", "--method", value],
        ["evaluate", value, "--method", "middle"],
        ["evaluate", "still_life", "--method", "middle", "--json", value],
        ["evaluate", "still_life", "--method", "middle", "--json", "no/such.json"],
        [*render, "--size", f"{value}x8"],
        [*render, "--size", "8x8", "--focal", value],
        [*render, "--size", "8x8", "--seed", value],
        ["scan", "--twin", "--size", value, "-o", "out.nc"],
        ["scan", "--twin", "--size", "2", "--seed", value, "-o", "out.nc"],
        ["scan", "--twin", "--size", "2", "--scene", value, "-o", "out.nc"],
        ["scan", value, "-o", "out.nc"],
        ["train", value, "-o", "run"],
        ["train", "miniature", "--data", value, "-o", "run"],
        ["train", "miniature", "--seed", value, "--data", "none", "-o", "run"],
        ["info", value],
        ["info", "pipe.nc"],
    ]
    files: Files = {"pipe.yml": None, "pipe.nc": None, "m.nc": netcdf(whole_measurement())}
    return files, commands[rng.integers(len(commands))]


KINDS: list[Callable[[np.random.Generator], Made]] = [
    frame, measurement, measurement, rig, configuration, options, options,
    card, journal, foreign, foreign, pictures,
]  # fmt: skip


# --- one case -------------------------------------------------------------------------------------


def started(command: list[str], folder: str | Path, err: IO[str]) -> int:
    """Run a command in a process of its own, in a folder; return its number."""
    from cmtof.cli import main

    if (child := os.fork()) == 0:
        code = 99
        try:
            os.chdir(folder)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            os.dup2(err.fileno(), 2)
            sys.stdout = os.fdopen(1, "w")
            sys.stderr = os.fdopen(2, "w", buffering=1)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            signal.setitimer(signal.ITIMER_PROF, 20 * SECONDS)
            signal.alarm(STUCK)
            if torch := sys.modules.get("torch"):
                torch.set_num_threads(1)  # a fork does not copy OpenMP's threads, and would wait
            main(command)
            code = 0
        except KeyboardInterrupt:
            code = 130
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
        finally:
            gc.collect()  # what destructors have to say
            sys.stderr.flush()
            os._exit(code)
    return child


def run(case: int) -> tuple[list[str], int]:
    """Run a case in a process of its own; return what is wrong, with its command, and its code."""
    files, command = KINDS[case % len(KINDS)](np.random.default_rng(case))
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+") as err:
        for name, content in files.items():
            path = Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            os.mkfifo(path) if content is None else path.write_bytes(content)
        _, status, usage = os.wait4(started(command, folder, err), 0)
        err.seek(0)
        said = err.read()
        left = {p.relative_to(folder).as_posix() for p in Path(folder).rglob("*") if p.is_file()}
        left -= files.keys()
        code = os.waitstatus_to_exitcode(status)
        kept = (Path(folder, n).read_bytes() == held for n, held in files.items() if held)
        same = (code == 0 and KINDS[case % len(KINDS)] is journal) or all(kept)
    wrong = []
    if code not in (0, 1, 2):
        wrong.append(f"ended with {code}")
    one = said.count("\n") == 1 and said.startswith("cmtof: Expected ")
    if (code == 1 and not one) or "Traceback" in said or "a defect" in said:
        wrong.append(f"said {said[-400:]!r}")
    if code == 0 and said.strip() and "is untrained" not in said:
        wrong.append(f"succeeded and said {said[-400:]!r}")
    if code != 0 and left:
        wrong.append(f"left {sorted(left)}")
    if not same:
        wrong.append("changed its input")
    if usage.ru_utime + usage.ru_stime > SECONDS:
        wrong.append(f"took {usage.ru_utime + usage.ru_stime:.0f} s")
    if usage.ru_maxrss > 1024 * MEGABYTES:
        wrong.append(f"held {usage.ru_maxrss / 1024:.0f} MB")
    return [f"case {case}, {' '.join(command)!r}: {one}" for one in wrong], code


def loaded() -> None:
    """Import what cases need, and compile, once for all of them."""
    from importlib import import_module

    from cmtof.measurement import Measurement
    from cmtof.methods import METHODS
    from cmtof.unwrapping import unwrap

    with warnings.catch_warnings(action="ignore"):
        for name in ("evaluation", "hardware.scan", "network.training"):
            with contextlib.suppress(ImportError):
                import_module(f"cmtof.{name}")
        for name in METHODS:
            with contextlib.suppress(ValueError):
                unwrap(Measurement(whole_measurement().copy(deep=True)), method=name)
    whole_journal()
    gc.collect()
    gc.freeze()  # or every process would look at all of it again


def main(count: int, first: int = 0) -> int:
    """Run cases that are not done yet, write the report, and return the exit code."""
    os.environ |= {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
    code = b"".join(p.read_bytes() for p in [Path(__file__), *sorted((ROOT / "src").rglob("*.py"))])
    digest = hashlib.sha256(code).hexdigest()[:16]
    place = ROOT / "build" / "fuzz" / f"{digest}.jsonl"
    place.parent.mkdir(parents=True, exist_ok=True)
    place.touch()
    done = {one["case"]: one for one in map(json.loads, place.read_text("utf-8").splitlines())}
    loaded()
    with place.open("a", encoding="utf-8", buffering=1) as file:
        for case in range(first, first + count):
            if case not in done:
                wrong, ended = run(case)
                done[case] = {"case": case, "code": ended, "wrong": wrong}
                file.write(json.dumps(done[case]) + "\n")
            for line in done[case]["wrong"]:
                print(line, flush=True)
    cases = [done[case] for case in range(first, first + count)]
    failures = [line for one in cases for line in one["wrong"]]
    codes: dict[str, Counter] = {kind.__name__: Counter() for kind in KINDS}
    for one in cases:
        codes[KINDS[one["case"] % len(KINDS)].__name__][f"exit {one['code']}"] += 1
    report = {"cases": count, "code": digest, "failures": failures, "kinds": codes}
    text = json.dumps(report, indent=1, sort_keys=True) + "\n"
    (ROOT / "book" / "results" / "fuzz.json").write_text(text, encoding="utf-8")
    print(f"{count} cases from {first}, {len(failures)} failures")
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
