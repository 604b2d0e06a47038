# %% [markdown]
# # The instrument
#
# Section 7 of the paper lists the parts of a prototype; its drawings and code were never published.
# This page draws the instrument that the rig file of this package describes (Fig. 6), and follows
# the light through it: how many photons arrive, what noise they have to beat, and where our
# settings differ from the paper's. Everything is *simulated*: the same drivers would command real
# devices, but no real one has been measured here.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of random draws; none here
distance: float = 1.0  # range of the target in the budget, m
reflectance: float = 0.5  # of that target, diffuse
points: int = 120  # ranges on the axis of the last figure

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from myst_nb import glue

from cmtof.book import paper, plotting
from cmtof.book.paper import quantity_text
from cmtof.book.schematic import SIZE, draw_instrument
from cmtof.correlation import wrap_length
from cmtof.hardware.rig import Rig
from cmtof.instrument.budget import photon_budget
from cmtof.instrument.electronics import SLOPE, Conversion, chain
from cmtof.instrument.settings import TwinSettings

run = plotting.begin(profile=profile, seed=seed)
COLOURS = {"single": plotting.PALETTE["blue"], "doubled": plotting.PALETTE["vermillion"]}
rig = Rig.default()
twin = TwinSettings.from_mapping(rig.twin)


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, float(value), display=False)


# %% [markdown]
# ## The drawing
#
# Light leaves the laser, loses most of itself in a fibre that makes its beam round, and passes the
# emission module: a polarising splitter, two wave plates, the crystal and a mirror, so that it
# passes the crystal twice ({doc}`04_modulator`). A first splitter gives half to a power
# meter, a second one half to the arm of the interferometer; the rest goes over the scan mirrors to
# the scene. What comes back takes the same way to the second splitter, which sends it into the
# detection module, a twin of the first. There it is multiplied by the reference: behind that, a
# slow detector will do.
#
# A few electric lines hold this together. Both RF drivers run on one clock. The detection's driver
# holds a table of phases, and each rising edge from the read-out moves it on by one, so that
# samples and phases stay in step with no dialogue. The same device sets the mirrors' voltages and
# switches laser, shutter, flip mirror and beam block.

# %% tags=["hide-input"]
figure, ax = plt.subplots(figsize=(11.0, 11.0 * SIZE[1] / SIZE[0]))
draw_instrument(ax, rig, twin)
devices = ", ".join(role.replace("_", " ") for role in rig.devices)
plotting.save(
    figure,
    "fig06_instrument",
    numbers={
        "devices": list(rig.devices),
        "mirror_distance": [twin.emission.mirror_distance, twin.detection.mirror_distance],
        "drive_frequencies": [rig.drive.frequency_single, rig.drive.frequency_doubled],
    },
    caption=(
        f"The instrument of the rig file «{rig.name}», not to scale: path of the light, drive, "
        "clock and signal, the terminals that switch it, and each device's driver and address. "
        "Addresses are those of the simulated devices. A number of folding mirrors is left out."
    ),
    alt=(
        "Plan of an optical table in three rows. Top: laser, shutter, fibre, beam reducer and the "
        "emission module with splitter, wave plates, modulator and mirror. Middle: two beam "
        "splitters to a power meter and a reference arm, flip mirror, galvo and scene. Bottom: "
        "beam reducer, the detection module, avalanche diode, low pass, RC and read-out. Above, a "
        "clock feeds both RF drivers. Below, a line from the host to "
        f"{len(rig.devices)} numbered devices: {devices}."
    ),
)

# %% [markdown]
# ## Where the light goes
#
# A diffuse target of reflectance {glue:text}`target_reflectance:.1f` stands
# {glue:text}`target_distance:.1f` m away. Of what reaches it, the aperture of the instrument sees
#
# $$\frac{P_\mathrm{collected}}{P_\mathrm{sent}} = \frac{\varrho}{2}\,\frac{A}{\pi z^2},$$
#
# with the aperture's area $A$; the factor ½ is the polarisation that the splitter cannot use.
# (A diffuse surface is taken to scramble polarisation.) That one step costs
# {glue:text}`collected:.1f` powers of ten; all losses before and behind it together cost
# {glue:text}`others:.1f`.

# %%
budgets = {
    mode: {
        line.name: line
        for line in photon_budget(twin, mode=mode, distance=distance, reflectance=reflectance)
    }
    for mode in ("single", "doubled")
}


def amount(line):
    """Value of a line as a reader would write it."""
    if line.unit in ("V", "rad"):
        return f"{1e3 * line.value:.3g} m{line.unit}"
    if line.value >= 1e4 or (line.unit == "1" and line.value < 1e-3):
        digits, _, power = f"{line.value:.2e}".partition("e")
        return f"{digits}·10<sup>{int(power)}</sup>" + " /s" * (line.unit == "1/s")
    if line.unit == "1":
        return f"{line.value:.3f}"
    return f"{line.value:.0f} Hz" if line.unit == "Hz" else quantity_text(line.value, line.unit)


lines = ["| | single | doubled | from |", "| --- | --: | --: | --- |"]
for name, one in budgets["single"].items():
    cells = amount(one), amount(budgets["doubled"][name])
    lines.append(f"| {name} | {cells[0]} | {cells[1]} | {one.source} |")
glue("budget", Markdown("\n".join(lines)), display=False)
tell(target_distance=distance, target_reflectance=reflectance)

# %% [markdown]
# ```{glue:md} budget
# :format: myst
# ```

# %% tags=["hide-input"]
STEPS = ("Fibre", "Emission module", "Optics to the scene", "Share collected", "Detection path")
figure, ax = plt.subplots(figsize=(9.2, 4.4))
power = {}
for row, (mode, budget) in enumerate(budgets.items()):
    level = budget["Laser"].value
    shift = 0.2 * (2 * row - 1)
    ax.plot([level] * 2, [-1.45, -0.55], color=plotting.PALETTE["black"], lw=2.5)
    for place, name in enumerate(STEPS):
        after = level * budget[name].value
        ax.barh(place + shift, level - after, left=after, height=0.36, color=COLOURS[mode],
                label=f"{mode} mode" if place == 0 else None)  # fmt: skip
        ax.text(after / 1.25, place + shift, f"\u2212{-10 * np.log10(budget[name].value):.1f} dB",
                va="center", ha="right", fontsize=9, color=COLOURS[mode])  # fmt: skip
        ax.plot([after] * 2, [place + shift - 0.18, min(place + 1 + shift, len(STEPS) - 0.4)],
                color=COLOURS[mode], lw=0.8, ls=":", zorder=1)  # fmt: skip
        level = after
    power[mode] = level
ax.text(1.3 * budgets["single"]["Laser"].value, -1, f"{1e3 * twin.laser.power:.0f} mW",
        va="center")  # fmt: skip
for row, mode in enumerate(budgets):
    ax.text(power[mode] / 1.4, len(STEPS) - 0.25 + 0.42 * row,
            f"on the detector: {quantity_text(power[mode], 'W')}", color=COLOURS[mode],
            ha="left", va="center", fontsize=9)  # fmt: skip
ax.set(xscale="log", xlim=(5e-12, 3), ylim=(len(STEPS) + 0.45, -1.5), xlabel="power (W)")
ax.set_yticks(range(-1, len(STEPS)), ["Laser", *STEPS])
ax.grid(visible=False, axis="y")
ax.legend(loc="lower right")
loss = {m: -10 * np.log10(p / twin.laser.power) for m, p in power.items()}
plotting.save(
    figure,
    "instrument_budget",
    numbers={"detected_power": list(power.values()), "loss_db": list(loss.values())},
    caption=(
        f"From the laser to the detector, for a diffuse target of reflectance {reflectance:.1f} at "
        f"{distance:.1f} m (simulated): each bar is what a step loses, in decibels of power."
    ),
    alt=(
        "Waterfall of bars on a logarithmic axis of power, for both modes. Five steps lead from "
        f"{1e3 * twin.laser.power:.0f} milliwatt down by {loss['single']:.0f} decibels in the "
        f"single and {loss['doubled']:.0f} in the doubled mode; the longest by far is the share of "
        "the scattered light that the aperture collects."
    ),
)
sent = {mode: budget["Sent to the scene"].value for mode, budget in budgets.items()}
photons = {mode: budget["Photons in a point"].value for mode, budget in budgets.items()}
tell(
    loss_single=loss["single"],
    loss_doubled=loss["doubled"],
    sent_single=1e3 * sent["single"],
    sent_doubled=1e3 * sent["doubled"],
    photons_single=photons["single"] / 1e6,
    photons_doubled=photons["doubled"] / 1e6,
    collected=-np.log10(budgets["single"]["Share collected"].value),
    others=loss["single"] / 10 + np.log10(budgets["single"]["Share collected"].value),
    fewer=power["single"] / power["doubled"],
    weaker=budgets["single"]["Amplitude of the correlation"].value
    / budgets["doubled"]["Amplitude of the correlation"].value,
)

# %% [markdown]
# {glue:text}`photons_single:.1f` million photons of a point in the single mode and
# {glue:text}`photons_doubled:.1f` million in the doubled one: the doubled mode passes less light
# in either module, {glue:text}`fewer:.1f` times less in both, and the amplitude of its correlation
# is {glue:text}`weaker:.1f` times weaker. What it buys for that is a wave of half the length.
#
# ## Which noise wins
#
# Three noises meet at the input of the converter. *Shot noise* of the light, multiplied by the
# avalanche with its excess factor $F = M^x$, grows with the square root of the output $U$; the
# *amplifier's* and the *converter's* do not depend on it:
#
# $$\sigma^2 = \bigl(2 e F M R_T\,U + s_\mathrm{amp}^2\bigr)\,B + \sigma_\mathrm{conv}^2,$$
#
# with the transimpedance $R_T$, the amplifier's density $s_\mathrm{amp}$ and the noise bandwidth
# $B$ of the filters. Averaged over the samples of one phase, for a time $T$, white noise counts
# with $B = 1/2T$, and the converter's with one over the number of samples.

# %%
conversion, filters = (
    Conversion(twin.detector, twin.laser.wavelength),
    chain(twin.detector, 1 / rig.detection.rate),
)
phase_time = rig.detection.samples_per_phase / rig.detection.rate
output = np.geomspace(1e-4, twin.detector.saturation, points)
shot = np.sqrt((conversion.density(output) - conversion.density(0)) / (2 * phase_time))
amplifier = np.sqrt(conversion.density(0) / (2 * phase_time))
converter = twin.detector.converter_noise * SLOPE / np.sqrt(rig.detection.samples_per_phase)
quantum = (20 / 2**14) / np.sqrt(12) / np.sqrt(rig.detection.samples_per_phase)
even = float(np.interp(1.0, shot / amplifier, output))
print(f"one phase: amplifier {1e6 * amplifier:.0f} µV, converter {1e6 * converter:.0f} µV")
print(f"shot noise exceeds the amplifier's above {1e3 * even:.0f} mV of output")

# %% [markdown]
# The phase of a point with 16 steps then has the noise $\sqrt{2/16}\,\sigma/a$, a being the
# amplitude of the correlation, and range follows by $c/4\pi f$.


# %%
def point(mode, z, rho):
    return {
        line.name: line.value
        for line in photon_budget(twin, mode=mode, distance=z, reflectance=rho)
    }


ranges = np.geomspace(0.2, 8.0, points)
curves = {
    (mode, rho): [point(mode, z, rho) for z in ranges]
    for rho in (reflectance, 0.05)
    for mode in COLOURS
}
frequency = {"single": rig.drive.frequency_single, "doubled": 2 * rig.drive.frequency_doubled}


def curve(mode, rho, name):
    return np.array([found[name] for found in curves[mode, rho]])


# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 3, figsize=(11.0, 4.5))
styles = {reflectance: "-", 0.05: "--"}
for (mode, rho), _ in curves.items():
    look = {"color": COLOURS[mode], "ls": styles[rho]}
    label = f"{mode}, ϱ = {rho:g}"
    crest = 1 + budgets[mode]["Correlation contrast"].value
    clips = crest * curve(mode, rho, "Detector output") > twin.detector.saturation
    photon_count = np.where(clips, np.nan, curve(mode, rho, "Photons in a point"))
    axes[0].plot(ranges, photon_count, label=label, **look)
    spread = curve(mode, rho, "Phase noise of a point")
    depth = wrap_length(frequency[mode]) / (2 * np.pi) * spread
    axes[2].plot(ranges, 1e6 * np.where(clips, np.nan, depth), **look)
axes[0].set(title="photons in a point", ylabel="photons in 16 phases", xlabel="range (m)")
axes[2].set(title="noise of the range", ylabel="one point, rms (µm)", xlabel="range (m)")
for ax in (axes[0], axes[2]):
    ax.set(xscale="log", yscale="log", xlim=(0.2, 8))
    ax.set_xticks([0.2, 0.5, 1, 2, 5], ["0.2", "0.5", "1", "2", "5"])
    ax.set_xticks([], minor=True)

# %% tags=["hide-input"]
axes[0].legend(fontsize=8.5, loc="lower left", handlelength=1.8)
black, purple, sky = (plotting.PALETTE[c] for c in ("black", "purple", "sky"))
axes[1].loglog(1e3 * output, 1e6 * shot, color=plotting.PALETTE["green"], label="shot noise")
axes[1].axhline(1e6 * amplifier, color=black, ls="-.", label="amplifier")
axes[1].axhline(1e6 * converter, color=purple, ls="--", label="converter, 16 bit")
axes[1].axhline(1e6 * quantum, color=purple, ls=":", label="rounding to 14 bit")
total = np.sqrt(shot**2 + amplifier**2 + converter**2)
axes[1].plot(1e3 * output, 1e6 * total, color="#9AA4AD", lw=4, alpha=0.5, zorder=1, label="sum")
for mode, colour in COLOURS.items():
    at = budgets[mode]["Detector output"].value
    axes[1].plot(1e3 * at, 1e6 * np.interp(at, output, total), "o", ms=7, color=colour, zorder=5)
axes[1].set(title="noise of one phase", xlabel="output of the detector (mV)", ylabel="rms (µV)",
            ylim=(8, 4e3), xlim=(0.1, 4.1e3))  # fmt: skip
axes[1].legend(fontsize=8.5, loc="upper left", handlelength=1.8)
plotting.label_panels(axes)
crossing = {
    mode: float(np.interp(-even, -curve(mode, reflectance, "Detector output"), ranges))
    for mode in COLOURS
}
microns = {
    mode: 1e6 * wrap_length(frequency[mode]) / (2 * np.pi) * budget["Phase noise of a point"].value
    for mode, budget in budgets.items()
}
room = 1e3 * conversion.volts(
    [budget["Room light on the detector"].value for budget in budgets.values()]
)
plotting.save(
    figure,
    "instrument_photons",
    numbers={
        "photons": list(photons.values()),
        "even_output": even,
        "crossing_range": list(crossing.values()),
        "noise_microns": list(microns.values()),
        "noise_volts": [amplifier, converter, quantum],
    },
    caption=(
        "(a) Photons in a point of 16 phases. (b) Noise of one phase against the detector's "
        f"output; dots: reflectance {reflectance:g} at {distance:g} m in both modes. "
        "(c) What that makes of the range, shot noise to amplifier noise from left to right. "
        "Simulated; curves end where the detector saturates."
    ),
    alt=(
        "Three double logarithmic panels. Photons in a point fall with the square of the range, "
        f"to {photons['single'] / 1e6:.1f} and {photons['doubled'] / 1e6:.1f} million at "
        f"{distance:g} metre. Shot noise crosses the amplifier's at {1e3 * even:.0f} millivolt of "
        "output; the converter's lies below both. The noise of the range grows with it, to "
        f"{microns['single']:.1f} and {microns['doubled']:.1f} micrometre at {distance:g} metre, "
        "and is larger in the doubled mode."
    ),
)
tell(
    even=1e3 * even,
    amplifier=1e6 * amplifier,
    converter=1e6 * converter,
    quantum=1e6 * quantum,
    cross_single=crossing["single"],
    cross_doubled=crossing["doubled"],
    microns_single=microns["single"],
    microns_doubled=microns["doubled"],
    room_single=room[0],
    room_doubled=room[1],
)

# %% [markdown]
# Shot noise dominates where the detector gives more than {glue:text}`even:.0f` mV: for the target
# above, out to {glue:text}`cross_single:.1f` m in the single mode and
# {glue:text}`cross_doubled:.1f` m in the doubled one. Beyond, what is left does not depend on the
# target: the amplifier, and the shot noise of the room's light, which alone gives
# {glue:text}`room_single:.0f` and {glue:text}`room_doubled:.0f` mV. There the noise of the range
# grows with the square of the distance instead of with the distance. The converter's
# {glue:text}`converter:.0f` µV never count beside the amplifier's {glue:text}`amplifier:.0f` µV;
# even the rounding to the 14 bits of the paper, {glue:text}`quantum:.0f` µV after averaging, would
# not. So neither bits nor range of the converter limit this instrument, but light does.
#
# At {glue:text}`target_distance:.1f` m photons alone allow {glue:text}`microns_single:.1f` µm in
# the single mode and {glue:text}`microns_doubled:.1f` µm in the doubled one: *less* precision at
# the higher frequency, since the amplitude falls faster than the wave shortens. Both lie below the
# paper's 33 µm. What a photon budget knows nothing of is larger: drift of the phase, air, light
# that comes back from the optics, the cyclic errors of {doc}`14_correlation_profiles`.

# %% [markdown]
# ## Where we differ from the paper
#
# The settings of the simulation carry a source each; nothing was tuned to the paper's results. Some
# differ from the text, and some had to be assumed.

# %%
said = paper.published_numbers()


def printed(key):
    return quantity_text(said[key].value, said[key].unit)


damped = np.hypot(1, 2 * np.pi / (16 * phase_time) * said["sec7.rc_time"].value)
weak = replace(twin, drive=replace(twin.drive, eta=0.26))
weak_amplitude = {
    mode: {
        line.name: line.value
        for line in photon_budget(weak, mode=mode, distance=distance, reflectance=reflectance)
    }["Amplitude of the correlation"]
    for mode in COLOURS
}
weak_ratio = weak_amplitude["single"] / weak_amplitude["doubled"]
rows = [
    ("RC time constant", printed("sec7.rc_time"), quantity_text(twin.detector.rc_time, "s"),
     f"the printed one would damp the sweep of ψ {damped:.0f} times"),
    ("converter", printed("sec6.bits"), f"{twin.detector.bits} bit",
     "the T7 streams 16 bit"),
    ("drive η", "not stated", f"{twin.drive.eta:.3f} rad",
     f"at 0.26 the doubled signal is {weak_ratio:.0f} times below the single one"),
    ("laser power", "not stated", quantity_text(twin.laser.power, "W"),
     f"gives the printed {printed('sec7.laser_power')} behind the optics"),
    ("resonance", printed("sec6.eom_frequency"), f"{twin.drive.resonance / 1e9:.3f} GHz",
     "between both drives, so that either is within the bandwidth"),
    ("aperture", "not stated", quantity_text(twin.optics.aperture, "m"),
     "a crystal of 2 mm seen through the expander"),
    ("avalanche gain", "not stated", f"{twin.detector.gain:.0f}",
     "middle of the detector's range"),
    ("back-reflection", "not stated", f"{twin.optics.back_fraction:.0e}".replace("e-0", "e-"),
     "of the emitted light; an order of magnitude, no more"),
]  # fmt: skip
lines = ["| | paper | here | why |", "| --- | --- | --- | --- |"]
lines += [f"| {' | '.join(row)} |" for row in rows]
glue("differences", Markdown("\n".join(lines)), display=False)
tell(sent_paper=1e3 * said["sec7.laser_power"].value)

# %% [markdown]
# ```{glue:md} differences
# :format: myst
# ```
#
# *Not verified* is what could not be read in a maker's own document: the detector's noise, gain and
# saturation (from a third party's transcription), its excess noise (that of another diode of the
# kind), the order of the filter EF120 (taken as one pole), the quantum efficiency at 532 nm, the
# reflectances and extinction ratios of mirrors and cubes, the noise of the converter while it
# streams, and every error of the RF drivers, which are nobody's catalogue part. With these settings
# {glue:text}`sent_single:.1f` mW reach the scene in the single mode, where the paper has
# {glue:text}`sent_paper:.0f` mW, and {glue:text}`sent_doubled:.1f` mW in the doubled one, for which
# the paper gives no number.
#
# ## Against the paper

# %%
reached = {
    "sec6.laser_wavelength": twin.laser.wavelength,
    "sec6.eom_frequency": rig.drive.frequency_single,
    "sec6.eom_bandwidth": twin.drive.width,
    "sec7.fibre_throughput_low": twin.laser.fibre_low,
    "sec7.fibre_throughput_high": twin.laser.fibre_high,
    "sec7.beam_after": 2 * twin.optics.exit_radius,
    "sec7.laser_power": sent["single"],
    "sec7.lowpass": twin.detector.low_pass,
    "sec7.sample_rate": rig.detection.rate,
    "sec7.samples_per_phase": rig.detection.samples_per_phase,
    "sec7.phase_steps": rig.detection.phases,
    "sec7.integration_time": rig.detection.duration,
    "sec8.target_distance": rig.reference.distance,
}
for key, value in reached.items():
    paper.check(key, value)
