# %% [markdown]
# # Precision
#
# Why anyone should want to modulate light at 7 GHz. Noise disturbs a *phase*, and a phase is a
# share of a wavelength: the shorter the wave, the finer the depth. This page regenerates Fig. 3 in
# simulation, puts the Cramér–Rao bound through it, asks what the 14-bit converter has to do with
# it, follows the noise beyond the point where it may be called small, and ends with the bill: at
# every frequency the ruler is only as long as a wave.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of all noise
samples: int = 1000  # measurements at each frequency; the paper's number
points: int = 41  # frequencies between 100 MHz and 10 GHz
depth: float = 3.0  # range of the point, m; its whole wraps are taken as known
intensity: float = 0.5  # brightness of the point, 0 to 1
law_samples: int = 400_000  # phases drawn at each brightness for the law of a noisy phase

# %%
import matplotlib.pyplot as plt
import numpy as np
from myst_nb import glue

from cmtof.book import paper, plotting
from cmtof.bounds import linear_phase_noise, phase_density, phase_spread
from cmtof.constants import ADC_BITS, FREQUENCY_SINGLE, GAIN, INTEGRATION_TIME, NOISE_SIGMA
from cmtof.correlation import (
    centred,
    correlation_from_phase,
    depth_from_phase,
    phase_from_correlation,
    phase_from_depth,
    wrap_length,
)
from cmtof.detector import poisson_gaussian
from cmtof.precision import precision_ratio, precision_sweep

paper_run = plotting.begin(profile=profile, seed=seed)
rng = np.random.default_rng(seed)
blue, vermillion, green, purple, orange, sky, black = (
    plotting.PALETTE[c] for c in ["blue", "vermillion", "green", "purple", "orange", "sky", "black"]
)
psi = np.arange(4) * np.pi / 2

# %% [markdown]
# ## A thousand measurements at each frequency
#
# One point of an indoor scene, 3 m away and half as bright as white, is measured again and again
# with the paper's settings: $G\,T = 20\,000$ counts, photon noise, Gaussian noise of σ = 1200
# counts, four reference phases, 14 bits. The noise knows nothing of the modulation frequency. So
# σ_φ is the same everywhere, and
#
# ```{math}
# :label: precision-depth
# \sigma_z = \frac{c}{4\pi f}\,\sigma_\varphi , \qquad
# \sigma_\varphi \ge \frac{1}{a}\sqrt{\frac{2v}{K}} , \qquad
# a = \frac{GTI}{\pi},\quad v = \frac{GTI}{2}+\sigma^2 ,
# ```
#
# where the right-hand side is what K samples of variance v allow at best: the Cramér–Rao bound
# {cite}`kay1993`, with amplitude and offset unknown.

# %%
frequencies = np.geomspace(1e8, 1e10, points)
sweep = precision_sweep(frequencies, rng=rng, samples=samples, depth=depth, intensity=intensity)
ratio = precision_ratio(sweep)
ratio_error = ratio / np.sqrt(samples - 1)  # of two spreads, 1/√(2(N − 1)) each
exponent = float(np.polyfit(np.log(frequencies), np.log(sweep.spread), 1)[0])
print(
    f"spread {1e3 * sweep.spread[0]:.1f} mm at 100 MHz, {1e3 * sweep.spread[-1]:.3f} mm at 10 GHz"
)
print(f"gain {ratio:.1f} ± {ratio_error:.1f}; through all points: spread ∝ f^{exponent:.3f}")
print(f"spread over bound {np.mean(sweep.spread / sweep.bound):.3f}, "
      f"over law {np.mean(sweep.spread / sweep.law):.3f}")  # fmt: skip

# %% [markdown]
# The converter's share can be told at once. Rounding to steps q adds a variance of $q^2/12$ to
# each sample. Its scale must hold the brightest signal and, on both sides of it, the noise.

# %%
full_scale = GAIN * INTEGRATION_TIME * (0.5 + 1 / np.pi) + 10 * NOISE_SIGMA
signal = GAIN * INTEGRATION_TIME * intensity
variance = signal / 2 + NOISE_SIGMA**2
step = full_scale / (2**ADC_BITS - 1)
rounding_phase = float(linear_phase_noise(signal / np.pi, step**2 / 12, psi.size))
rounding_share = step**2 / 12 / variance
bits_axis = np.arange(3, 15)
coarse = [
    precision_sweep(
        [FREQUENCY_SINGLE], rng=rng, samples=20 * samples, intensity=intensity, bits=int(b)
    )
    for b in bits_axis
]
excess = np.array([float(s.spread[0] / s.law[0]) for s in coarse])
step_per_bits = full_scale / (2.0**bits_axis - 1)
expected = np.sqrt(1 + step_per_bits**2 / 12 / variance)
print(
    f"one step of {ADC_BITS} bits: {step:.2f} counts; its share of the variance "
    f"{rounding_share:.1e}"
)

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 3, figsize=(11.4, 4.1), width_ratios=[1.15, 1.25, 0.85])
ax, ghz = axes[0], frequencies / 1e9
ax.fill_between(
    ghz, 1e3 * (sweep.mean - sweep.spread), 1e3 * (sweep.mean + sweep.spread),
    color=sky, alpha=0.45, lw=0, label="± one standard deviation",
)  # fmt: skip
ax.plot(ghz, 1e3 * sweep.mean, color=blue, label="mean error")
ax.set(
    xscale="log", xlabel="modulation frequency (GHz)", ylabel="depth error (mm)", ylim=(-80, 105)
)
ax.legend(loc="upper right")
ax.set_title(f"{samples} samples each")

ax = axes[1]
ax.plot(ghz, 1e3 * wrap_length(frequencies), color="#8A97A3", lw=2.4, label="one wrap, $c/2f$")
ax.plot(ghz, 1e3 * sweep.bound, color=black, label="Cramér–Rao bound")
ax.plot(
    ghz, 1e3 * sweep.spread, "o", color=vermillion, ms=5, mfc="white", label="simulated", zorder=1
)
rounding_depth = depth_from_phase(rounding_phase, frequencies)
ax.plot(ghz, 1e3 * rounding_depth, color=green, ls="--", label=f"rounding to {ADC_BITS} bits")
ax.set(xscale="log", yscale="log", xlabel="modulation frequency (GHz)", ylabel="depth (mm)")
ax.set(ylim=(8e-5, 4e5))
ax.legend(loc="upper right", fontsize="small", ncols=2, columnspacing=1.0)
ax.set_title("standard deviation")
for ax in axes[:2]:
    ax.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
    ax.axvline(FREQUENCY_SINGLE / 1e9, color="#8A97A3", lw=1, ls=":", zorder=0)
ax = axes[2]
ax.plot(bits_axis, expected, color=green, ls="--", label="$q^2/12$ added")
ax.plot(bits_axis, excess, "o", color=vermillion, ms=5, label="simulated")
ax.set(xlabel="bits of the converter", ylabel="spread over that without rounding")
ax.set_xticks([4, 6, 8, 10, 12, 14])
ax.legend(loc="upper right")
ax.set_title("how many bits?")
plotting.label_panels(axes)

at_prototype = float(np.interp(FREQUENCY_SINGLE, frequencies, sweep.spread))
plotting.save(
    figure,
    "fig03_precision",
    numbers={
        "ratio": ratio,
        "spread_mm": [1e3 * sweep.spread[0], 1e3 * sweep.spread[-1]],
        "spread_over_law": float(np.mean(sweep.spread / sweep.law)),
        "rounding_share": rounding_share,
    },
    caption=(
        f"Depth error against modulation frequency, simulated (the paper's Fig. 3): {samples} "
        "samples at each frequency, Poisson–Gaussian noise, 14 bits. (a) Mean error and "
        "envelope. (b) Their standard deviation on the Cramér–Rao bound; above it the depth of a "
        "wrap, below it the share of rounding. (c) What rounding costs at 7.15 GHz. Dotted: 7.15 "
        "GHz."
    ),
    alt=(
        "Left, an envelope of depth error that closes like a funnel from plus or minus "
        f"{1e3 * sweep.spread[0]:.0f} millimetres at 100 megahertz to a line at 10 gigahertz, its "
        "mean near zero. Middle, on logarithmic scales, parallel falling lines: the wrap length, "
        f"{wrap_length(frequencies[0]) / sweep.bound[0]:.0f} times lower the bound with the "
        "simulated dots on it, far below the rounding. Right, the cost of "
        f"rounding falls from {100 * (excess[0] - 1):.0f} percent at 3 bits to nothing at 7."
    ),
)
for name, value in {
    "ratio": ratio,
    "ratio_error": ratio_error,
    "exponent": exponent,
    "spread_low": 1e3 * sweep.spread[0],
    "spread_high": 1e3 * sweep.spread[-1],
    "spread_prototype": 1e3 * at_prototype,
    "over_bound": 100 * (np.mean(sweep.spread / sweep.bound) - 1),
    "rounding_ppm": 1e6 * rounding_share,
    "step": step,
    "six_bits": 100 * (expected[3] - 1),
}.items():
    glue(name, float(value), display=False)

# %% [markdown]
# From 100 MHz to 10 GHz the spread falls from {glue:text}`spread_low:.0f` mm to
# {glue:text}`spread_high:.2f` mm, by {glue:text}`ratio:.0f` ± {glue:text}`ratio_error:.0f` times:
# the paper's claim of 100 is just the ratio of the frequencies, and it holds; a line through all
# points gives $\sigma_z\propto f^{\,x}$ with x = {glue:text}`exponent:.2f`. The dots lie
# {glue:text}`over_bound:.0f` % above the bound, for a reason that comes in a moment.
#
# The 14 bits, on the other hand, do nothing here. One step is {glue:text}`step:.2f` counts, and
# rounding adds {glue:text}`rounding_ppm:.2f` millionths to the variance. Six bits would cost
# {glue:text}`six_bits:.1f` %. Only a converter that is *too short* hurts: with the paper's G and T
# the crest of a white pixel just fills 14 bits and its noise clips
# ({ref}`erratum 16 <erratum-16>`), so the scale here leaves five σ at either end.
#
# ## Crest or slope?
#
# The paper motivates all this by one number: how much does the signal change when a target moves
# by 1 mm? At time zero, which is the *crest* of the cosine, by
# $1-\cos\Delta\varphi\approx\Delta\varphi^2/2$. That is the one place where a cosine does not
# care. Half way up the slope, at quadrature, it changes by $\sin\Delta\varphi$.

# %%
moved = 1e-3  # m
marks = np.array([1e8, 8e9])
axis = np.geomspace(1e8, 1e10, 200)
turn, turn_marks = phase_from_depth(moved, axis), phase_from_depth(moved, marks)
crest, quadrature = 1 - np.cos(turn_marks), np.sin(turn_marks)
for f, at_crest, at_slope in zip(marks, crest, quadrature, strict=True):
    print(
        f"{f / 1e9:4.1f} GHz: {100 * at_crest:.5f} % at the crest, {100 * at_slope:.2f} % on the "
        "slope"
    )
for name, value in {
    "crest_gain": crest[1] / crest[0],
    "slope_gain": quadrature[1] / quadrature[0],
    "crest_low": 100 * crest[0],
    "crest_high": 100 * crest[1],
    "slope_low": 100 * quadrature[0],
    "slope_high": 100 * quadrature[1],
}.items():
    glue(name, float(value), display=False)

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(9.6, 3.9))
millimetres = np.linspace(-6, 6, 401)
for f, colour in zip(marks, (sky, blue), strict=True):
    angle = phase_from_depth(1e-3 * millimetres, f)
    axes[0].plot(millimetres, np.cos(angle), color=colour, label=f"{f / 1e9:g} GHz")
    axes[0].plot(millimetres, np.sin(angle), color=colour, ls="--")
axes[0].axvspan(0, 1, color=orange, alpha=0.35, lw=0)
axes[0].text(1.2, -1.24, "1 mm", color="#8A5F00", va="center")
axes[0].set(xlabel="displacement (mm)", ylabel="signal over its amplitude", ylim=(-1.4, 1.6))
axes[0].legend(ncols=2, loc="upper center")
axes[0].set_title("crest (solid), slope (dashed)")
ax = axes[1]
ax.plot(
    axis / 1e9, 100 * np.abs(np.sin(turn)), color=vermillion, ls="--", label="on the slope, ∝ f"
)
ax.plot(axis / 1e9, 100 * (1 - np.cos(turn)), color=vermillion, label="at the crest, ∝ f²")
ax.plot(marks / 1e9, 100 * quadrature, "o", color=black)
ax.plot(marks / 1e9, 100 * crest, "o", color=black)
for f, y, place in ((0.1, 100 * crest[0], (8, -3)), (8, 100 * crest[1], (-8, 6))):
    ax.annotate(f"{y:.2g} %", (f, y), place, textcoords="offset points",
                ha="left" if f < 1 else "right")  # fmt: skip
for f, y, place in ((0.1, 100 * quadrature[0], (0, 9)), (8, 100 * quadrature[1], (-8, 8))):
    ax.annotate(f"{y:.2g} %", (f, y), place, textcoords="offset points",
                ha="left" if f < 1 else "right")  # fmt: skip

ax.set(xscale="log", yscale="log", xlabel="modulation frequency (GHz)", ylim=(3e-4, 400))
ax.set(ylabel="change over 1 mm (% of amplitude)")
ax.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
ax.legend(loc="lower right")
ax.set_title("signal for one millimetre")
plotting.label_panels(axes)
plotting.save(
    figure,
    "precision_signal",
    numbers={"crest": crest, "quadrature": quadrature},
    caption=(
        "What one millimetre does to the signal. (a) Signal against displacement, from the crest "
        "and from the slope of the cosine, at 100 MHz and 8 GHz. (b) The change over 1 mm: the "
        "paper's two numbers lie on the crest."
    ),
    alt=(
        "Left, cosines and sines over twelve millimetres: at 100 megahertz nearly flat lines, at 8 "
        "gigahertz waves. Right, the change over one millimetre on logarithmic scales: the crest's "
        "line rises twice as steeply as the slope's and lies below it."
    ),
)

# %% [markdown]
# The paper's {glue:text}`crest_low:.4f` % and {glue:text}`crest_high:.1f` % are right, and taken
# where they flatter most: from one to the other is a factor of {glue:text}`crest_gain:.0f`. On the
# slope it is {glue:text}`slope_low:.2f` % and {glue:text}`slope_high:.0f` %, a factor of
# {glue:text}`slope_gain:.0f`, in step with the frequency and with {numref}`fig-fig03-precision`
# ({ref}`erratum 13 <erratum-13>`). Four samples at quarter turns always have some on a slope,
# which is why the error does not depend on where the phase lies.
#
# ## When noise is not small
#
# A phase is the angle of an arrow. Disturb the arrow's tip by Gaussian noise of σ, and as long as
# σ ≪ a the angle is Gaussian too, with $\sigma_\varphi=\sigma/a$. Let the arrow shrink, and the
# noise begins to reach around its foot: the tails grow, and in the end the angle is anything at
# all, with the spread $\pi/\sqrt3$ of a uniform law. With $\rho = a/\sigma$ the density of the
# error is {cite}`goodman2015`
#
# ```{math}
# :label: precision-law
# p(\theta) = \frac{e^{-\rho^2/2}}{2\pi}
#  + \frac{\rho\cos\theta}{\sqrt{2\pi}}\,e^{-\rho^2\sin^2\theta/2}\,\Phi(\rho\cos\theta).
# ```

# %%
brightness = np.array([1.0, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02])
linear, law, drawn, errors = [], [], [], {}
for value in brightness:
    counts = GAIN * INTEGRATION_TIME * value
    phase = rng.uniform(0, 2 * np.pi, law_samples)
    mean = correlation_from_phase(phase, psi, amplitude=counts / np.pi, offset=counts / 2)
    noisy = poisson_gaussian(mean.astype(np.float32), rng=rng, sigma=NOISE_SIGMA)
    errors[value] = centred(phase_from_correlation(noisy, psi) - phase)
    linear.append(float(linear_phase_noise(counts / np.pi, counts / 2 + NOISE_SIGMA**2, psi.size)))
    law.append(phase_spread(linear[-1]))
    drawn.append(float(errors[value].std()))
linear, law, drawn = map(np.array, (linear, law, drawn))
for row in zip(brightness, linear, law, drawn, strict=True):
    print("I = {:4.2f}: small-noise formula {:.3f}, law {:.3f}, simulated {:.3f} rad".format(*row))

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(9.8, 4.1))
ax, noise_axis = axes[0], np.geomspace(0.08, 8, 120)
ax.plot(noise_axis, noise_axis, color="#8A97A3", ls="--", label="small-noise formula (bound)")
ax.plot(noise_axis, [phase_spread(s) for s in noise_axis], color=black, label="exact law")
ax.plot(linear, drawn, "o", color=vermillion, label="simulated pixels")
ax.axhline(np.pi / np.sqrt(3), color="#8A97A3", lw=1, ls=":")
ax.text(0.085, np.pi / np.sqrt(3) * 1.06, "any angle at all, π/√3", color="#5A646D")
for value, x, y in zip(brightness, linear, drawn, strict=True):
    ax.annotate(f"I = {value:g}" if value == 1 else f"{value:g}", (x, y), (7, -11),
                textcoords="offset points", fontsize="small")  # fmt: skip
ax.set(xscale="log", yscale="log", ylim=(0.07, 4), xlim=(0.08, 8))
ax.set(
    xlabel=r"$\sigma_\varphi$ of the small-noise formula (rad)", ylabel="spread of the phase (rad)"
)
ax.set_xticks([0.1, 0.3, 1, 3], ["0.1", "0.3", "1", "3"])
ax.set_yticks([0.1, 0.3, 1, 3], ["0.1", "0.3", "1", "3"])
ax.legend(loc="lower right")
ax.set_title("how far phases scatter")

ax, theta = axes[1], np.linspace(-np.pi, np.pi, 400)
for value, colour in ((1.0, blue), (0.3, green), (0.05, vermillion)):
    density, edges = np.histogram(errors[value], bins=90, range=(-np.pi, np.pi), density=True)
    ax.stairs(density, edges, color=colour, alpha=0.3, fill=True)
    width = float(linear[brightness == value][0])
    ax.plot(theta, phase_density(theta, width), color=colour, label=f"I = {value:g}")
ax.set(xlabel="phase error (rad)", ylabel="density (1/rad)", yscale="log", ylim=(2e-4, 9))
ax.set_xticks([-np.pi, 0, np.pi], ["−π", "0", "π"])
ax.legend(loc="upper right")
ax.set_title("histograms on the law")
plotting.label_panels(axes)
plotting.save(
    figure,
    "precision_phase_law",
    numbers={"linear": linear, "law": law, "simulated": drawn},
    caption=(
        "Noise beyond the linear regime, simulated at the paper's settings. (a) Spread of the "
        "wrapped phase at eight brightnesses I, on the exact law; the small-noise formula is too "
        "kind to dark pixels. (b) Histograms of the error on {eq}`precision-law`, logarithmic: "
        "tails grow and fill the circle."
    ),
    alt=(
        "Left, spread of the phase over the small-noise formula, both logarithmic: the points "
        "leave the diagonal upwards near 0.3 radians, and bend to the level of pi over root "
        "three. Right, three histograms on their curves: narrow for full brightness, wider with "
        "tails for 0.3, nearly flat for 0.05."
    ),
)
for name, value in {
    "law_white": 100 * (law[0] / linear[0] - 1),
    "law_half": 100 * (law[2] / linear[2] - 1),
    "law_dark": 100 * (law[3] / linear[3] - 1),
    "agreement": 100 * np.abs(drawn / law - 1).max(),
}.items():
    glue(name, float(value), display=False)

# %% [markdown]
# The simulated pixels keep to the law within {glue:text}`agreement:.1f` %. At full brightness it
# lies {glue:text}`law_white:.0f` % above the small-noise formula, at half brightness
# {glue:text}`law_half:.0f` % (the gap in {numref}`fig-fig03-precision`), at I = 0.3
# {glue:text}`law_dark:.0f` %. The cure is to average *before* taking the angle: sums of arrows are
# linear, and pooled estimates keep to the bound.
#
# ## The bill
#
# {numref}`fig-fig03-precision` (b) holds the whole dilemma in two parallel lines. The spread falls
# as 1/f; the wrap, the length of the ruler, falls as 1/f too. Their ratio never changes: at this
# brightness a wrap holds as many spreads at 10 GHz as at 100 MHz. Frequency buys no information
# about *where in the room* a point is. It trades length for fineness.


# %%
def told(frequency):
    return float(wrap_length(frequency)), float(np.interp(frequency, frequencies, sweep.law))


wrap_low, spread_low = told(1e8)
wrap_high, spread_high = told(FREQUENCY_SINGLE)
print(f"100 MHz : one wrap {1e3 * wrap_low:7.1f} mm, spread {1e3 * spread_low:.2f} mm")
print(f"7.15 GHz: one wrap {1e3 * wrap_high:7.1f} mm, spread {1e3 * spread_high:.2f} mm")
for name, value in {
    "wrap_low": wrap_low,
    "wrap_high": 1e3 * wrap_high,
    "spreads_in_wrap": wrap_high / spread_high,
    "wraps_in_room": 5.0 / wrap_high,
    "missing_digits": spread_low / wrap_high,
}.items():
    glue(name, float(value), display=False)

# %% [markdown]
# One wrap is {glue:text}`spreads_in_wrap:.0f` spreads long at either frequency. At 100 MHz it is
# {glue:text}`wrap_low:.1f` m, and a room holds a handful; at 7.15 GHz it is
# {glue:text}`wrap_high:.0f` mm, and a room of 5 m holds {glue:text}`wraps_in_room:.0f`. Nor can a
# 100 MHz camera of the same noise tell which one it is: its spread is
# {glue:text}`missing_digits:.0f` wraps. **Counting them is the price of precision**, and the
# {doc}`next page <03_wraps>` looks at it.
#
# ## Against the paper

# %%
paper.check("fig3.frequency_low", frequencies[0])
paper.check("fig3.frequency_high", frequencies[-1])
paper.check("fig3.samples", samples)
paper.check("fig3.bits", ADC_BITS)
paper.check("fig3.precision_ratio", ratio)
paper.check("sec3.signal_change_100mhz", crest[0])
paper.check("sec3.signal_change_8ghz", crest[1])
