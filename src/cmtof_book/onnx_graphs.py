"""Graphs of all networks, ONNX files without weights, beside the weights of the package.

    python -m cmtof_book.onnx_graphs

Only a change of `cmtof.network.models` asks for it: other weights of a model fit its graph.
"""

import gzip
import io
import warnings
from itertools import product

import onnx
import torch
from onnx.external_data_helper import set_external_data

from cmtof.network.features import CLASSES
from cmtof.network.models import MODELS, Network, build_network
from cmtof.network.weights import FOLDER


def graph_of(network: Network) -> bytes:
    """ONNX graph of a network's body, whose weights are named and left out.

    It states what it reads and answers. Norms stay apart: ONNX Runtime folds them at its start.
    Where the last layer's answer would be larger than what it reads, its weights are handed on.
    """
    kind = network.model.features
    answers = [network.target]
    network.forward = network.body
    last = getattr(network, "output", None)
    if last and last.out_channels > last.in_channels:
        answers = ["before_output", "weight", "bias"]
        network.forward = lambda x: (network.before_output(x), last.weight, last.bias)  # pyright: ignore[reportAttributeAccessIssue]
    for weight in network.state_dict().values():
        if weight.is_floating_point():
            weight.uniform_()  # equal ones would become one
    written = io.BytesIO()
    with warnings.catch_warnings(action="ignore"):
        torch.onnx.export(
            network.eval(),
            (torch.zeros(1, network.inputs, 64, 64),),
            written,  # pyright: ignore[reportArgumentType]
            dynamo=False,
            opset_version=17,
            do_constant_folding=False,
            training=torch.onnx.TrainingMode.PRESERVE,  # or names of weights would be lost
            input_names=[kind],
            output_names=answers,
            dynamic_axes={kind: {2: "rows", 3: "columns"}, answers[0]: [1, 2, 3]},  # pyright: ignore[reportArgumentType]
        )
    model = onnx.load_from_string(written.getvalue())
    for weight in model.graph.initializer:  # handed over when the network is made ready
        set_external_data(weight, "weights")
        weight.ClearField("raw_data")
    onnx.helper.set_model_props(
        model,
        {"features": kind, "target": network.target, "stride": str(network.stride)},
    )
    return model.SerializeToString(deterministic=True)


def main() -> None:
    """Write the graph of every model and protocol."""
    for name, protocol in product(MODELS, CLASSES):
        path = FOLDER / f"{name}.{protocol}.onnx.gz"
        path.write_bytes(
            gzip.compress(graph_of(build_network(name, protocol)), mtime=0)
        )
        print(f"{path.name}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
