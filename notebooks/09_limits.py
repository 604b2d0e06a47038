# %% [markdown]
# # Limits of the data
#
# One pixel does not determine its wrap ([chapter 3](03_wraps.ipynb)); a surface does. How much of a
# scene can any method unwrap?
#
# A limit separates a poor method from poor data. It depends on the size, brightness and slope of
# the surfaces and on what is known of them. References that are given a part of the truth measure
# it, on the same images as all methods.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of the noise
places: list = [1, 6, 11, 16, 21, 26]  # test frames of this page
height: int = 384  # of those frames, px: their middle
width: int = 512
sides: list = [5, 11, 21, 41, 81, 161, 321]  # windows, px
repeats: int = 4  # measurements of each frame in the last section
draws: int = 2000  # sets of scenes drawn for the intervals
results: str = "../book/results"  # folder of counts over all test frames

# %% tags=["hide-input"]
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cmtof
from cmtof import bounds
from cmtof.classical.references import SIDE, bodies, surfaces
from cmtof.constants import FREQUENCIES
from cmtof.evaluation import Tally, rates, read_counts, scored_pixels
from cmtof.frame import held_out_frames
from cmtof_book import notes, plotting
from cmtof_book.comparison import Scene, comparison_figure

plotting.begin(profile=profile, seed=seed)
PROTOCOLS = ("released", "full")
METHODS = (
    "beat",
    "region",
    "mrf",
    "mrf-graphcut",
    "surfaces",
    "reference-field",
    "reference-offset",
    "reference-contact",
    "reference-depth",
)
every = held_out_frames()
frames = [every[place].middle(height, width) for place in places]

# %% [markdown]
# ## Size of the window
#
# The wrap follows from the sum of a surface's phasors over a window. In the upper curve the shape
# of every surface is known (`reference-field`); in the lower one the beat is averaged over all of
# the window. This average mixes the two sides of an edge, and its amplitude falls where the beat
# changes.

# %% tags=["hide-input"]
measured = {
    protocol: [
        cmtof.simulate(frame, protocol=protocol, seed=seed, frame_number=place)
        for frame, place in zip(frames, places, strict=True)
    ]
    for protocol in PROTOCOLS
}
window_rates = {}
for protocol in PROTOCOLS:
    for method, option in (("reference-field", "side"), ("beat", "window")):
        row = []
        for side in sides:
            tally = Tally()
            for m in measured[protocol]:
                answer = cmtof.unwrap(m, method=method, **{option: side})
                tally.add(scored_pixels(answer, m))
            row.append(tally.score()["delta_lt_1"])
        window_rates[protocol, method] = row

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.6), sharey=True)
for ax, protocol in zip(axes, PROTOCOLS, strict=True):
    for method, label, name in (
        ("reference-field", "true surfaces", "C2"),
        ("beat", "beat averaged", "C0"),
    ):
        ax.plot(
            sides,
            [100 * x for x in window_rates[protocol, method]],
            "o-",
            ms=4,
            color=name,
            label=label,
        )
    ax.set(
        xscale="log", xlabel="side of the window (px)", title=protocol, ylim=(0, 100)
    )
axes[0].set_ylabel("δ < 1 (%)")
axes[0].legend()
plotting.label_panels(axes)
plotting.save(
    figure,
    "limits_windows",
    caption="Right wraps against the side of the pooled window in simulated test frames (σ = "
    "1200), for `beat`, and for a reference that is given the true shape of every surface.",
    alt="Two panels of curves over the side of the window. The one of the true surfaces rises all "
    "the way, the one of the averaged beat has a maximum at some tens of pixels and stays far "
    "below.",
)

# %% [markdown]
# ## Four references
#
# | reference | is given | must find |
# | --- | --- | --- |
# | `reference-depth` | the depth itself | nothing; noise moves phases across a wrap's end |
# | `reference-contact` | the shape of all that is connected | one offset a body |
# | `reference-offset` | the shape of each surface, between creases | one offset a surface |
# | `reference-field` | as `reference-offset`, within 281 px | one offset a pixel |
#
# All but the first subtract the known shape from both phases and add the phasors that belong
# together. The lower frequency's sum gives the fraction of a wrap, the beat of both sums the whole
# wraps. The window of `reference-field` is about half as wide as what the network of
# [chapter 8](08_network.ipynb) sees.

# %% tags=["hide-input"]
rows = []
share = {}
for name in METHODS:
    cells = []
    for protocol in PROTOCOLS:
        counts = read_counts(Path(results) / f"table2_{protocol}_1200.json")
        if not counts or name not in counts[0]["methods"]:
            cells += [""] * 3
            continue
        found = rates(counts, name, draws=draws)
        value, low, high = share[protocol, name] = [100 * part for part in found]
        cells.append(f"{value[0]:.1f} ({low[0]:.1f}–{high[0]:.1f})")
        cells += [f"{value[2]:.1f}", f"{value[3]:.1f}"]
    rows += [[f"`{name}`", *cells]] if any(cells) else []  # where it was counted
notes.table(
    [
        "%",
        *(
            f"{name}: {one}"
            for name in PROTOCOLS
            for one in ("δ < 1", "δ < 3", "δ ≥ 10")
        ),
    ],
    rows,
)
print(
    f"{len(counts)} test frames; 95 % over scenes; window of reference-field: {SIDE} px"
)

# %% [markdown]
# The step from `reference-offset` to `reference-contact` is the gain from connections across
# creases: the offset of a chair follows from the floor that it stands on. The references do not use
# what the rays of a known camera tell of a plane. `surfaces` does, and exceeds `reference-offset`
# where that counts, in the full protocol ([chapter 11](11_surfaces.ipynb)).
#
# ## Steep surfaces
#
# Neighbouring pixels give a slope only up to a whole turn a pixel. In a room at its real size the
# phase of many surfaces changes by more than half a turn a pixel. A method that unwraps such a
# surface neighbour by neighbour, or pools it with the smallest slope that fits, loses a wrap with
# every pixel. The slope of the beat and the curvature of the phase resolve the ambiguity. The
# released protocol shrinks rooms to 1.2 m and is easier in this respect too.
# [Chapter 6](06_scenes.ipynb) has the slopes.
#
# ## Errors of the references
#
# In `reference-offset` small surfaces fail first, dark ones next. In `reference-contact` only those
# surfaces fail that touch nothing, or only dark surfaces.

# %% tags=["hide-input"]
names = ("surfaces", "reference-offset", "reference-contact", "reference-depth")
first = measured["full"][0]
answers = {name: cmtof.unwrap(first, method=name) for name in names}
plotting.save(
    comparison_figure(Scene(frames[0], first, answers), names),
    "limits_maps",
    caption="A simulated test room, full protocol, σ = 1200: errors in wraps (black: none) and the "
    "share of right pixels. Our `surfaces` is a method; references are given a part of the truth.",
    alt="A room, its true wraps, and the errors of a method and of three references, which shrink "
    "to the boundaries of wraps.",
    format="png",
)

# %% [markdown]
# ## Light needed by a surface
#
# Information adds up over a surface: n pixels of phase noise σ equal one of σ/√n. The scene alone
# thus predicts how much of it can be unwrapped: the odds of every surface, weighted by its pixels.


# %% tags=["hide-input"]
def predicted(frame, measurement, number):
    """Sums of odds for phasors that are added up alike, and with the best weights."""
    light = np.where(
        np.isfinite(measurement.depth), np.clip(frame.intensity, 1e-6, 1), 0
    )
    noise = bounds.simulated_phase_noise(np.maximum(light, 1e-6))
    alike, weighted, amplitude = (
        np.bincount(number.ravel(), np.where(light > 0, values, 0).ravel())
        for values in ((noise * light) ** 2, noise**-2, light)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        spreads = np.sqrt(alike) / amplitude, 1 / np.sqrt(weighted)
    spreads = [np.nan_to_num(spread, nan=np.inf) for spread in spreads]
    odds = [bounds.wrap_probability(s, s, frequencies=FREQUENCIES) for s in spreads]
    return np.array([one[number][measurement.mask].sum() for one in odds])


# %% tags=["hide-input"]
groups = {"reference-offset": surfaces, "reference-contact": bodies}
rows = []
for protocol in PROTOCOLS:
    for name, group in groups.items():
        expected = np.zeros(2)
        found = 0
        scored = 0
        for frame, place, m in zip(frames, places, measured[protocol], strict=True):
            expected += repeats * predicted(frame, m, group(m.depth.astype(float)))
            for again in range(1, repeats + 1):
                other = cmtof.simulate(
                    frame, protocol=protocol, seed=seed + again, frame_number=place
                )
                pixels = scored_pixels(cmtof.unwrap(other, method=name), other)
                found += np.sum(pixels["consistent"] == pixels["true_consistent"])
                scored += pixels["consistent"].size
        shares = (found / scored, *(expected / scored))
        rows.append([protocol, name, *(f"{100 * share:.1f}" for share in shares)])
notes.table(
    ["protocol", "pooled by", "found, %", "predicted, %", "best weights, %"], rows
)

# %% [markdown]
# *Found* is the share of pixels whose measured phase gets the right number of turns. The references
# add phasors with equal weights and agree with the prediction, as far as so few surfaces allow.
# With weights by brightness they would gain a little: the last column is what a method may expect
# that is given every shape and takes its distance from the beat. Luck apart, only contacts or flat
# surfaces give more: the shape of a plane in a known camera gives its distance ([chapter
# 11](11_surfaces.ipynb)).

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
with_contacts = share["released", "reference-contact"]
notes.answer(
    """
    **Answer.** A reference that is given the shape of every surface unwraps {shapes:.0f} % of the
    pixels of the small test frames (384×512, released protocol); one that is also given what
    touches what, {contacts:.0f} % ({low:.0f}–{high:.0f}). Our `surfaces`, which is given neither,
    has {ours:.0f} %. The remaining pixels lie on surfaces too small or too dark for their noise.
    """,
    shapes=share["released", "reference-offset"][0][0],
    contacts=with_contacts[0][0],
    low=with_contacts[1][0],
    high=with_contacts[2][0],
    ours=share["released", "surfaces"][0][0],
)
