# %% [markdown]
# # How fast
#
# The paper's network takes {glue:text}`paper_small:.1f` ms for an image of 256×256 pixels and
# {glue:text}`paper_large:.0f` ms for one of 768×1024, on a V100 (Sec. 8.1). No other machine can
# agree or disagree with that. This page counts what there is to compute, which is the
# same everywhere; shows what can be saved without changing a result; and takes the time on the
# machine that made this book: **{glue:text}`machine`**, one thread. The weights are random, which a
# clock does not notice. The times are those of one run on a machine that others may be using; look
# at ratios rather than at milliseconds.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of weights and noise
models: tuple = ("fast-scnn", "fast-scnn-released", "fast-scnn-light")  # networks to time
small: tuple = (256, 256)  # sizes, px: the paper's smaller
large: tuple = (768, 1024)  # and its larger
runs: int = 3  # runs of each at the small size, of which the median is shown
large_runs: int = 1  # the same at the large size
large_eager: tuple = ("fast-scnn",)  # networks to time as torch runs them at the large size

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import torch
from IPython.display import Markdown
from myst_nb import glue

from cmtof.book import paper, plotting, provenance
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, depth_from_wraps
from cmtof.network.building import build_network
from cmtof.network.configuration import MODELS, wraps_of
from cmtof.network.cost import BLOCKS, median_seconds, multiply_adds
from cmtof.network.export import Runner, check_export, export_network
from cmtof.network.features import features

paper_run = plotting.begin(profile=profile, seed=seed)
torch.set_num_threads(1)
first, classes = wraps_of("released")
sizes = (tuple(small), tuple(large))
device = "cuda" if torch.cuda.is_available() else "cpu"


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, value if isinstance(value, str) else float(value), display=False)


machine = provenance.processor()
tell(machine=machine)

# %% [markdown]
# ## What there is to compute
#
# A convolution is a sum of products. How many there are follows from the layers alone: torch counts
# them without computing one. Sums and products of norms, ReLUs, pools and resizing are left out;
# they are few, but they move as much memory as the others.

# %%
torch.manual_seed(seed)
networks = {name: build_network(name, classes).eval() for name in models}
counts = {name: multiply_adds(network, *sizes[-1]) for name, network in networks.items()}
totals = {name: sum(count.values()) / 1e9 for name, count in counts.items()}
for name, count in counts.items():
    print(f"{name}: {totals[name]:.1f} billion at {sizes[-1][0]}×{sizes[-1][1]}:",
          ", ".join(f"{block} {value / 1e9:.1f}" for block, value in count.items()))  # fmt: skip

# %% tags=["hide-input"]
figure, ax = plt.subplots(figsize=(8.6, 0.62 * len(models) + 1.3))
left = np.zeros(len(models))
for block, colour in zip(BLOCKS, list(plotting.PALETTE.values()), strict=False):
    wide = np.array([counts[name][block] / 1e9 for name in models])
    ax.barh(models, wide, left=left, color=colour, label=block, height=0.62)
    left += wide
ax.invert_yaxis()
ax.set_xlabel(f"billion multiply-adds at {sizes[-1][0]}×{sizes[-1][1]} px")
ax.legend(ncols=len(BLOCKS), loc="lower center", bbox_to_anchor=(0.45, 1.0), fontsize="small",
          handlelength=1.0, columnspacing=1.2)  # fmt: skip
largest = max(counts[models[0]], key=lambda block: counts[models[0]][block])
plotting.save(
    figure,
    "speed_multiply_adds",
    numbers={"multiply_adds": counts},
    caption=(
        f"Multiply-adds of one image of {sizes[-1][0]}×{sizes[-1][1]} px by blocks of the network, "
        f"for {classes} classes."
    ),
    alt=(
        f"Stacked bars for {len(models)} networks, from {max(totals.values()):.1f} billion to "
        f"{min(totals.values()):.1f} billion; of {models[0]} the block {largest} has most."
    ),
)
tell(total=totals[models[0]], largest=largest,
     per_pixel=1e6 * totals[models[0]] / np.prod(sizes[-1]),
     largest_share=100 * counts[models[0]][largest] / 1e9 / totals[models[0]])  # fmt: skip

# %% [markdown]
# {glue:text}`total:.1f` billion products for one image of the paper's network as we read it,
# {glue:text}`per_pixel:.0f` thousand a pixel; the block **{glue:text}`largest`** has
# {glue:text}`largest_share:.0f` % of them. A core that does sixteen products and sums at a time,
# two or three billion times a second, needs more than a second for that, however clever the
# program.
#
# ## What need not be computed
#
# Run as they stand, the last layers bring 128 channels to full resolution and convolve each of them
# with a small kernel. Both steps are linear, so they are one: the image of twice the size is four
# interleaved ones, and each of these is a convolution of the *small* image with a kernel into which
# the weights of the resizing are multiplied (`cmtof.network.phased` has the matrices). The
# upsampled image is never made. A network without a skip gains more, for its last layer is linear
# too: resize {glue:text}`classes:.0f` classes, and not 128 features. And who wants the wrap count
# alone need not keep the classes. Nothing is approximated; the graph is written as ONNX and held
# against the network itself.

# %%
folder = Path(tempfile.mkdtemp())
runners, agreements = {}, {}
for name, network in networks.items():
    path = export_network(network, folder / f"{name}.onnx", likeliest=True)
    agreements[name] = check_export(path, network, [(32, 48), (40, 24)], seed=seed)
    runners[name] = Runner(path, threads=1)
    print(f"{name}: odds differ by {agreements[name].error:.0e}, same class in "
          f"{agreements[name].same:.2%}, {path.stat().st_size / 1e6:.1f} MB")  # fmt: skip
tell(classes=classes, odds_error=max(found.error for found in agreements.values()))

# %% [markdown]
# The odds of the graphs differ from those of torch by {glue:text}`odds_error:.0e` at most.
#
# ## By the clock
#
# Before the network come the features, out of phases and amplitudes; after it the choice of the
# class and the depth that belongs to it (the graph makes the choice itself). `eager` is torch as it
# stands, `channels last` the same with another order in memory, `ONNX` the graph above.

# %%
rng = np.random.default_rng(seed)


def timed(name, size, count):
    """Seconds of every step, for one network and size."""
    network, phase = networks[name], rng.uniform(0, TAU, (2, *size)).astype(np.float32)
    amplitude = rng.uniform(500, 6000, (2, *size)).astype(np.float32)
    given = features(phase, amplitude, MODELS[name].features)[None]
    image, runner = torch.from_numpy(given), runners[name]
    chosen = runner(given)[0]
    found = {
        "features": median_seconds(
            lambda: features(phase, amplitude, MODELS[name].features), runs=count, warm_up=0
        ),
        "ONNX": median_seconds(lambda: runner(given), runs=count, warm_up=0),
        "depth": median_seconds(
            lambda: depth_from_wraps(phase[0], first + chosen[0], FREQUENCIES[0]), runs=count
        ),
    }
    with torch.inference_mode():
        if size == sizes[0] or name in large_eager:
            found["eager"] = median_seconds(lambda: network(image), runs=count, warm_up=0)
            weights = network(image) if size == sizes[0] else torch.rand(1, classes, *size)
            found["argmax"] = median_seconds(lambda: weights.argmax(1), runs=count)
        if size == sizes[0]:
            last = torch.channels_last
            network.to(memory_format=last)  # type: ignore[call-overload]
            again = image.contiguous(memory_format=last)
            found["channels last"] = median_seconds(lambda: network(again), runs=count, warm_up=0)
            network.to(memory_format=torch.contiguous_format)  # type: ignore[call-overload]
        if device == "cuda":
            there, on_gpu = network.to(device), image.to(device)

            def once():
                there(on_gpu).argmax(1)
                torch.cuda.synchronize()

            found["GPU"] = median_seconds(once, runs=20, warm_up=5)
            network.to("cpu")
    return found


taken = {}
for name in models:
    for size, count in zip(sizes, (runs, large_runs), strict=True):
        taken[name, size] = timed(name, size, count)
        print(name, size, {k: f"{1e3 * v:.1f} ms" for k, v in taken[name, size].items()})

# %%
columns = ["features", "eager", "channels last", "ONNX", *(["GPU"] if device == "cuda" else []),
           "argmax", "depth"]  # fmt: skip
published = dict(zip(("sec8.runtime_256", "sec8.runtime_full"), sizes, strict=True))
rows = []
for size in sizes:
    for name in models:
        found = taken[name, size]
        cells = [f"{1e3 * found[key]:.1f}" if key in found else "" for key in columns]
        gain = f"{found['eager'] / found['ONNX']:.1f}" if "eager" in found else ""
        rows.append(f"| {size[0]}×{size[1]} | {name} | " + " | ".join([*cells, gain]) + " |")
head = "| px | network | " + " | ".join([*columns, "eager / ONNX"]) + " |\n|---|---|"
table = head + "---:|" * (len(columns) + 1) + "\n" + "\n".join(rows)
glue("speed_table", Markdown(table), display=False)

# %% [markdown]
# Milliseconds an image, one thread:
#
# ```{glue:md} speed_table
# :format: myst
# ```

# %% tags=["hide-input"]
ways = [key for key in ("eager", "channels last", "ONNX", "GPU") if key in columns]
figure, axes = plt.subplots(1, 2, figsize=(10.6, 3.8))
colours = dict(zip(ways, ("#9AA5AD", *(plotting.PALETTE[k] for k in ("sky", "blue", "green"))),
                   strict=False))  # fmt: skip
for ax, size, key in zip(axes, sizes, published, strict=True):
    for k, way in enumerate(ways):
        have = [(i, taken[name, size][way]) for i, name in enumerate(models)
                if way in taken[name, size]]  # fmt: skip
        if not have:
            continue
        place = [i + (k - (len(ways) - 1) / 2) * 0.8 / len(ways) for i, _ in have]
        ax.bar(place, [1e3 * t for _, t in have], 0.76 / len(ways), color=colours[way], label=way)
    number = paper.published(key)
    ax.axhline(1e3 * number.value, color=plotting.PALETTE["vermillion"], lw=1.4,
               label=f"paper, V100, {number.what.removeprefix('network on ')}")  # fmt: skip
    ax.set(yscale="log", title=f"{size[0]}×{size[1]} px", ylabel="ms an image")
    ax.set_xticks(range(len(models)), models)
    shown = [1e3 * taken[name, size][way] for name in models for way in ways
             if way in taken[name, size]]  # fmt: skip
    ax.set_ylim(0.3 * min(*shown, 1e3 * number.value), 8 * max(shown))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_formatter("")
    ax.legend(fontsize="small", ncols=2, loc="upper right", handlelength=1.2)
plotting.label_panels(axes)
plotting.save(
    figure,
    "speed_runtimes",
    numbers={"sizes": [list(size) for size in sizes], "models": list(models)},
    caption=(
        f"Time for one image by the network alone, random weights, one thread of {machine}, "
        "beside what the paper states for its network on a V100. Logarithmic: every line of the "
        "grid is a factor of ten."
    ),
    alt=(
        "Bars in groups for each network at two sizes of image. In each group the bar of torch "
        "stands highest and that of the exported graph lower; the light network is the quickest. "
        "A line far below marks the paper's GPU."
    ),
)
leading = taken[models[0], sizes[0]]
tell(
    ours_small=1e3 * leading["ONNX"],
    ours_large=taken[models[0], sizes[1]]["ONNX"],
    paper_small=1e3 * paper.published("sec8.runtime_256").value,
    paper_large=1e3 * paper.published("sec8.runtime_full").value,
    gain=leading["eager"] / leading["ONNX"],
    around=100 * (leading["features"] + leading["depth"]) / leading["ONNX"],
    rate=2 * sum(multiply_adds(networks[models[0]], *sizes[0]).values()) / leading["ONNX"] / 1e9,
)

# %% [markdown]
# In this run the graph of {glue:text}`leading` is {glue:text}`gain:.1f` times as fast as torch, at
# {glue:text}`rate:.0f` billion operations a second; features and depth add
# {glue:text}`around:.0f` %. One thread takes {glue:text}`ours_small:.0f` ms at the small size and
# {glue:text}`ours_large:.1f` s at the large one, where the paper's V100 took
# {glue:text}`paper_small:.1f` and {glue:text}`paper_large:.0f` ms for *its* network, whose layers
# we do not know: a GPU of that kind has some hundred times the arithmetic of one thread. The light
# network shows the other way to be quick, which is to compute less.
#
# The paper's own two numbers tell something too. From one size to the other there are
# {glue:text}`more_pixels:.0f` times as many pixels, and {glue:text}`more_time:.1f` times as many
# milliseconds: the smaller image does not keep the GPU busy.

# %%
stated = [paper.published(key).value for key in published]
tell(leading=models[0], more_pixels=768 * 1024 / 256**2, more_time=stated[1] / stated[0])
