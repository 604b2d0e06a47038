"""Hostile inputs for the command line, made from a seed."""

import contextlib
import hashlib
import io
import json
import math
import zlib
from functools import partial

import numpy as np
import yaml
from contents import (
    netcdf,
    netcdf_3,
    npz,
    plain_arrays,
    plain_hdf5,
    png,
    reaching_out,
    whole_journal,
    whole_measurement,
)

from cmtof_book import ROOT

# --- damage ---------------------------------------------------------------------------------------


def damaged(rng, data):
    """Bytes with flipped bits, a lost end, a blanked or doubled piece, or a header written over."""
    out = bytearray(data)
    first, second = sorted(rng.choices(range(len(out) + 1), k=2))
    piece = slice(first, min(second, first + 4096))
    match rng.randrange(5):
        case 0:
            for place in rng.choices(range(len(out)), k=rng.randrange(1, 30)):
                out[place] ^= 1 << rng.randrange(8)
        case 1:
            del out[first:]
        case 2:
            out[piece] = bytes(len(out[piece]))
        case 3:
            out[first:first] = out[piece]
        case 4:
            out[:64] = rng.randbytes(len(out[:64]))
    return bytes(out)


def perhaps_damaged(rng, data, share):
    """Bytes, of which a share of the cases is damaged."""
    return damaged(rng, data) if rng.random() < share else data


TYPES = "U3 S2 c16 M8[s] m8[s] V4 i1,f4 ? f2 u8 f8 O"


def strange_array(rng):
    """An array of a kind or shape that no frame has."""
    shape = rng.choice([(), (0,), (3,), (4, 5), (1, 1), (2, 3, 4), (0, 7)])
    kind = rng.choice(TYPES.split())
    if kind not in ("f2", "f8"):
        return np.zeros(shape, kind)
    values = rng.choices([np.nan, np.inf, -1.0, 0.0, 1e300, 1.0], k=math.prod(shape))
    with np.errstate(over="ignore"):
        return np.reshape(values, shape).astype(kind)


def strange_value(rng):
    """A value that no setting has."""
    return rng.choice([
        "", "text", "nan", -1, 0, 1.5, 1e308, -1e308, 10**400, True, None, [], {}, [[1]], {1: 2}
    ])  # fmt: skip


def document(rng, known):
    """YAML or JSON: deep, aliased, of wrong kinds, of unknown names, or no text at all."""
    aliases = [f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 9)}]" for i in range(11)]
    documents = [
        "[" * 20_000 + "]" * 20_000,
        "\n".join(["a0: &a0 [x, x, x, x, x, x, x, x, x]", *aliases]),
        json.dumps({str(strange_value(rng)): 1} | known, default=str),
        f"{next(iter(known))}: {'9' * 5000}\n",
        "1: 2\n? [a, b]\n: c\n",
        json.dumps(known | {rng.choice(list(known)): strange_value(rng)}, default=str),
    ]
    return rng.choice([rng.randbytes(rng.randrange(300)), *map(str.encode, documents)])


# --- kinds of input: files by name (None is a pipe), and the command that reads them --------------


def frame(rng):
    """A frame whose arrays are strange or whose file is damaged."""
    depth = np.linspace(0.8, 1.1, 192, dtype=np.float32).reshape(12, 16)
    arrays = {
        "depth": depth,
        "intensity": np.full_like(depth, 0.5),
        "camera": np.full(4, 20.0),
    }
    if rng.random() < 0.7:
        arrays[rng.choice(list(arrays))] = strange_array(rng)
    data = perhaps_damaged(rng, npz(**arrays), 0.5)
    commands = """\
simulate f.npz -o out.nc
info f.npz
evaluate f.npz --method middle --json f.npz
evaluate . --method crt --json out.json
scan --twin --scene f.npz --size 2 -o out.nc"""
    return {"f.npz": data}, rng.choice(commands.splitlines()).split()


def strangely_filled(rng, data):
    """A measurement with strange variables or attributes."""
    match rng.randrange(6):
        case 0:
            array = strange_array(rng)
            name = rng.choice([*data.variables, "mask", "depth", "camera", "phase"])
            if array.dtype.kind not in "OVmM":
                dimensions = [f"d{i}" for i in range(array.ndim)]
                with contextlib.suppress(ValueError):  # a dimension is no scalar
                    data = data.drop_vars("psi").assign({name: (dimensions, array)})
        case 1:
            end = rng.choice(["range_min", "range_max"])
            data.attrs[end] = rng.choice([np.nan, np.inf, -1.0, 0.0, 1e6, 1e30])
        case 2:
            tone = rng.choice([1e15, 1e300, 1e-300, -1.0, np.nan, 7.15e9])
            data = data.assign_coords(frequency=[7.15e9, tone])
        case 3:
            data["mask"] = (("y", "x"), np.zeros((6, 8), bool))
        case 4:
            data.attrs["saturation"] = rng.choice([np.nan, "x", [1, 2], -1.0])
            data.attrs["protocol"] = rng.choice(["full", "x", 3, [1, 2]])
        case 5:
            data["correlation"] *= rng.choice([np.nan, -1.0, 1e30, 0.0])
    return data


def foreign(rng, data):
    """A measurement as other programs write it, or one that was made to harm."""
    match rng.randrange(8):
        case 0:
            valid = np.arange(48).reshape(6, 8) % 3 > 0
            data["mask"] = (("y", "x"), np.where(valid, 1.0, np.nan))
            fill = rng.choice([0.0, np.nan, 9.97e36, -1e30])
            data["correlation"] = data["correlation"].where(valid, fill)
        case 1:
            kind = rng.choice(["u2", "i4", "f2", "f8", "i2"])
            data["correlation"] = (data["correlation"] - 9000 * (kind == "i2")).astype(
                kind
            )
        case 2:
            data["psi"].attrs["units"] = rng.choice(["degree", "rad", "\x1b[2J", "K"])
            data["frequency"].attrs["units"] = rng.choice(["GHz", "Hz", ""])
        case 3:
            data = data.assign_coords(frequency=[16e6, rng.choice([80e6, 32e6, 17e6])])
            data.attrs = {"range_min": 0.0, "range_max": rng.choice([0.1, 9.0, 60.0])}
        case 4:
            data = data.drop_vars("psi").assign(psi=data["psi"].variable)
        case _:
            data.attrs["note"] = "\x1b[31m[red]\u202e" * rng.randrange(1, 4)
    return data


METHODS = """surfaces beat crt crt-ml kde mrf mrf-graphcut middle region spatial mode
fast-scnn-light phasor"""
OUTPUTS = """\
-o out.nc
-o out.nc
-o out.nc
-o out.nc
-o out.nc --tile 4
-o out.nc --tile 4
-o m.nc
-o out.nc --ply out.ply"""


def measurement(rng):
    """A measurement with strange or foreign content, from a strange writer, or damaged."""
    if rng.random() < 0.5:
        data = strangely_filled(rng, whole_measurement())
        writers = [netcdf] * 4 + [plain_arrays]
    else:
        data = foreign(rng, whole_measurement())
        reaching = partial(reaching_out, rng)
        writers = [*[netcdf] * 4, netcdf_3, plain_hdf5, reaching, reaching]
    write = rng.choice(writers)
    name = "m.npz" if write is plain_arrays else "m.nc"
    files = {name: perhaps_damaged(rng, write(data), 0.4), "pipe.nc": None}
    if rng.random() < 0.15:
        return files, ["info", name]
    method = rng.choice(METHODS.split())
    output = rng.choice(OUTPUTS.splitlines())
    return files, f"unwrap {name} --method {method} {output}".split()


def pictures(rng):
    """Images of depth and light of odd levels, kinds and sizes, alone or as a TUM sequence."""
    levels = np.arange(800, 1184, 2).reshape(12, 16) * rng.choice([1, 5, 8])
    levels[::3, ::4] = rng.choice([0, 65535, 900])
    light = np.indices(rng.choice([(12, 16), (24, 32)])).sum(0) * 4
    if rng.random() < 0.7:
        light = np.stack([light] * 3, axis=-1)
    np.save(buffer := io.BytesIO(), levels.astype(rng.choice(["u2", "u1", "f4"])))
    kinds = ["u1"] if light.ndim > 2 else ["u2", "u1", "?"]
    files = {
        "d.png": png(levels.astype(rng.choice(["u2", "u1"]))),
        "c.png": png(light.astype(rng.choice(kinds))),
        "d.npy": buffer.getvalue(),
        "rgb.txt": rng.choice(
            [b"1.0 c.png\n", b"", b"x\n", b"nan c.png\n", b"1 /dev/zero\n"]
        ),
        "depth.txt": b"1.01 d.png\n",
    }
    broken = rng.choice(["d.png", "c.png", "d.npy"])
    files[broken] = perhaps_damaged(rng, files[broken], 0.3)
    source = rng.choice([". ", "d.png --intensity c.png", "d.npy --intensity c.png"])
    scale = rng.choice(["1000", "8000", "5000", "nan", "1e-300"])
    linear = rng.choice(["", "--linear"])
    command = rng.choice(
        ["simulate -o out.nc", "evaluate --method middle --json out.json"]
    )
    return files, f"{command} {source} --depth-scale {scale} {linear}".split()


def card(rng):
    """Weights whose card or whose numbers are not theirs."""
    path = ROOT / "src/cmtof/weights/fast-scnn-light.released.safetensors"
    content = path.read_bytes()
    known = json.loads(path.with_suffix(".json").read_text("utf-8"))
    text = None
    match rng.randrange(3):
        case 0:
            text = document(rng, known)
        case 1:
            content = damaged(rng, content)
            known["sha256"] = hashlib.sha256(content).hexdigest()
        case 2:
            name = rng.choice(["classes", "first_wrap", "model", "protocol"])
            known[name] = rng.choice(
                [-1, 0.5, [1], 10**9, "full", "fast-scnn", None, {}]
            )
    files = {
        "m.nc": netcdf(whole_measurement()),
        "w.safetensors": content,
        "w.json": text or json.dumps(known).encode(),
    }
    method = rng.choice(["u-net", *["fast-scnn-light"] * 4])
    command = f"unwrap m.nc -o out.nc --method {method} --weights w.safetensors"
    return files, command.split()


RIG = """
phases: 16
field_of_view_deg: [9, 9]
twin: {scene: {kind: plane}}
rate: 24000.0
"""


def rig(rng):
    """A description of an instrument."""
    devices = (ROOT / "src/cmtof/hardware/rig.yml").read_text("utf-8")
    known = yaml.safe_load(devices + RIG)
    command = "scan rig.yml -o out.nc --size 2"
    return {"rig.yml": document(rng, known)}, command.split()


def journal(rng):
    """A scan that was begun, whose journal was damaged or made up."""
    lines = whole_journal().splitlines(keepends=True)
    if rng.random() < 0.4:
        data = damaged(rng, b"".join(lines))
    else:
        number = rng.randrange(len(lines))
        held = json.loads(lines[number][9:])
        name = rng.choice(list(held))
        held[name] = strange_value(rng)
        if rng.random() < 0.2:
            del held[name]
        content = json.dumps(held, default=str).encode()
        content = rng.choice([b"[" * 5000, *[content] * 19])
        lines[number] = b"%08x %s\n" % (zlib.crc32(content), content)
        data = b"".join(lines + lines[1:] * rng.randrange(2))
    resume = "--resume" * (rng.random() < 0.9)
    return {"out.nc.journal": data}, f"scan --twin --size 2 -o out.nc {resume}".split()


STAGE = "{name: a, crops: 8, crop: 32, batch: 2, noise: [30, 60], rate: [1.0e-3, 1]}"
CONFIGURATION = """
model: fast-scnn
protocol: released
seed: 1
rooms: {}
name: n
stages: []
precision: bf16-mixed
save_every: 10
"""


def configuration(rng):
    """A configuration of a training."""
    stage = yaml.safe_load(STAGE)
    if rng.random() < 0.4:
        stage[rng.choice(list(stage))] = strange_value(rng)
    known = yaml.safe_load(CONFIGURATION) | {"stages": [stage]}
    command = "train c.yml -o run --data none"
    return {"c.yml": document(rng, known)}, command.split()


COMMANDS = """\
simulate still_life -o out.nc --noise VALUE
simulate still_life -o out.nc --frequencies 7.15e9,VALUE
simulate still_life -o out.nc --seed VALUE
simulate still_life -o VALUE
simulate VALUE -o out.nc
unwrap m.nc -o out.nc --range VALUE 2
unwrap m.nc -o out.nc --method beat --window VALUE
unwrap m.nc -o out.nc --method fast-scnn --weights VALUE
unwrap m.nc -o out.nc --ply VALUE
unwrap VALUE -o out.nc
evaluate still_life --method VALUE
evaluate VALUE --method middle
evaluate still_life --method middle --json VALUE
evaluate still_life --method middle --json no/such.json
render --scenes 1 --views 1 --workers 1 -o set --size VALUEx8
render --scenes 1 --views 1 --workers 1 -o set --size 8x8 --focal VALUE
render --scenes 1 --views 1 --workers 1 -o set --size 8x8 --seed VALUE
scan --twin --size VALUE -o out.nc
scan --twin --size 2 --seed VALUE -o out.nc
scan --twin --size 2 --scene VALUE -o out.nc
scan VALUE -o out.nc
train VALUE -o run
train miniature --data VALUE -o run
train miniature --seed VALUE --data none -o run
info VALUE
info pipe.nc"""
VALUES = f"nan inf -1 0 1e300 {'9' * 400} 1000000001 x 1e-320 {10**23} {2**63}"
VALUES += " pipe.yml /dev/zero /dev/null / �"


def options(rng):
    """A command line with extreme options, or with files that are no regular ones."""
    value = rng.choice([*VALUES.split(), ""])
    command = rng.choice(COMMANDS.splitlines()).split()
    files = {"pipe.yml": None, "pipe.nc": None, "m.nc": netcdf(whole_measurement())}
    return files, [word.replace("VALUE", value) for word in command]


KINDS = [
    frame, measurement, measurement, measurement, measurement, rig, configuration, options, options,
    card, journal, pictures,
]  # fmt: skip
