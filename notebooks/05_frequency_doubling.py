# %% [markdown]
# # Frequency doubling
#
# The same modulator with its half-wave plate at 22.5° lets light through at twice the frequency of
# its drive (Section 6.2.2). This page regenerates Fig. 8 *in simulation*, where the paper measured
# it: the exact waveforms, the paper's weak-drive approximation, and what a 12 GHz photodiode would
# show of them. Then it asks what the drive η buys.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of the photodiode's noise
eta: float = 0.26  # drive amplitude in one pass, rad
bandwidth: float = 12e9  # -3 dB bandwidth of the photodiode, Hz
noise: float = 0.01  # standard deviation of its noise, in units of the light that enters
points: int = 400  # drive amplitudes on the axis of the last figure

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import sympy as sp
from myst_nb import glue
from scipy.special import jv

from cmtof.book import paper, plotting
from cmtof.constants import FREQUENCY_DOUBLED, FREQUENCY_SINGLE, SPEED_OF_LIGHT
from cmtof.correlation import correlation_contrast
from cmtof.modulator import (
    DOUBLED,
    SINGLE,
    doubled_mode_harmonics,
    doubled_mode_taylor,
    single_mode_harmonics,
    single_mode_taylor,
)
from cmtof.waveform import low_pass_harmonics, waveform_from_harmonics

paper_run = plotting.begin(profile=profile, seed=seed)
blue, vermillion, black = (plotting.PALETTE[c] for c in ("blue", "vermillion", "black"))
single, doubled = replace(SINGLE, eta=eta), replace(DOUBLED, eta=eta)

# %% [markdown]
# ## A factor of two
#
# The paper puts the drive into {eq}`eq-18` and expands for small η:
#
# ```{math}
# :label: eq-19
# \begin{aligned}
# I(t) &= \frac{A^2}{2}\bigl(1-\cos(2\eta\sin(\omega t-\phi))\bigr)\\
#      &\approx \frac{A^2}{2}\eta^2\sin^2(\omega t-\phi)\\
#      &= \frac{A^2}{4}\eta^2\bigl(1-\cos(2\omega t-2\phi)\bigr)
# \end{aligned}
# ```
#
# The first line is exact. But $1-\cos x \approx x^2/2$ with $x = 2\eta\sin\theta$,
# $\theta = \omega t-\phi$, so the second is *half* of what it approximates: it should read
# $A^2\eta^2\sin^2\theta = (A^2\eta^2/2)(1-\cos 2\theta)$.

# %%
e, theta = sp.symbols("eta theta", real=True)
exact = (1 - sp.cos(2 * e * sp.sin(theta))) / 2
lowest = sp.series(exact, e, 0, 4).removeO()
printed = e**2 * sp.sin(theta) ** 2 / 2
corrected = e**2 * (1 - sp.cos(2 * theta)) / 2
print("lowest order:", lowest, " over the printed one:", sp.simplify(lowest / printed))
print("lowest order − (η²/2)(1 − cos 2θ), residual:", sp.simplify(lowest - corrected))

# %% [markdown]
# The text then says that the doubled mode has a quarter of the single mode's amplitude. Neither
# version gives a fixed number. The exact series (Jacobi–Anger) has the amplitudes $A^2J_1(2\eta)$
# and $A^2J_2(2\eta)$; their ratio begins with η/2 (the printed formulas: η/4) and follows the
# drive.

# %%
x = sp.symbols("x", positive=True)
ratio_series = sp.series(sp.besselj(2, 2 * x) / sp.besselj(1, 2 * x), x, 0, 4)
print("J_2(2η)/J_1(2η) =", ratio_series)
ratio = float(jv(2, 2 * eta) / jv(1, 2 * eta))
eta_quarter = float(sp.nsolve(sp.besselj(2, 2 * x) / sp.besselj(1, 2 * x) - 0.25, x, 0.5))
print(f"at η = {eta}: {ratio:.3f}, not 0.25; a quarter is reached at η = {eta_quarter:.3f}")
glue("ratio", ratio, display=False)
glue("eta_quarter", eta_quarter, display=False)

# %% [markdown]
# ## The exact spectrum
#
# Harmonics from the product of Jones matrices against the Bessel functions: odd ones only in the
# single mode, even ones only in the doubled.

# %%
count = 8
single_w, doubled_w = single.harmonics(count), doubled.harmonics(count)
single_error = np.abs(single_w - single_mode_harmonics(eta, count)).max()
doubled_error = np.abs(doubled_w - doubled_mode_harmonics(eta, count)).max()
print(f"Jones against Bessel: {single_error:.0e} and {doubled_error:.0e}")
third = abs(single_w[3] / single_w[1])
fourth = abs(doubled_w[4] / doubled_w[2])
print(f"J_3/J_1 = {100 * third:.2f} %, J_4/J_2 = {100 * fourth:.2f} %")

# %% [markdown]
# ## What a fast photodiode would show
#
# Fig. 8 of the paper was taken with a fast photodetector that the text does not name; the fastest
# at hand had 12 GHz (Section 7.4). As a first-order low pass it weakens 14.32 GHz and delays it.
# The dots are *simulated* samples with Gaussian noise, no measurement. Each panel shows two
# periods of the drive.

# %%
rng = np.random.default_rng(seed)
cycles = np.linspace(0, 2, 401)
sampled = np.linspace(0, 2, 81)


def photodiode(modulator, drive_cycles):
    seen = low_pass_harmonics(
        modulator.harmonics(24), frequency=modulator.frequency, cutoff=bandwidth
    )
    return waveform_from_harmonics(seen, 2 * np.pi * drive_cycles)


def picoseconds(modulator, drive_cycles):
    return 1e12 * drive_cycles / modulator.frequency


# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 2, figsize=(9.2, 6.8), height_ratios=[1.35, 1])
theta_axis = 2 * np.pi * cycles
approximations = (
    single_mode_taylor(theta_axis, eta=eta),
    doubled_mode_taylor(theta_axis, eta=eta),
)
titles = (r"$\theta_h$ = 11.25°, 7.15 GHz", r"$\theta_h$ = 22.5°, 7.16 → 14.32 GHz")
printed_line = axes[0, 1].plot(
    picoseconds(doubled, cycles), doubled_mode_taylor(theta_axis, eta=eta) / 2
)[0]
printed_line.set(color=plotting.PALETTE["orange"], ls=":", label="Eq. 19 as printed")
for ax, mode, taylor, title in zip(axes[0], (single, doubled), approximations, titles, strict=True):
    time = picoseconds(mode, cycles)
    seen = photodiode(mode, sampled) + rng.normal(0, noise, sampled.size)
    ax.plot(picoseconds(mode, sampled), seen, ".", ms=4, color="#9AA4AD", label="photodiode, noisy")
    ax.plot(time, mode.waveform(theta_axis), color=blue, lw=2.4, label="exact")
    ax.plot(time, taylor, color=vermillion, ls="--", label="lowest order in η")
    ax.plot(time, photodiode(mode, cycles), color=black, lw=1.3, label="through 12 GHz")
    ax.set(title=title, xlabel="time (ps)", xlim=(0, time[-1]))

# %% tags=["hide-input"]
axes[0, 0].set(ylabel="transmitted intensity, $I/A^2$", ylim=(0, 1))
axes[0, 1].set(ylim=(-0.03, 0.13))
for ax in axes[0]:
    ax.legend(loc="upper center", ncols=2, fontsize="small", columnspacing=1.2)
for ax, mode, series in zip(
    axes[1], (single, doubled), (single_mode_harmonics, doubled_mode_harmonics), strict=True
):
    k = np.arange(count + 1)
    exact_w, bessel = 2 * np.abs(mode.harmonics(count)), 2 * np.abs(series(eta, count))
    seen = np.abs(low_pass_harmonics(exact_w, frequency=mode.frequency, cutoff=bandwidth))
    strong, ghz = exact_w[1:] > 1e-8, mode.frequency * k[1:] / 1e9
    ax.vlines(ghz[strong], 1e-9, exact_w[1:][strong], color=blue, lw=5, label="Jones product")
    ax.plot(
        ghz[strong], bessel[1:][strong], "o", mfc="none", color=vermillion, ms=10, label="Bessel"
    )
    ax.plot(ghz[strong], seen[1:][strong], "_", color=black, ms=16, mew=2, label="through 12 GHz")
    ax.set(yscale="log", ylim=(1e-8, 3), xlabel="frequency (GHz)", xlim=(0, 60))
    ax.set_xticks(mode.frequency / 1e9 * np.arange(0, 9, 2 if mode is doubled else 1))
    ax.tick_params(axis="x", labelrotation=0)
    ax.xaxis.set_major_formatter("{x:.1f}")

# %% tags=["hide-input"]
axes[1, 0].set_ylabel("amplitude, $2|W_k|/A^2$")
axes[1, 1].legend(loc="upper right", fontsize="small")
plotting.label_panels(axes.flat)
response = {
    name: float(np.abs(1 / (1 + 1j * f / bandwidth)))
    for name, f in (("single", FREQUENCY_SINGLE), ("doubled", FREQUENCY_DOUBLED))
}
taylor_error = [eta - np.sin(2 * eta) / 2, eta**2 - np.sin(eta) ** 2]
plotting.save(
    figure,
    "fig08_doubling",
    numbers={
        "amplitude_single": 2 * abs(single_w[1]),
        "amplitude_doubled": 2 * abs(doubled_w[2]),
        "doubled_over_single": ratio,
        "third_harmonic": third,
        "fourth_harmonic": fourth,
        "photodiode_response": list(response.values()),
        "taylor_error": taylor_error,
    },
    caption=(
        f"Single and doubled mode at η = {eta:.2f}, simulated (the paper's Fig. 8 is a "
        "measurement; mind the different scales of (a) and (b)). (a, b) The exact waveform, its "
        "lowest order, and what a first-order 12 GHz photodiode shows. (c, d) Harmonics of the "
        "Jones product and of the Bessel series, and what the photodiode leaves of them."
    ),
    alt=(
        "Four panels. Left, a 7.15 gigahertz sine about one half with odd harmonics that fall "
        "steeply; right, a 14.32 gigahertz wave that rises from zero to no more than "
        f"{np.sin(eta) ** 2:.3f}, with even harmonics. Equation 19 as printed reaches half of it. "
        "Behind the photodiode both waves are weaker and later, the doubled one more so."
    ),
)
glue("response_single", response["single"], display=False)
glue("response_doubled", response["doubled"], display=False)
glue("taylor_single", 100 * taylor_error[0], display=False)
glue("taylor_doubled", 100 * taylor_error[1] / np.sin(eta) ** 2, display=False)

# %% [markdown]
# At this drive the weak-drive forms are good: at most {glue:text}`taylor_single:.1f` % of A² off
# in the single mode, and {glue:text}`taylor_doubled:.1f` % of the crest in the doubled one, once
# the factor of two is put right. The doubled amplitude is {glue:text}`ratio:.3f` of the single
# one. The photodiode passes {glue:text}`response_single:.2f` of the amplitude at 7.15 GHz and
# {glue:text}`response_doubled:.2f` at 14.32 GHz: what Fig. 8 shows at the doubled frequency is
# weaker than the light.
#
# ## What η buys
#
# For a ranging system two such modules are multiplied, so signal and contrast of the *correlation*
# count. With the coefficients $W$ of one module, its mean is $W_0^2$, the signal $2|W_m|^2$ and the
# contrast their ratio.

# %%
etas = np.linspace(1e-3, 2, points)
w1, w2 = single_mode_harmonics(etas, 2), doubled_mode_harmonics(etas, 2)
bright = 1 - w2[:, 0].real
mean = {"single": w1[:, 0].real, "doubled, dark": w2[:, 0].real, "doubled, bright": bright}
amplitude = {"single": abs(w1[:, 1]), "doubled, dark": abs(w2[:, 2])}
amplitude["doubled, bright"] = amplitude["doubled, dark"]  # the other port, the same swing
looks = {
    "single": {"color": blue},
    "doubled, dark": {"color": vermillion},
    "doubled, bright": {"color": plotting.PALETTE["purple"], "ls": "--"},
}

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 3, figsize=(10.2, 4.1))
for name, look in looks.items():
    axes[0].plot(etas, mean[name] ** 2, label=name, **look)
    axes[1].plot(etas, 2 * amplitude[name] ** 2 / mean[name] ** 2, **look)
for name in ("single", "doubled, dark"):
    axes[2].plot(etas, 2 * amplitude[name] ** 2, **looks[name])
legend_entries = axes[0].get_legend_handles_labels()
legend = figure.legend(*legend_entries, loc="outside lower center", ncols=3)
for ax, title in zip(axes, ("throughput, $W_0^2$", "contrast", "signal, $2|W_m|^2$"), strict=True):
    for place in (eta, np.pi / 4):
        ax.axvline(place, color="#8A97A3", lw=1, ls=":", zorder=0)
    ax.set(title=title, xlabel="drive amplitude η (rad)", xlim=(0, 2))
axes[2].text(eta + 0.03, 0.168, f"{eta:.2f}", va="top", color="#5A646D")
axes[2].text(np.pi / 4 - 0.03, 0.168, "π/4", ha="right", va="top", color="#5A646D")
for name in ("single", "doubled, dark"):
    best = etas[amplitude[name].argmax()]
    axes[2].plot(best, 2 * amplitude[name].max() ** 2, "o", color=looks[name]["color"], ms=7)

# %% tags=["hide-input"]
strong = replace(SINGLE, eta=np.pi / 4), replace(DOUBLED, eta=np.pi / 4)
contrast_single = correlation_contrast(single_w, single_w)
contrast_doubled = correlation_contrast(doubled_w[::2], doubled_w[::2])
signal_ratio = [
    abs(d.harmonics(2)[2] / s.harmonics(1)[1]) ** 2 for s, d in ((single, doubled), strong)
]
bright_contrast = replace(doubled, output="returned").contrast()
best_single = etas[amplitude["single"].argmax()]
best_doubled = etas[amplitude["doubled, dark"].argmax()]
plotting.label_panels(axes)
plotting.save(
    figure,
    "modulator_eta",
    numbers={
        "correlation_contrast_single": contrast_single,
        "correlation_contrast_doubled": contrast_doubled,
        "signal_ratio": signal_ratio,
        "bright_contrast": bright_contrast,
        "best_eta": [best_single, best_doubled],
    },
    caption=(
        "Two modules correlated, against the drive amplitude η (simulated): mean, contrast and "
        "signal of the correlation in the single mode and in the doubled mode with dark and with "
        "bright bias. Dark and bright bias share one signal. "
        f"Dotted: η = {eta:.2f} and π/4; dots: the largest signals."
    ),
    alt=(
        "Three panels against η from 0 to 2. The single mode's throughput is a constant quarter, "
        "the dark doubled mode's grows from zero, the bright one's falls from one. The doubled "
        "mode's contrast falls slowly from one half with dark bias and stays near zero with bright "
        f"bias until η is large. The single mode's signal peaks near {best_single:.2f}, the "
        f"doubled one's near {best_doubled:.2f}."
    ),
)

# %% tags=["hide-input"]
told = {
    "contrast_single": contrast_single,
    "contrast_doubled": contrast_doubled,
    "signal_weak": 100 * signal_ratio[0],
    "signal_strong": 100 * signal_ratio[1],
    "bright_contrast": 100 * bright_contrast,
    "best_single": best_single,
    "best_doubled": best_doubled,
}
for name, value in told.items():
    glue(name, float(value), display=False)

# %% [markdown]
# At η = 0.26 two single-mode modules correlate with a contrast of
# {glue:text}`contrast_single:.3f`, two doubled ones with {glue:text}`contrast_doubled:.2f`: the
# doubled mode has the better contrast, and yet only {glue:text}`signal_weak:.1f` % of the signal.
# At η = π/4 it is {glue:text}`signal_strong:.0f` %. With bright bias the same swing rides on
# nearly all of the light, at a peak-to-peak contrast of {glue:text}`bright_contrast:.1f` % for one
# module, and its shot noise buries it. The signals are largest at η = {glue:text}`best_single:.2f`
# and {glue:text}`best_doubled:.2f`. Whether 14.32 GHz can be seen at all is a question of
# radio-frequency power.
#
# ## Against the paper

# %%
strongest = 1 + int(np.abs(doubled_w[1:]).argmax())
reached = {
    "sec6.doubled_amplitude": ratio,
    "sec6.effective_wavelength": SPEED_OF_LIGHT / FREQUENCY_DOUBLED,
    "sec6.frequency_difference": FREQUENCY_DOUBLED - FREQUENCY_SINGLE,
    "fig8.frequency_single": single.frequency,
    "fig8.frequency_drive": doubled.frequency,
    "fig8.frequency_doubled": strongest * doubled.frequency,
    "sec1.minimum_frequency": strongest * doubled.frequency,
}
for key, value in reached.items():
    paper.check(key, value)
