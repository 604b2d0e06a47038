# ---
# cmtof:
#   results:
#     - table2_released_1200.json
#     - table2_full_1200.json
# ---
# %% [markdown]
# # The limits: what the data can tell
#
# One pixel cannot tell its wrap ({doc}`03_wraps`), a surface can. So how well a scene can be
# unwrapped hangs on its surfaces: how large they are, how bright, how steep, and what is known of
# them. This page measures it with oracles. Each is told something that a method would have to find
# out, and reads the rest from the same simulated images as every method.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of the noise
places: list = [1, 4, 13, 22, 31, 40]  # test frames looked at on this page
height: int = 256  # of those frames, px
width: int = 256
sides: list = [5, 11, 21, 41, 81, 161, 321]  # windows, px
repeats: int = 8  # measurements of each frame in the last section
draws: int = 4000  # sets of scenes drawn for the intervals
results: str = "../book/results"  # folder of counts over all test frames

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from myst_nb import glue

import cmtof
from cmtof import bounds, stored_counts, tally
from cmtof.baselines.oracle_field import SIDE
from cmtof.baselines.oracle_offset import bodies, surfaces
from cmtof.book import plotting
from cmtof.comparison import Scene, comparison_figure
from cmtof.conditions import Conditions
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, phase_from_depth
from cmtof.metrics import scored_pixels
from cmtof.rates import markdown_table, rates_of_counts
from cmtof.scenes.rooms.held_out import TEST_ROOMS
from cmtof.scenes.rooms.rendering import Settings
from cmtof.simulation import RELEASED_FAR_DEPTH

run = plotting.begin(profile=profile, seed=seed)
here = Settings(TEST_ROOMS.seed, TEST_ROOMS.scenes, height=height, width=width)
PROTOCOLS = ("released", "full")
ORACLES = ("oracle-field", "oracle-plane", "oracle-offset", "oracle-contact", "oracle-depth")


def say(name, *sentences):
    glue(name, Markdown(" ".join(one for one in sentences if one)), display=False)


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, float(value), display=False)


# %% [markdown]
# ## Five oracles
#
# | oracle | is told | must find |
# | --- | --- | --- |
# | `oracle-depth` | the depth itself | nothing; what it loses lies within noise of a wrap's end |
# | `oracle-contact` | the shape of all that hangs together, across creases | one offset a body |
# | `oracle-offset` | the shape of each surface, between creases | one offset a surface |
# | `oracle-plane` | the same but for a tilt | offset and tilt of each surface |
# | `oracle-field` | as above, within {glue:text}`field_side:.0f` px | one offset a pixel |
#
# All but the first demodulate both images by the shape that they are told, add up what belongs
# together, read the fraction of a wrap from the lower frequency's sum and the whole wraps from the
# beat of the two sums. The window of `oracle-field` is the receptive field of the paper's network
# as we built it ({doc}`12_network`).

# %%
tables = {}
for protocol in PROTOCOLS:
    path = Path(results) / f"table2_{protocol}_1200.json"
    held = stored_counts.read_counts(path) if path.is_file() else None
    tables[protocol] = held["frames"] if held else []
shown = ("beat", "region", "mrf", "mrf-graphcut", *ORACLES)
found = {p: rates_of_counts(tables[p], shown, draws=draws, seed=seed) for p in PROTOCOLS}
glue("oracle_table", Markdown(markdown_table(shown, found)), display=False)
rates = {(label, p): found[p][label].value.tolist() for p in PROTOCOLS for label in found[p]}
frames_counted = len(tables["full"])
glue("frames_counted", frames_counted, display=False)
tell(field_side=SIDE, far_depth=RELEASED_FAR_DEPTH)

# %% [markdown]
# ```{glue:md} oracle_table
# :format: myst
# ```
#
# Rates in % over {glue:text}`frames_counted` test frames, 95 % over scenes in brackets; the methods
# of {doc}`10_methods` above, the oracles below.

# %% tags=["hide-input"]
if ("oracle-contact", "full") in rates:
    tied = {p: 100 * (rates["oracle-contact", p][0] - rates["oracle-offset", p][0])
            for p in PROTOCOLS}  # fmt: skip
    tilted = {p: 100 * abs(rates["oracle-plane", p][0] - rates["oracle-offset", p][0])
              for p in PROTOCOLS}  # fmt: skip
    best = {p: max((m for m in shown if m not in ORACLES), key=lambda m, p=p: rates[m, p][0])
            for p in PROTOCOLS}  # fmt: skip
    say(
        "contact",
        f"Ties across creases are worth {tied['released']:.0f} points (`released`) and "
        f"{tied['full']:.0f} (`full`): a chair knows where it stands by the floor that it stands "
        "on, and by nothing else. An unknown tilt changes the rates by "
        f"{tilted['released']:.1f} and {tilted['full']:.1f} points: a surface large enough to tell "
        "its wrap tells its slope far better. The best method without the truth is "
        f"`{best['released']}` with {100 * rates[best['released'], 'released'][0]:.0f} % "
        f"(`released`) and `{best['full']}` with {100 * rates[best['full'], 'full'][0]:.0f} % "
        "(`full`).",
    )
else:
    say("contact", "The stored counts lack the oracles.")

# %% [markdown]
# ```{glue:md} contact
# :format: myst
# ```
#
# ## How far one has to look
#
# The same surfaces through windows of other sides, and the averaged beat of the same sides, which
# knows nothing of shapes: it mixes the two sides of an edge, and dims as the beat turns.

# %%
window_rates = {}
measured = {}
for protocol in PROTOCOLS:
    contest = tally.Contest({}, here, Conditions(protocol=protocol, seed=seed))
    measured[protocol] = [
        (frame := contest.frame(place), contest.measure(frame, place).usual) for place in places
    ]
    for label, method, option in (("oracle", "oracle-field", "side"), ("beat", "beat", "window")):
        row = []
        for side in sides:
            counts = np.zeros(2)
            for frame, measurement in measured[protocol]:
                answer = cmtof.unwrap(measurement, method=method, **{option: side})
                scene = Scene(frame, measurement, {label: answer})
                if measurement.mask.any():
                    counts += [np.nansum(scene.error(label) < 1), measurement.mask.sum()]
            row.append(float(counts[0] / counts[1]))
        window_rates[protocol, label] = row
        print(protocol, label, [f"{x:.3f}" for x in row])

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(10.0, 3.8), sharey=True)
for ax, protocol in zip(axes, PROTOCOLS, strict=True):
    for label, name in (("oracle", "green"), ("beat", "blue")):
        ax.plot(sides, [100 * x for x in window_rates[protocol, label]], "o-", ms=4,
                color=plotting.PALETTE[name],
                label="true surfaces" if label == "oracle" else "beat averaged")  # fmt: skip
    ax.set(xscale="log", xlabel="side of the window (px)", title=protocol, ylim=(0, 100))
    ax.set_xticks(sides, [str(s) for s in sides])
    ax.minorticks_off()
axes[0].set_ylabel("δ < 1 (%)")
axes[0].legend()
plotting.label_panels(axes)
plotting.save(
    figure,
    "limits_windows",
    numbers={"sides": sides} | {f"{p}_{label}": row for (p, label), row in window_rates.items()},
    caption=(
        f"Pixels in the right wrap against the side of the window that is pooled, on {len(places)} "
        f"frames of {height}×{width} px, σ = 1200."
    ),
    alt=(
        "Two panels, the oracle's rate above the averaged beat's. "
        + " ".join(
            f"{p}: the oracle ends at {100 * window_rates[p, 'oracle'][-1]:.0f} %, the beat best "
            f"at {sides[int(np.argmax(window_rates[p, 'beat']))]} px with "
            f"{100 * max(window_rates[p, 'beat']):.0f} %."
            for p in PROTOCOLS
        )
    ),
)

# %% [markdown]
# ## Steep surfaces
#
# Neighbours tell a slope only up to a whole turn a pixel. In a room at its real size many surfaces
# recede so fast that the phase turns by more than half a turn from one pixel to the next: whoever
# unwraps such a surface neighbour by neighbour, or pools it with the smallest slope that fits,
# loses a wrap with every pixel. What tells the turns is the beat's own slope, and how the phase
# curves.

# %%
slopes = {}
for protocol, held in measured.items():
    steps = []
    for _, measurement in held:
        surface, _ = surfaces(measurement.depth.astype(float))
        phase = phase_from_depth(measurement.depth.astype(float), FREQUENCIES[0])
        turns = [np.abs(np.diff(phase, axis=a)) / TAU for a in (0, 1)]
        within = [np.diff(surface, axis=a) == 0 for a in (0, 1)]
        inside = [np.delete(measurement.mask, -1, a) & w for a, w in enumerate(within)]
        steps += [t[i] for t, i in zip(turns, inside, strict=True)]
    slopes[protocol] = np.concatenate(steps)
share = {p: float(np.mean(s > 0.5)) if s.size else 0.0 for p, s in slopes.items()}
tell(steep_released=100 * share["released"], steep_full=100 * share["full"])
print(share)

# %% [markdown]
# Of all steps between neighbours within one surface {glue:text}`steep_full:.0f` % are steeper than
# half a turn in the full protocol, and {glue:text}`steep_released:.0f` % in the released one, which
# shrinks rooms to {glue:text}`far_depth:.1f` m: another way in which it is the easier one.
#
# ## Where it is lost
#
# White is scored and wrong by ten wraps or more, black is right. Small things fail first in
# `oracle-offset`, dark ones next; what remains in `oracle-contact` is what hangs in the air, or
# touches only what is dark.

# %% tags=["hide-input"]
names = ("mrf-graphcut", "oracle-field", "oracle-offset", "oracle-contact", "oracle-depth")
scenes = [
    Scene(frame, m, {n: cmtof.unwrap(m, method=n) for n in names})
    for frame, m in measured["full"][:2]
]
plotting.save(
    comparison_figure(scenes, {name: name for name in names}),
    "limits_maps",
    numbers={
        "scenes": [scene.frame.name for scene in scenes],
        "right": {name: [scene.right(name) for scene in scenes] for name in names},
    },
    caption="Full protocol: wraps above, how far they are off below; black is right.",
    alt="Rooms with the wraps found by a method and by four oracles; the errors shrink from left "
    "to right to the boundaries of wraps.",
    format="png",
)

# %% [markdown]
# ## How much light a surface needs
#
# Information on the wrap adds up over a surface: n pixels of one phase noise σ know as much as one
# of σ/√n. So the scene itself foretells, before any image is taken, how much of it can be told:
# the odds of every surface, weighted by its pixels. A surface of full brightness needs
# {glue:text}`needed:.0f` pixels for odds of 95 %, one at a tenth of it
# {glue:text}`needed_dark:.0f`.

# %%
white = float(bounds.simulated_phase_noise(1.0))
grey = float(bounds.simulated_phase_noise(0.1))
tell(repeats=repeats, needed=bounds.pixels_needed(white, white, frequencies=FREQUENCIES),
     needed_dark=bounds.pixels_needed(grey, grey, frequencies=FREQUENCIES))  # fmt: skip


def odds_of(spread, number, measurement):
    """Sum of the odds of all scored pixels, each on a surface of that number."""
    odds = bounds.wrap_probability(spread, spread, frequencies=FREQUENCIES)
    return odds[number][measurement.mask].sum()


def foretold(frame, measurement, number):
    """Sums of odds for phasors that are added up alike, and weighted as noise would have it."""
    light = np.where(np.isfinite(measurement.depth), np.clip(frame.intensity, 1e-6, 1), 0)
    noise = bounds.simulated_phase_noise(np.maximum(light, 1e-6))
    alike, weighted, amplitude = (
        np.bincount(number.ravel(), np.where(light > 0, values, 0).ravel())
        for values in ((noise * light) ** 2, noise**-2, light)
    )
    with np.errstate(divide="ignore"):
        spreads = np.sqrt(alike) / amplitude, 1 / np.sqrt(weighted)
    return np.array([odds_of(np.nan_to_num(x, nan=np.inf), number, measurement) for x in spreads])


lines = ["| protocol | pooled over | found, % | foretold, % | best weights, % |",
         "| --- | --- | --: | --: | --: |"]  # fmt: skip
law = {}
for protocol, held in measured.items():
    for label, group in (("oracle-offset", lambda d: surfaces(d)[0]), ("oracle-contact", bodies)):
        told, found, scored = np.zeros(2), 0.0, 0.0
        for place, (frame, m) in zip(places, held, strict=True):
            if not m.mask.any():
                continue
            told += repeats * foretold(frame, m, group(m.depth.astype(float)))
            scored += repeats * m.mask.sum()
            for again in range(1, repeats + 1):
                other = Conditions(protocol=protocol, seed=seed + again).measure(frame, place)
                pixels = scored_pixels(cmtof.unwrap(other, method=label), other)
                found += np.sum(pixels["consistent"] == pixels["true_consistent"])
        shares = [float(x) for x in (found / scored, *(told / scored))]
        law[f"{protocol}_{label}"] = shares
        what = "surfaces" if label == "oracle-offset" else "bodies"
        lines.append(
            f"| {protocol} | {what} | " + " | ".join(f"{100 * x:.1f}" for x in shares) + " |"
        )
glue("law", Markdown("\n".join(lines)), display=False)
print(law)

# %% [markdown]
# ```{glue:md} law
# :format: myst
# ```
#
# It is the share of pixels whose measured phase gets the right number of turns, over
# {glue:text}`repeats:.0f` measurements of each frame. The oracles add up phasors alike, and are
# right as often as that foretells, to what so few surfaces allow. Weighted by their brightness the
# phasors would tell a little more: that last column is the bound for who knows every shape and
# reads its place from the beat. Who wants more has to know what touches what, or which surfaces are
# flat: a plane seen by a known camera tells its distance by its shape ({doc}`11_surfaces`).
