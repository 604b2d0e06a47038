# %% [markdown]
# # Correlation
#
# How does a camera that sees nothing faster than a kilohertz measure the delay of light that is
# modulated at 7 GHz (Paper Fig. 2, simulated; Eqs. 1–4 and 20)?
#
# The camera sees only the average of light times reference. Against the reference phase this
# average is a cosine. Everything in this book rests on it: its phase is the distance within one
# period, and its contrast sets the noise.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # nothing here is random
frequency: float = 7.15e9  # modulation frequency, Hz
depth: float = 0.6  # range of the target along the ray, m
eta_weak: float = 0.26  # drive amplitude at 50 % modulator contrast, rad
eta_strong: float = 0.7853982  # drive amplitude at full modulator contrast, π/4, rad
phases: int = 720  # phases at which the cyclic error is evaluated
drives: int = 120  # drive amplitudes on the axis of the last figure

# %% tags=["hide-input"]
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from cmtof import bounds
from cmtof.constants import ADC_BITS, GAIN, INTEGRATION_TIME, NOISE_SIGMA
from cmtof.correlation import (
    TAU,
    centred,
    correlation_contrast,
    correlation_from_harmonics,
    depth_from_phase,
    phase_from_correlation,
    phase_from_depth,
    wrap_length,
    wrapped,
)
from cmtof.detector import quantise
from cmtof.modulator import DOUBLED, SINGLE, single_mode_harmonics
from cmtof.waveform import gate, sinusoid, waveform_from_harmonics
from cmtof_book import notes, paper, plotting
from cmtof_book.compared import closed_form

plotting.begin(profile=profile, seed=seed)
quarters = np.arange(4) * np.pi / 2
quarter_ticks = (np.arange(5) * np.pi / 2, ["0", "π/2", "π", "3π/2", "2π"])

# %% tags=["hide-input"]
phi = float(wrapped(phase_from_depth(depth, frequency)))
raised = sinusoid(0.5, 0.5)  # half plus half a cosine
returned = 0.6 * raised  # the target keeps some of the light
period = 1e12 / frequency
turns = np.linspace(0, 2, 401)
received = waveform_from_harmonics(returned, TAU * turns - phi)

figure, axes = plt.subplots(2, 2, figsize=(8.4, 6.6))
ax = axes[0, 0]
ax.plot(
    period * turns, waveform_from_harmonics(raised, TAU * turns), label="emitted $p$"
)
ax.plot(period * turns, received, color="C4", label=r"received $\tilde p$")
gated = waveform_from_harmonics(raised, TAU * turns + np.pi / 2)
ax.plot(
    period * turns, gated, color=plotting.GREY, ls="--", label="reference $r$, ψ = π/2"
)
ax.set(
    title="light and reference",
    xlabel="time (ps)",
    ylabel="power, transmission",
    ylim=(0, 1.7),
)
ax.legend(loc="upper right", fontsize="small")

ax = axes[0, 1]
for psi, colour, name in ((-phi, "C1", "ψ = −φ"), (np.pi - phi, "C3", "ψ = π − φ")):
    product = received * waveform_from_harmonics(raised, TAU * turns + psi)
    ax.plot(period * turns, product, color=colour, label=f"product, {name}")
    ax.axhline(product[:-1].mean(), color=colour, ls="--")
ax.legend(loc="upper right", fontsize="small")
ax.set(
    title="their product and its average", xlabel="time (ps)", ylabel=r"$\tilde p\,r$"
)
_ = ax.set_ylim(0, 0.9)

# %% tags=["hide-input"]
ax = axes[1, 0]
sweep = np.linspace(0, TAU, 361)
for further in (0.0, 0.003, 0.006):
    angle = float(wrapped(phase_from_depth(depth + further, frequency)))
    curve = correlation_from_harmonics(returned, raised, phase=angle, psi=sweep)
    (line,) = ax.plot(sweep, curve, label=f"{1e3 * (depth + further):.0f} mm")
    four = correlation_from_harmonics(returned, raised, phase=angle, psi=quarters)
    ax.plot(quarters, four, "o", color=line.get_color(), ms=5)
    ax.plot(
        wrapped(-angle), curve.max(), "v", color=line.get_color(), ms=9, clip_on=False
    )
ax.set(
    title="the detector's reading",
    xlabel="reference phase ψ",
    ylabel="$C_ψ$",
    ylim=(0.06, 0.3),
)
ax.legend(
    ncols=3, loc="upper center", fontsize="small", handlelength=1, columnspacing=1
)
ax = axes[1, 1]
table = correlation_from_harmonics(returned, raised, phase=sweep[:, None], psi=sweep)
drawn = ax.imshow(table, origin="lower", extent=(0, TAU, 0, TAU), aspect="auto")
figure.colorbar(drawn, ax=ax, label="$C_ψ$")
ax.plot(sweep, TAU - sweep, color="white", ls="--")
ax.axhline(phi, color="C5")
ax.set(title="all phases and references", xlabel="reference phase ψ", ylabel="phase φ")
ax.set_yticks(*quarter_ticks)
ax.text(3.4, 5.6, "ψ = −φ", color="white")
for ax in axes[1]:
    ax.set_xticks(*quarter_ticks)
plotting.label_panels(axes.flat)

# %% tags=["hide-input"]
plotting.save(
    figure,
    "fig02_principle",
    numbers={
        "phase": closed_form(phi),
        "contrast": closed_form(correlation_contrast(returned, raised)),
    },
    caption=(
        f"Correlation time of flight at {frequency / 1e9:.2f} GHz, simulated. (a) Emitted and "
        f"received light of a target at {depth:.1f} m and the reference; whole periods of delay "
        "are left out. (b) Product of light and reference at the best and the worst ψ, with its "
        "averages (dashed). (c) The average against ψ for three depths: four samples (dots) "
        "determine the phase; triangles mark the maximum at ψ = −φ. (d) The same for every φ; the "
        "light blue line is the first curve of (c)."
    ),
    alt=(
        "Four panels. Two raised cosines of power, the received one weaker and later, and a dashed "
        "reference. Their product, high when in step and low when opposed, with dashed averages. "
        "Three cosines over the reference phase, shifted by three millimetres of depth each, with "
        "four dots and a triangle at the maximum. A map over both phases whose bright ridge falls "
        "along the dashed line psi equals minus phi."
    ),
)

# %% [markdown]
# ## The equations
#
# The laser is modulated ([Baek et al. 2023](../book/references.bib#baek2023),
# [Lange 2000](../book/references.bib#lange2000)), travels to the target and back, weaker and later
# by $\tau = 2z/c$, and meets a reference of phase ψ. The product is summed over an exposure of many
# periods:
#
# $$
# p(t) = \alpha\cos(\omega_p t) + \beta,
# \tag{1}$$
#
# $$
# \tilde p(t-\tau) = \tilde\alpha\cos(\omega_p t-\phi) + \tilde\beta,
# \qquad \phi = 2\pi\omega_p\tau ,
# \tag{2}$$
#
# $$
# r(t) = \cos(\omega_r t+\psi) + \tfrac12 ,
# \tag{3}$$
#
# $$
# C_\psi = \int_0^T \tilde p(t-\tau)\,r(t)\,dt = \frac{\tilde\alpha}{2}\cos(\psi-\phi) + TK .
# \tag{4}$$
#
# These are the printed equations. This book corrects three points: $\omega = 2\pi f$ is angular and
# $\varphi = \omega\tau = 4\pi fz/c$ ([erratum 3](22_errata.ipynb#erratum-3)); the product of
# [Eq. 2](#eq-2) and [Eq. 3](#eq-3) has **cos(φ + ψ)**, so the correlation is greatest at ψ = −φ
# ([erratum 2](22_errata.ipynb#erratum-2)); and the reference drawn above is a raised cosine: no
# transmission is negative.
#
# The waveforms need not be cosines. With the Fourier coefficients of each waveform, $p = P_0 +
# 2\,\mathrm{Re}\sum_k P_k e^{ik\omega t}$, only equal harmonics remain in the average:
#
# $$
# \frac{C_\psi}{T} = P_0R_0 + 2\,\mathrm{Re}\sum_{k\ge1}
#   P_kR_k^*\,e^{-ik(\varphi+\psi+2\pi\delta t)}\,\mathrm{sinc}(k\,\delta T).
# \tag{1.1}$$
#
# with $R_k$ those of the reference and sinc $x = \sin(\pi x)/\pi x$. In the **homodyne** case δ = 0
# and the correlation is constant. In the **heterodyne** case the reference frequency is higher by
# δ: the correlation oscillates at δ, and an exposure that is not short against 1/δ reduces its
# contrast.
#
# ## The gate of Eq. 8
#
# The paper simulates $\tfrac12+\tfrac1\pi\cos(\varphi+\psi)$, [Eq. 8](05_simulation.ipynb#eq-8). By
# [Eq. 1.1](#eq-1.1) that is a raised cosine (½, ¼) times a square gate open for half of every
# period (½, 1/π), as in an electronic *pixel*. The prototype multiplies **two optical modulators**:
# two perfect raised cosines give a contrast of ½, two [two-pass modulators](04_modulator.ipynb)
# $2J_1^2(2\eta)$ at a drive amplitude η. The chapters on light use η = 0.26, the lower end of the
# modulator contrast «> 50 %» that the paper states; those on the instrument assume π/4, since at
# 0.26 the doubled mode's signal is too weak for a scan ([chapter 13](13_instrument.ipynb)).

# %%
weak, strong = (
    replace(SINGLE, eta=eta).harmonics(24) for eta in (eta_weak, eta_strong)
)
# harmonics of twice the drive
doubled = replace(DOUBLED, eta=eta_strong).harmonics(24)[::2]
pairs = {
    "Eq. 8: raised cosine × gate": (raised, gate(24)),
    "two raised cosines": (raised, raised),
    f"two modulators, η = {eta_strong:.2f}": (strong, strong),
    f"two modulators, η = {eta_weak:.2f}": (weak, weak),
    f"two doubled, η = {eta_strong:.2f}": (doubled, doubled),
}
contrasts = {name: correlation_contrast(*pair) for name, pair in pairs.items()}
means = {name: (a[0] * b[0]).real for name, (a, b) in pairs.items()}

# %% [markdown]
# In the table every instrument collects the mean count of Eq. 8 at full brightness, with the
# paper's σ = 1200. The phase noise (its Cramér–Rao bound) is then inversely proportional to the
# contrast, and the pixels needed for one right wrap ([chapter 3](03_wraps.ipynb)) to its square.

# %% tags=["hide-input"]
mean_count = GAIN * INTEGRATION_TIME / 2
noise = {
    name: bounds.phase_bound(c * mean_count, mean_count, quarters, sigma=NOISE_SIGMA)
    for name, c in contrasts.items()
}
eq8, _, strong_name, weak_name, _ = pairs
rows = []
for name, value in noise.items():
    depth_noise = 1e3 * depth_from_phase(
        value, frequency * (2 if "doubled" in name else 1)
    )
    pixels = (value / noise[eq8]) ** 2
    light = (f"{contrasts[name]:.3f}", f"{means[name]:.3f}")
    rows.append((name, *light, f"{value:.3f}", f"{depth_noise:.2f}", f"{pixels:.1f}"))
notes.table(
    [
        "instrument",
        "contrast",
        "mean of $p\\,r$",
        "$\\sigma_\\varphi$ (rad)",
        "$\\sigma_z$ (mm)",
        "pixels over Eq. 8",
    ],
    rows,
)

# %% tags=["hide-input"]
notes.say(
    """
    Two modulators of 50 % contrast, above which the paper states its own, give a correlation
    contrast of {contrast_weak:.3f}, {contrast_fifth:.1f} times less than Eq. 8 assumes. At η = π/4
    it is {contrast_strong:.3f}, slightly more than in Eq. 8. The noise of the paper's simulation,
    which this book adopts, is therefore that of an instrument with a *strong* drive ([erratum
    6](22_errata.ipynb#erratum-6)).
    """,
    contrast_weak=contrasts[weak_name],
    contrast_fifth=contrasts[eq8] / contrasts[weak_name],
    contrast_strong=contrasts[strong_name],
)

# %% [markdown]
# ## Cyclic error of a strong drive
#
# A strong drive distorts the sinusoid: the third harmonic of the light is $J_3/J_1$ of the first,
# that of the correlation $(J_3/J_1)^2$. With K equal steps of ψ the harmonics $mK\pm1$ alias onto
# the fundamental. The resulting error is periodic in the phase: the cyclic error, which averaging
# does not remove.


# %% tags=["hide-input"]
def cyclic_error(wave, phase, samples):
    """Phase error of the harmonics with so many uniform steps, rad; harmonics k = m K ± 1 alias."""
    psi = TAU * np.arange(samples) / samples
    stack = correlation_from_harmonics(wave, wave, phase=phase, psi=psi[:, None])
    return centred(phase_from_correlation(stack, psi) - phase)


angle = TAU * np.arange(phases) / phases
waves = {eta: single_mode_harmonics(eta, 24) for eta in (eta_weak, eta_strong)}
error = {
    (eta, steps): 1e3 * cyclic_error(wave, angle, steps)  # mrad
    for eta, wave in waves.items()
    for steps in (4, 16)
}
largest = {key: float(np.abs(value).max()) for key, value in error.items()}
etas = np.linspace(0.02, 0.95, drives)
coarse = angle[:: max(1, phases // 90)]
many = single_mode_harmonics(etas, 24)
against_drive = {
    steps: [1e3 * np.abs(cyclic_error(w, coarse, steps)).max() for w in many]
    for steps in (3, 4, 8)
}

# %% tags=["hide-input"]
micron_per_mrad = 1e6 * float(depth_from_phase(1e-3, frequency))
table4 = 1e6 * paper.published_number("table4.proposed.rmse_mirror").value
figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.9))
for eta in waves:
    axes[0].plot(angle, error[eta, 4], label=f"η = {eta:.2f}, K = 4")
axes[0].set(xlabel="true phase φ", ylabel="cyclic error (mrad)", ylim=(-18, 26))
axes[0].set_title("over the phase")
axes[0].set_xticks(*quarter_ticks)
for steps, values in against_drive.items():
    axes[1].plot(etas, np.maximum(values, 1e-9), label=f"K = {steps}")
axes[1].set(yscale="log", ylim=(1e-7, 2e5), xlabel="drive amplitude η (rad)")
axes[1].set(ylabel="largest error (mrad)", title="over the drive")
plotting.mark(axes[1], y=table4 / micron_per_mrad, text="paper's RMSE, Table 4")
scales = (lambda y: y * micron_per_mrad, lambda y: y / micron_per_mrad)
axes[1].secondary_yaxis("right", functions=scales).set_ylabel("depth (µm)")
for ax in axes:
    ax.legend(loc="upper center", ncols=2, fontsize="small")
plotting.label_panels(axes)
plotting.save(
    figure,
    "correlation_cyclic_error",
    numbers={
        "mrad_4_steps": closed_form([largest[e, 4] for e in waves]),
    },
    caption="Cyclic error of the waveforms' harmonics with K steps of ψ, two single-mode "
    "modulators, simulated without noise. (a) Four steps alias the third harmonic of a strong "
    "drive into the phase. (b) The largest error against the drive, beside the RMSE that the paper "
    f"measured. Sixteen steps leave about $10^{{{np.log10(largest[eta_strong, 16]):.0f}}}$ mrad, "
    "below the axis. "
    "Right scale: depth at 7.15 GHz.",
    alt="Left, the phase error over the phase: with four steps and a strong drive a wave of four "
    "periods, with a weak drive next to nothing. Right, errors that rise "
    "steeply with the drive: four steps most, three a thousand times less, eight less still.",
)

# %% tags=["hide-input"]
notes.say(
    """
    With four steps the error is {cyclic_weak:.2f} mrad at η = 0.26 and {cyclic_strong:.0f} mrad at
    π/4, or {cyclic_strong_um:.0f} µm of depth, more than the {table4:.1f} µm that the paper reports
    for the whole instrument. The prototype's sixteen steps remove it. (Three steps are better than
    four only in an ideal single mode, which has odd harmonics alone.)
    """,
    cyclic_weak=largest[eta_weak, 4],
    cyclic_strong=largest[eta_strong, 4],
    cyclic_strong_um=largest[eta_strong, 4] * micron_per_mrad,
    table4=table4,
)

# %% [markdown]
# ## Detector and converter
#
# A detector of gain G and a converter Q complete the chain:
#
# $$
# C_\psi = Q\!\left(G\int_0^T\tilde p(t-\tau)\,r(t)\,dt\right)
#        = Q\!\left(\frac{\tilde\alpha}{2}\cos(\psi-\phi)+TK\right)
# \tag{20}$$
#
# (as printed; the right-hand side lacks the sign of φ and the factors G and T). When the signal
# fills the converter and nothing else is noisy, rounding to 14 bits costs this much phase:

# %%
levels = correlation_from_harmonics(raised, gate(1), phase=angle, psi=quarters[:, None])
counts = GAIN * INTEGRATION_TIME * 2 * levels  # G T (1/2 + cos/π), Eq. 8
digital = quantise(counts, bits=ADC_BITS, full_scale=2.0**ADC_BITS - 1)
rounding = (
    1e3 * np.abs(centred(phase_from_correlation(digital, quarters) - angle)).max()
)
print(f"largest error: {rounding:.3f} mrad, {rounding * micron_per_mrad:.2f} µm")

# %% [markdown]
# Rounding is negligible beside [noise](02_precision.ipynb).

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** It multiplies the returned light by a copy of the modulation and averages. The
    average is a cosine of the delay, and {steps} averages at different reference phases give its
    phase. Two modulators of 50 % contrast leave {fifth:.1f} times less contrast than Eq. 8 of the
    paper assumes, and with a strong drive four steps err by {error:.0f} µm of depth.
    """,
    steps=quarters.size,
    fifth=contrasts[eq8] / contrasts[weak_name],
    error=largest[eta_strong, 4] * micron_per_mrad,
)

# %% [markdown]
# ## Against the paper

# %% tags=["hide-input"]
paper.check("sec3.phase_steps", quarters.size)
paper.check("sec1.wrap_depth_7ghz", closed_form(wrap_length(frequency)))
paper.table()

# %% [markdown]
# ## Exercises
#
# **1.** Three readings at ψ = 0, 2π/3 and 4π/3 are 0.62, 0.29 and 0.59. What is their phase, and
# which ranges below 50 mm are possible at 7.15 GHz?

# %% tags=["hide-cell"]
# The phase is that of the first harmonic, fitted by least squares; further wraps add c/2f each.
thirds = TAU * np.arange(3) / 3
read = phase_from_correlation(np.array([0.62, 0.29, 0.59]), thirds)
ranges = depth_from_phase(read, frequency) + np.arange(3) * wrap_length(frequency)
print(f"{read:.2f} rad:", *(f"{1e3 * z:.1f} mm" for z in ranges))

# %% [markdown]
# **2.** What is the contrast of the correlation of a raised cosine with a gate that is open for a
# quarter of the period?

# %% tags=["hide-cell"]
# A gate open for the share d has R_k = sin(πkd)/(πk) and R_0 = d. The shorter gate has a higher
# contrast than one of half the period, but passes half as much light.
quarter = np.array([0.25, np.sin(np.pi / 4) / np.pi], complex)
half = np.array([0.5, 1 / np.pi], complex)
[round(float(correlation_contrast(raised, one)), 3) for one in (half, quarter)]
