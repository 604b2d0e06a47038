# %% [markdown]
# # Array sensors and multipath
#
# Section 9 of the paper looks ahead: flood light instead of a scanned spot, an array sensor instead
# of one detector, a telescope that spreads the modulated light. It also hopes that gigahertz
# modulation is robust to multipath by itself. Nothing of this was built there, and nothing is built
# here: this page works both thoughts out on paper and *simulates* them.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of noise and speckle
frequencies: int = 30  # modulation frequencies from 10 MHz to 15 GHz
cells: int = 41  # cells across a wall, at least (odd, so that one lies in the middle)
per_wave: float = 5.0  # cells in a modulation wavelength, at least
pixels: int = 64  # across the array's frame
fine: int = 128  # pixels across the maps of the corner
map_cells: int = 125  # cells across a wall for these maps and the frame
repeats: int = 20  # frames

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown
from matplotlib.ticker import NullLocator, PercentFormatter
from myst_nb import glue
from scipy.optimize import brentq

from cmtof.book import paper, plotting
from cmtof.constants import FREQUENCIES, SPEED_OF_LIGHT
from cmtof.correlation import wrap_length
from cmtof.instrument.budget import PHASES, SAMPLE_RATE, SAMPLES, photon_budget, sent_power
from cmtof.instrument.settings import TwinSettings
from cmtof.ranging.array_sensor import ArrayImager
from cmtof.ranging.corner import Corner
from cmtof.ranging.crystal import LITHIUM_NIOBATE, LITHIUM_TANTALATE
from cmtof.ranging.multipath import (
    Transport,
    band_limit,
    beat_wraps,
    bounces,
    flood,
    mean_path_error,
    range_error,
    spot_ratio,
    spots,
    total,
)

run = plotting.begin(profile=profile, seed=seed)
ALBEDOS = {0.2: "sky", 0.5: "blue", 0.9: "purple"}
ALBEDO = 0.5
MHZ = 100e6  # an ordinary correlation camera
LOW, HIGH = FREQUENCIES
ORDERS = 14  # bounces; what is left of them is 1e-4 of the light even at albedo 0.9
grey = "#5A646D"


def tell(**numbers):
    for name, value in numbers.items():
        glue(name, float(value), display=False)


def say(name, *sentences):
    glue(name, Markdown(" ".join(one for one in sentences if one)), display=False)


def cut(corner, frequency):
    """The corner in cells that are fine enough for a frequency; an odd number of them."""
    number = max(cells, int(np.ceil(per_wave * corner.side * frequency / SPEED_OF_LIGHT)))
    return replace(corner, cells=number + 1 - number % 2)


# %% [markdown]
# ## Light that takes a detour
#
# Under flood light every surface lights every other. What a pixel collects is then a sum of
# phasors: the direct one, and those of all detours, which are longer and so turned further. The
# classic place for it is a concave corner. The model here has two diffuse walls (a V-groove) or
# three (the corner of a room), {glue:text}`side_cm:.0f` cm wide, with the instrument
# {glue:text}`distance:.1f` m before the edge. It is the radiosity equation {cite}`goral1984` with a
# delay on each link,
#
# ```{math}
# :label: eq-multipath-radiosity
# b = e + \rho K b, \qquad K_{ij} = F_{ij}\,e^{-i2\pi f d_{ij}/c},
# ```
#
# where $e$ is the light straight from the instrument, $\rho$ the albedo, $F_{ij}$ the form factor
# between two cells and $d_{ij}$ their distance. The Neumann series $\sum_n\rho^n K^n e$ is the
# light by its number of bounces. Its terms do not know the albedo, so one solution serves all of
# them. The way from a cell to its pixel is the same for direct and indirect light, and the error of
# the range is
#
# $$\delta z = -\frac{c}{4\pi f}\arg\frac{b}{e}.$$
#
# At 15 GHz a wavelength is 2 cm, so cells are millimetres and there are up to
# {glue:text}`cells_most:.0f` of them. Flat walls look the same along their common edge, which makes
# $K$ a convolution along it: no matrix of all cells against all is ever built.

# %%
groove, room = Corner(), Corner(walls=3)
sweep = np.geomspace(1e7, 15e9, frequencies)
NAMES = {"groove": groove, "room": room}


def lit(corner, frequency):
    """Terms of the flood light, all over the direct light."""
    direct = flood(corner, frequency)
    return bounces(Transport(corner, frequency), direct, ORDERS) / direct


middle, typical, strength, typical_strength = ({n: [] for n in NAMES} for _ in range(4))
for name, corner in NAMES.items():
    for f in sweep:
        terms = lit(cut(corner, f), f)
        half = terms.shape[-1] // 2
        ratios = [total(terms, albedo) for albedo in ALBEDOS]
        middle[name].append([range_error(r[0, half, half], f) for r in ratios])
        typical[name].append([np.median(np.abs(range_error(r, f))) for r in ratios])
        own = ratios[list(ALBEDOS).index(ALBEDO)] - 1
        strength[name].append(np.abs(own[0, half, half]))
        typical_strength[name].append(np.median(np.abs(own)))
middle, typical = ({n: np.array(v[n]) for n in NAMES} for v in (middle, typical))
at_rest = {n: np.median(mean_path_error(c, ALBEDO)) for n, c in NAMES.items()}

# %% [markdown]
# Three checks before anything is read from it: the form factor of a long groove has a closed form
# (Hottel's crossed strings, $1-\sin(\alpha/2)$); at low frequency the error must be half the mean
# detour of the light, which follows from the derivative of {eq}`eq-multipath-radiosity` at $f=0$;
# and finer cells must not change the answer.

# %%
long = Corner(cells=24, along=720)
ones = np.zeros(long.shape)
ones[1] = 1
factor = float(Transport(long, 0.0).bounce(ones)[0, :, 360].real.mean())
limit_gap = float(np.max(np.abs(typical["groove"][0, 1] / at_rest["groove"] - 1)))
finest = cut(groove, HIGH).cells


def probed(number, frequency):
    ratio = total(lit(replace(groove, cells=number), frequency), ALBEDO)
    return float(range_error(ratio[0, number // 2, number // 2], frequency))


finer = finest + 2 * (finest // 4)  # half as many again, odd as well
fine_error, finer_error = probed(finest, HIGH), probed(finer, HIGH)
tell(side_cm=100 * groove.side, distance=groove.distance,
     cells_most=3 * cut(room, sweep[-1]).cells**2,
     albedo=ALBEDO, active_mm=1e3 * paper.published("sec9.active_area").value,
     scanned_ms=1e3 * paper.published("sec8.scan_integration_time").value)  # fmt: skip
print(f"form factor {factor:.4f}, in closed form {1 - np.sin(np.pi / 4):.4f}")
print(f"error at 10 MHz against half the mean detour: {100 * limit_gap:.2f} % apart")
print(f"14.32 GHz, middle of a wall: {1e6 * fine_error:.2f} µm with {finest} cells across, "
      f"{1e6 * finer_error:.2f} µm with {finer}")  # fmt: skip

# %% [markdown]
# ## What the camera would see
#
# The room's corner, seen by a camera that stands beside the light, with an albedo of
# {glue:text}`albedo:.1f`:

# %%
viewer = ArrayImager(pixels=fine, half_field=0.4)


def turned(rays):
    """Rays of a camera that looks from the instrument to the apex of a room's corner."""
    ahead = -np.ones(3) / np.sqrt(3)
    right = np.array([-1.0, 1.0, 0.0]) / np.sqrt(2)
    return rays @ np.stack([right, np.cross(ahead, right), ahead])


view = {}
for f in (MHZ, LOW, HIGH):
    walls = replace(room, cells=map_cells)
    reach, _, cell = walls.look(turned(viewer.rays()))
    ratio = total(lit(walls, f), ALBEDO)[tuple(np.moveaxis(cell, -1, 0))]
    view[f] = np.where(np.isfinite(reach), ratio, np.nan)
wrong = np.abs(beat_wraps(view[LOW], view[HIGH], frequencies=FREQUENCIES))
seen = np.isfinite(reach)
share_wrong = float(np.mean(wrong[seen] > 0.5))
maps = {f: range_error(view[f], f) for f in view}
typical_map = {f: float(np.median(np.abs(maps[f][seen]))) for f in maps}

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 3, figsize=(10.4, 6.0))
plotting.image(axes[0, 0], reach, label="range (m)", title="range")
plotting.image(axes[0, 1], np.abs(view[MHZ] - 1), label="over the direct light",
               title="indirect light, 100 MHz")  # fmt: skip
plotting.image(axes[0, 2], np.abs(view[HIGH] - 1), label="over the direct light",
               title="indirect light, 14.32 GHz", limits=(0, 0.1))  # fmt: skip
for ax, (f, scale, unit, most, title) in zip(
    (axes[1, 0], axes[1, 1]),
    ((MHZ, 1e3, "mm", 60, "error, 100 MHz"), (LOW, 1e6, "µm", 100, "error, 7.15 GHz")),
    strict=True,
):
    plotting.image(ax, scale * maps[f], label=f"error ({unit})", title=title, cmap="RdBu_r",
                   limits=(-most, most))  # fmt: skip
plotting.image(axes[1, 2], wrong, label="error of the beat (wraps)", title="beat of both",
               cmap="magma", limits=(0, 3))  # fmt: skip
plotting.label_panels(axes.flat)
plotting.save(
    figure,
    "multipath_corner",
    numbers={
        "median_mhz": typical_map[MHZ], "median_low": typical_map[LOW],
        "median_high": typical_map[HIGH], "wrong_wraps": share_wrong,
    },
    caption=(
        "Corner of a room under flood light, simulated, three diffuse walls of albedo 0.5. "
        "(b, c) Strength of all detours together. (d, e) Error of the range; mind the units. "
        "(f) Error of the beat that the wraps are counted with; beyond half a wrap the count is "
        "wrong without any noise."
    ),
    alt=(
        "Six images of a three-sided corner. At 100 megahertz the indirect light is spread "
        f"smoothly and the median error is {1e3 * typical_map[MHZ]:.0f} millimetres, of one sign. "
        "At 7.15 gigahertz fine rings of both signs are left, with a median of "
        f"{1e6 * typical_map[LOW]:.0f} micrometres, strongest along the three edges. The beat is "
        f"off by more than half a wrap in {100 * share_wrong:.0f} percent of the pixels."
    ),
    format="png",
)  # fmt: skip
tell(mhz_mm=1e3 * typical_map[MHZ], low_um=1e6 * typical_map[LOW],
     high_um=1e6 * typical_map[HIGH])  # fmt: skip

# %% [markdown]
# At 100 MHz all detours lie within a fraction of a wavelength of each other, their phasors add up,
# and the whole corner is rounded off by {glue:text}`mhz_mm:.0f` mm (median). At 7.15 GHz they point
# everywhere and cancel: {glue:text}`low_um:.0f` µm are left, and {glue:text}`high_um:.1f` µm at
# 14.32 GHz. Near an edge there is always a strip, about a wavelength wide, where detours are too
# short to cancel.
#
# ## Where the band ends
#
# Nothing in {eq}`eq-multipath-radiosity` has a length but the wavelength and the corner itself. So
# the light's phase depends on $fL/c$ alone, errors grow with the corner's size $L$ at fixed
# $fL/c$, and the band limit of {cite:t}`gupta2015` must be a pure number $\kappa$:
#
# $$f_\mathrm{band} = \kappa\,\frac{c}{L}.$$

# %%
limits = {n: band_limit(sweep, typical_strength[n]) for n in NAMES}
kappa = {n: limits[n] * NAMES[n].side / SPEED_OF_LIGHT for n in NAMES}
far_off = sweep > 3e9
falls = {n: np.polyfit(np.log(sweep[far_off]), np.log(typical[n][far_off, 1]), 1)[0] for n in NAMES}
angles = np.deg2rad([40, 60, 75, 90, 105, 120, 135, 150])
opened = {f: [] for f in (MHZ, LOW)}
for f in opened:
    for angle in angles:
        ratio = total(lit(cut(Corner(angle=float(angle)), f), f), ALBEDO)
        opened[f].append(float(np.median(np.abs(range_error(ratio, f)))))

# %% [markdown]
# ## A scanned spot
#
# The prototype lights one spot and its detector looks at little more than that spot
# ({glue:text}`field_mrad:.0f` mrad, as in {doc}`13_instrument`). Light that left the spot for
# another wall has to come back into this small field of view, and from a flat wall that takes three
# reflections. Here the lit cell moves from the edge outwards, and the same bounces are followed.

# %%
twin = TwinSettings()
field = twin.optics.field_of_view
scanned, flooded, places = {}, {}, {}
for f in (MHZ, LOW):
    walls = cut(groove, f)
    at = np.unique(np.geomspace(1, walls.cells, 14).astype(int)) - 1
    spot_cells = np.array([(0, i, walls.cells // 2) for i in at])
    transport = Transport(walls, f)
    terms = bounces(transport, spots(walls, f, spot_cells), 8)
    ratio = spot_ratio(walls, terms, ALBEDO, f, spot_cells, field)
    whole = total(bounces(transport, flood(walls, f), ORDERS), ALBEDO) / flood(walls, f)
    places[f] = (at + 0.5) * walls.cell
    scanned[f], flooded[f] = ratio, whole[0, at, walls.cells // 2]
kept = {f: np.abs(scanned[f] - 1) / np.abs(flooded[f] - 1) for f in scanned}
beyond = {f: places[f] > 1.2 * field * groove.distance for f in places}
weaker = {f: float(np.median(1 / kept[f][beyond[f]])) for f in kept}
left = {f: float(np.max(np.abs(range_error(scanned[f][beyond[f]], f)))) for f in kept}

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 2, figsize=(10.4, 7.6))
for (albedo, colour), column in zip(ALBEDOS.items(), range(3), strict=True):
    for name, style in (("groove", "-"), ("room", "--")):
        label = f"ρ = {albedo}" if name == "groove" else None
        axes[0, 0].loglog(sweep, typical[name][:, column], style, color=plotting.PALETTE[colour],
                          label=label)  # fmt: skip
for f in (MHZ, LOW, HIGH):
    axes[0, 0].axvline(f, color="#8A97A3", lw=1, ls=":")
axes[0, 0].plot([], [], "--", color=grey, label="room corner")
axes[0, 0].set(xlabel="modulation frequency (Hz)", ylabel="median error (m)",
               title="flood light", ylim=(5e-7, 0.3))  # fmt: skip
axes[0, 0].legend(loc="lower left", fontsize=9)
for name, style, colour in (("groove", "-", "blue"), ("room", "--", "vermillion")):
    line = np.array(typical_strength[name])
    axes[0, 1].loglog(sweep * NAMES[name].side / SPEED_OF_LIGHT, line, style,
                      color=plotting.PALETTE[colour], label=f"{name}, ρ = {ALBEDO}")  # fmt: skip
    axes[0, 1].plot(kappa[name], line[0] / 10, "o", color=plotting.PALETTE[colour])
axes[0, 1].plot([], [], "o", color=grey, label="band limit: a tenth")
axes[0, 1].set(xlabel="size over wavelength, fL/c", ylabel="indirect over direct light",
               title="where phasors cancel")  # fmt: skip
axes[0, 1].legend(loc="lower left", fontsize=9)
for f, colour, text in ((MHZ, "orange", "100 MHz"), (LOW, "blue", "7.15 GHz")):
    axes[1, 0].loglog(100 * places[f], np.abs(flooded[f] - 1), "-", marker=".",
                      color=plotting.PALETTE[colour], label=f"flood, {text}")  # fmt: skip
    axes[1, 0].loglog(100 * places[f], np.abs(scanned[f] - 1), "--", marker=".",
                      color=plotting.PALETTE[colour], label=f"spot, {text}")  # fmt: skip
axes[1, 0].axvspan(0.1, 100 * field * groove.distance / 2, color="#8A97A3", alpha=0.2, lw=0)
axes[1, 0].set(xlabel="distance from the edge (cm)", ylabel="indirect over direct light",
               title="flood against spot", ylim=(1e-10, 3), xlim=(0.3, 50))  # fmt: skip
axes[1, 0].legend(loc="lower left", fontsize=9)
for f, colour, text in ((MHZ, "orange", "100 MHz"), (LOW, "blue", "7.15 GHz")):
    axes[1, 1].semilogy(np.rad2deg(angles), opened[f], "-o", ms=4,
                        color=plotting.PALETTE[colour], label=text)  # fmt: skip
axes[1, 1].set(xlabel="angle of the groove (°)", ylabel="median error (m)",
               title="the groove opens", ylim=(1e-8, 0.3))  # fmt: skip
axes[1, 1].set_xticks([40, 60, 90, 120, 150])
axes[1, 1].legend(loc="center right", fontsize=9)
for ax in axes.flat:  # minor ticks of logarithmic axes take longest to draw
    ax.yaxis.set_minor_locator(NullLocator())
    ax.xaxis.set_minor_locator(NullLocator())
plotting.label_panels(axes.flat)
row = int(np.argmin(np.abs(sweep - MHZ)))
plotting.save(
    figure,
    "multipath_frequency",
    numbers={
        "kappa": list(kappa.values()), "slope": list(falls.values()),
        "spot_weaker": list(weaker.values()), "rest": list(at_rest.values()),
    },
    caption=(
        "Multipath against frequency, simulated. (a) Median error over the walls; dotted lines "
        "stand at 100 MHz, 7.15 and 14.32 GHz. (b) Strength of the indirect light against the size "
        "of the corner in wavelengths. (c) Indirect light along a wall of the groove, flood and "
        "spot; in the grey strip the detector sees over the edge. (d) Median error against the "
        "angle of the groove, ρ = 0.5."
    ),
    alt=(
        "Four plots. The error stays flat up to 100 megahertz, at centimetres, then falls steeply, "
        f"about as frequency to the power {falls['groove']:.1f}, to micrometres at 15 gigahertz. "
        f"Indirect light falls to a tenth at {kappa['groove']:.1f} wavelengths in the groove. A "
        f"scanned spot has {weaker[MHZ]:.0f} times less of it than flood light, away from the "
        "edge. The error falls as the groove opens."
    ),
)  # fmt: skip
tell(kappa_groove=kappa["groove"], kappa_room=kappa["room"], slope=falls["groove"],
     band_ghz=limits["groove"] / 1e9, rest_mm=1e3 * at_rest["groove"], field_mrad=1e3 * field,
     share_rest=100 * at_rest["groove"] / groove.side,
     one_m=kappa["groove"] * SPEED_OF_LIGHT / 5.0 / 1e6,
     clear_cm=120 * field * groove.distance, spot_mhz=weaker[MHZ], left_mhz=1e6 * left[MHZ],
     left_low=1e6 * left[LOW],
     hand=kappa["groove"] * SPEED_OF_LIGHT / 0.05 / 1e9)  # fmt: skip
low_kept = float(
    np.median(typical["groove"][np.argmin(np.abs(sweep - LOW)), 1]) / at_rest["groove"]
)
say("band_says",
    f"The hope of Section 9 holds for the *range*: at 7.15 GHz the median error in the groove is "
    f"{100 * low_kept:.2f} % of that at low frequency." if low_kept < 0.01 else
    f"At 7.15 GHz the median error is still {100 * low_kept:.1f} % of that at low frequency: the "
    "hope of Section 9 holds only in part.")  # fmt: skip
say("beat_says",
    f"It does not hold for the *wraps*. The two frequencies are unwrapped by their beat at "
    f"{(HIGH - 2 * LOW) / 1e6:.0f} MHz, in which one wrap is "
    f"{2e3 * np.pi * (HIGH - 2 * LOW) / LOW:.1f} mrad; residual detours of a "
    f"few milliradians at either frequency put {100 * share_wrong:.0f} % of the room corner's "
    "pixels into the wrong wrap, however bright the light." if share_wrong > 0.05 else
    f"The beat of the two survives it too: only {100 * share_wrong:.1f} % of the pixels change "
    "their wrap.")  # fmt: skip

# %% [markdown]
# The light that comes by detours falls to a tenth at $\kappa$ = {glue:text}`kappa_groove:.1f`
# (groove) and {glue:text}`kappa_room:.1f` (room), typical pixels counted. For this corner that is
# {glue:text}`band_ghz:.1f` GHz; a corner of 5 m ends its band at {glue:text}`one_m:.0f` MHz, one of
# 5 cm at {glue:text}`hand:.0f` GHz. What counts is not gigahertz but wavelengths: below the band, a
# groove of any size is off by {glue:text}`share_rest:.1f` % of its width (median), and small ones
# stay there longest. Beyond the band the error falls with the power {glue:text}`slope:.1f` of the
# frequency: the phasors' sum and the depth of a radian both shrink.
#
# ```{glue:md} band_says
# :format: myst
# ```
#
# ```{glue:md} beat_says
# :format: myst
# ```
#
# A scanned spot is another matter. The paper says that scanning «naturally suppresses» multipath:
# from {glue:text}`clear_cm:.0f` cm off the edge the indirect light of a spot is
# {glue:text}`spot_mhz:.0f` times weaker (median) at 100 MHz than under flood light, and leaves at
# most {glue:text}`left_mhz:.0f` µm there and {glue:text}`left_low:.3f` µm at 7.15 GHz. The claim
# holds, and it is the geometry that does it, at any frequency. Within the field of view of the edge
# it fails: there the detector sees the other wall. (Specular walls, which send much light on one
# path, are not in this model.)
#
# ## What fits through the crystal
#
# Now the array. The emitted light is one mode of a fibre; behind its modulator it can be spread at
# will. The returned light is the problem. All of it must pass the detection's crystal, whose active
# area measures {glue:text}`active_mm:.1f` mm a side. A telescope makes the beam wider *or* its
# angles wider, never both: area times solid angle, the étendue, stays. With $s$ the sine of the
# largest usable angle in the crystal, $a$ its aperture, $D$ the pupil towards the scene and
# $\theta_F$ half the field of view,
#
# ```{math}
# :label: eq-array-etendue
# a\,s = D\,\sin\theta_F, \qquad N = \frac{a^2 (2s)^2}{\lambda^2}.
# ```
#
# $N$ is the number of points that diffraction lets anyone tell apart. What bounds $s$?
#
# **Retardance.** A birefringent crystal turns the polarisation even without a drive, in LiNbO₃ by
# {glue:text}`turns:.0f` waves in {glue:text}`length_mm:.0f` mm. The bias is set for one angle; at
# others the retardance differs, by a saddle of second order. A change Γ costs cos 2Γ of the
# amplitude; {glue:text}`tolerance:.1f` rad at the rim are allowed here.
#
# **The second pass.** The mirror stands half a modulation wavelength behind the crystal
# ({glue:text}`mirror_mm:.0f` mm). Slanted light comes back beside the aperture.
#
# **Timing.** The drive turns while light passes: over {glue:text}`length_mm:.0f` mm the retardance
# keeps {glue:text}`transit:.2f` of its size. Slanted light passes later. The closed forms of the
# two modes with both effects are tested against the full Jones model of
# {doc}`04_two_pass_modulator`.
#
# The paper does not say which crystal it uses, nor how long it is. Two materials are taken here,
# {glue:text}`length_mm:.0f` mm long (assumed).

# %%
imagers = {
    "LiNbO₃": ArrayImager(pixels=pixels, crystal=LITHIUM_NIOBATE),
    "LiTaO₃": ArrayImager(pixels=pixels, crystal=LITHIUM_TANTALATE),
}
array = imagers["LiNbO₃"]
wavelength = array.twin.laser.wavelength
budget = {line.name: line.value for line in photon_budget(array.twin, distance=1.0)}
point_time = PHASES * SAMPLES / SAMPLE_RATE
noise = budget["Phase noise of a point"]
megapixel = 1e6
counts = np.geomspace(10, 3000, 60).astype(int)


def time_of(imager, number, watts=None, distance=1.0):
    """Time of a frame of `number` pixels across with the phase noise of a scanned point, s."""
    brightness = watts / sent_power(imager.twin, imager.mode) if watts else 1.0
    one = replace(imager, pixels=int(number), brightness=brightness)
    return float(one.time_for(one.electrons(distance), noise))


frame_time = {name: [time_of(i, n) for n in counts] for name, i in imagers.items()}
strong_time = [time_of(array, n, watts=1.0) for n in counts]
scan_time = counts**2 * point_time
most = {name: np.sqrt(i.resolvable) for name, i in imagers.items()}
here = time_of(array, pixels)
pupil_loss = (np.pi * array.twin.optics.aperture**2 / 4) / array.pupil**2
need = brentq(lambda w: np.log(time_of(array, most["LiNbO₃"], np.exp(w))), -7, 14)
lengths = np.geomspace(0.5e-3, 30e-3, 80)
rim = np.linspace(0, array.acceptance, 80)

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 2, figsize=(10.4, 8.0))
reach_mrad = 40.0
line = np.linspace(-reach_mrad, reach_mrad, 161)
x, z = np.meshgrid(1e-3 * line, 1e-3 * line)
change = array.crystal.retardance(x, z, wavelength) - array.crystal.retardance(0, 0, wavelength)
ax = axes[0, 0]
drawn = ax.pcolormesh(line, line, change, cmap="RdBu_r", vmin=-0.8, vmax=0.8, shading="auto",
                      rasterized=True)  # fmt: skip
figure.colorbar(drawn, ax=ax, label="change of retardance (rad)")
ax.contour(line, line, np.abs(change), levels=[array.tolerance], colors="black", linewidths=1)
open_share = array.unvignetted(x, z)
inked = ax.contour(line, line, open_share, levels=[0.25, 0.5, 0.75], colors=grey, linewidths=1,
                   linestyles="--")  # fmt: skip
ax.clabel(inked, fmt=lambda v: f"{100 * v:.0f} %", fontsize=8)
s = 1e3 * array.acceptance
ax.plot([-s, s, s, -s, -s], [-s, -s, s, s, -s], color=plotting.PALETTE["orange"], lw=2)
ax.set(xlabel="angle across the optic axis (mrad)", ylabel="angle along it (mrad)",
       title="LiNbO₃, one pass", aspect="equal")  # fmt: skip
ax.grid(visible=False)
ax = axes[0, 1]
for (name, imager), colour in zip(imagers.items(), ("blue", "vermillion"), strict=True):
    number = [replace(imager, crystal=replace(imager.crystal, length=float(v))).resolvable
              for v in lengths]  # fmt: skip
    ax.loglog(1e3 * lengths, number, color=plotting.PALETTE[colour], label=name)
    ax.plot(1e3 * imager.crystal.length, imager.resolvable, "o", color=plotting.PALETTE[colour])
for n, text in ((64, "64 × 64"), (256, "256 × 256"), (1000, "a megapixel")):
    ax.axhline(n**2, color="#8A97A3", lw=1, ls=":")
    ax.text(31, 1.08 * n**2, text, color=grey, fontsize=9, ha="right")
ax.set(xlabel="length of the crystal (mm)", ylabel="resolvable points N", ylim=(1.5e3, 3e6),
       title="points through 2.5 × 2.5 mm")  # fmt: skip
ax.legend(loc="lower left", fontsize=9)
ax = axes[1, 0]
ax.loglog(counts, scan_time, color=plotting.PALETTE["black"], label="scanned, 3 mW")
for name, colour in (("LiNbO₃", "blue"), ("LiTaO₃", "vermillion")):
    inside = counts <= most[name]
    ax.loglog(counts[inside], np.array(frame_time[name])[inside], color=plotting.PALETTE[colour],
              label=f"array, {name}, 3 mW")  # fmt: skip
inside = counts <= most["LiNbO₃"]
ax.loglog(counts[inside], np.array(strong_time)[inside], "--", color=plotting.PALETTE["blue"],
          label="array, LiNbO₃, 1 W")  # fmt: skip
ax.set(xlabel="pixels across", ylabel="time of a frame (s)", title="same precision, at 1 m")
ax.legend(loc="upper left", fontsize=9)
ax.set_ylim(1e-2, 1e8)
ax = axes[1, 1]
ax.plot(1e3 * rim, 1e6 * array.field_error(rim, 0), color=plotting.PALETTE["blue"],
        label="late gate: error of the range")  # fmt: skip
ax.set(xlabel="angle (mrad)", ylabel="error unless calibrated (µm)", title="over the field, LiNbO₃")
twin_ax = ax.twinx()
twin_ax.grid(visible=False)
rates = array.electrons(1.0, across=rim)
twin_ax.plot(1e3 * rim, rates.amplitude / rates.amplitude[0], "--",
             color=plotting.PALETTE["vermillion"], label="amplitude")  # fmt: skip
twin_ax.set_ylim(0, 1.05)
twin_ax.set_ylabel("amplitude")
twin_ax.yaxis.set_major_formatter(PercentFormatter(1.0))
entries = (one.get_legend_handles_labels() for one in (ax, twin_ax))
ax.legend(*(a + b for a, b in zip(*entries, strict=True)), loc="center left", fontsize=9)
for ax in (axes[0, 1], axes[1, 0]):
    ax.yaxis.set_minor_locator(NullLocator())
    ax.xaxis.set_minor_locator(NullLocator())
plotting.label_panels(axes.flat)
edge_um = 1e6 * float(array.field_error(array.acceptance, array.acceptance))
plotting.save(
    figure,
    "array_etendue",
    numbers={
        "acceptance": [i.acceptance for i in imagers.values()],
        "resolvable": [i.resolvable for i in imagers.values()],
        "pupil": array.pupil, "frame_time": here, "scan_time": pixels**2 * point_time,
        "watts_for_a_second": float(np.exp(need)),
    },
    caption=(
        "What an array gets through the modulator, computed. (a) Change of a pass's static "
        "retardance with angle (black: the tolerance), light left after both passes (dashed), the "
        "field used (orange). (b) Points that diffraction tells apart; dots mark 5 mm. (c) "
        "Time of a frame with the phase noise of one scanned point; lines end where the crystal's "
        "points do. (d) Along one axis of the field."
    ),
    alt=(
        "Four plots. The retardance changes as a saddle; a square of plus or minus "
        f"{1e3 * array.acceptance:.0f} milliradians keeps to the tolerance. At 5 millimetres "
        f"lithium niobate passes {array.resolvable:.0f} points and lithium tantalate "
        f"{imagers['LiTaO₃'].resolvable:.0f}, both short of a megapixel. At equal precision and 3 "
        f"milliwatts the array takes {here / (pixels**2 * point_time):.0f} times as long as the "
        f"scan at {pixels} by {pixels} pixels. At the rim of the field the range is off by a few "
        "micrometres and the amplitude about half."
    ),
)  # fmt: skip
tell(turns=abs(float(array.crystal.retardance(0, 0, wavelength))) / (2 * np.pi),
     length_mm=1e3 * array.crystal.length, tolerance=array.tolerance,
     mirror_mm=1e3 * array.twin.detection.mirror_distance, transit=array.crystal.transit(LOW),
     accept=1e3 * array.acceptance,
     points_ln=array.resolvable / 1e3, points_lt=imagers["LiTaO₃"].resolvable / 1e3,
     side_ln=most["LiNbO₃"], pupil_mm=1e3 * array.pupil,
     half_deg=np.rad2deg(array.half_field), pupil_loss=pupil_loss, edge_um=edge_um,
     scan_hours=megapixel * paper.published("sec8.scan_integration_time").value / 3600,
     noise_mrad=1e3 * noise,
     noise_um=1e6 * noise * wrap_length(LOW) / (2 * np.pi), aperture=1e3 * twin.optics.aperture,
     cap_time=time_of(array, most["LiNbO₃"]) / 3600, cap_watts=float(np.exp(need)),
     cap_scan=array.resolvable * point_time,
     weaker_by=abs(LITHIUM_NIOBATE.extraordinary - LITHIUM_NIOBATE.ordinary)
     / abs(LITHIUM_TANTALATE.extraordinary - LITHIUM_TANTALATE.ordinary))  # fmt: skip

# %% [markdown]
# Of LiNbO₃ the field of ±{glue:text}`accept:.0f` mrad keeps to the tolerance, which makes
# {glue:text}`points_ln:.0f` thousand points or {glue:text}`side_ln:.0f` × {glue:text}`side_ln:.0f`.
# LiTaO₃, with {glue:text}`weaker_by:.0f` times less birefringence, is limited by its aperture on
# the second pass: {glue:text}`points_lt:.0f` thousand, with its rim in the dark. A megapixel goes
# through neither. In LiNbO₃ points grow as aperture squared over length; a shorter crystal
# modulates less.
#
# Worse is the light. For a field of ±{glue:text}`half_deg:.0f`° the étendue allows a pupil of
# {glue:text}`pupil_mm:.2f` mm, where the scanner collects through {glue:text}`aperture:.1f` mm in
# every direction, {glue:text}`pupil_loss:.0f` times the area. Flood light and scan send the same
# photons for a frame; what matters is how many come back. For the noise of one scanned point,
# {glue:text}`noise_mrad:.1f` mrad or {glue:text}`noise_um:.1f` µm,

# %%
say("time_says",
    f"| {pixels} × {pixels} points at 1 m | time |\n| :-- | --: |\n"
    f"| scanned, 3 mW | {pixels**2 * point_time:.0f} s |\n"
    f"| array, LiNbO₃, 3 mW | {here:.0f} s |\n"
    f"| array, LiTaO₃, 3 mW | {time_of(imagers['LiTaO₃'], pixels):.0f} s |\n"
    f"| array, LiNbO₃, 1 W | {time_of(array, pixels, 1.0):.1f} s |")  # fmt: skip
say("verdict_says",
    "So the array is *slower* than the scanner at the same power, and wins only by power: a watt "
    "that is spread over a field is easier to make safe than a watt in a beam."
    if here > pixels**2 * point_time else
    "So the array is faster than the scanner even at the same power.")  # fmt: skip

# %% [markdown]
# ```{glue:md} time_says
# :format: myst
# ```
#
# ```{glue:md} verdict_says
# :format: myst
# ```
#
# A megapixel scanned at {glue:text}`scanned_ms:.0f` ms a point takes {glue:text}`scan_hours:.1f`
# hours. The most that the array can show, {glue:text}`side_ln:.0f` × {glue:text}`side_ln:.0f`,
# takes the scanner {glue:text}`cap_scan:.0f` s and the array {glue:text}`cap_time:.1f` hours at 3
# mW; a frame a second of that precision would need {glue:text}`cap_watts:.0f` W. The way out is a
# larger crystal, or one without birefringence along the light. The gate's delay over the field, at
# most {glue:text}`edge_um:.1f` µm of range, is a constant of each pixel and calibrates away.
#
# ## A frame
#
# One instrument with both: flood light in the corner of the room, the array behind LiNbO₃, for the
# time that a scan of as many points takes. Each pixel draws photons, read noise and rounding of a
# CMOS sensor like the paper's stereo cameras', and speckle of {glue:text}`modes:.1f` modes. The
# wrap is taken as known, and a pixel sees the detours of its centre.

# %%
frame_seconds = pixels**2 * point_time
walls = replace(room, cells=map_cells)
reach, facing, cell = walls.look(turned(array.rays()))
detour = total(lit(walls, LOW), ALBEDO)[tuple(np.moveaxis(cell, -1, 0))]
scene = {"cosine": facing, "reflectance": ALBEDO, "time": frame_seconds, "repeats": repeats}
alone = array.frames(reach, seed=seed, **scene)
both = array.frames(reach, ratio=detour, seed=seed, **scene)
detour_error = range_error(detour, LOW)
rms = float(np.sqrt(np.mean(alone.error**2)))
foretold = float(np.sqrt(np.mean(alone.bound**2)))

# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 2, figsize=(9.0, 7.0))
plotting.image(axes[0, 0], reach, label="range (m)", title="corner, in the field")
plotting.image(axes[0, 1], alone.electrons[0], label="electrons", title="mean of a phase")
most_um = float(4 * 1e6 * foretold)
plotting.image(axes[1, 0], 1e6 * both.error[0], label="error (µm)", title="one frame",
               cmap="RdBu_r", limits=(-most_um, most_um))  # fmt: skip
plotting.image(axes[1, 1], 1e6 * detour_error, label="error (µm)", title="its multipath alone",
               cmap="RdBu_r", limits=(-most_um, most_um))  # fmt: skip
plotting.label_panels(axes.flat)
plotting.save(
    figure,
    "array_frame",
    numbers={"rms": rms, "bound": foretold, "multipath": float(np.median(np.abs(detour_error))),
             "electrons": float(np.median(alone.electrons))},
    caption=(
        "A frame of the array in flood light, simulated: (a) range, (b) electrons of a phase, with "
        "speckle and vignetting, (c) error with noise and multipath at 7.15 GHz, (d) the part of "
        "it that is multipath."
    ),
    alt=(
        f"Four images of {pixels} by {pixels} pixels of a corner. The electrons fall from the "
        f"middle to the rim. The error is noise of {1e6 * rms:.0f} micrometres rms that grows "
        "towards the rim. The multipath within it makes rings of a few tens of micrometres around "
        "the apex and along the three edges."
    ),
    format="png",
)  # fmt: skip
tell(modes=array.speckle_cells, frame_seconds=frame_seconds, rms_um=1e6 * rms,
     over=rms / foretold, electrons=float(np.median(alone.electrons)))  # fmt: skip
say("frame_says",
    f"Multipath, {1e6 * np.median(np.abs(detour_error)):.0f} µm in the median, hides below the "
    "noise of one frame; it would show in an average, for it does not change from frame to frame."
    if np.median(np.abs(detour_error)) < rms else
    f"Multipath, {1e6 * np.median(np.abs(detour_error)):.0f} µm in the median, exceeds the noise "
    "of one frame.")  # fmt: skip

# %% [markdown]
# In {glue:text}`frame_seconds:.0f` s a phase collects {glue:text}`electrons:.0f` electrons in a
# typical pixel. The error without detours is {glue:text}`rms_um:.0f` µm rms over
# {glue:text}`frames:.0f` frames, {glue:text}`over:.2f` times the Cramér–Rao bound: decoding weighs
# all phases alike, though the bright ones are noisier.
#
# ```{glue:md} frame_says
# :format: myst
# ```
#
# ## Against the paper

# %%
tell(frames=repeats)
paper.check("sec9.active_area", array.side)
paper.check("sec8.scan_integration_time", point_time)
