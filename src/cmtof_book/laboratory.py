"""Data of the book's laboratory, a page that simulates and unwraps: scenes and the light network.

    python -m cmtof_book.laboratory FOLDER

They are scripts that hold data, since a page that is opened from a file may fetch nothing.
"""

import gzip
import json
import sys
from pathlib import Path

import numpy as np
import onnx
from numpy.typing import NDArray

from cmtof.frame import Frame, held_out_frames
from cmtof.network.inference import read_graph
from cmtof.network.weights import read_weights, weights_path
from cmtof.scenes import load_frame
from cmtof.simulation import simulate
from cmtof.types import Fields
from cmtof_book import ROOT
from cmtof_book.provenance import letters

RUNTIME = ROOT / "book/runtime"
SCRIPTS = {
    "script": "ort.wasm.min.js",
    "loader": "ort-wasm-simd-threaded.mjs",
    "binary": "ort-wasm-simd-threaded.wasm",
}
SIDE = 256  # px, of a scene
DEPTH_STEP = 2e-5  # m, of stored depths
ROOMS = {"study": 5, "living room": 16}  # frames of the test set
OBJECTS = ("bust", "owl", "helmet")


def light_network() -> bytes:
    """ONNX model of the light network with its weights."""
    arrays, card = read_weights(weights_path("fast-scnn-light", "released"))
    model = onnx.load_from_string(read_graph(card))
    for weight in model.graph.initializer:
        weight.CopyFrom(
            onnx.numpy_helper.from_array(
                arrays[weight.name].astype(np.float32), weight.name
            )
        )
    return model.SerializeToString()


def scenes() -> dict[str, Frame]:
    """Frames by what the page calls them: rooms, the staircase, and scanned objects."""
    tested = held_out_frames()
    return {
        **{name: tested[number] for name, number in ROOMS.items()},
        "staircase": load_frame("stairs"),
        **{name: object_frame(name) for name in OBJECTS},
    }


def object_frame(name: str) -> Frame:
    """A scanned object as the instrument sees it, lit from where it looks."""
    from cmtof_lab.objects import FIELD_OF_VIEW
    from cmtof_lab.optics import directions_from_angles
    from cmtof_lab.targets import scene_from

    half = FIELD_OF_VIEW[name] / 2
    along = np.linspace(-half, half, SIDE)
    seen = scene_from({"kind": "object", "name": name}).look(  # pyright: ignore[reportOptionalMemberAccess]
        directions_from_angles(np.dstack(np.meshgrid(along, along)))
    )
    return Frame(seen.range, seen.reflectance * seen.cosine, name=name)


def packed_scene(frame: Frame) -> Fields:
    """Size, depth in steps, 16 bit, light, 8 bit, and mask of the middle of a simulated frame."""
    measured = simulate(frame, noise_free=True)
    place = tuple(slice(max(0, n - SIDE) // 2, (n + SIDE) // 2) for n in measured.shape)
    depth = np.nan_to_num(measured.depth[place])  # pyright: ignore[reportOptionalSubscript]
    height, width = depth.shape
    return {
        "width": width,
        "height": height,
        "step": DEPTH_STEP,
        "depth": pack(np.rint(depth / DEPTH_STEP).astype("<u2")),
        "light": pack(
            np.rint(255 * np.minimum(frame.intensity[place], 1)).astype(np.uint8)
        ),
        "mask": pack(measured.mask[place]),
    }


def pack(content: bytes | NDArray) -> str:
    """Content compressed by gzip, as base64 text."""
    return letters(gzip.compress(bytes(content), mtime=0))


def write(folder: Path) -> None:
    """Write ``scenes.js``, ``runtime.js``, and phases as a reader has them: ``example.csv``."""
    frames = scenes()
    room = simulate(frames["study"].middle(96, 128))
    np.savetxt(folder / "example.csv", np.concatenate(room.phase), "%.3f", ",")
    drawn = {name: packed_scene(frame) for name, frame in frames.items()}
    runtime = {
        key: letters((RUNTIME / f"{name}.gz").read_bytes())
        for key, name in SCRIPTS.items()
    }
    runtime["model"] = pack(light_network())
    for name, data in {"scenes": drawn, "runtime": runtime}.items():
        (folder / f"{name}.js").write_text(
            f"laboratory.{name} = {json.dumps(data)};\n", "utf-8"
        )


if __name__ == "__main__":
    write(Path(sys.argv[1]))
