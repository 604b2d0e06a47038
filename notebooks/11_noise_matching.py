# %% [markdown]
# # Noise matching
#
# A simulator is worth what its noise is worth: a method that was tuned on noise of the wrong size,
# or the wrong grain, fails on the instrument. The paper shows one simulated and one measured phase
# map side by side (its Fig. 11) and leaves it at that. This page puts numbers to it: how noisy the
# published captures of the 7.15 GHz line are {cite}`pan2024`, what setting of the simulator gives
# as much, and what such a simulation still lacks. The captures are not part of this project; where
# a machine has none, the page rehearses on a simulated scan in the same format. **The maps
# studied on this page are {glue:text}`map_source`**: {glue:text}`map_names`.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of the simulated noise
window: int = 9  # side of the local fits whose residual is studied, px
fit_window: int = 5  # side of the local fits that tell the noise, px
draws: int = 16  # simulated maps for each capture and kind of noise

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown, display
from myst_nb import glue
from scipy import ndimage, stats

import cmtof
from cmtof import noise
from cmtof.book import plotting, views
from cmtof.constants import FREQUENCY_SINGLE, NOISE_SIGMA
from cmtof.correlation import wrap_length, wrapped
from cmtof.noise import denoise, local_phase_noise
from cmtof.scenes.captures import published_captures

paper_run = plotting.begin(profile=profile, seed=seed)
blue, vermillion, green = (plotting.PALETTE[k] for k in ("blue", "vermillion", "green"))


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, value if isinstance(value, str) else float(value), display=False)


# %%
found = published_captures()
source, role = ("measured", "measured") if found else ("simulated", "rehearsal")
with tempfile.TemporaryDirectory() as folder:
    files = found or {"still life": noise.rehearsal_capture(Path(folder), seed=seed)}
    captures = {name: cmtof.open(file) for name, file in files.items()}
banner = {
    "measured": "**Measured.** Published captures are on this machine: " + ", ".join(captures),
    "simulated": "**Simulated.** No published captures are on this machine: what is called "
    "measured here is a rehearsal.",
}
display(Markdown(banner[source]))
tell(map_source=source, map_names=", ".join(captures))

# %% [markdown]
# ## How noisy is a phase map?
#
# Anyone who has measured the noise of a camera has photographed a grey card twice and subtracted.
# A scan is taken once, so the noise must come from neighbours: fit a smooth surface to a few pixels
# and look at what is left ({doc}`08_real_capture` tells how a wrapped phase is fitted). On the flat
# wall behind the objects there is nothing else to be left; the study keeps to it, so far from every
# object that no window reaches one.

# %%
phases = {name: m.phase[0].astype(float) for name, m in captures.items()}
references = {name: m.dataset["reference_depth"].to_numpy() for name, m in captures.items()}
margin = np.ones((window + fit_window - 1,) * 2)  # no fit to the averaged map sees an object
inside, sigma_phi = {}, {}
for name, phase in phases.items():
    wall = views.fit_wall(references[name]).mask
    known = np.isfinite(noise.local_residual(phase, window=window))
    inside[name] = ndimage.binary_erosion(wall, margin) & known
    sigma_phi[name] = noise.typical_phase_noise(phase, inside[name], window=fit_window)
    print(f"{name}: σ_φ = {sigma_phi[name]:.3f} rad on {inside[name].sum()} pixels of wall")
tell(phi_low=min(sigma_phi.values()), phi_high=max(sigma_phi.values()))

# %% [markdown]
# Between {glue:text}`phi_low:.3f` and {glue:text}`phi_high:.3f` rad. In the simulator the phase
# noise of four correlation images comes from photons and from Gaussian noise of σ counts, against
# an amplitude that grows with the brightness I of the surface:
#
# ```{math}
# :label: matching-noise
# \sigma_\varphi\approx\frac{\sqrt{GTI/2+\sigma^2}}{\sqrt2\,a},\qquad a=\frac{GTI}{\pi},
# ```
#
# and a little more by the exact law ({doc}`05_simulation`). The captures hold phases only, no
# amplitude: how bright the wall was is unknown. So each capture fixes a *curve* of pairs (I, σ),
# all of which give its phase noise. Where σ outweighs the photons, only their ratio counts. One
# more unknown hides here: the captures were decoded from swept signals, not from four images. What
# is matched is the noise of the phase, not the path to it.

# %%
matched = {n: float(noise.sigma_from_phase_noise(v)) for n, v in sigma_phi.items()}
equal = {n: float(noise.intensity_from_phase_noise(v, NOISE_SIGMA)) for n, v in sigma_phi.items()}
for name in captures:
    least = noise.intensity_from_phase_noise(sigma_phi[name], 0.0)
    print(
        f"{name}: σ = {matched[name]:.0f} counts at I = 1, or I = {equal[name]:.2f} at "
        f"σ = {NOISE_SIGMA:.0f}; photons alone at I = {least:.4f}"
    )
tell(
    matched_low=min(matched.values()),
    matched_high=max(matched.values()),
    equal_low=min(equal.values()),
    equal_high=max(equal.values()),
    paper_noise=noise.phase_noise_from_sigma(NOISE_SIGMA),
    paper_third=noise.phase_noise_from_sigma(NOISE_SIGMA, intensity=0.3),
)

# %% tags=["hide-input"]
colours = dict(zip(captures, (blue, green, plotting.PALETTE["purple"]), strict=False))
figure, ax = plt.subplots(figsize=(6.6, 4.2))
for name, colour in colours.items():
    least = float(noise.intensity_from_phase_noise(sigma_phi[name], 0.0))
    brightness = np.geomspace(1.001 * least, 2.0, 200)
    pairs = noise.sigma_from_phase_noise(sigma_phi[name], intensity=brightness)
    ax.plot(brightness, pairs, color=colour, label=f"{name}: {sigma_phi[name]:.3f} rad")
    ax.plot(1.0, matched[name], "o", color=colour, ms=6)
    ax.plot(equal[name], NOISE_SIGMA, "D", mfc="none", mec=colour, ms=6)
ax.axhline(NOISE_SIGMA, color="#8A97A3", ls=":", lw=1.2)
ax.axvline(1.0, color="#8A97A3", ls=":", lw=1.2)
ax.text(0.021, NOISE_SIGMA * 1.07, "the paper's σ", color="#59646E")
ax.text(0.97, 5.6, "white paper", color="#59646E", rotation=90, ha="right", va="bottom")
ax.set(
    xscale="log",
    yscale="log",
    xlabel="brightness I assumed",
    ylabel="Gaussian noise σ (counts)",
    xlim=(0.02, 2.05),
    ylim=(5, 4000),
)
ax.set_xticks([0.02, 0.05, 0.1, 0.2, 0.5, 1, 2], ["0.02", "0.05", "0.1", "0.2", "0.5", "1", "2"])
ax.set_yticks([10, 100, 1000], ["10", "100", "1000"])
ax.minorticks_off()
ax.legend(loc="upper left", bbox_to_anchor=(0.0, 0.8), title="phase noise")
plotting.save(
    figure,
    "noise_matching_pairs",
    numbers={
        "source": source,
        "phase_noise_rad": sigma_phi,
        "sigma_at_full_brightness": matched,
        "brightness_at_1200": equal,
    },
    caption=f"Settings of the simulator that give the phase noise of each map ({source}): pairs of "
    "brightness and Gaussian noise. Dots: at I = 1. Diamonds: at the paper's σ. To the left the "
    "curves end where photon noise alone is enough.",
    alt="Curves of Gaussian noise over brightness, both logarithmic, that rise side by side, "
    "steeply at the dark end and in proportion beyond; at full brightness they pass "
    f"{min(matched.values()):.0f} to {max(matched.values()):.0f} counts.",
)

# %% [markdown]
# A white wall would need σ = {glue:text}`matched_low:.0f` to {glue:text}`matched_high:.0f` counts.
# At the paper's σ = 1200 the wall would have the brightness {glue:text}`equal_low:.2f` to
# {glue:text}`equal_high:.2f`. So the paper's noise, {glue:text}`paper_noise:.3f` rad on a white
# pixel, is the right size for these walls *if they count as white*. It is not the noise of a scan
# in which everything is white: a simulated surface of brightness 0.3 has
# {glue:text}`paper_third:.2f` rad.
#
# ## The same surface, simulated
#
# Now the match itself. The scene is the capture's own surface: its phase averaged over a window,
# with whichever whole wraps lie nearest the reference (at one frequency they do not show). It goes
# through the simulator at I = 1 with the σ found above.

# %%
scenes, simulated = {}, {}
for name, phase in phases.items():
    smooth = denoise(phase, window=fit_window).phase
    scenes[name] = noise.frame_from_phase(smooth, references[name])
    options = {"protocol": "full", "noise": matched[name]}
    simulated[name] = [
        cmtof.simulate(scenes[name], seed=seed, frame_number=k, **options).phase[0].astype(float)
        for k in range(draws)
    ]

# %% tags=["hide-input"]
count = len(captures)
figure, axes = plt.subplots(2, count, figsize=(3.1 * count + 0.9, 6.0), squeeze=False)
for column, name in zip(axes.T, captures, strict=True):
    plotting.phase_image(column[0], simulated[name][0], title=f"{name}, simulated")
    plotting.phase_image(column[1], phases[name], title=f"{name}, {role}")
plotting.save(
    figure,
    "fig11_noise_matching",
    numbers={
        "source": source,
        "phase_noise_rad": sigma_phi,
        "phase_noise_simulated_rad": {
            n: noise.typical_phase_noise(simulated[n][0], inside[n], window=fit_window)
            for n in captures
        },
    },
    caption=f"Noise matching. Above: simulated with the noise found. Below: {source}. The phase of "
    f"7.15 GHz; a turn of colour is {1e3 * float(wrap_length(FREQUENCY_SINGLE)):.1f} mm of depth. "
    f"The simulated surface is an average over {fit_window}×{fit_window} pixels, hence its softer "
    "detail.",
    alt="Pairs of cyclic-coloured phase maps with rings on a wall and on an object before it; the "
    "upper and the lower map of each pair have the same rings and the same graininess.",
    format="png",
)

# %% [markdown]
# Side by side the grain of the two looks alike, which is as far as the paper's figure goes. The eye
# is lenient with noise.
#
# ## What is left over a fit
#
# The residual of a pixel is its phase minus a quadratic surface fitted to the
# {glue:text}`window_side:.0f`×{glue:text}`window_side:.0f` pixels around it. Simulated and measured
# maps go through the same fit and the same mask, so what the fit swallows it swallows in both. All
# simulated numbers below come with their scatter over {glue:text}`draw_count:.0f` draws, which is
# what makes «alike» a question with an answer.

# %%
residual = {n: noise.local_residual(p, window=window) for n, p in phases.items()}
residual_simulated = {
    n: [noise.local_residual(p, window=window) for p in maps] for n, maps in simulated.items()
}
tell(window_side=window, draw_count=draws)
leak = {}
for name in captures:
    clean = cmtof.simulate(scenes[name], protocol="full", noise_free=True).phase[0]
    own = noise.local_residual(clean, window=window)[inside[name]]
    leak[name] = float(own.std() / residual[name][inside[name]].std())
    print(f"{name}: the scene itself still holds {leak[name]:.0%} of the residual, rms")
tell(leak_share=100 * max(leak.values()) ** 2)

# %% [markdown]
# (The averaged surface is not quite free of the noise it was averaged from: at most
# {glue:text}`leak_share:.0f` % of the residual's power is its own.)

# %%
bins = np.linspace(-5, 5, 61)
apart = (slice(window // 2, None, window // 2 + 1),) * 2  # fits that share less than half


def spread_out(values, where):
    return values[apart][where[apart]]


kolmogorov = {}
for name in captures:
    ours = np.concatenate([spread_out(r, inside[name]) for r in residual_simulated[name]])
    theirs = spread_out(residual[name], inside[name])
    test = stats.ks_2samp(theirs / theirs.std(), ours / ours.std())
    kolmogorov[name] = float(test.pvalue)
    print(f"{name}: {theirs.size} residuals far apart, same shape with p = {test.pvalue:.3f}")

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, count, figsize=(3.3 * count + 0.9, 6.2), squeeze=False)
for column, name in zip(axes.T, captures, strict=True):
    shown = np.where(inside[name], residual[name], np.nan)
    plotting.image(
        column[0], shown, label="residual (rad)", title=f"{name}, {role}", cmap="RdBu_r",
        limits=(-0.4, 0.4),
    )  # fmt: skip
    unit = residual[name][inside[name]].std()
    pooled = np.concatenate([r[inside[name]] for r in residual_simulated[name]])
    column[1].hist(
        residual[name][inside[name]] / unit, bins, density=True, color=blue, alpha=0.45,
        label=role,
    )  # fmt: skip
    heights = np.histogram(pooled / pooled.std(), bins, density=True)[0]
    column[1].stairs(heights, bins, color=vermillion, lw=1.6, label="matched simulation")
    column[1].set(xlabel="residual / its own rms", yscale="log", ylim=(2e-4, 6), xlim=(-5, 5))
axes[1, 0].set_ylabel("density")
axes[1, 0].legend(loc="upper left", fontsize="small", handlelength=1.0)
plotting.save(
    figure,
    "noise_matching_residuals",
    numbers={
        "source": source,
        "rms_rad": {n: float(residual[n][inside[n]].std()) for n in captures},
        "rms_simulated_rad": {
            n: float(np.mean([r[inside[n]].std() for r in residual_simulated[n]])) for n in captures
        },
        "kolmogorov_p": kolmogorov,
    },
    caption=f"Above: what a quadratic fit of {window}×{window} pixels leaves of the phase on the "
    f"wall ({source}; grey is not studied). Below: its histogram, each in units of its own rms, "
    "beside that of the matched simulation.",
    alt="Residual maps in red and blue: grain without an image of the scene. Below, "
    "bell-shaped histograms on a logarithmic scale; outlines of the simulated ones lie on them "
    "in the middle.",
    format="png",
)

# %% [markdown]
# ## The grain of the noise
#
# A histogram knows nothing of where a value stands. That is told by the **power spectrum**: how
# much of the residual's variance lies at each spatial frequency, from waves as long as the map to
# waves of two pixels. Independent pixels give a flat spectrum, whose height is their variance. The
# fit takes out what is slow; its response is known, so the curve to be expected is not flat but
# flat times the response.

# %%
response = noise.fit_response(phases[next(iter(captures))].shape, window=window) ** 2
spectra = {n: noise.power_spectrum(residual[n], inside[n]) for n in captures}
white = {n: [noise.power_spectrum(r, inside[n]) for r in residual_simulated[n]] for n in captures}
for name in captures:
    power, square = spectra[name].mean(), np.mean(residual[name][inside[name]] ** 2)
    print(f"{name}: mean of the spectrum {power:.6f}, mean square {square:.6f} rad² (Parseval)")

# %% [markdown]
# ### A scan has lines
#
# What correlates in a scan, and why? Samples of one line follow each other in time: filters and
# overlapping beam spots mix **neighbours**. From one line to the next the instrument drifts, and
# all pixels of a **line** move together. Both have spectra that can be written down,
#
# ```{math}
# :label: line-noise
# P(k_y,k_x)=\sigma_\mathrm{w}^2\,(1+2\rho_\mathrm{d}\cos k_y)(1+2\rho_\mathrm{a}\cos k_x)
# \;+\;H\,\sigma_\mathrm{l}^2\,\delta_{k_y},
# ```
#
# grain of strength $\sigma_\mathrm w$ whose neighbours correlate by ρ down and across, and an
# offset $\sigma_\mathrm l$ of each column of H pixels. The four numbers are found as those under
# which the residual's spectrum is likeliest, seen through the fit and the mask.

# %%
lines, with_lines, line_residual, line_spectra = {}, {}, {}, {}
rng = np.random.default_rng([seed, 11])
for name in captures:
    lines[name] = noise.fit_line_noise(residual[name], inside[name], window=window)
    spectrum = lines[name].spectrum(phases[name].shape)
    smooth = denoise(phases[name], window=fit_window).phase
    with_lines[name] = [
        wrapped(smooth + noise.noise_from_spectrum(spectrum, rng=rng)) for _ in range(draws)
    ]
    line_residual[name] = [noise.local_residual(p, window=window) for p in with_lines[name]]
    line_spectra[name] = [noise.power_spectrum(r, inside[name]) for r in line_residual[name]]
    print(name, {key: round(value, 3) for key, value in lines[name]._asdict().items()})

# %% tags=["hide-input"]
figure, axes = plt.subplots(3, count, figsize=(3.4 * count + 0.9, 8.8), squeeze=False)
half = phases[next(iter(captures))].shape[0] // 2
frequency = np.arange(1, half) / (2 * half)
for column, name in zip(axes.T, captures, strict=True):
    level = 1e3 * spectra[name].mean()
    smoothed = ndimage.uniform_filter(spectra[name], 3, mode="wrap")
    plotting.image(
        column[0], np.fft.fftshift(1e3 * smoothed), label="10⁻³ rad²", title=f"{name}, {role}",
        limits=(0, 2.5 * level),
    )  # fmt: skip
    column[0].set(xlabel="across →", ylabel="down →")
    for ax, axis, title in ((column[1], 1, "down the columns"), (column[2], 0, "across the rows")):
        for kind, colour in ((white[name], vermillion), (line_spectra[name], green)):
            curves = 1e3 * np.mean(kind, axis=1 + axis)[:, 1:half]
            ax.fill_between(frequency, *np.percentile(curves, [5, 95], axis=0), color=colour,
                            alpha=0.25, lw=0)  # fmt: skip
            ax.plot(frequency, curves.mean(0), color=colour, lw=1.4,
                    label="matched, white" if colour == vermillion else "with lines")  # fmt: skip
        ax.plot(frequency, 1e3 * spectra[name].mean(axis)[1:half], ".", color=blue, ms=5,
                label=role)  # fmt: skip
        ax.set(title=title, ylim=(0, 2.0 * level), xlim=(0, 0.5))
    column[2].set_xlabel("frequency (1/px)")
axes[1, 0].set_ylabel("power (10⁻³ rad²)")
axes[2, 0].set_ylabel("power (10⁻³ rad²)")
axes[1, 0].legend(loc="upper right", fontsize="small", handlelength=1.0)
plotting.save(
    figure,
    "noise_matching_spectra",
    numbers={
        "source": source,
        "line_noise": {n: line._asdict() for n, line in lines.items()},
        "power_at_the_finest_down": {
            n: float(spectra[n][half - 8 : half].mean() / spectra[n].mean()) for n in captures
        },
        "power_at_the_finest_across": {
            n: float(spectra[n][:, half - 8 : half].mean() / spectra[n].mean()) for n in captures
        },
    },
    caption=f"Power spectra of the residual on the wall ({source}). Above: in two dimensions, zero "
    "frequency in the middle. Below: down the columns and across the rows, with the spread (5 to "
    "95 %) of simulations with white noise and with line noise.",
    alt="Two-dimensional spectra above two rows of curves: dots of the residual among two bands, "
    "an orange one of white noise, nearly level, and a green one of line noise, whose neighbours "
    f"correlate by {max(line.down for line in lines.values()):.2f} at most.",
    format="png",
)
tell(
    excess=max(100 * (np.hypot(v.white, v.line) / sigma_phi[n] - 1) for n, v in lines.items()),
    fit_side=fit_window,
    line_low=min(v.line for v in lines.values()),
    line_high=max(v.line for v in lines.values()),
    down_low=min(v.down for v in lines.values()),
    down_high=max(v.down for v in lines.values()),
    across_low=min(v.across for v in lines.values()),
    across_high=max(v.across for v in lines.values()),
)

# %% [markdown]
# The columns' offsets come out at {glue:text}`line_low:.3f` to {glue:text}`line_high:.3f` rad,
# neighbours correlate by {glue:text}`down_low:.2f` to {glue:text}`down_high:.2f` down and
# {glue:text}`across_low:.2f` to {glue:text}`across_high:.2f` across. A value of ½ is a running mean
# of two samples: its spectrum falls to zero at the finest wave. Where it stands near that, the scan
# was sampled twice as finely as it was resolved. Grain and offsets together make up to
# {glue:text}`excess:.0f` % more noise than the fits of
# {glue:text}`fit_side:.0f`×{glue:text}`fit_side:.0f` pixels told: what neighbours share, so small a
# fit takes for surface.
#
# ## What matches, what does not
#
# Each line of the table is one number of a map: **measured** / white simulation / simulation with
# lines. A simulation that matches gives it within the scatter of its own draws; one that is off by
# more than four of their standard deviations is marked ≠.


# %%
def grain(left, where):
    """Of the residual: level, correlations, power of common columns and of slow ripples."""
    down, right = where[:-1] & where[1:], where[:, :-1] & where[:, 1:]
    power = noise.power_spectrum(left, where)
    passed = response > 0.5
    columns = (power / np.maximum(response, 0.5))[0, passed[0]].mean()
    return {
        f"rms about {window}×{window} fits (rad)": left[where].std(),
        "correlation with the pixel below": np.corrcoef(left[:-1][down], left[1:][down])[0, 1],
        "correlation with the pixel beside": np.corrcoef(
            left[:, :-1][right], left[:, 1:][right]
        )[0, 1],
        "power common to a column (of the mean)": columns / power[passed].mean(),
        "slow ripples (% of the power)": 100 * power[~passed].sum() / power.sum(),
    }  # fmt: skip


def tails(phase, left, where):
    """Of the noise's size: outliers, how it changes over the wall, and what edges add."""
    local = local_phase_noise(phase, window=fit_window)
    low, middle, high = np.percentile(local[where], [5, 50, 95])
    limit = 3.5 * 1.4826 * np.median(np.abs(left[where]))
    return {
        f"noise of a typical {fit_window}×{fit_window} window (rad)": middle,
        "noisiest over quietest windows (95 % / 5 %)": high / low,
        "outliers on the wall, beyond 3.5 σ (%)": 100 * np.mean(np.abs(left[where]) > limit),
        "the same, whole map (%)": 100 * np.mean(np.abs(left[np.isfinite(left)]) > limit),
    }


# %%
def told(phase, left, where):
    return grain(left, where) | tails(phase, left, where)


seen = {n: told(phases[n], residual[n], inside[n]) for n in captures}
made = {
    kind: {
        n: [told(p, r, inside[n]) for p, r in zip(maps[n], lefts[n], strict=True)] for n in captures
    }
    for kind, maps, lefts in (
        ("white", simulated, residual_simulated),
        ("lines", with_lines, line_residual),
    )
}

# %%
labels = list(seen[next(iter(captures))])
off, cells = {}, {}
for kind, maps in made.items():
    for name, drawn in maps.items():
        for label in labels:
            values = np.array([d[label] for d in drawn])
            off[kind, name, label] = float(
                (seen[name][label] - values.mean()) / max(values.std(ddof=1), 1e-9)
            )
            sign = "≠ " if abs(off[kind, name, label]) > 4 else ""
            cells[kind, name, label] = f"{sign}{values.mean():.3g}"
rows = [
    f"| {label} | "
    + " | ".join(
        f"**{seen[n][label]:.3g}** / {cells['white', n, label]} / {cells['lines', n, label]}"
        for n in captures
    )
    + " |"
    for label in labels
]
title = "| " + " | ".join(["", *captures]) + " |\n|---" + "|---:" * count + "|\n"
glue("matching_table", Markdown(title + "\n".join(rows)), display=False)

# %% [markdown]
# ```{glue:md} matching_table
# :format: myst
# ```

# %%
missed = [(n, k) for n in captures for k in labels if abs(off["white", n, k]) > 4]
mended = [pair for pair in missed if abs(off[("lines", *pair)]) <= 4]
words = []
for name in captures:
    far = max(labels[:-1], key=lambda k: abs(off["white", name, k]))
    value, away = cells["white", name, far], abs(off["white", name, far])
    alike = "alike in every number of the wall" if away <= 4 else f"furthest off in **{far}**"
    words.append(
        f"- {name}: white noise is {alike}"
        + (f": {seen[name][far]:.3g} measured, {value.removeprefix('≠ ')} simulated" * (away > 4))
        + "."
    )
display(Markdown("\n".join(words)))
tell(
    missed=len(missed),
    mended=len(mended),
    of_all=len(labels) * count,
    shape_low=min(kolmogorov.values()),
    outliers_low=min(v["outliers on the wall, beyond 3.5 σ (%)"] for v in seen.values()),
    outliers_high=max(v["outliers on the wall, beyond 3.5 σ (%)"] for v in seen.values()),
    whole_low=min(v["the same, whole map (%)"] for v in seen.values()),
    whole_high=max(v["the same, whole map (%)"] for v in seen.values()),
)

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, count, figsize=(3.1 * count + 3.2, 4.0), squeeze=False, sharey=True)
place = np.arange(len(labels))[::-1]
for ax, name in zip(axes[0], captures, strict=True):
    ax.axvspan(-4, 4, color="#E9EDF0", lw=0)
    for kind, colour, marker, shift in (
        ("white", vermillion, "o", 0.12), ("lines", green, "s", -0.12),
    ):  # fmt: skip
        ax.plot([off[kind, name, label] for label in labels], place + shift, marker, color=colour,
                ms=6, label={"white": "white noise", "lines": "with lines"}[kind])  # fmt: skip
    ax.set_xscale("symlog", linthresh=4)
    ax.set(title=f"{name}, {role}", xlabel="off by (σ of the draws)")
    ax.set_xticks([-100, -10, -4, 0, 4, 10, 100], ["-100", "-10", "", "0", "", "10", "100"])
    ax.minorticks_off()
    ax.set_xlim(-300, 300)
axes[0, 0].set_yticks(place, labels)
axes[0, 0].legend(loc="upper left", fontsize="small", handlelength=1.0)
plotting.save(
    figure,
    "noise_matching_verdict",
    numbers={
        "source": source,
        "measured": {n: {str(k): float(x) for k, x in v.items()} for n, v in seen.items()},
    },
    caption="How far each number of a map lies from the simulations', in standard deviations of "
    "their draws; grey: alike. Circles: white noise of the matched size. Squares: with lines.",
    alt=f"Dots for {len(labels)} statistics of each map. {len(missed)} of {len(labels) * count} "
    f"circles lie outside the grey band, and of these {len(mended)} have their square within it.",
)

# %% [markdown]
# White noise of the matched size misses {glue:text}`missed:.0f` of the
# {glue:text}`of_all:.0f` numbers; noise with lines meets {glue:text}`mended:.0f` of these.
#
# **In reach of the simulator**: the size of the noise, by a choice of σ, and the shape of its
# histogram on a wall (the least p of the Kolmogorov tests is {glue:text}`shape_low:.2f`). **Beyond
# it**: a grain. The simulator draws every pixel by itself. Where neighbours or columns of a scan
# share their noise it knows nothing of that, and so nothing of an error that averaging over a
# surface takes out more slowly than the number of its pixels promises. One cannot tell from the
# size of the noise whether a scan is of that kind; its spectrum shows it at a glance.
#
# **Edges.** Over the whole map {glue:text}`whole_low:.1f` to {glue:text}`whole_high:.1f` % of the
# residuals lie beyond 3.5 σ of the wall's, on the wall {glue:text}`outliers_low:.2f` to
# {glue:text}`outliers_high:.2f` %. Some of that is surface that no quadratic fits, which the
# simulation shares; the rest may be fine relief, dark paint, or a beam of finite width that sees
# two depths at once. The simulator's pixels are points, and an averaged scene has softer edges than
# the real one: this page cannot part these causes.
#
# **Not settled here.** How the *amplitude* varied over the scene is unknown, so the change of noise
# from window to window is compared with that of a uniform brightness, which no scene has. Slow
# ripples may be noise, the wall, or an error that runs with the phase itself. And one map a scene
# knows nothing of what changes from scan to scan.
