# %% [markdown]
# # Correlation
#
# How a distance becomes a brightness. A correlation camera never sees its light flicker at 7 GHz:
# it multiplies what comes back with a copy of what went out, and only the *average* of the product
# reaches a slow detector. This page regenerates Fig. 2 (simulated), Eqs. 1–4 and 20, lets any
# periodic waveforms take the place of cosines, and asks what Eq. 8 quietly assumes about the gate.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of the random waveforms that check the formula
frequency: float = 7.15e9  # modulation frequency, Hz
depth: float = 0.6  # range of the target along the ray, m
eta_weak: float = 0.26  # drive amplitude at 50 % modulator contrast, rad
eta_strong: float = 0.7853981633974483  # drive amplitude at full modulator contrast, π/4, rad
periods: int = 4000  # periods of light in one exposure of the heterodyne check
phases: int = 720  # phases at which the cyclic error is evaluated
drives: int = 120  # drive amplitudes on the axis of the last figure

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from matplotlib.patches import FancyArrowPatch
from myst_nb import glue

from cmtof import bounds
from cmtof.book import paper, plotting
from cmtof.constants import ADC_BITS, GAIN, INTEGRATION_TIME, NOISE_SIGMA
from cmtof.correlation import (
    TAU,
    correlation_contrast,
    correlation_from_harmonics,
    cyclic_error,
    depth_from_phase,
    phase_from_correlation,
    phase_from_depth,
    wrap_length,
    wrapped,
)
from cmtof.detector import quantise
from cmtof.modulator import DOUBLED, SINGLE, single_mode_harmonics
from cmtof.waveform import gate, sinusoid, waveform_from_harmonics

paper_run = plotting.begin(profile=profile, seed=seed)
blue, vermillion, green, purple, orange, sky, black = (
    plotting.PALETTE[c] for c in ["blue", "vermillion", "green", "purple", "orange", "sky", "black"]
)
quarters = np.arange(4) * np.pi / 2
turn_ticks = (np.arange(5) * np.pi / 2, ["0", "π/2", "π", "3π/2", "2π"])

# %% [markdown]
# ## Light out, light back, light multiplied
#
# The laser is modulated {cite}`baek2023,lange2000`,
#
# ```{math}
# :label: eq-1
# p(t) = \alpha\cos(\omega_p t) + \beta,
# ```
#
# travels to the target and back, weaker and later by $\tau = 2z/c$,
#
# ```{math}
# :label: eq-2
# \tilde p(t-\tau) = \tilde\alpha\cos(\omega_p t-\phi) + \tilde\beta,
# \qquad \phi = 2\pi\omega_p\tau ,
# ```
#
# meets a reference of phase ψ,
#
# ```{math}
# :label: eq-3
# r(t) = \cos(\omega_r t+\psi) + \tfrac12 ,
# ```
#
# and the product is summed over an exposure of very many periods:
#
# ```{math}
# :label: eq-4
# C_\psi = \int_0^T \tilde p(t-\tau)\,r(t)\,dt = \frac{\tilde\alpha}{2}\cos(\psi-\phi) + TK .
# ```
#
# So the paper prints them. Three things are put right here and kept right in the whole book:
# $\omega = 2\pi f$ is angular and $\varphi = \omega\tau = 4\pi fz/c$
# ({ref}`erratum 3 <erratum-3>`); the product of {eq}`eq-2` and {eq}`eq-3` has **cos(φ + ψ)**, so
# the correlation is brightest at ψ = −φ ({ref}`erratum 2 <erratum-2>`); and a passive modulator
# cannot transmit less than nothing, as {eq}`eq-3` would, so the reference drawn below is a raised
# cosine, $\tfrac12(1+\cos)$.

# %%
phi = float(wrapped(phase_from_depth(depth, frequency)))
whole_periods = float(phase_from_depth(depth, frequency) // TAU)
raised = sinusoid(0.5, 0.5)
returned = 0.6 * raised  # the target keeps some of the light
period = 1e12 / frequency  # ps
turns = np.linspace(0, 2, 401)
emitted = waveform_from_harmonics(raised, TAU * turns)
for name, value in {
    "depth": depth,
    "phi": phi,
    "whole_periods": whole_periods,
    "period": period,
    "delay": period * phi / TAU,
}.items():
    glue(name, float(value), display=False)


def received(turn):
    return waveform_from_harmonics(returned, TAU * turn - phi)


def reference(turn, psi):
    return waveform_from_harmonics(raised, TAU * turn + psi)


# %% [markdown]
# A target at {glue:text}`depth:.1f` m delays the light by {glue:text}`whole_periods:.0f` whole
# periods of {glue:text}`period:.0f` ps, which leave no trace, and by {glue:text}`delay:.0f` ps
# more, which do: φ = {glue:text}`phi:.2f` rad. Where the reference swings with the returning
# light, bright meets open and the average is high; where it swings against it, it is low. Sweep ψ
# and the average draws a cosine whose crest lies at −φ. That is all the slow detector has to see.

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 2, figsize=(9.6, 6.9))
ax = axes[0, 0]
ax.plot(period * turns, emitted, color=blue, label="emitted $p$")
ax.plot(period * turns, received(turns), color=orange, lw=2.4, label=r"received $\tilde p$")
ax.plot(
    period * turns,
    reference(turns, np.pi / 2),
    color="#8A97A3",
    ls="--",
    label="reference $r$, ψ = π/2",
)
delay = period * phi / TAU
ax.add_patch(FancyArrowPatch((0, 1.07), (delay, 1.07), arrowstyle="<->", mutation_scale=11))
ax.vlines([0, delay], [1, 0.6], 1.13, color=black, lw=0.8)
ax.text(delay / 2, 1.1, "φ/ω", ha="center", va="bottom")
ax.set(title="light, and the gate it will meet", xlabel="time (ps)", ylabel="power, transmission")
ax.set(ylim=(-0.03, 1.55), xlim=(0, 2 * period), yticks=(0, 0.5, 1))
ax.legend(ncols=2, loc="upper right", fontsize="small")

ax = axes[0, 1]
for psi_shown, colour, name in ((-phi, vermillion, "ψ = −φ"), (np.pi - phi, purple, "ψ = π − φ")):
    product = received(turns) * reference(turns, psi_shown)
    ax.fill_between(period * turns, product, color=colour, alpha=0.22, lw=0)
    ax.plot(period * turns, product, color=colour, lw=1.4, label=f"product, {name}")
    ax.axhline(product[:-1].mean(), color=colour, ls="--")
ax.text(1.12 * period, 0.235, "average", color=vermillion, ha="center", va="bottom")
ax.set(title="the product and its average", xlabel="time (ps)", xlim=(0, 2 * period))
ax.set(ylim=(0, 0.85), ylabel=r"$\tilde p\,r$")
ax.legend(ncols=2, loc="upper right", fontsize="small")

ax, sweep = axes[1, 0], np.linspace(0, TAU, 361)
for extra, colour in ((0.0, blue), (0.003, sky), (0.006, green)):
    angle = float(wrapped(phase_from_depth(depth + extra, frequency)))
    curve = correlation_from_harmonics(returned, raised, phase=angle, psi=sweep)
    four = correlation_from_harmonics(returned, raised, phase=angle, psi=quarters)
    ax.plot(sweep, curve, color=colour, label=f"{1e3 * (depth + extra):.0f} mm")
    ax.plot(quarters, four, "o", color=colour, ms=5)
    ax.plot(wrapped(-angle), curve.max(), "v", color=colour, ms=9, clip_on=False)
ax.set(title="what the detector reads", xlabel="reference phase ψ", ylabel="$C_ψ$")
ax.set(xlim=(0, TAU), ylim=(0.06, 0.29))
ax.set_xticks(*turn_ticks)
ax.legend(ncols=3, loc="upper center", fontsize="small")

ax, grid = axes[1, 1], np.linspace(0, TAU, 181)
table = correlation_from_harmonics(returned, raised, phase=grid[:, None], psi=grid)
drawn = ax.imshow(table, origin="lower", extent=(0, TAU, 0, TAU), aspect="auto")
figure.colorbar(drawn, ax=ax, label="$C_ψ$")
ax.plot(grid, TAU - grid, color="white", ls="--", lw=1.6)
ax.annotate(
    "ψ = −φ", (1.45, TAU - 1.45), (-3, -3), textcoords="offset points", color="black",
    rotation=-45, transform_rotates_text=True, rotation_mode="anchor", ha="center", va="top",
)  # fmt: skip
ax.axhline(phi, color=blue, lw=1.6)
ax.set(title="every phase, every reference", xlabel="reference phase ψ", ylabel="phase φ")
ax.set_xticks(*turn_ticks)
ax.set_yticks(*turn_ticks)
ax.grid(visible=False)
plotting.label_panels(axes.flat)
crest = float(sweep[correlation_from_harmonics(returned, raised, phase=phi, psi=sweep).argmax()])
contrast_raised = correlation_contrast(returned, raised)

plotting.save(
    figure,
    "fig02_principle",
    numbers={"phase": phi, "crest_psi": crest, "contrast": contrast_raised},
    caption=(
        f"Correlation time of flight at {frequency / 1e9:.2f} GHz, simulated (the paper's Fig. 2). "
        f"(a) Emitted and received light of a target at {depth:.1f} m, and the reference; the "
        f"{whole_periods:.0f} whole periods of delay are left out. (b) Product of light and "
        "reference at the best and at the worst ψ, with its averages (dashed). (c) The average "
        "against ψ for three depths: four samples (dots) tell the phase; triangles mark the crest "
        "at −φ. (d) The same for every φ; the blue line is the blue curve of (c)."
    ),
    alt=(
        "Four panels. Two raised cosines of power, the received one weaker and later by phi over "
        "omega, and a dashed reference. Their product, high when in step and low when opposed, "
        "with dashed averages. Three cosines over the reference phase, each shifted by three "
        "millimetres of depth, with four dots and a triangle at the crest. A map over both phases "
        "whose bright ridge falls along the dashed line psi equals minus phi."
    ),
)

# %% [markdown]
# ## Any two periodic waveforms
#
# Nothing needs cosines. Write each waveform by its Fourier coefficients,
# $p = P_0 + 2\,\mathrm{Re}\sum_k P_k e^{ik\omega t}$; in the average only equal harmonics meet:
#
# ```{math}
# :label: correlation-harmonics
# \frac{C_\psi}{T} = P_0R_0 + 2\,\mathrm{Re}\sum_{k\ge1}
#   P_kR_k^*\,e^{-ik(\varphi+\psi+2\pi\delta t)}\,\mathrm{sinc}(k\,\delta T).
# ```
#
# In the **homodyne** case the reference has the frequency of the light, δ = 0, and the correlation
# stands still. In the **heterodyne** case it runs δ faster: the crest walks through ψ by itself,
# and an exposure that is not short against 1/δ blurs it. Below, the formula
# (`correlation_from_harmonics`) against a brute-force sum over time, with waveforms drawn at
# random.

# %%
rng = np.random.default_rng(seed)
scale = 0.5 / np.arange(1, 9) ** 1.5  # eight harmonics
p, r = (
    np.r_[1.0, scale * (rng.normal(size=8) + 1j * rng.normal(size=8))].astype(complex)
    for _ in range(2)
)
theta = TAU * np.arange(64) / 64
trial_phase, trial_psi = rng.uniform(0, TAU, (2, 50))


def time_average(phase, psi):
    product = waveform_from_harmonics(p, theta - phase) * waveform_from_harmonics(r, theta + psi)
    return product.mean()


brute = [time_average(a, b) for a, b in zip(trial_phase, trial_psi, strict=True)]
formula = correlation_from_harmonics(p, r, phase=trial_phase, psi=trial_psi)
homodyne_error = float(np.abs(formula - brute).max())
print(f"homodyne, 50 pairs of phases: largest difference {homodyne_error:.0e}")

# %% [markdown]
# The heterodyne sum runs over a whole exposure, in which the reference gains a third of a period.
# It also holds what the formula leaves out, the terms that swing with the light itself. They
# shrink as one over the number of periods. The prototype's 13 ms hold almost a hundred million
# periods.

# %%
gained = 1 / 3  # periods that the reference gains in one exposure, δT
light = TAU * np.arange(32 * periods) / 32
slow = 1 + gained / periods
middle = TAU * gained / 2  # the formula takes the beat phase in the middle of the exposure
brute = np.mean(
    waveform_from_harmonics(p, light - 0.7) * waveform_from_harmonics(r, slow * light + 1.9)
)
formula = correlation_from_harmonics(
    p, r, phase=0.7, psi=1.9, beat_phase=middle, beat_cycles=gained
)
heterodyne_error = float(abs(formula - brute))
print(f"heterodyne, {periods} periods: difference {heterodyne_error:.0e}")
blur = np.sinc(gained)
print(f"an exposure of a third of a beat keeps {100 * blur:.0f} % of the fundamental")
glue("blur", 100 * float(blur), display=False)

# %% [markdown]
# ## What Eq. 8's gate means
#
# The paper simulates its measurements with $\tfrac12+\tfrac1\pi\cos(\varphi+\psi)$, {eq}`eq-8`.
# Which instrument is that? By {eq}`correlation-harmonics`, a raised cosine (coefficients ½, ¼)
# against a square gate that is open for half of every period (½, 1/π). Such a gate is a bucket of
# a multi-bucket *pixel*, switched in silicon. The prototype multiplies **two optical modulators**,
# and their product is what it is: two perfect raised cosines give a contrast of ½, two of the
# {doc}`two-pass modulators <04_modulator>` $2J_1^2(2\eta)$, by the amplitude η of their
# drive.

# %%
weak, strong = replace(SINGLE, eta=eta_weak), replace(SINGLE, eta=eta_strong)
doubled = replace(DOUBLED, eta=eta_strong).harmonics(24)[::2]  # by harmonic of twice the drive
pairs = {
    "Eq. 8: raised cosine × gate": (raised, gate(24), vermillion),
    "two raised cosines": (raised, raised, black),
    f"two modulators, η = {eta_strong:.2f}": (strong.harmonics(24), strong.harmonics(24), green),
    f"two modulators, η = {eta_weak:.2f}": (weak.harmonics(24), weak.harmonics(24), blue),
    f"two doubled, η = {eta_strong:.2f}": (doubled, doubled, purple),
}
contrasts = {name: correlation_contrast(a, b) for name, (a, b, _) in pairs.items()}
means = {name: float((a[0] * b[0]).real) for name, (a, b, _) in pairs.items()}

# %% tags=["hide-input"]
figure = plt.figure(figsize=(9.8, 6.6))
panels = figure.subplot_mosaic([[*"abcde"], ["C"] * 5], height_ratios=[1, 1.9])
cycles, sweep = np.linspace(0, 2, 801), np.linspace(-np.pi, np.pi, 361)
for ax, (name, (emitted, reference_h, colour)) in zip(
    [panels[k] for k in "abcde"], pairs.items(), strict=True
):
    # each pair is drawn with its light at a crest at time zero
    shift = -np.angle(emitted[1])
    ax.plot(cycles, waveform_from_harmonics(emitted, TAU * cycles + shift), color=colour, lw=2)
    shown = (np.cos(TAU * cycles) > 0) if name.startswith("Eq. 8") else None
    other = waveform_from_harmonics(reference_h, TAU * cycles + shift) if shown is None else shown
    ax.plot(cycles, other, color="#8A97A3", ls="--", lw=1.5)
    ax.set(title=name.replace(", ", ",\n").replace(": ", ":\n"), ylim=(-0.06, 1.06))
    ax.set(xlabel="periods", xticks=(0, 1, 2), yticks=(0, 0.5, 1))

ax = panels["C"]
for name, (emitted, reference_h, colour) in pairs.items():
    lag = np.angle(emitted[1] * np.conj(reference_h[1]))
    relative = correlation_from_harmonics(emitted, reference_h, phase=lag, psi=sweep) / means[name]
    label = f"{name}: {contrasts[name]:.3f}"
    ax.plot(
        sweep, relative, color=colour, lw=2.2, ls="--" if "doubled" in name else "-", label=label
    )
ax.set(xlabel="φ + ψ", ylabel="correlation over its mean", xlim=(-np.pi, np.pi), ylim=(0.3, 1.75))
ax.set_xticks(np.arange(-2, 3) * np.pi / 2, ["−π", "−π/2", "0", "π/2", "π"])
ax.legend(loc="upper left", fontsize="small", title="contrast", alignment="left")
panels["a"].set_ylabel("transmission")
titles = [panels[k].get_title() for k in "abcde"]
for letter, title in zip("abcde", titles, strict=True):
    panels[letter].set_title(f"({letter}) {title}", fontsize="small", loc="left")
    panels[letter].set_title("")
ax.set_title("(f) their correlations", loc="left")
plotting.save(
    figure,
    "correlation_gates",
    numbers={"contrasts": list(contrasts.values()), "means": list(means.values())},
    caption=(
        "Light (solid) and reference (dashed) of five instruments, simulated, and their "
        "correlations over their means. (a) The pixel that Eq. 8 describes. (b) Two perfect raised "
        "cosines. (c, d) Two two-pass modulators, driven to full and to 50 % modulator contrast. "
        "(e) Two in the doubled mode with dark bias. (f) Contrast is the amplitude of the "
        "fundamental over the mean."
    ),
    alt=(
        "Five small panels of waveforms over two periods: a raised cosine with a square gate, two "
        "identical raised cosines, two flattened full-swing waves, two waves that swing by a "
        "quarter about one half, two that rise from zero to one half. Below, five cosine-like "
        f"correlations: the gate's and the strongly driven modulators' swing by "
        f"{100 * contrasts['Eq. 8: raised cosine × gate']:.0f} percent, raised cosines by "
        f"{100 * contrasts['two raised cosines']:.0f}, the weakly driven modulators' by "
        f"{100 * contrasts[f'two modulators, η = {eta_weak:.2f}']:.0f}."
    ),
)

# %% [markdown]
# What is the difference worth? Let every instrument collect the same mean count, that of Eq. 8 at
# full brightness with the paper's σ = 1200, and take the Cramér–Rao bound on the phase, and what
# it is as depth at 7.15 GHz (twice that for the doubled mode). Noise of the phase goes as one over
# the contrast, the pixels to be pooled for one right wrap
# ({doc}`later <03_wraps>`) as its square.

# %%
mean_count = GAIN * INTEGRATION_TIME / 2
noise = {
    name: float(bounds.phase_bound(k * mean_count, mean_count, quarters, sigma=NOISE_SIGMA))
    for name, k in contrasts.items()
}
eq8 = next(iter(pairs))
tone = {name: frequency * (2 if "doubled" in name else 1) for name in pairs}
rows = [
    f"| {name} | {contrasts[name]:.3f} | {means[name]:.3f} | {noise[name]:.3f} | "
    f"{1e3 * float(depth_from_phase(noise[name], tone[name])):.2f} | "
    f"{(noise[name] / noise[eq8]) ** 2:.1f} |"
    for name in pairs
]
head = "| instrument | contrast | mean of $p\\,r$ | $\\sigma_\\varphi$ (rad) "
head += "| $\\sigma_z$ (mm) | pixels, over Eq. 8 |\n|---|---|---|---|---|---|\n"
glue("instruments", Markdown(head + "\n".join(rows)), display=False)
weak_name, strong_name = (
    f"two modulators, η = {eta_weak:.2f}",
    f"two modulators, η = {eta_strong:.2f}",
)
told = {
    "contrast_eq8": contrasts[eq8],
    "contrast_weak": contrasts[weak_name],
    "contrast_strong": contrasts[strong_name],
    "contrast_fifth": contrasts[eq8] / contrasts[weak_name],
    "pixels_weak": (noise[weak_name] / noise[eq8]) ** 2,
    "modulator_weak": 100 * weak.contrast(),
}
for name, value in told.items():
    glue(name, float(value), display=False)

# %% [markdown]
# ```{glue:md} instruments
# :format: myst
# ```
#
# Modulators at a contrast of {glue:text}`modulator_weak:.0f` % each, which the paper calls high,
# correlate with {glue:text}`contrast_weak:.3f`: {glue:text}`contrast_fifth:.1f` times less than
# Eq. 8 takes for granted, and {glue:text}`pixels_weak:.0f` times the pixels. Driven to η = π/4
# they reach {glue:text}`contrast_strong:.3f`, a hair more than Eq. 8's
# {glue:text}`contrast_eq8:.3f`. So the simulated noise of the paper (and of this book, which keeps
# its settings) is that of an instrument with a *strong* drive ({ref}`erratum 6 <erratum-6>`).
#
# ## The price of a strong drive
#
# A strong drive is not a sinusoid any more: its third harmonic is $J_3/J_1$ of the first, the
# correlation's $(J_3/J_1)^2$. Sampled at K equal steps of ψ, harmonics $mK\pm1$ fold onto the
# fundamental, and the phase errs by an amount that *repeats with the phase itself*: the cyclic
# error, which no averaging removes.

# %%
angle = TAU * np.arange(phases) / phases
counts = (3, 4, 8, 16)
looks = dict(zip(counts, (green, vermillion, purple, blue), strict=True))
error = {
    (eta, k): cyclic_error(*2 * [single_mode_harmonics(eta, 24)], phase=angle, samples=k)
    for eta in (eta_weak, eta_strong)
    for k in (4, 16)
}
largest = {key: 1e3 * float(np.abs(e).max()) for key, e in error.items()}  # mrad
etas = np.linspace(0.02, 0.95, drives)
coarse = angle[:: max(1, phases // 90)]
against_drive = {
    k: [
        np.abs(cyclic_error(w, w, phase=coarse, samples=k)).max()
        for w in single_mode_harmonics(etas, 24)
    ]
    for k in counts
}

# %% tags=["hide-input"]
micron_per_mrad = 1e6 * float(depth_from_phase(1e-3, frequency))
figure, axes = plt.subplots(1, 2, figsize=(9.6, 4.0))
ax = axes[0]
ax.plot(angle, 1e3 * error[eta_strong, 4], color=vermillion, label="η = π/4, K = 4")
ax.plot(angle, 1e3 * error[eta_weak, 4], color=orange, label=f"η = {eta_weak:.2f}, K = 4")
ax.plot(angle, 1e3 * error[eta_strong, 16], color=blue, ls="--", label="η = π/4, K = 16")
ax.set(xlabel="true phase φ", ylabel="cyclic error (mrad)", xlim=(0, TAU), ylim=(-18, 26))
ax.set_xticks(*turn_ticks)
ax.legend(loc="upper center", ncols=2, fontsize="small")
ax.set_title("over the phase")
axes[1].set(yscale="log", ylim=(1e-7, 200), xlim=(0, 0.95), xlabel="drive amplitude η (rad)")
for k in counts:
    axes[1].plot(etas, np.maximum(1e3 * np.array(against_drive[k]), 1e-9), color=looks[k], lw=2)
for x, y, k in ((0.7, 0.9, 4), (0.8, 1e-3, 3), (0.93, 1e-6, 8)):
    axes[1].text(x, y, f"K = {k}", color=looks[k], ha="right", weight="bold")
for place, name in ((eta_weak, f"{eta_weak:.2f}"), (eta_strong, "π/4")):
    axes[1].axvline(place, color="#8A97A3", lw=1, ls=":", zorder=0)
    axes[1].text(place - 0.01, 1.6e-7, name, color="#5A646D", ha="right")

axes[1].set(ylabel="largest error (mrad)", title="over the drive")
for ax in axes:
    twin = ax.secondary_yaxis(
        "right", functions=(lambda y: y * micron_per_mrad, lambda y: y / micron_per_mrad)
    )
    twin.set_ylabel("depth (µm)")
table4 = 1e6 * paper.published("table4.proposed.rmse_mirror").value
axes[1].axhline(table4 / micron_per_mrad, color=black, lw=1, ls="-.")
axes[1].text(0.02, 1.4 * table4 / micron_per_mrad, "prototype, Table 4", fontsize="small")
plotting.label_panels(axes)
plotting.save(
    figure,
    "correlation_cyclic_error",
    numbers={f"mrad_{k}_steps": [largest[e, k] for e in (eta_weak, eta_strong)] for k in (4, 16)},
    caption=(
        "Cyclic error of the waveforms' harmonics with K steps of ψ, two single-mode modulators, "
        "simulated without noise. (a) Four steps alias the third harmonic of a strong drive into "
        "the phase; sixteen do not (dashed, on zero). (b) The largest error against the drive; K "
        "= 16 lies below. Right scales: as depth at 7.15 GHz; dash-dotted: Table 4's error of "
        "the prototype."
    ),
    alt=(
        "Left, the phase error over the phase: with four steps and a strong drive a wave of four "
        f"periods and {largest[eta_strong, 4]:.0f} milliradians, with a weak drive next to "
        "nothing, with sixteen steps zero. "
        "Right, on a logarithmic scale, errors that rise steeply with the drive: four steps most, "
        "three steps a thousand times less, eight less still; sixteen lie below the axis."
    ),
)

# %%
biased = replace(strong, half_wave_angle_error=np.deg2rad(1.0)).harmonics(24)
biased_error = {
    k: 1e3 * float(np.abs(cyclic_error(biased, biased, phase=coarse, samples=k)).max())
    for k in (3, 4, 16)
}
print("half-wave plate off by 1°:", {k: f"{e:.2g} mrad" for k, e in biased_error.items()})
glue("cyclic_weak", largest[eta_weak, 4], display=False)
glue("cyclic_strong", largest[eta_strong, 4], display=False)
glue("cyclic_strong_um", largest[eta_strong, 4] * micron_per_mrad, display=False)
glue("cyclic_sixteen", max(largest[eta_strong, 16], 1e-12), display=False)
glue("biased_three", biased_error[3], display=False)
glue("table4", table4, display=False)

# %% [markdown]
# With four steps the error is {glue:text}`cyclic_weak:.2f` mrad at η = 0.26 and
# {glue:text}`cyclic_strong:.0f` mrad at π/4. As depth that is {glue:text}`cyclic_strong_um:.0f`
# µm, more than the {glue:text}`table4:.1f` µm that the paper reports for the whole instrument. The
# prototype takes sixteen steps, and the error is gone.
#
# Odd numbers of steps are a surprise worth knowing: an ideal single-mode waveform has odd
# harmonics only, so *three* steps meet the fifth first, and beat four a thousandfold. The bargain
# ends where the optics are not ideal. A half-wave plate off by one degree adds even harmonics, and
# three steps err by {glue:text}`biased_three:.2f` mrad.
#
# ## From light to a number
#
# A detector of gain G and a converter Q complete the chain:
#
# ```{math}
# :label: eq-20
# C_\psi = Q\!\left(G\int_0^T\tilde p(t-\tau)\,r(t)\,dt\right)
#        = Q\!\left(\frac{\tilde\alpha}{2}\cos(\psi-\phi)+TK\right)
# ```
#
# (as printed; the right-hand side has again lost the sign of φ and the factors G and T). How much
# phase does rounding to 14 bits cost, when the signal fills the converter and nothing else is
# noisy?

# %%
full_scale = 2.0**ADC_BITS - 1
levels = np.array(
    [correlation_from_harmonics(raised, gate(1), phase=angle, psi=q) for q in quarters]
)
counts_in = GAIN * INTEGRATION_TIME * 2 * levels  # G T (1/2 + cos/π), as Eq. 8 has it
digital = quantise(counts_in, bits=ADC_BITS, full_scale=full_scale)
rounding = np.abs(np.angle(np.exp(1j * (phase_from_correlation(digital, quarters) - angle)))).max()
print(f"largest phase error of 14 bits: {1e3 * rounding:.3f} mrad")
glue("rounding", 1e3 * float(rounding), display=False)
glue("rounding_um", 1e3 * float(rounding) * micron_per_mrad, display=False)

# %% [markdown]
# At most {glue:text}`rounding:.2f` mrad, {glue:text}`rounding_um:.2f` µm of depth: the converter
# is not what limits this instrument. {doc}`Noise is <02_precision>`.
#
# ## Against the paper

# %%
paper.check("sec3.phase_steps", quarters.size)
paper.check("sec1.wrap_depth_7ghz", float(wrap_length(frequency)))
paper.check("sec6.bits", ADC_BITS)
paper.check("sec7.phase_steps", max(counts))
