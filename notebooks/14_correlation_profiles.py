# %% [markdown]
# # Correlation profiles
#
# A mirror stands still, the phase of the reference turns once, and what the instrument reads should
# be a cosine: that is Eq. 20, and Fig. 12 of the paper shows it *measured*. This page takes the
# same profiles from the *simulated* instrument over the wire: drivers, phase table, trigger, stream
# and counts, as in a scan. Then it looks at what is left when the cosine has been taken away.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of noise, drift and errors of the drivers
bursts: int = 48  # sweeps of the reference phase averaged in Fig. 12
settings: int = 48  # phases programmed into the emission's driver
sweeps: int = 60  # sweeps in a row with the paper's RC
reflectance: float = 6e-6  # of the mirror behind its grey filter

# %%
from dataclasses import replace
from itertools import count

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from myst_nb import glue
from scipy.special import jv

from cmtof.book import paper, plotting
from cmtof.correlation import TAU, centred, correlation_from_harmonics, decode
from cmtof.hardware.bench import Bench
from cmtof.hardware.reduction import Sampling, drive_phases, nominal_psi
from cmtof.hardware.rig import Rig
from cmtof.hardware.twin.run import Twin
from cmtof.instrument.electronics import Conversion, chain
from cmtof.instrument.world import LABEL_TIME
from cmtof.modulator import doubled_mode_harmonics, single_mode_harmonics

run = plotting.begin(profile=profile, seed=seed)
COLOURS = {"single": plotting.PALETTE["blue"], "doubled": plotting.PALETTE["vermillion"]}
HARMONICS = {"single": single_mode_harmonics, "doubled": doubled_mode_harmonics}
ORDER = {"single": 1, "doubled": 2}
PHASES = 64
TICKS = 5  # numbers from one burst to the next
black = plotting.PALETTE["black"]


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, float(value), display=False)


# %% [markdown]
# ## What Eq. 20 says
#
# ```{math}
# :label: eq-20-profile
# C_\psi = Q\!\left(G\int_0^T \tilde p(t-\tau)\,r(t)\,dt\right)
#        = Q\!\left(\frac{\tilde\alpha}{2}\cos(\psi-\phi) + TK\right)
# ```
#
# Here both $\tilde p$ and $r$ are transmissions of a two-pass modulator, with the harmonics $W_k$
# and $R_k$. With $P$ the light that would reach the detector through open modulators, $S$ the
# detector's volts per watt and $u$ the room's light,
#
# $$U(\psi) = \underbrace{S\,(P\,W_0R_0 + u)}_{K}
#   + \underbrace{2\,S P\,|W_mR_m|}_{\tilde\alpha/2}\cos(\phi+\psi) + \dots$$
#
# with m = 1 in the single mode and 2 in the doubled one, and higher harmonics behind the dots. The
# read-out adds up samples for a time $T$, so *both* terms get the factor $T$; in
# {eq}`eq-20-profile` the first one lacks it. The sign is that of the convention here,
# $\phi+\psi$ ({doc}`22_errata`).
#
# ## The sweep
#
# The detection's driver gets a table of {glue:text}`phases:.0f` phases, where a scan has
# {glue:text}`scan_phases:.0f`. The read-out's pulses step it every {glue:text}`per_phase:.0f`
# samples; the first {glue:text}`settle:.0f` of each phase, while the filter settles, are dropped.
# The mirror wears a grey filter, for bare it would drive the detector
# {glue:text}`overload:.0f` thousand times beyond its end. Each sweep is divided by the laser's
# power, read before and after.

# %%
base = Rig.default()


def simulated(phases, **twin):
    """A default rig with a mirror at 60 cm and so many phases; `twin` changes the simulation."""
    detection = replace(base.settings.detection, phases=phases)
    rig = replace(base, settings=replace(base.settings, detection=detection, twin=twin))
    mirror = {"kind": "mirror", "distance": 0.6, "reflectance": reflectance}
    return Twin(rig, scene=mirror, seed=seed, private=True)


def bench_of(twin, instruments):
    reading = twin.rig.settings.detection
    layout = Sampling(reading.phases, reading.samples_per_phase, reading.settle_samples,
                      reading.settle_samples)  # fmt: skip
    bench = Bench(instruments, twin.rig.settings, layout)
    bench.set_up()
    return bench


# %% [markdown]
# A burst carries a number that the simulated instrument takes as its clock,
# {glue:text}`tick_ms:.0f` ms each; one of {glue:text}`burst_ms:.0f` ms and a reading of the power
# take {glue:text}`ticks:.0f`. After the sweeps the emission's driver is told one
# phase after another, and a single sweep is taken at each: that is the test of linearity further
# down.

# %%
taken, dark, power, programmed, shifted = {}, {}, {}, {}, {}
with simulated(PHASES) as twin, twin.rig.open() as instruments:
    bench = bench_of(twin, instruments)
    labels, to_volts = count(TICKS, TICKS), instruments.daq.volts_from_counts
    reading = twin.rig.settings.detection

    def sweep():
        counts = bench.burst(next(labels))
        kept = counts.reshape(PHASES, reading.samples_per_phase)[:, reading.settle_samples :]
        return to_volts(kept, reading.range).mean(axis=1)

    for mode in ORDER:
        bench.choose_mode(mode)
        bench.begin_line()
        dark[mode] = np.mean([sweep() for _ in range(8)])
        bench.look_at("scan")
        bench.begin_line()
        sweep()  # sets the clock; its laser power is the first
        power[mode], taken[mode] = [bench.power()], []
        for _ in range(bursts):
            taken[mode].append(sweep())
            power[mode].append(bench.power())
        programmed[mode], shifted[mode] = [], []
        for step in TAU * np.arange(settings) / settings / ORDER[mode]:
            programmed[mode].append(instruments.rf_emission.set_phase(step))
            shifted[mode].append(sweep())
            power[mode].append(bench.power())
        instruments.rf_emission.set_phase(0.0)
        bench.check()
    stepped, known = bench.stepped(), twin.world.settings
    bench.shut()
print("table stepped once a phase:", stepped, "| samples of a phase:", reading.samples_per_phase)

# %% [markdown]
# The laser drifts through a sweep; between the two readings beside it a straight line will do. (The
# simulated meter gives the power at the moment it is asked, at the end of a burst.)

# %%
psi = nominal_psi(PHASES)
burst_time = reading.scans / reading.rate
between = TICKS * LABEL_TIME  # from one burst to the next, s
middle = (np.arange(PHASES) + 0.5) / PHASES * burst_time
place = (middle + between - burst_time) / between
profiles, moved, fits = {}, {}, {}
for mode in ORDER:
    meter = np.array(power[mode])
    light = meter[:-1, None] + (meter[1:] - meter[:-1])[:, None] * place
    level = (np.array(taken[mode] + shifted[mode]) - dark[mode]) * meter.mean() / light
    profiles[mode], moved[mode] = level[:bursts], level[bursts:]
    fits[mode] = decode(profiles[mode].mean(axis=0), psi)
    print(f"{mode}: {fits[mode].offset:.3f} V + {fits[mode].amplitude:.3f} V cos(ψ + φ)")

# %% [markdown]
# ## What to expect
#
# **Noise.** Light and amplifier make white noise of a known density; the filters in between let
# their samples agree with each other a little, which the covariance of the chain tells. The
# converter adds its own, independent noise. So each phase of the mean profile has a foretold
# standard deviation.
#
# **Harmonics.** Of two modules with the harmonics $W_k$ the correlation has $|W_k|^2$: relative to
# its fundamental, the third is $(J_3/J_1)^2$ in the single mode, and the second
# $(J_4/J_2)^2$ in the doubled one, at $2\eta$. There are no even ones in the single mode.
#
# **Errors of the drivers.** Each phase that a driver makes is off by a little, by its code and as
# $\sin 2\varphi$; both have stated sizes in the simulation. The second can be foretold, the first
# is random.


# %%
def foretold_noise(volts, samples):
    """Standard deviation of the mean over successive samples at an output, V."""
    filters = chain(known.detector, 1 / reading.rate)
    settled = filters.settled @ filters.settled.T
    lags, carried = [], np.eye(3)
    for _ in range(samples):
        lags.append((carried @ settled)[-1, -1])
        carried = filters.transition @ carried
    weight = np.where(np.arange(samples) == 0, 1, 2) * (samples - np.arange(samples)) / samples**2
    density = Conversion(known.detector, known.laser.wavelength).density(volts)
    per_count = np.diff(to_volts(np.array([30000, 30001]), reading.range))[0]
    converter = (known.detector.converter_noise**2 + 1 / 12) * per_count**2 / samples
    return np.sqrt(density * (weight @ lags) + converter)


def foretold(mode, phase, steps, emitted=0.0):
    """Correlation with all harmonics, and the drivers' errors that are no noise."""
    w = HARMONICS[mode](known.drive.eta, 16)[:: ORDER[mode]]
    skew = known.drive.iq_imbalance
    drives = drive_phases(PHASES, mode)[steps]
    error = np.subtract.outer(skew * np.sin(2 * np.asarray(emitted)), skew * np.sin(2 * drives))
    shift = np.add.outer(ORDER[mode] * np.asarray(emitted), psi[steps]) + ORDER[mode] * error
    return correlation_from_harmonics(w, w, phase=phase, psi=shift)


# %%
kept = reading.samples_per_phase - reading.settle_samples
left, model, noise = {}, {}, {}
every = np.arange(PHASES)
for mode, fit in fits.items():
    mean = profiles[mode].mean(axis=0)
    straight = fit.offset + fit.amplitude * np.cos(fit.phase + psi)
    ideal = foretold(mode, fit.phase, every)
    ideal = foretold(mode, fit.phase - (decode(ideal, psi).phase - fit.phase), every)
    own = decode(ideal, psi)
    bent = ideal - own.offset - own.amplitude * np.cos(own.phase + psi)
    left[mode], model[mode] = mean - straight, bent * fit.amplitude / own.amplitude
    noise[mode] = foretold_noise(mean + dark[mode], kept) / np.sqrt(bursts)
code = {
    mode: ORDER[mode] * known.drive.phase_step_error * fits[mode].amplitude
    * np.abs(np.sin(fits[mode].phase + psi))
    for mode in ORDER
}  # fmt: skip
pull = {m: (left[m] - model[m]) / noise[m] for m in ORDER}
pull_all = {m: (left[m] - model[m]) / np.hypot(noise[m], code[m]) for m in ORDER}
spread = {m: float(np.std(profiles[m] - profiles[m].mean(0), ddof=1)) for m in ORDER}
single_noise = {m: float(np.sqrt(np.mean(noise[m] ** 2 * bursts))) for m in ORDER}
freedom = np.sqrt(PHASES / (PHASES - 3))
for m in ORDER:
    print(
        f"{m}: residual {1e3 * left[m].std():.2f} mV, harmonics taken away "
        f"{1e3 * (left[m] - model[m]).std():.2f} mV, noise foretold "
        f"{1e3 * np.sqrt(np.mean(noise[m] ** 2)):.2f} mV; in units of the noise "
        f"{freedom * pull[m].std():.2f}, with the codes' errors {freedom * pull_all[m].std():.2f}"
    )

# %% tags=["hide-input"]
figure, axes = plt.subplots(3, 2, figsize=(10.4, 8.8), height_ratios=[1.25, 1, 1])
turn = np.linspace(0, TAU, 400)
for column, (mode, fit) in enumerate(fits.items()):
    top, middle_ax, low = axes[:, column]
    colour, mean = COLOURS[mode], profiles[mode].mean(axis=0)
    top.plot(turn, fit.offset + fit.amplitude * np.cos(fit.phase + turn), color=colour, lw=4,
             alpha=0.5, label="fitted cosine")  # fmt: skip
    top.plot(psi, mean, "o", ms=2.8, color=black, label=f"mean of {bursts} sweeps")
    top.axhline(fit.offset, color="#8A97A3", lw=1, ls=":")
    top.text(TAU * 0.995, fit.offset, "$K$", ha="right", va="bottom", color="#5A646D")
    peak = float(np.mod(-fit.phase, TAU))
    bar = {"arrowstyle": "<->", "color": "#5A646D", "shrinkA": 0, "shrinkB": 0}
    top.annotate("", (peak, fit.offset), (peak, fit.offset + fit.amplitude), arrowprops=bar)
    top.text(peak + 0.12, fit.offset + 0.4 * fit.amplitude, r"$\tilde\alpha/2$", color="#5A646D")
    top.set(title=f"{mode} mode", ylim=(0, 1.32 * (fit.offset + fit.amplitude)))
    top.legend(loc="upper center", ncols=2, fontsize=8.5)
    band = 1e3 * np.stack([model[mode] - noise[mode], model[mode] + noise[mode]])
    middle_ax.fill_between(psi, *band, color=colour, alpha=0.3, lw=0, label="foretold, ± noise")
    middle_ax.plot(psi, 1e3 * left[mode], "o", ms=3.5, color=black, label="what the fit leaves")
    reach = 1e3 * np.abs(left[mode]).max()
    middle_ax.set(ylim=(-1.25 * reach, 1.75 * reach))
    middle_ax.legend(loc="upper center", ncols=2, fontsize=8.5)
    for ax in (top, middle_ax):
        ax.set(xlim=(-0.1, TAU + 0.1), xlabel="reference phase ψ (rad)")
        ax.set_xticks([0, np.pi / 2, np.pi, 3 * np.pi / 2, TAU], ["0", "π/2", "π", "3π/2", "2π"])

# %% tags=["hide-input"]
axes[0, 0].set_ylabel("output (V)")
axes[1, 0].set_ylabel("residual (mV)")
orders = np.arange(1, 9)
harmonic, closed_form, floor = {}, {}, {}
for ax, (mode, fit) in zip(axes[2], fits.items(), strict=True):
    spectrum = 2 * np.abs(np.fft.fft(profiles[mode].mean(axis=0))) / PHASES
    harmonic[mode] = spectrum[orders] / fit.amplitude
    w = np.abs(HARMONICS[mode](known.drive.eta, 16))[:: ORDER[mode]]
    closed_form[mode] = (w[orders] / w[1]) ** 2
    floor[mode] = float(np.sqrt(4 / PHASES * np.mean(np.hypot(noise[mode], code[mode]) ** 2)))
    floor[mode] /= fit.amplitude
    strong = closed_form[mode] > 1e-9
    ax.vlines(orders[strong], 1e-7, closed_form[mode][strong], color=COLOURS[mode], lw=9,
              alpha=0.35, label="closed form")  # fmt: skip
    ax.plot(orders, harmonic[mode], "o", ms=6, mfc="none", color=black, label="of the profile")
    ax.axhline(floor[mode], color="#5A646D", lw=1.2, ls="--", label="noise and codes, rms")
    ax.set(yscale="log", ylim=(1e-5, 3), xlabel="harmonic of ψ", xlim=(0.4, 8.6))
    ax.legend(loc="upper right", fontsize=8.5)
axes[2, 0].set_ylabel("over the fundamental")
plotting.label_panels(axes.flat)
contrast = {m: float(fits[m].amplitude / fits[m].offset) for m in ORDER}
plotting.save(
    figure,
    "fig12_correlation_profiles",
    numbers={
        "offset": [float(fits[m].offset) for m in ORDER],
        "amplitude": [float(fits[m].amplitude) for m in ORDER],
        "contrast": list(contrast.values()),
        "third_of_single": float(harmonic["single"][2]),
        "second_of_doubled": float(harmonic["doubled"][1]),
        "pull": [float(freedom * pull_all[m].std()) for m in ORDER],
    },
    caption=(
        "Correlation of a fixed mirror against the reference phase, in the single and the doubled "
        "mode, simulated and read through the drivers (the paper's Fig. 12 is a measurement). "
        "(a, b) Profile and fitted cosine, with the terms of Eq. 20. (c, d) What the fit leaves, "
        "and what harmonics and drivers were foretold to leave. (e, f) Harmonics of the profile."
    ),
    alt=(
        "Six panels in two columns, single and doubled mode. Above, points follow one period of a "
        f"cosine with a contrast of {contrast['single']:.2f} and {contrast['doubled']:.2f}. In the "
        "middle the residual: in the single mode a wave of three periods with an amplitude of "
        f"{100 * harmonic['single'][2]:.2f} percent of the cosine's, in the doubled mode one of "
        f"two periods with {100 * harmonic['doubled'][1]:.2f} percent. What was foretold leaves "
        f"{freedom * pull_all['single'].std():.1f} and {freedom * pull_all['doubled'].std():.1f} "
        "times the noise of them. Below, spectra with the foretold harmonics as bars."
    ),
)

# %% tags=["hide-input"]
tell(
    phases=PHASES,
    scan_phases=base.settings.detection.phases,
    per_phase=reading.samples_per_phase,
    settle=reading.settle_samples,
    tick_ms=1e3 * LABEL_TIME,
    burst_ms=1e3 * burst_time,
    ticks=TICKS,
    overload=0.97e-3  # of a silvered mirror; in thousands
    * (fits["single"].offset + fits["single"].amplitude)
    / reflectance
    / known.detector.saturation,
    contrast_single=contrast["single"],
    contrast_doubled=contrast["doubled"],
    closed_single=2 * jv(1, 2 * known.drive.eta) ** 2,
    closed_doubled=2 * (jv(2, 2 * known.drive.eta) / (1 - jv(0, 2 * known.drive.eta))) ** 2,
    third=100 * harmonic["single"][2],
    third_closed=100 * closed_form["single"][2],
    second=100 * harmonic["doubled"][1],
    second_closed=100 * closed_form["doubled"][1],
    pull_single=freedom * pull["single"].std(),
    pull_doubled=freedom * pull["doubled"].std(),
    full_single=freedom * pull_all["single"].std(),
    full_doubled=freedom * pull_all["doubled"].std(),
    spread_single=1e3 * spread["single"],
    spread_doubled=1e3 * spread["doubled"],
    noise_single=1e3 * single_noise["single"],
    noise_doubled=1e3 * single_noise["doubled"],
    step14=1e3 * 20 / 2**14 / np.sqrt(12),
)

# %% [markdown]
# The contrasts are {glue:text}`contrast_single:.3f` and {glue:text}`contrast_doubled:.3f`, where
# ideal modules would give $2J_1^2$ = {glue:text}`closed_single:.3f` and
# $2J_2^2/(1-J_0)^2$ = {glue:text}`closed_doubled:.3f`; the rest is light that the splitters leak.
# The third harmonic of the single mode is {glue:text}`third:.2f` % (foretold
# {glue:text}`third_closed:.2f` %), the second of the doubled {glue:text}`second:.2f` %
# ({glue:text}`second_closed:.2f` % from the light, the rest from the drivers' $\sin 2\varphi$). So
# Fig. 12's cosine is one only to the eye: what is left of it has a shape.
#
# **In units of the noise.** Sweep by sweep the phases scatter by {glue:text}`spread_single:.2f` and
# {glue:text}`spread_doubled:.2f` mV, where {glue:text}`noise_single:.2f` and
# {glue:text}`noise_doubled:.2f` mV were foretold. Averaged, and the foretold shape taken away, the
# residual is {glue:text}`pull_single:.2f` and {glue:text}`pull_doubled:.2f` times the noise of the
# mean: errors of the single phase codes do not average out. With their stated size it is
# {glue:text}`full_single:.2f` and {glue:text}`full_doubled:.2f`. Rounding to the 14 bits of
# {eq}`eq-20-profile` in place of 16 would add {glue:text}`step14:.2f` mV to each sample, and change
# nothing.

# %% [markdown]
# ## Four steps, and sixteen
#
# Now the emission's driver is told a phase, and the correlation should move by just that. From each
# sweep of 64 phases every sixteenth, or every fourth, makes a measurement of 4 or of 16 steps. With
# four, harmonic 3 cannot be told from the fundamental and turns up as an error that goes round four
# times a turn, with the amplitude $(J_3/J_1)^2$ = {glue:text}`cyclic:.1f` mrad in the single mode;
# in the doubled one it is the third harmonic of *its* correlation, $(J_6/J_2)^2$, which is nothing.
# Sixteen steps leave what the drivers do.

# %%
errors, expected = {}, {}
for mode in ORDER:
    told = ORDER[mode] * np.array(programmed[mode])
    seen = moved[mode].T
    for number in (4, 16):
        steps = every[:: PHASES // number]
        decoded = decode(seen[steps], psi[steps]).phase
        off = np.angle(np.exp(1j * (decoded - told)))
        errors[mode, number] = 1e3 * centred(off - np.angle(np.exp(1j * off).mean()))
        fine = np.linspace(0, TAU, 241) / ORDER[mode]
        curve = foretold(mode, fits[mode].phase, steps, emitted=fine)
        off = np.angle(np.exp(1j * (decode(curve.T, psi[steps]).phase - ORDER[mode] * fine)))
        expected[mode, number] = 1e3 * centred(off - np.angle(np.exp(1j * off).mean()))
rms = {key: float(np.sqrt(np.mean(value**2))) for key, value in errors.items()}
print({f"{mode}, {number} steps": f"{value:.2f} mrad rms" for (mode, number), value in rms.items()})

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(10.2, 4.0))
for ax, mode in zip(axes, ORDER, strict=True):
    told = ORDER[mode] * np.array(programmed[mode])
    for number, colour, marker in ((4, plotting.PALETTE["orange"], "s"), (16, COLOURS[mode], "o")):
        ax.plot(np.linspace(0, TAU, 241), expected[mode, number], color=colour, lw=1.4)
        ax.plot(told, errors[mode, number], marker, ms=4.5, color=colour, label=f"{number} steps")
    ax.set(title=f"{mode} mode", xlim=(0, TAU), xlabel="programmed phase of the correlation (rad)")
    ax.set_xticks([0, np.pi / 2, np.pi, 3 * np.pi / 2, TAU], ["0", "π/2", "π", "3π/2", "2π"])
    reach = 1.15 * np.abs(errors[mode, 4]).max()
    ax.set_ylim(-reach, 1.35 * reach)
    ax.legend(loc="upper right", ncols=2, fontsize=8.5)
axes[0].set_ylabel("decoded minus programmed (mrad)")
plotting.label_panels(axes)
plotting.save(
    figure,
    "instrument_linearity",
    numbers={f"{mode}_{number}": value for (mode, number), value in rms.items()},
    caption=(
        "Decoded minus programmed phase, mean removed, with 4 and with 16 steps of the reference; "
        "dots: simulated, one sweep each; lines: foretold from harmonics and drivers, without "
        "noise. Mind the two scales."
    ),
    alt=(
        "Two panels. In the single mode four steps err with four periods in a turn, "
        f"{rms['single', 4]:.1f} milliradian rms, and sixteen steps stay within "
        f"{np.abs(errors['single', 16]).max():.1f} milliradian. In the doubled mode four steps err "
        f"by {rms['doubled', 4]:.1f} and sixteen by {rms['doubled', 16]:.1f} milliradian rms. Dots "
        "scatter about the foretold lines."
    ),
)
tell(cyclic=1e3 * closed_form["single"][2],
     four_single=rms["single", 4], sixteen_single=rms["single", 16],
     four_doubled=rms["doubled", 4], sixteen_doubled=rms["doubled", 16],
     skew=1e3 * known.drive.iq_imbalance)  # fmt: skip

# %% [markdown]
# In the single mode four steps err by {glue:text}`four_single:.1f` mrad rms, sixteen by
# {glue:text}`sixteen_single:.1f` mrad; in the doubled mode it is {glue:text}`four_doubled:.1f` and
# {glue:text}`sixteen_doubled:.1f` mrad, most of it the noise of a single sweep. The slow
# waves that sixteen steps keep are the drivers' own: a phase is off by {glue:text}`skew:.0f` mrad
# times $\sin 2\varphi$, and no number of steps removes what the emission itself does.

# %% [markdown]
# ## An RC of 100 ms
#
# Section 7.2 prints a time constant of 100 ms for the RC behind the detector. One turn of the
# reference in 16 steps takes {glue:text}`turn_ms:.1f` ms, so that such an RC damps it by
# $\sqrt{1+(2\pi f\,t_{RC})^2}$ = {glue:text}`damping:.1f`. The simulated instrument can be built
# like that. It runs {glue:text}`sweeps:.0f` sweeps in a row, in one burst; the table wraps.

# %%
runs = {}
paper_rc = paper.published("sec7.rc_time").value
for rc in (known.detector.rc_time, paper_rc):
    with simulated(16, detector={"rc_time": rc}) as twin, twin.rig.open() as instruments:
        bench = bench_of(twin, instruments)
        bench.choose_mode("single")
        bench.look_at("scan")
        bench.begin_line()
        sampling = twin.rig.settings.detection
        instruments.daq.configure_burst(
            channel=sampling.channel_number, rate=sampling.rate, scans=sweeps * sampling.scans,
            range=sampling.range, pulse_line=twin.rig.settings.lines.trigger,
            scans_per_pulse=sampling.samples_per_phase,
        )  # fmt: skip
        counts = instruments.daq.burst({"USER_RAM0_U32": 5}).counts
        runs[rc] = instruments.daq.volts_from_counts(counts, sampling.range)
        bench.shut()
times = np.arange(sweeps * sampling.scans) / sampling.rate
sweep_rate = sampling.rate / sampling.scans
late = times > times[-1] - min(20, sweeps // 2) / sweep_rate
cycle = TAU * sweep_rate * times[late]
slow = (times[late] - times[late].mean()) * sweep_rate
design = np.stack([np.ones_like(slow), slow, slow**2, np.cos(cycle), np.sin(cycle)], axis=1)
swing = {rc: np.hypot(*np.linalg.lstsq(design, volts[late], rcond=None)[0][3:])
         for rc, volts in runs.items()}  # fmt: skip
damping = np.hypot(1, TAU * sweep_rate * paper_rc)
found_damping = swing[known.detector.rc_time] / swing[paper_rc]
print(f"damped {found_damping:.1f} times, foretold {damping:.1f}")

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(10.2, 3.9), width_ratios=[1.35, 1])
names = {known.detector.rc_time: f"RC {1e6 * known.detector.rc_time:.0f} µs",
         paper_rc: f"RC {1e3 * paper_rc:.0f} ms, as printed"}  # fmt: skip
looks = {known.detector.rc_time: {"color": COLOURS["single"]},
         paper_rc: {"color": plotting.PALETTE["orange"], "lw": 2}}  # fmt: skip
axes[0].plot(1e3 * times, runs[known.detector.rc_time], lw=0.4, alpha=0.55, color=COLOURS["single"],
             rasterized=True)  # fmt: skip
axes[0].plot(1e3 * times, runs[paper_rc], **looks[paper_rc])
axes[0].set(xlabel="time (ms)", ylabel="output (V)", xlim=(0, 1e3 * times[-1]),
            title=f"{sweeps} sweeps in a row", ylim=(0, None))  # fmt: skip
last = times >= times[-1] - 2 / sweep_rate
since = 1e3 * (times[last] - times[last][0])
for rc, volts in runs.items():
    axes[1].plot(since, volts[last], label=names[rc], **looks[rc])
axes[1].set(xlabel="time (ms)", xlim=(0, since[-1]), title="the last two",
            ylim=(0, 1.45 * runs[known.detector.rc_time].max()))  # fmt: skip
axes[1].legend(loc="upper center", ncols=1, fontsize=8.5)
plotting.label_panels(axes)
plotting.save(
    figure,
    "instrument_rc",
    numbers={"swing": [float(v) for v in swing.values()], "damping": found_damping},
    caption=(
        "The profile of the single mode read in time, with the RC of the simulated instrument and "
        "with the one printed in the paper (simulated): (a) from the start, (b) two sweeps at the "
        "end."
    ),
    alt=(
        f"Two panels of voltage against time. With {1e6 * known.detector.rc_time:.0f} microseconds "
        "the output follows every sweep of the phase in steps. With "
        f"{1e3 * paper_rc:.0f} milliseconds it creeps from its first value towards the mean, and "
        f"swings {found_damping:.0f} times less."
    ),
    format="png",
)
tell(turn_ms=1e3 / sweep_rate, damping=damping, found_damping=found_damping, sweeps=sweeps,
     memory=paper_rc * sweep_rate, swing=1e3 * swing[paper_rc])  # fmt: skip

# %% [markdown]
# The swing falls {glue:text}`found_damping:.1f` times, to {glue:text}`swing:.1f` mV. Noise that
# comes before the RC falls with it, so the phase would survive in principle. What does not is the
# image: the RC remembers {glue:text}`memory:.1f` sweeps, and as the scan goes on to the next point
# after one, most of a reading would belong to the points before. With the
# {glue:text}`rc_here:.0f` µs assumed here the filter has settled within the samples that are
# dropped. (The simulation starts each burst settled, so it takes long bursts to show this.)
#
# ## Both terms grow with T
#
# The last point needs no more light. Of each phase's kept samples the first few are added up:

# %%
tell(rc_here=1e6 * known.detector.rc_time)
levels = runs[known.detector.rc_time].reshape(sweeps, 16, sampling.samples_per_phase)
grown = {}
for samples in (4, 8, 16):
    chosen = slice(sampling.settle_samples, sampling.settle_samples + samples)
    totals = levels[..., chosen].sum(axis=-1) / sampling.rate
    fit = decode(totals.mean(axis=0), nominal_psi(16))
    grown[samples] = 1e6 * samples / sampling.rate, 1e6 * fit.offset, 1e6 * fit.amplitude
lines = ["| T (µs) | TK (µV s) | amplitude (µV s) | their ratio |", "| --: | --: | --: | --: |"]
lines += [f"| {t:.0f} | {k:.0f} | {a:.0f} | {a / k:.3f} |" for t, k, a in grown.values()]
glue("grown", Markdown("\n".join(lines)), display=False)

# %% [markdown]
# ```{glue:md} grown
# :format: myst
# ```
#
# ## Against the paper

# %%
reached = {
    "fig12.psi_range": PHASES * (psi[1] - psi[0]),
    "sec7.rc_time": known.detector.rc_time,
    "sec7.samples_per_phase": reading.samples_per_phase,
    "sec8.scan_phase_steps": base.settings.detection.phases,
    "sec8.scan_integration_time": base.settings.detection.duration,
}
for key, value in reached.items():
    paper.check(key, value)
