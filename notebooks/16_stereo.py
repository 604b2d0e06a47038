# %% [markdown]
# # Stereo supervision
#
# A network that was trained on simulated rooms meets an instrument whose noise and waveforms are
# its own. To fine-tune it, somebody has to say which wrap each pixel lies in. Two cameras beside
# the scanner can: they watch its laser spot, and triangulate it (Section 6.4). This page builds
# that rig in simulation, from the calibration board to the labels, regenerates Fig. 9, and asks how
# far such labels reach. Everything here is simulated; the paper shows one scan and no numbers.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of every random draw
scene: str = "still_life"  # embedded frame that is scanned
far_scene: str = "room"  # embedded frame for what lies farther away
stride: int = 2  # every how many pixels of the first are scanned
far_stride: int = 4  # and of the second
baseline: float = 0.3  # between the cameras, m; the paper does not tell
f_number: float = 4.0  # of both lenses; the paper does not tell
sigmas: float = 3.0  # standard deviations of a range that must fit
views: int = 20  # of the board
corner_noise: float = 0.05  # of a corner in those views, px
binning: int = 3  # pixels of the board's picture are that much larger
view_counts: list = [5, 10, 20]  # boards shown, for the last figure
trials: int = 3  # calibrations drawn for each
draws: int = 200  # speckled spots drawn from the wave
steps: int = 12  # of fine-tuning
crop: int = 64  # px, of its crops

# %%
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from myst_nb import glue

import cmtof
from cmtof import stereo
from cmtof.book import paper, plotting
from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import residual_noise, wrap_length
from cmtof.measurement import Measurement
from cmtof.scenes import load_frame
from cmtof.scenes.frame import Frame
from cmtof.simulation import RELEASED_FAR_DEPTH
from cmtof.stereo.drawing import COLOURS, draw_rig
from cmtof.stereo.rig import FOCAL_LENGTH, PIXEL_PITCH
from cmtof.stereo.sensor import speckled_centroids
from cmtof.stereo.supervision import Reason

run = plotting.begin(profile=profile, seed=seed)
rng = np.random.default_rng(seed)
WRAP = float(wrap_length(FREQUENCY_SINGLE))


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, float(value), display=False)


# %% [markdown]
# ## The rig
#
# Two FLIR Grasshopper3 GS3-U3-32S4C with 8 mm lenses stand on either side of the scanner. Their
# sensor has 2048×1536 pixels of 3.45 µm behind a colour mosaic: at 532 nm half of its pixels see
# the laser, the others hardly. The paper states neither baseline nor aperture; here they are
# {glue:text}`baseline_mm:.0f` mm and f/{glue:text}`f_number:.0f`. A depth error grows with the
# square of the distance: a disparity that is wrong by $\delta$ pixels moves a point by
#
# $$\delta z = \frac{z^2}{f\,b}\,\delta,$$
#
# and at 7.15 GHz a wrap is only {glue:text}`wrap_mm:.2f` mm long.

# %%
rig = stereo.simulated_rig(baseline=baseline)
sensor = stereo.Sensor(f_number=f_number)
tell(baseline_mm=1e3 * rig.baseline, f_number=f_number, wrap_mm=1e3 * WRAP)
field = [2 * np.degrees(np.arctan(n / 2 / rig.left.intrinsics[0])) for n in rig.left.shape[::-1]]
print(f"each camera sees {field[0]:.1f} x {field[1]:.1f} degrees, undistorted")

# %% [markdown]
# ## Calibration
#
# A checkerboard is shown to both cameras. Its inner corners are saddles of the image, found to a
# small fraction of a pixel; Zhang's closed form {cite}`zhang2000` starts a least-squares fit of all
# of them at once, both cameras and their pose together. The fit also says how well it knows its
# parameters.

# %%
board = stereo.Board()
small = stereo.PinholeCamera.from_lens(
    FOCAL_LENGTH, PIXEL_PITCH * binning, tuple(n // binning for n in rig.left.shape)
)
errors = []
for pose in board.poses(3, rng=rng, distance=1.1):
    corners = stereo.find_corners(stereo.board_image(board, small, pose, rng=rng), board)
    errors.append(corners - small.project(pose.apply(board.corners)))
found_noise = float(np.sqrt(np.mean(np.square(errors))))
print(f"corners of drawn boards are found to {found_noise:.4f} px")

# %% [markdown]
# On drawn boards the corners are right to {glue:text}`found_noise:.3f` px. A printed board is less
# perfect than a drawn one, so the calibration below takes {glue:text}`corner_noise:.2f` px for
# them, in {glue:text}`views:.0f` views.

# %%
shapes = (rig.left.shape, rig.right.shape)
left, right = stereo.simulated_views(rig, board, views, rng=rng, noise=corner_noise)
calibration = stereo.calibrate(board, left, right, shapes)
cameras = calibration.rig
deviation = np.sqrt(np.diag(cameras.covariance))[:24]
worst = np.abs(cameras.parameters - rig.parameters)[:24] / deviation
focal = float(cameras.left.intrinsics[0] * PIXEL_PITCH)
shown = {"left_fx": "px", "left_k1": "", "right_ry": "rad", "right_tx": "m"}
for name, unit in shown.items():
    i = stereo.PARAMETERS.index(name)
    print(f"{name}: {cameras.parameters[i]:.6g} ± {deviation[i]:.1g} {unit}")
print(f"errors in deviations: rms {np.sqrt(np.mean(worst**2)):.2f}, largest {worst.max():.2f}")
paper.check("sec6.lens_focal_length", focal)
tell(found_noise=found_noise, corner_noise=corner_noise, views=views)
tell(worst=worst.max(), left_over=calibration.corner_noise)

# %% [markdown]
# What the fit leaves over, {glue:text}`left_over:.3f` px, is the corners' own noise, and no
# parameter errs by more than {glue:text}`worst:.1f` of its standard deviations.
#
# ## The spot
#
# A spot of many thousand electrons could be placed to a hundredth of a pixel. But laser light on a
# rough wall has speckle, and its grains shift the middle of the spot. A spot of Gaussian profile
# $E$, covered with grains of area $A = 4(\lambda N)^2/\pi$ and contrast $C$, has a centroid that
# scatters by
#
# $$\sigma^2 = C^2 A\,\frac{\int x^2 E^2}{\left(\int E\right)^2} = \frac{C^2 A}{8\pi}, \qquad
#   \sigma = \frac{C\lambda N}{\sqrt2\,\pi},$$
#
# whatever its size: a larger spot holds more grains, but spreads them farther. That is a limit of
# laser triangulation itself {cite}`dorsch1994`; only a wider lens, or less coherent light, helps.
# The wave, drawn with random phases and sent through the lens's aperture, agrees.

# %%
lighting = stereo.Lighting()
foretold = sensor.speckle(lighting.contrast)
drawn = speckled_centroids(sensor, width=1.6, draws=draws, rng=rng, polarisations=2, side=128)
electrons = np.geomspace(300, 6e4, 9)
bounds = [
    np.sqrt(np.trace(stereo.spot_bound(sensor, centre=[7.5, 7.5], brightness=e, width=1.1)) / 2)
    for e in electrons
]
print(f"speckle: foretold {foretold:.3f} px, drawn {drawn.std():.3f} px")
print("bound by photons and read-out (px):", np.round(bounds, 4).tolist())
tell(speckle=foretold, speckle_drawn=drawn.std(), faint=bounds[0], bright=bounds[-1])

# %% [markdown]
# From {glue:text}`faint:.2f` px for a faint spot to {glue:text}`bright:.4f` px for a bright one the
# Cramér–Rao bound falls; speckle stays at {glue:text}`speckle:.3f` px (drawn:
# {glue:text}`speckle_drawn:.3f`). Each spot below is drawn with both, and found by a
# maximum-likelihood fit of a Gaussian on the mosaic's pixels, which reaches that bound; spots that
# are absent, saturated or double are refused.
#
# ## From spots to labels
#
# The frame is scanned; each pixel's spot is seen by a camera unless something stands before it.
# The triangulated spots first tell where the scanner is: its beams leave in known directions, so
# it is located like a third camera. Then each has a range $z$, with the uncertainty of its spots
# and of the calibration, and so a wrap count $\lfloor 2fz/c \rfloor$.


# %%
def thinned(name, stride):
    """Every so many pixels of an embedded frame, as a scan would take them."""
    whole = load_frame(name)
    fx, fy, cx, cy = whole.camera
    kept = (slice(None, None, stride),) * 2
    camera = [fx / stride, fy / stride, (cx - 0.5) / stride + 0.5, (cy - 0.5) / stride + 0.5]
    return Frame(whole.depth[kept], whole.intensity[kept], np.array(camera), name)


def scanned(name, stride):
    """A frame, its noisy measurement, and what both cameras saw of the scan."""
    frame = thinned(name, stride)
    measurement = cmtof.simulate(frame, protocol="full", seed=seed)
    watched = stereo.view_scene(frame, rig, sensor=sensor, lighting=lighting)
    return frame, measurement, watched, stereo.record(watched, rng=rng)


def located(cameras, spots, watched):
    """The cameras with the scanner found from a scan."""
    seen = [(s.pixels.reshape(-1, 2), s.covariance.reshape(-1, 2, 2)) for s in spots]
    pairs = stereo.triangulate(cameras, seen[0][0], seen[1][0], (seen[0][1], seen[1][1]))
    return stereo.locate_scanner(cameras, pairs, watched.points.reshape(-1, 3))


# %%
def labels(spots, watched, cameras, measurement=None):
    """Pseudo-truth, with the phase of a measurement or without."""
    known = {}
    if measurement is not None:
        images, psi = (measurement.dataset[k].to_numpy()[0] for k in ("correlation", "psi"))
        noise = residual_noise(images, psi) * np.sqrt(2 / psi.size)
        amplitude = np.maximum(measurement.amplitude[0], 1e-6)
        known = {"phase": measurement.phase[0], "phase_noise": noise / amplitude}
    return stereo.truth_from_spots(
        spots, cameras, FREQUENCY_SINGLE, sigmas=sigmas, lit=watched.lit, **known
    )


frame, measurement, watched, spots = scanned(scene, stride)
calibrated = located(cameras, spots, watched)
alone = labels(spots, watched, calibrated)
truth = labels(spots, watched, calibrated, measurement)
depth = frame.depth.astype(float)
right_alone = (alone.wraps == np.floor(depth / WRAP))[alone.mask].mean()
wrong = float((np.abs(truth.depth - depth) > WRAP / 2)[truth.mask].mean())
where = [one.scanner_from_left.inverse.translation for one in (calibrated, rig)]
offset = where[0] - where[1]
print(f"scanner found to {1e3 * np.linalg.norm(offset):.2f} mm")
print({Reason(i).name: int(n) for i, n in enumerate(np.bincount(truth.reason.ravel()))})
tell(scanner_mm=1e3 * np.linalg.norm(offset), alone=100 * alone.share, both=100 * truth.share)
tell(right_alone=100 * right_alone, wrong=100 * wrong, sigmas=sigmas)

# %% [markdown]
# Stereo alone is in doubt wherever {glue:text}`sigmas:.0f` standard deviations reach over the
# boundary of a wrap, however precise it is: it labels {glue:text}`alone:.1f` % of the pixels, of
# which {glue:text}`right_alone:.2f` % are right. The measured phase removes that doubt: it says
# where in the wrap the surface lies, and stereo need only be right to half a wrap. So
# {glue:text}`both:.1f` % get a label, and {glue:text}`wrong:.2f` % of those err.

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 3, figsize=(11.0, 3.5), width_ratios=[1.25, 1, 1])
height, width = frame.depth.shape
draw_rig(axes[0], frame, rig, (height // 2, int(0.45 * width)))
axes[0].set_title("stereo rig, to scale")
plotting.phase_image(axes[1], measurement.phase[0], title="7.15 GHz phase")
shown_wraps = np.where(truth.mask, truth.wraps, np.nan)
plotting.image(axes[2], shown_wraps, label="wrap count", title="wraps by stereo")
plotting.label_panels(axes)
plotting.save(
    figure,
    "fig09_stereo",
    numbers={
        "labelled": truth.share,
        "labelled_by_stereo_alone": alone.share,
        "wrong": wrong,
        "least_wrap": int(np.nanmin(shown_wraps)),
        "largest_wrap": int(np.nanmax(shown_wraps)),
        "median_uncertainty_mm": 1e3 * float(np.nanmedian(truth.uncertainty)),
    },
    caption=(
        "Active stereo supervision (Fig. 9 of the paper), simulated. (a) The rig, drawn to scale "
        "before the scene. (b) The phase that the scan measures. (c) The wrap map that the cameras "
        "recover; grey pixels have no label."
    ),
    alt=(
        "A point cloud of a table with objects; a scanner's green beam meets it, and dashed lines "
        "run from the spot to two cameras. Beside it a noisy phase map with fringes, and a smooth "
        f"wrap map from {int(np.nanmin(shown_wraps))} to {int(np.nanmax(shown_wraps))}, grey where "
        "a camera sees nothing."
    ),
    format="png",
)

# %% [markdown]
# ## How far it reaches
#
# The same rig before a room. A label needs {glue:text}`sigmas:.0f` standard deviations within half
# a wrap; where the uncertainty crosses that line, supervision ends.

# %%
far_frame, far_measurement, far_watched, far_spots = scanned(far_scene, far_stride)
far_rig = located(cameras, far_spots, far_watched)
far = labels(far_spots, far_watched, far_rig, far_measurement)
reach = WRAP / 2 / sigmas
ideal = np.sqrt(2) * foretold / (rig.left.intrinsics[0] * rig.baseline)
limit = float(np.sqrt(reach / ideal))
places = np.geomspace(0.5, 8, 60)
edges = np.arange(0.5, 6.5, 0.25)
rates = []
for low, high in pairwise(edges):
    chosen = [t.mask[(f.depth >= low) & (f.depth < high) & w.inside.all(axis=0)]
              for t, f, w in ((truth, frame, watched), (far, far_frame, far_watched))]  # fmt: skip
    both = np.concatenate(chosen)
    rates.append(float(both.mean()) if both.size > 30 else np.nan)
print(f"by speckle alone the line is crossed at {limit:.2f} m")
tell(limit=limit, far=100 * far.share, released_far=RELEASED_FAR_DEPTH)

# %% tags=["hide-input"]
figure, (ax, lower) = plt.subplots(2, 1, figsize=(6.8, 5.6), sharex=True, height_ratios=[2, 1])
for one, name, colour in ((truth, scene, COLOURS[0]), (far, far_scene, COLOURS[1])):
    some = np.isfinite(one.uncertainty)
    ax.plot(one.range[some], 1e3 * one.uncertainty[some], ".", ms=2, alpha=0.3, color=colour,
            label=name.replace("_", " "), rasterized=True)  # fmt: skip
ax.plot(places, 1e3 * ideal * places**2, "k-", lw=1.2, label="speckle alone, on axis")
ax.axhline(1e3 * WRAP, color="0.4", lw=1, ls="-")
ax.text(0.52, 1.08e3 * WRAP, "one wrap", color="0.3")
ax.axhline(1e3 * reach, color="0.4", lw=1, ls="--")
ax.text(0.52, 1.08e3 * reach, f"half a wrap in {sigmas:g} σ", color="0.3")
ax.set(xscale="log", yscale="log", ylabel="uncertainty of the range (mm)", ylim=(0.1, 60))
ax.legend(loc="lower right", markerscale=5)
lower.stairs(100 * np.array(rates), edges, color="k")
lower.set(xlabel="range (m)", ylabel="labelled (%)", ylim=(0, 100), xlim=(0.5, 8))
lower.set_xticks([0.5, 1, 2, 4, 8], ["0.5", "1", "2", "4", "8"])
lower.minorticks_off()
plotting.save(
    figure,
    "stereo_uncertainty",
    numbers={
        "speckle_limit_m": limit,
        "near_share": truth.share,
        "far_share": far.share,
        "rates": [r for r in rates if np.isfinite(r)],
    },
    caption=(
        "Uncertainty of the range from stereo, of every pixel of two simulated scans, and the "
        "share of the pixels within both images that get a label."
    ),
    alt=(
        "On logarithmic axes the uncertainty rises with the square of the range, along the line of "
        f"speckle, which crosses half a wrap in {sigmas:g} sigma at {limit:.1f} m; below, the "
        "labelled share falls to none over the same ranges."
    ),
    format="png",
)

# %% [markdown]
# Speckle alone would end the labels at {glue:text}`limit:.1f` m on this baseline. In the room
# {glue:text}`far:.1f` % of the pixels get one. The network of the authors' released
# code ends at {glue:text}`released_far:.3f` m, where there is room to spare.
#
# ## What a bad calibration does
#
# Noise of spots is drawn anew at each pixel; an error of the calibration is shared by all, and
# shifts a whole surface by whole wraps without a trace in the map. What lifts a spot off its
# epipolar line is seen, and masked; what moves it along is not. The calibration's own covariance
# counts in the mask, but it knows of no knock. Below, single parameters of the true rig are changed
# and nobody is told: labels keep being given, and some are wrong.

# %%
CHANGES = {
    "none": {},
    "focal length of left, 2 px": {"left_fx": 2.0, "left_fy": 2.0},
    "centre of right, 1 px": {"right_cx": 1.0},
    "right turned about y, 0.5 mrad": {"right_ry": 5e-4},
    "right turned about x, 0.5 mrad": {"right_rx": 5e-4},
    "baseline, 1 mm": {"right_tx": 1e-3},
    "distortion k1 of left, 0.01": {"left_k1": 0.01},
}
rows = {}
for name, change in CHANGES.items():
    bad = located(rig.moved(**change), far_spots, far_watched)
    got = labels(far_spots, far_watched, bad, far_measurement)
    off = np.abs(got.depth - far_frame.depth) > WRAP / 2
    shift = 1e3 * float(np.nanmedian(got.range - far_frame.depth))
    rows[name] = (
        shift,
        100 * got.share,
        100 * float(off[got.mask].mean()) if got.mask.any() else np.nan,
    )
lines = [
    "| changed | median error (mm) | labelled (%) | of them wrong (%) |",
    "| --- | --: | --: | --: |",
]
lines += [
    f"| {n} | {a:+.1f} | {b:.1f} | {'–' if np.isnan(c) else f'{c:.1f}'} |"
    for n, (a, b, c) in rows.items()
]
glue("changes", Markdown("\n".join(lines)), display=False)

# %% [markdown]
# ```{glue:md} changes
# :format: myst
# ```
#
# So the calibration has to be as good as the spots are, {glue:text}`speckle:.2f` px, and a rig that
# has been knocked has to be calibrated again. How many views of the board that takes:

# %%
shares, wrongs = [], []
for count in view_counts:
    found = []
    for trial in range(trials):
        own = np.random.default_rng([seed, count, trial])
        pair = stereo.simulated_views(rig, board, count, rng=own, noise=corner_noise)
        one = located(stereo.calibrate(board, *pair, shapes).rig, far_spots, far_watched)
        got = labels(far_spots, far_watched, one, far_measurement)
        off = np.abs(got.depth - far_frame.depth)[got.mask] > WRAP / 2
        found.append((got.share, off.mean() if off.size else 0.0))
    share, bad = np.mean(found, axis=0)
    shares.append(float(share))
    wrongs.append(float(bad))
perfect = labels(far_spots, far_watched, rig, far_measurement).share
print(dict(zip(view_counts, zip(shares, wrongs, strict=True), strict=True)))

# %% tags=["hide-input"]
figure, ax = plt.subplots(figsize=(6.0, 3.4))
ax.axhline(100 * perfect, color="0.5", ls="--", lw=1)
ax.text(view_counts[0], 100 * perfect + 0.5, "calibration without error", color="0.3", va="bottom")
ax.plot(view_counts, 100 * np.array(shares), "o-", color=COLOURS[0], label="labelled")
ax.plot(view_counts, 100 * np.array(wrongs), "s-", color=COLOURS[1], label="of them wrong")
ax.set(xlabel="views of the board", ylabel="pixels of the room (%)", ylim=(-1, None), xscale="log")
ax.set_xticks(view_counts, [str(n) for n in view_counts])
ax.minorticks_off()
ax.legend(loc="center right")
plotting.save(
    figure,
    "stereo_calibration",
    numbers={"views": view_counts, "labelled": shares, "wrong": wrongs, "perfect": perfect},
    caption="Labels in the room against the number of views that the calibration was given.",
    alt=(
        f"The labelled share rises from {100 * shares[0]:.1f} to {100 * shares[-1]:.1f} % with the "
        f"number of views, towards {100 * perfect:.1f} %; hardly any label is wrong."
    ),
)

# %% [markdown]
# ## Fine-tuning
#
# The labels go where they are meant to: into a few more steps of training. The left half of the
# scan teaches, the right half is withheld; only labelled pixels within the network's classes count
# in the loss, and the normalisation keeps its statistics. This is a proof that the path is whole,
# from spots to weights, and no more: one half of one scan cannot do what the paper's «diverse
# dataset» does.

# %%
from cmtof.network.features import features
from cmtof.network.finetuning import Labelled, fine_tune
from cmtof.network.inference import classify
from cmtof.network.weights import load_weights, weights_path

trained = load_weights(weights_path("fast-scnn", "released"))
half = width // 2
sides = {"taught": slice(0, half), "withheld": slice(half, width)}
examples = {
    name: Labelled(Measurement(measurement.dataset.isel(x=part)), truth.wraps[:, part],
                   truth.mask[:, part], truth.depth[:, part])
    for name, part in sides.items()
}  # fmt: skip
tuned = fine_tune(trained, [examples["taught"]], steps=steps, crop=crop, batch=1, seed=seed)


# %%
def rate(network, example):
    """Share of labelled pixels within the network's classes whose wrap is right."""
    images = (example.measurement.phase, example.measurement.amplitude)
    phase, amplitude = (np.asarray(image[:2], np.float32) for image in images)
    wraps = network.first + classify(network, features(phase, amplitude))[0]
    last = network.first + network.card["classes"]
    scored = example.mask & (example.wraps >= network.first) & (example.wraps < last)
    return float((wraps == example.wraps)[scored].mean())


before = {name: rate(trained, one) for name, one in examples.items()}
after = {name: rate(tuned.trained, one) for name, one in examples.items()}
labelled = tuned.trained.card["fine_tuned"]["labelled_pixels"]
print("loss:", np.round(tuned.losses, 2).tolist())
print("right before:", before, "after:", after)
tell(steps=steps, labelled=labelled)
tell(
    **{f"{n}_before": 100 * before[n] for n in before},
    **{f"{n}_after": 100 * after[n] for n in after},
)

# %% [markdown]
# Of the wraps on the half that taught {glue:text}`taught_before:.1f` % were right before, and
# {glue:text}`taught_after:.1f` % are after {glue:text}`steps:.0f` steps on
# {glue:text}`labelled:.0f` labelled pixels. On the withheld half it was
# {glue:text}`withheld_before:.1f` % and is {glue:text}`withheld_after:.1f` %.
