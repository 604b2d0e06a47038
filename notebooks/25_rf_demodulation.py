# %% [markdown]
# # RF demodulation after photo-conversion
#
# Before there were optical demodulators one would have done it the other way round: catch the light
# with a fast photodiode, amplify what comes out at 7.15 GHz, and mix it down with the drive. The
# paper builds this circuit for comparison (Section 7.4) and finds that it works on a mirror and
# fails on a diffuse target. This page follows the signal through such a circuit, part by part.
# Everything here is *simulated*; the paper names the photodiode only, so the other parts are
# catalogue parts with their data sheets' numbers, and what no data sheet tells is assumed and
# marked so in `cmtof.ranging.rf_settings`.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of noise, offsets and drift
draws: int = 20_000  # simulated readings at each power
days: int = 200  # repeats of the sweep of the stage

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from myst_nb import glue
from scipy.optimize import brentq

from cmtof.book import paper, plotting
from cmtof.bounds import phase_spread
from cmtof.correlation import centred, depth_from_phase, wrap_length
from cmtof.instrument.optics import sent_power
from cmtof.instrument.electronics import Conversion
from cmtof.instrument.settings import TwinSettings
from cmtof.ranging.optical import FREQUENCY, OpticalRanger
from cmtof.ranging.reach import levels_of_light
from cmtof.ranging.rf import RfRanger, RfReceiver, diode_power, emitting, modulation_depth
from cmtof.ranging.target import StageTarget, collected_power

run = plotting.begin(profile=profile, seed=seed)
blue, red, green = (plotting.PALETTE[name] for name in ("blue", "vermillion", "green"))
grey, black = "#5A646D", plotting.PALETTE["black"]
USUAL, HIGH = (
    paper.published("sec7.laser_power").value,
    paper.published("sec8.laser_power_high").value,
)
base = {power: emitting(TwinSettings(), power) for power in (USUAL, HIGH)}
targets = {"mirror": StageTarget.mirror(), "diffuse": StageTarget()}
colours = {"mirror": blue, "diffuse": red}
receiver = RfReceiver()
parts, frequency = receiver.parts, FREQUENCY["single"]
depth = modulation_depth(base[USUAL])


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, float(value), display=False)


# %% [markdown]
# ## The chain
#
# ```text
# light -> photodiode -> amplifier -> band-pass -> I/Q mixer -> low-pass -> converter
#            50 ohm                                  ^
#                                     drive (LO), 0 and 90 degrees
# ```
#
# Light of mean power $P$ whose fundamental has the depth $m$ makes a current, and in the load
# $R_L$ a voltage with the complex envelope
#
# ```{math}
# :label: eq-rf-envelope
# V = R_L\,R\,m\,|H(f)|\,P\,e^{i\phi}, \qquad \phi = 4\pi f z/c .
# ```
#
# $R$ is the responsivity ({glue:text}`responsivity:.1f` A/W at 532 nm, assumed), and $|H|$ =
# {glue:text}`response:.2f` what a bandwidth of {glue:text}`bandwidth:.0f` GHz leaves at
# {glue:text}`frequency:.2f` GHz. The emitted light is that of the all-optical instrument:
# $m = 2J_1(2\eta)$ = {glue:text}`depth:.2f`, more than one because the fundamental of a clipped
# wave may be. Mixed with the drive, $I$ and $Q$ are the two parts of $V$, and the phase is the
# angle of $I + iQ$. After averaging for the time $T$ of {glue:text}`time:.1f` ms, as long as the
# all-optical instrument takes for its 16 phases, each part has the noise
#
# ```{math}
# :label: eq-rf-noise
# \sigma_V^2 = \frac{k_BT_0F R_L + 2e\,(RP + I_d)\,R_L^2}{T},
# \qquad \mathrm{SNR} = \frac{|V|^2}{2\sigma_V^2} .
# ```
#
# The first term is thermal noise, worsened by the noise factor $F$ of the chain
# ({glue:text}`noise_factor:.1f`), and does not care about light; the second is shot noise. **The
# electrical signal power goes with the square of the optical power.** As long as thermal noise
# rules, so does the SNR: a thousandth of the light is a millionth of the SNR. Shot noise takes over
# at {glue:text}`shot_power:.1f` mW.
#
# What comes out of a mirror and of a diffuse plate at {glue:text}`distance:.1f` m, at the
# amplifier's input:

# %%
target_power = {
    (name, power): float(diode_power(base[power], parts, target, target.distance))
    for name, target in targets.items()
    for power in base
}
volts = {key: float(np.abs(receiver.envelope(p, depth))) for key, p in target_power.items()}
mixing, pickup = receiver.offsets()
noise = float(np.sqrt(2) * receiver.noise(0.0))
tell(
    responsivity=parts.photodiode.responsivity,
    response=1 / np.hypot(1, frequency / parts.photodiode.bandwidth),
    bandwidth=parts.photodiode.bandwidth / 1e9,
    frequency=frequency / 1e9,
    depth=depth,
    time=1e3 * parts.baseband.time,
    noise_factor=receiver.noise_factor,
    shot_power=1e3 * receiver.shot_noise_power(),
    distance=targets["mirror"].distance,
    seen=100 * target_power["diffuse", USUAL]
    / collected_power(base[USUAL], targets["diffuse"], targets["diffuse"].distance),
)  # fmt: skip


def power_text(watts):
    unit, scale = next(
        (u, s) for u, s in (("mW", 1e3), ("µW", 1e6), ("nW", 1e9)) if watts * s > 0.1
    )
    return f"{watts * scale:.2g} {unit}"


rows = ["| | light | level | SNR |", "| :-- | --: | --: | --: |"]
for (name, power), watts in target_power.items():
    ratio = 10 * np.log10(receiver.snr(watts, depth))
    level = receiver.level(volts[name, power])
    rows.append(
        f"| {name}, {1e3 * power:.0f} mW | {power_text(watts)} | {level:.0f} dBm | {ratio:.0f} dB |"
    )
for name, amplitude in (("pick-up", pickup), ("self-mixing", mixing), ("noise in T", noise)):
    rows.append(f"| {name} | | {receiver.level(amplitude):.0f} dBm | |")
glue("chain_levels", Markdown("\n".join(rows)), display=False)

# %% [markdown]
# ```{glue:md} chain_levels
# :format: myst
# ```
#
# The diffuse target has two handicaps. Its light spreads over the hemisphere, and the diode is
# {glue:text}`diode:.0f` µm wide: it sees {glue:text}`seen:.0f` % of the image of a beam that was
# defocused against speckle. The last three rows are no light. *Pick-up* is what the crystal's drive
# sends into the photodiode's cable, {glue:text}`isolation:.0f` dB down (assumed). *Self-mixing* is
# what the local oscillator leaks out of the mixer's input; the filter throws it back, and it mixes
# with itself to a direct voltage. Both are constant phasors, and both are far above the diffuse
# signal.

# %% tags=["hide-input"]
steps = ["photodiode", "amplifier", "band-pass", "mixer", "low-pass"]
amp, mix = parts.amplifier, parts.mixer
gains = np.cumsum([0.0, amp.gain, -amp.filter_loss, -mix.conversion_loss,
                   20 * np.log10(parts.baseband.gain)])  # fmt: skip
first = amp.noise_figure  # the amplifier's own noise is in from its output on
figures = np.array([0.0, first, first, 10 * np.log10(receiver.noise_factor),
                    10 * np.log10(receiver.noise_factor)])  # fmt: skip
floor = float(receiver.level(noise)) - 10 * np.log10(receiver.noise_factor) + gains + figures
fig, ax = plt.subplots(figsize=(7.4, 4.4))
place = np.arange(len(steps))
for name, colour in colours.items():
    for power, style in ((USUAL, "-o"), (HIGH, "--o")):
        ax.plot(place, receiver.level(volts[name, power]) + gains, style, ms=4, color=colour,
                label=f"{name}, {1e3 * power:.0f} mW")  # fmt: skip
ax.plot(place, receiver.level(pickup) + gains, "-s", ms=4, color=plotting.PALETTE["orange"],
        label="pick-up of the drive")  # fmt: skip
ax.plot(place[3:], receiver.level(mixing) + gains[3:], "-D", ms=4, color=plotting.PALETTE["purple"],
        label="self-mixing")  # fmt: skip
ax.fill_between(place, -190, floor, color="#D5DADF", lw=0)
ax.plot(place, floor, color=grey, lw=1.2)
ax.text(0.05, floor[0] - 4, f"noise in {1e3 * parts.baseband.time:.1f} ms", va="top", color=grey,
        fontsize=9)  # fmt: skip
ax.axhline(mix.compression, xmin=0.45, xmax=0.72, color=black, lw=1, ls=":")
ax.text(2.5, mix.compression + 3, "mixer compresses", fontsize=8.5)
ax.set(xticks=place, ylabel="level in 50 ohm (dBm)", ylim=(-190, 75), xlim=(-0.15, 4.15))
ax.set_xticklabels(steps)
ax.legend(ncols=2, fontsize=8.5, loc="upper left")
level = {key: float(receiver.level(v)) for key, v in volts.items()}
plotting.save(
    fig,
    "rf_levels",
    numbers={
        "mirror_dbm": level["mirror", USUAL],
        "diffuse_dbm": level["diffuse", USUAL],
        "noise_dbm": float(receiver.level(noise)),
        "pickup_dbm": float(receiver.level(pickup)),
        "self_mixing_dbm": float(receiver.level(mixing)),
    },
    caption=(
        "Levels behind each part of the RF chain, simulated: signals of mirror and diffuse plate "
        "at 60 cm, the offsets that are no light, and the noise that an average over 13.3 ms "
        "leaves."
    ),
    alt=(
        "Lines that rise and fall along photodiode, amplifier, band-pass, mixer and low-pass. "
        f"The mirror starts at {level['mirror', USUAL]:.0f} dBm, the pick-up of the drive at "
        f"{receiver.level(pickup):.0f}, the diffuse target at {level['diffuse', USUAL]:.0f} dBm, "
        f"right at the noise of {receiver.level(noise):.0f} dBm. Ten times the light is 20 dB."
    ),
)
tell(
    diode=1e6 * parts.photodiode.diameter,
    isolation=parts.pickup.isolation,
    apart=level["mirror", USUAL] - level["diffuse", USUAL],
    light_ratio=target_power["mirror", USUAL] / target_power["diffuse", USUAL],
    over=float(receiver.level(mixing)) - level["diffuse", USUAL],
)

# %% [markdown]
# Between mirror and diffuse plate lie a factor of {glue:text}`light_ratio:.1e` in light and
# {glue:text}`apart:.0f` dB in electrical power. Self-mixing alone stands
# {glue:text}`over:.0f` dB above the diffuse signal.
#
# ## Signal-to-noise ratio against light
#
# To compare the two instruments, take the SNR of a phase reading as $1/2\sigma_\phi^2$, which for
# RF is just {eq}`eq-rf-noise`, and put both on one axis: mean light behind the receiving optics,
# before any detector or second modulator. The all-optical chain loses light in its second
# modulator, and modulates only part of the rest, but its
# slow detector multiplies the current before the amplifier adds noise to it. So the detector's own
# noise counts only below {glue:text}`turn:.1f` nW; above, the noise is that of the photons.
# Where light would drive it beyond its end, a grey filter thins it. The dots are
# {glue:text}`draws:.0f` simulated readings each, decoded one by one, and their error's variance.

# %%
power = np.logspace(-12, -2, 201)
optical = OpticalRanger(base[USUAL])
slow = Conversion(optical.settings.detector, optical.settings.laser.wavelength)
own_noise, with_volt = slow.density(0.0), slow.density(1.0)
volts_equal = own_noise / (with_volt - own_noise)  # where shot noise equals it
passed = levels_of_light(optical, 1e-9).light / 1e-9
turn = float(volts_equal / slow.volts_per_watt / passed)
curves = {
    "RF, 7.15 GHz": (receiver.snr(power, depth), frequency, blue, "-"),
    "all-optical, 7.15 GHz": (
        1 / (2 * levels_of_light(optical, power).phase_noise ** 2), frequency, green, "-",
    ),
    "RF, 14.32 GHz": (
        receiver.snr(power, modulation_depth(base[USUAL], "doubled"),
                     frequency=FREQUENCY["doubled"]),
        FREQUENCY["doubled"], blue, ":",
    ),
    "all-optical, 14.32 GHz": (
        1 / (2 * levels_of_light(OpticalRanger(base[USUAL], "doubled"), power).phase_noise ** 2),
        FREQUENCY["doubled"], green, ":",
    ),
}  # fmt: skip
rng = np.random.default_rng(seed)
dots = np.logspace(-10.5, -2.5, 9)
read = receiver.phasor(dots[:, None], depth, np.full(draws, 1.0), rng=rng)
error = centred(receiver.estimate(read).phase - 1.0)
simulated = np.sqrt(np.mean(error**2, axis=1))
bound = receiver.phase_bound(dots, depth)
strong = bound < 0.1
reached = simulated[strong] / bound[strong]
law = np.array([phase_spread(float(one)) for one in bound])
off = float(np.abs(reached - 1).max())
print(
    "simulated over bound:",
    np.round(reached, 3),
    "| over the exact law:",
    np.round(simulated / law, 3),
)
print("within 3 % of the bound:", bool(off < 0.03))

# %% [markdown]
# Where the bound is small the readings reach it to {glue:text}`off:.1f` %. In weak light the phase
# follows the exact law of a phasor in noise, and ends up uniform over a turn: any range within a
# wrap of {glue:text}`wrap:.1f` mm, with a standard deviation of {glue:text}`uniform:.1f` mm.


# %%
def meeting(light):
    """RF minus all-optical SNR at equal light, as a logarithm."""
    other = 1 / (2 * levels_of_light(optical, light).phase_noise ** 2)
    return float(np.log(receiver.snr(light, depth) / other))


diffuse_light = {p: float(collected_power(base[p], targets["diffuse"], 0.6)) for p in base}
reach = float(1 / (2 * levels_of_light(optical, diffuse_light[USUAL]).phase_noise ** 2))
needed = brentq(lambda x: float(np.log(receiver.snr(10**x, depth) / reach)), -12, -1)
needed = 10.0 ** float(needed)  # W on the diode
crossing = 10.0 ** float(brentq(lambda x: meeting(10**x), -10, -2))
own = float(receiver.snr(target_power["diffuse", USUAL], depth))
factor = needed / target_power["diffuse", USUAL]
laser = USUAL * factor

# %% tags=["hide-input"]
fig, axes = plt.subplots(1, 2, figsize=(10.6, 4.6))
left, right = axes
for name, (ratio, of, colour, style) in curves.items():
    left.loglog(power, ratio, style, color=colour, label=name)
    linear = np.sqrt(1 / (2 * ratio))
    spread = [phase_spread(float(one)) if one > 0.05 else one for one in linear]
    right.loglog(power, 1e6 * depth_from_phase(spread, of), style, color=colour)
left.loglog(dots, 1 / (2 * simulated**2), "o", ms=5, mfc="none", color=black, label="simulated RF")
right.loglog(dots, 1e6 * depth_from_phase(simulated, frequency), "o", ms=5, mfc="none", color=black)
for name, target in targets.items():
    for p, marker in ((USUAL, "v"), (HIGH, "^")):
        light = float(collected_power(base[p], target, target.distance))
        for ax in axes:
            ax.axvline(light, color=colours[name], lw=1, ls="--" if p == HIGH else "-", alpha=0.5)
        left.plot(target_power[name, p], receiver.snr(target_power[name, p], depth), marker,
                  color=colours[name], ms=8, label=f"RF, {name}, {1e3 * p:.0f} mW")  # fmt: skip
left.plot(diffuse_light[USUAL], reach, "*", ms=13, color=green, label="all-optical, diffuse, 3 mW")
left.axhline(1, color=grey, lw=0.8)
left.set(ylim=(1e-6, 1e16), ylabel="SNR of a phase reading, $1/2\\sigma_\\phi^2$")
left.set_title("signal to noise")
right.set(ylim=(1e-3, 3e4), ylabel="standard deviation of range (µm)", title="range")
right.text(1.5e-12, 1.3e4, "uniform phase", fontsize=8.5, color=grey)
for ax in axes:
    ax.set(xlim=(power[0], power[-1]), xlabel="light collected (W)")
left.legend(fontsize=7.6, loc="upper left", ncols=2)
plotting.label_panels(axes)
plotting.save(
    fig,
    "rf_snr_power",
    numbers={
        "snr_rf_diffuse": own,
        "snr_rf_mirror": float(receiver.snr(target_power["mirror", USUAL], depth)),
        "snr_optical_diffuse": reach,
        "power_for_equal": needed,
        "crossing": crossing,
        "worst_over_bound": off,
    },
    caption=(
        "RF demodulation against the all-optical chain, both for 13.3 ms, noise alone. (a) SNR of "
        "a phase reading against the light collected. RF rises with its square, the all-optical "
        "chain, once photons make its noise, with its first power until the avalanche diode needs "
        "a grey filter. (b) The standard deviation of range that follows. Vertical lines: what "
        "comes back from mirror "
        "(blue) and diffuse plate (red) at 60 cm, at 3 mW (solid) and 30 mW (dashed); the markers "
        "lie left of their line by what the small photodiode does not see. Dots below an SNR of 1 "
        "have the variance of a uniform phase."
    ),
    alt=(
        "Two log-log plots against light from a picowatt to ten milliwatts. The RF line climbs two "
        "decades a decade and the all-optical line one; they cross near "
        f"{1e6 * crossing:.1g} microwatts. At the diffuse target's "
        f"{1e9 * diffuse_light[USUAL]:.1f} nanowatts the all-optical SNR is {reach:.0e} "
        f"and that of RF {own:.1g}. Dots of simulated readings lie on the RF line, and in weak "
        "light turn to the level of a uniform phase."
    ),
)
tell(
    draws=draws,
    turn=1e9 * turn,
    off=100 * off,
    wrap=1e3 * wrap_length(frequency),
    uniform=1e3 * depth_from_phase(np.pi / np.sqrt(3), frequency),
    own=own,
    reach=reach,
    needed=1e6 * needed,
    factor=factor,
    laser=laser,
    crossing=1e6 * crossing,
    nano=1e9 * diffuse_light[USUAL],
    rf_diffuse=1e3 * depth_from_phase(np.sqrt(1 / (2 * own)), frequency),
    rf_diffuse_high=1e6
    * depth_from_phase(receiver.phase_bound(target_power["diffuse", HIGH], depth), frequency),
    optical_diffuse=1e6 * depth_from_phase(np.sqrt(1 / (2 * reach)), frequency),
)

# %% [markdown]
# From the {glue:text}`nano:.1f` nW that a diffuse plate returns, the all-optical chain makes an SNR
# of {glue:text}`reach:.1e` ({glue:text}`optical_diffuse:.1f` µm of range), RF one of
# {glue:text}`own:.2f` ({glue:text}`rf_diffuse:.1f` mm by the linear formula, that is: not much).
# Ten times the laser brings RF to {glue:text}`rf_diffuse_high:.0f` µm, on noise alone. To reach
# what the all-optical chain has at 3 mW, RF needs {glue:text}`needed:.1f` µW on its diode,
# {glue:text}`factor:.0f` times more than it gets: a laser that sends {glue:text}`laser:.0f` W.
#
# The other side of the coin: beyond {glue:text}`crossing:.1f` µW the lines cross, and RF has less
# noise. Thermal noise stays and the signal grows until the converter's resolution ends it, while
# the avalanche diode has reached its end. On a mirror, noise is not what limits RF.
#
# ## In the plane of I and Q
#
# So what limits it on a mirror? Here the stage goes through one whole wrap. A perfect circuit
# would draw a circle about zero. The mixer's imbalance
# ({glue:text}`amplitude_imbalance:.1f` dB and {glue:text}`phase_imbalance:.0f` degrees, data sheet)
# makes it an ellipse,
#
# ```{math}
# :label: eq-rf-imbalance
# z \to \alpha z + \beta z^*,\quad \alpha = \tfrac12(1+ge^{i\epsilon}),\
# \beta = \tfrac12(1-ge^{-i\epsilon}),
# ```
#
# and its phase errs by up to $|\beta/\alpha|$ twice a turn, with an image rejection
# $|\alpha/\beta|^2$ of {glue:text}`rejection:.0f` dB. The offsets move it away from zero: an error
# once a turn. A lab measures both: the offset with the beam blocked, the imbalance while the phase
# goes round, and takes them away. What is left is what changes afterwards: here the offset drifts
# by {glue:text}`drift:.1f` % and the imbalance by as much (assumed).

# %%
round_trip = np.linspace(0, float(wrap_length(frequency)), 121)
seen = {}
for name, target in targets.items():
    for calibrated in (False, True):
        ranger = RfRanger(base[USUAL], receiver, calibrated=calibrated)
        found = ranger.readings(target, round_trip, repeats=1, seed=seed)[0]
        seen[name, calibrated] = (found.amplitude * np.exp(1j * found.phase))[0]

# %% tags=["hide-input"]
fig, axes = plt.subplots(1, 4, figsize=(11.4, 3.2))
for ax, ((name, calibrated), z) in zip(axes, seen.items(), strict=True):
    unit, scale = (
        ("V", 1.0) if name == "mirror" else (("mV", 1e3) if not calibrated else ("µV", 1e6))
    )
    ax.scatter(scale * z.real, scale * z.imag, c=np.arange(z.size), s=9,
               cmap=plotting.PHASE_CMAP)  # fmt: skip
    ax.plot(0, 0, "+", color=black, ms=10)
    if name == "diffuse":
        true = 1e6 * receiver.gain * volts["diffuse", USUAL]
        if calibrated:
            ax.add_patch(plt.Circle((0, 0), true, fill=False, color=green, lw=1.5))
            ax.set_title("")
            ax.text(0.03, 0.03, f"signal: circle of {true:.1f} µV", transform=ax.transAxes,
                    color=green, fontsize=8)  # fmt: skip
        else:
            middle = scale * z.mean()
            ax.plot([0, middle.real], [0, middle.imag], color="#B9C2CA", lw=1.2, zorder=0)
    else:
        ax.add_patch(plt.Circle((0, 0), receiver.gain * volts["mirror", USUAL], fill=False,
                                color=green, lw=1, ls=":"))  # fmt: skip
    reach_of = 1.15 * scale * np.abs(z).max()
    ax.set(xlim=(-reach_of, reach_of), ylim=(-reach_of, reach_of), aspect="equal",
           xlabel=f"I ({unit})", ylabel=f"Q ({unit})")  # fmt: skip
    ax.set_title(f"{name}, {'calibrated' if calibrated else 'as read'}")
    ax.tick_params(labelsize=8)
plotting.label_panels(axes)
offset_ratio = float(
    np.abs(seen["diffuse", False]).mean() / (receiver.gain * volts["diffuse", USUAL])
)
left_over = float(np.abs(seen["diffuse", True].mean()) / (receiver.gain * volts["diffuse", USUAL]))
plotting.save(
    fig,
    "rf_iq_plane",
    numbers={"offset_over_signal": offset_ratio, "left_over_signal": left_over},
    caption=(
        "What I and Q read while the stage goes through one wrap, colour by position, simulated. "
        "The plus is zero. (a, b) Mirror, as read and with offset and imbalance taken away; "
        "dotted: the true circle. "
        "(c, d) Diffuse plate, the same; the circle in (d) is the true signal."
    ),
    alt=(
        "Four scatter plots. The mirror as read is a ring stretched along Q, calibrated a circle "
        "about zero. The diffuse plate as read is one spot far from zero, "
        f"{offset_ratio:.0f} times the signal away; calibrated it is a cloud without order, on "
        f"average {left_over:.1f} signal amplitudes from zero."
    ),
    format="png",
)
mirror_signal = receiver.gain * volts["mirror", USUAL]
tell(
    amplitude_imbalance=mix.amplitude_imbalance,
    phase_imbalance=np.rad2deg(mix.phase_imbalance),
    rejection=10 * np.log10(receiver.imbalance.rejection),
    drift=100 * parts.pickup.drift,
    offset_ratio=offset_ratio,
    left_over=left_over,
)

# %% [markdown]
# The radius wanders because the fibre's throughput does; a phase does not mind. On the diffuse
# plate the offset is {glue:text}`offset_ratio:.0f` times the signal. Taken away, its drift still
# leaves {glue:text}`left_over:.1f` times the signal. So RF on nanowatts fails twice: by noise, and
# because an offset would have to stay put to one part in {glue:text}`offset_ratio:.0f` only to be
# no larger than the signal. Against noise ten times the light helps ten times, in range; against
# drift of that size it does not help until the signal is above it.
#
# ## A millimetre of travel
#
# The sweep of Section 8.2 is {glue:text}`travel:.0f` mm in steps of {glue:text}`step:.0f` µm at
# {glue:text}`distance:.1f` m. Each of {glue:text}`days:.0f` simulated days has its own offsets,
# drift and speckle; the first position is known and sets the zero of range.

# %%
travel = paper.published("sec8.sweep").value
step = paper.published("sec8.sweep_step").value
positions = np.arange(round(travel / step) + 1) * step
errors, bounds = {}, {}
for name, target in targets.items():
    for p in base:
        bounds[name, p] = float(RfRanger(base[p], receiver).bound(target, positions).mean())
        for calibrated in (False, True):
            ranger = RfRanger(base[p], receiver, calibrated=calibrated)
            found = ranger.sweep(target, positions, repeats=days, seed=seed)
            off_by = found - target.distance - positions
            errors[name, p, calibrated] = float(np.sqrt(np.mean(off_by**2)))
steady = replace(base[USUAL], drive=replace(base[USUAL].drive, phase_drift=0.0))
found = RfRanger(steady, receiver).sweep(targets["mirror"], positions, repeats=days, seed=seed)
steady_error = float(np.sqrt(np.mean((found - targets["mirror"].distance - positions) ** 2)))


def length(metres):
    if metres >= 1e-3:
        return f"{1e3 * metres:.1f} mm"
    return f"{1e6 * metres:.0f} µm" if metres > 1e-5 else f"{1e6 * metres:.2g} µm"


rows = ["| | bound | calibrated | as read |", "| :-- | --: | --: | --: |"]
rows += [
    f"| {name}, {1e3 * p:.0f} mW | {length(bounds[name, p])} | {length(errors[name, p, True])} "
    f"| {length(errors[name, p, False])} |"
    for name, p in bounds
]
glue("rf_sweep", Markdown("\n".join(rows)), display=False)
still = float(np.sqrt(np.mean(positions**2)))
gain_of_ten = errors["diffuse", USUAL, True] / errors["diffuse", HIGH, True]
verdict = (
    "Ten times the light hardly helps the calibrated circuit, as the paper reports: drift of the "
    "offset has taken over from noise."
    if gain_of_ten < 2
    else "Ten times the light helps the calibrated circuit here, where the paper reports no help."
)
glue("ten_times", Markdown(verdict), display=False)
tell(
    travel=1e3 * travel,
    step=1e6 * step,
    days=days,
    still=1e6 * still,
    mirror_raw=1e6 * errors["mirror", USUAL, False],
    mirror_calibrated=1e6 * errors["mirror", USUAL, True],
    steady=1e6 * steady_error,
    phase_drift=1e3 * base[USUAL].drive.phase_drift,
    mirror_bound=1e9 * bounds["mirror", USUAL],
    gain_of_ten=gain_of_ten,
)

# %% [markdown]
# Root mean square of the error of range:
#
# ```{glue:md} rf_sweep
# :format: myst
# ```
#
# On the mirror the circuit is a good instrument. Noise would allow {glue:text}`mirror_bound:.0f`
# nm; imbalance and offsets leave {glue:text}`mirror_raw:.0f` µm as read, and calibration brings
# that down to {glue:text}`mirror_calibrated:.1f` µm. Of this the slow drift of
# {glue:text}`phase_drift:.0f` mrad between the phases of drive and light is most, which the
# all-optical instrument shares; without it {glue:text}`steady:.2f` µm are left.
#
# On the diffuse plate the reading without calibration *looks* tame only because it does not move at
# all: it shows the angle of the offset, and its error is the travel itself,
# {glue:text}`still:.0f` µm rms for a sweep that starts at the known position. With another zero it
# would be any constant up to half a wrap, {glue:text}`half:.1f` mm.

# %%
tell(half=1e3 * wrap_length(frequency) / 2)

# %% [markdown]
# ```{glue:md} ten_times
# :format: myst
# ```
#
# Two remarks on the paper's text. It sets its kHz sampling against «direct fast sampling at rates
# higher than 10 GHz in the RF setup»; but the circuit of Section 7.4 does not sample fast, its
# mixer hands a slow voltage to the same kind of converter. The ratio below is that of sampling
# twice a period at 7.15 GHz. And a photodiode of 12 GHz is no obstacle at 7.15 GHz, where it loses
# {glue:text}`loss:.1f` dB; what is missing is light.
#
# ## Against the paper

# %%
tell(loss=-20 * np.log10(1 / np.hypot(1, frequency / parts.photodiode.bandwidth)))
nyquist = 2 * frequency / parts.baseband.rate
paper.check("sec7.photodetector", parts.photodiode.bandwidth)
paper.check("sec8.laser_power_high", sent_power(base[HIGH]))
paper.check("sec8.laser_power_ratio", base[HIGH].laser.power / base[USUAL].laser.power)
paper.check("sec8.sampling_ratio", nyquist)
