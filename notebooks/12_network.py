# %% [markdown]
# # The network
#
# A wrap count is a class, and a picture of wrap counts is what a network that segments street
# scenes would call a segmentation. The paper takes such a network, Fast-SCNN {cite}`poudel2019`,
# narrows its view and gives it a shortcut; the layers stand in a supplement that we do not have, so
# **the table behind this page is our reading**. The page takes the equations 5, 6 and 7 apart,
# draws the network from its own layers (Fig. 5), measures how far it looks, and lets a small one
# learn for a few seconds on simulated measurements. That last part shows that everything runs, and
# nothing else.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of weights, noise and crops
frame: str = "still_life"  # embedded frame, to validate on
field_side: int = 321  # side of the receptive field's image, px
field_samples: int = 3  # noise images to measure it on
smoke_model: str = "fast-scnn-light"  # network of the smoke training
smoke_epochs: int = 10  # epochs of the smoke training
smoke_crops: int = 32  # crops an epoch

# %%
import logging
import warnings
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import torch
from matplotlib.patches import Rectangle
from myst_nb import glue

import cmtof
from cmtof import bounds
from cmtof.book import paper, plotting
from cmtof.constants import FREQUENCIES, NOISE_SIGMA
from cmtof.correlation import TAU
from cmtof.network.building import build_network
from cmtof.network.configuration import MODELS, Rooms, read_config, wraps_of
from cmtof.network.data import Crops, EpochSampler, Views
from cmtof.network.diagram import draw_network
from cmtof.network.features import ORDER, features, fourier_features
from cmtof.network.frames import Pack
from cmtof.network.losses import IGNORED, soft_argmax, unwrapping_loss
from cmtof.network.measuring import Batch, measure
from cmtof.network.receptive_field import receptive_field

paper_run = plotting.begin(profile=profile, seed=seed)
blue, vermillion, green = (plotting.PALETTE[k] for k in ("blue", "vermillion", "green"))
generator = torch.Generator().manual_seed(seed)
classes = wraps_of("released")[1]


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, value if isinstance(value, str) else float(value), display=False)


# %% [markdown]
# ## Equation 5: whole multiples hide the wrap
#
# The octaves of {eq}`eq-5` are whole multiples of the wrapped phase. That is the point of them: add
# as many turns as you like, and cosine and sine come out the same. A multiple that is not whole
# would show the network where the phase was cut.

# %%
phases = np.linspace(0, TAU, 1000, endpoint=False)[None]
turned = fourier_features(phases + 57 * TAU) - fourier_features(phases)
half = np.cos(1.5 * (phases + TAU)) - np.cos(1.5 * phases)
print(f"57 turns change {2 * (ORDER + 1)} features by {np.abs(turned).max():.0e} at most,")
print(f"one turn changes the cosine of 1.5 φ by {np.abs(half).max():.0f}")
tell(octaves=ORDER + 1, turn_error=np.abs(turned).max(), half_error=np.abs(half).max())

# %% [markdown]
# ## Equation 6: an argmax with a slope
#
# To say how far a guess is off, the classes have to become a number again. The likeliest class is
# no help to a training: move the weights a little and it stays. The mean of all classes, each by
# its share in a softmax, moves with them,
#
# ```{math}
# :label: eq-6
# n'=\sum_{n=0}^{N-1} n\,\frac{e^{\gamma\bar\phi_n}}{\sum_{m=0}^{N-1}e^{\gamma\bar\phi_m}},
# ```
#
# and the hardness γ says how much it is an argmax. The paper prints
# $\gamma e^{\bar\phi_n}/\sum_m e^{\gamma\bar\phi_m}$. Those shares do not add up to one, so what
# they weight is no mean ({ref}`erratum 5 <erratum-5>`); it is a wrap count and not yet a phase
# ({ref}`erratum 18 <erratum-18>`).

# %%
certain = torch.full((classes, classes), -1e3).fill_diagonal_(1e3)
onehot = soft_argmax(certain)
weights = torch.zeros(classes, dtype=torch.float64)
weights[5:8] = torch.tensor([1.0, 3.0, 2.0])
print("one-hot weights give the class:", torch.equal(onehot, torch.arange(float(classes))))
number = torch.arange(classes, dtype=torch.float64)
printed_sums, printed_values, right_values = [], [], []
for hardness in (1.0, 2.0, 4.0, 16.0):
    printed = hardness * weights.exp() / (hardness * weights).exp().sum()
    printed_sums.append(float(printed.sum()))
    printed_values.append(float(number @ printed))
    right_values.append(float(soft_argmax(weights[None], hardness)[0]))
    print(f"γ = {hardness:4.0f}: n' = {right_values[-1]:6.3f}; as printed {printed_values[-1]:.1e},"
          f" of shares that add up to {printed_sums[-1]:.1e}")  # fmt: skip
tell(right_hard=right_values[-1], printed_hard=printed_values[-1], printed_sum=printed_sums[-1],
     right_soft=right_values[0])  # fmt: skip

# %% [markdown]
# At γ = 1 the printed formula and the right one agree. With growing hardness the right one goes to
# the class of the largest weight ({glue:text}`right_hard:.3f` in the end), the printed one to
# nothing at all ({glue:text}`printed_hard:.1e`). Mind the upper line too: at γ = 1 the mean is
# {glue:text}`right_soft:.2f`, for every class that is all but ruled out still pulls.
#
# ## Equation 7: right, or at least near
#
# ```{math}
# :label: eq-7
# \mathcal L=-\ln p_n+w\,s(z'-z),\qquad p=\mathrm{softmax}(\bar\phi),
# ```
#
# the cross-entropy of the true class n and a distance in depth, s, smoothed where it would have a
# corner. The first asks for the right class and holds all wrong ones for equally wrong; the second
# prefers a near one. The paper's w is {glue:text}`depth_weight:.1f`. Three checks: the slope of the
# first part is $p-\mathrm{onehot}(n)$; the slope of the whole is that of finite differences; and
# what is masked has none.

# %%
shape = (1, classes, 3, 4)
logits = torch.randn(shape, generator=generator, dtype=torch.float64).requires_grad_()
label = torch.randint(classes, (1, 3, 4), generator=generator)
label[0, 0] = IGNORED
phase = TAU * torch.rand(1, 3, 4, generator=generator)
turns = label + phase / TAU + 0.05
turns[0, 0] = torch.nan


def slope(depth_weight):
    loss = unwrapping_loss(logits, label, phase, turns, depth_weight=depth_weight).total
    return torch.autograd.grad(loss, logits)[0].detach()


kept = label != IGNORED
one_hot = torch.nn.functional.one_hot(label.clamp(min=0), classes).movedim(-1, 1)
closed = (torch.softmax(logits, 1) - one_hot) * kept[:, None] / kept.sum()
entropy_error = float((slope(0.0) - closed.detach()).abs().max())

# %%
depth_weight = MODELS["fast-scnn"].depth_weight
whole, step = slope(depth_weight), 1e-2
where = (0, 7, 2, 1)
moved = []
for sign in (1, -1):
    shifted = logits.detach().clone()
    shifted[where] += sign * step
    moved.append(unwrapping_loss(shifted, label, phase, turns, depth_weight=depth_weight).total)
finite = float((moved[0] - moved[1]) / (2 * step))
difference = abs(finite - float(whole[where]))
masked = float(whole[0, :, 0].abs().max())
print(f"slope of the cross-entropy against p − onehot: {entropy_error:.0e}")
print(f"slope of the whole loss {float(whole[where]):.6f}, by finite differences {finite:.6f}")
print(f"largest slope of a masked pixel, whose depth is not a number: {masked:g}")
tell(depth_weight=depth_weight, masked=masked)

# %% [markdown]
# ## Figure 5: the network
#
# From left to right, resolution as height. Fast-SCNN halves the picture three times before its
# features divide; here they divide at half the resolution already. What is deep looks far (the
# pyramid takes means over neighbourhoods beside each pixel's own features), what is shallow sees
# sharply; both are added. The orange line is the paper's **skip**: the first layer, at full
# resolution, goes straight to the last. Every number below is read from the layers as they run.

# %%
network = build_network("fast-scnn", classes)
parameters = sum(weight.numel() for weight in network.parameters())
patch = read_config("paper").crop
figure, ax = plt.subplots(figsize=(11.2, 4.9))
drawn = draw_network(ax, network, patch, patch)
smallest = min(drawn, key=lambda block: block.height)
plotting.save(
    figure,
    "fig05_network",
    numbers={
        "parameters": parameters,
        "channels": {block.name: block.channels for block in drawn},
        "height": {block.name: block.height for block in drawn},
    },
    caption=(
        f"The network of Fig. 5 as we read it, {parameters / 1e6:.2f} million weights, drawn from "
        "its layers. In each block the channels that leave it, and how many such blocks stand in a "
        f"row; at the left the resolution of a {patch}×{patch} patch. «Up» resizes first."
    ),
    alt=(
        f"Blocks from left to right: {drawn[0].channels} features at full resolution, a "
        f"convolution, then down over two levels to {smallest.height} pixels a side, and up again "
        f"to {drawn[-1].channels} classes at full resolution. A shortcut runs along the top from "
        "the first layer to the last but one, another one along the second level."
    ),
)
tell(parameters=parameters / 1e6, inputs=network.inputs, smallest=smallest.height)

# %% [markdown]
# {glue:text}`parameters:.2f` million weights are few: a network for photographs has ten to a
# hundred times as many. Its {glue:text}`inputs:.0f` channels of input are the subject of
# {doc}`05_simulation`.
#
# ## How far it looks
#
# The paper narrows the view, so that a network learns how phases beat and not where rooms have
# their walls. How narrow may it be? Theory has an answer of its own: one pixel's beat cannot tell a
# wrap, but {doc}`enough of them together can <03_wraps>`, and the number that is needed is a
# window. Both can be measured in pixels. The network's view is taken from its gradients: how much
# does one output pixel move with each input? The weights are fresh, with their norms settled on a
# few simulated crops; training will move the weight within the square and cannot enlarge it.

# %%
embedded = {name: cmtof.load_frame(name) for name in ("room", "stairs", "still_life")}


def packed(names):
    """Frames as a training reads them."""
    frames = [embedded[name] for name in names]
    return Pack(
        np.stack([np.asarray(f.depth, np.float32) for f in frames]),
        np.stack([np.clip(f.intensity, 0, 1).astype(np.float16) for f in frames]),
        np.array([float(np.nanpercentile(f.depth, 99.9)) for f in frames]),
        list(names),
    )


measured = cmtof.simulate(embedded[frame], seed=seed)
given = features(measured.phase.astype(np.float32), measured.amplitude.astype(np.float32))
fields = {}
for name in ("fast-scnn", "fast-scnn-light"):
    torch.manual_seed(seed)
    fresh = build_network(name, classes)
    extra = fresh.inputs - given.shape[0]
    padded = torch.from_numpy(np.concatenate([given, given[:extra]]))
    for module in fresh.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            module.momentum = None  # plain means over what follows
    with torch.no_grad():
        for corner in range(0, 144, 48):
            fresh(padded[None, :, corner : corner + 96, corner : corner + 96])
    fields[name] = receptive_field(
        fresh, fresh.inputs, side=field_side, samples=field_samples, seed=seed
    )
    field = fields[name]
    print(f"{name}: {field.extent} px at most; half of the weight in {field.side(0.5)} px, 95 % in "
          f"{field.side(0.95)} px")  # fmt: skip

# %%
counts = 20_000.0  # G T at full brightness
asked = {}
for level in (1.0, 0.3, 0.1):
    noise = float(
        bounds.phase_bound(
            level * counts / np.pi, level * counts / 2, np.arange(4) * np.pi / 2, sigma=NOISE_SIGMA
        )
    )
    pixels = bounds.pixels_needed(noise, noise, frequencies=FREQUENCIES)
    asked[level] = float(np.sqrt(pixels))
    print(f"brightness {level:.1f}: {pixels} pixels for odds of 95 %, {asked[level]:.0f}² px")

# %% tags=["hide-input"]
field = fields["fast-scnn"]
figure, axes = plt.subplots(1, 2, figsize=(10.6, 4.3), width_ratios=[1, 1.25])
half = field_side // 2
density = np.log10(np.maximum(field.weight / field.weight.max(), 1e-7))
shown = axes[0].imshow(density, extent=(-half, half, half, -half), cmap="cividis", vmin=-7)
figure.colorbar(shown, ax=axes[0], label="log₁₀ of the weight", shrink=0.8)
for side, colour, style in (
    (field.extent, "white", "-"), (field.side(0.95), "white", ":"), (asked[1.0], vermillion, "-"),
):  # fmt: skip
    axes[0].add_patch(
        Rectangle((-side / 2, -side / 2), side, side, fill=False, ec=colour, ls=style, lw=1.6)
    )
axes[0].set(title="paper's network", xlabel="px from the output pixel", ylabel="px")
axes[0].grid(visible=False)
sides = 2 * np.arange(half + 1) + 1
for (name, one), colour in zip(fields.items(), (blue, green), strict=True):
    axes[1].plot(sides, 100 * one.profile(), color=colour, label=name)
for level, side in asked.items():
    if side < field_side:
        axes[1].axvline(side, color=vermillion, lw=1.1, ls="--")
        axes[1].text(side + 2, 4, f"asked at\nbrightness {level:g}", fontsize="small",
                     color=vermillion)  # fmt: skip
axes[1].set(xlabel="side of a centred square (px)", ylabel="weight within (%)", ylim=(0, 103),
            xlim=(0, field_side), title="how much lies within a square")  # fmt: skip
axes[1].legend(loc="center right")
plotting.label_panels(axes)
plotting.save(
    figure,
    "network_receptive_field",
    numbers={
        "extent": {name: one.extent for name, one in fields.items()},
        "asked_px": {f"{level:g}": side for level, side in asked.items()},
    },
    caption=(
        "The view of one output pixel, measured by gradients (fresh weights). (a) Where its weight "
        f"lies; white: all of it ({field.extent} px) and 95 % ({field.side(0.95)} px), orange: "
        f"the {asked[1.0]:.0f} px that theory asks for at full brightness. (b) Weight within "
        "squares, and what theory asks for."
    ),
    alt=(
        "Left, a map that is brightest in its middle and fades through nested squares to a sharp "
        "border. Right, curves that rise steeply from nought and flatten towards 100 %, with "
        "upright lines where theory wants its windows."
    ),
    format="png",
)
tell(extent=field.extent, half_side=field.side(0.5), most_side=field.side(0.95),
     asked_bright=asked[1.0], asked_dark=asked[0.3], asked_darkest=asked[0.1])  # fmt: skip

# %% [markdown]
# The square is {glue:text}`extent:.0f` px wide, but before any training half of the weight lies
# within {glue:text}`half_side:.0f` px and 95 % within {glue:text}`most_side:.0f` px. Theory asks
# for {glue:text}`asked_bright:.0f` px on a white surface, {glue:text}`asked_dark:.0f` px at a
# brightness of 0.3 and {glue:text}`asked_darkest:.0f` px at 0.1, and that on *one smooth surface
# whose shape is known*. So the square is wide enough for all but the darkest of the three, and the
# weight, as it falls before any training, lies about where a white surface wants it.
#
# ## A smoke training
#
# The training loop of `cmtof train`, for a few seconds: the embedded frames `room` and `stairs` to
# learn from, `still_life` to validate on, all measured in simulation, with a network and crops that
# are far too small.

# %%
config = read_config(
    "smoke", model=smoke_model, epochs=smoke_epochs, crops=smoke_crops, crop=64, seed=seed
)
learnt, held_out = (packed(names) for names in (("room", "stairs"), ("still_life",)))
unseen = Views(held_out, replace(config, crop=192, rooms=Rooms(height=192, width=192)))
with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # Lightning's advice for long trainings
    logging.getLogger("lightning.pytorch").setLevel(logging.ERROR)
    from lightning import Trainer

    from cmtof.network.module import Unwrapping

    module = Unwrapping(config)
    loader = torch.utils.data.DataLoader
    trainer = Trainer(
        max_epochs=config.epochs, accelerator="cpu", logger=False, enable_checkpointing=False,
        enable_progress_bar=False, enable_model_summary=False, num_sanity_val_steps=0,
        use_distributed_sampler=False,
    )  # fmt: skip
    trainer.fit(
        module,
        loader(Crops(learnt, config), config.batch, sampler=EpochSampler(config.crops)),
        loader(unseen, 1),
    )

# %%
batch, noise = unseen[0]
asked_of = measure(
    Batch(*(part[None] for part in batch)), noise[:, None],
    inputs=module.model.features, first=module.first, classes=classes,
)  # fmt: skip
even = torch.zeros(1, classes, *batch.depth.shape)
chance = float(unwrapping_loss(even, asked_of.label, asked_of.phase, asked_of.turns).total)
print(f"a network that finds all classes alike: {chance:.2f} on the unseen frame")

# %% tags=["hide-input"]
curve = {key: [found[key] for found in module.curve] for key in module.curve[0]}
figure, axes = plt.subplots(1, 2, figsize=(10.0, 3.6))
axes[0].plot(curve["step"], curve["loss"], "o-", color=blue, label="training")
axes[0].plot(curve["step"], curve["validation_loss"], "s-", color=vermillion, label="validation")
axes[0].axhline(chance, color="#808080", lw=1, ls=":", label="even weights, validation")
axes[0].set(xlabel="step", ylabel="loss (Eq. 7)")
axes[0].legend(fontsize="small")
axes[1].plot(curve["step"], 100 * np.array(curve["delta_lt_1"]), "s-", color=vermillion)
axes[1].axhline(100 / classes, color="#808080", lw=1, ls=":")
axes[1].set(xlabel="step", ylabel="validation: right wrap (%)", ylim=(0, None))
plotting.label_panels(axes)
falls = curve["loss"][-1] < curve["loss"][0]
plotting.save(
    figure,
    "network_smoke",
    numbers={"steps": curve["step"], "falls": bool(falls)},
    caption=(
        f"A smoke training of `{smoke_model}`: {curve['step'][-1]} steps of {config.batch} crops "
        f"of {config.crop}×{config.crop} px, simulated. (a) Loss on what it learns from, and on a "
        "frame that it has never seen. (b) Right wraps on that frame; dotted, an even guess."
    ),
    alt=(
        f"Left, the training loss {'falls' if falls else 'does not fall'} from "
        f"{curve['loss'][0]:.2f} to {curve['loss'][-1]:.2f}; the validation loss goes from "
        f"{curve['validation_loss'][0]:.2f} to {curve['validation_loss'][-1]:.2f}. Right, the rate "
        "of right wraps stays low."
    ),
)
tell(first_loss=curve["loss"][0], last_loss=curve["loss"][-1], smoke_steps=curve["step"][-1],
     first_validation=curve["validation_loss"][0], last_validation=curve["validation_loss"][-1],
     right=100 * curve["delta_lt_1"][-1], even=100 / classes, chance=chance,
     paper_steps=read_config("paper").steps)  # fmt: skip

# %% [markdown]
# The training loss goes from {glue:text}`first_loss:.2f` to {glue:text}`last_loss:.2f`, that of the
# unseen frame from {glue:text}`first_validation:.2f` to {glue:text}`last_validation:.2f`; a network
# that holds all classes for alike has {glue:text}`chance:.2f` there. In the end
# {glue:text}`right:.1f` % of the unseen wraps are right, where an even guess has
# {glue:text}`even:.1f` %. **It has learnt next to nothing**, and could not: the paper takes
# {glue:text}`paper_steps:.0f` steps of larger batches and crops, these are
# {glue:text}`smoke_steps:.0f`. What is shown is that features, labels, loss and slope hang
# together. What trained networks can do is measured elsewhere in this book.

# %%
stated = read_config("paper")
paper.check("sec8.loss_weight", depth_weight)
paper.check("sec8.patch", stated.crop)
paper.check("sec8.batch", stated.batch)
paper.check("sec8.epochs", stated.epochs)
paper.check("sec8.samples_per_epoch", stated.crops)
