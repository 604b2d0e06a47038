# %% [markdown]
# # Rooms from a seed
#
# To simulate a measurement one needs a scene whose range is known to a fraction of a wrap, and to
# train a network one needs thousands. The paper takes them from Hypersim
# {cite}`roberts2021hypersim`, 1.9 TB of rendered interiors that not everybody can fetch, and whose
# depth is stored too coarsely for gigahertz phases, as the end of this page shows. So this book
# also builds its own: a seed draws a floor plan, a household that chose its furniture together,
# what lies about on every table, lamps, windows and the sun; Embree {cite}`wald2014` sends the
# rays. Whoever has Hypersim reads it with the same loader.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of the set of rooms
scenes: int = 12  # rooms
views: int = 5  # views of each
height: int = 256  # of a view, px
width: int = 384
focal: float = 443.4  # px: that of the path-traced frames, seen at every second pixel

# %%
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from myst_nb import glue

from cmtof.book import plotting
from cmtof.constants import FREQUENCIES, FREQUENCY_SINGLE
from cmtof.correlation import phase_from_depth
from cmtof.scenes import load_frame
from cmtof.scenes.captures import data_root
from cmtof.scenes.frame import Frame, brightness, rays_from_camera, tone_mapped
from cmtof.scenes.half_precision import float16_phase, float16_step, smoothed_within_step
from cmtof.scenes.rooms.rendering import Settings, rendered_views
from cmtof.scenes.statistics import (
    HYPERSIM_BRIGHTNESS,
    HYPERSIM_DEPTH,
    bends,
    cumulative,
    hardness,
    pooled,
)

paper_run = plotting.begin(profile=profile, seed=seed)
blue, vermillion, green = (plotting.PALETTE[k] for k in ("blue", "vermillion", "green"))

# %% [markdown]
# ## A look into many houses
#
# Cameras stand where a person could; one view in ten is taken from close to a thing, 0.5 to 1.2 m
# away. Light makes three bounces: lamps, windows and patches of sun are asked directly, the rest is
# gathered from the surfaces around. Intensities are linear; for the eye they go through Hypersim's
# tone map.

# %%
settings = Settings(seed, scenes, views, height, width, focal)
shown = list(rendered_views(settings))
kinds = [view.scene.kind for view in shown[::views]]
triangles = [len(view.scene.geometry.faces) for view in shown[::views]]
things = [len(view.scene.geometry.kinds) for view in shown[::views]]
print(f"{len(shown)} views, {min(triangles)} to {max(triangles)} triangles a room")
print(f"{min(things)} to {max(things)} things a room: {', '.join(sorted(set(kinds)))}")

# %% tags=["hide-input"]
small = [tone_mapped(view.picture.color[::2, ::2]) for view in shown]
rows = [np.concatenate(small[k : k + views], axis=1) for k in range(0, len(small), views)]
half = -(-len(rows) // 2)
columns = [np.concatenate(part) for part in (rows[:half], rows[half:]) if part]
sheet = np.concatenate([c for c in columns if len(c) == len(columns[0])], axis=1)
figure, ax = plt.subplots(figsize=(12, 12 * sheet.shape[0] / sheet.shape[1]))
ax.imshow(sheet, interpolation="antialiased")
ax.axis("off")
plotting.save(
    figure,
    "scenes_sheet",
    format="png",
    numbers={
        "triangles": [min(triangles), max(triangles)],
        "things": [min(things), max(things)],
        "mean_brightness": float(np.mean([brightness(v.picture.color).mean() for v in shown])),
    },
    caption=(
        f"{len(shown)} views of {len(kinds)} rooms, {views} of each side by side, simulated. "
        "Nothing in them was modelled by hand: plan, furniture and clutter follow from the seed."
    ),
    alt=(
        f"Contact sheet of {len(shown)} rendered interiors: {', '.join(sorted(set(kinds)))}; "
        "furnished rooms with windows, lamps, patterned floors, and a few close views of things."
    ),
)
glue("views", len(shown), display=False)
glue("rooms", len(kinds), display=False)
glue("triangles", float(np.mean(triangles)) / 1e3, display=False)
glue("things", float(np.mean(things)), display=False)

# %% [markdown]
# On average a room holds {glue:text}`things:.0f` things of {glue:text}`triangles:.0f` thousand
# triangles. `cmtof render` writes such sets to disk, in Hypersim's own layout but in single
# precision: colour, range, normal and the number of each thing. The same seed gives the same bytes.

# %%
one = shown[0]
exact = one.picture.depth
normal = (1 + one.picture.normal) / 2
numbers = np.where(one.picture.instance < 0, np.nan, (one.picture.instance * 37) % 61)

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 2, figsize=(10.4, 7.0))
for panel, picture, title in (
    (axes[0, 0], tone_mapped(one.picture.color), f"colour ({one.scene.kind})"),
    (axes[1, 0], normal, "normal, towards the camera"),
):
    panel.imshow(picture)
    panel.set(xticks=[], yticks=[], title=title)
    panel.grid(visible=False)
    panel.spines[:].set_visible(False)
plotting.image(axes[0, 1], exact, label="range along the ray (m)", title="range")
axes[1, 1].imshow(numbers, cmap="tab20", interpolation="nearest")
axes[1, 1].set(xticks=[], yticks=[], title="things, each a colour")
axes[1, 1].grid(visible=False)
axes[1, 1].spines[:].set_visible(False)
plotting.label_panels([axes[0, 0], axes[0, 1], axes[1, 0], axes[1, 1]])
depths = [float(v) for v in np.nanpercentile(exact, [5, 50, 95])]
plotting.save(
    figure,
    "scenes_layers",
    format="png",
    numbers={"range_5_50_95_m": depths, "things_seen": int(np.unique(one.picture.instance).size)},
    caption=(
        "What is stored of each view: linear colour, range, normals, and which thing each pixel "
        "belongs to. Range is exact to the last bit of single precision."
    ),
    alt=(
        "Four panels of one view: the tone-mapped picture, its range from "
        f"{depths[0]:.1f} to {depths[2]:.1f} metres, normals as colours, and a map of "
        f"{np.unique(one.picture.instance).size} things in flat colours."
    ),
)

# %% [markdown]
# ## Are they like Hypersim's?
#
# Hypersim's pixels are known by their percentiles: brightness decides the noise, range the number
# of wraps. Exposure and the distances from which cameras look were set on rooms of other seeds so
# that both come near; the acceptance was 30 %. Brightness is Hypersim's, 0.30 R + 0.59 G + 0.11 B.

# %%
bright = np.concatenate([brightness(view.picture.color).ravel() for view in shown])
ranges = np.concatenate([view.frame.depth[np.isfinite(view.frame.depth)] for view in shown])
ours_bright = {at: float(np.percentile(bright, at)) for at in HYPERSIM_BRIGHTNESS}
ours_depth = {at: float(np.percentile(ranges, at)) for at in HYPERSIM_DEPTH}
far = float(np.mean(ranges > 7.5))
table = ["|  | percentile | Hypersim | these rooms | ratio |", "| --- | --: | --: | --: | --: |"]
for name, theirs, ours in (
    ("brightness", HYPERSIM_BRIGHTNESS, ours_bright),
    ("range (m)", HYPERSIM_DEPTH, ours_depth),
):
    for at, value in theirs.items():
        table.append(f"| {name} | {at} | {value:.3g} | {ours[at]:.3g} | {ours[at] / value:.2f} |")
print("\n".join(table), f"\nbeyond 7.5 m: {far:.1%}")
glue("against_hypersim", Markdown("\n".join(table)), display=False)
within = [
    *(abs(ours_bright[at] / value - 1) for at, value in HYPERSIM_BRIGHTNESS.items()),
    *(abs(ours_depth[at] / HYPERSIM_DEPTH[at] - 1) for at in (5, 25, 50)),
]
glue("worst", 100 * max(within), display=False)
glue("kept", sum(w <= 0.3 for w in within), display=False)
glue("asked", len(within), display=False)
glue("far", 100 * far, display=False)

# %% [markdown]
# ```{glue:md} against_hypersim
# :format: myst
# ```
#
# Of the {glue:text}`asked` percentiles held to 30 % (brightness, and range up to the median),
# {glue:text}`kept` keep to it in this draw of {glue:text}`rooms` rooms; the largest departure is
# {glue:text}`worst:.0f` %. What differs on purpose is the far end: {glue:text}`far:.1f` % of these
# pixels lie beyond the 7.5 m that two frequencies can tell apart, where Hypersim, with its halls
# and terraces, has a quarter.
#
# ## What makes unwrapping hard
#
# Not range itself but its changes. Within a surface a method may follow depth from pixel to pixel;
# the steeper it runs, the fewer pixels it may average. Where a surface ends it must start anew, and
# has only that surface's pixels to find the wrap. So three quantities matter: the slope within
# surfaces, the jump between them, and the size of the surface that a pixel lies in. Beside them
# stand those of path-traced frames of one furnished room, made by others, at every second pixel to
# match the lens; they serve for looking only.

# %%
hard = pooled(hardness(view.frame) for view in shown)
root = data_root()
files = sorted(root.glob("frames/*.npz")) if root else []


def thinned(frame):
    """Every second pixel: half the focal length at the same field of view."""
    return Frame(frame.depth[::2, ::2], frame.intensity[::2, ::2], None, frame.name)


theirs = pooled(hardness(thinned(load_frame(file))) for file in files) if files else None
quantities = {
    "slope within a surface\n(wraps a pixel)": ("slope", np.geomspace(1e-3, 10, 200)),
    "jump at its end\n(wraps)": ("jump", np.geomspace(0.19, 500, 200)),
    "size of a pixel's surface\n(pixels)": ("patch", np.geomspace(1, 1e5, 200)),
}
for label, (name, _) in quantities.items():
    print(label.split("\n")[0], "median", f"{np.median(getattr(hard, name)):.3g}")

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 3, figsize=(11.4, 3.8), sharey=True)
for ax, (label, (name, at)) in zip(axes, quantities.items(), strict=True):
    ax.plot(at, cumulative(getattr(hard, name), at), color=blue, label="rooms")
    if theirs is not None:
        ax.plot(at, cumulative(getattr(theirs, name), at), color=vermillion, ls="--",
                label="path-traced frames")  # fmt: skip
    ax.set(xscale="log", xlabel=label, ylim=(0, 1))
axes[0].axvline(0.5, color="#8A97A3", lw=1)
axes[0].set_ylabel("share of pixels at or below")
axes[0].legend(loc="upper left")
plotting.label_panels(axes)
medians = {name: float(np.median(getattr(hard, name))) for name in ("slope", "jump", "patch")}
steep = float(np.mean(hard.slope > 0.5))
beside = ""
if theirs is not None:
    beside = f" The frames' medians: {np.median(theirs.slope):.3f}, {np.median(theirs.jump):.1f} "
    beside += f"and {np.median(theirs.patch):.0f}."
plotting.save(
    figure,
    "scenes_hardness",
    numbers={"median": medians, "steeper_than_half_a_wrap": steep},
    caption=(
        "What makes unwrapping hard, pooled over all pixels, in wraps of 7.15 GHz (20.97 mm). The "
        "grey line is half a wrap a pixel, beyond which neighbours no longer tell the direction."
    ),
    alt=(
        "Three cumulative curves on logarithmic axes for rooms"
        + (" and path-traced frames" if theirs is not None else "")
        + f": slope, median {medians['slope']:.3f} wraps a pixel; jump, median "
        f"{medians['jump']:.1f} wraps; surface size, median {medians['patch']:.0f} pixels." + beside
    ),
)
for name, value in medians.items():
    glue(f"median_{name}", value, display=False)
glue("steep", 100 * steep, display=False)

# %% [markdown]
# The median pixel of these rooms lies in a surface of {glue:text}`median_patch:.0f` pixels whose
# depth changes by {glue:text}`median_slope:.3f` wraps a pixel; at its end depth jumps by
# {glue:text}`median_jump:.1f` wraps in the median. {glue:text}`steep:.2f` % of neighbours differ by
# more than half a wrap: there no method can count by neighbours alone. Many small surfaces, from
# clutter and thin things, are what tells these rooms from an empty one.
#
# ## What half precision does to a plane
#
# Hypersim stores range as 16-bit floating point, with 11 bits for the number: from each power of
# two on, its steps are twice as wide. Rounded like that, a plane becomes a staircase, and its phase
# with it. A network trained on it may learn stairs.

# %%
distance = np.array([1.5, 3.0, 6.0])
for z, step in zip(distance, float16_step(distance), strict=True):
    turn = [float(float16_phase(z, f)) for f in FREQUENCIES]
    print(f"at {z:.1f} m: steps of {1e3 * step:.2f} mm, {turn[0]:.2f} and {turn[1]:.2f} rad")
stored = exact.astype(np.float16)
mended = smoothed_within_step(stored)
flat = ~bends(exact) & np.isfinite(exact)
errors = {}
for name, depth in (("half precision", stored.astype(float)), ("smoothed within its step", mended)):
    off = depth - exact.astype(float)
    errors[name] = float(np.sqrt(np.mean(phase_from_depth(off[flat], FREQUENCY_SINGLE) ** 2)))
    print(f"{name}: {errors[name]:.3f} rad rms at 7.15 GHz on surfaces")
span = np.nanmax(np.abs(mended - stored.astype(float)) / float16_step(exact))
print(f"smoothing moved no pixel by more than {span:.2f} of its step")

# %% tags=["hide-input"]
rays = rays_from_camera((64, 96), [886.8, 886.8, -300, 32])
plane = np.linalg.norm(rays, axis=-1) * 3 / (rays @ [0.3, 0.1, 1])  # 3 m before the camera
coarse = plane.astype(np.float16)
maps = {"exact": plane, "half precision": coarse, "smoothed": smoothed_within_step(coarse)}
figure, axes = plt.subplots(1, 3, figsize=(11.4, 3.0))
for panel, (name, depth) in zip(axes, maps.items(), strict=True):
    phase = phase_from_depth(np.asarray(depth, float), FREQUENCIES[1]) % (2 * np.pi)
    plotting.phase_image(panel, phase, title=name)
plotting.label_panels(axes)
plotting.save(
    figure,
    "scenes_half_precision",
    format="png",
    numbers={"rms_rad": [errors["half precision"], errors["smoothed within its step"]]},
    caption=(
        "Phase at 14.32 GHz of a slanted plane from exact range, from the same range stored in "
        "half precision, and from that after smoothing within its own step."
    ),
    alt=(
        "Three phase maps of the same slanted plane: even bands of colour, then hard terraces of "
        "few colours, then even bands again."
    ),
)
glue("rms_half", errors["half precision"], display=False)
glue("rms_mended", errors["smoothed within its step"], display=False)
glue("gain", errors["half precision"] / errors["smoothed within its step"], display=False)
glue("step_far", 1e3 * float(float16_step(6.0)), display=False)
glue("turn_far", float(float16_phase(6.0, FREQUENCIES[1])), display=False)

# %% [markdown]
# At 6 m a step is {glue:text}`step_far:.1f` mm, {glue:text}`turn_far:.1f` rad at the upper
# frequency. On the surfaces of this view half precision alone puts {glue:text}`rms_half:.2f` rad of
# error on the lower phase, as much as the noise of the whole measurement. `Hypersim(root).frames(…,
# smooth=True)` draws a smooth surface through the middle of the steps, never leaving the rounding
# interval and never crossing an edge, which leaves {glue:text}`rms_mended:.3f` rad,
# {glue:text}`gain:.1f` times less; such frames say so in their note. Rooms are stored in single
# precision and need none of it.
