# %% [markdown]
# # Simulated measurements
#
# No public data set holds correlation images at 7 GHz with a known truth, so the paper makes its
# own from depth and colour, and so does this book. This page follows one frame through Section 5.3
# and 5.4: in go depth and brightness, out come correlation images by Eq. {eq}`eq-8`, and back come
# phase and amplitude by Eq. {eq}`eq-9`. Everything on it is simulated.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of all noise
frame_name: str = "still_life"  # embedded frame
ambient_noise: float = 2000.0  # Gaussian σ of the paper's setting with ambient light, counts
draws: int = 200_000  # pixels drawn at each brightness for the noise curves
steps: int = 7  # reference phases of the irregular decoding

# %%
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from myst_nb import glue

import cmtof
from cmtof.book import paper, plotting
from cmtof.bounds import linear_phase_noise, phase_spread
from cmtof.constants import FREQUENCIES, GAIN, INTEGRATION_TIME, NOISE_SIGMA
from cmtof.correlation import (
    centred,
    consistent_wrap_count,
    correlation_from_phase,
    decode,
    depth_from_wraps,
    phase_variance,
    wrap_count_from_depth,
    wrapped,
)
from cmtof.detector import poisson_gaussian
from cmtof.scenes import embedded_frames
from cmtof.simulation import QUADRATURES, true_phase

paper_run = plotting.begin(profile=profile, seed=seed)
rng = np.random.default_rng(seed)
blue, vermillion, green, purple, orange, sky, black = (
    plotting.PALETTE[c] for c in ["blue", "vermillion", "green", "purple", "orange", "sky", "black"]
)
frame = cmtof.load_frame(frame_name)
psi = np.array(QUADRATURES)

# %% [markdown]
# ## Forward: from a picture to correlations
#
# A pixel of range z and linear brightness I (the green channel; the laser is green) has the phase
# $\varphi = 4\pi fz/c$ and gives, at reference phase ψ,
#
# ```{math}
# :label: eq-8
# C_\psi = G\,T\,I_g\left(0.5+\frac{\cos(\phi+\psi)}{\pi}\right)+\eta_P+\eta_G ,
# ```
#
# with $GT = 20\,000$ counts, photon noise $\eta_P$ and Gaussian noise $\eta_G$ of σ = 1200 counts.
# {doc}`Which instrument <01_correlation>` has this contrast of 2/π is another question.

# %%
measurement = cmtof.simulate(frame, protocol="full", seed=seed)
images = measurement.dataset["correlation"].to_numpy()
phase, amplitude, offset = (field[0] for field in measurement.decoded)
print(measurement)
print(
    "correlation",
    images.shape,
    images.dtype,
    f"from {images.min():.0f} to {images.max():.0f} counts",
)
low, high = np.percentile(images[0], [0.5, 99.5])

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 4, figsize=(12.4, 4.6))
plotting.image(
    axes[0, 0], np.clip(frame.intensity, 0, 1), label="", title="in: brightness I", cmap="gray"
)
plotting.image(axes[0, 1], frame.depth, label="", title="in: depth z (m)")
plotting.phase_image(axes[0, 2], phase, title=r"out: phase $\hat\varphi$", label="")
plotting.image(axes[0, 3], amplitude / 1e3, label="", title="out: amplitude (10³ counts)",
               limits=(0, GAIN * INTEGRATION_TIME / np.pi / 1e3))  # fmt: skip
for ax, image, name in zip(axes[1], images[0], ("0", "π/2", "π", "3π/2"), strict=True):
    plotting.image(
        ax, image / 1e3, label="", title=f"$C_ψ$, ψ = {name}", limits=(low / 1e3, high / 1e3)
    )
axes[1, 3].images[0].colorbar.set_label("10³ counts")
plotting.label_panels(axes.flat)
plotting.save(
    figure,
    "simulation_correlations",
    format="png",
    numbers={
        "median_amplitude": float(np.median(amplitude)),
        "median_count": float(np.median(images[0])),
    },
    caption=(
        f"The frame `{frame_name}` through the simulator at 7.15 GHz. (a, b) What goes in. (e–h) "
        "The four correlation images at the paper's noise. (c, d) What is decoded from them. "
        "Every fringe of (c) is 21 mm of depth."
    ),
    alt=(
        "Eight images of a table top with bust, vase and books: brightness, depth, decoded phase "
        "with many fringes, decoded amplitude; below, four correlation images in which the "
        "fringes wander by a quarter period from one to the next."
    ),
)

# %% [markdown]
# ## Backward: any ψ, in any order
#
# The paper decodes with a Fourier transform along ψ,
#
# ```{math}
# :label: eq-9
# \hat\phi = \mathrm{angle}\bigl(\mathcal F_2(C_\psi)\bigr),\qquad
# \hat a = 2\,\bigl|\mathcal F_2(C_\psi)\bigr| .
# ```
#
# That holds for equal steps in rising order only, and the index wants care: if $\mathcal F_0$ is
# the mean, as the paper says, the fundamental is $\mathcal F_1$, and of four samples
# $\mathcal F_2$ is the Nyquist bin, which is real ({ref}`erratum 7 <erratum-7>`). Here decoding is
# a **least-squares fit** of
#
# ```{math}
# :label: simulation-fit
# C_\psi = d + x\cos\psi - y\sin\psi ,\qquad
# \hat\varphi = \mathrm{atan2}(y, x),\quad \hat a=\sqrt{x^2+y^2},
# ```
#
# to whatever ψ the file states: any number from three up, any spacing, any order.

# %%
truth = np.linspace(0, 2 * np.pi, 400, endpoint=False)
irregular = rng.permutation(
    np.linspace(0, 2 * np.pi, steps, endpoint=False) + rng.uniform(-0.3, 0.3, steps)
)
curve = correlation_from_phase(truth, irregular, amplitude=2.0, offset=7.0)
fit_error = float(np.abs(centred(decode(curve, irregular).phase - truth)).max())
print("ψ =", np.round(irregular, 2), f"-> largest phase error {fit_error:.0e} rad")

# %% [markdown]
# What the other readings would give is best seen with the noise of a white pixel: without any, the
# Nyquist bin is exactly zero and has no angle at all.

# %%
signal = GAIN * INTEGRATION_TIME
clean_four = correlation_from_phase(truth, psi, amplitude=signal / np.pi, offset=signal / 2)
four = poisson_gaussian(clean_four, rng=rng, sigma=NOISE_SIGMA)
printed_order = [0, 1, 3, 2]  # {0, π/2, 3π/2, π}, as Section 5.3 lists them
spectrum, misordered = np.fft.fft(four, axis=0), np.fft.fft(four[printed_order], axis=0)
readings = {
    "$F_1$, steps in order": wrapped(np.angle(spectrum[1])),
    "$F_2$, as printed": wrapped(np.angle(spectrum[2])),
    "$F_1$, in the order of Section 5.3": wrapped(np.angle(misordered[1])),
}
reading_error = [float(np.sqrt(np.mean(centred(r - truth) ** 2))) for r in readings.values()]
same = float(np.abs(centred(readings["$F_1$, steps in order"] - decode(four, psi).phase)).max())
print(f"F1 against least squares: {same:.0e} rad")
for name, error in zip(readings, reading_error, strict=True):
    print(f"{name}: off by {error:.3f} rad rms")

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 3, figsize=(10.4, 3.5), sharex=True, sharey=True)
for ax, (name, reading), colour in zip(
    axes, readings.items(), (blue, vermillion, purple), strict=True
):
    ax.plot(truth, truth, color="#C4CBD1", lw=5, solid_capstyle="butt")
    ax.plot(truth, reading, ".", color=colour, ms=4)
    ax.set(title=name, xlabel="true phase")
    ax.set_xticks([0, np.pi, 2 * np.pi], ["0", "π", "2π"])
    ax.set_yticks([0, np.pi, 2 * np.pi], ["0", "π", "2π"])
axes[0].set_ylabel("decoded phase")
plotting.label_panels(axes)
plotting.save(
    figure,
    "simulation_decoding",
    numbers={"rms_error_rad": reading_error},
    caption=(
        "Decoding four simulated samples of white pixels. (a) The fundamental, which is the "
        "least-squares fit, returns the phase (grey) and its noise. (b) The Nyquist bin is real: "
        "its angle is 0 or π, and noise tosses the coin. (c) The fundamental of samples in the "
        "order in which Section 5.3 lists them knows two directions."
    ),
    alt=(
        "Three panels of decoded over true phase. Left, dots along the grey diagonal. Middle, "
        "dots on the lines zero and pi only. Right, dots about two horizontal lines half a turn "
        "apart."
    ),
)
glue("steps", steps, display=False)
for name, error in zip(("right", "nyquist", "misordered"), reading_error, strict=True):
    glue(f"error_{name}", error, display=False)
glue("error_blind", np.pi / np.sqrt(3), display=False)

# %% [markdown]
# {glue:text}`steps:.0f` irregular, shuffled phases are decoded to the last bit. Four in order give
# the phase with {glue:text}`error_right:.2f` rad of noise. {eq}`eq-9` read literally errs by
# {glue:text}`error_nyquist:.2f` rad, the right bin with the ψ in printed order by
# {glue:text}`error_misordered:.2f`; guessing would err by {glue:text}`error_blind:.2f`. Whoever
# stores a measurement should store its ψ.
#
# ### Round trip
#
# Without noise the way there and back must be exact. The images are single precision, which costs
# about a microradian; with the right whole turns, depth comes back to nanometres.

# %%
worst = {}
f1 = FREQUENCIES[0]
for name in embedded_frames():
    clean = cmtof.simulate(cmtof.load_frame(name), protocol="full", noise_free=True)
    lit = np.isfinite(clean.depth) & (clean.amplitude[0] > 10) & clean.mask
    z, phi = clean.depth[lit].astype(float), clean.phase[0][lit].astype(float)
    phase_error = centred(phi - true_phase(clean)[lit])
    depth_error = depth_from_wraps(phi, consistent_wrap_count(z, phi, f1), f1) - z
    across = int(np.sum(consistent_wrap_count(z, phi, f1) != wrap_count_from_depth(z, f1)))
    worst[name] = float(np.abs(phase_error).max()), float(np.abs(depth_error).max())
    print(f"{name}: phase {1e6 * worst[name][0]:.1f} µrad, depth {1e9 * worst[name][1]:.1f} nm")
    print(f"   pixels that rounding moved across a wrap's boundary: {across}")
glue("round_trip", 1e6 * max(w[0] for w in worst.values()), display=False)
glue("round_trip_depth", 1e9 * max(w[1] for w in worst.values()), display=False)

# %% [markdown]
# At most {glue:text}`round_trip:.1f` µrad and {glue:text}`round_trip_depth:.0f` nm. A pixel that
# sits on the boundary of a wrap by less than that may fall to its other side; the depth is then
# right again with the neighbouring count, which is why the book keeps
# {doc}`two wrap counts <03_wraps>` apart.
#
# ## Noise, in two orders
#
# {eq}`eq-8` adds photon noise to the signal, then Gaussian noise. The authors' released code does
# it the other way round: Gaussian noise first, clipped at zero, and a Poisson draw of what
# remains. For bright pixels that is the same. For dark ones it is not: with σ = 1200 counts most
# of the Gaussian's lower half would be negative, and the clipping lifts the mean and shrinks the
# cosine.

# %%
brightness = np.geomspace(0.02, 1, 12)
settings = {
    "paper's order": ("paper", NOISE_SIGMA, blue, "o"),
    "released code's order": ("released", NOISE_SIGMA, vermillion, "s"),
    f"ambient light, σ = {ambient_noise:.0f}": ("paper", ambient_noise, green, "^"),
}
spread, kept = {}, {}
for name, (order, sigma, _, _) in settings.items():
    for value in brightness:
        counts = GAIN * INTEGRATION_TIME * value
        angle = rng.uniform(0, 2 * np.pi, draws)
        mean = correlation_from_phase(angle, psi, amplitude=counts / np.pi, offset=counts / 2)
        noisy = poisson_gaussian(mean.astype(np.float32), rng=rng, sigma=sigma, order=order)
        decoded = decode(noisy, psi)
        error = centred(decoded.phase - angle)
        spread[name, value] = float(error.std())
        # the decoded phasor along the true direction, over the true amplitude
        kept[name, value] = float(np.mean(decoded.amplitude * np.cos(error)) / (counts / np.pi))

# %% [markdown]
# The frame gives the same answer without any flat target: its pixels, sorted by brightness,
# scatter about their true phases as the law says.

# %%
noisy_error = centred(phase - true_phase(measurement))
level = np.clip(frame.intensity, 0, 1)
edges = np.geomspace(0.04, 1.0001, 13)
inside = [(level >= a) & (level < b) & np.isfinite(measurement.depth) for a, b in pairwise(edges)]
inside = [m for m in inside if m.sum() > 200]
frame_level = np.array([level[m].mean() for m in inside])
frame_spread = np.array([noisy_error[m].std() for m in inside])


def theory(value, sigma):
    signal = GAIN * INTEGRATION_TIME * np.asarray(value)
    return linear_phase_noise(signal / np.pi, signal / 2 + sigma**2, psi.size)


general = np.sqrt(phase_variance(psi, phase=0.3, amplitude=signal / np.pi,
                                 variance=signal / 2 + NOISE_SIGMA**2))  # fmt: skip
print(
    f"σ_φ at I = 1: formula {theory(1.0, NOISE_SIGMA):.4f}, from the fit's own weights "
    f"{general:.4f} rad"
)

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(10.2, 4.3))
ax, fine = axes[0], np.geomspace(0.018, 1.05, 100)
ax.plot(fine, theory(fine, NOISE_SIGMA), color="#8A97A3", ls="--", label="bound, σ = 1200")
ax.plot(
    fine,
    [phase_spread(float(s)) for s in theory(fine, NOISE_SIGMA)],
    color=black,
    label="exact law",
)
ax.plot(fine, [phase_spread(float(s)) for s in theory(fine, ambient_noise)], color=black, lw=1)
for name, (_, _, colour, marker) in settings.items():
    ax.plot(
        brightness, [spread[name, v] for v in brightness], marker, color=colour, ms=5, label=name
    )
ax.plot(frame_level, frame_spread, "D", mfc="none", mec=black, ms=5, label="pixels of the frame")
ax.set(
    xscale="log",
    yscale="log",
    xlabel="brightness I",
    ylabel="spread of the phase (rad)",
    ylim=(0.1, 4),
)
ax.set_xticks([0.02, 0.05, 0.1, 0.2, 0.5, 1], ["0.02", "0.05", "0.1", "0.2", "0.5", "1"])
ax.set_yticks([0.1, 0.3, 1, 3], ["0.1", "0.3", "1", "3"])
ax.minorticks_off()
ax.legend(loc="lower left", fontsize="small")
ax.set_title("noise of the phase")
ax = axes[1]
for name in list(settings)[:2]:
    _, _, colour, marker = settings[name]
    ax.plot(
        brightness,
        [100 * kept[name, v] for v in brightness],
        marker + "-",
        color=colour,
        label=name,
    )
ax.set(
    xscale="log",
    xlabel="brightness I",
    ylabel="mean decoded signal (% of the true)",
    ylim=(40, 110),
)
ax.set_xticks([0.02, 0.05, 0.1, 0.2, 0.5, 1], ["0.02", "0.05", "0.1", "0.2", "0.5", "1"])
ax.minorticks_off()
ax.legend(loc="lower right")
ax.set_title("what clipping takes")
plotting.label_panels(axes)

ours, theirs = list(settings)[:2]
dark = brightness[0]
agreement = max(
    abs(spread[ours, v] / phase_spread(float(theory(v, NOISE_SIGMA))) - 1) for v in brightness
)
plotting.save(
    figure,
    "simulation_noise",
    numbers={
        "spread_paper": [spread[ours, v] for v in brightness],
        "spread_released": [spread[theirs, v] for v in brightness],
        "kept_released": [kept[theirs, v] for v in brightness],
    },
    caption=(
        "Noise of the simulated phase at four ψ. (a) Spread against brightness on bound and "
        "exact law, for both orders of noise, for the paper's ambient light, and for the pixels "
        "of the frame. (b) The mean of the decoded phasor along its true direction: clipping at "
        "zero shortens it."
    ),
    alt=(
        "Left, spread over brightness, both logarithmic, falling from "
        f"{spread[ours, dark]:.1f} radians for dark pixels to "
        f"{spread[ours, brightness[-1]]:.2f} for white ones; symbols of both orders lie close to "
        "the law, ambient light lies higher. Right, the decoded signal: whole at all "
        "brightnesses in the paper's order, falling to "
        f"{100 * kept[theirs, dark]:.0f} percent for dark pixels in the released code's."
    ),
)
for name, value in {
    "agreement": 100 * agreement,
    "kept_dark": 100 * kept[theirs, dark],
    "dark": dark,
    "white": spread[ours, 1.0],
    "white_ambient": spread[list(settings)[2], 1.0],
    "ambient_ratio": ambient_noise / NOISE_SIGMA,
}.items():
    glue(name, float(value), display=False)

# %% [markdown]
# In the paper's order the simulation keeps to the law within {glue:text}`agreement:.1f` %. In the
# released code's order a pixel of brightness {glue:text}`dark:.2f` keeps
# {glue:text}`kept_dark:.0f` % of its signal, while its phase scatters just as much: what clipping
# takes from the noise it takes from the cosine too. This book simulates in the paper's order
# (`order="released"` has the other). Ambient light, as the paper models it, multiplies σ by
# {glue:text}`ambient_ratio:.2f` and raises a white pixel's noise from {glue:text}`white:.3f` to
# {glue:text}`white_ambient:.3f` rad.
#
# ## Two protocols
#
# What is asked of an unwrapping method depends on what it may assume. **released** follows the
# authors' code: the scene is shrunk until nearly all of it lies within 1.195 m, and only pixels in
# wraps 36 to 56 are scored, 21 classes. **full** leaves the scene as it is and scores everything
# within the beat's 7.495 m. A pixel that is not scored keeps its light: the camera sees it.

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 3, figsize=(10.8, 5.1))
coverage = {}
for column, name in enumerate(embedded_frames()):
    for row, protocol in enumerate(("released", "full")):
        seen = cmtof.simulate(cmtof.load_frame(name), protocol=protocol, noise_free=True)
        coverage[name, protocol] = float(seen.mask.mean())
        shown = np.where(seen.mask, seen.depth, np.nan)
        plotting.image(
            axes[row, column], shown, label="depth (m)" if column == 2 else "",
            title=f"{name}, {protocol}: {100 * coverage[name, protocol]:.0f} %",
        )  # fmt: skip
plotting.label_panels(axes.flat)
plotting.save(
    figure,
    "simulation_protocols",
    format="png",
    numbers={p: [coverage[n, p] for n in embedded_frames()] for p in ("released", "full")},
    caption=(
        "The depth that each protocol asks for, on the three embedded frames, and the share of "
        "pixels scored; grey is not scored. Mind the colour bars: in `released` every scene is a "
        "model of itself."
    ),
    alt=(
        "Two rows of three depth images. Above, the released protocol: a narrow span of depths, "
        "large grey areas in the foreground. Below, the full protocol: the whole depth of each "
        "room, no grey."
    ),
)
ratio = np.mean([coverage[n, "released"] for n in embedded_frames()])
glue("coverage_released", 100 * float(ratio), display=False)
glue(
    "coverage_full",
    100 * float(np.mean([coverage[n, "full"] for n in embedded_frames()])),
    display=False,
)

# %% [markdown]
# `released` scores {glue:text}`coverage_released:.0f` % of all pixels here, `full`
# {glue:text}`coverage_full:.0f` %. Rates of the two must never stand in one column.
#
# ## Against the paper

# %%
settings_of_run = measurement.dataset.attrs
paper.check("sec5.phase_steps", images.shape[1])
paper.check("sec8.gain", settings_of_run["gain"])
paper.check("sec8.integration_time", settings_of_run["integration_time_ms"] / 1e3)
paper.check(
    "sec8.noise_mean",
    float(np.mean((offset - signal * level / 2)[measurement.mask])),
    tolerance=10.0,
)
paper.check("sec8.noise_sigma", settings_of_run["noise_sigma"])
paper.check("sec8.noise_sigma_high", ambient_noise)
paper.check("sec8.noise_ratio", ambient_noise / NOISE_SIGMA)
paper.check("sec8.frequency_low", measurement.frequencies[0])
paper.check("sec8.frequency_high", measurement.frequencies[1])
