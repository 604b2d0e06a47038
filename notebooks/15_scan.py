# %% [markdown]
# # A scan, from drivers to depth
#
# A small scene is scanned through the drivers of the real instruments: serial lines, SCPI and
# Modbus go over sockets and pseudo-terminals. At their other end stands no hardware but the
# simulated instrument, so everything on this page is simulated, and for every number it is known
# what it should have been. {doc}`../book/hardware` tells how the same scan is run on a bench.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of the simulated instrument
scene: str = "still_life"  # embedded frame before it
field_of_view_deg: float = 10.0  # optical angle across and down
size: int = 48  # height and width of the image, px
repeats: int = 6  # scans averaged in the comparison of methods
window: int = 7  # of the small window, px
killed_size: int = 6  # image of the scan that is killed, px

# %%
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from myst_nb import glue

import cmtof
from cmtof.book import plotting
from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU, centred, decode, phase_from_depth, wrap_length
from cmtof.hardware.bench import Bench
from cmtof.hardware.dry_run import duration
from cmtof.hardware.journal import journal_path, read_journal
from cmtof.hardware.reduction import drive_phases
from cmtof.hardware.rig import Rig
from cmtof.hardware.scan import planned, sampling_of, scan
from cmtof.hardware.twin.modbus_server import TDAC_STEP
from cmtof.hardware.twin.run import Twin
from cmtof.instrument.electronics import volts_from_counts
from cmtof.instrument.light import Panel, RfKnobs
from cmtof.instrument.world import World
from cmtof.measurement import Measurement

run = plotting.begin(profile=profile, seed=seed)
folder = tempfile.TemporaryDirectory(prefix="cmtof-scan-")
here = Path(folder.name)


def say(name, *sentences):
    glue(name, Markdown(" ".join(one for one in sentences if one)), display=False)


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, float(value), display=False)


def typical(error):
    """Median of the absolute error: edges of objects must not decide it."""
    return float(np.nanmedian(np.abs(error)))


# %% [markdown]
# ## Plan and run
#
# A scan is settled before anything moves. Each mode is taken in one go: dark level behind the
# closed shutter, a reference target at known distances, every line of the image, and the reference
# target once more, to see what has drifted. Between the modes both half-wave plates turn. `Twin`
# serves every device of the default rig; `scan` knows nothing of that and drives what answers.

# %%
rig = Rig.default()
settings = replace(
    rig.settings,
    scan=replace(rig.settings.scan, field_of_view_deg=(field_of_view_deg, field_of_view_deg)),
)
plan = planned(settings, size=size)
twin = Twin(replace(rig, settings=settings), scene=scene, seed=seed, private=True)
with twin:
    started = time.perf_counter()
    measurement = scan(twin.rig, plan, here / "m.nc", seed=seed, scene=scene)
    wall_time = time.perf_counter() - started
    model = twin.world
data = measurement.dataset
modes = plan.modes
print(measurement)

# %% tags=["hide-input"]
full = planned(rig.settings, size=64)
tell(
    bursts=plan.bursts,
    lines=len(plan.lines),
    instrument_time=duration(plan),
    wall_time=wall_time,
    faster=duration(plan) / wall_time,
    full_minutes=duration(full) / 60,
    burst_ms=1e3 * settings.detection.duration,
    phases=settings.detection.phases,
    samples=settings.detection.samples_per_phase,
)

# %% [markdown]
# {glue:text}`bursts:.0f` points in {glue:text}`lines:.0f` lines: on the instrument, which needs
# {glue:text}`burst_ms:.1f` ms for a point and a little more to say so, about
# {glue:text}`instrument_time:.0f` s; here it took {glue:text}`wall_time:.0f` s, as the simulated
# instrument lives on a clock of its own ({glue:text}`faster:.1f` times real time). An image of
# 64 × 64 points in both modes would take {glue:text}`full_minutes:.1f` minutes on a bench.
#
# ## One point
#
# At each point the read-out samples the detector while its own trigger line steps the phase of the
# detection module's drive: {glue:text}`phases:.0f` phases of {glue:text}`samples:.0f` samples. To
# look at the raw samples of one point, the drivers are asked again, step by step, for the burst
# that bears that point's number.

# %%
row, column = plan.shape[0] // 3, plan.shape[1] // 3
sampling = sampling_of(settings, plan)


def labels_of(mode):
    """Numbers (H, W) of a mode's bursts."""
    lines = [line for line in plan.lines if (line.mode, line.kind) == (mode, "scan")]
    return np.array([list(line.labels) for line in lines])


raw = {}
again = Twin(replace(rig, settings=settings), scene=scene, seed=seed, private=True)
with again, again.rig.open() as instruments:
    bench = Bench(instruments, settings, sampling)
    bench.set_up()
    for mode in modes:
        bench.choose_mode(mode)
        bench.look_at("scan")
        bench.begin_line()
        raw[mode] = bench.burst(int(labels_of(mode)[row, column]), plan.angles[row, column])

# %%
same_point = True
means = {}
for number, mode in enumerate(modes):
    sums, clipped = sampling.sums(raw[mode])
    means[mode] = sums / sampling.kept
    stored = data["raw_counts"].to_numpy()[number, :, row, column]
    same_point &= bool(np.array_equal(means[mode].astype(np.float32), stored))
say("point_says",
    "The sums of these samples are bit for bit those of the file: noise and drift hang on the "
    "number of the burst alone, not on when it is taken, or how often." if same_point else
    "The sums of these samples are NOT those of the file.")  # fmt: skip
print(same_point)

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(9.6, 3.7))
instant = 1e3 * np.arange(sampling.scans) / settings.detection.rate
step = 1e3 * sampling.samples_per_phase / settings.detection.rate
for colour, mode in zip(("blue", "vermillion"), modes, strict=True):
    axes[0].plot(instant, raw[mode], ".", ms=2.5, color=plotting.PALETTE[colour], label=mode)
for edge in range(sampling.phases + 1):
    axes[0].axvline(edge * step, color="0.85", lw=0.6, zorder=0)
axes[0].set(xlabel="time (ms)", ylabel="converter (counts)", title="one burst")
axes[0].legend(loc="upper right")
contrasts = {}
turn = np.linspace(0, TAU, 200)
for number, (colour, mode) in enumerate(zip(("blue", "vermillion"), modes, strict=True)):
    values = data["correlation"].to_numpy()[number, :, row, column]
    psi = data["psi"].to_numpy()[number]
    fit = decode(values, psi)
    contrasts[mode] = float(fit.amplitude / fit.offset)
    axes[1].plot(psi, 1e3 * values, "o", ms=4, color=plotting.PALETTE[colour])
    curve = fit.offset + fit.amplitude * np.cos(fit.phase + turn)
    axes[1].plot(turn, 1e3 * curve, color=plotting.PALETTE[colour],
                 label=f"{mode}: φ = {float(fit.phase):.2f} rad")  # fmt: skip
axes[1].set(xlabel="reference phase ψ (rad)", ylabel="above the dark (mV)", title="what is kept")
axes[1].set_xticks([0, TAU / 2, TAU], ["0", "π", "2π"])
axes[1].legend()
plotting.label_panels(axes)
plotting.save(
    figure,
    "scan_point",
    numbers={
        "contrast": contrasts,
        "mean_counts": {mode: float(np.mean(raw[mode])) for mode in modes},
        "reproduced": same_point,
    },
    caption=(
        "(a) The samples of one point in both modes; lines are the edges of the trigger. "
        "(b) The mean of each phase, and the cosine that fits them."
    ),
    alt=(
        f"Left: {sampling.scans} samples of two bursts run in {sampling.phases} steps through one "
        "period of a cosine. Right: their means lie on fitted cosines, of contrast "
        f"{contrasts['single']:.2f} in the single and {contrasts['doubled']:.2f} in the doubled "
        "mode."
    ),
)
tell(settle=sampling.settle_samples, settle_first=sampling.settle_first)

# %% [markdown]
# Of each phase the first {glue:text}`settle:.0f` samples are dropped, until the low-pass has
# settled, of the first one {glue:text}`settle_first:.0f`, while the mirrors still move. The rest is
# summed as whole counts, and the sums are what the journal keeps.
#
# ```{glue:md} point_says
# :format: myst
# ```
#
# ## What the reference target tells
#
# Counts become volts by the read-out's own calibration; the dark level is taken off; each line is
# divided by its laser power. What then is still unknown is where ψ begins: the way of the light
# within the instrument and the cables of the drives shift it by
#
# $$\psi_0 = \frac{4\pi f\,\ell}{c} - m\,\varphi_\mathrm{cable},\qquad m = 1, 2,$$
#
# with the internal path $\ell$ and the lag of the detection's cable, which counts twice in the
# doubled mode. The target behind the flip mirror stands at known distances, over one whole wrap, so
# that light which comes back from the optics averages out. The simulated instrument was given
# $\ell$ and $\varphi_\mathrm{cable}$; here is what the calibration found.

# %%
given = model.settings
found = np.array(data.attrs["phase_offset"])
true_offset = np.array([
    centred(4 * np.pi * f * given.optics.internal_path / SPEED_OF_LIGHT
            - order * given.drive.phase_offset)
    for f, order in zip(measurement.frequencies, (1, 2), strict=True)
])  # fmt: skip
off = centred(found - true_offset)
excess = measurement.frequencies[1] / measurement.frequencies[0] - 2
wrap_in_beat = TAU * excess
lines = ["| | put in (rad) | found (rad) | off by (mrad) | drift during the image (mrad) |",
         "| --- | --: | --: | --: | --: |"]  # fmt: skip
for number, mode in enumerate(modes):
    drift = 1e3 * data.attrs["phase_drift"][number]
    lines.append(f"| {mode} | {true_offset[number]:.4f} | {found[number]:.4f} | "
                 f"{1e3 * off[number]:+.2f} | {drift:+.2f} |")  # fmt: skip
glue("offsets", Markdown("\n".join(lines)), display=False)
beat_off = float(centred(off[1] - 2 * off[0]))
tell(beat_off=1e3 * abs(beat_off), wrap_mrad=1e3 * wrap_in_beat,
     beat_off_wraps=abs(beat_off) / wrap_in_beat, index_ppm=1e6 * (data.attrs["group_index"] - 1),
     depth_off=1e6 * abs(off[0]) / TAU * wrap_length(measurement.frequencies[0]))  # fmt: skip

# %% [markdown]
# ```{glue:md} offsets
# :format: myst
# ```
#
# As depth the first is nothing, {glue:text}`depth_off:.1f` µm. What counts is the beat of both
# phases, which has to tell one wrap from the next: a wrap is {glue:text}`wrap_mrad:.1f` mrad of it,
# and the calibration is off by {glue:text}`beat_off:.2f` mrad, or {glue:text}`beat_off_wraps:.3f`
# wraps. Light is slower in air by {glue:text}`index_ppm:.0f` ppm, which the file states and which
# is taken out below.
#
# ## Images

# %%
index = float(data.attrs["group_index"])
truth = model.ranges(plan.angles).reshape(plan.shape)
ideal_phase = np.stack([phase_from_depth(index * truth, f) for f in measurement.frequencies])
error = centred(measurement.phase - ideal_phase)
TONES = [f"{f / 1e9:.2f} GHz" for f in measurement.frequencies]
period = float(wrap_length(measurement.frequencies[0])) / index
tell(nearest=np.nanmin(truth), farthest=np.nanmax(truth), period=1e3 * period,
     turns=(np.nanmax(truth) - np.nanmin(truth)) / period,
     error_single=1e3 * typical(error[0]), error_doubled=1e3 * typical(error[1]))  # fmt: skip

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 4, figsize=(12.4, 3.1))
plotting.image(axes[0], 1e3 * measurement.amplitude[0], label="amplitude (mV)", title=TONES[0])
plotting.phase_image(axes[1], np.mod(measurement.phase[0], TAU), title=TONES[0])
plotting.phase_image(axes[2], np.mod(measurement.phase[1], TAU), title=TONES[1])
plotting.image(axes[3], truth, label="range (m)", title="the scene's range")
plotting.label_panels(axes)
plotting.save(
    figure,
    "scan_images",
    numbers={
        "range_m": [float(np.nanmin(truth)), float(np.nanmax(truth))],
        "median_error_mrad": [1e3 * typical(e) for e in error],
        "valid": float(measurement.mask.mean()),
    },
    caption="What the scan brought: amplitude, both wrapped phases, and the truth beside them.",
    alt=(
        "Four small images. The amplitude is grainy with speckle; the phases run through "
        f"{(np.nanmax(truth) - np.nanmin(truth)) / period:.0f} wraps of fringes over the scene, "
        f"twice as many at the doubled frequency; the range goes from "
        f"{np.nanmin(truth):.2f} to {np.nanmax(truth):.2f} m."
    ),
    format="png",
)

# %% [markdown]
# The scene lies between {glue:text}`nearest:.2f` and {glue:text}`farthest:.2f` m, which is
# {glue:text}`turns:.0f` wraps of {glue:text}`period:.2f` mm. Against the truth the phases are off
# by {glue:text}`error_single:.1f` and {glue:text}`error_doubled:.1f` mrad (median).
#
# ## What the errors are made of
#
# The physical model behind the servers can be asked directly, without wires, and with its parts
# switched off one after the other: noise, speckle, the size of the spot, light that comes back from
# the beam splitter, errors of the RF drivers, and last the finite steps of the converter that
# steers the mirrors. The differences add up to the whole error. What noise there has to be is also
# foretold from the counts alone: shot noise with the avalanche's excess, amplifier and converter,
# through the mean of the kept samples,
#
# $$\sigma_\varphi = \sqrt{\frac{2}{K}}\;\frac{\sigma_U}{a}.$$


# %%
def panel(mode):
    """Knobs as the scan leaves them in a mode."""
    knobs = {"on": True, "frequency": settings.drive.frequency(mode),
             "power": settings.drive.power_dbm}  # fmt: skip
    table = drive_phases(sampling.phases, mode)
    return Panel(emission=RfKnobs(**knobs),
                 detection=RfKnobs(**knobs, table=table, armed=True, trigger=True),
                 plate_angle=list(settings.plates.mount_angles(mode)),
                 laser_on=True, shutter_open=True, clock_on=True)  # fmt: skip


scale = settings.galvo.volts_per_radian
steered = np.rint(plan.angles * scale / TDAC_STEP) * TDAC_STEP / scale


def asked(world, angles=steered, shift=0):
    """Mean counts (mode, step, H, W) of a model, at the numbers of the scan's own bursts."""
    edges = np.arange(sampling.scans) // sampling.samples_per_phase
    place = np.arange(sampling.samples_per_phase)
    used = place >= (sampling.samples_per_phase - sampling.kept)[:, None]
    images = []
    for mode in modes:
        counts = world.bursts(panel(mode), angles.reshape(-1, 2), pulses=edges,
                              labels=labels_of(mode).ravel() + shift)  # fmt: skip
        samples = counts.reshape(-1, *used.shape)
        images.append(((samples * used).sum(-1) / sampling.kept).T.reshape(-1, *plan.shape))
    return np.stack(images)


direct = asked(model)
differing = int((direct.astype(np.float32) != data["raw_counts"].to_numpy()).sum())
print(differing, "values differ between wires and model")

# %%
quiet = replace(given, noise=False)
smooth = replace(quiet, optics=replace(quiet.optics, speckle=False))
fine = replace(smooth, optics=replace(smooth.optics, divergence=0.0, exit_radius=0.0))
clear = replace(fine, optics=replace(fine.optics, back_fraction=0.0))
flawless = dict.fromkeys(("phase_drift", "phase_step_error", "iq_imbalance", "leakage"), 0.0)
ideal = replace(clear, drive=replace(clear.drive, **flawless))


def phases_of(counts):
    """Phases (mode, H, W) of counts, against the psi that the scan's file states."""
    volts = volts_from_counts(counts, volts_range=settings.detection.range)
    return decode(volts, data["psi"].to_numpy()).phase


steps = [phases_of(direct)]
steps += [phases_of(asked(World(one, scene, seed=seed)))
          for one in (quiet, smooth, fine, clear, ideal)]  # fmt: skip
steps += [phases_of(asked(World(ideal, scene, seed=seed), plan.angles))]
CAUSES = ("noise", "speckle", "spot", "back-reflection", "RF drivers", "mirror steps")
causes = {
    name: centred(with_it - without)
    for name, with_it, without in zip(CAUSES, steps, steps[1:], strict=False)
}
sizes = {
    name: [1e3 * typical(e[0]), 1e3 * typical(e[1]), 1e3 * typical(centred(e[1] - 2 * e[0]))]
    for name, e in {**causes, "all": error}.items()
}

# %%
amplitude, kept_time = (
    measurement.amplitude,
    (settings.detection.samples_per_phase - settings.detection.settle_samples)
    / settings.detection.rate,
)
level = measurement.decoded.offset + np.asarray(volts_from_counts(
    data["dark"].to_numpy(), volts_range=settings.detection.range))[:, None, None]  # fmt: skip
converter = given.detector.converter_noise * float(
    np.diff(volts_from_counts([0, 1], volts_range=settings.detection.range))[0]
)
samples_kept = kept_time * settings.detection.rate
variance = model.conversion.density(np.maximum(level, 0)) / (2 * kept_time)
foretold = np.sqrt(2 / sampling.phases * (variance + converter**2 / samples_kept)) / amplitude
pull = causes["noise"] / foretold
pulls = [float(np.median(np.abs(p)) / 0.6745) for p in pull]
beat_noise = np.hypot(2 * foretold[0], foretold[1])
largest = max(CAUSES, key=lambda name: sizes[name][2])
say("errors_say",
    f"The scatter of the noise is {pulls[0]:.2f} (single) and {pulls[1]:.2f} (doubled) times what "
    "was foretold for each pixel.",
    f"In the single phase the largest part is {max(CAUSES, key=lambda n: sizes[n][0])}, with a "
    f"median of {max(sizes[n][0] for n in CAUSES):.1f} mrad; in the beat it is {largest}, with "
    f"{sizes[largest][2]:.1f} mrad or {sizes[largest][2] / 1e3 / wrap_in_beat:.2f} wraps."
)  # fmt: skip
say("wires_say",
    "Asked directly, the model gives every count of the scan, bit for bit." if not differing else
    f"Asked directly, the model differs from the scan in {differing} values.")  # fmt: skip
tell(beat_foretold=1e3 * np.median(beat_noise))

# %% tags=["hide-input"]
figure, ax = plt.subplots(figsize=(7.6, 3.9))
names = [*CAUSES, "all"]
where = np.arange(len(names))
for number, (label, colour) in enumerate(((TONES[0], "sky"), (TONES[1], "blue"),
                                          ("beat", "vermillion"))):  # fmt: skip
    heights = [max(sizes[name][number], 1e-3) for name in names]
    ax.bar(where + 0.27 * (number - 1), heights, 0.25, color=plotting.PALETTE[colour], label=label)
ax.axhline(500 * wrap_in_beat, color="0.4", lw=0.9, ls="--")
ax.text(4.0, 500 * wrap_in_beat * 1.1, "half a wrap in the beat", ha="center",
        fontsize=8.5, color="0.3")  # fmt: skip
ax.set_yscale("log")
ax.set_ylim(0.05, None)
ax.set_xticks(where, [name.replace(" ", "\n").replace("-", "-\n") for name in names])
ax.set_ylabel("median phase error (mrad)")
ax.grid(axis="x", visible=False)
ax.legend(ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
plotting.save(
    figure,
    "scan_errors",
    numbers={"mrad": sizes, "foretold_over_found": pulls, "wrap_mrad": 1e3 * wrap_in_beat},
    caption=(
        "Median phase error by its cause, in both modes and in their beat, where it decides "
        "about the wraps."
    ),
    alt=(
        "Bars on a logarithmic scale for "
        + ", ".join(f"{name} ({sizes[name][2]:.1f} mrad in the beat)" for name in names)
        + f"; half a wrap is {500 * wrap_in_beat:.1f} mrad."
    ),
)

# %% [markdown]
# ```{glue:md} wires_say
# :format: myst
# ```
#
# ```{glue:md} errors_say
# :format: myst
# ```
#
# Speckle shifts a phase because the spot is not a point: its bright grains lie now on the near, now
# on the far side of a slope. That is a real displacement, the same in both modes, so most of it
# cancels in the beat; so does what the mirrors' converter rounds away. Noise does not cancel, and
# the doubled mode, which has less contrast, brings most of it. Back-reflected light is a constant
# phasor, pulling strong echoes little and weak ones a lot, each mode in its own way.
#
# ## Laser power
#
# The fibre's transmission drifts. The power meter behind the emission module is read at the end of
# every line, and the line is divided by it.

# %%
steady = replace(given, laser=replace(given.laser, fibre_low=0.25, fibre_high=0.25), noise=False)
volts = volts_from_counts(asked(World(steady, scene, seed=seed)),
                          volts_range=settings.detection.range)  # fmt: skip
expected = decode(volts, data["psi"].to_numpy()).amplitude
power = data["laser_power"].to_numpy()[:, :, 0]
relative = power / power[:, :1]
swing = 100 * float((np.ptp(power, axis=1) / power.mean(axis=1)).max())
without = measurement.amplitude * relative[..., None]
bright = np.where(expected > np.median(expected, axis=2, keepdims=True), 1.0, np.nan)
line_gain = {}
for name, seen in (("as it came", without), ("divided by power", measurement.amplitude)):
    gain = np.nanmedian(bright * seen / expected, axis=2)
    line_gain[name] = gain / gain.mean(axis=1, keepdims=True)
spread = {name: float(100 * gain.std()) for name, gain in line_gain.items()}
tell(power_swing=swing, before=spread["as it came"],
     after=spread["divided by power"])  # fmt: skip

# %% tags=["hide-input"]
figure, ax = plt.subplots(figsize=(7.6, 3.4))
when = data["time"].to_numpy()[:, :, -1]
for number in range(len(modes)):
    label = number == 0
    ax.plot(when[number], power[number] / power[number].mean(), color="0.65", lw=4, alpha=0.6,
            label="power meter" if label else None)  # fmt: skip
    for (name, gain), colour in zip(line_gain.items(), ("vermillion", "green"), strict=True):
        ax.plot(when[number], gain[number], ".-", ms=4, lw=1, color=plotting.PALETTE[colour],
                label=f"amplitude, {name}" if label else None)  # fmt: skip
ax.set(xlabel="time on the plan's clock (s)", ylabel="relative to the mean of the mode")
ax.legend(fontsize=8.5, ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
plotting.save(
    figure,
    "scan_power",
    numbers={"spread_percent": spread, "swing_percent": swing},
    caption="Laser power, and the amplitude of each line against that of a steady laser.",
    alt=(
        f"Two stretches, one a mode. The power swings by {swing:.0f} "
        f"%; the lines' amplitudes follow it with a spread of {spread['as it came']:.1f} %, and "
        f"after division of {spread['divided by power']:.1f} %."
    ),
)

# %% [markdown]
# The power swings by {glue:text}`power_swing:.0f` % of its mean. Division brings the spread of the
# lines' amplitudes from {glue:text}`before:.1f` to {glue:text}`after:.1f` %; what is left drifted
# within a line. The phases are what they were: a factor common to all values of a point takes no
# part in them. So the division serves brightness, and every method that cuts at its edges.
#
# ## Which wrap?
#
# One wrap is {glue:text}`wrap_mrad:.1f` mrad of the beat, and noise alone, as foretold, has a
# standard deviation of {glue:text}`beat_foretold:.1f` mrad there at a typical pixel. Pixel by pixel
# (`crt-ml`) that leaves little. The other methods pool over pixels that belong together: in a fixed
# window (`beat`), in regions cut where phase or brightness steps (`region`), by smoothness (`mrf`),
# or over surfaces (`cmtof`). Below they stand side by side on the scan, and on what the instrument
# would have brought without one of its ills. Counted are the whole wraps by which the depth is off.

# %%
METHODS = {
    "crt-ml": ("crt-ml", {}),
    "beat": ("beat", {}),
    "beat, small window": ("beat", {"window": window}),
    "region": ("region", {}),
    "mrf": ("mrf", {}),
    "cmtof": ("cmtof", {}),
}


def as_measurement(counts):
    """Correlations of a model's counts, with the scan's own calibration."""
    volts = volts_from_counts(counts, volts_range=settings.detection.range)
    return Measurement.from_arrays(volts.astype(np.float32), data["psi"].to_numpy(),
                                   measurement.frequencies, camera=plan.camera)  # fmt: skip


optics = given.optics
without_one = {
    "without noise": quiet,
    "without speckle": replace(given, optics=replace(optics, speckle=False)),
    "without back-reflection": replace(given, optics=replace(optics, back_fraction=0.0)),
    "without any of the three": replace(smooth, optics=replace(smooth.optics, back_fraction=0.0)),
}
seen = {name: as_measurement(asked(World(one, scene, seed=seed)))
        for name, one in without_one.items()}  # fmt: skip
later = [asked(model, shift=n * plan.bursts) for n in range(1, repeats)]
variants = {"as scanned": measurement,
            "the mean of several scans": as_measurement(np.mean([direct, *later], axis=0)),
            **seen}  # fmt: skip


# %%
def wraps_off(result):
    """Whole wraps (H, W) between a result and the truth."""
    return np.abs(np.rint((result["depth"].to_numpy() / index - truth) / period))


answers = {
    (name, label): cmtof.unwrap(one, method=method, **options)
    for name, one in variants.items()
    for label, (method, options) in METHODS.items()
}
right = {key: 100 * float(np.nanmean(wraps_off(one) < 1)) for key, one in answers.items()}
close = {key: 100 * float(np.nanmean(wraps_off(one) < 3)) for key, one in answers.items()}
table = ["| | " + " | ".join(METHODS) + " |", "| --- |" + " --: |" * len(METHODS)]
for name in variants:
    cells = [f"{right[name, m]:.0f} ({close[name, m]:.0f})" for m in METHODS]
    table.append(f"| {name} | {' | '.join(cells)} |")
glue("methods", Markdown("\n".join(table)), display=False)

# %%
best = max(METHODS, key=lambda method: right["as scanned", method])
pooling = [method for method in METHODS if method != "crt-ml"]


def gained(name, methods):
    """Points of right pixels that a variant gains, on average over methods."""
    return np.mean([right[name, m] - right["as scanned", m] for m in methods])


steep = np.concatenate([np.abs(np.diff(truth, axis=axis)).ravel() > period / 2 for axis in (0, 1)])
say("methods_say",
    f"On the scan as it is, `{best}` gets furthest: {right['as scanned', best]:.0f} % of the "
    f"pixels have the right wrap, {close['as scanned', best]:.0f} % are off by two at most.",
    " ".join(f"{name.capitalize()}, `crt-ml` gains {gained(name, ['crt-ml']):+.0f} points and the "
             f"others {gained(name, pooling):+.0f} on average." for name in without_one),
    f"{100 * steep.mean():.0f} % of neighbouring pixels differ by more than half a wrap.",
)  # fmt: skip
tell(averaged=repeats, window_px=window)

# %% [markdown]
# ```{glue:md} methods
# :format: myst
# ```
#
# Pixels with the right wrap in %; in brackets those off by two wraps at most. The mean is that of
# {glue:text}`averaged:.0f` scans, the small window one of {glue:text}`window_px:.0f` px.
#
# ```{glue:md} methods_say
# :format: myst
# ```
#
# Pooling divides noise by the root of the number of pixels. It does not divide what these pixels
# have in common: at an edge the spot lies on both surfaces, on a slope its far side weighs less
# than its near one, and there the beat is off by whole wraps however long one measures. And pools
# must not mix: in an image of so few points neighbours often lie more than half a wrap apart, and
# a region that takes them for one surface goes astray with no noise at all. A surface of a few
# hundred pixels is then right or wrong as a whole, and a little change of the data can move it by
# a wrap: so the shares of `region`, `mrf` and `cmtof` jump from row to row. `cmtof` was made for
# much wider images, where shape tells the distance, see {doc}`11_surfaces`. A window small
# enough to stay on one surface errs less, and one that spans the image most. So a scan for depth
# wants its points dense rather than spread, and a small spot.
#
# ## Depth

# %%
chosen = answers["as scanned", best]
depth = chosen["depth"].to_numpy() / index
off_by = np.rint((depth - truth) / period)
residual = depth - truth - off_by * period
noise_depth = foretold[0] / TAU * period
tell(residual=1e6 * typical(residual), residual_foretold=1e6 * 0.6745 * np.median(noise_depth))
glue("best", f"{best}", display=False)

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 4, figsize=(12.4, 3.1))
limits = (float(np.nanmin(truth)), float(np.nanmax(truth)))
plotting.image(axes[0], truth, label="range (m)", title="truth", limits=limits)
plotting.image(axes[1], depth, label="range (m)", title=f"scan, {best}", limits=limits)
plotting.image(axes[2], off_by, label="wraps", title="off by", cmap="coolwarm", limits=(-5, 5))
plotting.image(axes[3], 1e3 * residual, label="error (mm)", title="but for wraps",
               cmap="coolwarm", limits=(-0.2, 0.2))  # fmt: skip
plotting.label_panels(axes)
plotting.save(
    figure,
    "scan_depth",
    numbers={
        "right": {m: right["as scanned", m] for m in METHODS},
        "close": {m: close["as scanned", m] for m in METHODS},
        "best": best,
        "residual_um": 1e6 * typical(residual),
    },
    caption=(
        f"Range of the scene and of the scan (`{best}`), whole wraps by which they differ, and "
        "what is left when these are taken out."
    ),
    alt=(
        f"Four images: the true range, the range found with {best}, "
        f"{right['as scanned', best]:.0f} % of whose pixels have the right wrap, the wraps "
        f"by which it is off, and a remaining error of {1e6 * typical(residual):.0f} µm in the "
        "median."
    ),
    format="png",
)

# %% [markdown]
# But for whole wraps the depth is right to {glue:text}`residual:.0f` µm in the median; noise alone
# would leave {glue:text}`residual_foretold:.0f` µm. The precision of the phase is there. What a
# scan of this size lacks is the integer.
#
# ## Killed, and resumed
#
# A scan of the real instrument takes minutes, and computers stop when they like. Here one is
# started from the command line and killed by `SIGKILL`, against which no program can do anything,
# once half of its lines are recorded. On a bench the RF drivers' dead man's timers would now turn
# RF off, and the read-out's watchdog close the shutter. Then it is resumed, as `--resume` does it,
# before an instrument that was switched off and on.

# %%
killed_plan = planned(rig.settings, size=killed_size)
half = len(killed_plan.lines) // 2
around = os.environ | {"TMPDIR": str(here)}


command = ["scan", "--twin", "--scene", scene, "--size", killed_size, "--seed", seed,
           "-o", here / "k.nc", "--quiet"]  # fmt: skip


def recorded(output):
    path = journal_path(here / output)
    return len(read_journal(path)[1]) if path.exists() else 0


victim = subprocess.Popen(
    [sys.executable, "-m", "cmtof.cli", *map(str, command)],
    env=around,
    stdout=subprocess.PIPE,
    stderr=subprocess.STDOUT,
)
deadline = time.monotonic() + 120
while recorded("k.nc") < half and victim.poll() is None and time.monotonic() < deadline:
    time.sleep(0.01)
victim.send_signal(signal.SIGKILL)
victim.communicate()
readable = half <= recorded("k.nc") and not (here / "k.nc").exists()

# %%
for output, resume in (("k.nc", True), ("whole.nc", False)):
    with Twin.default(seed=seed, scene=scene) as fresh:
        scan(fresh.rig, killed_plan, here / output, resume=resume, seed=seed, scene=scene)
identical = (here / "k.nc").read_bytes() == (here / "whole.nc").read_bytes()
print("killed in the middle:", readable, "- identical:", identical)
say("kill_says",
    f"It was killed when {half} of {len(killed_plan.lines)} lines or more were in the journal.",
    "The resumed file and that of an uninterrupted scan are identical, byte for byte."
    if readable and identical else "The resumed file DIFFERS from that of an uninterrupted scan.",
    f"Both are {(here / 'k.nc').stat().st_size / 1e3:.0f} kB.")  # fmt: skip
folder.cleanup()

# %% [markdown]
# ```{glue:md} kill_says
# :format: myst
# ```
#
# The journal loses at most the line that was being taken. What is in it can be exported at any
# time, and a scan that is resumed refuses one of other settings, so that two halves which do not
# belong together never meet.
