"""Inference by ONNX Runtime: a network's graph and weights, and unwrapping with them.

Graphs travel with the package, without weights (`cmtof_book.onnx_graphs` writes them);
weights are those of `cmtof.network.weights`, which training goes on from. torch is not needed.
"""

import gzip
import os
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np
import xarray as xr
from onnxruntime import (
    GraphOptimizationLevel,  # pyright: ignore[reportAttributeAccessIssue]
    InferenceSession,
    OrtAllocatorType,  # pyright: ignore[reportAttributeAccessIssue]
    OrtArenaCfg,  # pyright: ignore[reportAttributeAccessIssue]
    OrtMemoryInfo,  # pyright: ignore[reportAttributeAccessIssue]
    OrtMemType,  # pyright: ignore[reportAttributeAccessIssue]
    OrtValue,
    RunOptions,  # pyright: ignore[reportAttributeAccessIssue]
    SessionOptions,  # pyright: ignore[reportAttributeAccessIssue]
    create_and_register_allocator,  # pyright: ignore[reportAttributeAccessIssue]
)

from cmtof.constants import FREQUENCIES, FREQUENCY_SINGLE
from cmtof.correlation import centred, depth_from_wraps, wrap_length
from cmtof.estimate import within_range, wraps_in_range
from cmtof.files import AnyPath
from cmtof.measurement import Measurement
from cmtof.network.features import FULL_AMPLITUDE, features, padding
from cmtof.network.weights import (
    FOLDER,
    Card,
    find_weights,
    read_weights,
    reading_weights,
)
from cmtof.simulation import QUADRATURES
from cmtof.types import Array, Arrays, Shape, Single, Texts

# Orders of rows and columns: as they are, left to right, upside down, and both.
MIRRORS = [np.s_[..., ::down, ::right] for down in (1, -1) for right in (1, -1)]

# All sessions share 256 MiB, which stay: fetching all memory in each run takes a third of the light
# network's time. What a run needs beyond them is given back after it.
create_and_register_allocator(
    OrtMemoryInfo("Cpu", OrtAllocatorType.ORT_ARENA_ALLOCATOR, 0, OrtMemType.DEFAULT),
    OrtArenaCfg({"initial_chunk_size_bytes": 2**28}),
)


@dataclass(frozen=True)
class LoadedNetwork:
    """A network that can run: a unique name, its card and its weights."""

    name: str
    card: Card = field(compare=False)
    weights: dict[str, Array] = field(compare=False)


def read_graph(card: Card) -> bytes:
    """Content of a model's ONNX file, a graph without weights."""
    path = FOLDER / f"{card.model}.{card.protocol}.onnx.gz"
    if not path.is_file():
        raise ValueError("no such model")
    return gzip.decompress(path.read_bytes())


def load_network(path: Path) -> LoadedNetwork:
    """Network with the weights of a file; a ValueError if file or card cannot be used."""
    arrays, card = read_weights(path)
    # a fork does not copy the threads of a session
    ready = LoadedNetwork(
        f"{card.model}.{card.protocol} {card.sha256} {os.getpid()}", card, arrays
    )
    with reading_weights(path, card):
        metadata_of(ready)
    return ready


@lru_cache(maxsize=8)
def session(ready: LoadedNetwork, size: Shape | None = None) -> InferenceSession:
    """Session of ONNX Runtime for images of one size (H, W), or of no size for the metadata alone.

    It fuses more layers where the size is known, in half of the memory.
    """
    options = SessionOptions()
    options.log_severity_level = 4  # an error is raised anyway
    threads = os.environ.get("OMP_NUM_THREADS", "").partition(",")[0]
    options.intra_op_num_threads = int(threads or os.cpu_count() or 1)
    options.enable_mem_pattern = False  # one block for all would be larger
    options.add_session_config_entry("session.use_env_allocators", "1")
    if size:
        options.add_free_dimension_override_by_name("rows", size[0])
        options.add_free_dimension_override_by_name("columns", size[1])
    else:
        options.graph_optimization_level = GraphOptimizationLevel.ORT_DISABLE_ALL
    initializers = {
        name: OrtValue.ortvalue_from_numpy(array.astype(np.float32))
        for name, array in ready.weights.items()
        if array.dtype.kind == "f"
    }
    options.add_external_initializers(list(initializers), list(initializers.values()))
    return InferenceSession(
        read_graph(ready.card), options, providers=["CPUExecutionProvider"]
    )


def unwrap_with_network(
    measurement: Measurement,
    *,
    model: str | None = None,
    weights: AnyPath | None = None,
    mirrored: bool = False,
) -> Arrays:
    """Depth by a network that classifies each pixel's wrap (Sec. 5) or regresses its depth.

    Weights are the shipped ones that hold every wrap in range, or a ``.safetensors`` of one's own.
    With ``mirrored`` its outputs for four mirror images are averaged, in four times the time.
    Returned are depth, m, and the probability of the chosen class, of a regression the share of
    right wraps in validation; both (H, W).
    """
    first, _ = wraps_in_range(measurement)
    ready = network_for(measurement, model, weights)
    card = ready.card
    if metadata_of(ready)["target"] == "depth":
        turns = card.classes * (0.5 + graph_output(ready, measurement, mirrored)[0])
        depth = (card.first_wrap + turns) * wrap_length(FREQUENCY_SINGLE)
        confidence = np.full_like(depth, card.validation.delta_lt_1)
    else:
        wraps = np.full(measurement.shape, first)
        confidence = np.empty(wraps.shape, np.float32)
        for rows, odds in log_odds(ready, measurement, mirrored):
            # 15 times as fast as an argmax of 358 wraps; of equal odds the lowest wrap's count
            for number in reversed(range(len(odds))):
                wraps[rows][odds[number] == 0] = first + number
            confidence[rows] = 1 / np.exp(odds, out=odds).sum(0)  # a softmax, in place
        depth = depth_from_wraps(measurement.phase[0], wraps, FREQUENCY_SINGLE)
    return within_range(depth, measurement), confidence


def network_for(
    measurement: Measurement, model: str | None, weights: AnyPath | None
) -> LoadedNetwork:
    """Network with given or shipped weights; a ValueError if it does not fit the measurement."""
    tones = measurement.frequencies
    if not np.allclose(tones, FREQUENCIES, rtol=1e-6):
        raise ValueError(
            "Expected 7.15 and 14.32 GHz, which the weights were trained at, "
            f"got {', '.join(f'{f / 1e9:g}' for f in tones)} GHz. Choose the method crt."
        )
    path = Path(
        weights or find_weights(model or "fast-scnn", *wraps_in_range(measurement))
    )
    ready = load_network(path)
    if model not in (None, ready.card.model):
        raise ValueError(
            f"Expected weights of {model}, got those of {ready.card.model}. Choose that method."
        )
    if not ready.card.trained:
        warnings.warn(
            f"{path.stem} is untrained: its card shows no gain over a trivial answer.",
            stacklevel=2,
        )
    return ready


def log_odds(
    ready: LoadedNetwork, measurement: Measurement, mirrored: bool
) -> Iterator[tuple[slice, Single]]:
    """Rows of the image, h at a time, and log-odds (N, h, W) of the wraps in range.

    Odds are against the likeliest wrap of each pixel. Raises a ValueError if the network does not
    distinguish all wraps in range.
    """
    first, last = wraps_in_range(measurement)
    card = ready.card
    low = card.first_wrap
    stop = low + card.classes
    if first < low or last >= stop:
        raise ValueError(
            f"Expected wraps within {low} to {stop - 1}, which {card.model} distinguishes, "
            f"got {first} to {last}. Narrow the range."
        )
    found = graph_output(ready, measurement, mirrored)
    step = max(2**14 // found.shape[2], 1)  # odds of more rows would leave the cache
    for top in range(0, found.shape[1], step):
        rows = slice(top, top + step)
        odds = apply_last_layer(ready, found[:, rows])[first - low : last - low + 1]
        odds -= odds.max(0)
        yield rows, odds


def apply_last_layer(ready: LoadedNetwork, found: Single) -> Single:
    """Values (N, H, W) of all classes, from the `graph_output` (C, H, W).

    That of 358 classes ends before the network's last layer, and hands on the layer's weights.
    """
    if len(session(ready).get_outputs()) == 1:
        return found
    weight = ready.weights["output.weight"][..., 0, 0]
    return np.tensordot(weight, found, 1) + ready.weights["output.bias"][:, None, None]  # pyright: ignore[reportReturnType]


def network_images(measurement: Measurement, kind: str) -> list[Single]:
    """Phase, rad, and amplitude (2, H, W); for raw features also correlations (2, 4, H, W).

    Amplitudes in other units than the simulation's counts are scaled, for each frequency, so that
    the brightest tenth of the image begins at a white surface's.
    """
    # a masked pixel may be NaN; the network gets a dark one, or its neighbours would be NaN too
    images = [measurement.phase[:2], measurement.amplitude[:2]]
    if kind == "correlation" and "correlation" in measurement.dataset:
        images.append(_at_quadratures(measurement.dataset))
    phase, amplitude, *more = (np.nan_to_num(np.asarray(x, np.float32)) for x in images)
    # noise alone has more in the simulation
    if not 0.1 < np.quantile(amplitude[0], 0.9) / FULL_AMPLITUDE < 2:
        bright = np.quantile(amplitude, 0.9, axis=(1, 2), keepdims=True)
        factor = FULL_AMPLITUDE / np.maximum(bright, np.float32(1e-30))
        amplitude *= factor
        more = [image * factor[:, None] for image in more]
    return [phase, amplitude, *more]  # pyright: ignore[reportReturnType]


def _at_quadratures(dataset: xr.Dataset) -> Array:
    """Correlations (2, 4, H, W) at psi = 0, 1/2, 1, 3/2 pi; a ValueError if not measured."""
    psi = dataset["psi"].to_numpy()[:2]
    distance = abs(centred(psi[:, :, None] - np.asarray(QUADRATURES)))
    if not (distance.min(1) <= 1e-6).all():
        raise ValueError(
            "Expected correlations at psi = 0, 1/2, 1 and 3/2 pi, which the network was trained "
            f"on, got psi = {np.round(psi[0], 3).tolist()} rad. Choose another method."
        )
    correlation = dataset["correlation"].to_numpy()[:2]
    return np.take_along_axis(correlation, distance.argmin(1)[..., None, None], axis=1)


def metadata_of(ready: LoadedNetwork) -> Texts:
    """Metadata of a network: its inputs (``features``), output (``target``), ``stride``, px."""
    return session(ready).get_modelmeta().custom_metadata_map


def graph_output(
    ready: LoadedNetwork, measurement: Measurement, mirrored: bool = False
) -> Single:
    """Output (C, H, W) of a graph for a measurement, or its mean over four mirror images."""
    kind = metadata_of(ready)["features"]
    images = network_images(measurement, kind)

    def answer(mirror):
        phase, amplitude, *more = (image[mirror] for image in images)
        return run_padded(ready, features(phase, amplitude, kind, *more)[None])[mirror]

    found = answer(())
    if mirrored:
        for mirror in MIRRORS[1:]:
            found += answer(mirror)
        found /= len(MIRRORS)
    return found


def run_padded(ready: LoadedNetwork, inputs: Single) -> Single:
    """Output (C, H, W) of a graph for inputs (1, C', H, W), padded to the network's stride."""
    metadata = metadata_of(ready)
    stride = int(metadata["stride"])
    height, width = inputs.shape[-2:]
    margins = [(0, padding(size, stride)) for size in (height, width)]
    if np.any(margins):  # or the copy would take a tenth of the time
        inputs = np.pad(inputs, [(0, 0), (0, 0), *margins], mode="edge")
    network = session(ready, inputs.shape[-2:])
    options = RunOptions()  # memory beyond the shared 256 MiB is freed at once
    options.add_run_config_entry("memory.enable_memory_arena_shrinkage", "cpu:0")
    found = network.run(None, {metadata["features"]: inputs}, options)[0]
    return found[0, :, :height, :width]  # pyright: ignore[reportArgumentType, reportCallIssue, reportIndexIssue]
