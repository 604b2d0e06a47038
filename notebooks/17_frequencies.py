# %% [markdown]
# # Other frequencies
#
# The paper measures at 7.15 and 14.32 GHz. Its modulators reach ±10 MHz about 7.15 GHz, and twice
# that in the doubled mode. {doc}`03_wraps` showed how many pixels must be pooled before these two
# frequencies tell a wrap. This page asks what other frequencies within the same reach would have
# needed: by theory, by a search over all sets on a grid, and by counting simulated pixels.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of all noise
step: float = 1e6  # drives on the grid lie so far apart, for two and three frequencies, Hz
step_four: float = 2e6  # the same for four frequencies, Hz
draws: int = 2000  # simulated pixels behind each dot
dots: int = 6  # dots on each curve
drives: int = 40  # drive amplitudes on the axis of the last figure

# %%
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from matplotlib.colors import LogNorm
from myst_nb import glue
from scipy.optimize import bisect

from cmtof import bounds
from cmtof.book import paper, plotting
from cmtof.constants import FREQUENCIES, GAIN, INTEGRATION_TIME, NOISE_SIGMA
from cmtof.correlation import depth_from_phase, wrap_length
from cmtof.frequency_choice import (
    best_choices,
    budget_factor,
    counted_odds,
    feasible_frequencies,
    odds_bounds,
    pixels_needed,
    relative_signal,
)

paper_run = plotting.begin(profile=profile, seed=seed)
colour = plotting.PALETTE
grey = "#8A97A3"
reaches = tuple(float(z) for z in (1.5, wrap_length(40e6), wrap_length(20e6)))  # m


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, value if isinstance(value, str) else float(value), display=False)


def name_of(frequencies):
    return " / ".join(f"{f / 1e9:.6g}" for f in frequencies)


def pixels_text(pixels):
    return f"{pixels:,.0f}".replace(",", " ") if np.isfinite(pixels) else "never"


# %% [markdown]
# ## Two frequencies
#
# A pair beats at Δ = |f₂ − k f₁|, with k the nearest whole ratio. {eq}`wraps-noise` gives the noise
# of its wrap count, σₙ ∝ 1/Δ, and pixels are pooled until 95 % of the counts come out right: their
# number falls as 1/Δ². The beat repeats after c/2Δ. So **range is paid for with pixels, squared**,
# and the band sets the end: Δ can reach 20 MHz between two tones of the single mode, and 40 MHz
# between the single and the doubled.
#
# Throughout, one pixel is white and has the paper's noise. Where nothing else is said, all
# frequencies have the same phase noise, as the paper simulates them.

# %%
f1, f2 = FREQUENCIES
signal = GAIN * INTEGRATION_TIME
white = float(bounds.simulated_phase_noise(1.0))
eta = np.pi / 4  # drive of full contrast in the single mode, rad
megahertz = float(wrap_length(1e6))  # range of a beat of 1 MHz, m
weak = float(relative_signal([f2], eta=eta)[0])
pairs = {
    "phasor": (7.15e9, 7.16e9),
    "paper": FREQUENCIES,
    "single": (7.14e9, 7.16e9),
    "wide": (7.14e9, 14.32e9),
}
pair_pixels = {
    key: bounds.pixels_needed(white, white, frequencies=pair) for key, pair in pairs.items()
}
pair_range = {
    key: float(wrap_length(abs(high - round(high / low) * low)))
    for key, (low, high) in pairs.items()
}
for key, pair in pairs.items():
    print(f"{name_of(pair):>14} GHz: {pair_range[key]:6.3f} m, {pair_pixels[key]:5d} pixels")
tell(
    weak=weak,
    paper_pixels=pair_pixels["paper"],
    phasor_pixels=pair_pixels["phasor"],
    single_pixels=pair_pixels["single"],
    wide_pixels=pair_pixels["wide"],
    wide_range=pair_range["wide"],
    paper_range=pair_range["paper"],
    phasor_range=pair_range["phasor"],
    single_factor=pair_pixels["paper"] / pair_pixels["single"],
    wide_factor=pair_pixels["paper"] / pair_pixels["wide"],
)

# %% [markdown]
# A required range adds arithmetic to the physics. Beyond c/2Δ the beat repeats, but not always at
# the same place: if f₁/Δ is a whole number, the wraps of the second turn coincide with those of the
# first and nothing tells them apart; if it is a half, they fall *between* them, at half the
# distance. The maps below count every rival wrap within the range.

# %%
detuning = np.arange(-10e6, 10e6 + 1, step)
singles, drives_of = np.meshgrid(f1 + detuning, 7.15e9 + detuning)
grid = np.stack([singles, 2 * drives_of])
maps = {z: pixels_needed(grid, white, depth_range=z)[1] for z in reaches[1:]}
tell(wide_far=float(pixels_needed(pairs["wide"], white, depth_range=reaches[2])[1]))

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 3, figsize=(12.4, 4.3), width_ratios=[1.25, 1, 1])
ax, beats = axes[0], np.geomspace(4e6, 60e6, 60)
curves = [
    ("two single tones", 1, 20e6, 1.0, colour["blue"], "-"),
    ("single and doubled, equal noise", 2, 40e6, 1.0, colour["vermillion"], "-"),
    (f"the same, doubled signal {weak:.2f}", 2, 40e6, weak, colour["vermillion"], "--"),
]
for label, k, most, strength, shade, dash in curves:
    needed = np.array([
        bounds.pixels_needed(white, white / strength, frequencies=(f1, k * f1 + beat))
        for beat in beats
    ])  # fmt: skip
    ax.plot(beats[beats <= most] / 1e6, needed[beats <= most], color=shade, ls=dash, label=label)
    ax.plot(beats[beats >= most] / 1e6, needed[beats >= most], color=shade, ls=":", lw=0.9)
# where each label has room: offset in points, and its side
places = {
    "phasor": (-7, -13, "right"),
    "paper": (9, -2, "left"),
    "single": (-7, -13, "right"),
    "wide": (7, 4, "left"),
}
for key, pair in pairs.items():
    beat = megahertz / pair_range[key]
    ax.plot(beat, pair_pixels[key], "D", ms=6, mfc="white", mec=colour["black"])
    across, up, side = places[key]
    ax.annotate(name_of(pair).replace(" ", ""), (beat, pair_pixels[key]), (across, up),
                textcoords="offset points", fontsize="small", ha=side)  # fmt: skip
ax.set(xscale="log", yscale="log", xlabel="beat Δ (MHz)", ylabel="pixels for 95 %", ylim=(180, 4e6))
ax.set(xlim=(3.6, 110))
ax.set_xticks([5, 10, 20, 40], ["5", "10", "20", "40"])
ax.minorticks_off()
ax.legend(loc="upper right", fontsize="small")
top = ax.secondary_xaxis("top", functions=(lambda b: megahertz / np.maximum(b, 1e-9),) * 2)
top.set_xticks([30, 15, 7.5, 3.75], ["30", "15", "7.5", "3.75"])
top.set_xlabel("range c/2Δ (m)", fontsize="small")
top.minorticks_off()
edge = detuning[[0, -1]] / 1e6 + np.array([-0.5, 0.5]) * step / 1e6
colours = plt.get_cmap(plotting.DEPTH_CMAP).with_extremes(bad=plotting.INVALID_COLOUR)
for ax, (z, needed) in zip(axes[1:], maps.items(), strict=True):
    drawn = ax.imshow(
        np.where(np.isfinite(needed), needed, np.nan),
        origin="lower", extent=(*edge, *edge), cmap=colours, norm=LogNorm(1e3, 1e6),
    )  # fmt: skip
    ax.plot(0, 10, "D", ms=6, mfc="white", mec=colour["black"], clip_on=False)
    ax.set(title=f"{z:.2f} m", xlabel="single tone − 7.15 GHz (MHz)")
    ax.set(xticks=[-10, -5, 0, 5, 10], yticks=[-10, -5, 0, 5, 10])
    ax.grid(visible=False)
axes[1].set_ylabel("drive of the doubled − 7.15 GHz (MHz)")
figure.colorbar(drawn, ax=axes[1:], label="pixels for 95 %", extend="max", shrink=0.8)
plotting.label_panels(axes)
finite = {f"{z:.2f}": float(needed.min()) for z, needed in maps.items()}
plotting.save(
    figure,
    "frequencies_pairs",
    numbers={"pixels": pair_pixels, "range_m": pair_range, "best_of_map": finite},
    caption=(
        "Pixels to pool for 95 % right wraps, white and at the paper's noise, by theory. (a) "
        "Against the beat of a pair, each at its own range c/2Δ; dotted beyond the modulators' "
        "reach. (b, c) For one tone of each mode at equal noise, when a range of 3.75 m and of "
        "7.49 m is required; grey: two wraps cannot be told apart. Diamonds: in (a) the pairs "
        "named, in (b, c) the paper's."
    ),
    alt=(
        "Left, straight falling lines of pixels over beat on logarithmic scales: from "
        f"{pair_pixels['phasor']} for phasor imaging to {pair_pixels['wide']} at 40 megahertz; "
        "the line for a weak doubled mode lies six times higher. Right, two maps: on the diagonal "
        "of equal drives the pixels run to infinity, towards the two far corners they fall; in "
        "the second map single cells and lines stand out grey."
    ),
)

# %% [markdown]
# At its own range of {glue:text}`paper_range:.2f` m the paper's pair needs
# {glue:text}`paper_pixels:.0f` pixels. The two ends of the single mode, 7.14 and 7.16 GHz, have the
# same range and need {glue:text}`single_pixels:.0f`, {glue:text}`single_factor:.1f` times fewer:
# their beat does not double the noise of a phase. The phasor baseline of the paper needs
# {glue:text}`phasor_pixels:.0f` for {glue:text}`phasor_range:.0f` m
# ({ref}`erratum 22 <erratum-22>`).
# 7.14 and 14.32 GHz need {glue:text}`wide_pixels:.0f` within {glue:text}`wide_range:.2f` m,
# {glue:text}`wide_factor:.1f` times fewer than the paper's pair, and cost nothing where the range
# is wanted after all: f₁/Δ is 178.5, a half, and over {glue:text}`paper_range:.2f` m they need
# {glue:text}`wide_far:.0f`. For the pair 7.16 and 14.28 GHz it is 179, and there they never can.
#
# ## More than two
#
# For any set of frequencies there is one question: how far apart do two wraps look? If the guess is
# off by d wraps, the phases leave residuals $\rho_i(d)=2\pi d f_i/f_1$, wrapped to ±π; a small
# shift of the depth absorbs a part of them. The rest, in units of the noise, is the distance
#
# ```{math}
# :label: frequencies-distance
# D^2(d)=\sum_i\frac{\rho_i^2}{\sigma_i^2}
#        -\frac{\bigl(\sum_i f_i\rho_i/\sigma_i^2\bigr)^2}{\sum_i f_i^2/\sigma_i^2},
# ```
#
# and the wrong one is preferred with probability $Q(D/2)$, the tail of the normal law. For a pair,
# $D(1)=1/\sigma_n$. The odds of an error are at most the sum over all rivals within the range and
# at least the largest of them. Where they are small the two nearly agree, so that theory says how
# many pixels are *enough*; pooling P pixels multiplies D by √P.
#
# The search tries every set on a grid of drives ({glue:text}`step:.0f` MHz apart, for four
# frequencies {glue:text}`step_four:.0f` MHz), with at least one tone of the single mode, so that
# a wrap is 21 mm for all of them. Three cases:
#
# - **equal**: the paper's simulation, the same noise everywhere;
# - **doubled mode weak**: the instrument's correlation signal at 14.32 GHz is
#   $(J_2(2\eta)/J_1(2\eta))^2$ of that at 7.15 GHz ({doc}`04_modulator`),
#   {glue:text}`weak:.2f` at η = π/4, and its phase noise that much larger;
# - **and resonant**: in addition ±10 MHz is taken as where the drive's *power* has halved, by one
#   resonance. That is our reading; the paper does not say what its bandwidth means.


# %%
def noise_equal(frequencies):
    return np.full(np.shape(frequencies), white)


def noise_weak(frequencies):
    return white / relative_signal(frequencies, eta=eta)


def noise_resonant(frequencies):
    return white / relative_signal(frequencies, eta=eta, half_power=10e6)


cases = {
    "equal": noise_equal,
    "doubled mode weak": noise_weak,
    "and resonant": noise_resonant,
}


def enough(frequencies, case, depth_range):
    f = np.asarray(frequencies)
    return float(pixels_needed(f, cases[case](f), depth_range=depth_range)[1])


# %%
best = {}
for case, noise in cases.items():
    for z in reaches:
        for size in (2, 3, 4):
            tones = feasible_frequencies(step_four if size == 4 else step)
            found = best_choices(tones, noise(tones), size=size, depth_range=z)
            best[case, z, size] = found[0]
            print(f"{case:>18}, {z:.2f} m: {name_of(found[0].frequencies)}: {found[0].enough:.0f}")

# %%
rows = ["| noise | range | two | three | four |", "|---|---|---|---|---|"]
for case in cases:
    for z in reaches:
        cells = (
            f"{name_of(best[case, z, n].frequencies)}: **{pixels_text(best[case, z, n].enough)}**"
            for n in (2, 3, 4)
        )
        rows.append(f"| {case} | {z:.2f} m | " + " | ".join(cells) + " |")
glue("search_table", Markdown("\n".join(rows)), display=False)

# %% [markdown]
# The best sets in GHz, and the pixels for 95 % right wraps, each image exposed as long as the
# paper's (so that three frequencies take half as long again):
#
# ```{glue:md} search_table
# :format: myst
# ```
#
# At equal noise a third frequency is worth much: over {glue:text}`paper_range:.2f` m it needs
# {glue:text}`third_over_two:.1f` times fewer pixels than the best two. The best three are two ends
# of the doubled mode and one tone of the single: the two high tones beat with one another, and the
# low one, whose noise a pair has to double, only tells which of two 10.5 mm wraps it is. Where the
# doubled mode is weak it is not used at all: all tones sit at the ends of the single mode or next
# to them.
#
# ## The same light for all
#
# A third image costs time. If F frequencies must share the time of two, each gets 2/F of it. How
# much noise that adds depends on the noise. **Photon noise**: the variance of a phase grows as F/2.
# **Gaussian noise of fixed σ in each image**, like read noise: the signal falls and σ stays, so the
# variance grows as (F/2)². Pixels grow as the variance. The split is an even one.

# %%
shorter = signal * 2 / 3  # three images in the time of two
split = float(bounds.linear_phase_noise(shorter / np.pi, shorter / 2 + NOISE_SIGMA**2, 4) / white)
photon, gaussian = (budget_factor(3, gaussian=g) for g in (False, True))
print(
    f"variance of a phase, three for two: photon noise {photon:.2f}, Gaussian {gaussian:.2f}, "
    f"the paper's settings {split**2:.3f}"
)
z = reaches[2]
rows = [
    "| noise | frequencies (GHz) | more time | same time, photon noise | same time, Gaussian |",
    "|---|---|---|---|---|",
]
gains = {}
for case in cases:
    base = enough(FREQUENCIES, case, z)
    rows.append(f"| {case} | the paper's, {name_of(FREQUENCIES)} | {pixels_text(base)} | | |")
    for size in (2, 3, 4):
        choice = best[case, z, size]
        factors = (1.0, *(budget_factor(size, gaussian=g) for g in (False, True)))
        needed = [choice.enough * factor for factor in factors]
        gains[case, size] = [base / pixels for pixels in needed]
        cells = " | ".join(f"{pixels_text(p)} ({base / p:.1f}×)" for p in needed)
        rows.append(f"| {case} | {name_of(choice.frequencies)} | {cells} |")
glue("budget_table", Markdown("\n".join(rows)), display=False)


# %%
def uneven_gain(case):
    """Pixels of the paper's pair in equal times over those in the best, Gaussian noise.

    f2^2 s1^2 / t1^2 + f1^2 s2^2 / t2^2 with t1 + t2 = 2 is least at t_i as the cube roots.
    """
    low, high = cases[case](np.array(FREQUENCIES))
    parts = np.array([(f2 * low) ** 2, (f1 * high) ** 2])
    return float(parts.sum() / (np.cbrt(parts).sum() ** 3 / 4))


tell(uneven_equal=uneven_gain("equal"), uneven_weak=uneven_gain("doubled mode weak"))

# %%
tell(
    step=step / 1e6,
    step_four=step_four / 1e6,
    split=split**2,
    gaussian_three=gaussian,
    base_weak=enough(FREQUENCIES, "doubled mode weak", z),
    gain_pair=gains["equal", 2][0],
    third_over_two=best["equal", z, 2].enough / best["equal", z, 3].enough,
    gain_weak_three_photon=gains["doubled mode weak", 3][1],
    gain_weak_four_photon=gains["doubled mode weak", 4][1],
    gain_three=gains["equal", 3][0],
    gain_three_photon=gains["equal", 3][1],
    gain_three_gaussian=gains["equal", 3][2],
    gain_four_photon=gains["equal", 4][1],
    gain_four_gaussian=gains["equal", 4][2],
    gain_weak_pair=gains["doubled mode weak", 2][0],
    gain_weak_three_gaussian=gains["doubled mode weak", 3][2],
    gain_weak_four_gaussian=gains["doubled mode weak", 4][2],
    gain_resonant_pair=gains["and resonant", 2][0],
    three_name=name_of(best["equal", z, 3].frequencies),
    weak_name=name_of(best["doubled mode weak", z, 2].frequencies),
    three_pixels=best["equal", z, 3].enough,
)

# %% [markdown]
# Over {glue:text}`paper_range:.2f` m, with the gain over the paper's pair in brackets:
#
# ```{glue:md} budget_table
# :format: myst
# ```
#
# The paper's settings are of the second kind: with three images in the time of two the variance of
# a phase becomes {glue:text}`split:.3f` times as large, by Gaussian noise alone
# {glue:text}`gaussian_three:.3f`. The even split itself costs little: with the best split of its
# time between its two frequencies, the paper's pair would need {glue:text}`uneven_equal:.2f` times
# fewer pixels at equal noise and {glue:text}`uneven_weak:.2f` times fewer with the doubled mode
# weak (Gaussian noise).
#
# ## By counting
#
# Theory assumes small Gaussian noise and a search that makes no other mistakes. To see whether it
# holds, depths are drawn in {glue:text}`paper_range:.2f` m, each frequency gets a noisy phasor, as
# if P pixels of known relative depth had been averaged, and `likeliest_wrap` searches all wraps of
# the range for the likeliest. These pixels are simulated one by one; no scene is involved.

# %%
contest = {
    "phasor, 7.15/7.16": ((7.15e9, 7.16e9), "sky"),
    "paper, 7.15/14.32": (FREQUENCIES, "black"),
    "7.14/7.16": ((7.14e9, 7.16e9), "blue"),
    "7.14/7.16/14.32": ((7.14e9, 7.16e9, 14.32e9), "orange"),
    "7.14/7.15/7.16/14.32": ((7.14e9, 7.15e9, 7.16e9, 14.32e9), "purple"),
    "best three": (best["equal", z, 3].frequencies, "green"),
}
shown = ("equal", "doubled mode weak")
rng = np.random.default_rng(seed)
pooled = {
    "equal": np.geomspace(20, 10_000, dots),
    "doubled mode weak": np.geomspace(60, 30_000, dots),
}
# a little apart, so that dots of like sets do not hide one another
aside = dict(zip(contest, np.linspace(0.85, 1.15, len(contest)), strict=True))
counted = {
    (case, key): np.array([
        counted_odds(f, cases[case](f), depth_range=z, pixels=p, draws=draws, rng=rng)
        for p in pooled[case] * aside[key]
    ])
    for case in shown for key, (f, _) in contest.items()
}  # fmt: skip

# %%
inside, total = 0, 0
for (case, key), share in counted.items():
    f, at = contest[key][0], pooled[case] * aside[key]
    lower, upper = odds_bounds(f, cases[case](f), depth_range=z, pixels=at)
    inside += int(np.sum((share[:, 1] <= upper) & (share[:, 2] >= lower)))
    total += len(share)
print(f"{inside} of {total} intervals meet the theory's bounds")
tell(inside=inside, total=total)

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(11.6, 4.5), sharey=True)
dash = dict.fromkeys(contest, "-") | {"phasor, 7.15/7.16": "--"}
for ax, case in zip(axes, shown, strict=True):
    axis = np.geomspace(pooled[case][0] / 1.5, pooled[case][-1] * 1.5, 120)
    for key, (f, shade) in contest.items():
        lower, upper = odds_bounds(f, cases[case](f), depth_range=z, pixels=axis)
        near = lower > 0.5
        ax.plot(axis[near], 100 * lower[near], color=colour[shade], ls=":", lw=1.1)
        ax.plot(axis, 100 * upper, color=colour[shade], label=key, ls=dash[key])
        share, low, high = 100 * counted[case, key].T
        ax.errorbar(pooled[case] * aside[key], share, [share - low, high - share], fmt="o", ms=4,
                    color=colour[shade], capsize=2)  # fmt: skip
    ax.axhline(95, color=grey, lw=1, ls=":")
    ax.set(xscale="log", xlabel="pixels pooled", ylim=(0, 103), xlim=(axis[0], axis[-1]))
axes[0].set(ylabel="wrap right (%)", title="equal noise")
axes[1].set(title=f"doubled signal {weak:.2f} (η = π/4)")
axes[1].legend(
    loc="lower right", fontsize="small", title_fontsize="small",
    title=f"best three: {name_of(contest['best three'][0])}",
)  # fmt: skip
plotting.label_panels(axes)
plotting.save(
    figure,
    "frequencies_odds",
    numbers={
        "best_three_ghz": [f / 1e9 for f in contest["best three"][0]],
        **{f"{case}: {key}": share[:, 0] for (case, key), share in counted.items()},
    },
    caption=(
        f"Odds of the right wrap within {z:.2f} m against the pixels pooled, for white pixels at "
        "the paper's noise. Lines: the upper bound of theory, and dotted the lower one; dots: "
        "counted on simulated pixels, with 95 % intervals. (a) All frequencies with equal noise. "
        "(b) The doubled mode as weak as the instrument's."
    ),
    alt=(
        "Two panels of S-shaped curves over pixels on a logarithmic axis, with dots on them. Left, "
        "from the right: phasor imaging, the paper's pair, 7.14 with 7.16 gigahertz, the two sets "
        "that add 14.32, and far left the best three. Right, the paper's pair is last, far to the "
        "right, and the sets with 7.14 and 7.16 lie together in front."
    ),
)

# %% [markdown]
# {glue:text}`inside:.0f` of {glue:text}`total:.0f` counted intervals meet the bounds (of so many
# 95 % intervals a few should miss). Where the odds are good, the bounds close and the dots lie on
# them. In (b) the order is another one. That is a matter of the drive.

# %%
axis = np.linspace(0.2, 1.3, drives)
eta_curves = {
    key: np.array([
        float(pixels_needed(f, white / relative_signal(f, eta=e), depth_range=z)[1]) for e in axis
    ])
    for key, (f, _) in contest.items()
}  # fmt: skip
strength = relative_signal([f2], eta=0.26)[0]
rival, three = enough(pairs["single"], "equal", z), contest["best three"][0]


def excess(drive):
    noise = white / relative_signal(three, eta=drive)
    return float(pixels_needed(three, noise, depth_range=z)[1]) - rival


cross = float(bisect(excess, axis[0], axis[-1], xtol=1e-3))
level = float(relative_signal([f2], eta=cross)[0])
print(f"the best three lead from η = {cross:.2f}, doubled signal {level:.2f}")
tell(cross=cross, cross_level=level, faint=strength)

# %% tags=["hide-input"]
figure, ax = plt.subplots(figsize=(7.4, 4.2))
for key, (_, shade) in contest.items():
    ax.plot(axis, eta_curves[key], color=colour[shade], label=key)
for place, text in ((0.26, "η = 0.26"), (np.pi / 4, "η = π/4")):
    ax.axvline(place, color=grey, lw=1, ls=":")
    ax.annotate(text, (place, 0), (4, 6), xycoords=("data", "axes fraction"),
                textcoords="offset points", fontsize="small", color="#5A646D")  # fmt: skip
ax.set(yscale="log", xlabel="drive η (rad)", ylabel="pixels for 95 %", ylim=(200, 1e6),
       xlim=(axis[0], axis[-1]))  # fmt: skip
top = ax.secondary_xaxis("top")
ticks = np.array([0.26, 0.5, np.pi / 4, 1.0, 1.25])
labels = [f"{relative_signal([f2], eta=e)[0]:.2f}" for e in ticks]
top.set_xticks(ticks, labels)
top.set_xlabel("signal of the doubled mode over the single", fontsize="small")
ax.legend(loc="upper right", bbox_to_anchor=(1.0, 0.93), fontsize="small")
plotting.save(
    figure,
    "frequencies_drive",
    numbers={"cross_eta": cross, "signal_0.26": strength, "signal_quarter": weak},
    caption=(
        f"Pixels for 95 % within {z:.2f} m when the doubled mode has the signal that the drive "
        "gives it, by theory. The noise of the single mode is held at the paper's 0.134 rad; the "
        "drive changes that too, for all sets alike."
    ),
    alt=(
        "Curves of pixels over the drive. The sets of single tones are level lines. The paper's "
        "pair falls from far above them and never reaches the line of 7.14 and 7.16; the best "
        f"three fall too and cross it at about {cross:.2f} radians. The sets that hold 7.14 and "
        "7.16 besides 14.32 run along that line and sink a little below it at the right."
    ),
)

# %% [markdown]
# At η = 0.26 the doubled mode has {glue:text}`faint:.3f` of the single mode's signal, and any set
# that leans on it is lost. The best three for equal noise lead only from
# η ≈ {glue:text}`cross:.2f` on, where the doubled signal is {glue:text}`cross_level:.2f`.
#
# ## The candidates side by side
#
# What a pair of single tones gives up is precision *within* the wrap: there the higher frequency
# counts, with the noise that it has.

# %%
candidates = [
    *contest.values(), (pairs["wide"], ""), ((7.16e9, 14.28e9), ""),
    ((7.14e9, 7.16e9, 14.30e9), ""),
]  # fmt: skip
columns = [*(("equal", r) for r in reaches), ("doubled mode weak", z)]
rows = [
    "| frequencies (GHz) | " + " | ".join(f"{c}, {r:.2f} m" for c, r in columns)
    + " | depth noise, equal (mm) | weak (mm) |",
    "|---" * (len(columns) + 3) + "|",
]  # fmt: skip


def depth_noise(frequencies, case):
    f = np.asarray(frequencies)
    return 1e3 * float(depth_from_phase(1.0, np.sqrt(np.sum((f / cases[case](f)) ** 2))))


for f, _ in sorted(candidates, key=lambda c: (len(c[0]), c[0])):
    cells = " | ".join(pixels_text(enough(f, case, r)) for case, r in columns)
    noise = " | ".join(f"{depth_noise(f, case):.2f}" for case in shown)
    rows.append(f"| {name_of(f)} | {cells} | {noise} |")
glue("candidates_table", Markdown("\n".join(rows)), display=False)
tell(
    offset_paper=0.01 / (2 * np.pi) * f1 / 20e6,
    offset_wide=0.01 / (2 * np.pi) * 7.14e9 / 40e6,
    depth_paper=depth_noise(FREQUENCIES, "equal"),
    depth_single=depth_noise(pairs["single"], "equal"),
    depth_paper_weak=depth_noise(FREQUENCIES, "doubled mode weak"),
    depth_single_weak=depth_noise(pairs["single"], "doubled mode weak"),
)

# %% [markdown]
# Pixels that are enough for 95 % by theory, and the depth noise of one white pixel whose wrap is
# known:
#
# ```{glue:md} candidates_table
# :format: myst
# ```
#
# 7.14 with 7.16 GHz has a depth noise of {glue:text}`depth_single:.2f` mm where the paper's pair
# has {glue:text}`depth_paper:.2f` mm at equal noise; with the doubled mode as weak as at η = π/4 it
# is {glue:text}`depth_single_weak:.2f` against {glue:text}`depth_paper_weak:.2f` mm.
#
# ## What a better choice would have bought
#
# Over the paper's own {glue:text}`paper_range:.2f` m, in pixels that need not be pooled:
#
# - **As simulated in the paper**, equal noise: {glue:text}`gain_pair:.1f` times fewer with two
#   other frequencies; with three, {glue:text}`three_name` GHz, {glue:text}`gain_three:.1f` times
#   fewer for half as much time again, and {glue:text}`gain_three_photon:.1f` (photon noise) or
#   {glue:text}`gain_three_gaussian:.1f` times (Gaussian) in the same time. A fourth, in the same
#   time, gives {glue:text}`gain_four_photon:.1f` or {glue:text}`gain_four_gaussian:.1f`.
# - **With the instrument's weak doubled mode** (η = π/4) the paper's pair needs
#   {glue:text}`base_weak:.0f` pixels, and {glue:text}`weak_name` GHz
#   {glue:text}`gain_weak_pair:.1f` times fewer. In the same time, three bring
#   {glue:text}`gain_weak_three_photon:.1f` (photon noise) or
#   {glue:text}`gain_weak_three_gaussian:.1f` times (Gaussian), four
#   {glue:text}`gain_weak_four_photon:.1f` or {glue:text}`gain_weak_four_gaussian:.1f`: less than
#   two.
# - **If the band's ends have only half of the drive's power**, {glue:text}`gain_resonant_pair:.1f`
#   times fewer, for the paper's doubled tone stands at such an end too.
#
# None of them makes one pixel enough: even the best three need {glue:text}`three_pixels:.0f` white
# pixels whose relative depth is known. Other frequencies shrink the surface that has to be pooled;
# pooling remains the task. Nor do they spare calibration: 0.01 rad between the phases of a pair,
# on the higher one, moves all its counts by {glue:text}`offset_paper:.2f` wraps at the paper's
# frequencies and by {glue:text}`offset_wide:.2f` at 7.14 and 14.32 GHz, however many pixels are
# pooled, and each further frequency brings an offset of its own.

# %%
paper.check("sec8.frequency_low", f1)
paper.check("sec8.frequency_high", f2)
paper.check("sec8.phasor_frequency_low", pairs["phasor"][0])
paper.check("sec8.phasor_frequency_high", pairs["phasor"][1])
paper.check("sec5.bandwidth_half", float(np.ptp(feasible_frequencies(10e6)[:3])) / 2)
