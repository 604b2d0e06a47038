"""Networks as ONNX graphs, for machines without torch, and a runner of such graphs.

A graph ends either in the weights of all classes or in the likeliest class and its odds. The second
is made of `cmtof.network.phased.Phased`, which never holds all channels at full resolution: it
gives the same, sooner.
"""

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from cmtof.files import written_whole
from cmtof.network.fast_scnn import FastSCNN
from cmtof.network.phased import Phased

INPUT, OUTPUT = "features", {False: "weights", True: "likeliest_and_odds"}

SIDE = 32
"""Side of the image that the graph is traced with; it holds for any other."""


def export_network(network: FastSCNN, path: Path, *, likeliest: bool = False) -> Path:
    """Write a network as an ONNX graph for images of any height and width.

    Parameters
    ----------
    network : FastSCNN
        In eval mode.
    path : Path
        File to write.
    likeliest : bool
        End in the likeliest class and its odds (B, 2, H, W) instead of the class weights
        (B, N, H, W); a network with a skip then asks for even H and W, at least 8 px.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        If the network is in training mode.

    Examples
    --------
    >>> import tempfile
    >>> from cmtof.network.building import build_network
    >>> network = build_network("fast-scnn-light", 21).eval()
    >>> path = export_network(network, Path(tempfile.mkdtemp()) / "light.onnx")
    >>> Runner(path)(np.zeros((1, 38, 9, 12), np.float32)).shape
    (1, 21, 9, 12)
    """
    if network.training:
        raise ValueError("Expected a network in eval mode, got one in training. Call eval().")
    plain = network.join is not None and not likeliest
    module = network if plain else Phased(network, likeliest=likeliest).eval()
    with written_whole(path) as part:
        _trace(module, network.inputs, OUTPUT[likeliest], part)
        even = likeliest and network.join is not None
        _describe(part, classes=network.classes, multiple=2 if even else 1)
    return path


def _trace(module: torch.nn.Module, channels: int, output: str, path: Path) -> None:
    sizes = {0: "batch", 2: "height", 3: "width"}
    with warnings.catch_warnings(), torch.inference_mode():
        # traced, in a second; torch.export takes a minute over the symbols H and W, to the same end
        warnings.simplefilter("ignore", DeprecationWarning)
        # slices are not folded; instance norms have no mode of inference
        warnings.filterwarnings("ignore", "(Constant folding|ONNX export mode)", UserWarning)
        warnings.filterwarnings("ignore", category=torch.jit.TracerWarning)  # type: ignore[attr-defined]
        torch.onnx.export(
            module,
            (torch.zeros(1, channels, SIDE, SIDE),),
            path,
            input_names=[INPUT],
            output_names=[output],
            dynamic_axes={INPUT: sizes, output: sizes},
            opset_version=18,
            dynamo=False,
        )


def _describe(path: Path, **facts: int) -> None:
    """Note in the graph what a caller has to know of it."""
    import onnx

    model = onnx.load(path)
    onnx.helper.set_model_props(model, {name: str(fact) for name, fact in facts.items()})
    onnx.checker.check_model(model)
    onnx.save(model, path)


class Runner:
    """An ONNX graph, run by ONNX Runtime on the CPU.

    Parameters
    ----------
    path : Path
        As `export_network` wrote it.
    threads : int

    Raises
    ------
    ValueError
        If there is no such graph.
    """

    def __init__(self, path: Path, *, threads: int = 1) -> None:
        import onnxruntime

        if not Path(path).is_file():
            raise ValueError(f"Expected an ONNX graph in {path}, got none. Export it first.")
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = threads
        options.log_severity_level = 3
        self.session = onnxruntime.InferenceSession(
            str(path), options, providers=["CPUExecutionProvider"]
        )
        self.facts = {
            k: int(v) for k, v in self.session.get_modelmeta().custom_metadata_map.items()
        }

    def __call__(self, features: NDArray[np.float32]) -> NDArray[np.float32]:
        """Run the graph on features (B, C, H, W); a ValueError if it does not take this size."""
        multiple = self.facts.get("multiple", 1)
        if any(size % multiple for size in features.shape[-2:]):
            raise ValueError(
                f"Expected sides that are multiples of {multiple}, got {features.shape[-2:]}. Crop "
                "a row or column, or export the class weights, which take any size."
            )
        found: Any = self.session.run(None, {INPUT: np.ascontiguousarray(features, np.float32)})
        return found[0]


class Agreement(NamedTuple):
    """How far a graph lies from the network that it was made of."""

    error: float
    """Largest difference: of weights over the largest weight, or of odds."""
    same: float
    """Share of pixels with the same likeliest class."""


def check_export(
    path: Path,
    network: FastSCNN,
    shapes: Sequence[tuple[int, int]] = ((64, 96), (72, 40)),
    *,
    tolerance: float = 1e-4,
    seed: int = 0,
) -> Agreement:
    """Hold a graph against its network on noise of several sizes.

    Returns
    -------
    Agreement
        The worst of all sizes.

    Raises
    ------
    ValueError
        If they differ by more than the tolerance, or in a class that leads by more than that.
    """
    runner, rng = Runner(path), np.random.default_rng(seed)
    found = [_compared(runner, network, shape, tolerance, rng) for shape in shapes]
    worst = Agreement(max(a.error for a in found), min(a.same for a in found))
    if worst.error > tolerance:
        raise ValueError(
            f"Expected {path.name} to agree with its network to {tolerance:g}, got "
            f"{worst.error:.2g}. Export it anew."
        )
    return worst


def _compared(
    runner: Runner,
    network: FastSCNN,
    shape: tuple[int, int],
    tolerance: float,
    rng: np.random.Generator,
) -> Agreement:
    inputs = rng.standard_normal((1, network.inputs, *shape)).astype(np.float32)
    with torch.inference_mode():
        weights = network(torch.from_numpy(inputs))
    likeliest, found = weights.argmax(1).numpy(), runner(inputs)
    if found.shape[1] == network.classes:
        error = float(np.abs(found - weights.numpy()).max() / weights.abs().max())
        return Agreement(error, float(np.mean(found.argmax(1) == likeliest)))
    odds, second = torch.softmax(weights, 1).topk(2, 1).values.numpy().swapaxes(0, 1)
    differ = found[:, 0] != likeliest
    off = np.abs(found[:, 1] - odds)
    # a class that leads by less than rounding may be either
    off = np.where(differ & (odds - second > tolerance), np.inf, off)
    return Agreement(float(off.max()), float(1 - differ.mean()))
