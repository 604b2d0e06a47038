# %% [markdown]
# # Rendered scenes
#
# A simulation needs scenes whose range is known to a fraction of a wrap; training needs thousands.
# Where do they come from?
#
# The paper uses Hypersim ([Roberts et al. 2021](../book/references.bib#roberts2021hypersim)), 1.9
# TB of rendered interiors whose depth is stored too coarsely for gigahertz phases. This book reads
# it, but uses rooms of its own, rendered from a seed.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of the set of rooms
scenes: int = 12  # rooms
views: int = 5  # views of each
height: int = 256  # of a view, px
width: int = 384
focal: float = 443.4  # px: that of the path-traced frames, seen at every second pixel

# %% tags=["hide-input"]
import numpy as np

from cmtof.captures import data_root
from cmtof.constants import FREQUENCIES, FREQUENCY_SINGLE
from cmtof.correlation import phase_from_depth
from cmtof.frame import brightness
from cmtof.hardness import bends, hardness
from cmtof.scenes import load_frame
from cmtof_book import notes, plotting
from cmtof_rooms.rendering import Settings, render_views

plotting.begin(profile=profile, seed=seed)


def tone_mapped(color):
    """Hypersim's tone map: the 90th percentile of brightness is shown at 0.8."""
    scale = 0.8**2.2 / max(np.percentile(brightness(color), 90), 1e-4)
    return np.clip(scale * np.maximum(color, 0), 0, 1) ** (1 / 2.2)


# %%
shown = list(render_views(Settings(seed, scenes, views, height, width, focal)))
interiors = [view.room.interior for view in shown[::views]]
triangles = [len(interior.faces) for interior in interiors]
things = [len(interior.things) for interior in interiors]
print(
    f"{len(shown)} views of {scenes} rooms: {min(things)} to {max(things)} things and\n"
    f"{min(triangles)} to {max(triangles)} triangles a room"
)

# %% tags=["hide-input"]
firsts = shown[::views][:12]
figure, axes = plotting.grid(len(firsts), 3, height / width)
for ax, view in zip(axes, firsts, strict=True):
    plotting.image(ax, tone_mapped(view.picture.color), label="", bar=False)
plotting.save(
    figure,
    "scenes_sheet",
    format="png",
    caption="Rooms rendered from a seed, one view of each.",
    alt="Rendered interiors: furnished rooms with windows, lamps and patterns.",
)

# %% [markdown]
# A seed determines floor plan, furniture, objects, lamps, windows and the sun; Embree
# ([Wald et al. 2014](../book/references.bib#wald2014)) traces the rays. Cameras stand where a
# person could; one view in ten is a close view of an object. Intensities are linear. `cmtof render`
# writes such sets to disk in Hypersim's own layout; the same seed gives the same bytes. Range is
# exact to single precision.

# %% [markdown]
# ## Beside Hypersim
#
# Only percentiles of Hypersim are compared. They are given here, not computed: its frames are not
# part of this repository. Brightness is Hypersim's, 0.30 R + 0.59 G + 0.11 B, and stands for the
# noise, which follows from green alone ([chapter 5](05_simulation.ipynb)). Range determines the
# number of wraps.

# %% tags=["hide-input"]
HYPERSIM = {
    "brightness": {5: 0.010, 25: 0.08, 50: 0.27, 75: 0.70, 90: 1.6},
    "range (m)": {5: 1.27, 25: 3.0, 50: 4.8, 75: 7.8, 95: 23.0},
}
ours = {
    "brightness": np.concatenate(
        [brightness(view.picture.color).ravel() for view in shown]
    ),
    "range (m)": np.concatenate([view.frame.depth.ravel() for view in shown]),
}
rows = []
for name, published in HYPERSIM.items():
    found = np.nanpercentile(ours[name], list(published))
    for (at, value), mine in zip(published.items(), found, strict=True):
        rows.append(
            [f"{name}, {at} %", f"{value:.3g}", f"{mine:.3g}", f"{mine / value:.2f}"]
        )
notes.table(["percentile", "Hypersim", "these rooms", "ratio"], rows)
print(f"beyond 7.5 m: {np.mean(ours['range (m)'] > 7.5):.0%} of the pixels")

# %% [markdown]
# Two frequencies are unambiguous up to 7.5 m; in Hypersim, with halls and terraces, a quarter of
# the pixels lies beyond.
#
# ## Difficulty of a scene
#
# The difficulty depends on changes of range. The steeper a surface, the fewer of its pixels can be
# averaged. Beyond half a wrap a pixel the sign of a slope is ambiguous. Where a surface ends, a
# method must start again, with only the next surface's pixels to find the wrap. Where the machine
# has them, path-traced frames of one furnished room, made by others, are compared, at every second
# pixel to match the lens. The generator of the rooms was tuned with a view to the slopes, jumps and
# surface sizes of these frames. Their agreement below is therefore no independent test.

# %% tags=["hide-input"]
root = data_root()
files = sorted(root.glob("frames/*.npz")) if root else []
sets = {"rooms": [view.frame.depth for view in shown]}
if files:
    sets["path-traced frames"] = [load_frame(file).depth[::2, ::2] for file in files]
samples = {
    name: [np.concatenate(part) for part in zip(*map(hardness, depths), strict=True)]
    for name, depths in sets.items()
}
labels = (
    "slope within a surface (wraps/px)",
    "jump at its end (wraps)",
    "its size (px)",
)
medians = {name: [np.median(part) for part in parts] for name, parts in samples.items()}
steep = np.mean(samples["rooms"][0] > 0.5)
rows = [
    [k, *(f"{v[i]:.{i + 3}g}" for v in medians.values())] for i, k in enumerate(labels)
]
notes.table(["median", *medians], rows)
print(f"{steep:.1%} of neighbours in rooms differ by more than half a wrap")

# %% [markdown]
# ## Half precision
#
# Hypersim stores range as 16-bit floating point: its steps double at each power of two. A plane
# becomes a staircase, which a network may learn. Rooms are stored in single precision.

# %%
distance = np.array([1.5, 3.0, 6.0], np.float16)
steps = np.spacing(distance).astype(float)
for z, step in zip(distance, steps, strict=True):
    turns = phase_from_depth(step, FREQUENCIES)
    print(
        f"at {z:.1f} m: steps of {1e3 * step:.2f} mm, {turns[0]:.2f} and {turns[1]:.2f} rad"
    )
exact = shown[0].picture.depth
off = exact.astype(np.float16).astype(float) - exact
flat = ~bends(exact) & np.isfinite(exact)
rms = np.sqrt(np.mean(phase_from_depth(off[flat], FREQUENCY_SINGLE) ** 2))
print(f"on the surfaces of one view {rms:.3f} rad rms at 7.15 GHz")

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** Furnished rooms drawn at random, ray-traced; ranges are computed in double
    precision and stored in single. Their median pixel lies in a surface of {size:,.0f} pixels whose
    range changes by {slope:.3f} wraps a pixel. The depth that Hypersim stores would add {rms:.2f}
    rad of phase error.
    """,
    size=medians["rooms"][2],
    slope=medians["rooms"][0],
    rms=rms,
)
