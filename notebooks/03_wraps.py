# %% [markdown]
# # Wraps
#
# At 100 MHz the phase wraps every 1.5 m, at 7.15 GHz every 21 mm (Paper Fig. 4, simulated). Do two
# frequencies show how often it has wrapped?
#
# A wrong count moves a point by 21 mm or more, so depth is only as good as the count. The rest of
# the book looks for pixels that belong together.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of all noise
frame_name: str = "still_life"  # embedded frame
column: int = 300  # image column along which wraps are counted, px
odds_side: int = 1024  # side of the flat targets on which odds are counted, px
flat_depth: float = 3.7  # their range, m

# %% tags=["hide-input"]
import matplotlib.pyplot as plt
import numpy as np

import cmtof
from cmtof import bounds
from cmtof.classical.beat import beat_depth, beat_phasor
from cmtof.constants import FREQUENCIES
from cmtof.correlation import (
    TAU,
    consistent_wrap_count,
    phase_from_depth,
    wrap_count_from_depth,
    wrap_length,
)
from cmtof.measurement import unambiguous_range
from cmtof.scenes import Frame
from cmtof_book import live, notes, paper, plotting
from cmtof_book.compared import closed_form, sum_over_draws

plotting.begin(profile=profile, seed=seed)
frame = cmtof.load_frame(frame_name)
f1, f2 = FREQUENCIES

# %%
tones = {1e8: "100 MHz", f1: "7.15 GHz", f2: "14.32 GHz"}
measured = cmtof.simulate(frame, protocol="full", frequencies=list(tones), seed=seed)
line = frame.depth[:, column].astype(float)
counts = {f: wrap_count_from_depth(line, f) for f in tones}
crossed = {f: int(np.ptp(n)) for f, n in counts.items()}
for f, name in tones.items():
    print(f"{name:>9}: {1e3 * wrap_length(f):7.1f} mm a wrap, {crossed[f]} on the line")

# %% tags=["hide-input"]
figure = plt.figure(figsize=(8.4, 5.2))
above, below = figure.subfigures(2, 1)
maps = above.subplots(1, 3)
look = {"label": "", "cmap": plotting.PHASE_CMAP, "limits": plotting.TURN, "bar": False}
for ax, phase, name in zip(maps, measured.phase, tones.values(), strict=True):
    drawn = plotting.image(ax, phase, title=name, **look)
    ax.axvline(column, color="white", lw=2.4)
    ax.axvline(column, color="black", lw=1.0)
plotting.colour_bar(drawn, ax=maps, label="phase (rad)")
left, right = below.subplots(1, 2)
left.plot(measured.phase[1][:, column], ".", ms=4)
left.set(ylim=(0, TAU), title="phase along the line, 7.15 GHz", ylabel="phase (rad)")
left.set_yticks([0, np.pi, TAU], ["0", "π", "2π"])
for f, name in tones.items():
    right.plot(counts[f], drawstyle="steps-mid", label=f"{name}: crosses {crossed[f]}")
right.set(ylim=(-5, 240), title="wraps along it", ylabel="wrap count n")
right.legend(fontsize="small")
for ax in (left, right):
    ax.set_xlabel("row of the image, wall to table (px)")
plotting.label_panels([*maps, left, right])
plotting.save(
    figure,
    "fig04_wraps",
    format="png",
    caption=f"The embedded frame `{frame_name}` at 100 MHz, 7.15 GHz and 14.32 GHz, simulated with "
    "the paper's noise (the paper shows another scene). (a–c) Measured wrapped phase. Along the "
    "line: (d) the measured phase at 7.15 GHz and (e) the true wrap count at each frequency.",
    alt="Top, phase images of a table with vase, bust and books before a wall: one smooth gradient "
    "at 100 megahertz, dozens of narrow rings at 7.15 gigahertz, twice as many at 14.32. Below, "
    "saw teeth of the phase along a column, and three staircases of the wrap count.",
)

# %% [markdown]
# **The number of wraps depends on the scene**: it is the span of depth over $c/2f$. The paper
# counts 1 and 35 wraps in its scene, whose depth is not published.
#
# ## Two frequencies
#
# The **beat** $\varphi_2-2\varphi_1$ is a phase at $f_2-2f_1 = 20$ MHz, unambiguous over 7.5 m. One
# wrap of 21 mm changes it very little, and the subtraction *adds* the noise of both phases. In
# wraps, with σ₁ and σ₂ the phase noise and Δ = |f₂ − 2f₁|,
#
# $$
# \sigma_n = \frac{\sqrt{f_1^2\sigma_2^2+f_2^2\sigma_1^2}}{2\pi\,\Delta},\qquad
# P(\text{correct}) \approx \mathrm{erf}\frac{1}{2\sqrt2\,\sigma_n} .
# \tag{3.1}$$

# %%
beat_range = unambiguous_range(FREQUENCIES)
beat_wraps = beat_range / wrap_length(f1)
white = bounds.simulated_phase_noise(1.0)
wrap_spread = bounds.wrap_noise(white, white, frequencies=FREQUENCIES)
step = 1e3 * phase_from_depth(wrap_length(f1), f2 - 2 * f1)
print(
    f"range {beat_range:.3f} m, {beat_wraps:.1f} wraps of {step:.1f} mrad of beat each"
)
print(
    f"at full brightness the count of one pixel has a standard deviation of {wrap_spread:.1f}"
)

# %% [markdown]
# A simulation tests the formula: on flat targets of one brightness the right wraps are counted
# (those *consistent* with the measured phase). For dark pixels `wrap_probability_law` takes the
# [exact law](02_precision.ipynb) of the phase.


# %% tags=["hide-input"]
def flat(brightness):
    shape = (odds_side, odds_side)
    target = Frame(np.full(shape, flat_depth), np.full(shape, brightness))
    return cmtof.simulate(target, protocol="full", seed=seed)


def share_right(phase, beat_phase, measurement):
    found = beat_depth(beat_phase, measurement)
    right = consistent_wrap_count(flat_depth, phase, f1)
    return np.mean(consistent_wrap_count(found, phase, f1) == right)


brightness = np.array([1.0, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05])
noise = bounds.simulated_phase_noise(brightness)
formula = bounds.wrap_probability(noise, noise, frequencies=FREQUENCIES)
law = np.array(
    [bounds.wrap_probability_law(s, s, frequencies=FREQUENCIES) for s in noise]
)
targets = {value: flat(value) for value in brightness}
counted = np.array(
    [share_right(t.phase[0], np.angle(beat_phasor(t)), t) for t in targets.values()]
)
error = np.sqrt(law * (1 - law)) / odds_side

# %% [markdown]
# Pixels must be pooled. One can average the *beats* of neighbours, which are products of noisy
# phasors. Or one averages the correlations first, so that each frequency's phasor is clean *before*
# the beat is taken.

# %% tags=["hide-input"]
sides = np.array([1, 4, 8, 16, 24, 32, 48, 64])


def blocks(images, side):
    """Mean of squares of side x side pixels."""
    rows, columns = (n // side * side for n in images.shape[-2:])
    shape = (*images.shape[:-2], rows // side, side, columns // side, side)
    return images[..., :rows, :columns].reshape(shape).mean(axis=(-3, -1))


pooled = {}
for level in (1.0, 0.3):
    target = targets[level]
    phasors = target.amplitude * np.exp(1j * target.phase)
    product = beat_phasor(target)
    for side in sides:
        low, high = blocks(phasors, side)
        own = np.mod(np.angle(low), TAU)
        pooled[level, side] = (
            share_right(own, np.angle(high * np.conj(low) ** 2), target),
            share_right(own, np.angle(blocks(product, side)), target),
        )
pool_noise = {level: bounds.simulated_phase_noise(level) for level in (1.0, 0.3)}
need = {
    v: bounds.pixels_needed(s, s, frequencies=FREQUENCIES)
    for v, s in pool_noise.items()
}

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(8.4, 4.1))
names = {"label": "counted", "bound_label": "exact law", "color": "C1"}
plotting.sweep(
    axes[0],
    brightness,
    100 * counted,
    errors=200 * error,
    bound=(brightness, 100 * law),
    **names,
)
axes[0].plot(
    brightness, 100 * formula, color=plotting.GREY, ls="--", label="small-noise formula"
)
plotting.mark(axes[0], y=100 / beat_wraps, text="chance")
axes[0].set(
    xlabel="brightness I", ylabel="wrap right (%)", title="one pixel", xmargin=0.2
)
side_axis = np.geomspace(1, 330, 200)
for level, colour in ((1.0, "C0"), (0.3, "C4")):
    spread = pool_noise[level] / side_axis
    theory = 100 * bounds.wrap_probability(spread, spread, frequencies=FREQUENCIES)
    by_phasor, by_beat = (
        100 * np.array([pooled[level, s][k] for s in sides]) for k in (0, 1)
    )
    names = {"bound_label": f"I = {level:g}, formula", "color": colour, "log": "x"}
    plotting.sweep(axes[1], sides, by_phasor, bound=(side_axis, theory), **names)
    axes[1].plot(sides, by_beat, "x", color=colour, mew=2)
    axes[1].plot(np.sqrt(need[level]), 95, "D", mfc="white", mec=colour, ms=7)
axes[1].plot([], [], "ko", ms=4.5, label="phasors pooled")
axes[1].plot([], [], "kx", mew=2, label="beats pooled")
plotting.mark(axes[1], y=95, text="95 %")
axes[1].set(
    xlabel="side of the pooled square (px)", ylabel="wrap right (%)", title="pooled"
)
for ax, place in zip(axes, ("upper left", "center left"), strict=True):
    ax.legend(fontsize="small", loc=place)
plotting.label_panels(axes)

# %% tags=["hide-input"]
plotting.save(
    figure,
    "wraps_odds",
    numbers={
        "formula": closed_form(formula),
        "law": closed_form(law),
        "counted": sum_over_draws(counted, error=error),
        "pixels_needed": closed_form(list(need.values())),
    },
    caption="Odds of the right wrap at the paper's noise, in 7.5 m, simulated. (a) One pixel: "
    "formula, exact law, and counts on flat targets (bars: two standard errors). (b) Squares of "
    "pixels whose relative depth is known; diamonds: the pixels that 95 % need. Pooling each "
    "frequency's phasors first follows the formula; pooling beats is worse on dark targets.",
    alt="Left, odds over brightness on logarithmic scales, from chance for dark pixels to two "
    "percent for white ones, points on the exact law. Right, odds over the side of the pooled "
    "square: S-shaped curves that reach 95 percent; dots lie on them, crosses of the "
    "darker target below.",
)

# %% tags=["hide-input"]
notes.say(
    """
    At I = 0.3 the count of one pixel is right in {odds_dark:.1f} %, where chance is {guess:.2f} %.
    In squares of 64 pooled phasors are then right in {big_phasor:.0f} %, pooled beats in
    {big_product:.0f} %. The sliders give the odds for other frequencies ($f_2 = 2f_1$ + 20 MHz)
    and other noise.
    """,
    odds_dark=100 * counted[3],
    guess=100 / beat_wraps,
    big_phasor=100 * pooled[0.3, 64][0],
    big_product=100 * pooled[0.3, 64][1],
)

# %% tags=["hide-input"]
live.show('<div data-play="odds"></div>')

# %% [markdown]
# Real surfaces are not flat: before the phasors of neighbours are added, their phases must be
# aligned, which requires knowledge of the surface. So unwrapping needs the very surface it seeks.

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** In principle, up to {range:.1f} m. At the paper's noise the count of one white pixel
    is right in {odds:.1f} % of cases; for 95 % it takes {white:,.0f} white pixels, or {dark:,.0f}
    of brightness 0.3.
    """,
    range=beat_range,
    odds=100 * counted[0],
    white=need[1.0],
    dark=need[0.3],
)

# %% [markdown]
# ## Against the paper

# %% tags=["hide-input"]
paper.check("fig4.wraps_low", crossed[1e8])
paper.check("fig4.wraps_high", crossed[f1])
paper.check("sec4.frequency_ratio", f1 / 1e8)
paper.table()

# %% [markdown]
# ## Exercises
#
# **1.** A third frequency of 7.25 GHz is added to 7.15 GHz. How many wraps has the range of their
# beat, and what is the spread of a white pixel's count?

# %% tags=["hide-cell"]
# The beat has 100 MHz and a range of 1.5 m, five times fewer wraps than that of 20 MHz, and by
# Eq. 3.1 with Δ = f₂ − f₁ a spread of 2.2 wraps instead of 17.
other = 7.25e9
spread = white * np.hypot(f1, other) / (TAU * (other - f1))
print(f"{wrap_length(other - f1) / wrap_length(f1):.1f} wraps, spread {spread:.2f}")

# %% [markdown]
# **2.** How many white pixels must be pooled for 99.9 %?

# %% tags=["hide-cell"]
# The spread is proportional to one over the root of the number of pixels; 99.9 % lie within 3.29
# spreads, which may be half a wrap.
print(f"{(2 * 3.2905 * wrap_spread) ** 2:,.0f} pixels")
