# %% [markdown]
# # A scan from instrument to depth
#
# What happens between the laser and a depth map, and which errors enter on the way?
#
# A small scene is scanned as on the real instrument: with the same plan, checks, journal and
# reduction, but simulated devices, so the truth is known. The [hardware page](../book/hardware.md)
# has the same on a bench.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of the simulated instrument
scene: str = "still_life"  # embedded frame before it
field_of_view_deg: float = 10.0  # optical angle across and down
size: int = 48  # height and width of the image, px
repeats: int = 6  # scans averaged in the comparison of methods

# %% tags=["hide-input"]
import tempfile
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cmtof
from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU, centred, decode, phase_from_depth, wrap_length
from cmtof.hardware.plan import MODES, plan_scan
from cmtof.hardware.rig import Rig
from cmtof.hardware.scan import scan
from cmtof.measurement import Measurement
from cmtof_book import notes, plotting
from cmtof_lab.electronics import SLOPE, density, volts_from_counts
from cmtof_lab.rehearsal import scan_scene, simulated_bench
from cmtof_lab.settings import TwinSettings

plotting.begin(profile=profile, seed=seed)


def typical(error):
    """Median of the absolute error: edges of objects must not decide it."""
    return np.nanmedian(np.abs(error))


# %% [markdown]
# ## Plan, scan, images
#
# Each mode is taken in one sequence: dark level behind the closed shutter, a reference target at
# known distances, every line of the image, and the reference target again, to measure drift.
# Between the modes both half-wave plates turn.

# %%
rig = replace(Rig.default(), field_of_view_deg=(field_of_view_deg, field_of_view_deg))
plan = plan_scan(rig, size=size)
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "m.nc")
    measurement = scan(plan, lambda: simulated_bench(rig, scene, seed=seed), file)
data = measurement.dataset
given = TwinSettings()
print(measurement, f"{plan.lines[-1].labels[-1]} bursts in {len(plan.lines)} lines")

# %% tags=["hide-input"]
bench = simulated_bench(rig, scene, seed=seed)
index = float(data.attrs["group_index"])
truth = bench.daq.instrument.ranges(plan.angles).reshape(size, size)
ideal_phase = np.stack(
    [phase_from_depth(index * truth, f) for f in measurement.frequencies]
)
error = centred(measurement.phase - ideal_phase)
period = wrap_length(measurement.frequencies[0]) / index
wrap_in_beat = TAU * (measurement.frequencies[1] / measurement.frequencies[0] - 2)
tones = [f"{f / 1e9:.2f} GHz" for f in measurement.frequencies]
print(
    f"{np.nanmin(truth):.2f} to {np.nanmax(truth):.2f} m, {np.ptp(truth) / period:.0f} wraps of "
    f"{1e3 * period:.2f} mm"
)

# %% tags=["hide-input"]
figure, axes = plotting.grid(3, 3, 1)
plotting.image(
    axes[0], 1e3 * measurement.amplitude[0], label="", title="amplitude (mV)"
)
for ax, phase, tone in zip(axes[1:], measurement.phase, tones, strict=True):
    plotting.phase_image(ax, np.mod(phase, TAU), title=f"phase, {tone}", label="")
plotting.label_panels(axes)
plotting.save(
    figure,
    "scan_images",
    caption="A scan simulated at the photon limit: amplitude and wrapped phases.",
    alt="Three images: an amplitude grainy with speckle, fringes of phase over the scene, and "
    "finer ones at the doubled frequency, which alias on the table.",
    format="png",
)

# %% [markdown]
# ## One point
#
# At each point the read-out samples the detector while its trigger line steps the phase of the
# detection module's drive: 16 phases of 20 samples. Here one burst is repeated; noise and drift
# depend on its number alone.

# %% tags=["hide-input"]
row = column = size // 3
raw = {}
bench.set_up()
for mode in MODES:
    bench.choose_mode(mode)
    bench.look_at("scan")
    label = next(one for one in plan.lines if one[1:4] == (mode, "scan", row)).labels[
        column
    ]
    raw[mode] = bench.bursts([label], bench.mirror_outputs(plan.angles[row, [column]]))
bench.close_and_park()

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.5))
instant = 1e3 * np.arange(rig.scans) / rig.rate
fine = TAU / 200 * np.arange(201)
for number, (mode, colour) in enumerate(zip(MODES, ("C0", "C1"), strict=True)):
    axes[0].plot(instant, raw[mode][0], ".", ms=2.5, color=colour, label=mode)
    values = data["correlation"].to_numpy()[number, :, row, column]
    psi = data["psi"].to_numpy()[number]
    fit = decode(values, psi)
    axes[1].plot(psi, 1e3 * values, "o", ms=4, color=colour)
    axes[1].plot(
        fine,
        1e3 * (fit.offset + fit.amplitude * np.cos(fit.phase + fine)),
        color=colour,
    )
axes[0].set(xlabel="time (ms)", ylabel="converter (counts)", title="one burst")
axes[1].set(
    xlabel="reference phase ψ (rad)",
    ylabel="above the dark (mV)",
    title="means and fit",
)
axes[0].legend()
plotting.label_panels(axes)
plotting.save(
    figure,
    "scan_point",
    caption="(a) Simulated samples of one point in both modes, photon limit. (b) Means, and fits.",
    alt="Left: samples of two bursts in 16 steps through one period of a cosine; right: their "
    "means on fitted cosines.",
)

# %% [markdown]
# ## Calibration by the reference target
#
# Counts are converted to volts, the dark level is subtracted, and each line is divided by its laser
# power. The zero of ψ remains unknown: the path ℓ within the instrument and the lag of the
# detection's cable shift it by
#
# $$\psi_0 = \frac{4\pi f\,\ell}{c} - m\,\varphi_\mathrm{cable},\qquad m = 1, 2.$$
#
# The target stands at known distances over one whole wrap, so that back-reflected light averages
# out. The remaining offset is negligible as depth, but matters in the beat: a wrap is 17.6 mrad.

# %% tags=["hide-input"]
found, drift = (data[name].to_numpy() for name in ("phase_offset", "phase_drift"))
paths = 4 * np.pi * measurement.frequencies * given.internal_path / SPEED_OF_LIGHT
wanted = centred(paths - np.array([1, 2]) * given.phase_offset)
off = centred(found - wanted)
notes.table(
    [
        "",
        "put in (rad)",
        "found (rad)",
        "off by (mrad)",
        "drift during the image (mrad)",
    ],
    [
        [
            mode,
            f"{wanted[n]:.4f}",
            f"{found[n]:.4f}",
            f"{1e3 * off[n]:+.2f}",
            f"{1e3 * drift[n]:+.2f}",
        ]
        for n, mode in enumerate(MODES)
    ],
)
beat_off = centred(off[1] - 2 * off[0])
print(
    f"the beat is off by {1e3 * beat_off:.2f} mrad, {beat_off / wrap_in_beat:.3f} wraps"
)

# %% [markdown]
# ## Sources of error
#
# The same bursts are repeated with parts of the simulation switched off in turn: noise, speckle,
# the size of the spot, back-reflected light, errors of the RF drivers. The rest comes from the
# finite steps of the converter that steers the mirrors. The noise is also predicted from the
# counts, $\sigma_\varphi = \sqrt{2/K}\;\sigma_U/a$.


# %%
def scanned(settings, shift=0):
    """Correlations (mode, step, H, W) of the instrument with other settings, V."""
    view = float(np.deg2rad(field_of_view_deg))
    one = scan_scene(settings, scene, size=size, field_of_view=view, seed=seed + shift)
    return one.dataset["correlation"].to_numpy()


quiet = replace(given, noise=False)
smooth = replace(quiet, speckle=False)
fine = replace(smooth, divergence=0.0, exit_radius=0.0)
clear = replace(fine, back_fraction=0.0)
ideal = replace(
    clear, phase_drift=0.0, phase_step_error=0.0, iq_imbalance=0.0, leakage=0.0
)

# %% tags=["hide-input"]
psi = data["psi"].to_numpy()
CAUSES = ("noise", "speckle", "spot", "back-reflection", "RF drivers")
steps = [
    decode(one, psi).phase
    for one in (
        data["correlation"].to_numpy(),
        *map(scanned, (quiet, smooth, fine, clear, ideal)),
    )
]
causes = {
    name: centred(a - b) for name, a, b in zip(CAUSES, steps, steps[1:], strict=False)
}
rest = centred(steps[-1] - ideal_phase)
causes |= {
    "mirror steps": rest - np.nanmedian(rest, axis=(1, 2), keepdims=True),
    "all": error,
}
sizes = {
    name: [1e3 * typical(e) for e in (e[0], e[1], centred(e[1] - 2 * e[0]))]
    for name, e in causes.items()
}
kept_time = (rig.samples_per_phase - rig.settle_samples) / rig.rate
level = (
    measurement.decoded.offset
    + volts_from_counts(data["dark"].to_numpy())[:, None, None]
)
shot = density(given, np.maximum(level, 0))
converter = (given.converter_noise * SLOPE) ** 2 / (kept_time * rig.rate)
expected = np.sqrt(2 / rig.phases * (shot / (2 * kept_time) + converter))
expected = expected / measurement.amplitude
pulls = [np.median(np.abs(p)) / 0.6745 for p in causes["noise"] / expected]
print(f"scatter of the noise over its prediction: {pulls[0]:.2f} and {pulls[1]:.2f}")

# %% tags=["hide-input"]
figure, ax = plt.subplots()
columns = np.transpose(list(sizes.values()))
plotting.dots(ax, dict(zip((*tones, "beat"), columns, strict=True)), list(sizes))
plotting.mark(ax, x=500 * wrap_in_beat, text="half a wrap in the beat")
ax.set(xscale="log", xlim=(0.05, None), xlabel="median phase error (mrad)")
ax.legend()
plotting.save(
    figure,
    "scan_errors",
    caption=(
        "Median phase error by its cause, simulated at the photon limit, in both modes and in "
        "their beat, which determines the wraps."
    ),
    alt="Dots on a logarithmic scale: speckle is the largest cause in either phase, noise in the "
    "beat.",
)

# %% [markdown]
# Speckle shifts a phase because the spot is extended: its bright grains lie on the near or the far
# side of a slope. This is a real displacement, equal in both modes, so most of it cancels in the
# beat. So do the mirrors' steps. Noise does not cancel; most of it comes from the doubled mode,
# which has less contrast. Back-reflected light is a constant phasor that affects weak echoes most,
# in each mode differently. A short scan with a covered beam measures it, and
# `Measurement.without_stray_light` takes it away, as in [chapter 21](21_scanned_scenes.ipynb).

# %% [markdown]
# ## Unwrapping
#
# In a single pixel (`crt-ml`) the noise of the beat, about 15 mrad, exceeds half of the 17.6 mrad
# of a wrap. The other methods pool over pixels: in a fixed window (`beat`), in regions bounded by
# steps of phase or brightness (`region`), by smoothness (`mrf`), or over surfaces. The table has
# the share of right wraps, and in brackets the share of those that are off by two at most.

# %% tags=["hide-input"]
METHODS = ("crt-ml", "beat", "region", "mrf", "surfaces")


def as_measurement(correlation):
    """Measurement with the scan's own calibration."""
    values = np.asarray(correlation, np.float32)
    return Measurement.from_arrays(
        values, psi, measurement.frequencies, camera=plan.camera
    )


variants = {
    "as scanned": measurement,
    "the mean of several scans": as_measurement(
        np.mean(
            [data["correlation"], *(scanned(given, n) for n in range(1, repeats))],
            axis=0,
        )
    ),
    "without noise": as_measurement(scanned(quiet)),
    "without back-reflection": as_measurement(
        scanned(replace(given, back_fraction=0.0))
    ),
}
answers = {
    (name, method): cmtof.unwrap(one, method=method)["depth"].to_numpy() / index
    for name, one in variants.items()
    for method in METHODS
}
wraps = {
    key: np.abs(np.rint((depth - truth) / period)) for key, depth in answers.items()
}
right, close = (
    {key: 100 * np.nanmean(w < n) for key, w in wraps.items()} for n in (1, 3)
)

# %% tags=["hide-input"]
notes.table(
    ["right wraps in %", *METHODS],
    [
        [k, *(f"{right[k, m]:.0f} ({close[k, m]:.0f})" for m in METHODS)]
        for k in variants
    ],
)
best = max(METHODS, key=lambda method: right["as scanned", method])
depth = answers["as scanned", best]
off_by = np.rint((depth - truth) / period)
residual = depth - truth - off_by * period
print(
    f"{best}: error apart from whole wraps {1e6 * typical(residual):.0f} µm; noise alone "
    f"{1e6 * 0.6745 * np.median(expected[0]) / TAU * period:.0f} µm"
)

# %% tags=["hide-input"]
figure, axes = plotting.grid(4, 2, 0.7)
limits = (np.nanmin(truth), np.nanmax(truth))
plotting.image(axes[0], truth, label="range (m)", title="truth", limits=limits)
plotting.image(axes[1], depth, label="range (m)", title=f"scan, {best}", limits=limits)
for ax, values, words, end in (
    (axes[2], off_by, ("wraps", "off by"), 5),
    (axes[3], 1e3 * residual, ("error (mm)", "but for wraps"), 0.2),
):
    plotting.image(
        ax, values, label=words[0], title=words[1], cmap="coolwarm", limits=(-end, end)
    )
plotting.label_panels(axes)
plotting.save(
    figure,
    "scan_depth",
    caption="True range of the scene; range of the scan, simulated at the photon limit and "
    f"unwrapped by `{best}`, the best method; its error in whole wraps, and the rest.",
    alt="Four images: true range, scanned range, wraps by which it is off, and a remaining error, "
    "from tens of micrometres on bright bodies to tenths of a millimetre on the table.",
    format="png",
)

# %% [markdown]
# Pooling reduces noise, but not errors that pixels share: at an edge the spot lies on both
# surfaces, and the beat is off by whole wraps however long one measures. In an image of so few
# points neighbours often lie more than half a wrap apart, so a scan for depth needs dense points
# and a small spot.
#
# Every line of a scan is recorded in a journal. A scan that is killed goes on from there with
# `--resume`, and ends with the file of an uninterrupted one, byte for byte (the tests kill scans at
# random moments).

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** At the photon limit the phases are accurate to {first:.0f} and {second:.0f} mrad,
    and depth, apart from whole wraps, to {depth:.0f} µm. But a scan of {points:,} points hardly
    determines the wraps: the best method has {right:.0f} % of them right.
    """,
    first=1e3 * typical(error[0]),
    second=1e3 * typical(error[1]),
    depth=1e6 * typical(residual),
    points=size**2,
    right=right["as scanned", best],
)
