"""ONNX models, put together from a network's graph and its weights.

A message of protobuf goes on where another ends, so that weights are written behind the graph.
"""

import gzip
from collections.abc import Mapping

from numpy.typing import NDArray

from cmtof.network.weights import FOLDER, Refused


def read_graph(model: str) -> bytes:
    """Graph of a model, an ONNX file without weights."""
    path = FOLDER / f"{model}.onnx.gz"
    if not path.is_file():
        raise Refused("no such model")
    return gzip.decompress(path.read_bytes())


def onnx_model(graph: bytes, arrays: Mapping[str, NDArray]) -> bytes:
    """ONNX model of a graph and its weights, in single precision.

    Fields are those of onnx.proto: ``ModelProto.graph`` is 7, ``GraphProto.initializer`` 5.
    """
    weights = b""
    for name, array in arrays.items():
        if array.dtype.kind == "f":
            weights += _field(5, _tensor(name, array))
    return graph + _field(7, weights)


def _tensor(name: str, array: NDArray) -> bytes:
    """TensorProto: dims (1), data_type (2; 1 is float), name (8), raw_data (9)."""
    sizes = b""
    for size in array.shape:
        sizes += b"\x08" + _varint(size)
    content = array.astype("<f4").tobytes()
    return sizes + b"\x10\x01" + _field(8, name.encode()) + _field(9, content)


def _field(number: int, content: bytes) -> bytes:
    """Field of protobuf that holds bytes."""
    return _varint(8 * number + 2) + _varint(len(content)) + content


def _varint(number: int) -> bytes:
    """Whole number, seven bits a byte, the lowest first."""
    if number < 128:
        return bytes([number])
    return bytes([128 + number % 128]) + _varint(number // 128)
