# %% [markdown]
# # Stereo supervision
#
# Fine-tuning a network on scans ([chapter 21](21_scanned_scenes.ipynb)) needs the wrap count of
# each pixel. Can two cameras beside the scanner measure it (Section 6.4)?
#
# They triangulate the scanner's laser spot. A label that is off by 10 mm is wrong by half a wrap.
# Everything here is simulated; the paper shows one scan and no numbers.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of every random draw
scene: str = "books"  # object that is scanned, one that the network learns from
far_scene: str = "room"  # embedded frame for what lies farther away
size: int = 120  # height and width of the scan, px
far_stride: int = 4  # every how many pixels of that frame are scanned
baseline: float = 0.3  # between the cameras, m; assumed
sigmas: float = 3.0  # standard deviations of a range that must fit
views: int = 12  # of the board
print_error: float = 0.06  # px, of a corner: picture and printed board; assumed
draws: int = 12  # calibrations redrawn for the uncertainty

# %% tags=["hide-input"]

import matplotlib.pyplot as plt
import numpy as np

import cmtof
from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import residual_noise, wrap_length
from cmtof.frame import Frame
from cmtof.pointcloud import points_from_depth
from cmtof.scenes import load_frame
from cmtof_book import notes, paper, plotting
from cmtof_book.scanned import frame_of, scan_object
from cmtof_lab import stereo
from cmtof_lab.targets import scene_from

plotting.begin(profile=profile, seed=seed)
rng = np.random.default_rng(seed)
WRAP = wrap_length(FREQUENCY_SINGLE)
LEFT = "C0"
RIGHT = "C1"

# %% [markdown]
# ## The labels of one scan
#
# Views of a checkerboard calibrate both cameras. The spots of the scan locate the scanner, whose
# beams leave in known directions, like a third camera.

# %% tags=["hide-input"]
sensor = stereo.Sensor()
rig = stereo.simulated_rig(baseline=baseline, sensor=sensor)
poses = stereo.board_poses(rig, views, rng=rng)
corners = np.stack([rig.project(pose.apply(stereo.BOARD)) for pose in poses], axis=1)
corners += print_error * rng.standard_normal(corners.shape)
cameras, corner_noise = stereo.calibrate(corners, rig.shape)
redrawn = [
    stereo.calibrate(
        corners + corner_noise * rng.standard_normal(corners.shape), rig.shape
    )[0]
    for _ in range(draws)
]
print(f"{views} views leave {corner_noise:.3f} px at a corner")


# %% tags=["hide-input"]
def thinned(name, stride):
    """Every so many pixels of an embedded frame, as a scan would take them."""
    whole = load_frame(name)
    fx, fy, cx, cy = whole.camera
    camera = [
        fx / stride,
        fy / stride,
        (cx - 0.5) / stride + 0.5,
        (cy - 0.5) / stride + 0.5,
    ]
    return Frame(
        whole.depth[::stride, ::stride],
        whole.intensity[::stride, ::stride],
        camera,
        name,
    )


def measured_phase(measurement):
    """Wrapped phase of the low frequency and its standard deviation, rad."""
    images, psi = (measurement.dataset[k].to_numpy()[0] for k in ("correlation", "psi"))
    noise = residual_noise(images, psi) * np.sqrt(2 / psi.size)
    noise = noise / np.maximum(measurement.amplitude[0], 1e-6)
    return {"phase": measurement.phase[0], "phase_noise": noise}


def labels(frame, spots, cameras, others=(), **phase):
    """Pseudo ground truth of a scan by calibrated cameras, the scanner found from its spots."""
    beams = points_from_depth(np.ones(frame.depth.shape), frame.camera)
    found = [
        stereo.locate_scanner(one, spots.pixels, beams) for one in (cameras, *others)
    ]
    return stereo.truth_from_spots(
        spots, found[0], draws=found[1:], sigmas=sigmas, **phase
    )


# %% tags=["hide-input"]
measurement = scan_object(scene, "captures", size=size, seed=seed)
frame = frame_of(scene_from({"kind": "object", "name": scene}), measurement)
spots = stereo.scan_spots(frame, rig, rng=rng, sensor=sensor)
alone = labels(frame, spots, cameras, redrawn)
truth = labels(frame, spots, cameras, redrawn, **measured_phase(measurement))
wrong = (np.abs(truth.depth - frame.depth) > WRAP / 2)[truth.mask].mean()
print(
    f"labelled: stereo alone {alone.mask.mean():.1%}, with the phase {truth.mask.mean():.1%}"
)

# %% tags=["hide-input"]
figure = plt.figure(figsize=(8.4, 5.4))
axes = [figure.add_subplot(121, projection="3d", computed_zorder=False)]
axes += [figure.add_subplot(place) for place in (222, 224)]
turned = [[0, -1, 0], [0, 0, -1], [1, 0, 0]]  # z of the plot points upwards
points = points_from_depth(frame.depth, frame.camera) @ turned
target = points[points.shape[0] // 2, int(0.45 * points.shape[1])]
places = [*rig.centres @ turned, np.zeros(3)]
cloud = points[::2].reshape(-1, 3)
known = np.isfinite(points[::2, :, 0]).ravel()
grey = 0.35 + 0.6 * frame.intensity[::2].clip(0, 1).ravel()[known] ** 0.45
axes[0].scatter(*cloud[known].T, c=grey, s=1, cmap="gray", vmin=0, vmax=1)
for place, name, colour in zip(
    places, ("left", "right", "scanner"), (LEFT, RIGHT, "#00A86B"), strict=True
):
    axes[0].plot(*np.stack([place, target], 1), color=colour, lw=1.4)
    axes[0].plot(*place[:, None], "s", color=colour, label=name)
sides = np.ptp(np.concatenate([cloud[known], places]), axis=0)
axes[0].set_box_aspect(sides, zoom=1.25)
axes[0].view_init(15, 150)
axes[0].set_axis_off()
axes[0].legend(loc="upper left")
_ = axes[0].set_title("stereo rig, to scale")

# %% tags=["hide-input"]
plotting.phase_image(axes[1], measurement.phase[0], title="7.15 GHz phase")
wraps = np.where(truth.mask, truth.wraps, np.nan)
plotting.image(axes[2], wraps, label="wrap count", title="wraps by stereo")
plotting.label_panels(axes)
plotting.save(
    figure,
    "fig09_stereo",
    caption=(
        "Active stereo supervision, simulated on one scan of those that the network learns from, "
        "with the noise of the published captures. (a) Rig and scene. (b) Its phase. (c) The wrap "
        "map from the cameras; grey pixels have no label."
    ),
    alt=(
        f"A point cloud of {scene}, met by a beam and the lines of two cameras. Beside it a phase "
        f"map with fringes, and a smooth wrap map from {np.nanmin(wraps):.0f} "
        f"to {np.nanmax(wraps):.0f}."
    ),
    format="png",
)

# %% [markdown]
# Stereo alone gives $n = \lfloor 2fz/c \rfloor$, which is uncertain at the boundary of a wrap. With
# the measured phase stereo need only be right to half a wrap, 10.5 mm.
#
# ## Limits of a range
#
# A disparity error of $\delta$ pixels causes a range error $\delta z = z^2\delta/(fb)$ with the
# focal length $f$ in pixels and the baseline $b$. Photon noise would allow a hundredth of a pixel
# for a bright spot, but speckle limits it: grains of contrast $C$ shift the centroid by
#
# $$\sigma = \frac{C\lambda N}{\sqrt2\,\pi}$$
#
# on the sensor, whatever the size of the spot
# ([Dorsch et al. 1994](../book/references.bib#dorsch1994)). The calibration
# ([Zhang 2000](../book/references.bib#zhang2000)) is repeated with its corners redrawn, and the
# variance of the ranges is added.

# %% tags=["hide-input"]
paper.check("sec6.lens_focal_length", cameras.matrices[0, 0, 0] * sensor.pitch)
print(f"speckle {sensor.speckle:.3f} px; all noise {np.nanmedian(spots.sigma):.3f} px")
paper.table()

# %% [markdown]
# ## Reach: the same rig before a room

# %%
far_frame = thinned(far_scene, far_stride)
far_phase = measured_phase(cmtof.simulate(far_frame, protocol="full", seed=seed))
far_spots = stereo.scan_spots(far_frame, rig, rng=rng, sensor=sensor)
far = labels(far_frame, far_spots, cameras, redrawn, **far_phase)
reach = WRAP / 2 / sigmas
ideal = np.sqrt(2) * sensor.speckle / (rig.matrices[0, 0, 0] * baseline)  # 1/m
limit = np.sqrt(reach / ideal)
print(f"labelled in the room: {far.mask.mean():.1%}")

# %% tags=["hide-input"]
figure, ax = plt.subplots(figsize=(7, 4.0))
for one, name, colour in ((truth, scene, LEFT), (far, far_scene, RIGHT)):
    ax.plot(
        one.range.ravel(),
        1e3 * one.uncertainty.ravel(),
        ".",
        ms=2,
        alpha=0.3,
        color=colour,
        label=name.replace("_", " "),
        rasterized=True,
    )
places = np.geomspace(0.5, 8, 60)
ax.plot(places, 1e3 * ideal * places**2, "k-", lw=1.2, label="speckle alone, on axis")
ax.set(
    xscale="log",
    yscale="log",
    ylim=(0.1, 60),
    xlim=(0.5, 8),
    xlabel="range (m)",
    ylabel="uncertainty of the range (mm)",
)
plotting.mark(ax, y=1e3 * WRAP, text="one wrap")
plotting.mark(ax, y=1e3 * reach, text=f"half a wrap in {sigmas:g} σ")
ax.legend(loc="lower right", markerscale=5)
plotting.save(
    figure,
    "stereo_uncertainty",
    caption="Uncertainty of the range from stereo in two simulated scans, and its limit by "
    "speckle.",
    alt="On logarithmic axes the uncertainty rises with the square of the range, along the line of "
    f"speckle, which crosses half a wrap in {sigmas:g} sigma at {limit:.1f} m.",
    format="png",
)

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** Yes, on books: {both:.0f} % of the pixels get a label, and {wrong:.2f} % of the
    labels are wrong. Beyond about {limit:.0f} m there are none.
    """,
    both=100 * truth.mask.mean(),
    wrong=100 * wrong,
    limit=limit,
)
