# %% [markdown]
# # The instrument
#
# Section 7 of the paper lists the parts of a prototype; drawings and control software were not
# published. What does a complete plan look like (Paper Fig. 6), and how much light arrives?
#
# The plan is of the instrument in this package's rig file, which the drivers can run. Everything
# here is *simulated*.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of random draws; none here
distance: float = 1.0  # range of the target in the budget, m
reflectance: float = 0.5  # of that target, diffuse
points: int = 120  # ranges on the axis of the last figure

# %% tags=["hide-input"]
import matplotlib.pyplot as plt
import numpy as np
from scipy.constants import h

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU, wrap_length
from cmtof.hardware.reduction import FULL_SCALE
from cmtof.hardware.rig import MODES, Rig
from cmtof.modulator import doubled_mode_harmonics, single_mode_harmonics
from cmtof_book import notes, paper, plotting
from cmtof_book.compared import closed_form
from cmtof_book.paper import quantity_text
from cmtof_lab import optics as free_space
from cmtof_lab.electronics import SLOPE, density, volts_per_watt
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import RayEnds

plotting.begin(profile=profile, seed=seed)
COLOURS = {"single": "C0", "doubled": "C1"}
LAWS = {"single": single_mode_harmonics, "doubled": doubled_mode_harmonics}
rig = Rig.default()
twin = TwinSettings()

# %% tags=["hide-input"]
OUT = {"color": "#00A86B", "lw": 2.4, "zorder": 2}
BACK = {"color": "#8FD9BC", "lw": 2.4, "zorder": 2}
PATHS = (  # look, corners
    (OUT, [(1.0, 9), (9.6, 9)]),
    (OUT, [(5.4, 9), (5.4, 6.78), (12.6, 6.78), (12.6, 8.08), (15.9, 8.08)]),
    (OUT, [(7.2, 6.78), (7.2, 5.5)]),
    (OUT, [(9.4, 6.78), (9.4, 7.9)]),
    (OUT, [(11.3, 6.78), (11.3, 8.7)]),
    (
        BACK,
        [
            (15.9, 7.92),
            (12.8, 7.92),
            (12.8, 6.62),
            (9.4, 6.62),
            (9.4, 4.4),
            (14.8, 4.4),
        ],
    ),
    (BACK, [(10.6, 4.4), (10.6, 2.72)]),
)
GLASS = {"mfc": "#DCEBF7", "mec": "#6B8CA8", "ms": 22}
SPLITTERS = [(5.4, 9, "PBS"), (10.6, 4.4, "PBS"), (7.2, 6.7, "NBS"), (9.4, 6.7, "")]
PLATES = [(6.2, 9, "HWP"), (7.05, 9, "QWP"), (11.5, 4.4, "HWP"), (12.35, 4.4, "QWP")]
LENSES = [(4.0, 9, ""), (4.5, 9, "2.5×"), (9.4, 5.5, ""), (10.6, 3.45, "")]
MIRRORS = [
    (9.6, 9, ""),
    (14.8, 4.4, ""),
    (5.4, 6.7, ""),
    (9.4, 7.95, ""),
    (9.4, 4.4, ""),
]
MIRRORS += [(12.7, 6.7, ""), (12.7, 8, "galvo"), (11.3, 6.7, "")]
PARTS = (  # look, places and names
    (GLASS | {"marker": "s"}, SPLITTERS),
    (GLASS | {"marker": "d"}, PLATES + LENSES),
    ({"marker": (2, 2, -45), "ms": 22, "mew": 5, "mec": "#9AA4AD"}, MIRRORS),
)
BOXES = (
    (1.0, 9, f"laser, 532 nm\n{1e3 * twin.laser_power:.0f} mW"),
    (3.1, 9, "fibre"),
    (8.15, 9, "EOM"),
    (13.35, 4.4, "EOM"),
    (7.2, 5.5, "power meter"),
    (15.9, 8, "scene"),
    (11.3, 8.7, "target"),
    (10.6, 2.72, "APD"),
)

# %% tags=["hide-input"]
figure, ax = plt.subplots(figsize=(8.4, 4.4))
ax.set(xlim=(0, 17.2), ylim=(2.2, 10.2), aspect="equal")
ax.axis("off")
small = {"fontsize": "small", "ha": "center", "va": "center", "zorder": 6}
for look, corners in PATHS:
    ax.plot(*zip(*corners, strict=True), **look)
for look, places in PARTS:
    ax.plot(
        *zip(*(place[:2] for place in places), strict=True), ls="", zorder=3, **look
    )
    for x, y, name in places:
        ax.text(x, y + 0.65, name, **small)
for x, y, name in BOXES:
    ax.text(
        x,
        y,
        name,
        bbox={"boxstyle": "round", "fc": "#F3F5F7", "ec": "#7C8A96"},
        **small,
    )
BESIDE = (
    (8.2, 8.2, "reference arm"),
    (8.6, 5.5, "1.6×"),
    (8.75, 7.25, "NBS"),
    (11.3, 6.05, "flip mirror"),
)
for x, y, name in BESIDE:
    ax.text(x, y, name, **small)
plotting.save(
    figure,
    "fig06_instrument",
    caption="The optics of the simulated instrument, our reconstruction of the paper's, not to "
    "scale: path of the light out (dark green) and back (pale green).",
    alt="Plan of an optical table in three rows. Top: laser, fibre, beam reducer and the emission "
    "module. Middle: two beam splitters to a power meter and a reference arm, flip mirror, galvo "
    "and scene. Bottom: the detection module and the avalanche diode.",
)

# %% [markdown]
# The emission module is a polarising splitter, two wave plates, the crystal and a mirror, so light
# passes the crystal twice ([chapter 4](04_modulator.ipynb)). One splitter sends half to a power
# meter, the next half to the interferometer's arm; the rest goes over the scan mirrors to the
# scene. The returned light is multiplied by the reference in the detection module, a copy of the
# first, so that a slow detector suffices. Both RF drivers share one clock. The detection's driver
# holds a table of phases; each rising edge from the read-out advances it by one. Devices, lines and
# wires are on the [hardware page](../book/hardware.md).
#
# ## Power budget
#
# A diffuse target of reflectance ϱ at the range z returns into the aperture A
#
# $$\frac{P_\mathrm{collected}}{P_\mathrm{sent}} = \frac{\varrho}{2}\,\frac{A}{\pi z^2};$$
#
# the factor ½ is the polarisation that the splitter rejects. This step loses more light than any
# other.

# %% tags=["hide-input"]
phase_time = rig.samples_per_phase / rig.rate
converter = twin.converter_noise * SLOPE / np.sqrt(rig.samples_per_phase)


def budget(mode, z, rho):
    """Light (W), photons, output (V) and phase noise (rad) of a point; ideal modulators."""
    harmonics = LAWS[mode](twin.eta, 2)
    mean = harmonics[0].real
    contrast = 2 * abs(harmonics[MODES[mode]]) ** 2 / mean**2
    hits = RayEnds(np.array(z), np.array(1.0), np.array(rho))
    share = float(sum(free_space.returned_fractions(twin, hits)))
    path = free_space.inward(twin) * mean * twin.mirror_reflectance
    light = free_space.sent_power(twin, mode) * share * path
    room = free_space.ambient(twin) * mean * twin.mirror_reflectance
    volts = min((light + room) * volts_per_watt(twin), twin.saturation)
    noise = np.sqrt(density(twin, volts) / (2 * phase_time) + converter**2)
    amplitude = contrast * min(light * volts_per_watt(twin), twin.saturation)
    photon = h * SPEED_OF_LIGHT / twin.wavelength
    return {
        "share": share,
        "path": path,
        "light": light,
        "room": room,
        "volts": volts,
        "photons": light / photon * phase_time * rig.phases,
        "contrast": contrast,
        "amplitude": amplitude,
        "phase_noise": np.sqrt(2 / rig.phases) * noise / amplitude,
    }


# %% tags=["hide-input"]
here = {mode: budget(mode, distance, reflectance) for mode in COLOURS}
fibre = (twin.fibre_low + twin.fibre_high) / 2
steps = {
    mode: {
        "Fibre": fibre,
        "Emission module": free_space.emission_mean(twin, mode),
        "Optics to the scene": free_space.outward(twin),
        "Share collected": one["share"],
        "Detection path": one["path"],
    }
    for mode, one in here.items()
}
rows = [
    ["On the detector", *(quantity_text(one["light"], "W") for one in here.values())],
    [
        "Photons in a point",
        *(f"{one['photons'] / 1e6:.3g} million" for one in here.values()),
    ],
    ["Output (mV)", *(f"{1e3 * one['volts']:.0f}" for one in here.values())],
]
notes.table(["", "single", "doubled"], rows)

# %% tags=["hide-input"]
figure, ax = plt.subplots(figsize=(8.4, 3.8))
for row, (mode, passed) in enumerate(steps.items()):
    level = twin.laser_power
    for place, factor in enumerate(passed.values()):
        at = place + 0.2 * (2 * row - 1)
        ax.barh(
            at,
            level * (1 - factor),
            left=level * factor,
            height=0.36,
            color=COLOURS[mode],
            label=f"{mode} mode" if place == 0 else None,
        )
        ax.text(
            level * factor / 1.25,
            at,
            f"\u2212{-10 * np.log10(factor):.1f} dB",
            va="center",
            ha="right",
            fontsize=9,
            color=COLOURS[mode],
        )
        level *= factor
ax.set(xscale="log", xlim=(5e-12, 0.3), ylim=(4.6, -0.6), xlabel="power (W)")
ax.set_yticks(range(5), list(steps["single"]))
ax.grid(visible=False, axis="y")
ax.legend(loc="lower right")
plotting.save(
    figure,
    "instrument_budget",
    numbers={
        "detected_power": closed_form([one["light"] for one in here.values()]),
        "loss_db": closed_form(
            [-10 * np.log10(one["light"] / twin.laser_power) for one in here.values()]
        ),
    },
    caption=(
        f"From the laser to the detector, for a diffuse target of reflectance {reflectance:.1f} at "
        f"{distance:.1f} m (simulated): each bar is the loss of a step, in decibels of power."
    ),
    alt="Waterfall of bars on a logarithmic axis of power; the longest by far is the share of the "
    "scattered light that the aperture collects.",
)

# %% [markdown]
# ## Noise sources
#
# *Shot noise*, multiplied by the avalanche with the gain $M$ and the excess factor $F = M^x$, grows
# with the square root of the output $U$ behind the transimpedance $R_T$; the noise of *amplifier*
# and *converter* is constant:
#
# $$\sigma^2 = \bigl(2 e F M R_T\,U + s_\mathrm{amp}^2\bigr)\,B + \sigma_\mathrm{conv}^2.$$
#
# For white noise averaged over a time $T$, $B = 1/2T$. The phase of a point with 16 steps has the
# noise $\sqrt{2/16}\,\sigma/a$ for an amplitude a, its range $c/4\pi f$ times as much.

# %% tags=["hide-input"]
output = np.geomspace(1e-4, twin.saturation, points)
shot = np.sqrt((density(twin, output) - density(twin, 0)) / (2 * phase_time))
amplifier = np.sqrt(density(twin, 0) / (2 * phase_time))
quantum = (20 / 2**14) / np.sqrt(12) / np.sqrt(rig.samples_per_phase)
even = np.interp(1.0, shot / amplifier, output)
ranges = np.geomspace(0.2, 8.0, points)
micron = {
    mode: 1e6 * wrap_length(order * rig.drive_frequency(mode)) / TAU
    for mode, order in MODES.items()
}
curves = {
    (m, rho): [budget(m, z, rho) for z in ranges]
    for rho in (reflectance, 0.05)
    for m in COLOURS
}

# %% tags=["hide-input"]
figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 4.0))
for (mode, rho), found in curves.items():
    good = [(1 + one["contrast"]) * one["volts"] <= twin.saturation for one in found]
    values = micron[mode] * np.array([one["phase_noise"] for one in found])
    right.plot(
        ranges,
        np.where(good, values, np.nan),
        color=COLOURS[mode],
        ls="-" if rho == reflectance else "--",
        label=f"{mode}, ϱ = {rho:g}",
    )
right.set(xscale="log", yscale="log", xlim=(0.2, 8))
right.set(xlabel="range (m)", ylabel="noise of the range (µm)")
right.set_xticks([0.3, 1, 3], ["0.3", "1", "3"])
right.tick_params(axis="x", which="minor", labelbottom=False)
right.legend()
for values, name, style in (
    (shot, "shot noise", "-"),
    (0 * shot + amplifier, "amplifier", "-."),
    (0 * shot + converter, "converter", "--"),
    (0 * shot + quantum, "rounding to 14 bit", ":"),
):
    left.loglog(1e3 * output, 1e6 * values, style, label=name)
left.set(xlabel="output of the detector (mV)", ylabel="noise of one phase (µV)")
left.legend()
plotting.label_panels([left, right])
crossing = [
    np.interp(-even, [-one["volts"] for one in curves[m, reflectance]], ranges)
    for m in COLOURS
]
plotting.save(
    figure,
    "instrument_photons",
    numbers={
        "photons": closed_form([one["photons"] for one in here.values()]),
        "even_output": closed_form(even),
        "crossing_range": closed_form(crossing),
        "noise_microns": closed_form(
            [micron[m] * one["phase_noise"] for m, one in here.items()]
        ),
        "noise_volts": closed_form([amplifier, converter, quantum]),
    },
    caption=(
        "(a) Noise of one phase against the detector's output. (b) Noise of the range at this "
        "photon limit; the second noise case, that of the published captures, is 390 µm at 7.15 "
        "GHz, whatever the light. Simulated; curves end where the detector saturates."
    ),
    alt="Two double logarithmic panels: shot noise crosses the amplifier's; the noise of the range "
    "grows, more in the doubled mode.",
)
for mode, one in here.items():
    print(f"{mode}: {micron[mode] * one['phase_noise']:.1f} µm at {distance:g} m")

# %% [markdown]
# Below the crossing the noise does not depend on the target: it comes from the amplifier and the
# shot noise of the room's light. The converter's noise is negligible, even with the paper's 14
# bits. At the photon limit precision is *lower* at the higher frequency where no filter is needed,
# since the amplitude falls faster than the wavelength. Both values are below the paper's 33 µm.
# They are for ideal modulators, all 20 samples of a phase and a zero that is known;
# [chapter 18](18_error_budget.ipynb) has those of the instrument, which are larger, and adds
# drift, air, back-reflected light and cyclic errors.
#
# ## Two noise cases
#
# Captures of a later instrument are far noisier ([chapter 7](07_captures.ipynb)), 0.08 to 0.13 rad
# at 7.15 GHz. The *captures' noise* is therefore a second case beside this *photon limit*: the
# phase between both drives fluctuates from step to step, in part correlated with the point before.
# Its level and grain, 0.117 rad a point and a correlation of 0.17, are means over three of five
# published scans, of which one has 0.45 and two hardly any. At 14.32 GHz the same value in radians
# is assumed (a jitter in time would double it). In a rig file it is
# `twin: {phase_noise: [0.117, 0.117], grain: 0.167}`.
#
# ## Differences from the paper
#
# Every setting of the simulation has its source; none was fitted to the paper's results. The RC
# constant is 20 µs; the paper's 0.1 s would damp the sweep of ψ 47 times. The converter has the 16
# bits of the T7's stream, not 14. The drive is η = π/4, not the 0.26 of the chapters on light
# ([chapter 4](04_modulator.ipynb)), the least contrast that the paper states: at 0.26 the doubled
# mode has 2 % of the single mode's signal, too little for a scan. Drive amplitude, laser power,
# avalanche gain and back-reflection are not stated in the paper and are assumed. So is the
# aperture, 2 mm of the crystal's 2.5 mm or 3.2 mm before the expander; the beam of 0.5 mm that
# Section 7.2 states has a sixteenth of its light. Not verified in a manufacturer's document: noise,
# gain and excess of the detector, the order of the filter EF120, reflectances and extinction
# ratios, and every error of the RF drivers.

# %% tags=["hide-input"]
paper.check_all(
    {
        "sec6.laser_wavelength": twin.wavelength,
        "sec6.bits": np.log2(FULL_SCALE + 1),
        "sec6.eom_frequency": rig.frequency_single,
        "sec6.eom_bandwidth": twin.resonance_width,
        "sec7.fibre_throughput_low": twin.fibre_low,
        "sec7.fibre_throughput_high": twin.fibre_high,
        "sec7.beam_after": 2 * twin.exit_radius,
        "sec7.laser_power": free_space.sent_power(twin),
        "sec7.lowpass": twin.low_pass,
        "sec7.sample_rate": rig.rate,
        "sec7.samples_per_phase": rig.samples_per_phase,
        "sec7.phase_steps": rig.phases,
        "sec7.integration_time": rig.scans / rig.rate,
        "sec8.target_distance": rig.reference_distance,
    }
)
paper.table()

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** Of {laser:.0f} mW of laser light {light:.2f} nW reach the detector from a wall of
    reflectance {reflectance:.1f} at {distance:g} m in the single mode. Photons and electronics then
    cause {noise:.1f} µm of range noise.
    """,
    laser=1e3 * twin.laser_power,
    light=1e9 * here["single"]["light"],
    reflectance=reflectance,
    distance=distance,
    noise=micron["single"] * here["single"]["phase_noise"],
)
