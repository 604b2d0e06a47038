# %% [markdown]
# # Precision
#
# How much does a higher modulation frequency improve the depth (Paper Fig. 3, simulated)?
#
# This gain is why one builds an instrument for gigahertz light. The price is a phase that repeats
# every two centimetres.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of all noise
samples: int = 1000  # measurements at each frequency; the paper's number
points: int = 41  # frequencies between 100 MHz and 10 GHz
depth: float = 3.0  # range of the point, m; its whole wraps are taken as known
intensity: float = 0.5  # brightness of the point, 0 to 1
law_samples: int = 400_000  # phases drawn at each brightness for their law

# %% tags=["hide-input"]
import matplotlib.pyplot as plt
import numpy as np

from cmtof.bounds import phase_bound, phase_density, phase_spread, simulated_phase_noise
from cmtof.constants import (
    ADC_BITS,
    FREQUENCY_SINGLE,
    GAIN,
    INTEGRATION_TIME,
    NOISE_SIGMA,
)
from cmtof.correlation import (
    TAU,
    centred,
    correlation_from_phase,
    depth_from_phase,
    phase_from_correlation,
    phase_from_depth,
    wrap_length,
)
from cmtof.detector import poisson_gaussian, quantise
from cmtof_book import notes, paper, plotting
from cmtof_book.compared import closed_form, sum_over_draws

plotting.begin(profile=profile, seed=seed)
rng = np.random.default_rng(seed)

# %% [markdown]
# One point, 3 m away and half as bright as white, is measured repeatedly with the paper's settings:
# $G\,T = 20\,000$ counts, photon noise, Gaussian noise of σ = 1200 counts, four reference phases.
# The scale of the 14-bit converter leaves five σ at either end, so that noise is not clipped
# ([erratum 16](22_errata.ipynb#erratum-16)).

# %% tags=["hide-input"]
frequencies = np.geomspace(1e8, 1e10, points)
psi = np.arange(4) * np.pi / 2
signal = GAIN * INTEGRATION_TIME * intensity
phase = phase_from_depth(depth, frequencies)
mean = correlation_from_phase(phase, psi, amplitude=signal / np.pi, offset=signal / 2)
noisy = poisson_gaussian(
    np.repeat(mean[..., None], samples, -1), rng=rng, sigma=NOISE_SIGMA
)
pedestal = 5 * NOISE_SIGMA
full_scale = GAIN * INTEGRATION_TIME * (0.5 + 1 / np.pi) + 2 * pedestal
counts = quantise(noisy + pedestal, bits=ADC_BITS, full_scale=full_scale) - pedestal
error = centred(phase_from_correlation(counts, psi) - phase[:, None])
error = 1e3 * depth_from_phase(error, frequencies[:, None])  # mm
spread = error.std(axis=1, ddof=1)

# %% tags=["hide-input"]
bound = phase_bound(signal / np.pi, signal / 2, psi, sigma=NOISE_SIGMA, phase=phase)
law = 1e3 * depth_from_phase([phase_spread(b) for b in bound], frequencies)
ratio = spread[0] / spread[-1]
gain_in_precision = sum_over_draws(ratio, error=ratio / np.sqrt(samples - 1))
step = full_scale / (2**ADC_BITS - 1)
rounding_share = step**2 / 12 / (signal / 2 + NOISE_SIGMA**2)
print(f"rounding to {ADC_BITS} bits adds {rounding_share:.1e} of the variance")

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.9))
ghz = frequencies / 1e9
average = error.mean(axis=1)
band = {"color": "C5", "alpha": 0.45, "lw": 0, "label": "± one standard deviation"}
axes[0].fill_between(ghz, average - spread, average + spread, **band)
axes[0].plot(ghz, average, label="mean error")
axes[0].set(xscale="log", ylabel="depth error (mm)", title=f"{samples} samples each")
bound_mm = 1e3 * depth_from_phase(bound, frequencies)
plotting.sweep(axes[1], ghz, spread, color="C1", label="simulated")
axes[1].plot(ghz, bound_mm, color="black", label="Cramér–Rao bound")
axes[1].plot(
    ghz, 1e3 * wrap_length(frequencies), color=plotting.GREY, label="one wrap, $c/2f$"
)
axes[1].set(ylabel="depth (mm)", title="standard deviation")
for ax in axes:
    ax.set(xlabel="modulation frequency (GHz)")
    plotting.mark(ax, x=FREQUENCY_SINGLE / 1e9)
    ax.legend(fontsize="small")
plotting.label_panels(axes)
plotting.save(
    figure,
    "fig03_precision",
    numbers={
        "ratio": gain_in_precision,
        "spread_over_law": sum_over_draws(
            np.mean(spread / law), error=1 / np.sqrt(2 * error.size)
        ),
        "rounding_share": closed_form(rounding_share),
    },
    caption=f"Depth error of one point against modulation frequency, simulated: {samples} samples "
    "at each frequency, the paper's Poisson–Gaussian noise, 14 bits, wraps known. (a) Mean error "
    "and standard deviation. (b) Standard deviation, its bound, and the depth of a wrap. Dotted: "
    "7.15 GHz.",
    alt="Left, an envelope of depth error that closes like a funnel from 100 megahertz to 10 "
    "gigahertz, its mean near zero. Right, on logarithmic scales, parallel falling lines: the wrap "
    "length, and far below it the bound with the simulated dots on it.",
)

# %% [markdown]
# The noise does not depend on the modulation frequency, so $\sigma_\varphi$ is the same everywhere,
# and
#
# $$
# \sigma_z = \frac{c}{4\pi f}\,\sigma_\varphi , \qquad
# \sigma_\varphi \ge \frac{1}{a}\sqrt{\frac{2v}{K}} , \qquad
# a = \frac{GTI}{\pi},\quad v = \frac{GTI}{2}+\sigma^2 ,
# \tag{2.1}$$

# %% tags=["hide-input"]
notes.say(
    """
    where the right-hand side is the Cramér–Rao bound ([Kay 1993](../book/references.bib#kay1993))
    of K samples of variance v with amplitude and offset unknown. The wrap length falls as 1/f too:
    at every frequency it is {wrap_spreads:.0f} standard deviations. A higher frequency thus trades
    unambiguous range for precision. The [next chapter](03_wraps.ipynb) counts the wraps.
    """,
    wrap_spreads=1e3 * wrap_length(1e10) / law[-1],
)

# %% [markdown]
# ## Signal change at maximum and slope
#
# The paper motivates high frequencies by the change of the signal when a target moves by 1 mm, at
# the *maximum* of the cosine: $1-\cos\Delta\varphi\approx\Delta\varphi^2/2$. There a cosine changes
# least. At quadrature it changes by $\sin\Delta\varphi$.

# %% tags=["hide-input"]
turn = phase_from_depth(1e-3, np.array([1e8, 8e9]))
crest = 1 - np.cos(turn)
rows = [
    (name, f"{low:.4%}", f"{high:.1%}", f"{high / low:.0f}")
    for name, (low, high) in {"maximum": crest, "quadrature": np.sin(turn)}.items()
]
notes.table(["change over 1 mm", "100 MHz", "8 GHz", "gain"], rows)

# %% [markdown]
# The paper's two numbers are correct, but they hold at the maximum, where a cosine changes least
# and the gain is the square of the ratio of the frequencies ([erratum
# 13](22_errata.ipynb#erratum-13)). Of four samples at quarter turns some always lie on a slope, so
# the phase error does not depend on the phase.
#
# ## Large phase noise
#
# A phase is the angle of a phasor. Gaussian noise of σ in each of its components causes a phase
# noise $\sigma_\varphi=\sigma/a$ as long as σ ≪ a. For darker pixels the tails of the distribution
# grow; in the limit the angle is uniform, with standard deviation $\pi/\sqrt3$. With $\rho =
# a/\sigma$ and the distribution function Φ of the standard normal law, the density of the error is
# ([Goodman 2015](../book/references.bib#goodman2015))
#
# $$
# p(\theta) = \frac{e^{-\rho^2/2}}{2\pi}
#  + \frac{\rho\cos\theta}{\sqrt{2\pi}}\,e^{-\rho^2\sin^2\theta/2}\,\Phi(\rho\cos\theta).
# \tag{2.2}$$

# %%
brightness = np.array([1.0, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02])
linear = simulated_phase_noise(brightness)
exact = np.array([phase_spread(noise) for noise in linear])
errors = {}
for value in brightness:
    full = GAIN * INTEGRATION_TIME * value
    truth = rng.uniform(0, TAU, law_samples)
    mean = correlation_from_phase(truth, psi, amplitude=full / np.pi, offset=full / 2)
    noisy = poisson_gaussian(mean.astype(np.float32), rng=rng, sigma=NOISE_SIGMA)
    errors[value] = centred(phase_from_correlation(noisy, psi) - truth)
drawn = np.array([found.std() for found in errors.values()])

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.9))
noise_axis = np.geomspace(0.08, 8, 120)
exact_axis = [phase_spread(noise) for noise in noise_axis]
names = {"label": "simulated pixels", "bound_label": "exact law"}
plotting.sweep(axes[0], linear, drawn, bound=(noise_axis, exact_axis), **names)
axes[0].plot(
    noise_axis, noise_axis, color=plotting.GREY, ls="--", label="small-noise formula"
)
plotting.mark(axes[0], y=np.pi / np.sqrt(3), text="uniform, π/√3")
for row in zip(brightness, linear, drawn, strict=True):
    axes[0].annotate(
        f"{row[0]:g}", row[1:], (6, -11), textcoords="offset points", fontsize="small"
    )
axes[0].set(
    ylim=(0.07, 4),
    xlabel=r"small-noise formula (rad)",
    ylabel="spread of the phase (rad)",
)
axes[0].legend(loc="lower right")
theta = np.linspace(-np.pi, np.pi, 400)
for value, colour in ((1.0, "C0"), (0.3, "C2"), (0.05, "C1")):
    density, edges = np.histogram(
        errors[value], bins=90, range=(-np.pi, np.pi), density=True
    )
    axes[1].stairs(density, edges, color=colour, alpha=0.3, fill=True)
    width = float(linear[brightness == value][0])
    axes[1].plot(
        theta, phase_density(theta, width), color=colour, label=f"I = {value:g}"
    )
axes[1].set(
    xlabel="phase error (rad)", ylabel="density (1/rad)", yscale="log", ylim=(2e-4, 9)
)
axes[1].legend(loc="upper right")
plotting.label_panels(axes)

# %% tags=["hide-input"]
plotting.save(
    figure,
    "precision_phase_law",
    numbers={
        "linear": closed_form(linear),
        "law": closed_form(exact),
        "simulated": sum_over_draws(drawn, error=drawn / np.sqrt(2 * law_samples)),
    },
    caption="Noise beyond the linear regime, simulated at the paper's settings. (a) Standard "
    "deviation of the wrapped phase at eight brightnesses, with the exact law; the small-noise "
    "formula is too small down to a brightness of 0.2, slightly too large at 0.1, and exceeds what "
    "an angle can spread for darker pixels. "
    "(b) Histograms of the error, with "
    "[Eq. 2.2](#eq-2.2).",
    alt="Left, spread of the phase over the small-noise formula, both logarithmic: the points "
    "leave the diagonal upwards near 0.3 radians and bend to the level of pi over root three. "
    "Right, three histograms on their curves: narrow, wider with tails, nearly flat.",
)
print(
    f"simulated pixels agree with the law within {np.abs(drawn / exact - 1).max():.1%}"
)

# %% [markdown]
# If phasors are averaged *before* the angle is taken, the estimate stays near the bound.

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** From 100 MHz to 10 GHz, at the same noise, depth becomes {ratio:.0f} ± {error:.0f}
    times more precise, as the paper states (100): the spread falls from {low:.0f} to {high:.2f} mm.
    The range within which a phase is unambiguous shrinks by the same factor.
    """,
    ratio=ratio,
    error=ratio / np.sqrt(samples - 1),
    low=spread[0],
    high=spread[-1],
)

# %% [markdown]
# ## Against the paper

# %% tags=["hide-input"]
paper.check_all(
    {
        "fig3.frequency_low": frequencies[0],
        "fig3.frequency_high": frequencies[-1],
        "fig3.samples": samples,
        "fig3.bits": ADC_BITS,
        "fig3.precision_ratio": gain_in_precision,
        "sec3.signal_change_100mhz": closed_form(crest[0]),
        "sec3.signal_change_8ghz": closed_form(crest[1]),
    }
)
paper.table()

# %% [markdown]
# ## Exercises
#
# **1.** How many times longer must an exposure be at 1 GHz to reach the depth precision of
# 7.15 GHz, with photon noise alone?

# %% tags=["hide-cell"]
# σ_z is proportional to 1/f and, with photon noise, to one over the root of the exposure.
round((7.15e9 / 1e9) ** 2, 1)

# %% [markdown]
# **2.** At which brightness do photons and the Gaussian noise of σ = 1200 counts contribute
# equally? What is the phase noise of a white pixel without the Gaussian noise?

# %% tags=["hide-cell"]
# At none: the photons' variance is their mean count GTI/2, which never reaches σ².
ratio = NOISE_SIGMA**2 / (GAIN * INTEGRATION_TIME / 2)
print(f"σ² is {ratio:.0f} times the photons' variance of a white pixel")
[round(float(simulated_phase_noise(1.0, sigma=sigma)), 4) for sigma in (NOISE_SIGMA, 0)]
