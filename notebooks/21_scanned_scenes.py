# %% [markdown]
# # Scanned scenes
#
# A bust, a helmet, an owl and a cluttered table stand a metre before the simulated instrument, and
# are scanned as the paper's scenes were (Paper Figs. 1 and 16). The phases are good to some ten
# micrometres; the wraps decide. Over all scenes `surfaces`, the method of this book, finds
# {glue:text}`ours:.0f` % of them and KDE {glue:text}`kde:.0f` %; after RF demodulation no phase is
# left. The objects are meshes of ours, so every true range is known. Nothing here was measured, and
# the simulated instrument has less noise than the published captures ({doc}`07_captures`).

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of the simulated instrument: speckle, noise, drift
objects: list = ["bust", "helmet", "owl", "table"]  # scenes
size: int = 80  # height and width of the scans, px
picture_size: int = 240  # of the rendered pictures, px
room_light: float = 1.0  # radiance in the bright room, W/(m^2 sr); 0.1 otherwise
teaser: str = "bust"  # scene of Paper Fig. 1

# %% tags=["hide-input"]
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import cmtof
from cmtof.book import notes, plotting, views
from cmtof.correlation import TAU, centred, phase_from_depth, wrap_length
from cmtof.evaluation import score, scored_pixels
from cmtof.hardware.scan import scan_scene
from cmtof.instrument.optics import directions_from_angles
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import scene_from
from cmtof.methods import METHODS
from cmtof.pointcloud import normals_from_points, points_from_depth
from cmtof.ranging.rf import RfRanger, rf_image
from cmtof.scenes.frame import rays_from_camera
from cmtof.scenes.objects import FIELD_OF_VIEW

plotting.begin(profile=profile, seed=seed)

# %% [markdown]
# ## Scans and methods
#
# Each scene is scanned three times: in the ordinary room; under strong room light, a white wall in
# some 1500 lux; and without any noise of light, amplifier and converter. A point takes 16 phases in
# 13.3 ms, in both modes ({doc}`15_scan`). Every method has the whole range to choose from, 0 to
# 7.5 m. The networks stand beside them once their weights do better than a trivial answer on
# simulated rooms ({doc}`08_network`); untrained ones are left out.

# %%
ordinary = TwinSettings()
rooms = {
    "ordinary": ordinary,
    "bright room": replace(ordinary, ambient_radiance=room_light),
    "no noise": replace(ordinary, noise=False),
}
scenes = {name: scene_from({"kind": "object", "name": name}) for name in objects}
scans = {
    (name, room): scan_scene(
        settings, scenes[name], size=size, field_of_view=FIELD_OF_VIEW[name], seed=seed
    )
    for name in objects
    for room, settings in rooms.items()
}
first = scans[objects[0], "ordinary"]
index = float(first.dataset.attrs["group_index"])
period = float(wrap_length(first.frequencies[0])) / index
truth = {name: scans[name, "ordinary"].depth / index for name in objects}
camera = {name: scans[name, "ordinary"].camera for name in objects}
limits = {name: (float(np.nanmin(z)), float(np.nanmax(z))) for name, z in truth.items()}

# %%
networks = [n for n in ("rapid", "fast-scnn") if METHODS[n].state("full") == "trained"]
names = ["kde", "crt-ml", "region", *networks, "surfaces"]
answers = {
    (*key, method): cmtof.unwrap(scan, method=method)
    for key, scan in scans.items()
    for method in names
}
scores = {key: score(scored_pixels(answer, scans[key[:2]])) for key, answer in answers.items()}
right = {key: 100 * one["delta_lt_1"] for key, one in scores.items()}
mean = {
    room: {m: float(np.mean([right[n, room, m] for n in objects])) for m in names} for room in rooms
}
best = {  # of the least error: a few pixels off by many wraps spoil a shape more than many by one
    n: min(names, key=lambda m: scores[n, "ordinary", m]["depth_rmse_m"]) for n in objects
}
notes.tell(ours=mean["ordinary"]["surfaces"], kde=mean["ordinary"]["kde"])
rows = [(n, *(f"{right[n, 'ordinary', m]:.0f}" for m in names)) for n in objects]
rows += [(f"mean, {room}", *(f"{mean[room][m]:.0f}" for m in names)) for room in rooms]
notes.table(("right wraps (%)", *names), rows)


# %% tags=["hide-input"]
def picture(name):
    """Grey rendering of a scene: a lamp above the instrument, to its left, and a pale ceiling."""
    focal, lamp = picture_size / 2 / np.tan(FIELD_OF_VIEW[name] / 2), np.array([-0.7, -0.9, -0.1])
    eye = [focal, focal, picture_size / 2, picture_size / 2]
    rays = rays_from_camera((picture_size, picture_size), eye)
    rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    hits = scenes[name].look(rays)
    points = points_from_depth(hits.range, eye)
    normal, way = normals_from_points(points), lamp - points
    far = np.linalg.norm(way, axis=-1)
    shade = scenes[name].hidden(np.nan_to_num(points), lamp)
    lit = np.clip((normal * way).sum(-1) / far**3, 0, None) * ~shade
    up = -(rays - 2 * (rays * normal).sum(-1, keepdims=True) * normal)[..., 1]
    mirrored = hits.mirrored * 0.3 * (1 + np.tanh(3 * up))
    grey = hits.reflectance * ((1 - hits.mirrored) * (lit + 0.3) + mirrored)
    return np.clip(np.nan_to_num(grey) / np.nanpercentile(grey, 99.5), 0, 1) ** (1 / 2.2)


def depth_of(name, method):
    return answers[name, "ordinary", method]["depth"].to_numpy() / index


def wraps_off(name, method):
    return np.rint((depth_of(name, method) - truth[name]) / period)


def normals_of(name, depth):
    return normals_from_points(points_from_depth(depth, camera[name]))


def bare(ax, colours, title):
    """Image of colours, or of greys from 0 to 1, without axes."""
    ax.imshow(np.clip(colours, 0, 1), cmap="gray", vmin=0, vmax=1)
    ax.set_title(title)
    ax.axis("off")


pictures = {name: picture(name) for name in objects}
TONES = [f"{f / 1e9:.2f} GHz" for f in first.frequencies]

# %% [markdown]
# ## In one picture
#
# The teaser of the paper (Paper Fig. 1): fringes of two wrapped phases become a surface.

# %% tags=["hide-input"]
stills, flat, residual, tilt = {}, {}, {}, {}
for name in objects:
    depth = depth_of(name, best[name])
    shades = plt.cm.ScalarMappable(plt.Normalize(*limits[name]), "cividis_r")
    flat[name] = shades.to_rgba(depth)[..., :3]
    points, off = points_from_depth(depth, camera[name]), np.abs(wraps_off(name, best[name]))
    wraps = plt.get_cmap("YlOrRd")(np.nan_to_num(off) / 10)[..., :3]
    true_points = points_from_depth(truth[name], camera[name])
    layers = {"depth": (points, flat[name]), "wraps off": (points, wraps)}
    layers["truth"] = (true_points, shades.to_rgba(truth[name])[..., :3])
    stills[name] = views.save_scene(
        f"scene_{name}",
        layers,
        longest=3 * FIELD_OF_VIEW[name] / size,  # three pitches of the points at 1 m
        eye=(-0.3, -0.22, -0.1),
    )
    left = depth - truth[name] - wraps_off(name, best[name]) * period
    residual[name] = 1e6 * float(np.nanmedian(np.abs(left)))
    cosine = (normals_of(name, depth) * normals_of(name, truth[name])).sum(-1)
    fine = wraps_off(name, best[name]) == 0
    tilt[name] = float(np.rad2deg(np.median(np.arccos(np.clip(cosine[fine], -1, 1)))))


def still(ax, name, title):
    """Shaded surface of a scene, or its depth in the same colours where none can be drawn."""
    bare(ax, flat[name] if stills[name] is None else stills[name], title)


# %% tags=["hide-input"]
figure, grid = plt.subplots(2, 3, figsize=(10.4, 6.2))
axes = list(grid.ravel())
bare(axes[0], pictures[teaser], teaser)
for ax, phase, tone in zip(axes[1:3], scans[teaser, "ordinary"].phase, TONES, strict=True):
    plotting.phase_image(ax, np.mod(phase, TAU), title=tone)
depth = depth_of(teaser, best[teaser])
plotting.image(axes[3], depth, label="range (m)", title="depth", limits=limits[teaser])
bare(axes[4], (1 + normals_of(teaser, depth) * [1, -1, -1]) / 2, "normals")
still(axes[5], teaser, "in space")
plotting.label_panels(axes)
plotting.save(
    figure,
    "fig01_teaser",
    numbers={
        "right_percent": right[teaser, "ordinary", best[teaser]],
        "residual_um": residual[teaser],
        "normals_deg": tilt[teaser],
    },
    caption=(
        f"From centimetre waves to shape, simulated: (a) a rendering of the "
        f"{teaser}, (b, c) both wrapped phases, (d) depth by the method `{best[teaser]}`, not by "
        "the paper's network, (e) its normals, (f) the surface."
    ),
    alt=(
        f"Six images: the rendered {teaser}, fringes of two wrapped phases, the depth with "
        f"{right[teaser, 'ordinary', best[teaser]]:.0f} % of right wraps, coloured normals, and a "
        "shaded surface in space."
    ),
    format="png",
)

# %% [markdown]
# ## RF demodulation
#
# The same light on the fast photodiode, demodulated after photo-conversion: each pixel's power goes
# to the photodiode for the same 13.3 ms, and offsets and imbalance count as calibrated away.

# %%
phase_error, rf, rf_rms = {}, {}, {}
for (name, room), scan in scans.items():
    low, high = (
        centred(phase - phase_from_depth(index * truth[name], f))
        for phase, f in zip(scan.phase, scan.frequencies, strict=True)
    )
    phase_error[name, room] = 1e3 * float(np.nanmedian(np.abs(centred(high - 2 * low))))
for name in objects:
    angles = scans[name, "ordinary"].dataset["angle"].to_numpy()
    rf[name], *_ = rf_image(RfRanger(settings=ordinary), scenes[name], angles, seed=seed)
    off = centred(rf[name] - phase_from_depth(index * truth[name], first.frequencies[0]))
    rf_rms[name] = float(np.sqrt(np.nanmean(off**2)))
notes.table(
    ("scene", "amplitude (mV)", *(f"beat, {room} (mrad)" for room in rooms), "RF phase (rad rms)"),
    [(n, f"{1e3 * np.median(scans[n, 'ordinary'].amplitude[0]):.0f}",
      *(f"{phase_error[n, room]:.1f}" for room in rooms), f"{rf_rms[n]:.2f}") for n in objects],
)  # fmt: skip

# %% [markdown]
# A phase without any information has an rms error of 1.81 rad. The errors of the beat of both
# phases are medians; a whole wrap is 17.6 mrad of it, and more than half of that in a pixel is a
# wrong wrap. What is left without noise comes from the spot's size, its speckle, reflections within
# the instrument and the calibration. Polished steel mirrors nearly all light away, so the phases of
# the helmet rest on a faint diffuse remainder.
#
# ## The scenes
#
# In place of a photograph stands a rendering of the mesh. Depths have the colours of the truth;
# what lies outside takes the colour at its end.

# %% tags=["hide-input"]
COMPARED = ["kde", networks[0] if networks else "region", "surfaces"]
ABOUT = {
    "bust": "plaster, diffuse and bright",
    "helmet": "polished steel with slits and holes",
    "owl": "pale and dark plumage",
    "table": "a cluttered table of many materials",
}


def drawn(name):
    """Paper Fig. 16 of one scene."""
    scan = scans[name, "ordinary"]
    figure, grid = plt.subplots(3, 4, figsize=(12.4, 8.8))
    axes = list(grid.ravel())
    bare(axes[0], pictures[name], "rendering")
    for ax, amplitude, tone in zip(axes[1:3], scan.amplitude, TONES, strict=True):
        plotting.image(ax, 1e3 * amplitude, label="amplitude (mV)", title=tone,
                       limits=(0, 1e3 * float(np.percentile(amplitude, 98))))  # fmt: skip
    plotting.image(axes[3], truth[name], label="range (m)", title="truth", limits=limits[name])
    phases = (*scan.phase, rf[name])
    for ax, phase, title in zip(axes[4:7], phases, (*TONES, f"RF, {TONES[0]}"), strict=True):
        plotting.phase_image(ax, np.mod(phase, TAU), title=title)
    normals = normals_of(name, depth_of(name, best[name]))
    bare(axes[7], (1 + normals * [1, -1, -1]) / 2, f"normals, {best[name]}")
    for ax, m in zip(axes[8:11], COMPARED, strict=True):
        plotting.image(ax, depth_of(name, m), label="range (m)", limits=limits[name],
                       title=f"{m}, {right[name, 'ordinary', m]:.0f} %")  # fmt: skip
    plotting.image(axes[11], wraps_off(name, "surfaces"), label="wraps", cmap="coolwarm",
                   title="surfaces, off by", limits=(-5, 5))  # fmt: skip
    plotting.label_panels(axes)
    return figure


# %% tags=["hide-input"]
for name in objects:
    shares = {m: right[name, "ordinary", m] for m in names}
    plotting.save(
        drawn(name),
        f"fig16_{name}",
        numbers={
            "right_percent": shares,
            "right_percent_bright": {m: right[name, "bright room", m] for m in names},
            "right_percent_no_noise": {m: right[name, "no noise", m] for m in names},
            "rmse_mm": {m: 1e3 * scores[name, "ordinary", m]["depth_rmse_m"] for m in names},
            "residual_um": residual[name],
            "normals_deg": tilt[name],
            "beat_error_mrad": phase_error[name, "ordinary"],
            "rf_rms_rad": rf_rms[name],
        },
        caption=(
            f"{name.capitalize()}: {ABOUT[name]}, simulated scan of {size} × {size} points. "
            "(a) Rendering. (b, c) Amplitude. (d) True range. (e, f) Wrapped phase. (g) Phase "
            f"after RF demodulation. (h) Normals of the depth by `{best[name]}`. (i–k) Depth, "
            "with the share of right wraps. (l) Whole wraps by which `surfaces` is off."
        ),
        alt=(
            f"Twelve images of the {name}. The amplitudes are grainy, the wrapped phases run in "
            "fringes over the scene, the RF phase is noise. Right wraps: "
            + ", ".join(f"{m} {shares[m]:.0f} %" for m in COMPARED)
            + "."
        ),
        format="png",
    )

# %% [markdown]
# ## What works, and what fails
#
# Each pixel is put into the first class that holds: at an edge, where a neighbour lies more than
# half a wrap nearer or farther, be it an outline or a steep slope; polished, where most of the
# light is mirrored away; dark, with a reflectance below 0.1; or the rest.

# %%
CLASSES = ("edge", "polished", "dark", "rest")


def classes_of(name):
    """Class (H, W) of each pixel, by what stands there."""
    hits = scenes[name].look(
        directions_from_angles(scans[name, "ordinary"].dataset["angle"].to_numpy())
    )
    around = np.lib.stride_tricks.sliding_window_view(np.pad(truth[name], 1, mode="edge"), (3, 3))
    step = np.abs(around - truth[name][..., None, None]).max((2, 3))
    tests = [step > period / 2, hits.mirrored * np.ones(step.shape) > 0.5, hits.reflectance < 0.1]
    return np.select(tests, CLASSES[:3], CLASSES[3])


kinds = np.concatenate([classes_of(n).ravel() for n in objects])
hit = {m: np.concatenate([wraps_off(n, m).ravel() == 0 for n in objects]) for m in names}
found = [kind for kind in CLASSES if (kinds == kind).any()]
of_class = {k: {m: 100 * float(hit[m][kinds == k].mean()) for m in names} for k in found}
share = {kind: 100 * float((kinds == kind).mean()) for kind in found}

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(10.4, 3.7), sharey=True)
plotting.bars(axes[0], {m: [right[n, "ordinary", m] for n in objects] for m in names}, objects)
plotting.bars(axes[1], {m: [of_class[k][m] for k in found] for m in names},
              [f"{k}, {share[k]:.0f} %" for k in found])  # fmt: skip
axes[0].set(ylabel="right wraps (%)", title="by scene", ylim=(0, 100))
axes[1].set_title("by what stands there, with its share")
figure.legend(*axes[0].get_legend_handles_labels(), ncols=6, loc="outside lower center")
plotting.label_panels(axes)
plotting.save(
    figure,
    "fig16_scenes",
    numbers={
        "right_percent": mean["ordinary"],
        "right_percent_bright": mean["bright room"],
        "right_percent_no_noise": mean["no noise"],
        "classes_percent": of_class,
        "class_share_percent": share,
        "beat_error_mrad": {f"{n}, {room}": e for (n, room), e in phase_error.items()},
        "rf_rms_rad": rf_rms,
    },
    caption="Pixels with the right wrap, (a) by scene and (b) by what stands there; simulated.",
    alt=(
        "Bars of right wraps. On average over the scenes: "
        + ", ".join(f"{m} {mean['ordinary'][m]:.0f} %" for m in names)
        + "."
    ),
)

# %% [markdown]
# Edges fail for all methods: where the spot lies across an outline, the phases of both modes are
# those of neither surface, and the neighbours have other wraps, so that pooling misleads. `crt-ml`
# pools nothing; what it gains without noise is what noise costs. KDE struggles on the paper's
# scenes and does well on these, whose noise is lower. `surfaces` decides for a surface as a whole,
# so a wrong decision costs many pixels at once.
#
# ## In space
#
# Each scene in space: the depth of least error, in colours of the range or of the wraps that it is
# off (pale is right), and the truth. Neighbours are joined only where they lie close, so a pixel
# with a wrong wrap leaves a hole, and a patch floats before or behind its place.

# %% tags=["remove-input"]
for name in objects:
    views.show_scene(f"scene_{name}", title=f"the {name}")
