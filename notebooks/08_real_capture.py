# %% [markdown]
# # A real capture
#
# The all-optical prototype line has published raster scans: wrapped phase at 7.15 GHz of a few
# busts before a wall, beside a coarse reference depth {cite}`pan2024`. This page takes them from
# raw phase to depth: how noisy they are, what may be averaged, what one frequency can unwrap, and
# where the reference can be believed. The files are not part of this project; where a machine has
# none, the page says so and rehearses on a simulated scan in the same format. **The maps on this
# page are {glue:text}`capture_source`**: {glue:text}`capture_names`.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of the simulated scan's noise, where one is needed
fit_window: int = 5  # side of the local fits that tell the noise, px
window: int = 5  # side of the coherent average, px
stills: int = 3  # how many captures to draw in three dimensions

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown, display
from myst_nb import glue
from scipy import ndimage, stats

import cmtof
from cmtof.baselines.region import relative_phase
from cmtof.book import plotting, views
from cmtof.correlation import TAU, centred, depth_from_phase, phase_from_depth, wrap_length
from cmtof.measurement import Measurement
from cmtof.noise import denoise, local_phase_noise, rehearsal_capture
from cmtof.pointcloud import points_from_depth
from cmtof.scenes.captures import published_captures

paper_run = plotting.begin(profile=profile, seed=seed)
blue, vermillion, green = (plotting.PALETTE[k] for k in ("blue", "vermillion", "green"))


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, value if isinstance(value, str) else float(value), display=False)


# %% [markdown]
# ## The files
#
# Where there are no published files, a piece of an embedded frame stands in, shrunk to the
# captures' distances. Its phase is simulated with photon and electronic noise, its «reference» is
# the true range blurred and tilted by millimetres, as a coarse stereo pair would see it, and both
# are written and read in the published layout.


# %%
found = published_captures()
source = "measured" if found else "simulated"
with tempfile.TemporaryDirectory() as folder:
    files = found or {"still life": rehearsal_capture(Path(folder), seed=seed)}
    captures = {name: cmtof.open(file) for name, file in files.items()}
banner = {
    "measured": "**Measured.** Published captures are on this machine: " + ", ".join(captures),
    "simulated": "**Simulated.** No published captures are on this machine; a rehearsal follows.",
}
display(Markdown(banner[source]))
tell(capture_source=source, capture_names=", ".join(captures))

# %%
frequency = float(next(iter(captures.values())).frequencies[0])
wrap = float(wrap_length(frequency))
phases = {name: m.phase[0].astype(float) for name, m in captures.items()}
references = {name: m.dataset["reference_depth"].to_numpy() for name, m in captures.items()}
walls = {name: views.fit_wall(depth) for name, depth in references.items()}
for name, wall in walls.items():
    angle = np.degrees(2 * np.arctan(0.5 * wall.mask.shape[1] / wall.camera[0]))
    print(f"{name}: {wall.mask.shape}, wall in {wall.mask.mean():.0%}, {angle:.1f}° across")

# %% [markdown]
# No angles come with the maps, but the wall knows them: the range to a flat wall bends with the
# angle of the ray, and a fit of plane and scale to what lies farthest (`views.fit_wall`) gives
# both the background mask and a camera.
#
# ## How noisy is the phase?
#
# One phase a pixel and no repetition: the noise must come from neighbours. A quadratic surface is
# fitted to each window of 5×5 phases, after turning them back by their local slope, so that no wrap
# lies between them. What is left over, divided by 19 degrees of freedom, is the noise, as long as
# the surface is smooth: on the wall it is, at edges it is not. The squares of white noise would
# follow a χ² law with those 19 degrees.

# %%
margin = np.ones((2 * fit_window - 1,) * 2)
noise = {name: local_phase_noise(phase, window=fit_window) for name, phase in phases.items()}
inside = {
    name: ndimage.binary_erosion(walls[name].mask, margin) & np.isfinite(noise[name])
    for name in captures
}
freedom = fit_window**2 - 6
median_of_law = np.sqrt(stats.chi2.median(freedom) / freedom)
sigma = {name: np.median(noise[name][inside[name]]) / median_of_law for name in captures}
spread = {name: np.percentile(noise[name][inside[name]], [5, 95]) for name in captures}
for name in captures:
    low, high = spread[name]
    print(f"{name}: σ_φ = {sigma[name]:.3f} rad, 90 % of the windows {low:.3f} to {high:.3f}")
tell(sigma_low=min(sigma.values()), sigma_high=max(sigma.values()))

# %%
count = len(captures)
colours = [blue, vermillion, green][:count]


def panels(kinds):
    """Axes by capture, then by kind: a column for each capture, or one row for a single one."""
    shape = (kinds, count) if count > 1 else (1, kinds)
    size = (3.0 * shape[1] + 1.2, 2.9 * shape[0] + 0.3)
    figure, axes = plt.subplots(*shape, figsize=size, squeeze=False)
    return figure, axes.T if count > 1 else axes


# %%
figure = plt.figure(figsize=(3.0 * max(count, 2) + 1.2, 6.4), layout="constrained")
top, bottom = figure.subfigures(2, 1, height_ratios=[1.1, 1])
maps = top.subplots(1, count, squeeze=False)[0]
for panel, name in zip(maps, captures, strict=True):
    plotting.image(
        panel, noise[name], label="local noise (rad)", title=f"{name}, {source}", limits=(0, 0.6)
    )
    panel.contour(inside[name], levels=[0.5], colors="white", linewidths=1.2)
law = bottom.subplots()
bins = np.linspace(0, 0.32, 65)
for (name, value), colour in zip(sigma.items(), colours, strict=True):
    held = noise[name][inside[name]]
    law.hist(held, bins, density=True, color=colour, alpha=0.35)
    x = np.linspace(0.001, 0.32, 300)
    density = 2 * freedom * x / value**2 * stats.chi2.pdf(freedom * (x / value) ** 2, freedom)
    law.plot(x, density, color=colour, label=f"{name}: {value:.3f} rad")
law.set(xlabel="local noise on the wall (rad)", ylabel="density (1/rad)", xlim=(0, 0.32))
law.legend(title="lines: white noise of")
plotting.save(
    figure,
    "capture_noise",
    numbers={
        "source": source,
        "sigma_rad": {name: float(value) for name, value in sigma.items()},
        "percentiles_5_95_rad": {name: value.tolist() for name, value in spread.items()},
    },
    caption=f"Phase noise ({source}) about quadratic surfaces fitted to windows of "
    f"{fit_window}×{fit_window} pixels. Above: each window's noise; white lines enclose the wall. "
    "Below: its histogram on the wall, beside the law of white noise with the same median.",
    alt="Noise maps, dark on the wall and bright along the outlines of the objects, above "
    "bell-shaped histograms near a tenth of a radian that are a little wider than the drawn laws.",
    format="png",
)

# %% [markdown]
# On the wall the noise is {glue:text}`sigma_low:.3f` to {glue:text}`sigma_high:.3f` rad. Is it
# white? Averages fall with the root of the number of pixels only if neighbours are independent. The
# residual about a wide average tells.

# %%
neighbours = {}
for name, phase in phases.items():
    left = centred(phase - denoise(phase, window=9).phase)
    down = inside[name][:-1] & inside[name][1:]
    right = inside[name][:, :-1] & inside[name][:, 1:]
    neighbours[name] = (
        float(np.corrcoef(left[:-1][down], left[1:][down])[0, 1]),
        float(np.corrcoef(left[:, :-1][right], left[:, 1:][right])[0, 1]),
    )
    print(f"{name}: correlation {neighbours[name][0]:.2f} down, {neighbours[name][1]:.2f} across")
tell(
    correlation_down=np.mean([pair[0] for pair in neighbours.values()]),
    correlation_across=np.mean([pair[1] for pair in neighbours.values()]),
)

# %% [markdown]
# Neighbours correlate by {glue:text}`correlation_down:.2f` down the columns and
# {glue:text}`correlation_across:.2f` across, on average. Independent noise gives zero, as the
# simulated scan shows where it stands in. What the scans show beyond it, the drift between one line
# and the next or beam spots that overlap, no average within five pixels takes out, and a local fit
# takes part of it for surface: the numbers above are then a lower bound.
#
# ## Denoising: turn back, then sum
#
# Wrapped phases must not be averaged, phasors may: a sum of phasors is linear in the noise and
# knows no wraps. But over five pixels the phase of a slanted surface turns by a radian or two, and
# a plain average of phasors would cancel. So each window is first turned back by its own slope
# (`cmtof.noise.denoise`). A small Gaussian would be simpler, and loses exactly where surfaces
# slant; a quadratic fit would keep curvature, and about twice the noise.

# %%
denoised = {name: denoise(phase, window=window) for name, phase in phases.items()}
after = {}
for name in captures:
    apart = (slice(window // 2, None, window),) * 2  # windows that share no pixel
    coarse = local_phase_noise(denoised[name].phase[apart], window=3)
    wall = ndimage.binary_erosion(inside[name][apart], np.ones((3, 3))) & np.isfinite(coarse)
    after[name] = float(np.median(coarse[wall]) / np.sqrt(stats.chi2.median(3) / 3))
    print(
        f"{name}: {after[name]:.3f} rad after averaging ({wall.sum()} windows), "
        f"{sigma[name] / window:.3f} if the noise were white"
    )

# %%
figure, columns = panels(2)
for column, name in zip(columns, captures, strict=True):
    plotting.phase_image(column[0], phases[name], title=f"{name}, {source}")
    plotting.phase_image(column[1], denoised[name].phase, title=f"averaged {window}×{window}")
plotting.save(
    figure,
    "capture_phase",
    numbers={
        "source": source,
        "noise_after_rad": after,
        "correlation_down_across": {name: list(pair) for name, pair in neighbours.items()},
    },
    caption=f"Wrapped phase at 7.15 GHz ({source}), as it stands in the files and after coherent "
    f"averaging along the local slope. One turn of colour is {1e3 * wrap:.2f} mm of depth.",
    alt="Cyclic-coloured phase maps: contour-like rings on the wall and on the object in front of "
    "it. In the lower row the same rings without grain.",
    format="png",
)

# %% [markdown]
# ## Unwrapping with one frequency
#
# One frequency tells depth within a wrap, and neighbours tell the next wrap as long as the surface
# goes on. Over an occlusion nothing does. So the wall and the objects are unwrapped apart, by
# reliability {cite}`herraez2002`, only where the average is coherent; each connected piece then
# takes the whole number of wraps that brings its median nearest to the reference. The fraction of a
# wrap is never touched.


# %%
def pinned(phase, region, reference):
    held = Measurement.from_phase(phase[None], [frequency], mask=region, range_max=1.0)
    relative = relative_phase(held)
    total = np.full(phase.shape, np.nan)
    pieces, number = ndimage.label(region)
    for piece in (pieces == k for k in range(1, number + 1)):
        if piece.sum() >= 25:
            off = np.median((phase_from_depth(reference, frequency) - relative)[piece])
            total[piece] = relative[piece] + TAU * np.rint(off / TAU)
    return total


depths, misled = {}, {}
for name in captures:
    smooth, clear = denoised[name].phase, denoised[name].coherence > 0.8
    parts = [
        pinned(smooth, clear & side, references[name])
        for side in (walls[name].mask, ~walls[name].mask)
    ]
    total = np.where(np.isfinite(parts[0]), parts[0], parts[1])
    depths[name] = depth_from_phase(total, frequency)
    naive = relative_phase(Measurement.from_phase(smooth[None], [frequency], range_max=1.0))
    turns = np.rint((naive - total)[np.isfinite(total)] / TAU)
    misled[name] = float(np.mean(turns != np.median(turns)))
    print(f"{name}: unwrapped in one piece, {misled[name]:.0%} of the pixels differ by wraps")

# %% [markdown]
# ## Against the reference
#
# On the wall, measured and reference phase should differ by one constant, up to whole wraps: the
# length of $\langle e^{i(\hat\varphi-\varphi_\mathrm{ref})}\rangle$ is 1 for a constant and 0 for
# no relation. A slow tilt of the reference, which comes from another instrument, is fitted and
# taken out in a second step.

# %%
y, x = np.mgrid[:1:100j, :1:100j]
agreement = {}
for name in captures:
    wall = inside[name]
    error = centred(denoised[name].phase - phase_from_depth(references[name], frequency))
    vector = np.exp(1j * error[wall]).mean()
    about = centred(error - np.angle(vector))[wall]
    design = np.stack([np.ones_like(x), x, y], -1)[wall]
    plane = design @ np.linalg.lstsq(design, about, rcond=None)[0]
    agreement[name] = {
        "circular": float(abs(vector)),
        "offset_mm": float(1e3 * depth_from_phase(np.angle(vector), frequency)),
        "rms_mm": float(1e3 * depth_from_phase(about.std(), frequency)),
        "tilt_mm": float(1e3 * depth_from_phase(np.ptp(plane), frequency)),
        "rms_flat_mm": float(1e3 * depth_from_phase((about - plane).std(), frequency)),
    }
    found_here = agreement[name]
    print(name, {key: round(value, 2) for key, value in found_here.items()})
tell(
    agreement_low=min(a["circular"] for a in agreement.values()),
    agreement_high=max(a["circular"] for a in agreement.values()),
    tilt=max(a["tilt_mm"] for a in agreement.values()),
    flat=max(a["rms_flat_mm"] for a in agreement.values()),
)

# %% [markdown]
# The agreement on the wall is {glue:text}`agreement_low:.2f` to {glue:text}`agreement_high:.2f`;
# most of what it lacks is a tilt of up to {glue:text}`tilt:.1f` mm, and {glue:text}`flat:.2f` mm
# rms are left once that is out. Which of the two is tilted? Where several captures show the same
# wall, their phases can be held against each other, without any reference.

# %%
first, *others = captures
for name in others:
    both = inside[first] & inside[name]
    same = np.mean((references[first] == references[name])[both])
    change = np.exp(1j * (denoised[name].phase - denoised[first].phase))
    offset = depth_from_phase(np.angle(change[both].mean()), frequency)
    moved = centred(np.angle(change) - np.angle(change[both].mean()))[both]
    design = np.stack([np.ones_like(x), x, y], -1)[both]
    slope = np.linalg.lstsq(design, moved, rcond=None)[0][1:]
    across, down = 1e3 * depth_from_phase(slope, frequency)
    print(f"{name} − {first}: wall moved by {1e3 * offset:.2f} mm, {across:.2f} mm more from left")
    print(f"  to right, {down:.2f} mm from top to bottom; references identical in {same:.0%}")
if not others:
    print("a single scan: nothing to compare with")

# %% [markdown]
# In the published captures the reference of the wall is one and the same measurement, digit by
# digit, behind every object, while the measured phase of that wall moves from capture to capture by
# a millimetre or two, with a slope: the instrument drifts between scans and within one. The greater
# part of the tilt is common to all. It may be the reference's, or the path through the scanner's
# mirrors, which changes with their angle; the files do not tell. Within a window of five pixels
# neither shows; over a scan they are many times the noise.
#
# On the objects the comparison ends. A reference can name the wrap only where it errs by less than
# half a wrap; on the published objects its differences run through about a whole one within a
# single smooth surface. It is no truth for them, and the whole wraps of our own objects are no
# better known.

# %%
figure, columns = panels(3)
off_wraps = {}
for column, name in zip(columns, captures, strict=True):
    plotting.image(column[0], depths[name], label="depth (m)", title=f"{name}, {source}")
    turns = (depths[name] - references[name]) / wrap
    plotting.image(
        column[1],
        turns,
        label="minus reference (wraps)",
        cmap="RdBu_r",
        limits=(-1.5, 1.5),
    )
    object_turns = turns[~walls[name].mask & np.isfinite(turns)]
    off_wraps[name] = np.percentile(object_turns, [5, 95]).tolist()
    bins = np.linspace(-1.5, 1.5, 61)
    column[2].hist(turns[inside[name]], bins, density=True, color=blue, label="wall")
    column[2].hist(object_turns, bins, density=True, color=vermillion, alpha=0.6, label="objects")
    column[2].set(xlabel="minus reference (wraps)", yticks=[], xlim=(-1.5, 1.5))
    column[2].legend(loc="upper left", handlelength=1.0)
plotting.save(
    figure,
    "capture_depth",
    numbers={
        "source": source,
        "agreement": agreement,
        "object_off_wraps_5_95": off_wraps,
        "unwrapped_in_one_piece_wrong": misled,
    },
    caption=f"Depth from one frequency ({source}), its difference from the reference in wraps of "
    f"{1e3 * wrap:.2f} mm, and that difference's histogram. Grey: no coherent average, no depth.",
    alt="Depth maps of objects before a wall; difference maps that are pale on the wall and "
    "coloured "
    "on the objects; histograms, narrow for the wall and wide for the objects.",
    format="png",
)
widths = [high - low for low, high in off_wraps.values()]
tell(object_low=min(widths), object_high=max(widths))

# %% [markdown]
# Nine tenths of the objects' pixels spread over {glue:text}`object_low:.1f` to
# {glue:text}`object_high:.1f` wraps about the reference.
#
# ## From phase noise to micrometres
#
# Within a wrap $\sigma_z=c\,\sigma_\varphi/4\pi f$. What the paper reports, 33.5 µm, is a mirror
# and a plate on a motion stage; these are single points of a scan of a bust and its wall.

# %%
micrometres = {}
for name in captures:
    single = 1e6 * depth_from_phase(sigma[name], frequency)
    mean = 1e6 * depth_from_phase(after[name], frequency)
    micrometres[name] = (float(single), float(mean))
    print(f"{name}: {single:.0f} µm a point, {mean:.0f} µm after averaging {window}×{window}")
tell(
    single_low=min(v[0] for v in micrometres.values()),
    single_high=max(v[0] for v in micrometres.values()),
    mean_low=min(v[1] for v in micrometres.values()),
    mean_high=max(v[1] for v in micrometres.values()),
)

# %% [markdown]
# One point is known to {glue:text}`single_low:.0f` to {glue:text}`single_high:.0f` µm within its
# wrap, a window of averaged points to {glue:text}`mean_low:.0f` to {glue:text}`mean_high:.0f` µm.
#
# ## The surface
#
# With the wall's camera each depth is a point in space. Pixels without a coherent average are left
# out, and the mesh is cut open where neighbours lie more than a centimetre and a half apart.

# %%
shown = list(captures)[:stills]
figure, axes = plt.subplots(
    1, len(shown), figsize=(4.6 * len(shown) + 0.6 * (len(shown) == 1), 5.2), squeeze=False
)
drawn_by = []
for ax, name in zip(axes[0], shown, strict=True):
    points = points_from_depth(depths[name], walls[name].camera)
    with tempfile.TemporaryDirectory() as folder:
        still = Path(folder) / "still.png"
        done = views.render_surface(
            points, depths[name], still, longest=0.015, eye=(-0.12, -0.1, -0.02), cmap="cividis_r"
        )
        drawn_by.append(done)
        if done:
            ax.imshow(plt.imread(still), interpolation="antialiased")
            ax.axis("off")
    ax.set_title(f"{name}, {source}")
    ax.set_anchor("N")
if not all(drawn_by):  # no OpenGL here: shaded relief of the same surface
    from matplotlib.colors import LightSource

    for ax, name in zip(axes[0], shown, strict=True):
        light = LightSource(azdeg=315, altdeg=40)
        relief = np.nan_to_num(-depths[name], nan=float(-np.nanmax(depths[name])))
        ax.imshow(light.shade(relief, plt.get_cmap("cividis"), vert_exag=300, blend_mode="soft"))
        ax.axis("off")
plotting.save(
    figure,
    "capture_surface",
    numbers={
        "source": source,
        "noise_um": {name: list(pair) for name, pair in micrometres.items()},
    },
    caption=f"The recovered surface ({source}): 7.15 GHz phase, averaged, unwrapped, and placed in "
    "space by the camera that the wall's bend tells. Yellow is near. Holes are pixels whose "
    "average "
    "is incoherent.",
    alt="Shaded three-dimensional still of the scanned object standing out from a smooth wall.",
    format="png",
)
