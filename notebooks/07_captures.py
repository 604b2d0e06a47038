# %% [markdown]
# # Real captures and their noise
#
# How noisy are real all-optical measurements, and does the simulator have that noise (Paper Fig.
# 11)?
#
# Some of the authors published five raster scans of a later instrument, which sweeps the frequency
# where the paper steps the phase: wrapped phase at 7.15 GHz, and a coarse reference depth
# ([Pan et al. 2024](../book/references.bib#pan2024)). This book uses three, two heads and an owl
# before a wall. They are the only measurements that it can check itself against. The files are not
# part of it; the last line of the answer says whether this page had them.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of the simulated noise
fit_window: int = 5  # side of local fits and averages, px
window: int = 9  # side of the local fits whose residual is studied, px
draws: int = 16  # simulated maps of each capture and kind of noise

# %% tags=["hide-input"]
import matplotlib.pyplot as plt
import numpy as np
from scipy import ndimage, optimize, stats
from skimage.restoration import unwrap_phase

import cmtof
from cmtof import noise
from cmtof.captures import published_captures, read_capture
from cmtof.constants import FREQUENCY_SINGLE, NOISE_SIGMA
from cmtof.correlation import (
    TAU,
    consistent_wrap_count,
    depth_from_phase,
    depth_from_wraps,
    phase_from_depth,
    wrap_length,
    wrapped,
)
from cmtof.scenes import Frame, load_frame
from cmtof_book import notes, plotting

plotting.begin(profile=profile, seed=seed)
colours = tuple(plotting.PALETTE.values())
WRAP = wrap_length(FREQUENCY_SINGLE)


# %% [markdown]
# ## Noise matching on the same surface
#
# The files are not part of this project. Where a machine has none, a simulated scan in the same
# format replaces them: a piece of an embedded frame, shrunk to the captures' distances, with photon
# and electronic noise; its «reference» is the true range blurred and tilted by millimetres.


# %% tags=["hide-input"]
def simulated_scan():
    """Phase, rad, and reference depth, m, (100, 100), in place of a capture."""
    frame = load_frame("still_life")
    view = (slice(5, 105), slice(85, 185))
    piece = Frame(frame.depth[view] / 2, frame.intensity[view])
    scan = cmtof.simulate(piece, protocol="full", noise=600.0, seed=seed)
    filled = np.where(np.isfinite(piece.depth), piece.depth, np.nanmax(piece.depth))
    tilt = 0.004 * np.linspace(-1, 1, 100)[:, None]
    return scan.phase[0].astype(float), ndimage.gaussian_filter(filled, 2) + tilt


captures = {name: read_capture(file) for name, file in published_captures().items()}
source = "measured" if captures else "simulated"
captures = captures or {"still life": simulated_scan()}
names = list(captures)
count = len(captures)
phases, references = (
    dict(zip(names, two, strict=True)) for two in zip(*captures.values(), strict=True)
)


# %% [markdown]
# The range to a flat wall depends on the angle of the ray. So a fit of a plane and a focal length
# to the farthest points gives a mask of the wall.


# %% tags=["hide-input"]
def wall_of(depth):
    """Pixels within 1 cm of the flat wall behind everything, which a camera's rays see bent."""
    height, width = depth.shape
    y, x = np.mgrid[:height, :width] + 0.5
    u = (x - width / 2) / width
    v = (y - height / 2) / width

    def model(q):
        return np.sqrt(1 + q[0] ** 2 * (u**2 + v**2)) / (q[1] + q[2] * u + q[3] * v)

    q = np.array([0.5, 1 / np.percentile(depth, 90), 0.0, 0.0])
    for step in range(12):  # first what lies behind pulls, then what lies near
        off = depth - model(q)
        weight = (
            np.where(off > 0, 1.0, 0.1)
            if step < 6
            else (np.abs(off) < 0.01).astype(float)
        )
        q = optimize.least_squares(
            lambda q, w=weight: (w * (depth - model(q))).ravel(), q
        ).x
    return np.abs(depth - model(q)) < 0.01


walls = {name: wall_of(references[name]) for name in names}
residual = {name: noise.local_residual(phases[name], window=window) for name in names}
# no fit to an averaged map sees an object
margin = np.ones((window + fit_window - 1,) * 2)
inside = {
    name: ndimage.binary_erosion(walls[name], margin) & np.isfinite(residual[name])
    for name in names
}

# %% [markdown]
# A quadratic surface is fitted to 5×5 phases, from which the local slope is first removed, so that
# no wrap lies between them. What the fit leaves is the noise (`cmtof.noise`). In the simulator the
# phase noise of four images comes from photons and from Gaussian noise of σ counts:
#
# $$
# \sigma_\varphi\approx\frac{\sqrt{GTI/2+\sigma^2}}{\sqrt2\,a},\qquad a=\frac{GTI}{\pi}.
# \tag{7.1}$$
#
# At I = 1 this gives σ. The simulated scene is the capture's own averaged surface.

# %% tags=["hide-input"]
sigma = {}
matched = {}
smooth = {}
simulated = {}
for name, phase in phases.items():
    sigma[name] = noise.typical_phase_noise(phase, inside[name], window=fit_window)
    matched[name] = float(noise.sigma_from_phase_noise(sigma[name]))
    smooth[name] = noise.denoise(phase, window=fit_window)
    wraps = consistent_wrap_count(
        references[name], smooth[name].phase, FREQUENCY_SINGLE
    )
    depth = depth_from_wraps(smooth[name].phase, wraps, FREQUENCY_SINGLE)
    scene = Frame(depth, np.ones(depth.shape))
    how = {"protocol": "full", "noise": matched[name]}
    maps = [
        cmtof.simulate(scene, seed=seed, frame_number=k, **how) for k in range(draws)
    ]
    simulated[name] = [one.phase[0].astype(float) for one in maps]
    print(f"{name}: σ = {matched[name]:.0f} counts at I = 1")
single = 1e6 * depth_from_phase(list(sigma.values()), FREQUENCY_SINGLE)

# %% tags=["hide-input"]
shown = [simulated[name][0] for name in names] + list(phases.values())
titles = [f"{name}, {kind}" for kind in ("matched", source) for name in names]
style = {"cmap": plotting.PHASE_CMAP, "limits": plotting.TURN, "bar": False}
figure, axes = plotting.grid(2 * count, max(count, 2), 1)
for ax, picture, title in zip(axes, shown, titles, strict=True):
    drawn = plotting.image(ax, picture, label="", title=title, **style)
plotting.colour_bar(drawn, ax=axes, label="phase (rad)", shrink=0.6)
plotting.save(
    figure,
    "fig11_noise_matching",
    numbers={
        "source": source,
    },
    caption="Noise matching at 7.15 GHz: above, phase simulated with the noise level found; below, "
    f"the {source} phase to which it is matched (scenes: {count}). A turn of colour is "
    f"{1e3 * WRAP:.1f} mm. The simulated surface is an average, hence smoother.",
    alt="Pairs of phase maps with the same rings on a wall and an object, and the same graininess.",
    format="png",
)

# %% [markdown]
# ## Noise of the phase
#
# A scan is taken once, so its noise is estimated from neighbours. White noise has three properties.
# Its local squares follow a χ² law with 19 degrees of freedom (25 pixels less six coefficients).
# Neighbours are not correlated. The average of 5×5 phasors, less the local slope, has a fifth of
# the noise.

# %% tags=["hide-input"]
local = {
    name: noise.local_phase_noise(phase, window=fit_window)
    for name, phase in phases.items()
}
neighbours = {}
after = {}
few = (slice(fit_window // 2, None, fit_window),) * 2  # windows that share no pixel
for name in names:
    left = residual[name]
    where = inside[name]
    pairs = (
        (left[:-1], left[1:], where[:-1] & where[1:]),
        (left.T[:-1], left.T[1:], where.T[:-1] & where.T[1:]),
    )
    neighbours[name] = [np.corrcoef(a[both], b[both])[0, 1] for a, b, both in pairs]
    coarse = noise.local_phase_noise(smooth[name].phase[few], window=3)
    flat = ndimage.binary_erosion(where[few], np.ones((3, 3))) & np.isfinite(coarse)
    after[name] = np.median(coarse[flat]) / np.sqrt(stats.chi2.median(3) / 3)
    print(
        f"{name}: neighbours' correlation",
        *(f"{round(r, 2) + 0:.2f}" for r in neighbours[name]),
    )
    print(
        f"  averaged {after[name]:.3f} rad, {sigma[name] / fit_window:.3f} if it were white"
    )

# %% tags=["hide-input"]
freedom = fit_window**2 - 6
x = np.linspace(0.001, 0.32, 300)
figure = plt.figure(figsize=(8.4, 5.6))
above, below = figure.subfigures(2, 1)
ax = below.subplots()
panels = above.subplots(1, count, squeeze=False)[0]
for panel, name, colour in zip(panels, names, colours, strict=False):
    plotting.image(
        panel,
        local[name],
        label="",
        title=f"{name}, {source}",
        limits=(0, 0.6),
        bar=False,
    )
    panel.contour(inside[name], levels=[0.5], colors="white", linewidths=1.2)
    density, edges = np.histogram(
        local[name][inside[name]], 64, (0, 0.32), density=True
    )
    ax.stairs(density, edges, color=colour, alpha=0.3, fill=True)
    law = stats.chi2.pdf(freedom * (x / sigma[name]) ** 2, freedom)
    label = f"{name}: {sigma[name]:.3f} rad"
    ax.plot(x, 2 * freedom * x / sigma[name] ** 2 * law, color=colour, label=label)
above.colorbar(panels[0].images[0], ax=panels, label="noise (rad)")
ax.set(xlabel="local noise on the wall (rad)", ylabel="density (1/rad)")
ax.legend()
plotting.save(
    figure,
    "capture_noise",
    numbers={
        "source": source,
        "sigma_rad": sigma,
    },
    caption=f"Phase noise at 7.15 GHz ({source}) about quadratics fitted to "
    f"{fit_window}×{fit_window} pixels; white lines enclose the wall. Below: its distribution on "
    "the wall, and as lines that of white noise of equal size.",
    alt="Noise maps, dark on the wall and bright along outlines, above bell-shaped histograms near "
    "a tenth of a radian. Two follow the drawn laws; curlyhair1, whose neighbours share noise, is "
    "broader.",
    format="png",
)

# %% [markdown]
# Where neighbours are correlated, a local fit takes part of the noise for surface: the size above
# is then a lower bound.
#
# The brightness of the wall is unknown, so each capture determines a curve of pairs (I, σ) that
# give its phase noise, from photons alone to the paper's σ = 1200. The captures were decoded from
# swept signals, not from four images: the match concerns the size of the noise, not its origin.

# %%
for name, value in sigma.items():
    least, equal = (
        noise.intensity_from_phase_noise(value, s) for s in (0.0, NOISE_SIGMA)
    )
    print(
        f"{name}: I = {least:.4f} by photons alone, {equal:.2f} at σ = {NOISE_SIGMA:.0f}"
    )

# %% [markdown]
# ## From phase to depth
#
# Within a surface the wrap follows from neighbours; across an occlusion it does not. Wall and
# objects are therefore unwrapped separately ([Herráez et al.
# 2002](../book/references.bib#herraez2002)), where the average is coherent. Each connected piece
# gets the whole wraps that bring its median nearest to the reference.


# %% tags=["hide-input"]
def unwrapped(phase, region):
    return np.ma.filled(
        unwrap_phase(np.ma.masked_array(np.float32(phase), ~region), rng=0), np.nan
    )


def pinned(phase, region, reference):
    """Phase of the pieces of a region, rad, each in the wraps nearest to a reference depth."""
    relative = unwrapped(phase, region)
    total = np.full(phase.shape, np.nan)
    pieces, number = ndimage.label(region)
    for piece in (pieces == k for k in range(1, number + 1)):
        if piece.sum() >= 25:
            off = np.median(
                (phase_from_depth(reference, FREQUENCY_SINGLE) - relative)[piece]
            )
            total[piece] = relative[piece] + TAU * np.rint(off / TAU)
    return total


depths = {}
for name in names:
    phase = smooth[name].phase
    clear = smooth[name].coherence > 0.8
    wall = walls[name]
    parts = [pinned(phase, clear & side, references[name]) for side in (wall, ~wall)]
    total = np.where(np.isfinite(parts[0]), *parts)
    depths[name] = depth_from_phase(total, FREQUENCY_SINGLE)

# %% [markdown]
# On the wall, measured and reference phase should differ by one constant: the length of
# $\langle e^{i(\hat\varphi-\varphi_\mathrm{ref})}\rangle$ is 1 for a constant and 0 for no
# relation.

# %% tags=["hide-input"]
rows = []
for name in names:
    where = inside[name]
    error = smooth[name].phase - phase_from_depth(references[name], FREQUENCY_SINGLE)
    vector = np.exp(1j * error[where]).mean()
    offset = 1e3 * depth_from_phase(np.angle(vector), FREQUENCY_SINGLE)
    turns = (depths[name] - references[name]) / WRAP
    objects = turns[~walls[name] & np.isfinite(turns)]
    low, high = np.percentile(objects, [5, 95])
    rows.append(
        [name, f"{abs(vector):.3f}", f"{offset:.2f}", f"{low:.1f} to {high:.1f}"]
    )
notes.table(["", "length", "offset of the wall (mm)", "objects off by (wraps)"], rows)

# %% tags=["hide-input"]
titles = [f"{name}, {source}" for name in names] + count * ["minus reference"]
shown = [*depths.values(), *((depths[n] - references[n]) / WRAP for n in names)]
figure, axes = plotting.grid(2 * count, max(count, 2), 0.85)
for ax, values, title in zip(axes, shown, titles, strict=True):
    wraps = {"cmap": "RdBu_r", "limits": (-1.5, 1.5)} if "minus" in title else {}
    plotting.image(
        ax, values, label="wraps" if wraps else "depth (m)", title=title, **wraps
    )
plotting.save(
    figure,
    "capture_depth",
    numbers={
        "source": source,
    },
    caption=f"Depth from 7.15 GHz alone ({source}), its whole wraps taken from the reference "
    f"depth, and its difference from that reference in wraps of {1e3 * WRAP:.2f} mm. Grey: no "
    "coherent average, no depth.",
    alt="Depth maps of objects before a wall; differences, small on the wall, wide on the objects.",
    format="png",
)

# %% [markdown]
# In the published captures the reference of the wall is identical behind every object, while its
# measured phase moves from scan to scan by a millimetre or two: the instrument drifts. On the
# objects the reference errs by about a whole wrap within one smooth surface, so it cannot serve as
# ground truth.

# %% [markdown]
# ## The grain of the noise
#
# Measured and simulated maps go through the same fit of 9×9 pixels and the same mask; the
# residual's power spectrum shows its grain. Samples of one scan line follow each other in time:
# filters and overlapping beam spots correlate *neighbours*. Between lines the instrument drifts, so
# all pixels of a *line* share an error:
#
# $$
# P(k_y,k_x)=\sigma_\mathrm{w}^2\,(1+2\rho_\mathrm{d}\cos k_y)(1+2\rho_\mathrm{a}\cos k_x)
# \;+\;H\,\sigma_\mathrm{l}^2\,\delta_{k_y}.
# \tag{7.2}$$
#
# Here σ_w is the noise of a pixel, ρ_d and ρ_a its correlation with the neighbour down and across,
# and σ_l the error that the H pixels of a line share, at k_y = 0 alone. The four numbers are
# maximum-likelihood estimates from the residual's spectrum. A ρ of ½ is a running mean of two
# samples, or a scan sampled twice as finely as it is resolved.

# %% tags=["hide-input"]
lines = {}
with_lines = {}
rng = np.random.default_rng([seed, 11])
for name in names:
    lines[name] = noise.fit_line_noise(residual[name], inside[name], window=window)
    spectrum = lines[name].spectrum(phases[name].shape)
    with_lines[name] = [
        wrapped(smooth[name].phase + noise.noise_from_spectrum(spectrum, rng=rng))
        for _ in range(draws)
    ]
    print(
        f"{name}:", ", ".join(f"{k} {v:.3f}" for k, v in lines[name]._asdict().items())
    )
left = {
    kind: {n: [noise.local_residual(p, window=window) for p in maps[n]] for n in names}
    for kind, maps in (("white", simulated), ("lines", with_lines))
}
spectra = {n: noise.power_spectrum(residual[n], inside[n]) for n in names}
drawn = {
    kind: {n: [noise.power_spectrum(r, inside[n]) for r in maps[n]] for n in names}
    for kind, maps in left.items()
}

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(8.4, 4.2), sharey=True)
half = phases[names[0]].shape[0] // 2
waves = np.arange(1, half) / (2 * half)
for ax, axis, title in zip(
    axes, (1, 0), ("down the columns", "across the rows"), strict=True
):
    white = []
    for name, colour in zip(names, colours, strict=False):
        level = spectra[name].mean()
        white += [one.mean(axis)[1:half] / level for one in drawn["white"][name]]
        lined = np.mean(drawn["lines"][name], axis=0).mean(axis)[1:half] / level
        ax.plot(
            waves,
            spectra[name].mean(axis)[1:half] / level,
            ".",
            color=colour,
            label=name,
        )
        ax.plot(waves, lined, color=colour)
    low, high = np.percentile(white, [5, 95], axis=0)
    ax.fill_between(waves, low, high, color="0.85", zorder=0, label="simulated, white")
    ax.set(title=title, xlabel="frequency (1/px)", ylim=(0, 2.2))
axes[0].set_ylabel("power over its mean")
axes[0].legend(fontsize="small", ncols=2)
plotting.label_panels(axes)
plotting.save(
    figure,
    "noise_matching_spectra",
    numbers={
        "source": source,
        "line_noise": {n: line._asdict() for n, line in lines.items()},
    },
    caption=f"Spectra of the noise on the wall ({source}, dots), those of simulated line noise "
    "(lines), and the range (5 to 95 %) of simulated white noise (grey). White noise is level, "
    "but for the low frequencies that the fit takes away; noise that neighbours share falls with "
    "the frequency.",
    alt="Dots of each scan, lines and a band: curlyhair1 falls with the frequency, the others are "
    "level.",
)


# %% [markdown]
# ## Agreement and disagreement
#
# **Reproduced**: the size of the noise, by a choice of σ. **Not reproduced**: its grain. The
# simulator's pixels are independent. Where neighbours or columns of a scan share their noise,
# averages over a surface improve more slowly than in the simulation.
#
# **Not settled**: the amplitude over the scene is unknown, so noise is compared with that of
# uniform brightness. One map of each scene does not show changes between scans.

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** On the wall one point scatters by {low:.0f} to {high:.0f} µm. The simulator has the
    same noise level with σ = {least:.0f} to {most:.0f} counts on a white wall, but not always the
    same grain. **The maps on this page are {source}.**
    """,
    low=single.min(),
    high=single.max(),
    least=min(matched.values()),
    most=max(matched.values()),
    source=source,
)
