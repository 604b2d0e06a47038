# %% [markdown]
# # The two-pass modulator
#
# A resonant electro-optic modulator only shifts phases. This page derives, matrix by matrix, how
# two passes through it and four passive elements turn that into intensity modulation (Section 6.2,
# equations {eq}`eq-10` to {eq}`eq-18`), and regenerates Fig. 7 with the polarisation drawn in. Each
# printed equation is proved beside its statement: what is left over after SymPy has simplified
# *ours minus theirs* is printed, and must be 0.

# %% tags=["parameters"]
profile: str = "book"  # size profile
seed: int = 0  # of random draws; none here
eta: float = 0.26  # drive amplitude in one pass, rad; 50 % contrast in the single mode
points: int = 81  # settings along each axis of the tolerance figure

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import sympy as sp
from matplotlib.patches import ConnectionPatch
from myst_nb import glue

from cmtof import light_path
from cmtof.book import paper, plotting
from cmtof.constants import SPEED_OF_LIGHT
from cmtof.modulator import DOUBLED, SINGLE

paper_run = plotting.begin(profile=profile, seed=seed)
blue, vermillion = plotting.PALETTE["blue"], plotting.PALETTE["vermillion"]

# %% [markdown]
# ## Vectors, matrices, and one tool to prove with
#
# A Jones vector holds the complex amplitudes of the horizontal and the vertical field
# {cite}`jones1941`; an element is a 2×2 matrix. Every retarder is the diagonal matrix of its two
# phases, turned by its angle. The function `residual` rewrites an expression in exponentials,
# expands and simplifies: it returns 0 for an identity.

# %%
V, eta_s, theta, theta_h, theta_q, static = sp.symbols(
    "V eta theta theta_h theta_q Gamma", real=True
)


def retarder(retardance, angle):
    turn = sp.Matrix([[sp.cos(angle), -sp.sin(angle)], [sp.sin(angle), sp.cos(angle)]])
    phases = sp.diag(sp.exp(-sp.I * retardance / 2), sp.exp(sp.I * retardance / 2))
    return turn * phases * turn.T


def powers(expression):
    return sp.expand(sp.expand(expression).rewrite(sp.exp))


def residual(expression):
    return sp.simplify(sp.expand(powers(expression).rewrite(sp.cos)))


# %% [markdown]
# **The modulator.** The crystal's axes lie horizontal and vertical; the voltage V, measured as the
# retardance that it causes, is shared between them:
#
# ```{math}
# :label: eq-10
# B(V) = \begin{bmatrix} e^{-iV/2} & 0\\ 0 & e^{iV/2} \end{bmatrix}, \qquad
# V = \eta\cos(\omega t-\phi)
# ```
#
# It is a retarder at angle zero. (The paper drives with a cosine here and with a sine in
# {eq}`eq-16`. We keep the sine: a quarter period of time lies between them.)


# %%
def modulator_matrix(voltage):
    return sp.diag(sp.exp(-sp.I * voltage / 2), sp.exp(sp.I * voltage / 2))


print("Eq. 10, residual:", residual((modulator_matrix(V) - retarder(V, 0)).norm() ** 2))

# %% [markdown]
# **The way out.** The splitter leaves vertical light, which meets the half-wave plate, the
# quarter-wave plate and the modulator:
#
# ```{math}
# :label: eq-11
# E_0 = A\begin{bmatrix}0\\1\end{bmatrix}
# ```
#
# ```{math}
# :label: eq-12
# E_1 = B(V)\,Q(\theta_q)\,H(\theta_h)\,E_0
# ```
#
# **The mirror** sends it back. Seen from the returning light the horizontal axis has changed sides,
# hence the minus, and hence also the opposite angles of the plates on the way back:
#
# ```{math}
# :label: eq-13
# E_2 = M E_1, \qquad M = \begin{bmatrix} 1 & 0\\ 0 & -1 \end{bmatrix}
# ```

# %%
half, quarter, mirror = sp.pi, sp.pi / 2, sp.diag(1, -1)
E0 = sp.Matrix([0, 1])
E1 = modulator_matrix(V) * retarder(quarter, theta_q) * retarder(half, theta_h) * E0
E2 = mirror * E1
lossless = residual((E2.H * E2)[0] - 1)
print("Eq. 11-13: |E_2|² − |E_0|², residual for any plate angles:", lossless)

# %% [markdown]
# **The way back** passes the same elements in the opposite order, and $L_h$ keeps the horizontal
# part. With $\theta_q = 45°$ this is, for *any* half-wave plate angle, one cosine:
# $E_3 = -iA\cos(4\theta_h + V)$. Everything below follows from that line.

# %%
back = retarder(half, -theta_h) * retarder(quarter, -theta_q) * modulator_matrix(V)
any_plates = powers((back * E2)[0])
field = powers(any_plates.subs(theta_q, sp.pi / 4))
print("E_3 = −i cos(4θ_h + V), residual:", residual(field + sp.I * sp.cos(4 * theta_h + V)))

# %% [markdown]
# **The single mode**, $\theta_h = 11.25°$, $\theta_q = 45°$. The paper prints both angles as
# $\theta_q$; the first is the half-wave plate's.
#
# ```{math}
# :label: eq-14
# \begin{aligned}
# E_3 &= L_h H(-\theta_h) Q(-\theta_q) B(V) M B(V) Q(\theta_q) H(\theta_h) E_0\\
#     &= A\begin{bmatrix} \frac{i(\cos V-\sin V)}{\sqrt2}\\ 0\end{bmatrix}
# \end{aligned}
# ```
#
# ```{math}
# :label: eq-15
# I(V) = |E_3|^2 = \frac{A^2}{2}(1-\sin 2V)
# ```

# %%
single = field.subs(theta_h, sp.pi / 16)
printed = sp.I * (sp.cos(V) - sp.sin(V)) / sp.sqrt(2)
I_single = (1 - sp.sin(2 * V)) / 2
eq14, eq15 = residual(single + printed), residual(single * sp.conjugate(single) - I_single)
print("Eq. 14, residual (common phase −1):", eq14)
print("Eq. 15, residual:", eq15)

# %% [markdown]
# With the drive put in, and expanded for a weak one:
#
# ```{math}
# :label: eq-16
# \begin{aligned}
# I(t) &= \frac{A^2}{2}\bigl(1-\sin(2\eta\sin(\omega t-\phi))\bigr)\\
#      &\approx \frac{A^2}{2}\bigl(1-2\eta\sin(\omega t-\phi)\bigr)
# \end{aligned}
# ```

# %%
driven = I_single.subs(V, eta_s * sp.sin(theta))
taylor = sp.series(driven, eta_s, 0, 2).removeO()
eq16 = residual(taylor - (1 - 2 * eta_s * sp.sin(theta)) / 2)
print("Eq. 16, first order in η, residual:", eq16)
print("next term:", sp.series(driven - taylor, eta_s, 0, 4).removeO())

# %% [markdown]
# **The doubled mode**, $\theta_h = 22.5°$. Turning one plate by 11.25° moves the bias by a quarter
# period of the transfer curve, from its steepest point into its dark minimum:
#
# ```{math}
# :label: eq-17
# E_3 = A\begin{bmatrix} -i\sin V\\ 0\end{bmatrix}
# ```
#
# ```{math}
# :label: eq-18
# I(V) = |E_3|^2 = \frac{A^2}{2}(1-\cos 2V)
# ```

# %%
doubled = field.subs(theta_h, sp.pi / 8)
I_doubled = (1 - sp.cos(2 * V)) / 2
eq17, eq18 = (
    residual(doubled - sp.I * sp.sin(V)),
    residual(doubled * sp.conjugate(doubled) - I_doubled),
)
print("Eq. 17, residual (common phase −1):", eq17)
print("Eq. 18, residual:", eq18)
print("all hold:", [eq14, eq15, eq16, eq17, eq18] == [0] * 5)

# %% [markdown]
# ## Where the text slips, and what does not matter
#
# - *Two angles called $\theta_q$.* Were the quarter-wave plate at 11.25°, no setting of the
#   half-wave plate would reach the slope of {eq}`eq-15`, which is A² per radian.
# - *Vertical or horizontal.* Section 6.2.1 sends vertical light in and picks up the vertical, but
#   {eq}`eq-14` keeps the horizontal; Section 7.1 sends horizontal light in. In and out must be
#   crossed, but which is which makes no difference: the off-diagonal elements of a unitary matrix
#   have equal magnitude. The *same* port gives the complement, $1 - I$: another sign in the single
#   mode, a bright ground in the doubled one.

# %%
phases = np.linspace(0, 2 * np.pi, 1000)
literal = replace(SINGLE, quarter_wave_angle=np.pi / 16)
plates = [replace(literal, half_wave_angle=a) for a in np.linspace(0, np.pi / 2, points)]
slope = max(abs(np.diff(m.transmission([-1e-4, 1e-4]))[0]) / 2e-4 for m in plates)
swap = np.ptp(replace(SINGLE, input_axis="horizontal").waveform(phases) - SINGLE.waveform(phases))
other = np.ptp(replace(SINGLE, output="returned").waveform(phases) + SINGLE.waveform(phases))
print(f"θ_q = 11.25°: dI/dV is at most {slope:.2f} A² per rad for any half-wave plate angle")
print(f"horizontal for vertical changes {swap:.0e} A²; the ports' sum varies by {other:.0e} A²")

# %% [markdown]
# ## A gift: the half-wave plate is the bias knob
#
# The line $E_3 = -iA\cos(4\theta_h+V)$ holds for any plate angle, so a static birefringence
# $\Gamma$ of the crystal, which adds to V, is cancelled by turning the half-wave plate by
# $-\Gamma/4$. No bias voltage is needed, and one degree of the plate is eight of bias.

# %%
biased = powers(field.subs(V, V + static))
law = (1 + sp.cos(8 * theta_h + 2 * V + 2 * static)) / 2
print("I = [1 + cos(8θ_h + 2V + 2Γ)]/2, residual:", residual(biased * sp.conjugate(biased) - law))

# %% [markdown]
# ## The light path
#
# Between two passes of a quarter-wave plate at 45° the crystal turns the plane of the light: what
# comes back is *linear*, swung by ±V about a direction that the half-wave plate sets. On the
# Poincaré sphere it runs along one great circle. With horizontal light at the pole, the height of
# a point *is* the intensity behind the splitter: about the equator the drive shows once a period,
# about the bottom twice.

# %% tags=["hide-input"]
figure = plt.figure(figsize=(9.6, 10.2))
rows = figure.add_gridspec(2, 1, height_ratios=[1.5, 1], hspace=0.03)
path = figure.add_subplot(rows[0])
light_path.draw_elements(path)
path.set_ylim(-6.55, 1.85)
modes = {"single": replace(SINGLE, eta=eta), "doubled": replace(DOUBLED, eta=eta)}
light_path.draw_states(path, modes["single"], top=-2.0, title="single\n$\\theta_h$ = 11.25°")
light_path.draw_states(path, modes["doubled"], top=-4.75, title="doubled\n$\\theta_h$ = 22.5°")

# %% [markdown]
# Below it the sphere and the waveforms share their height. Thick lines: the drive of the
# prototype. Thin lines: η = π/4, where the single mode swings fully and the doubled one halfway.

# %% tags=["hide-input"]
lower = rows[1].subgridspec(1, 2, width_ratios=[1, 1.5], wspace=0.05)
sphere, waves = (figure.add_subplot(lower[i]) for i in (0, 1))
azimuth, cycles = np.deg2rad(125), np.linspace(0, 2, 401)
light_path.draw_sphere(sphere, azimuth=azimuth)
sphere.set_ylim(-1.3, 1.3)
waves.set(ylim=(-0.15, 1.15), xlim=(0, 2), yticks=[0, 0.5, 1], xlabel="drive periods, ωt/2π")
waves.set_ylabel("transmitted intensity, $I/A^2$")
waves.yaxis.tick_right()
waves.yaxis.set_label_position("right")
waves.spines["left"].set_visible(False)
for (name, mode), colour in zip(modes.items(), (blue, vermillion), strict=True):
    for drive, width in ((np.pi / 4, 1.0), (eta, 3.2)):
        this = replace(mode, eta=drive)
        states = this.states(drive * np.linspace(-1, 1, 101))["HWP back"]
        light_path.draw_trace(sphere, states, azimuth=azimuth, colour=colour, width=width)
        label = f"{name}, {mode.frequency / 1e9 * (1 + (name == 'doubled')):.2f} GHz"
        waves.plot(
            cycles,
            this.waveform(2 * np.pi * cycles),
            color=colour,
            lw=width,
            label=label if drive == eta else None,
        )

# %% tags=["hide-input"]
for mode in modes.values():
    states = mode.states(eta * np.linspace(-1, 1, 101))["HWP back"]
    x, _ = light_path.sphere_points(states, azimuth=azimuth)
    intensity = mode.transmission(eta * np.linspace(-1, 1, 101))
    for i in (intensity.argmin(), intensity.argmax()):
        start, end = (x[i], 2 * intensity[i] - 1), (0, intensity[i])
        line = ConnectionPatch(
            start, end, "data", "data", axesA=sphere, axesB=waves, color="#8A97A3", ls=":"
        )
        figure.add_artist(line)
waves.legend(loc="upper center", ncols=2, bbox_to_anchor=(0.5, 1.12))
contrasts = {name: mode.contrast() for name, mode in modes.items()}
plotting.save(
    figure,
    "fig07_two_pass",
    numbers={
        "eta": eta,
        "contrast": list(contrasts.values()),
        "throughput": [mode.throughput() for mode in modes.values()],
        "residuals": [float(r) for r in (eq14, eq15, eq16, eq17, eq18)],
    },
    caption=(
        "The two-pass modulator (Fig. 7 of the paper), computed. Above: the folded light path and "
        "the polarisation at each place, on the way out and back, for three drive voltages. "
        "Below: the light that returns to the splitter on the Poincaré sphere, horizontal on top; "
        f"its height is the transmitted intensity. Thick: η = {eta:.2f}, thin: η = π/4."
    ),
    alt=(
        "A laser beam is reflected by a polarising beam splitter through a half-wave plate, a "
        "quarter-wave plate and an electro-optic modulator to a mirror and back. Ellipses show the "
        "polarisation at each place. On a Poincaré sphere the returning light swings about the "
        "equator in the single mode and about the lower pole in the doubled mode; beside it the "
        "intensity is a sine about one half, and a small wave of twice the frequency about zero."
    ),
)

# %% [markdown]
# ## The mirror's distance
#
# The light needs time to the mirror and back, so the passes see $V(t)$ and $V(t+\delta t)$. Both
# matrices are diagonal and only their sum counts:
# $2\eta\cos(\delta/2)\sin(\theta+\delta/2)$, with $\delta = 4\pi f d/c$ in drive phase. Half a
# modulation wavelength, $d = c/2f$, brings the light back exactly one period later; a quarter
# wavelength would cancel the modulation. (The paper's «half a modulation wavelength $c/\omega$»
# wants $\omega$ read as f.) The mirror stays where it is when the drive goes from 7.15 to 7.16 GHz:

# %%
delta = sp.symbols("delta", real=True)
passes = sp.sin(theta) + sp.sin(theta + delta) - 2 * sp.cos(delta / 2) * sp.sin(theta + delta / 2)
spacing = SPEED_OF_LIGHT / (2 * SINGLE.frequency)
shared = replace(DOUBLED, eta=eta, mirror_distance=spacing)
print("sum of the passes, residual:", residual(passes))
print(f"mirror at {1e3 * spacing:.2f} mm; doubled drive {1e3 * shared.pass_delay:.1f} mrad late")
glue("mirror_mm", 1e3 * spacing, display=False)
glue("late_mrad", 1e3 * shared.pass_delay, display=False)
glue("late_loss", 1 - shared.effective_eta / eta, display=False)

# %% [markdown]
# On the {glue:text}`mirror_mm:.2f` mm of the single mode the doubled drive is
# {glue:text}`late_mrad:.1f` mrad late, which costs a fraction {glue:text}`late_loss:.1e` of it.
# One mirror serves both modes.
#
# ## What the bench forgives
#
# Four errors, one at a time, on otherwise ideal elements. *Depth* is the wanted harmonic's
# amplitude over the mean, $2|W_m|/W_0$, with m = 1 in the single and 2 in the doubled mode; *leak*
# is the drive's own frequency against the doubled one, $|W_1|/|W_2|$. The mirror's distance leaves
# the dark minimum dark, so there the *signal* itself is drawn, against that of a matched mirror.


# %% tags=["hide-input"]
def depth_and_leak(mode, order, **errors):
    w = np.abs(replace(mode, **errors).harmonics(2))
    return 2 * w[order] / w[0], w[1] / w[2]


def draw_depth(ax, label, field_name, values, settings, *, leak):
    for (name, mode), order, colour in zip(modes.items(), (1, 2), (blue, vermillion), strict=True):
        found = [depth_and_leak(mode, order, **{field_name: float(v)}) for v in settings]
        depth, other = np.transpose(found)
        ax.plot(values, depth, color=colour, label=f"{name}, depth")
        if leak and order == 2:
            ax.plot(values, other, color=colour, ls="--", lw=1.3, label="doubled, leak")
    ax.set(xlabel=label, ylim=(0, 1.08), xlim=(values[0], values[-1]))


# %% tags=["hide-input"]
figure, axes = plt.subplots(2, 2, figsize=(8.6, 6.2), sharey=True)
angles, retardances = np.linspace(-2, 2, points), np.linspace(-15, 15, points)
ratios, distances = np.geomspace(10, 1e4, points), np.linspace(0, 1.25, points)
label, name = "half-wave plate angle error (degrees)", "half_wave_angle_error"
draw_depth(axes[0, 0], label, name, angles, np.deg2rad(angles), leak=True)
label, name = "static retardance per pass (degrees)", "static_retardance"
draw_depth(axes[0, 1], label, name, retardances, np.deg2rad(retardances), leak=True)
label, name = "extinction ratio of the output port", "transmitted_extinction"
draw_depth(axes[1, 0], label, name, ratios, ratios, leak=False)
axes[1, 0].set_xscale("log")

# %% tags=["hide-input"]
for mode, order, colour in zip(modes.values(), (1, 2), (blue, vermillion), strict=True):
    wavelength = SPEED_OF_LIGHT / mode.frequency
    moved = [replace(mode, mirror_distance=float(d * wavelength)) for d in distances]
    signal = np.array([abs(m.harmonics(order)[order]) for m in moved])
    axes[1, 1].plot(distances, signal / signal[0], color=colour)
axes[1, 1].set(xlabel="mirror distance (modulation wavelengths)", xlim=(0, 1.25))
axes[1, 1].set_xticks([0, 0.25, 0.5, 0.75, 1, 1.25])
axes[1, 1].axvline(0.5, color="#8A97A3", ls=":", lw=1.2)
axes[0, 0].legend(loc="lower right", fontsize="small", frameon=True, framealpha=0.92)
axes[1, 1].set_title("signal; 1 for a matched mirror")
for ax, title in zip(axes.flat, ("depth and leak", "depth and leak", "depth"), strict=False):
    ax.set_title(title)
for ax in axes[:, 0]:
    ax.set_ylabel("relative amplitude")

# %% tags=["hide-input"]
ideal = depth_and_leak(modes["doubled"], 2)[0]
tenth = depth_and_leak(modes["doubled"], 2, half_wave_angle_error=np.deg2rad(0.1))[1]
thousand = depth_and_leak(modes["doubled"], 2, transmitted_extinction=1e3)[0]
hundred = depth_and_leak(modes["doubled"], 2, transmitted_extinction=1e2)[0]
plotting.label_panels(axes.flat)
plotting.save(
    figure,
    "modulator_tolerance",
    numbers={
        "doubled_depth_ideal": ideal,
        "doubled_leak_tenth_degree": tenth,
        "doubled_depth_extinction_1000": thousand,
        "doubled_depth_extinction_100": hundred,
    },
    caption=(
        "What alignment costs at the prototype's drive (simulated). (a–c) modulation depth of both "
        "modes, and the drive's frequency leaking into the doubled one; (d) signal against the "
        "mirror's distance, with the paper's spacing dotted."
    ),
    alt=(
        "Four panels. The single mode's depth of one half tilts gently with plate angle and static "
        "retardance. The doubled mode's depth falls from one on both sides, and the leak of the "
        "drive's frequency rises steeply in a V. The doubled mode needs an extinction ratio of "
        "several hundred. Both signals vanish with the mirror at a quarter and three quarters of "
        "a wavelength and are full at one half."
    ),
)
told = {"ideal": ideal, "tenth": tenth, "thousand": thousand, "hundred": hundred}
for name, value in told.items():
    glue(f"doubled_{name}", float(value), display=False)

# %% [markdown]
# The single mode sits on a slope and forgives. The doubled mode sits in a dark minimum of which it
# fills only a little, so whatever moves or lifts the minimum costs contrast: with a tenth of a
# degree of error in the half-wave plate the drive's own frequency already reaches
# {glue:text}`doubled_tenth:.2f` of the doubled one, and an extinction ratio of 100 leaves a depth
# of {glue:text}`doubled_hundred:.2f` (1000: {glue:text}`doubled_thousand:.2f`) where an ideal
# splitter gives {glue:text}`doubled_ideal:.2f`. On the bench the leak is the thing to look at:
# turn the plate until the drive's frequency vanishes. A larger η helps: see
# {doc}`05_frequency_doubling`.
#
# ## Against the paper

# %%
reached = {
    "sec1.contrast": modes["single"].contrast(),
    "sec6.hwp_angle_single": SINGLE.half_wave_angle,
    "sec6.qwp_angle": SINGLE.quarter_wave_angle,
    "sec6.hwp_angle_double": DOUBLED.half_wave_angle,
}
for key, value in reached.items():
    paper.check(key, value)
