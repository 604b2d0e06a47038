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

from cmtof.network.features import CLASSES
from cmtof.network.models import MODELS, Network, build_network
from cmtof.network.weights import FOLDER

OPSET = 17


def graph_of(network: Network) -> bytes:
    """ONNX graph of a network's body, whose weights are named and left out.

    It states what it reads and answers. Norms stay apart: ONNX Runtime folds them at its start.
    The last layer is left out where its answer would be larger than what it reads.
    """
    kind = network.model.features
    answer = network.target
    network.forward = network.body
    if network.classes > getattr(network, "head_width", network.classes):
        answer = "before_output"
        network.forward = network.before_output
    for weight in network.state_dict().values():
        if weight.is_floating_point():
            weight.uniform_()  # equal ones would become one
    written = io.BytesIO()
    with warnings.catch_warnings(action="ignore"):
        torch.onnx.export(
            network.eval(),
            (torch.zeros(1, network.inputs, 64, 64),),
            written,
            dynamo=False,
            opset_version=OPSET,
            export_params=False,
            do_constant_folding=False,
            training=torch.onnx.TrainingMode.PRESERVE,  # or names of weights would be lost
            input_names=[kind],
            output_names=[answer],
            dynamic_axes={kind: {2: "rows", 3: "columns"}, answer: [2, 3]},
        )
    model = onnx.load_from_string(written.getvalue())
    for weight in model.graph.input[1:]:
        model.graph.initializer.append(outside(weight))
    del model.graph.input[1:]
    about = {"features": kind, "target": network.target, "stride": str(network.stride)}
    onnx.helper.set_model_props(model, about)
    return model.SerializeToString(deterministic=True)


def outside(weight: onnx.ValueInfoProto) -> onnx.TensorProto:
    """A weight that is handed over when the network is made ready."""
    kind = weight.type.tensor_type
    tensor = onnx.TensorProto(name=weight.name, data_type=kind.elem_type)
    tensor.dims.extend(side.dim_value for side in kind.shape.dim)
    tensor.data_location = onnx.TensorProto.EXTERNAL
    tensor.external_data.add(key="location", value="weights")
    return tensor


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
