# %% [markdown]
# # Simulated measurements
#
# No public data set has correlation images at 7 GHz with known depth. What would the camera have
# seen (Secs. 5.3 and 5.4, Eqs. 5, 8 and 9)?
#
# Training and every comparison of this book use these images, so their noise and the order of the
# steps decide all rates. All of it is simulated.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of all noise
frame_name: str = "still_life"  # embedded frame
ambient_noise: float = 2000.0  # Gaussian σ with the paper's ambient light, counts
draws: int = 200_000  # pixels drawn at each brightness for the noise curves
order: int = 5  # highest octave of the Fourier features, E_C of Eq. 5

# %% tags=["hide-input"]
import matplotlib.pyplot as plt
import numpy as np

import cmtof
from cmtof.bounds import phase_spread, simulated_phase_noise
from cmtof.classical.beat import beat_depth, beat_phasor
from cmtof.constants import FREQUENCIES, GAIN, INTEGRATION_TIME, NOISE_SIGMA
from cmtof.correlation import (
    TAU,
    centred,
    consistent_wrap_count,
    correlation_from_phase,
    decode,
    depth_from_wraps,
    phase_from_depth,
    wrap_count_from_depth,
    wrap_length,
    wrapped,
)
from cmtof.detector import poisson_gaussian
from cmtof.network.features import fourier_features, phase_edges
from cmtof.scenes import embedded_frames
from cmtof.simulation import QUADRATURES
from cmtof_book import notes, paper, plotting
from cmtof_book.compared import closed_form, share_of_pixels, sum_over_draws

plotting.begin(profile=profile, seed=seed)
rng = np.random.default_rng(seed)
frame = cmtof.load_frame(frame_name)
psi = np.array(QUADRATURES)
f1 = FREQUENCIES[0]
signal = GAIN * INTEGRATION_TIME

# %%
measurement = cmtof.simulate(frame, protocol="full", seed=seed)
images = measurement.dataset["correlation"].to_numpy()
phase, amplitude, offset = (field[0] for field in measurement.decoded)
print(measurement, images.shape, images.dtype)

# %% tags=["hide-input"]
brightness = np.clip(frame.intensity, 0, 1)
height, width = frame.depth.shape
figure, axes = plotting.grid(6, 3, height / width)
plotting.image(axes[0], brightness, label="", title="in: brightness I", cmap="gray")
plotting.image(axes[1], frame.depth, label="", title="in: depth z (m)")
shared = tuple(np.percentile(images[0], [0.5, 99.5]) / 1e3)
for ax, picture, name in zip(axes[2:4], images[0], ("0", "π/2"), strict=False):
    title = f"$C_ψ$, ψ = {name} (10³ counts)"
    plotting.image(ax, picture / 1e3, label="", title=title, limits=shared)
plotting.phase_image(axes[4], phase, title=r"out: phase $\hat\varphi$", label="")
plotting.image(axes[5], amplitude / 1e3, label="", title="out: amplitude (10³)")
plotting.label_panels(axes)
plotting.save(
    figure,
    "simulation_correlations",
    format="png",
    caption=f"The frame `{frame_name}`, simulated at 7.15 GHz. (a, b) The inputs. (c, d) Two of "
    "the four correlation images at the paper's noise. (e, f) Phase and amplitude decoded from "
    "the four; every fringe of (e) is 21 mm of depth.",
    alt="Six images of a table top with bust, vase and books: brightness, depth, two correlation "
    "images whose fringes differ by a quarter period, decoded phase with many fringes, decoded "
    "amplitude.",
)

# %% [markdown]
# ## Simulation and decoding
#
# A pixel of range z and linear brightness I (the green channel; the laser is green) has the phase
# $\varphi = 4\pi fz/c$ and gives, at reference phase ψ,
#
# $$
# C_\psi = G\,T\,I_g\left(0.5+\frac{\cos(\phi+\psi)}{\pi}\right)+\eta_P+\eta_G ,
# \tag{8}$$
#
# with $GT = 20\,000$ counts, photon noise $\eta_P$ and Gaussian noise $\eta_G$ of σ = 1200 counts.
# ([chapter 1](01_correlation.ipynb) discusses this contrast of 2/π.) The paper decodes with a
# Fourier transform along ψ,
#
# $$
# \hat\phi = \mathrm{angle}\bigl(\mathcal F_2(C_\psi)\bigr),\qquad
# \hat a = 2\,\bigl|\mathcal F_2(C_\psi)\bigr| .
# \tag{9}$$
#
# This holds for equal steps in rising order. If $\mathcal F_0$ is the mean, as the paper says, the
# fundamental is $\mathcal F_1$. Of four samples $\mathcal F_2$ is the Nyquist bin, which is real
# ([erratum 7](22_errata.ipynb#erratum-7)). Here decoding is a **least-squares fit** of
#
# $$
# C_\psi = d + x\cos\psi - y\sin\psi ,\qquad
# \hat\varphi = \mathrm{atan2}(y, x),\quad \hat a=\sqrt{x^2+y^2},
# \tag{5.1}$$
#
# to the values of ψ that the file states: at least three, of any spacing and order.

# %% tags=["hide-input"]
truth = np.linspace(0, TAU, 400, endpoint=False)
irregular = np.array([5.1, 0.2, 2.9, 1.0, 4.4, 3.3, 1.9])
curve = correlation_from_phase(truth, irregular, amplitude=2.0, offset=7.0)
worst = np.abs(centred(decode(curve, irregular).phase - truth)).max()
print(f"seven irregular, shuffled steps: largest phase error {worst:.0e} rad")
clean = correlation_from_phase(truth, psi, amplitude=signal / np.pi, offset=signal / 2)
four = poisson_gaussian(clean, rng=rng, sigma=NOISE_SIGMA)
spectrum = np.fft.fft(four, axis=0)
misordered = np.fft.fft(four[[0, 1, 3, 2]], axis=0)
readings = {
    "F₁, steps in order": wrapped(np.angle(spectrum[1])),
    "F₂, as printed": wrapped(np.angle(spectrum[2])),
    "F₁, in the order of Section 5.3": wrapped(np.angle(misordered[1])),
}
for name, read in readings.items():
    print(f"{name}: {np.sqrt(np.mean(centred(read - truth) ** 2)):.2f} rad rms")

# %% [markdown]
# [Eq. 9](#eq-9) read literally does not recover the phase, nor does the right bin if the set of ψ
# is used as it is listed, unsorted; a random phase errs by $\pi/\sqrt3 = 1.81$ rad rms. Without
# noise decoding must be exact:

# %%
for name in embedded_frames():
    quiet = cmtof.simulate(cmtof.load_frame(name), protocol="full", noise_free=True)
    lit = np.isfinite(quiet.depth) & (quiet.amplitude[0] > 10) & quiet.mask
    z = quiet.depth[lit].astype(float)
    phi = quiet.phase[0][lit].astype(float)
    wraps = consistent_wrap_count(z, phi, f1)
    phase_error = np.abs(centred(phi - phase_from_depth(z, f1))).max()
    depth_error = np.abs(depth_from_wraps(phi, wraps, f1) - z).max()
    moved = int(np.sum(wraps != wrap_count_from_depth(z, f1)))
    print(
        f"{name}: phase {1e6 * phase_error:.1f} µrad, depth {1e9 * depth_error:.1f} nm"
    )
    print(f"   pixels that rounding moved across a wrap's boundary: {moved}")

# %% [markdown]
# Rounding may move a pixel across the boundary of a wrap. With the neighbouring count its depth is
# still right. This book therefore distinguishes [two wrap counts](../book/notation.md).
#
# ## The order of the two noise terms
#
# [Eq. 8](#eq-8) adds photon noise, then Gaussian noise. The authors' released code draws Gaussian
# noise first, clips it at zero, and then draws Poisson counts. For bright pixels that is
# equivalent; for dark ones clipping raises the mean and reduces the amplitude.

# %% tags=["hide-input"]
levels = np.geomspace(0.02, 1, 12)
settings = {
    "paper's order": ("paper", NOISE_SIGMA),
    "released code's order": ("released", NOISE_SIGMA),
    f"ambient light, σ = {ambient_noise:.0f}": ("paper", ambient_noise),
}
spread = {}
kept = {}
for name, (which, sigma) in settings.items():
    spread[name] = []
    kept[name] = []
    for level in levels:
        angle = rng.uniform(0, TAU, draws)
        one = {"amplitude": level * signal / np.pi, "offset": level * signal / 2}
        mean = correlation_from_phase(angle, psi, **one).astype(np.float32)
        decoded = decode(poisson_gaussian(mean, rng=rng, sigma=sigma, order=which), psi)
        error = centred(decoded.phase - angle)
        spread[name].append(error.std())
        # the decoded phasor along the true direction, over the true amplitude
        kept[name].append(np.mean(decoded.amplitude * np.cos(error)) / one["amplitude"])

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(8.4, 4.0))
fine = np.geomspace(0.018, 1.05, 100)
for (name, (_, sigma)), marker in zip(settings.items(), "os^", strict=True):
    law = [phase_spread(s) for s in simulated_phase_noise(fine, sigma=sigma)]
    axes[0].plot(fine, law, color=plotting.GREY, lw=1)
    axes[0].plot(levels, spread[name], marker, ms=5, label=name)
    if sigma == NOISE_SIGMA:
        axes[1].plot(levels, 100 * np.array(kept[name]), marker + "-", label=name)
axes[0].set(
    xscale="log", yscale="log", ylabel="spread of the phase (rad)", title="noise"
)
axes[1].set(
    xscale="log", ylabel="mean decoded signal (%)", ylim=(40, 110), title="clipping"
)
for ax in axes:
    ax.set(xlabel="brightness I")
    ax.legend(fontsize="small")
plotting.label_panels(axes)
ours, theirs, ambient = spread
spread_error = np.array(spread[theirs]) / np.sqrt(2 * draws)
kept_error = simulated_phase_noise(levels) / np.sqrt(draws)
plotting.save(
    figure,
    "simulation_noise",
    numbers={
        "spread_released": sum_over_draws(spread[theirs], error=spread_error),
        "kept_released": sum_over_draws(kept[theirs], error=kept_error),
    },
    caption="Noise of the simulated phase at four ψ. (a) Standard deviation against brightness "
    "beside the exact law (grey), for both orders of the noise terms and for the paper's ambient "
    "light. (b) Mean of the decoded phasor along its true direction: clipping at zero reduces it.",
    alt="Left, spread over brightness, both logarithmic, falling towards white pixels; symbols of "
    "both orders lie close to the law, ambient light lies higher. Right, the decoded signal: whole "
    "at all brightnesses in the paper's order, falling for dark pixels in the released code's.",
)

# %% tags=["hide-input"]
notes.say(
    """
    In the released code's order a dark pixel keeps less of its signal at equal phase noise, since
    clipping reduces both. This book uses the paper's order (`order="released"` selects the other).
    Ambient light, as the paper models it, raises a white pixel's noise from {white:.3f} to
    {white_ambient:.3f} rad.
    """,
    white=spread[ours][-1],
    white_ambient=spread[ambient][-1],
)

# %% [markdown]
# ## Two protocols, and the target
#
# The network predicts the **wrap count**
#
# $$
# n=\left\lfloor\frac{\varphi}{2\pi}\right\rfloor=\left\lfloor\frac{2f_1z}{c}\right\rfloor
# \tag{5.2}$$
#
# of the lower frequency, as one class for each pixel. **released** follows the authors' code: the
# scene is shrunk until nearly all of it lies within 1.195 m, and only pixels in wraps 36 to 56 are
# scored, 21 classes. **full** leaves the scene as it is and scores everything within the beat's
# 7.495 m. A pixel that is not scored keeps its signal.

# %% tags=["hide-input"]
frames = {name: cmtof.load_frame(name) for name in embedded_frames()}
quiet = {
    (name, protocol): cmtof.simulate(held, protocol=protocol, noise_free=True)
    for protocol in ("released", "full")
    for name, held in frames.items()
}
rows = []
for protocol in ("released", "full"):
    one = quiet[frame_name, protocol]
    first, last = (round(edge / wrap_length(f1)) for edge in one.range)
    used, sizes = np.unique(
        wrap_count_from_depth(one.depth[one.mask], f1), return_counts=True
    )
    commonest = f"{sizes.max() / sizes.sum():.1%}"
    rows.append(
        (protocol, last - first, used.size, f"{one.mask.mean():.0%}", commonest)
    )
notes.table(
    [f"`{frame_name}`", "classes", "that occur", "scored", "commonest class"], rows
)

# %% tags=["hide-input"]
figure, axes = plotting.grid(len(quiet), 3, height / width)
for ax, ((name, protocol), one) in zip(axes, quiet.items(), strict=True):
    title = f"{name}, {protocol}: {100 * one.mask.mean():.0f} %"
    shown = np.where(one.mask, one.depth, np.nan)
    plotting.image(ax, shown, label="depth (m)", title=title, limits=one.range)
plotting.label_panels(axes)
plotting.save(
    figure,
    "simulation_protocols",
    format="png",
    numbers={
        protocol: share_of_pixels(
            [quiet[name, protocol].mask.mean() for name in frames],
            pixels=[held.depth.size for held in frames.values()],
        )
        for protocol in ("released", "full")
    },
    caption="True depth of the three embedded frames in each protocol, and the share of pixels "
    "scored; grey is not scored. Each row has one scale, the protocol's range: `released` shrinks "
    "every scene.",
    alt="Two rows of three depth images. Above, the released protocol: a narrow span of depths, "
    "large grey areas in the foreground. Below, the full protocol: the whole depth of each room.",
)

# %% [markdown]
# Rates of the two protocols are not comparable; each is given beside that of the most common class.
#
# ## Fourier features
#
# A wrapped phase jumps from 2π to 0 where depth is continuous, which makes it a poor input for
# convolutions; its sine and cosine are continuous. The paper uses octaves,
#
# $$
# \gamma(\hat\phi)=\bigl[\cos(2^0\hat\phi),\ \sin(2^0\hat\phi),\ \cos(2^1\hat\phi),\ \ldots,\
# \sin(2^{E_C}\hat\phi)\bigr],
# \tag{5}$$
#
# without stating where they stop; the authors' released code stops at $E_C=5$
# ([erratum 4](22_errata.ipynb#erratum-4)). A phase error ε is an error $2^k\epsilon$ of the k-th
# octave, which reduces its cosine by the factor $\langle\cos 2^k\epsilon\rangle$.

# %% tags=["hide-input"]
measured = cmtof.simulate(frame, protocol="released", seed=seed)
exact = quiet[frame_name, "released"]
error = centred(measured.phase[0] - exact.phase[0])
scored = measured.mask
bright = scored & (brightness >= np.percentile(brightness[scored], 90))
octaves = 2.0 ** np.arange(order + 1)
multiples = ["φ", *(f"{2**k}φ" for k in range(1, order + 1))]
remains = [np.cos(k * error[scored]).mean() for k in octaves]
remains_bright = [np.cos(k * error[bright]).mean() for k in octaves]
remains_white = np.exp(
    -((octaves * phase_spread(float(simulated_phase_noise(1.0)))) ** 2) / 2
)
rows = [
    (name, *(f"{x:.1%}" for x in kept))
    for name, *kept in zip(
        multiples, remains, remains_bright, remains_white, strict=True
    )
]
notes.table(
    ["kept of the cosine of", "whole frame", "brightest tenth", "white pixels"], rows
)


# %% [markdown]
# The last octaves are noise. The features of one phase repeat with every wrap, so the wrap count
# follows only from *both* frequencies.
#
# ## Edges
#
# Differences of neighbouring pixels show outlines, but those of a wrapped phase also show every
# wrap. Wrapping the difference corrects this,
#
# $$
# \Delta=\bigl(\hat\varphi_{x}-\hat\varphi_{x'}+\pi\bigr)\bmod 2\pi-\pi ,
# \tag{5.3}$$
#
# as long as depth changes by less than half a turn from one pixel to the next. Four neighbours are
# used: left, above, and the two on the left diagonals.

# %%
edges = phase_edges(exact.phase[0])
noisy_edges = phase_edges(measured.phase[0])
naive = np.diff(exact.phase[0], axis=1, prepend=exact.phase[0][:, :1])
z = measured.depth.astype(float)
true_steps = [np.diff(phase_from_depth(z, f), axis=1) for f in measured.frequencies]
pair = scored[:, 1:] & scored[:, :-1]
naive_wrong = np.mean(np.abs(naive[:, 1:] - true_steps[0])[pair] > np.pi)
folded = [np.mean(np.abs(step)[pair] > np.pi) for step in true_steps]
print(
    f"naive differences are wrong in {naive_wrong:.1%} of the pairs,\n"
    f"wrapped ones in {folded[0]:.2%} at 7.15 GHz, {folded[1]:.2%} at 14.32 GHz"
)

# %% tags=["hide-input"]
names = ["left", "above", "above left", "below left"]
titles = [
    "naive, left",
    *(f"wrapped, {name}" for name in names),
    "wrapped, left, noisy",
]
figure, axes = plotting.grid(len(titles), 3, height / width)
pictures = [naive, *edges, noisy_edges[0]]
for ax, picture, title in zip(axes, pictures, titles, strict=True):
    look = {"cmap": "RdBu_r", "limits": (-np.pi, np.pi), "bar": False}
    plotting.image(ax, picture, label="", title=title, **look)
figure.colorbar(axes[0].images[0], ax=axes, shrink=0.6, label="rad")
plotting.label_panels(axes)
plotting.save(
    figure,
    "inputs_edges",
    numbers={
        "naive_wrong": share_of_pixels(naive_wrong, pixels=pair.sum()),
        "folded": share_of_pixels(folded, pixels=pair.sum()),
    },
    caption=f"Phase differences of `{frame_name}` at 7.15 GHz, simulated. (a) Not wrapped: every "
    "wrap is an edge. (b–e) Wrapped, in four directions, without noise. (f) With the paper's "
    "noise.",
    alt="Six difference images. The first is full of parallel dark lines, one for each wrap. In "
    "the next four the lines are gone, and the outlines of the objects remain. The last has grain.",
    format="png",
)

# %% [markdown]
# ## All inputs
#
# The published network had amplitude, phase, Fourier features and edges of both frequencies; the
# authors' released code has the phases and their octaves only.

# %%
given = np.stack([np.log1p(measured.amplitude), measured.phase], axis=1)
edges_of = phase_edges(measured.phase)
inputs = np.concatenate(
    [given, fourier_features(measured.phase, order), edges_of], axis=1
)
channels = inputs.shape[0] * inputs.shape[1]

# %% tags=["hide-input"]
low, high = inputs
target = np.where(
    scored, wrap_count_from_depth(np.nan_to_num(measured.depth), f1), np.nan
)
tiles = {
    "log amplitude": (low[0], "gray"),
    "phase φ": (low[1], plotting.PHASE_CMAP),
    "cos φ": (low[2], "RdBu_r"),
    "cos φ, 14.32 GHz": (high[2], "RdBu_r"),
    "edges, above": (edges_of[0, 1], "RdBu_r"),
    "target: wrap count": (target, plotting.DEPTH_CMAP),
}
figure, axes = plotting.grid(len(tiles), 3, height / width)
for ax, (title, (picture, cmap)) in zip(axes, tiles.items(), strict=True):
    plotting.image(ax, picture, label="", title=title, cmap=cmap, bar=False)
plotting.label_panels(axes)
plotting.save(
    figure,
    "fig05_inputs",
    numbers={
        "channels": closed_form(channels),
        "scored": share_of_pixels(scored.mean(), pixels=scored.size),
    },
    caption=f"The network's inputs: five of the {channels} channels of the frame `{frame_name}` at "
    "the paper's noise, and the target, protocol `released` (grey: not scored). Both frequencies "
    "have log amplitude, phase, six octaves of cosine and sine, and edges in four directions.",
    alt="Six images: an amplitude that shows the scene, a phase with fringes, its cosine, twice as "
    "many fringes at 14.32 gigahertz, an edge map with outlines, and the target in steps of depth.",
    format="png",
)

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** Noisy images from which decoding recovers the phase: a white pixel has a phase noise
    of {white:.2f} rad. Of the network's octave features the first keeps {first:.0f} % of its cosine
    over the frame and the last {last:.0f} %. The released code's order of the noise loses light in
    dark pixels: {kept:.0f} % is left at brightness 0.02.
    """,
    white=spread[ours][-1],
    first=100 * remains[0],
    last=100 * abs(remains[-1]),
    kept=100 * kept[theirs][0],
)

# %% [markdown]
# ## Against the paper

# %% tags=["hide-input"]
about = measurement.dataset.attrs
paper.check_all(
    {
        "sec5.phase_steps": images.shape[1],
        "sec8.gain": about["gain"],
        "sec8.integration_time": about["integration_time_ms"] / 1e3,
        "sec8.noise_mean": (offset - signal * brightness / 2)[measurement.mask].mean(),
        "sec8.noise_sigma": about["noise_sigma"],
        "sec8.noise_sigma_high": ambient_noise,
        "sec8.noise_ratio": ambient_noise / NOISE_SIGMA,
    }
)
paper.table()

# %% [markdown]
# ## Exercises
#
# **1.** Compare the spread of the phase of this frame with
# [Eq. 2.1](02_precision.ipynb#eq-2.1).

# %% tags=["hide-cell"]
# The noise of a pixel follows from its brightness; the ratio of both is one.
lit = scored & (frame.intensity > 0.5)
law = simulated_phase_noise(frame.intensity[lit])
round(float(error[lit].std() / np.sqrt(np.mean(law**2))), 1)

# %% [markdown]
# **2.** Unwrap the measurement by the beat of single pixels. Which share has the right wrap?

# %% tags=["hide-cell"]
# A few in a hundred, the odds of a single bright pixel.
found = beat_depth(np.angle(beat_phasor(measured)), measured)
wraps = [
    consistent_wrap_count(z[scored], measured.phase[0][scored], f1)
    for z in (found, measured.depth)
]
round(float(np.mean(wraps[0] == wraps[1])), 2)
