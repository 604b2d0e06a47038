# %% [markdown]
# # What goes into the network
#
# A photograph has three numbers a pixel. A time-of-flight camera that works by correlation has
# four pictures at each of its frequencies, and none of them looks like a distance. This page makes
# them from a picture with known depth and turns them, step by step, into what the paper's network
# is given and what it is asked for: the inputs of its Fig. 5. All of it is simulated.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of all noise
frame: str = "still_life"  # embedded frame
order: int = 5  # highest octave of the Fourier features, E_C of Eq. 5

# %%
import matplotlib.pyplot as plt
import numpy as np
from myst_nb import glue

import cmtof
from cmtof.book import paper, plotting
from cmtof.constants import NOISE_SIGMA
from cmtof.correlation import centred, wrap_count_from_depth, wrap_length
from cmtof.network.features import fourier_features, log_amplitude, phase_edges
from cmtof.noise import phase_noise_from_sigma
from cmtof.simulation import RELEASED_FAR_DEPTH, RELEASED_WRAPS, true_phase

paper_run = plotting.begin(profile=profile, seed=seed)
blue, vermillion = plotting.PALETTE["blue"], plotting.PALETTE["vermillion"]
scene = cmtof.load_frame(frame)
protocols = ("released", "full")


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, value if isinstance(value, str) else float(value), display=False)


# %% [markdown]
# ## Four pictures, twice
#
# The light that leaves the camera swells and fades billions of times a second. On its way to the
# scene and back it falls behind, and the detector compares it with a reference of the same beat: it
# records much light where the two are in step and little where they are not. Four references, each
# a quarter turn ψ later, tell how far the light has fallen behind: its **phase** φ, and how strong
# it came back: its **amplitude** ({doc}`05_simulation` has the equations). Twice as fast a beat
# gives the same again at twice the rate. That is all that is measured.

# %%
noisy = {p: cmtof.simulate(scene, protocol=p, seed=seed) for p in protocols}
clean = {p: cmtof.simulate(scene, protocol=p, noise_free=True) for p in protocols}
measured = noisy["released"]
images = measured.dataset["correlation"].to_numpy()
steps = ("0", "π/2", "π", "3π/2")
gigahertz = measured.frequencies / 1e9
print(measured, images.shape, images.dtype)

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 6, figsize=(11.0, 3.5))
low, high = np.percentile(images, [0.5, 99.5]) / 1e3
logarithm = log_amplitude(measured.amplitude)
shown = tuple(np.percentile(logarithm, [1, 99.9]))
for row, tone, pictures, phase, light in zip(
    axes, gigahertz, images, measured.phase, logarithm, strict=True
):
    for ax, picture, step in zip(row, pictures, steps, strict=False):
        plotting.image(
            ax, picture / 1e3, label="", title=f"{tone:.2f} GHz, {step}", limits=(low, high)
        )
    plotting.phase_image(row[4], phase, title="phase", label="")
    plotting.image(row[5], light, label="", title="log amplitude", cmap="gray", limits=shown)
    row[3].images[0].colorbar.set_label("10³ counts")
plotting.save(
    figure,
    "inputs_measurement",
    numbers={
        "images": images.shape[0] * images.shape[1],
        "median_count": float(np.median(images)),
        "median_log_amplitude": [float(np.median(x)) for x in logarithm],
    },
    caption=(
        f"What is measured of the frame `{frame}`, protocol `released`, at the paper's noise: four "
        "correlation images at each frequency (ψ above each), and what is decoded from them. A "
        f"turn of the phase is {1e3 * float(wrap_length(measured.frequencies[0])):.1f} mm of depth "
        f"above, {1e3 * float(wrap_length(measured.frequencies[1])):.1f} mm below."
    ),
    alt=(
        "Two rows of four grainy images of a scene crossed by fringes that shift from one image "
        "to the next, then a phase map of cyclic colours and a grey image of the amplitude; the "
        "fringes of the lower row are twice as dense."
    ),
    format="png",
)

# %% [markdown]
# The eye sees objects in the amplitude, which is an ordinary photograph under the camera's own
# light, and contour lines in the phase. Along a surface one can follow them; across an outline one
# cannot tell how many lines lie hidden. That number is what is sought.
#
# ## The target: a count
#
# Depth is known within a wrap, but which wrap? The network is asked for the **wrap count**
#
# ```{math}
# :label: inputs-target
# n=\left\lfloor\frac{\varphi}{2\pi}\right\rfloor=\left\lfloor\frac{2f_1z}{c}\right\rfloor
# ```
#
# at the lower frequency, as a class for each pixel, the way a network that segments a street scene
# is asked for «road» or «tree». Here the classes have an order: to be off by one costs
# {glue:text}`wrap_mm:.0f` mm, to be off by twenty costs twenty times that. In `released` the scene
# is shrunk to a model of itself, no deeper than {glue:text}`model_depth:.3f` m, and the wraps
# {glue:text}`first_wrap:.0f` to {glue:text}`last_wrap:.0f` are told apart; in `full` it has its own
# size, and every wrap of the beat's {glue:text}`beat_range:.3f` m may occur.

# %%
counts, classes = {}, {}
for name, held in noisy.items():
    first, last = np.ceil(np.asarray(held.range) / wrap_length(held.frequencies[0]) - 1e-9)
    classes[name] = int(last - first)
    counts[name] = np.where(
        held.mask, wrap_count_from_depth(np.nan_to_num(held.depth), held.frequencies[0]), -1
    )
    used, sizes = np.unique(counts[name][held.mask], return_counts=True)
    print(
        f"{name}: {classes[name]} classes, {used.size} occur ({used.min()} to {used.max()}), "
        f"{held.mask.mean():.0%} of the pixels scored, commonest {sizes.max() / sizes.sum():.1%}"
    )
tell(
    wrap_mm=1e3 * wrap_length(measured.frequencies[0]),
    model_depth=RELEASED_FAR_DEPTH,
    first_wrap=RELEASED_WRAPS[0],
    last_wrap=RELEASED_WRAPS[1] - 1,
    beat_range=noisy["full"].range[1],
    classes_released=classes["released"],
    classes_full=classes["full"],
    occur_full=np.unique(counts["full"][noisy["full"].mask]).size,
    scored_released=100 * noisy["released"].mask.mean(),
    scored_full=100 * noisy["full"].mask.mean(),
)

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 3, figsize=(11.6, 5.6), width_ratios=[1, 1, 1.25])
largest = {}
for row, name in zip(axes, protocols, strict=True):
    held, mask = noisy[name], noisy[name].mask
    plotting.image(
        row[0], np.where(mask, counts[name], np.nan), label="wrap count n", title=f"{name}: target"
    )
    plotting.phase_image(row[1], held.phase[0], title="phase at 7.15 GHz", label="")
    used, sizes = np.unique(counts[name][mask], return_counts=True)
    largest[name] = float(sizes.max() / sizes.sum())
    row[2].bar(used, 100 * sizes / sizes.sum(), width=1.0, color=blue, lw=0)
    row[2].axhline(100 / classes[name], color=vermillion, lw=1.2)
    low, high = np.asarray(held.range) / float(wrap_length(held.frequencies[0]))
    row[2].set(xlim=(low - 1, high + 1), ylabel="pixels (%)", title=f"{classes[name]} classes")
axes[1, 2].set_xlabel("wrap count n")
plotting.label_panels(axes.flat)
plotting.save(
    figure,
    "inputs_protocols",
    numbers={
        "classes": classes,
        "scored": {p: float(noisy[p].mask.mean()) for p in protocols},
        "largest_class": largest,
    },
    caption=(
        "The target under both protocols, on the same frame. (a, d) The wrap count, grey where a "
        "pixel is not scored. (b, e) The phase that is measured there. (c, f) How often each "
        "class occurs; the line is an even share."
    ),
    alt=(
        "Two rows. Left, the scene in steps of depth; middle, its phase, with fringes; right, bars "
        f"over the classes: uneven bars over {classes['released']} classes above, a "
        f"clump within {classes['full']} below."
    ),
    format="png",
)
tell(largest_released=100 * largest["released"], largest_full=100 * largest["full"])

# %% [markdown]
# Both rows show one scene, and neither the phases nor the counts look the same. `released` asks for
# one of {glue:text}`classes_released:.0f` classes in {glue:text}`scored_released:.0f` % of the
# pixels; `full` for one of {glue:text}`classes_full:.0f` in {glue:text}`scored_full:.0f` %, though
# this frame uses {glue:text}`occur_full:.0f` of them. The classes are uneven: whoever always
# answers with the frame's commonest is right in {glue:text}`largest_released:.0f` % of the pixels
# of `released` and in {glue:text}`largest_full:.0f` % of `full`, without a look at the measurement.
# A rate means little before that one is known. And since rooms are alike, a network may learn where
# they have their walls instead of how phases beat.
#
# ## Fourier features: a phase without its cut
#
# A number that jumps from 2π to 0 where nothing jumps is a poor input: a convolution that smooths
# it invents values in between, half a turn off. Sine and cosine do not jump. The paper takes those
# of the octaves too,
#
# ```{math}
# :label: eq-5
# \gamma(\hat\phi)=\bigl[\cos(2^0\hat\phi),\ \sin(2^0\hat\phi),\ \cos(2^1\hat\phi),\ \ldots,\
# \sin(2^{E_C}\hat\phi)\bigr],
# ```
#
# without saying where to stop; the authors' released code stops at $E_C=5$
# ({ref}`erratum 4 <erratum-4>`). All multiples are whole, so no feature knows the cut. Each octave
# cuts a wrap into finer rings, and noise grows with it: an error ε of the phase is $2^k\epsilon$ of
# its k-th octave, whose fringes fade by $\langle\cos 2^k\epsilon\rangle$.

# %%
features = {
    "noise-free": fourier_features(clean["released"].phase[0], order),
    "noisy": fourier_features(measured.phase[0], order),
}
error = centred(measured.phase[0] - clean["released"].phase[0])
level = np.clip(scene.intensity, 0, 1)
scored = measured.mask
bright = scored & (level >= np.percentile(level[scored], 90))
octaves = 2.0 ** np.arange(order + 1)
multiples = ["φ", *(f"{2**k}φ" for k in range(1, order + 1))]
kept = [float(np.cos(k * error[scored]).mean()) for k in octaves]
kept_bright = [float(np.cos(k * error[bright]).mean()) for k in octaves]
sigma = phase_noise_from_sigma(NOISE_SIGMA)
kept_white = np.exp(-((octaves * sigma) ** 2) / 2)
for multiple, ours, best, white in zip(multiples, kept, kept_bright, kept_white, strict=True):
    print(f"cos {multiple} keeps {ours:.0%}, on the brightest tenth {best:.0%}, white {white:.0%}")
tell(
    kept_first=100 * kept[0],
    kept_third=100 * kept[min(2, order)],
    kept_last=100 * kept[-1],
    white_last=100 * kept_white[-1],
    last_octave=2**order,
)

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, order + 1, figsize=(1.7 * (order + 1) + 0.5, 3.2), squeeze=False)
for drawn, (row, stack) in enumerate(zip(axes, features.values(), strict=True)):
    for k, (ax, cosine) in enumerate(zip(row, stack[::2], strict=True)):
        title = f"cos {multiples[k]}" if not drawn else f"noisy: keeps {100 * kept[k]:.0f} %"
        plotting.image(ax, cosine, label="", title=title, cmap="RdBu_r", limits=(-1, 1))
        if k < order:
            ax.images[0].colorbar.remove()
plotting.save(
    figure,
    "inputs_features",
    numbers={"kept": kept, "kept_brightest_tenth": kept_bright, "kept_white": kept_white.tolist()},
    caption=(
        "The cosines of the Fourier features at 7.15 GHz, without noise and at the paper's noise; "
        "below, how much of each cosine the noise leaves on average over the scored pixels."
    ),
    alt=(
        f"Two rows of {order + 1} images with fringes that double in number from left to right. "
        f"Above they stay crisp; below they drown in grain, from {kept[0]:.0%} kept on the left to "
        f"{kept[-1]:.0%} on the right."
    ),
    format="png",
)

# %% [markdown]
# On this frame the first octave keeps {glue:text}`kept_first:.0f` % of its contrast, the third
# {glue:text}`kept_third:.0f` %, and the cosine of the {glue:text}`last_octave:.0f`-fold phase
# {glue:text}`kept_last:.1f` %; even a white surface would keep only {glue:text}`white_last:.2g` %
# of that one. To a network the last octaves are grain. (Without noise they show rings that belong
# to no surface: the pixels sample them too coarsely.) And what tells the count is not there at all,
# for the features of one phase repeat with every wrap, whatever the octave. It lies in how those of
# *both* frequencies stand to each other.
#
# ## Edges: where the surface ends, not where the phase wraps
#
# To find outlines, a camera engineer takes differences of neighbouring pixels. Of a wrapped phase
# these find every wrap as well, a wall of 2π each, though the surface runs on. Wrapped once more,
# into −π to π, the difference is right again:
#
# ```{math}
# :label: inputs-edges
# \Delta=\bigl(\hat\varphi_{x}-\hat\varphi_{x'}+\pi\bigr)\bmod 2\pi-\pi ,
# ```
#
# as long as depth changes by less than half a turn from one pixel to the next. Four neighbours
# count: left, above, and the two above and below on the left diagonal.

# %%
phase = clean["released"].phase[0]
edges = phase_edges(phase)
names = ["left", "above", "above left", "below left"]
naive = np.zeros_like(phase)
naive[:, 1:] = np.diff(phase, axis=1)
true = np.zeros_like(phase)
true[:, 1:] = np.diff(true_phase(measured), axis=1)
pair = scored.copy()
pair[:, 1:] &= scored[:, :-1]
pair[:, 0] = False
wrong_naive = float(np.mean(np.abs(naive - true)[pair] > np.pi))
wrong = [
    float(np.mean(np.abs(np.diff(true_phase(measured, i), axis=1))[pair[:, 1:]] > np.pi))
    for i in range(2)
]
print(f"naive differences off by a turn or more in {wrong_naive:.1%} of the pairs")
print(f"wrapped differences folded in {wrong[0]:.2%} at 7.15 GHz, {wrong[1]:.2%} at 14.32 GHz")
tell(
    wrong_naive=100 * wrong_naive,
    folded_low=100 * wrong[0],
    folded_high=100 * wrong[1],
    edge_noise=float(np.std(centred(phase_edges(measured.phase[0])[0] - edges[0])[pair & bright])),
)

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 3, figsize=(11.4, 5.3))
edges_noisy = phase_edges(measured.phase[0])
panels = [
    (naive, "naive, left: wraps are walls"),
    *((edge, f"wrapped, {name}") for edge, name in zip(edges, names, strict=True)),
    (edges_noisy[0], "wrapped, left, noisy"),
]
for ax, (values, title) in zip(axes.flat, panels, strict=True):
    plotting.image(ax, values, label="rad", title=title, cmap="RdBu_r", limits=(-np.pi, np.pi))
plotting.label_panels(axes.flat)
plotting.save(
    figure,
    "inputs_edges",
    numbers={"naive_wrong": wrong_naive, "folded": wrong},
    caption=(
        "Differences of the phase at 7.15 GHz. (a) As it stands: every wrap is an edge. (b–e) "
        "Wrapped once more, in four directions, without noise: outlines and slopes. (f) At the "
        "paper's noise."
    ),
    alt=(
        "Six difference images. The first is full of parallel dark lines, one for each wrap. In "
        "the next four the lines are gone, and the outlines of the objects and faint slopes "
        "remain. The last is the second with grain over it."
    ),
    format="png",
)

# %% [markdown]
# The naive difference to the left is off by a turn or more in {glue:text}`wrong_naive:.1f` % of the
# neighbours, most of them on a surface that simply goes on. The wrapped one is off only where depth
# jumps, or slants by more than half a turn a pixel: in {glue:text}`folded_low:.1f` % at 7.15 GHz
# and {glue:text}`folded_high:.1f` % at 14.32 GHz. There it tells *that* something jumps and not by
# how much; the missing wraps are missing in every feature. The noise of two pixels adds up to
# {glue:text}`edge_noise:.2f` rad even on the brightest tenth, so a faint slope is seen only by one
# who looks at many edges at once. That is what convolutions do.
#
# ## All that goes in


# %%
def stacked(held):
    """Channels (2, 1 + 2 (order + 1) + 4, H, W): amplitude, octaves and edges of each frequency."""
    return np.concatenate(
        [
            log_amplitude(held.amplitude)[:, None],
            fourier_features(held.phase, order),
            phase_edges(held.phase),
        ],
        axis=1,
    )


inputs = stacked(measured)
channels = inputs.shape[0] * inputs.shape[1]
print(f"{channels} channels of {inputs.shape[2:]} pixels, {inputs.dtype}")
tell(channels=channels, per_frequency=inputs.shape[1])

# %% tags=["hide-input"]
labels = ["log a", *(f"{f} {m}" for m in multiples for f in ("cos", "sin")), *names]
across = (inputs.shape[1] + 2) // 2
figure, axes = plt.subplots(4, across, figsize=(1.15 * across, 4.4))
tiles = axes.reshape(2, -1)
for row, tone, stack in zip(tiles, gigahertz, inputs, strict=True):
    for ax, label, channel in zip(row, labels, stack, strict=False):
        limits = shown if label == "log a" else (-1, 1) if "φ" in label else (-np.pi, np.pi)
        ax.imshow(channel, cmap="gray" if label == "log a" else "RdBu_r",
                  vmin=limits[0], vmax=limits[1])  # fmt: skip
        ax.set_title(label, fontsize="small", pad=2)
    row[0].set_ylabel(f"{tone:.2f} GHz", fontsize="small")
target = np.where(scored, counts["released"], np.nan)
tiles[0, -1].imshow(target, cmap=plotting.DEPTH_CMAP)
tiles[0, -1].set_title("target n", fontsize="small", pad=2)
tiles[1, -1].imshow(scored, cmap="gray")
tiles[1, -1].set_title("scored: white", fontsize="small", pad=2)
for ax in axes.flat:
    ax.set(xticks=[], yticks=[])
    ax.grid(visible=False)
    ax.spines[:].set_visible(ax.has_data())
plotting.save(
    figure,
    "fig05_inputs",
    numbers={"channels": channels, "classes": classes, "scored": float(scored.mean())},
    caption=(
        f"The inputs of Fig. 5: {channels} channels of the frame `{frame}` at the paper's noise "
        "(log amplitude, Fourier features and phase edges of both frequencies), with the target "
        "and the mask of the pixels that are scored, protocol `released`."
    ),
    alt=(
        "A contact sheet of small images: above those of 7.15 GHz, below those of 14.32 GHz. "
        "Amplitudes show the scene, the first octaves fringes, the last octaves grain, the edges "
        "outlines; at the end the target in steps of depth and the mask."
    ),
    format="png",
)

# %% [markdown]
# {glue:text}`channels:.0f` channels, {glue:text}`per_frequency:.0f` a frequency: one of amplitude,
# the octaves, the edges. The published network had amplitude, Fourier features and edges; the
# authors' released code has the phases and their octaves only. The functions are
# `cmtof.network.features`; they need no learning framework.
#
# By eye one sees the objects in the amplitude and the edges, fringes in the first octaves, and
# nothing in the last; the count one does not see. Yet it *is* in there: not in a pixel, where
# {doc}`a wrap moves the beat by far less than its noise <03_wraps>`, but in a surface, if its
# pixels are pooled by someone who knows that they belong together.

# %%
paper.check("sec5.phase_steps", images.shape[1])
paper.check("sec8.frequency_low", measured.frequencies[0])
paper.check("sec8.frequency_high", measured.frequencies[1])
