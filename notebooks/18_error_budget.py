# %% [markdown]
# # The error budget
#
# Fig. 13 and Table 4 of the paper state what came out: 33 µm over a sweep of 1 mm at 60 cm, ± 7.5
# µm. They do not state what it is made of. This page takes the *simulated* all-optical instrument
# ({doc}`13_instrument`), makes it perfect, and then lets one thing at a time go wrong. For nearly
# every error there is a closed form beside the simulation. No size was chosen with the paper's
# results in view; a later section asks what size each *would* need.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of days, noise, drift and errors of the drivers
days: int = 14  # days that each term is measured on
days_together: int = 60  # days for the whole
wrap_points: int = 64  # positions over a wrap in the cyclic figure

# %%
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from matplotlib.ticker import NullLocator
from myst_nb import glue

from cmtof.book import paper, plotting
from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import wrap_length
from cmtof.instrument.electronics import Conversion
from cmtof.instrument.settings import TwinSettings
from cmtof.ranging import cyclic
from cmtof.ranging.budget_forms import back_ratio, foretold, residual_ratio
from cmtof.ranging.budget_needs import (
    CABLE_DRIFT,
    CABLE_LENGTH,
    EXPANSION,
    offset_needs,
    scatter_needs,
)
from cmtof.ranging.budget_terms import MEASURED_AIR, TERMS, TOGETHER
from cmtof.ranging.error_budget import (
    AGE,
    VISITS,
    errors,
    over_a_wrap,
    ranger_of,
    rms,
    slope_errors,
    slope_scatter,
)
from cmtof.ranging.optical import FREQUENCY, OpticalRanger
from cmtof.ranging.sweep import offset_and_scatter, parts
from cmtof.ranging.target import StageTarget

run = plotting.begin(profile=profile, seed=seed)
known = TwinSettings()
MODES = ("single", "doubled")
COLOURS = {"single": plotting.PALETTE["blue"], "doubled": plotting.PALETTE["vermillion"]}
GREY = "#5A646D"


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, float(value), display=False)


def say(name, *sentences):
    glue(name, Markdown(" ".join(one for one in sentences if one)), display=False)


def table(name, head, rows):
    lines = ["| " + " | ".join(head) + " |", "| --- |" + " --: |" * (len(head) - 1)]
    glue(name, Markdown("\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])),
         display=False)  # fmt: skip


def decades(ax):
    """Logarithmic axis with plain numbers at the decades."""
    ax.set_xscale("log")
    ax.xaxis.set_major_formatter("{x:g}")
    ax.xaxis.set_minor_locator(NullLocator())


# %% [markdown]
# ## A day, and how its zero is found
#
# A day begins with a reference: the same target at {glue:text}`visits:.0f` known positions over one
# whole wrap. The mean of what is read there is the *zero*. {glue:text}`age:.0f` s later the sweep
# is taken, {glue:text}`positions:.0f` positions, one a second. What no data sheet can state is
# drawn anew each day: the phase of the inner path, of the cables, of a leak and of the
# back-reflection. An error $e_i$ is the estimated minus the true range, and it has three parts,
#
# ```{math}
# :label: eq-budget-parts
# e_i = \underbrace{\bar e}_{\text{offset}} + \underbrace{s\,(z_i-\bar z)}_{\text{scale}}
#       + \underbrace{\epsilon_i}_{\text{scatter}},\qquad
# \frac{\mathrm{MAE}}{\mathrm{RMSE}} =
# \begin{cases}1 & \text{offset alone}\\ \sqrt{2/\pi}=0.80 & \text{scatter alone.}\end{cases}
# ```
#
# A cyclic error is a function of the phase. It goes round once or more in a wrap, of
# {glue:text}`wrap_single:.1f` mm in the single and {glue:text}`wrap_doubled:.1f` mm in the doubled
# mode, and a sweep of 1 mm sees one part in {glue:text}`share:.0f` or
# {glue:text}`share_doubled:.0f` of it. So it turns up under offset and scale.

# %%
target = StageTarget()
mirror = StageTarget.mirror()
step = paper.published("sec8.sweep_step").value
travel = paper.published("sec8.sweep").value
positions = np.arange(round(travel / step) + 1) * step - travel / 2
wrap = {mode: float(wrap_length(FREQUENCY[mode])) for mode in MODES}
tell(visits=VISITS, age=AGE, positions=positions.size, wrap_single=1e3 * wrap["single"],
     wrap_doubled=1e3 * wrap["doubled"], share=wrap["single"] / travel,
     share_doubled=wrap["doubled"] / travel)  # fmt: skip

# %%
terms = {**TERMS, "together": TOGETHER}
measured = {
    (name, mode): errors(term, target, positions, mode=mode, seed=seed,
                         days=days_together if name == "together" else days)
    for mode in MODES for name, term in terms.items()
}  # fmt: skip
on_mirror = {
    mode: errors(TOGETHER, mirror, positions, mode=mode, days=days_together, seed=seed)
    for mode in MODES
}
zeroed = {key: parts(found.zeroed, positions) for key, found in measured.items()}
raw = {key: parts(found.raw, positions) for key, found in measured.items()}
forms = {(name, mode): foretold(name, target, mode=mode) for name in TERMS for mode in MODES}
floor = {mode: rms(zeroed["sixteen", mode].rmse) for mode in MODES}
bound = {
    (what.material, mode): float(ranger_of(known, mode, {}).bound(what, [0.0])[0])
    for what in (target, mirror) for mode in MODES
}  # fmt: skip
for mode in MODES:
    whole = zeroed["together", mode]
    print(f"{mode}: rms {1e6 * rms(whole.rmse):.1f} µm, scatter {1e6 * rms(whole.scatter):.1f} µm, "
          f"bound {1e6 * bound['diffuse', mode]:.1f} µm")  # fmt: skip

# %% [markdown]
# ## Each alone
#
# Three terms stay out of the whole. Two are choices, not flaws: four steps of the phase in place of
# sixteen, and air that is left out of the arithmetic. And the wave plates of the simulated
# instrument are in place; the line of the plates puts them where a mount and a hand might. The
# harmonics with sixteen steps are nothing; what that line shows is the converter's rounding, which
# stays in every run.

# %% tags=["hide-input"]
WORDS = ("offset", "scatter", "rmse")
APART = ("four", "air", "modulators")  # no part of the whole
TITLES = ("offset, the zero taken", "scatter", "rms, and closed form")
order = list(TERMS)
place = {name: len(order) - i for i, name in enumerate(order)} | {"together": -0.6}
figure, axes = plt.subplots(1, 3, figsize=(11.4, 7.6), sharey=True)
for ax, part, title in zip(axes, WORDS, TITLES, strict=True):
    for mode, shift in zip(MODES, (0.19, -0.19), strict=True):
        for name in terms:
            size = 1e6 * rms(getattr(zeroed[name, mode], part))
            ax.barh(place[name] + shift, size, 0.36, color=COLOURS[mode],
                    label=mode if name == "together" else None)  # fmt: skip
            form = forms.get((name, mode))
            if part == "rmse" and form is not None and 1e6 * form > 0.02:
                ax.plot(1e6 * form, place[name] + shift, "d", ms=5.5, mfc="white", mec="black",
                        mew=1.1, label="closed form" if (name, mode) == ("photons", "single")
                        else None)  # fmt: skip
        if part != "offset":
            ax.plot(2 * [1e6 * bound["diffuse", mode]], [-1.05, -0.15], color="black", lw=2.2,
                    label="Cramér–Rao bound" if mode == "single" else None)  # fmt: skip
    ax.axvline(33.5, color=GREY, lw=1, ls="--")
    ax.axhline(0.2, color=GREY, lw=0.8)
    decades(ax)
    ax.set(xlim=(0.02, 80), xlabel="µm, rms over the days", title=title)
    ax.grid(axis="y", visible=False)
axes[0].text(31, 15.5, "Table 4", rotation=90, ha="right", va="center", color=GREY, fontsize=9)
axes[0].set_yticks([place[n] for n in terms], [t.label for t in terms.values()])
axes[0].set_ylim(-1.2, len(order) + 0.7)
handles, labels = axes[2].get_legend_handles_labels()
figure.legend(handles, labels, loc="outside upper center", ncols=4)
plotting.label_panels(axes)
largest = {
    mode: max((n for n in TERMS if n not in APART),
              key=lambda n, mode=mode: rms(zeroed[n, mode].rmse))
    for mode in MODES
}  # fmt: skip
plotting.save(
    figure,
    "budget_terms",
    numbers={
        f"{name}_{mode}": [1e6 * rms(getattr(zeroed[name, mode], part)) for part in WORDS]
        for name in terms for mode in MODES
    } | {f"bound_{mode}": 1e6 * bound["diffuse", mode] for mode in MODES},
    caption=(
        "Error budget of the simulated instrument for a diffuse target at 60 cm, each term alone "
        "and all together: (a) offset over the sweep, after the zero was taken from a reference "
        "over a wrap, (b) scatter about a straight line, (c) rms error, with closed forms; where a "
        "diamond lies within its bar, the converter's rounding makes the rest. Dashed: 33.5 µm."
    ),
    alt=(
        f"Three panels of bars on a logarithmic scale, {len(order)} terms and their whole, in both "
        "modes. The largest term of the whole is "
        + " and ".join(f"{TERMS[largest[m]].label} in the {m} mode "
                       f"({1e6 * rms(zeroed[largest[m], m].rmse):.1f} µm rms)" for m in MODES)
        + f". Four steps alone make {1e6 * rms(zeroed['four', 'single'].rmse):.0f} µm in the "
        "single mode. All together make "
        + " and ".join(f"{1e6 * rms(zeroed['together', m].rmse):.1f}" for m in MODES)
        + " µm. White diamonds of the closed forms lie at the ends of all bars that stand out of "
        "the rounding."
    ),
)  # fmt: skip

# %% tags=["hide-input"]
in_the_whole = ("photons", "amplifier", "converter", "laser", "drift", "codes", "imbalance",
                "leakage", "back", "weather", "stage")  # fmt: skip
summed = {m: float(np.sqrt(sum(forms[n, m] ** 2 for n in in_the_whole))) for m in MODES}
whole_rms = {m: rms(zeroed["together", m].rmse) for m in MODES}
noise_share = {m: rms(zeroed["together", m].scatter) / bound["diffuse", m] for m in MODES}
gap = max(abs(summed[m] / whole_rms[m] - 1) for m in MODES)
say("sum_says",
    "Independent errors add up as squares: the closed forms of the terms give "
    f"{1e6 * summed['single']:.1f} and {1e6 * summed['doubled']:.1f} µm, the simulation of all at "
    f"once {1e6 * whole_rms['single']:.1f} and {1e6 * whole_rms['doubled']:.1f} µm.",
    f"They agree within {100 * gap:.0f} %." if gap < 0.2 else
    f"They differ by {100 * gap:.0f} %; the days are too few, or a term is missing.",
    "(The instrument has its wave plates in place; that line is not in this sum.)")  # fmt: skip
say("bound_says",
    f"Against the Cramér–Rao bound of {1e6 * bound['diffuse', 'single']:.1f} and "
    f"{1e6 * bound['diffuse', 'doubled']:.1f} µm the scatter is {noise_share['single']:.2f} and "
    f"{noise_share['doubled']:.2f} times as large.",
    f"The doubled mode, with twice the frequency, is no better here: at η = {known.drive.eta:.2f} "
    "its light and its contrast are both lower."
    if bound["diffuse", "doubled"] > bound["diffuse", "single"] else
    "The doubled mode gains from its frequency.")  # fmt: skip


def budget_rows(mode):
    rows = []
    for name, term in terms.items():
        some = zeroed[name, mode]
        wave = "–"
        if term.cyclic:
            turn = over_a_wrap(term, target, mode=mode, count=wrap_points, seed=seed)
            wave = f"{1e6 * np.sqrt(2) * rms(turn.error):.2f}"
        numbers = 1e6 * rms(some.offset), 1e3 * rms(some.slope), 1e6 * rms(some.scatter)
        offset, scale, scatter = (f"{number:.2f}" for number in numbers)
        rows.append([term.label, offset, scale, wave, scatter, f"{np.median(some.ratio):.2f}"])
    return rows


HEAD = ["", "offset", "scale", "cyclic", "scatter", "ratio"]
rows = {mode: budget_rows(mode) for mode in MODES}
for mode in MODES:
    table(f"table_{mode}", HEAD, rows[mode])
tell(ignored=1e6 * rms(raw["air", "single"].offset), rounding=1e6 * floor["single"],
     plates=1e6 * rms(zeroed["modulators", "doubled"].rmse),
     plates_left=100 * np.sqrt(residual_ratio()), turn_wraps=2,
     kelvin=MEASURED_AIR["temperature_error"], hecto=MEASURED_AIR["pressure_error"] / 100,
     weather=1e6 * forms["weather", "single"], drift_mrad=1e3 * known.drive.phase_drift,
     drift_um=1e6 * forms["drift", "single"])  # fmt: skip

# %% [markdown]
# ```{glue:md} sum_says
# :format: myst
# ```
#
# ```{glue:md} bound_says
# :format: myst
# ```
#
# The single mode, diffuse target; offset, cyclic amplitude and scatter in µm, scale in µm per mm,
# all rms over the days, and the median of MAE/RMSE:
#
# ```{glue:md} table_single
# :format: myst
# ```
#
# The doubled mode:
#
# ```{glue:md} table_doubled
# :format: myst
# ```
#
# Three lines want a word.
#
# **Air.** Left out, it is {glue:text}`ignored:.0f` µm of range, but the reference stood in the same
# air at the same range, and its zero takes all of that away. What remains is what changed since:
# {glue:text}`kelvin:.1f` K and {glue:text}`hecto:.0f` hPa make {glue:text}`weather:.2f` µm.
#
# **RF phase.** {glue:text}`drift_mrad:.0f` mrad rms of slow drift is {glue:text}`drift_um:.1f` µm,
# and as a 1/f drift has fast octaves too, it is offset and scatter at once.
#
# **Plates.** In the single mode wave plates and splitters off by a little cost no phase. In the
# doubled one they let {glue:text}`plates_left:.1f` % of the drive's own frequency through beside
# its double, and the table of phases spans only half a turn of that, so that it does not average
# out: {glue:text}`plates:.1f` µm. It also repeats only after {glue:text}`turn_wraps:.0f` wraps,
# so a reference over a single wrap cannot take it out.

# %% [markdown]
# ## Cyclic errors, over a whole wrap
#
# With $x=\phi+\psi$ a small change $a\,\epsilon_k$ of the readings $C_k=d+a\cos x_k$ turns the
# phase by
#
# ```{math}
# :label: eq-budget-first-order
# \delta\phi = -\frac2K\sum_k \epsilon_k\sin x_k ,
# ```
#
# and all closed forms but the first follow from it:
#
# - back-reflection of the power ratio $r$: $\arg(1+re^{i(\phi_b-\phi)})$, at most $\arcsin r$;
# - I/Q imbalance $\varepsilon$: $\tfrac\varepsilon2\sin2\phi$ in the single mode, nothing in the
#   doubled one;
# - third harmonic, four steps: $-(J_3/J_1)^2\sin4\phi$, nothing with sixteen;
# - drives that leak into each other: nothing in the single mode. In the doubled one the table spans
#   half a turn, and the sum of {eq}`eq-budget-first-order` does not vanish;
# - plates: $(J_1/J_2)^2\tan^2 8\delta$ of the drive's frequency, for a half-wave plate off by
#   $\delta$.

# %% tags=["hide-input"]
eta = known.drive.eta
PANELS = {
    ("back", "single"): ("back-reflection, single",
                         lambda t: cyclic.back_reflection(t.phase, t.stray, back_ratio(target))),
    ("imbalance", "single"): ("I/Q imbalance, single",
                              lambda t: cyclic.imbalance(t.phase, known.drive.iq_imbalance)),
    ("four", "single"): ("harmonics, 4 steps, single",
                         lambda t: cyclic.aliasing(t.phase, eta, steps=4)),
    ("back", "doubled"): ("back-reflection, doubled",
                          lambda t: cyclic.back_reflection(t.phase, t.stray, back_ratio(target))),
    ("leakage", "doubled"): ("RF leakage, doubled",
                             lambda t: cyclic.leakage(
                                 t.phase, np.full(t.phase.size, t.lag),
                                 known.drive.leakage * t.leak, eta, steps=16, mode="doubled")),
    ("modulators", "doubled"): ("plates, doubled",
                                lambda t: cyclic.residual_fundamental(
                                    t.phase, residual_ratio(), steps=16)),
}  # fmt: skip
figure, axes = plt.subplots(2, 3, figsize=(11.4, 5.8))
apart = {}
for ax, ((name, mode), (title, form)) in zip(axes.flat, PANELS.items(), strict=True):
    turn = over_a_wrap(TERMS[name], target, mode=mode, count=wrap_points, seed=seed)
    curve = form(turn) * SPEED_OF_LIGHT / (4 * np.pi * FREQUENCY[mode])
    curve = curve - curve.mean()
    ax.axvspan(-500 * travel, 500 * travel, color=plotting.PALETTE["yellow"], alpha=0.35, lw=0)
    ax.plot(1e3 * turn.positions, 1e6 * curve, color=COLOURS[mode])
    ax.plot(1e3 * turn.positions, 1e6 * turn.error, "o", ms=3, color="black", mfc="none")
    ax.set(title=title, xlim=(-500 * wrap[mode], 500 * wrap[mode]))
    reach = 1.2e6 * max(np.abs(turn.error).max(), np.abs(curve).max())
    ax.set_ylim(-reach, reach)
    # a quarter of the steps average a quarter of the rounding
    rounding = floor[mode] * (2 if name == "four" else 1)
    apart[name, mode] = rms(turn.error - curve) / rounding
for ax in axes[1]:
    ax.set_xlabel("position (mm)")
for ax in axes[:, 0]:
    ax.set_ylabel("error (µm)")
plotting.label_panels(axes.flat)
plotting.save(
    figure,
    "budget_cyclic",
    numbers={f"{name}_{mode}_over_floor": value for (name, mode), value in apart.items()},
    caption=(
        "Cyclic errors over one wrap on one day, each alone: circles simulated, lines closed form. "
        "The yellow band is the sweep of 1 mm. Mind the scales; what scatters is rounding by the "
        "converter."
    ),
    alt=(
        "Six panels of error against position. Circles lie on curves: one sine a wrap for the "
        "back-reflection, two for the I/Q imbalance, four for the third harmonic, one for the RF "
        "leakage, half a wave for the plates. A narrow band in the middle is 1 mm wide, and within "
        "it each curve is nearly a straight line."
    ),
)
worst = max(apart, key=lambda key: apart[key])
say("cyclic_says",
    f"What the closed forms leave is {min(apart.values()):.1f} to {max(apart.values()):.1f} times "
    "the rounding.",
    f"The most is left by the {TERMS[worst[0]].label}, an error of first order only."
    if apart[worst] > 1.5 else "")  # fmt: skip

# %% [markdown]
# ```{glue:md} cyclic_says
# :format: myst
# ```
#
# The band is the point of this figure. Whatever depends on the phase alone, however it came about,
# is nearly a constant over a millimetre.
#
# ## Which terms are nearly constant offsets?

# %% tags=["hide-input"]
published = {
    what: (paper.published(f"table4.proposed.rmse_{what}").value,
           paper.published(f"table4.proposed.mae_{what}").value)
    for what in ("mirror", "diffuse")
}  # fmt: skip
implied = {what: offset_and_scatter(*found)[1] for what, found in published.items()}
figure, axes = plt.subplots(1, 2, figsize=(11.2, 4.9), sharey=True)
WIDTH, LINE = 0.043, 0.019  # of a letter, decades, and of a line, in the figure below
shown = [n for n in terms if n not in ("sixteen", "converter", "stage", "thermometer", "spot")]
for ax, mode in zip(axes, MODES, strict=True):
    for low, words, beside in ((1, "every error the same", "bottom"),
                               (np.sqrt(2 / np.pi), "Gaussian about zero", "top")):  # fmt: skip
        ax.axhline(low, color=GREY, lw=0.9, ls=":")
        lower = beside == "top"
        ax.text(380 if lower else 0.13, low + 0.006 * (1 - 2 * lower), words, va=beside,
                ha="right" if lower else "left", color=GREY, fontsize=8.5)  # fmt: skip
    taken = [(mae / rmse, np.log10(1e6 * rmse) - 0.07, np.log10(1e6 * rmse) + 0.07)
             for rmse, mae in published.values()]  # fmt: skip
    for name in sorted(shown, key=lambda n, mode=mode: -np.median(zeroed[n, mode].ratio)):
        some = (raw if name == "air" else zeroed)[name, mode]
        size = 1e6 * rms(some.rmse)
        if size < 1.5e6 * floor[mode]:
            continue
        low, middle, high = np.percentile(some.ratio, [10, 50, 90])
        colour = "black" if name == "together" else COLOURS[mode]
        ax.plot([size, size], [low, high], color=colour, lw=0.8, zorder=3)
        ax.plot(size, middle, "o", ms=5.5, color=colour, zorder=5)
        # labels keep a line's height from those beside them
        label = terms[name].label + (" (no zero)" if name == "air" else "")
        left = np.log10(size) + (0.3 - WIDTH * len(label) if name == "air" else 0.06)
        right, y = left + WIDTH * len(label), middle + 0.014 * (name == "air")
        while any(abs(y - other) < LINE and left < ends[1] and right > ends[0]
                  for other, *ends in taken):  # fmt: skip
            y -= LINE / 4
        taken.append((y, left, right))
        ax.annotate(label, (size, middle), (10**left, y), textcoords="data", va="center",
                    fontsize=8.5, arrowprops={"arrowstyle": "-", "lw": 0.5, "color": GREY,
                                              "shrinkA": 1, "shrinkB": 3},
                    bbox={"fc": "white", "ec": "none", "pad": 0.6, "alpha": 0.75},
                    zorder=4)  # fmt: skip
    for what, (rmse, mae) in published.items():
        ax.plot(1e6 * rmse, mae / rmse, "*", ms=13, color=plotting.PALETTE["green"], zorder=6,
                label="Table 4, proposed" if what == "mirror" else None)  # fmt: skip
    decades(ax)
    ax.set(xlim=(0.12, 400), ylim=(0.72, 1.025), xlabel="rms error (µm)",
           title=f"{mode} mode")  # fmt: skip
axes[0].set_ylabel("MAE / RMSE")
axes[1].legend(loc="lower right", fontsize=9)
plotting.label_panels(axes)
ratios = {key: float(np.median(some.ratio)) for key, some in zeroed.items()}
plotting.save(
    figure,
    "budget_ratio",
    numbers={f"{n}_{m}": [1e6 * rms(zeroed[n, m].rmse), ratios[n, m]] for n in terms for m in MODES}
    | {"air_raw": float(np.median(raw["air", "single"].ratio)),
       "implied": [1e6 * implied[w] for w in implied]},
    caption=(
        "MAE over RMSE against size, each term alone and all together (black), diffuse target: "
        "median over the days, with the range of 10 to 90 %. Stars: the published Table 4."
    ),
    alt=(
        "Two panels. Noise lies near 0.8, "
        f"with photon noise at {ratios['photons', 'single']:.2f}; back-reflection at "
        f"{ratios['back', 'single']:.2f}, four steps at {ratios['four', 'single']:.2f} and ignored "
        f"air at {np.median(raw['air', 'single'].ratio):.2f} near 1. All together "
        f"{ratios['together', 'single']:.2f} and {ratios['together', 'doubled']:.2f} at a few "
        "micrometres. Two stars of Table 4 lie at 0.97 and 0.95 and 34 µm, away from them."
    ),
)  # fmt: skip
CONSTANT = 0.9
lists = {}
for mode in MODES:
    here = [n for n in TERMS if n != "sixteen" and rms(zeroed[n, mode].rmse) > 1.5 * floor[mode]]
    lists[mode] = [TERMS[n].label for n in here if ratios[n, mode] >= CONSTANT]
steady = [rms(zeroed[n, m].rmse) for n in TERMS for m in MODES
          if n not in APART and ratios[n, m] >= CONSTANT]  # fmt: skip
largest_one = 1e6 * max(steady, default=0.0)
first = {m: float(np.median(parts(measured["together", m].first, positions).ratio)) for m in MODES}
say(
    "ratio_says",
    f"A median ratio of {CONSTANT} or more, and a size that stands out of the rounding, have in "
    f"the single mode: {', '.join(lists['single']) or 'none'}; in the doubled one: "
    f"{', '.join(lists['doubled']) or 'none'}; and air, where no zero takes it out.",
    f"Those that belong to the whole are small, {largest_one:.1f} µm at most.",
    "The whole is ruled by noise and drift, with ratios of "
    f"{ratios['together', 'single']:.2f} and {ratios['together', 'doubled']:.2f}."
    if max(ratios["together", m] for m in MODES) < CONSTANT
    else "So the whole is nearly a constant as well, with ratios of "
    f"{ratios['together', 'single']:.2f} and {ratios['together', 'doubled']:.2f}.",
    "A zero from the sweep's own first reading, whose error moves all others, gives "
    f"{first['single']:.2f} and {first['doubled']:.2f}.",
)
tell(implied_mirror=1e6 * implied["mirror"], implied_diffuse=1e6 * implied["diffuse"],
     stated_sd=1e6 * paper.published("fig13.standard_deviation").value,
     whole_single=1e6 * whole_rms["single"], whole_doubled=1e6 * whole_rms["doubled"],
     short=paper.published("table4.proposed.rmse_diffuse").value / max(whole_rms.values()),
     four_um=1e6 * forms["four", "single"], four_peak=1e6 * np.sqrt(2) * forms["four", "single"],
     eta=eta, four_ratio=ratios["four", "single"])  # fmt: skip

# %% [markdown]
# ```{glue:md} ratio_says
# :format: myst
# ```
#
# Table 4 is {glue:text}`short:.0f` times the whole of this budget, which is
# {glue:text}`whole_single:.1f` and {glue:text}`whole_doubled:.1f` µm rms, and its ratios are those
# of constants. Where all errors have one sign, RMSE and MAE also
# tell the scatter, $\sqrt{\mathrm{RMSE}^2-\mathrm{MAE}^2}$: {glue:text}`implied_mirror:.1f` µm on
# the mirror and {glue:text}`implied_diffuse:.1f` µm on the diffuse target, near the stated
# {glue:text}`stated_sd:.1f` µm though not equal ({doc}`22_errata`, erratum 24).
#
# ## What it would take
#
# Each term is linear, or nearly, so its closed form can be turned round: what size makes
# {glue:text}`wanted:.1f` µm of constant error, or {glue:text}`spread_um:.1f` µm of scatter, alone?
# A cyclic error is taken at its crest, so these sizes are the least.

# %% tags=["hide-input"]
wanted = paper.published("fig13.accuracy").value
spread = paper.published("fig13.standard_deviation").value


def size_text(need):
    """The needed size in a unit that a bench would use."""
    if need.unit == "rad":
        return f"{np.rad2deg(need.size):.2g}°" if need.size > 0.2 else f"{1e3 * need.size:.3g} mrad"
    if need.unit.startswith("dB"):
        factor = 10 if need.unit.endswith("power") else 20
        return f"{factor * np.log10(need.size):.0f} dB".replace("-", "−")
    if need.unit == "m":
        return f"{1e3 * need.size:.0f} mm" if need.size > 1e-3 else f"{1e6 * need.size:.3g} µm"
    units = {"K": " K", "eta": " rad", "times": " times", "of assumed": " of the light"}
    return f"{need.size:.2g}{units[need.unit]}"


needs = {
    "offset": {m: offset_needs(wanted, target, mode=m) for m in MODES},
    "scatter": {m: scatter_needs(spread, target, mode=m) for m in MODES},
}
figure, axes = plt.subplots(1, 2, figsize=(11.4, 5.2))
titles = {
    "offset": f"a constant {1e6 * wanted:.1f} µm",
    "scatter": f"scatter of {1e6 * spread:.1f} µm",
}
for ax, (kind, by_mode) in zip(axes, needs.items(), strict=True):
    labels = list(dict.fromkeys(need.label for m in MODES for need in by_mode[m]
                                if np.isfinite(need.factor)))  # fmt: skip
    for mode, shift in zip(MODES, (0.19, -0.19), strict=True):
        for need in by_mode[mode]:
            if need.label not in labels:
                continue
            y = len(labels) - labels.index(need.label) + shift
            ax.plot([1, need.factor], [y, y], color=COLOURS[mode], lw=2.4)
            ax.plot(need.factor, y, "o", color=COLOURS[mode], ms=5,
                    label=mode if need.label == labels[0] else None)  # fmt: skip
            grows = need.factor > 1
            ax.text(need.factor * (1.25 if grows else 0.8), y, size_text(need), fontsize=8.5,
                    va="center", ha="left" if grows else "right")  # fmt: skip
    ax.axvline(1, color=GREY, lw=1)
    ax.set_yticks(len(labels) - np.arange(len(labels)), labels)
    decades(ax)
    ax.set(ylim=(0.4, len(labels) + 0.7), title=titles[kind],
           xlabel="error needed over error assumed")  # fmt: skip
    ax.grid(axis="y", visible=False)
axes[0].set_xlim(0.015, 2000)
axes[1].set_xlim(0.5, 2000)
axes[0].legend(loc="upper left")
plotting.label_panels(axes)
by = {(kind, m, need.label): need for kind in needs for m in MODES for need in needs[kind][m]}
plotting.save(
    figure,
    "budget_needed",
    numbers={f"{kind}_{m}": {need.label: need.size for need in needs[kind][m]}
             for kind in needs for m in MODES},
    caption=(
        "What each term would have to be, alone, to make the published errors: by how much its "
        "error exceeds that of the size assumed here, and the size itself. (a) A constant error, "
        "(b) scatter from position to position. Nothing here is fitted."
    ),
    alt=(
        "Two panels of points on logarithmic scales. For the offset: an RF phase of "
        f"{1e3 * by['offset', 'single', 'RF phase since the zero'].size:.0f} milliradian, a "
        "back-reflection of "
        f"{10 * np.log10(by['offset', 'single', 'back-reflection over target'].size):.0f} decibel "
        "of the target's light, an I/Q imbalance of "
        f"{1e3 * by['offset', 'single', 'I/Q imbalance'].size:.0f} milliradian, four steps at a "
        f"drive of {by['offset', 'single', 'drive, with 4 steps'].size:.2f} radian, "
        f"{1e3 * by['offset', 'single', 'air left out, path in it'].size:.0f} millimetres of air "
        "left out. For the scatter: "
        f"{by['scatter', 'single', 'light'].size:.2f} of the light in the single mode, "
        f"{1e3 * by['scatter', 'single', 'RF phase, point to point'].size:.1f} milliradian of "
        "phase from point to point."
    ),
)  # fmt: skip

# %% tags=["hide-input"]
get = {need.label: need for need in needs["offset"]["single"]}
two = {need.label: need for need in needs["offset"]["doubled"]}
fine = {need.label: need for need in needs["scatter"]["single"]}
tell(wanted=1e6 * wanted, need_phase=1e3 * get["RF phase since the zero"].size,
     need_back=10 * np.log10(get["back-reflection over target"].size),
     have_back=10 * np.log10(get["back-reflection over target"].assumed),
     back_emitted=10 * np.log10(get["back-reflection over target"].size / back_ratio(target)
                                * known.optics.back_fraction),
     coated=10 * np.log10(2.5e-3), need_skew=np.rad2deg(get["I/Q imbalance"].size),
     need_eta=get["drive, with 4 steps"].size, need_air=1e3 * get["air left out, path in it"].size,
     need_kelvin=get["air since the zero"].size, need_bench=get["0.6 m of bench"].size,
     need_cable=get["1 m of cable"].size, need_leak=20 * np.log10(two["RF leakage"].size),
     have_leak=20 * np.log10(two["RF leakage"].assumed),
     need_plate=np.rad2deg(two["half-wave plates"].size), need_codes=1e3 * get["phase codes"].size,
     cable_ppm=1e6 * CABLE_DRIFT, cable_length=CABLE_LENGTH, bench_ppm=1e6 * EXPANSION,
     need_light=100 * fine["light"].size, need_jitter=1e3 * fine["RF phase, point to point"].size,
     need_stage=1e6 * fine["stage"].size, need_slope=np.rad2deg(fine["slope, fresh speckle"].size),
     need_laser=fine["laser drift"].size, spread_um=1e6 * spread,
     stage_said=1e6 * paper.published("sec8.stage_error").value,
     scatter_single=1e6 * rms(zeroed["together", "single"].scatter),
     scatter_doubled=1e6 * rms(zeroed["together", "doubled"].scatter))  # fmt: skip

# %% [markdown]
# **Plausible, each alone, for {glue:text}`wanted:.1f` µm** (*known* and *assumed* as in
# {doc}`13_instrument`):
#
# - *The range of the reference.* An error of the zero is an error of every range. A steel rule
#   gives half a millimetre; 33 µm at 60 cm needs more than that. The paper does not say how its
#   zero was found.
# - *RF phase since the zero*, {glue:text}`need_phase:.0f` mrad. A cable of
#   {glue:text}`cable_length:.0f` m whose electrical length changes by {glue:text}`cable_ppm:.0f`
#   ppm a kelvin (known, PTFE) does that in {glue:text}`need_cable:.1f` K.
# - *Expansion.* 0.6 m of aluminium bench, {glue:text}`bench_ppm:.0f` ppm a kelvin (known), does it
#   in {glue:text}`need_bench:.1f` K.
# - *Back-reflection*, {glue:text}`need_back:.0f` dB of the target's light, where
#   {glue:text}`have_back:.0f` dB are assumed. Of the emitted light that is
#   {glue:text}`back_emitted:.0f` dB; a coated face reflects about {glue:text}`coated:.0f` dB
#   (known), nearly all of which has to miss the aperture. Against a mirror, which sends all its
#   light back, the same stray light is nothing, unless a filter stands between them. The paper's
#   mirror errs as much as its diffuse target, so this hardly explains both.
# - *Air left out* of {glue:text}`need_air:.0f` mm of path: a reference that stands nearer than the
#   target by that much is enough.
# - *I/Q imbalance* of {glue:text}`need_skew:.1f`° in the single mode, *RF leakage* of
#   {glue:text}`need_leak:.0f` dB in the doubled one (assumed: {glue:text}`have_leak:.0f` dB), and
#   *half-wave plates* off by {glue:text}`need_plate:.1f`° there.
# - *Four steps* and a drive of {glue:text}`need_eta:.2f` rad. With the drive assumed here,
#   {glue:text}`eta:.2f` rad, four steps make {glue:text}`four_um:.0f` µm rms and a ratio of
#   {glue:text}`four_ratio:.2f`. But the paper states sixteen phases for its scans, and sixteen do
#   not alias.
#
# **Not plausible**: air that changed since the zero ({glue:text}`need_kelvin:.0f` K), phase codes
# ({glue:text}`need_codes:.0f` mrad each), spot and wavefront on a flat target.
#
# **For the {glue:text}`spread_um:.1f` µm of scatter**, where the whole has
# {glue:text}`scatter_single:.1f` and {glue:text}`scatter_doubled:.1f` µm:
# {glue:text}`need_light:.0f` % of the light assumed here in the single mode, or an RF phase that
# moves by {glue:text}`need_jitter:.1f` mrad from point to point, or a stage that errs by
# {glue:text}`need_stage:.1f` µm, where the paper states {glue:text}`stage_said:.2f` µm (for a stage
# driven by a screw that is a step, not an accuracy: *known*), or a target
# {glue:text}`need_slope:.0f`° out of square whose speckle changes from point to point, or a laser
# that drifts {glue:text}`need_laser:.0f` times as fast. No cyclic error can do it: none of them
# turns fast enough.
#
# So the budget explains the *kind* of the published errors, many a term of plausible size makes a
# constant of 33 µm, but it does not tell which. A lab could: a second zero at another range
# separates back-reflection and I/Q from the rest, the other mode separates lengths (equal in µm)
# from RF phases, and the same sweep an hour later shows the drift.
#
# ## On a slope
#
# The target of Fig. 13 faces the beam. On a slope speckle lights up now the near, now the far side
# of the spot, and its mean range scatters by $\tan\theta\,(w/2)/\sqrt N$, for a spot of the radius
# $w$ with $N$ speckle cells in the aperture.

# %%
angles = np.deg2rad([0.0, 5.0, 15.0, 30.0])
tilted = [
    (tilt, slope_errors(known, tilt, distance=0.6, count=2000, seed=seed).std(),
     slope_scatter(known, tilt, distance=0.6))
    for tilt in angles
]  # fmt: skip
rows = [[f"{np.rad2deg(t):.0f}°", f"{1e6 * s:.2f}", f"{1e6 * f:.2f}"] for t, s, f in tilted]
table("slope", ["slope", "simulated (µm)", "closed form (µm)"], rows)
light = {
    (what.material, mode): OpticalRanger(known, mode).grey_filter(what)
    for what in (target, mirror) for mode in MODES
}  # fmt: skip
brightest = OpticalRanger(known, "single", level=1.0)
conversion = Conversion(known.detector, known.laser.wavelength)
crest = known.detector.saturation / conversion.volts_per_watt
# light falls with the square of the range
near = 0.3 * brightest.grey_filter(StageTarget(distance=0.3)) ** -0.5
tell(near=100 * near, crest=1e9 * crest, mirror_filter=-10 * np.log10(light["specular", "single"]))

# %% [markdown]
# ```{glue:md} slope
# :format: myst
# ```
#
# ## Saturation, and the mirror
#
# The detector ends at {glue:text}`crest:.2f` nW. The diffuse target at 60 cm keeps well below; it
# would clip the crest of the correlation nearer than {glue:text}`near:.0f` cm. The mirror needs a
# grey filter of {glue:text}`mirror_filter:.0f` dB in front of the detector. With it, the mirror is
# a brighter target without speckle, and nothing else changes:

# %% tags=["hide-input"]
lines = []
for mode in MODES:
    for what, found in (("diffuse", measured["together", mode].zeroed),
                        ("mirror", on_mirror[mode].zeroed)):  # fmt: skip
        some = parts(found, positions)
        limit = bound["diffuse" if what == "diffuse" else "specular", mode]
        numbers = 1e6 * rms(some.rmse), 1e6 * rms(some.scatter), 1e6 * limit
        cells = [f"{number:.1f}" for number in numbers]
        lines.append([f"{what}, {mode}", *cells, f"{np.median(some.ratio):.2f}"])
table("both_targets", ["all together", "rms", "scatter", "bound", "ratio"], lines)

# %% [markdown]
# ```{glue:md} both_targets
# :format: myst
# ```
#
# µm, but for the ratio. The table of the paper's sweep itself, with intervals and beside the other
# two methods, is {doc}`17_precision_sweep`.
#
# ## Against the paper

# %%
reached = {
    "sec8.scan_phase_steps": OpticalRanger(known).phases,
    "sec8.stage_error": TOGETHER.ranging["stage_error"],
    "fig13.target_distance": target.distance,
}
for key, value in reached.items():
    paper.check(key, value)
