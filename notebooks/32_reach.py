# %% [markdown]
# # Reach: where the method stops to be useful
#
# One number, 33 µm at 60 cm, says little about an instrument. This page turns one knob after the
# other of the *simulated* all-optical instrument: modulation frequency, range, reflectance,
# integration time, laser, room light, number of phases. Lines are closed forms of the noise
# (`cmtof.ranging.reach`), filled dots are simulated bursts with nothing but noise, and open
# circles have all errors of the simulated instrument in them.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of noise, drift, errors and speckle
bursts: int = 400  # simulated bursts of each filled dot
days: int = 15  # simulated days of each open circle
places: int = 5  # most dots along a knob
grid: int = 81  # side of the maps

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from myst_nb import glue
from scipy.special import erfinv

from cmtof.book import paper, plotting
from cmtof.bounds import wrap_noise, wrap_probability, wrap_probability_law
from cmtof.constants import FREQUENCIES
from cmtof.correlation import cyclic_error, depth_from_phase, phase_from_depth, wrap_length
from cmtof.instrument.electronics import Conversion
from cmtof.instrument.settings import TwinSettings
from cmtof.modulator import doubled_mode_harmonics, single_mode_harmonics
from cmtof.ranging.optical import FREQUENCY, OpticalRanger
from cmtof.ranging.reach import (
    beat_right,
    depth_noise,
    levels,
    noisy_only,
    simulated_errors,
    tuned,
)
from cmtof.ranging.rf import emitting
from cmtof.ranging.target import StageTarget

run = plotting.begin(profile=profile, seed=seed)
COLOURS = {"single": plotting.PALETTE["blue"], "doubled": plotting.PALETTE["vermillion"]}
green, grey, black = plotting.PALETTE["green"], "#5A646D", plotting.PALETTE["black"]
SENT = 1e3 * paper.published("sec7.laser_power").value
base = emitting(TwinSettings(), SENT / 1e3)
ALL = {mode: OpticalRanger(base, mode) for mode in FREQUENCY}
QUIET = {mode: noisy_only(ranger) for mode, ranger in ALL.items()}
HERE, GREY = paper.published("sec8.target_distance").value, StageTarget().reflectance
beat = FREQUENCIES[1] - 2 * FREQUENCIES[0]


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, float(value), display=False)


# %% [markdown]
# ## The closed form
#
# With $L$ the light that open modulators would let onto the detector, $\bar w$ and $w_1$ the mean
# and the fundamental of the product of both waveforms, $u$ the room's light and $S$ volts per watt,
#
# ```{math}
# :label: eq-reach-noise
# \sigma_z = \frac{c}{4\pi f}\,\frac{\sqrt{v}}{S L w_1},\qquad
# v = B\,d\big(S(L\bar w + u)\big) + \frac{2}{K}\,\frac{\sigma_\mathrm{adc}^2}{N} .
# ```
#
# $d$ is the density of amplifier and shot noise at the mean output, and $B$ the bandwidth of the
# fundamental of $K$ means of $N$ samples each, behind the instrument's filters. For a diffuse
# surface $L \propto P\rho/z^2$. So $\sigma_z$ goes with $z$ while photons make the noise, with
# $z^2$ where the amplifier does, and it stops falling where the light would drive the detector
# beyond its end and has to be thinned by a grey filter. The *beat* of both modes,
# {glue:text}`beat:.0f` MHz, tells the wrap. Its range has
#
# $$\sigma_b = \frac{c}{4\pi\Delta}\sqrt{\sigma_2^2 + 4\sigma_1^2},\qquad
# \Delta = f_2 - 2f_1 .$$

# %%
KNOBS = {
    "range": ("range (m)", np.geomspace(0.3, 5, 61), [0.3, 0.6, 1.2, 2.5, 5.0]),
    "reflectance": ("reflectance", np.geomspace(0.01, 1, 61), [0.01, 0.05, 0.2, 1.0]),
    "time": ("integration time (ms)", np.array([6, 8, 10, 14, 20, 40, 80, 160, 400, 800]) * 16 / 24,
             [8, 20, 80, 240]),
    "laser": ("laser sent to the scene (mW)", np.geomspace(0.1, 100, 31), [0.3, 3.0, 30.0]),
    "room": ("room light (W m$^{-2}$ sr$^{-1}$)", np.geomspace(1e-3, 1e3, 31), [0.1, 10.0, 300.0]),
    "frequency": ("modulation frequency (GHz)", np.geomspace(0.1, 100, 4), [0.1, 1.0, 7.15, 60.0]),
}  # fmt: skip


def turned(ranger, knob, value):
    """The instrument, the range and the reflectance with one knob at a value."""
    settings = ranger.settings
    if knob == "range":
        return ranger, value, GREY
    if knob == "reflectance":
        return ranger, HERE, value
    if knob == "time":  # more samples of each of the 16 phases
        return replace(ranger, samples=round(value * 24 / 16)), HERE, GREY
    if knob == "laser":
        laser = replace(settings.laser, power=settings.laser.power * value / SENT)
        return replace(ranger, settings=replace(settings, laser=laser)), HERE, GREY
    if knob == "room":
        optics = replace(settings.optics, ambient_radiance=value)
        return replace(ranger, settings=replace(settings, optics=optics)), HERE, GREY
    return tuned(ranger, 1e9 * value), HERE, GREY


def noise(knob, values, mode):
    """Closed form along a knob, m."""
    if knob in ("range", "reflectance"):
        _, z, rho = turned(QUIET[mode], knob, values)
        return depth_noise(QUIET[mode], z, rho)
    return np.array([float(depth_noise(*turned(QUIET[mode], knob, v))) for v in values])


def beat_noise(knob, values, lines):
    """Range of the beat, m, from the noise of both modes."""
    one, two = (
        phase_from_depth(lines[mode], values * 1e9 if knob == "frequency" else FREQUENCY[mode])
        for mode in FREQUENCY
    )
    return depth_from_phase(np.hypot(two, 2 * one), beat)


# %% [markdown]
# What stays equal along each axis: everything but the knob, at {glue:text}`here:.1f` m, reflectance
# {glue:text}`grey:.1f`, {glue:text}`sent:.1f` mW and 13.3 ms otherwise. Along the *frequency* the
# crystals are cut anew: light, $\eta$ and so the Bessel amplitudes, errors as phases and time stay,
# and the number of wraps grows with $f$. It is a thought experiment; drives of 60 GHz are not on
# offer.

# %%
lines, dots, circles, worst, pulls = {}, {}, {}, 0.0, 0
for knob, (_, axis, all_places) in KNOBS.items():
    shown = np.array(all_places[:places]) * (16 / 24 if knob == "time" else 1)
    for mode in FREQUENCY:
        lines[knob, mode] = noise(knob, axis, mode)
        spread, full = [], []
        for number, value in enumerate(shown):
            ranger, z, rho = turned(QUIET[mode], knob, float(value))
            count = max(100, bursts * 20 // max(20, ranger.samples))  # long bursts cost more
            errors = simulated_errors(ranger, z, rho, count=count, seed=seed + number)
            spread.append(float(errors.std()))
            chance = np.sqrt(2 * count) * abs(spread[-1] / float(depth_noise(ranger, z, rho)) - 1)
            worst, pulls = max(worst, chance), pulls + 1
            ranger = turned(ALL[mode], knob, float(value))[0]
            target = StageTarget(distance=z, reflectance=rho)
            off = ranger.sweep(target, np.linspace(0, 1e-3, 3)[1:], repeats=days, seed=seed) - z
            full.append(float(np.sqrt(np.mean((off - np.array([5e-4, 1e-3])) ** 2))))
        dots[knob, mode], circles[knob, mode] = np.array(spread), np.array(full)
    lines[knob, "beat"] = beat_noise(knob, axis, {m: lines[knob, m] for m in FREQUENCY})
print(f"{pulls} dots, off their lines by at most {worst:.1f} standard deviations of chance")

# %% tags=["hide-input"]
fig, axes = plt.subplots(2, 3, figsize=(11.0, 7.0), sharey=True)
for ax, (knob, (label, axis, all_places)) in zip(axes.flat, KNOBS.items(), strict=True):
    shown = np.array(all_places[:places]) * (16 / 24 if knob == "time" else 1)
    for mode, colour in COLOURS.items():
        ax.loglog(axis, 1e6 * lines[knob, mode], color=colour, label=f"{mode} mode")
        ax.loglog(shown, 1e6 * dots[knob, mode], "o", ms=4.5, color=colour)
        ax.loglog(shown, 1e6 * circles[knob, mode], "o", ms=8, mfc="none", color=colour)
    if knob != "frequency":
        ax.loglog(axis, 1e6 * lines[knob, "beat"], color=green, ls="--", label="beat")
    ax.set(xlabel=label, ylim=(0.1, 3e6))
    now = {"range": HERE, "reflectance": GREY, "time": 40 / 3, "laser": SENT,
           "room": QUIET["single"].settings.optics.ambient_radiance, "frequency": 7.15}  # fmt: skip
    ax.axvline(now[knob], color=grey, lw=0.9, ls=":")
    if knob == "range":
        ax.set_xticks([0.3, 0.6, 1, 2, 5], ["0.3", "0.6", "1", "2", "5"])
        ax.minorticks_off()
for ax in axes[:, 0]:
    ax.set_ylabel("standard deviation of range (µm)")
axes[0, 0].legend(fontsize=8.5, loc="upper left")
plotting.label_panels(axes.flat)
at = {mode: float(depth_noise(QUIET[mode], HERE, GREY)) for mode in FREQUENCY}
plotting.save(
    fig,
    "reach_sweeps",
    numbers={
        "single_here": at["single"],
        "doubled_here": at["doubled"],
        "single_far": float(lines["range", "single"][-1]),
        "doubled_far": float(lines["range", "doubled"][-1]),
        "worst_pull": worst,
    },
    caption=(
        "Precision of one reading of the simulated all-optical instrument on a diffuse plate, each "
        "panel turning one knob away from the dotted setting. Lines: closed form of noise alone; "
        "dots: simulated bursts with noise alone; open circles: root mean square error of "
        "simulated days with drift, phase codes, back-reflection, leakage, speckle and air, and "
        "with the noise of the one reading that calibrates. Dashed: range by the beat of both "
        "modes. (c) One sweep of the phases, slower. (f) Crystals cut for each frequency."
    ),
    alt=(
        "Six log-log panels. Against range the deviation rises from "
        f"{1e6 * lines['range', 'single'][0]:.1f} to {1e6 * lines['range', 'single'][-1]:.0f} "
        f"micrometres in the single mode between 0.3 and 5 m, and to "
        f"{1e6 * lines['range', 'doubled'][-1]:.0f} in the doubled. It falls with reflectance, "
        "time and laser until it levels off, rises with room light, and falls as one over the "
        "frequency. "
        "The beat lies about three decades above. Dots lie on the lines, open circles on or above."
    ),
)


places_of_time = KNOBS["time"][2][:places]
fibre = (base.laser.fibre_low + base.laser.fibre_high) / 2
calm = replace(base, laser=replace(base.laser, fibre_low=fibre, fibre_high=fibre))
slow_sweep = replace(ALL["single"], settings=calm, samples=places_of_time[-1])
far = np.array([5e-4, 1e-3])
found = slow_sweep.sweep(StageTarget(), far, repeats=days, seed=seed)
light_here = levels(QUIET["single"], HERE, GREY)
conversion = Conversion(base.detector, base.laser.wavelength)
spare = base.detector.saturation / conversion.volts_per_watt - float(
    light_here.light + light_here.amplitude
)
room_end = base.optics.ambient_radiance * spare / light_here.room
tell(
    beat=beat / 1e6,
    here=HERE,
    grey=GREY,
    sent=SENT,
    worst=worst,
    dots=pulls,
    single_here=1e6 * at["single"],
    doubled_here=1e6 * at["doubled"],
    single_far=1e6 * lines["range", "single"][-1],
    doubled_far=1e6 * lines["range", "doubled"][-1],
    full_here=1e6 * circles["range", "single"][1],
    full_doubled=1e6 * circles["range", "doubled"][1],
    pair_single=1e6 * np.sqrt(2) * at["single"],
    pair_doubled=1e6 * np.sqrt(2) * at["doubled"],
    longest=places_of_time[-1] * 16 / 24,
    slow=1e6 * circles["time", "single"][-1],
    slow_steady=1e6 * float(np.sqrt(np.mean((found - HERE - far) ** 2))),
    room_end=room_end,
)
pays = at["doubled"] < at["single"]
doubled_words = (
    "At 60 cm the doubled mode is the more precise one."
    if pays
    else "Twice the frequency does not pay for the light that the doubled mode loses at this η, "
    "unless light abounds."
)
glue("doubled_words", Markdown(doubled_words), display=False)

# %% [markdown]
# The {glue:text}`dots:.0f` dots lie within {glue:text}`worst:.1f` standard deviations of chance
# from their lines. What the panels say:
#
# - **Range and reflectance.** From {glue:text}`single_here:.1f` µm at {glue:text}`here:.1f` m noise
#   grows to {glue:text}`single_far:.0f` µm at 5 m in the single mode, and from
#   {glue:text}`doubled_here:.1f` to {glue:text}`doubled_far:.0f` µm in the doubled one.
# - **Errors against noise.** A circle holds the noise of two readings, its own and that of its
#   calibration: at {glue:text}`here:.1f` m that is {glue:text}`pair_single:.1f` and
#   {glue:text}`pair_doubled:.1f` µm of the {glue:text}`full_here:.1f` and
#   {glue:text}`full_doubled:.1f` µm seen. Farther away noise rules, nearer the other errors do.
# - **Laser.** More light helps up to the detector's end. There the single mode, which lets more
#   of it through, stops first.
# - **Time.** A slower sweep of the phases makes less noise, and in the end more error: at
#   {glue:text}`longest:.0f` ms the days scatter by {glue:text}`slow:.0f` µm, because the laser
# changes while the phase goes round; with a steady fibre it is {glue:text}`slow_steady:.1f` µm.
# Time   is better spent on many fast sweeps, or on a division by the power meter's reading.
# - **Room light** adds shot noise, and beyond about {glue:text}`room_end:.0f` W/(m² sr) it drives
#   the detector to its end by itself; then the filter takes the laser's light as well.
# - **Frequency.** The error of range falls as one over frequency, for noise and for errors of phase
#   alike. There is no optimum in this: what ends it are crystals, drivers, and the wraps below.
#
# ```{glue:md} doubled_words
# :format: myst
# ```
#
# ## How many phases
#
# In the same time one can take few phases with many samples or many with few. Each change of phase
# costs {glue:text}`settle:.0f` samples while the filters settle, so few phases make less noise. But
# harmonics of the correlation pass for its fundamental: with $K$ phases those of order $mK\pm1$.
# The correlation of the single mode has the third with $(J_3/J_1)^2$, and four phases cannot tell
# it.

# %%
COUNTS = (3, 4, 5, 6, 8, 10, 16, 20, 32, 40)
laws = {
    "single": single_mode_harmonics(QUIET["single"].settings.drive.eta, 16),
    "doubled": doubled_mode_harmonics(QUIET["doubled"].settings.drive.eta, 32)[::2],
}
turn = np.linspace(0, 2 * np.pi, 721)[:-1]
cyclic, by_count, wrap_dots = {}, {}, {}
for mode, w in laws.items():
    frequency = FREQUENCY[mode]
    cyclic[mode] = depth_from_phase(
        np.array([np.std(cyclic_error(w, w, phase=turn, samples=k)) for k in COUNTS]), frequency
    )
    rangers = [replace(QUIET[mode], phases=k, samples=320 // k) for k in COUNTS]
    by_count[mode] = np.array([float(depth_noise(one, HERE, GREY)) for one in rangers])
    across = np.linspace(0, float(wrap_length(frequency)), bursts // 2, endpoint=False)
    found = []
    for one in rangers:
        errors = one.sweep(StageTarget(), across, repeats=1, seed=seed)[0] - HERE - across
        found.append(float(errors.std()))
    wrap_dots[mode] = np.array(found)

# %% tags=["hide-input"]
fig, axes = plt.subplots(1, 2, figsize=(10.0, 3.9), sharey=True)
for ax, mode in zip(axes, FREQUENCY, strict=True):
    real = cyclic[mode] > 1e-10
    ax.loglog(COUNTS, 1e6 * by_count[mode], "-", color=COLOURS[mode], label="noise")
    ax.vlines(np.array(COUNTS)[real], 1e-3, 1e6 * cyclic[mode][real], lw=7, alpha=0.35,
              color=grey, label="cyclic error, closed form")  # fmt: skip
    ax.loglog(COUNTS, 1e6 * wrap_dots[mode], "o", mfc="none", ms=6.5, color=black,
              label="simulated over a wrap")  # fmt: skip
    ax.set(xlabel="phases in 13.3 ms", title=f"{mode} mode", ylim=(3e-2, 200))
    ax.set_xticks(COUNTS, [str(k) for k in COUNTS], minor=False)
    ax.tick_params(axis="x", labelsize=8.5)
    ax.minorticks_off()
axes[0].set_ylabel("standard deviation of range (µm)")
axes[1].legend(fontsize=8.5)
plotting.label_panels(axes)
four, sixteen = COUNTS.index(4), COUNTS.index(16)
plotting.save(
    fig,
    "reach_phases",
    numbers={
        "cyclic_four": float(cyclic["single"][four]),
        "simulated_four": float(wrap_dots["single"][four]),
        "simulated_sixteen": float(wrap_dots["single"][sixteen]),
        "noise_four": float(by_count["single"][four]),
        "noise_sixteen": float(by_count["single"][sixteen]),
    },
    caption=(
        "Few phases or many in the same 13.3 ms, diffuse plate at 60 cm, simulated without other "
        "errors: noise (lines), cyclic error by the harmonics of ideal modulators (bars), and the "
        "scatter of simulated readings while the target goes through a wrap (circles)."
    ),
    alt=(
        "Two panels against the number of phases from 3 to 40. Noise rises slowly. In the single "
        f"mode four phases have a cyclic error of {1e6 * cyclic['single'][four]:.0f} micrometres "
        f"and circles lie there, sixteen phases lie at {1e6 * wrap_dots['single'][sixteen]:.1f} "
        "micrometres, on the line of noise."
    ),
)
tell(
    settle=QUIET["single"].settle,
    cyclic_four=1e6 * cyclic["single"][four],
    simulated_four=1e6 * wrap_dots["single"][four],
    noise_four=1e6 * by_count["single"][four],
    noise_sixteen=1e6 * by_count["single"][sixteen],
    simulated_sixteen=1e6 * wrap_dots["single"][sixteen],
    doubled_four=1e6 * cyclic["doubled"][four],
    doubled_three=1e6 * cyclic["doubled"][COUNTS.index(3)],
)

# %% [markdown]
# Four phases would have {glue:text}`noise_four:.1f` µm of noise instead of
# {glue:text}`noise_sixteen:.1f` µm, and {glue:text}`cyclic_four:.0f` µm rms of cyclic error:
# simulated {glue:text}`simulated_four:.0f` µm. Sixteen read {glue:text}`simulated_sixteen:.1f` µm.
# In the doubled mode, whose correlation has a second harmonic, three phases are the bad choice
# ({glue:text}`doubled_three:.0f` µm). Five would already serve both; sixteen buy safety from a
# stronger drive at little cost.
#
# ## Range and reflectance together
#
# The micrometres above are those *within* a wrap. Which wrap it is has to come from the beat, pixel
# by pixel or from many pixels together. With the spread of the wrap count
#
# $$\sigma_n = \frac{\sqrt{f_1^2\sigma_2^2 + f_2^2\sigma_1^2}}{2\pi\Delta}$$
#
# one pixel is right with the odds $\mathrm{erf}(1/2\sqrt2\sigma_n)$ ({doc}`03_wraps`).

# %%
z, rho = np.geomspace(0.2, 10, grid), np.geomspace(0.005, 1, grid)
plane = np.meshgrid(z, rho)
maps = {mode: levels(QUIET[mode], *plane) for mode in FREQUENCY}
sigma = depth_from_phase(maps["single"].phase_noise, FREQUENCY["single"])
phases = maps["single"].phase_noise, maps["doubled"].phase_noise
odds = wrap_probability(*phases, frequencies=FREQUENCIES)
bright = maps["single"].saturated
allowed = 1 / (2 * np.sqrt(2) * erfinv(0.95))
pool = np.maximum((wrap_noise(*phases, frequencies=FREQUENCIES) / allowed) ** 2, 1)

# %% tags=["hide-input"]
fig, axes = plt.subplots(1, 2, figsize=(11.0, 4.6))
left, right = axes
plots = (
    (left, 1e6 * sigma, (1, 3, 10, 30, 100, 300, 1000, 3000), "standard deviation (µm)"),
    (right, 100 * odds, (1, 3, 10, 20, 50, 80, 95), "right wrap, one pixel (%)"),
)
across = np.log10(plane[0]), np.log10(plane[1])  # labels of contours go wrong on log axes
for ax, values, contours, title in plots:
    shown = np.log10(values) if ax is left else values
    ax.pcolormesh(*across, shown, cmap=plotting.DEPTH_CMAP, shading="gouraud", rasterized=True)
    drawn = ax.contour(*across, values, levels=contours, colors="white", linewidths=1)
    ax.clabel(drawn, fmt="%g", fontsize=8.5)
    ax.contourf(*across, bright, levels=[0.5, 1.5], colors="none", hatches=["////"])
    ax.set(xlabel="range (m)", ylabel="reflectance", title=title)
    ax.grid(visible=False)
    ax.plot(np.log10(HERE), np.log10(GREY), "*", ms=12, color=plotting.PALETTE["orange"],
            mec="white")  # fmt: skip
    for ticks, setter in (((0.2, 0.5, 1, 2, 5, 10), ax.set_xticks),
                           ((0.01, 0.03, 0.1, 0.3, 1), ax.set_yticks)):  # fmt: skip
        setter(np.log10(ticks), [f"{tick:g}" for tick in ticks])
gold = plotting.PALETTE["orange"]
pools = right.contour(*across, pool, levels=[10, 100, 1000, 10_000], colors=gold,
                      linewidths=1, linestyles="--")  # fmt: skip
right.clabel(pools, fmt=lambda v: f"{v:.0f} px", fontsize=8)
plotting.label_panels(axes)
row = np.argmin(np.abs(rho - GREY))
single_far = float(np.interp(100e-6, sigma[row], z))
here_odds = float(
    wrap_probability(
        *(levels(QUIET[m], HERE, GREY).phase_noise for m in FREQUENCY), frequencies=FREQUENCIES
    )
)
thousand = float(np.interp(1000, pool[row], z))
plotting.save(
    fig,
    "reach_map",
    numbers={
        "range_100_um": single_far,
        "odds_here": here_odds,
        "range_1000_px": thousand,
        "saturated_share": float(bright.mean()),
    },
    caption=(
        "Noise of one 13.3 ms reading over range and reflectance, simulated instrument at 3 mW, "
        "closed form. (a) Standard deviation within a wrap, single mode. (b) Odds that the beat of "
        "both modes names the right wrap from one pixel; dashed: pixels to pool coherently for "
        "95 %. Hatched: too bright for the detector without a filter. Star: the plate at 60 cm."
    ),
    alt=(
        "Two maps over range 0.2 to 10 m and reflectance 0.005 to 1. The deviation rises from "
        "about two micrometres near and bright to millimetres far and dark, passing 100 "
        f"micrometres at {single_far:.1f} m for a reflectance of one half. The odds of the right "
        f"wrap fall from above 95 percent near and bright to a few percent; they are "
        f"{100 * here_odds:.0f} percent at the star. A hatched corner at short range and high "
        "reflectance marks saturation."
    ),
    format="png",
)

# %% [markdown]
# The odds come from linear noise. Simulated pairs of phases, decoded and beaten, say how well that
# holds; where noise is strong the exact law of a noisy phase takes over. The last column has *all*
# errors of the instrument: simulated days, nothing calibrated away but the constants of a perfect
# instrument.

# %%
CHECKED = (HERE, 1.0, 2.0, 4.0)
rows = ["| range (m) | foretold | simulated | all errors |", "| --: | --: | --: | --: |"]
table = {}
for number, distance in enumerate(CHECKED):
    target, errors, full = StageTarget(distance=distance), [], []
    stage = np.arange(5) * 1e-3
    for k, (mode, frequency) in enumerate(FREQUENCY.items()):
        key = seed + 100 + number + 50 * k
        off = simulated_errors(QUIET[mode], distance, GREY, count=bursts, seed=key)
        errors.append(phase_from_depth(off - off.mean(), frequency))
        whole = replace(ALL[mode], calibration="perfect")
        off = whole.sweep(target, stage, repeats=days, seed=seed) - distance - stage
        full.append(phase_from_depth(off, frequency))
    pair = [float(levels(QUIET[mode], distance, GREY).phase_noise) for mode in FREQUENCY]
    exact = wrap_probability_law if min(pair) > 3e-3 else wrap_probability
    table[distance] = (
        float(exact(*pair, frequencies=FREQUENCIES)),
        float(beat_right(*errors, frequencies=FREQUENCIES).mean()),
        float(beat_right(*full, frequencies=FREQUENCIES).mean()),
    )
    rows.append(
        f"| {distance:.1f} | " + " | ".join(f"{100 * o:.0f} %" for o in table[distance]) + " |"
    )
glue("odds_table", Markdown("\n".join(rows)), display=False)

# %% tags=["hide-input"]
settings = QUIET["single"].settings
slow = Conversion(settings.detector, settings.laser.wavelength)
level_here = levels(QUIET["single"], HERE, GREY)
end = z[bright[row]].max() if bright[row].any() else float("nan")
ambient_equal = settings.optics.ambient_radiance * float(level_here.light / level_here.room)
far_level = levels(QUIET["single"], 3.0, 0.1)
tell(
    single_100=single_far,
    odds_here=100 * here_odds,
    thousand=thousand,
    saturates=end,
    ambient_equal=ambient_equal,
    ambient_far=settings.optics.ambient_radiance * float(far_level.light / far_level.room),
    odds_all=100 * table[HERE][2],
    odds_there=100 * float(np.interp(single_far, z, odds[row])),
    helmet=1e6 * float(depth_noise(QUIET["single"], 1.0, 0.02)),
)
words = (
    "On noise alone one pixel of the plate at 60 cm finds its wrap, and the errors of the "
    "instrument take that away in part."
    if here_odds > table[HERE][2] + 0.03
    else "The errors of the instrument hardly change these odds."
)
glue("one_pixel", Markdown(words), display=False)

# %% [markdown]
# ```{glue:md} odds_table
# :format: myst
# ```
#
# ```{glue:md} one_pixel
# :format: myst
# ```
#
# ## Where it stops
#
# - **Near and bright:** the detector ends. A white wall at less than about
#   {glue:text}`saturates:.2f` m (reflectance {glue:text}`grey:.1f`) drives it beyond its range at
# this   avalanche gain; a filter or a lower gain helps, but precision no longer rises with light.
# - **Far and dark:** {glue:text}`single_100:.1f` m is where a plate of reflectance
#   {glue:text}`grey:.1f` is known to 100 µm within its wrap. A surface of 2 % at 1 m still has
#   {glue:text}`helmet:.0f` µm.
# - **The wrap** fails first. At {glue:text}`here:.1f` m a single pixel is right in
#   {glue:text}`odds_here:.0f` % of cases on noise alone, with all errors in
# {glue:text}`odds_all:.0f`   %. At the {glue:text}`single_100:.1f` m above it is
# {glue:text}`odds_there:.0f` %, and beyond   {glue:text}`thousand:.1f` m more than a thousand
# pixels of one surface must be pooled for 95 %.   Errors that stay the same over the image no
# pooling removes: that is what the calibration at a   known range is for. (The paper's simulation
# has far noisier pixels, {doc}`09_limits`; these are   the noise of the bench as its data sheets
# have it.)
# - **Room light** matters where it equals the laser's: {glue:text}`ambient_equal:.1f` W/(m² sr) at
#   {glue:text}`here:.1f` m, but {glue:text}`ambient_far:.2f` W/(m² sr) for a tenth of reflectance
# at   3 m; a room has {glue:text}`room:.1f` (assumed), a white wall in the sun about a hundred. The
# instrument of the paper has no colour filter.
#
# ## Against the paper

# %%
tell(room=settings.optics.ambient_radiance)
burst = QUIET["single"].phases * QUIET["single"].samples / QUIET["single"].rate
paper.check("sec7.integration_time", burst)
paper.check("sec8.scan_integration_time", burst)
