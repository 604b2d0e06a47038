# %% [markdown]
# # The modulator
#
# A resonant electro-optic crystal only shifts phases. How does it modulate the intensity of light,
# at its own frequency or at twice that (Sec. 6.2; Paper Figs. 7 and 8, computed; Eqs. 10–19)?
#
# No photodiode and no camera follows 14 GHz. Two such modulators do the multiplication in the light
# itself.

# %% tags=["parameters", "hide-input"]
profile: str = "book"  # size profile
seed: int = 0  # of the instrument's errors and of the photodiode's noise
eta: float = 0.26  # drive amplitude in one pass, rad; 50 % contrast in the single mode
bandwidth: float = 12e9  # -3 dB bandwidth of the photodiode, Hz
noise: float = 0.01  # its standard deviation, in units of the light that enters
turns: int = 46  # angles of the half-wave plate, 0 to 45 degrees

# %% tags=["hide-input"]
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import sympy as sp
from matplotlib.patches import Circle, Rectangle
from scipy.special import jv

from cmtof.constants import FREQUENCY_DOUBLED, FREQUENCY_SINGLE, SPEED_OF_LIGHT
from cmtof.correlation import TAU, correlation_contrast
from cmtof.modulator import (
    DOUBLED,
    SINGLE,
    doubled_mode_harmonics,
    single_mode_harmonics,
)
from cmtof.waveform import low_pass_harmonics, waveform_from_harmonics
from cmtof_book import live, notes, paper, plotting
from cmtof_book.compared import closed_form
from cmtof_lab.instrument import Panel, RfKnobs, SimulatedInstrument
from cmtof_lab.settings import TwinSettings

plotting.begin(profile=profile, seed=seed)
modes = {"single": replace(SINGLE, eta=eta), "doubled": replace(DOUBLED, eta=eta)}
COLOURS = {"single": "C0", "doubled": "C1"}
ORDER = {"single": 1, "doubled": 2}
SERIES = {"single": single_mode_harmonics, "doubled": doubled_mode_harmonics}
DRIVE_COLOURS = ("C5", "black", "C4")  # V = −η, 0, +η

# %% tags=["hide-input"]
PLACES = {
    3.3: ("PBS in", "HWP back"),
    5.0: ("HWP", "QWP back"),
    6.9: ("QWP", "EOM back"),
}
PLACES[9.9] = ("EOM", "mirror")
BOXES = {
    "PBS": (1.6, 1, 1),
    "HWP": (4.0, 0.2, 1.3),
    "QWP": (5.8, 0.2, 1.3),
    "EOM": (7.6, 1.6, 0.9),
}
BOXES["mirror"] = (11.1, 0.16, 1.3)  # left end, width, height


def draw_path(ax):
    """Folded light path: the laser enters at the splitter, the mirror sends the light back."""
    ax.plot([2.1, 2.1, 11.1], [1.3, 0.1, 0.1], color="#00A86B", lw=3, zorder=0)
    ax.plot([11.1, 0.3], [-0.1, -0.1], color="#00A86B", lw=3, alpha=0.5, zorder=0)
    for name, (x, width, height) in BOXES.items():
        ax.add_patch(
            Rectangle((x, -height / 2), width, height, fc="#DCEBF7", ec="#6B8CA8")
        )
        ax.text(x + width / 2 - (name == "PBS"), 0.75, name, ha="center", weight="bold")
    ax.text(2.25, 1.2, "laser", va="center")
    ax.text(0.6, -0.3, "out, $I(t)$", ha="center", va="top")
    ax.text(8.4, 1.15, r"$V=\eta\,\sin\,\omega t$", ha="center")
    ax.text(
        9.1, -0.75, f"$c/2f$ = {1e3 * SPEED_OF_LIGHT / (2 * FREQUENCY_SINGLE):.0f} mm"
    )


def draw_states(ax, mode, top, name):
    """Polarisation ellipses for three drive voltages: the way out above, the way back below."""
    states = mode.states(eta * np.array([-1.0, 0.0, 1.0]))
    circle = np.exp(1j * np.linspace(0, TAU, 121))
    spots = {(0.6, top - 1.15): "PBS out"}
    for x, (out, back) in PLACES.items():
        spots |= {(x, top): out, (x, top - 1.15): back}
    for (x, y), place in spots.items():
        ax.add_patch(Circle((x, y), 0.45, fc="#F4F4F4", ec="#C8C8C8", lw=0.8))
        for vector, colour in zip(
            np.broadcast_to(states[place], (3, 2)), DRIVE_COLOURS, strict=True
        ):
            turn = 0.45 * np.real(vector[:, None] * circle)
            ax.plot(x + turn[0], y + turn[1], color=colour, lw=1.8)
    ax.text(0.0, top, name, va="center")


# %% tags=["hide-input"]
figure, (path, waves) = plt.subplots(2, 1, figsize=(8.4, 8.0), height_ratios=[2.2, 1])
draw_path(path)
draw_states(path, modes["single"], -1.7, "single\n$\\theta_h$ = 11.25°")
draw_states(path, modes["doubled"], -4.1, "doubled\n$\\theta_h$ = 22.5°")
for name, colour in zip(("V = −η", "V = 0", "V = +η"), DRIVE_COLOURS, strict=True):
    path.plot([], [], color=colour, lw=3, label=name)
path.legend(loc="upper right", ncols=3)
path.set(xlim=(-0.2, 12.2), ylim=(-5.8, 2.0), aspect="equal")
path.axis("off")
cycles = np.linspace(0, 2, 401)
for name, mode in modes.items():
    frequency = ORDER[name] * mode.frequency / 1e9
    for drive, style in ((eta, "-"), (np.pi / 4, ":")):
        wave = replace(mode, eta=drive).waveform(TAU * cycles)
        label = f"{name}, {frequency:.2f} GHz, η = {drive:.2f}"
        waves.plot(cycles, wave, style, color=COLOURS[name], label=label)
waves.set(
    xlabel="drive periods, ωt/2π",
    ylabel="transmitted intensity, $I/A^2$",
    ylim=(-0.05, 1.4),
)
waves.legend(loc="upper center", ncols=2, fontsize="small")
plotting.label_panels([path, waves])

# %% [markdown]
# The figure is computed from the equations below. SymPy proves them first: `residual` simplifies
# *ours minus theirs* and returns 0 for an identity.

# %%
V, eta_s, theta, theta_h, theta_q = sp.symbols("V eta theta theta_h theta_q", real=True)


def retarder(retardance, angle):
    """Diagonal matrix of the two phases, turned by its angle."""
    turn = sp.Matrix([[sp.cos(angle), -sp.sin(angle)], [sp.sin(angle), sp.cos(angle)]])
    phases = sp.diag(sp.exp(-sp.I * retardance / 2), sp.exp(sp.I * retardance / 2))
    return turn * phases * turn.T


def residual(expression):
    powers = sp.expand(sp.expand(expression).rewrite(sp.exp))
    return sp.simplify(sp.expand(powers.rewrite(sp.cos)))


# %% [markdown]
# The crystal's axes lie horizontal and vertical and share the voltage V, measured as the retardance
# that it causes. The splitter sends vertically polarised light through half-wave plate,
# quarter-wave plate and crystal to the mirror and back. For the returning light the horizontal axis
# is reversed, hence the minus in M and the opposite plate angles in [Eq. 14](#eq-14).
#
# $$
# B(V) = \begin{bmatrix} e^{-iV/2} & 0\\ 0 & e^{iV/2} \end{bmatrix}, \qquad
# V = \eta\cos(\omega t-\phi)
# \tag{10}$$
#
# $$
# E_0 = A\begin{bmatrix}0\\1\end{bmatrix}
# \tag{11}$$
#
# $$
# E_1 = B(V)\,Q(\theta_q)\,H(\theta_h)\,E_0
# \tag{12}$$
#
# $$
# E_2 = M E_1, \qquad M = \begin{bmatrix} 1 & 0\\ 0 & -1 \end{bmatrix}
# \tag{13}$$
#
# (The paper drives with a cosine here and with a sine in [Eq. 16](#eq-16); we keep the sine.) With
# $\theta_q = 45°$ the horizontal component of the returning field is one cosine for *any* angle of
# the half-wave plate, $E_3 = -iA\cos(4\theta_h + V)$. All else follows from it:

# %%
crystal = retarder(V, 0)
quarter = sp.pi / 2
E1 = crystal * retarder(quarter, theta_q) * retarder(sp.pi, theta_h) * sp.Matrix([0, 1])
E2 = sp.diag(1, -1) * E1
back = retarder(sp.pi, -theta_h) * retarder(quarter, -theta_q) * crystal
field = sp.expand((back * E2)[0].subs(theta_q, sp.pi / 4).rewrite(sp.exp))
print("Eqs. 11–13, |E_2|² − |E_0|²:", residual((E2.H * E2)[0] - 1))
print("E_3 + i cos(4θ_h + V):", residual(field + sp.I * sp.cos(4 * theta_h + V)))

# %% [markdown]
# **The single mode**, $\theta_h = 11.25°$ (printed as a second $\theta_q$,
# [erratum 8](22_errata.ipynb#erratum-8)):
#
# $$
# \begin{aligned}
# E_3 &= L_h H(-\theta_h) Q(-\theta_q) B(V) M B(V) Q(\theta_q) H(\theta_h) E_0\\
#     &= A\begin{bmatrix} \frac{i(\cos V-\sin V)}{\sqrt2}\\ 0\end{bmatrix}
# \end{aligned}
# \tag{14}$$
#
# $$
# I(V) = |E_3|^2 = \frac{A^2}{2}(1-\sin 2V)
# \tag{15}$$
#
# $$
# \begin{aligned}
# I(t) &= \frac{A^2}{2}\bigl(1-\sin(2\eta\sin(\omega t-\phi))\bigr)\\
#      &\approx \frac{A^2}{2}\bigl(1-2\eta\sin(\omega t-\phi)\bigr)
# \end{aligned}
# \tag{16}$$
#
# **The doubled mode**, $\theta_h = 22.5°$. The bias moves from the steepest point of the transfer
# curve to its minimum:
#
# $$
# E_3 = A\begin{bmatrix} -i\sin V\\ 0\end{bmatrix}
# \tag{17}$$
#
# $$
# I(V) = |E_3|^2 = \frac{A^2}{2}(1-\cos 2V)
# \tag{18}$$

# %% tags=["hide-input"]
single = field.subs(theta_h, sp.pi / 16)
doubled = field.subs(theta_h, sp.pi / 8)
I_single = (1 - sp.sin(2 * V)) / 2
I_doubled = (1 - sp.cos(2 * V)) / 2
driven = I_single.subs(V, eta_s * sp.sin(theta))
first_order = sp.series(driven, eta_s, 0, 2).removeO()
residuals = {
    "Eq. 14": residual(single + sp.I * (sp.cos(V) - sp.sin(V)) / sp.sqrt(2)),
    "Eq. 15": residual(single * sp.conjugate(single) - I_single),
    "Eq. 16": residual(first_order - (1 - 2 * eta_s * sp.sin(theta)) / 2),
    "Eq. 17": residual(doubled - sp.I * sp.sin(V)),
    "Eq. 18": residual(doubled * sp.conjugate(doubled) - I_doubled),
}
print(
    "up to the common phase −1,",
    ", ".join(f"{k}: {left}" for k, left in residuals.items()),
)

# %% tags=["hide-input"]
plotting.save(
    figure,
    "fig07_two_pass",
    caption="The two-pass modulator, computed. (a) The folded light path, and the polarisation "
    "before each element on the way out (upper rows) and behind it on the way back (lower rows), "
    "for three drive voltages; left, the light that leaves. (b) The intensity of both modes at η = "
    "0.26 and, dotted, π/4.",
    alt="A laser beam is reflected by a polarising beam splitter through a half-wave plate, a "
    "quarter-wave plate and an electro-optic modulator to a mirror and back. Ellipses show the "
    "polarisation at each place. Below, the intensity over two drive periods: a sine about one "
    "half, and a small wave of twice the frequency that rises from zero; "
    "dotted, both are larger.",
)

# %% [markdown]
# Input and output polarisation must be crossed; exchanging them changes nothing. The other port of
# the splitter gives the complement, $1 - I$: the opposite sign in the single mode, a bright
# background in the doubled one. The plate also sets the bias: a static birefringence Γ of the
# crystal adds to V and is cancelled by turning the half-wave plate by $-\Gamma/4$.
#
# The light travels to the mirror and back, so the two passes see $V(t)$ and $V(t+\delta t)$, whose
# sum is $2\eta\cos(\delta/2)\sin(\theta+\delta/2)$ with $\delta = 4\pi fd/c$. At a spacing of half
# a modulation wavelength, $d = c/2f$, both are equal; at a quarter they cancel. One spacing suits
# both:

# %%
shared = replace(
    modes["doubled"], mirror_distance=SPEED_OF_LIGHT / (2 * SINGLE.frequency)
)
late = 1e3 * shared.pass_delay
lost = 1 - shared.effective_eta / eta
print(
    f"doubled drive on the single mode's spacing: {late:.1f} mrad late, {lost:.1e} of it lost"
)

# %% [markdown]
# ## Doubling and the factor of two
#
# $$
# \begin{aligned}
# I(t) &= \frac{A^2}{2}\bigl(1-\cos(2\eta\sin(\omega t-\phi))\bigr)\\
#      &\approx \frac{A^2}{2}\eta^2\sin^2(\omega t-\phi)\\
#      &= \frac{A^2}{4}\eta^2\bigl(1-\cos(2\omega t-2\phi)\bigr)
# \end{aligned}
# \tag{19}$$
#
# The first line is exact. Since $1-\cos x \approx x^2/2$, the second is *half* of the lowest order.
# The text then states a quarter of the single mode's amplitude for the doubled mode. The exact
# series (Jacobi–Anger) has the amplitudes $A^2J_1(2\eta)$ and $A^2J_2(2\eta)$; their ratio is about
# η/2 and depends on the drive ([erratum 9](22_errata.ipynb#erratum-9)).

# %%
ratio = jv(2, 2 * eta) / jv(1, 2 * eta)
x = sp.symbols("x", positive=True)
quarter_at = sp.nsolve(sp.besselj(2, 2 * x) / sp.besselj(1, 2 * x) - 0.25, x, 0.5)
print(
    f"J_2/J_1 at η = {eta}: {ratio:.3f}; a quarter only at η = {float(quarter_at):.3f}"
)

# %% tags=["hide-input"]
rng = np.random.default_rng(seed)
sampled = np.linspace(0, 2, 81)
figure, axes = plt.subplots(2, 2, figsize=(8.4, 6.8), height_ratios=[1.35, 1])
# of eta sin(theta)
taylor = {
    "single": lambda sine: (1 - 2 * sine) / 2,
    "doubled": np.square,
}
spectra = {name: mode.harmonics(8) for name, mode in modes.items()}
for (ax, low), (name, mode) in zip(axes.T, modes.items(), strict=True):
    ps = 1e12 / mode.frequency
    seen = low_pass_harmonics(
        mode.harmonics(24), frequency=mode.frequency, cutoff=bandwidth
    )
    dots = waveform_from_harmonics(seen, TAU * sampled) + rng.normal(
        0, noise, sampled.size
    )
    ax.plot(ps * sampled, dots, ".", ms=4, color="#9AA4AD", label="photodiode, noisy")
    ax.plot(ps * cycles, mode.waveform(TAU * cycles), lw=2.4, label="exact")
    weak = taylor[name](eta * np.sin(TAU * cycles))
    ax.plot(ps * cycles, weak, ls="--", label="lowest order in η")
    if name == "doubled":
        ax.plot(ps * cycles, weak / 2, ":", color="C4", label="Eq. 19 as printed")
    filtered = waveform_from_harmonics(seen, TAU * cycles)
    ax.plot(
        ps * cycles,
        filtered,
        color="black",
        lw=1.3,
        label=f"through {bandwidth / 1e9:.0f} GHz",
    )
    ax.set(
        title=f"{name} mode",
        xlabel="time (ps)",
        ylim=((0, 1.1), (-0.03, 0.15))[name != "single"],
    )
    ax.legend(loc="upper center", ncols=2, fontsize="small")
    ghz = mode.frequency / 1e9 * np.arange(1, 9)
    exact = 2 * np.abs(spectra[name][1:])
    bessel = 2 * np.abs(SERIES[name](eta, 8)[1:])
    shown = exact > 1e-8
    low.vlines(ghz[shown], 1e-9, exact[shown], color="C0", lw=5, label="Jones product")
    low.plot(
        ghz[shown], bessel[shown], "o", mfc="none", color="C1", ms=10, label="Bessel"
    )
    low.plot(ghz[shown], 2 * np.abs(seen[1:9])[shown], "_", color="black", ms=16, mew=2)
    low.set(yscale="log", ylim=(1e-8, 3), xlabel="frequency (GHz)", xlim=(0, 60))

# %% tags=["hide-input"]
axes[0, 0].set_ylabel("transmitted intensity, $I/A^2$")
axes[1, 0].set_ylabel("amplitude, $2|W_k|/A^2$")
axes[1, 1].legend(fontsize="small")
plotting.label_panels(axes.flat)
response = [
    1 / np.hypot(1, f / bandwidth) for f in (FREQUENCY_SINGLE, FREQUENCY_DOUBLED)
]
taylor_error = [eta - np.sin(2 * eta) / 2, eta**2 - np.sin(eta) ** 2]
plotting.save(
    figure,
    "fig08_doubling",
    numbers={
        "doubled_over_single": closed_form(ratio),
        "photodiode_response": closed_form(response),
        "taylor_error": closed_form(taylor_error),
    },
    caption=f"Single and doubled mode at η = {eta:.2f}, simulated (the paper's is measured; the "
    "scales of (a) and (b) differ). (a, b) The exact waveform, its lowest order, and the signal of "
    "a first-order 12 GHz photodiode. (c, d) Harmonics of the Jones product and of the Bessel "
    "series; dashes, after the photodiode.",
    alt="Four panels. Left, a 7.15 gigahertz sine about one half with odd harmonics that fall "
    "steeply; right, a 14.32 gigahertz wave that rises from zero, with even harmonics. Equation 19 "
    "as printed is half as high. Behind the photodiode both waves are weaker and later.",
)

# %% tags=["hide-input"]
notes.say(
    r"""
    The photodiode passes {response_single:.2f} of the amplitude at 7.15 GHz and
    {response_doubled:.2f} at 14.32 GHz, but all of the mean. The contrast that it shows is
    therefore a lower bound of the light's. For any angle of the plate
    $I=\frac12(1+\cos(8\theta_h+2\eta\sin\omega t))$, which the sliders draw.
    """,
    response_single=response[0],
    response_doubled=response[1],
)

# %% tags=["hide-input"]
live.show('<div data-play="modulator"></div>')

# %% [markdown]
# ## Drive amplitude
#
# For ranging two such modules are multiplied. With the coefficients $W$ of one module the mean of
# the correlation is $W_0^2$, its signal $2|W_m|^2$ and its contrast their ratio.

# %%
etas = np.linspace(1e-3, 2, 400)
w1 = single_mode_harmonics(etas, 2)
w2 = doubled_mode_harmonics(etas, 2)
mean = {"single": w1[:, 0].real, "doubled, dark": w2[:, 0].real}
mean["doubled, bright"] = 1 - mean["doubled, dark"]  # the other port, the same swing
swing = {
    "single": abs(w1[:, 1]),
    "doubled, dark": abs(w2[:, 2]),
    "doubled, bright": abs(w2[:, 2]),
}
signal_ratio = [(jv(2, 2 * e) / jv(1, 2 * e)) ** 2 for e in (eta, np.pi / 4)]

# %% tags=["hide-input"]
figure, axes = plt.subplots(1, 3, figsize=(8.4, 3.5))
for name, colour in zip(mean, ("C0", "C1", "C3"), strict=True):
    style = {"color": colour, "ls": "--" if "bright" in name else "-"}
    axes[0].plot(etas, mean[name] ** 2, label=name, **style)
    axes[1].plot(etas, 2 * swing[name] ** 2 / mean[name] ** 2, **style)
    axes[2].plot(etas, 2 * swing[name] ** 2, **style)
for ax, title in zip(
    axes, ("throughput, $W_0^2$", "contrast", "signal, $2|W_m|^2$"), strict=True
):
    ax.set(title=title, xlabel="drive amplitude η (rad)", xlim=(0, 2))
    plotting.mark(ax, x=eta, text="0.26")
    plotting.mark(ax, x=np.pi / 4, text="π/4")
axes[0].legend(fontsize="small")
plotting.label_panels(axes)
contrast = [
    correlation_contrast(w, w) for w in (spectra["single"], spectra["doubled"][::2])
]
plotting.save(
    figure,
    "modulator_eta",
    numbers={
        "correlation_contrast_doubled": closed_form(contrast[1]),
        "signal_ratio": closed_form(signal_ratio),
    },
    caption="Two modules correlated, against the drive amplitude η (simulated): mean, contrast and "
    "signal of the correlation. Dark and bright bias of the doubled mode share one signal.",
    alt="Three panels against η from 0 to 2. The single mode's throughput is constant, the dark "
    "doubled mode's grows from zero, the bright one's falls from one. The doubled mode's contrast "
    "falls slowly from one half with dark bias. The signals peak near 0.9 and 1.5.",
)
print(
    f"contrast of two modules at η = {eta}: {contrast[0]:.3f} single, {contrast[1]:.2f} doubled"
)
weak, strong = signal_ratio
print(f"signal, doubled over single: {weak:.1%} at η = {eta}, {strong:.0%} at π/4")

# %% [markdown]
# At η = 0.26 the doubled mode has higher contrast but far less signal. With bright bias the same
# signal has nearly all of the light as background, and its shot noise dominates. Detection at 14.32
# GHz therefore depends on the radio-frequency power.
#
# ## Tolerances
#
# Here are four errors, one at a time. *Depth* is the wanted harmonic's amplitude over the mean,
# $2|W_m|/W_0$; *leak* is the drive's own frequency against the doubled one, $|W_1|/|W_2|$.


# %%
def depth_and_leak(name, **errors):
    w = np.abs(replace(modes[name], **errors).harmonics(2))
    return 2 * w[ORDER[name]] / w[0], w[1] / w[2]


# %% tags=["hide-input"]
rows = []
for name, error, value in (
    ("none", "half_wave_angle_error", 0.0),
    ("half-wave plate, 0.1°", "half_wave_angle_error", np.deg2rad(0.1)),
    ("half-wave plate, 1°", "half_wave_angle_error", np.deg2rad(1)),
    ("static retardance, 5°", "static_retardance", np.deg2rad(5)),
    ("extinction ratio 1000", "transmitted_extinction", 1e3),
    ("extinction ratio 100", "transmitted_extinction", 1e2),
):
    (depth, _), both = (depth_and_leak(mode, **{error: value}) for mode in modes)
    rows.append((name, f"{depth:.2f}", *(f"{x:.2f}" for x in both)))
notes.table(["error", "single, depth", "doubled, depth", "doubled, leak"], rows)

# %% [markdown]
# The single mode is biased on a slope and is tolerant. The doubled mode is biased at a minimum:
# with an error of 0.1° of the half-wave plate the drive's own frequency has a tenth of the doubled
# amplitude. On a bench the plate is turned until it vanishes.
#
# ## The simulated instrument on a fast detector
#
# Paper Fig. 8 was measured. The simulated [instrument](13_instrument.ipynb), with leaking
# splitters, is observed with a first-order detector of 12 GHz. Its drive is assumed to be η = π/4,
# because at this chapter's 0.26, the lower end of the paper's contrast of over 50 %, the doubled
# signal is too weak for a scan. The harmonics over their mean do not depend on the laser's power:
#
# $$m_1 = \frac{2 J_1(2\eta)\,|\sin 8\theta_h|}{1 + J_0(2\eta)\cos 8\theta_h},\qquad
#   m_2 = \frac{2 J_2(2\eta)\,|\cos 8\theta_h|}{1 + J_0(2\eta)\cos 8\theta_h}.$$

# %% tags=["hide-input"]
settings = TwinSettings()
instrument = SimulatedInstrument(settings, seed=seed)
FAST_BANDWIDTH = 12e9  # Hz, of the fast detector ET-4000 (Sec. 7.4)


def light_depth(order, angle):
    """Amplitude of a harmonic over the mean, the detector's bandwidth divided out."""
    knobs = RfKnobs(on=True, frequency=SINGLE.frequency, power=settings.drive_power)
    w = instrument.emission(Panel(emission=knobs, plate_emission=angle))
    detector = {"frequency": SINGLE.frequency, "cutoff": FAST_BANDWIDTH}
    seen = np.abs(low_pass_harmonics(w, **detector))
    lost = abs(1 + 1j * order * SINGLE.frequency / FAST_BANDWIDTH)
    return 2 * seen[order] / seen[0] * lost


plate = np.deg2rad(np.linspace(0, 45, turns))

# %% tags=["hide-input"]
j0, j1, j2 = (jv(n, 2 * settings.eta) for n in range(3))
fine = np.linspace(0, np.pi / 4, 400)
figure, ax = plt.subplots(figsize=(7, 3.8))
for order, wave, colour in (
    (1, j1 * np.sin(8 * fine), "C0"),
    (2, j2 * np.cos(8 * fine), "C1"),
):
    closed = 2 * np.abs(wave) / (1 + j0 * np.cos(8 * fine))
    ax.plot(np.rad2deg(fine), closed, color=colour)
    found = [light_depth(order, angle) for angle in plate]
    ax.plot(np.rad2deg(plate), found, "o", ms=4.5, color=colour, label=f"$m_{order}$")
ax.set(xlabel="angle of the half-wave plate (°)", ylabel="amplitude over the mean")
ax.legend(loc="upper left")
half_power = settings.drive_power + 20 * np.log10(0.26 / settings.eta)
plotting.save(
    figure,
    "instrument_plate_and_power",
    numbers={
        "half_contrast_dbm": closed_form(half_power),
    },
    caption="First and second harmonic of the simulated instrument's emitted light over its mean, "
    "against the plate's angle at η = π/4, detector bandwidth divided out, without noise. Dots: "
    "simulated instrument; lines: closed forms of ideal splitters.",
    alt="Against the plate's angle the first harmonic has two humps on either side of 22.5 degrees "
    "and the second a tall one near it and low ones at both ends; dots lie on the lines.",
)

# %% tags=["hide-input"]
notes.say(
    """
    At 22.5° $m_1$ vanishes and $m_2$ is largest. A drive of {half_power:.1f} dBm would give η =
    0.26, the lower end of the paper's contrast of over 50 %.
    """,
    half_power=half_power,
)

# %% [markdown]
# ## Answer

# %% tags=["hide-input"]
notes.answer(
    """
    **Answer.** Two passes through the crystal, two wave plates and a polarising splitter turn phase
    into intensity; one plate turned by 11.25° doubles the frequency. At η = {eta:.2f} the doubled
    amplitude is {ratio:.3f} of the single one. Eqs. 14 to 18 are right as printed;
    Eq. 19 is too small by a factor of two ([errata](22_errata.ipynb)).
    """,
    eta=eta,
    ratio=ratio,
)

# %% [markdown]
# ## Against the paper

# %% tags=["hide-input"]
strongest = 1 + int(np.abs(spectra["doubled"][1:]).argmax())
paper.check_all(
    {
        "sec1.contrast": closed_form(replace(SINGLE, eta=float(quarter_at)).contrast()),
        "sec1.minimum_frequency": strongest * DOUBLED.frequency,
        "sec6.hwp_angle_single": SINGLE.half_wave_angle,
        "sec6.qwp_angle": SINGLE.quarter_wave_angle,
        "sec6.hwp_angle_double": DOUBLED.half_wave_angle,
        # at half contrast, and from there to full contrast
        "sec6.doubled_amplitude": [
            jv(2, np.pi / part) / jv(1, np.pi / part) for part in (6, 6, 2)
        ],
        "sec6.effective_wavelength": closed_form(SPEED_OF_LIGHT / FREQUENCY_DOUBLED),
        "sec6.frequency_difference": FREQUENCY_DOUBLED - FREQUENCY_SINGLE,
        "sec7.photodetector": FAST_BANDWIDTH,
        "fig8.frequency_single": SINGLE.frequency,
        "fig8.frequency_drive": DOUBLED.frequency,
        "fig8.frequency_doubled": strongest * DOUBLED.frequency,
    }
)
paper.table()

# %% [markdown]
# ## Exercises
#
# **1.** Which drive amplitude gives the doubled mode its largest amplitude, and how large is it?

# %% tags=["hide-cell"]
# The amplitude is J₂(2η); it is largest where its derivative vanishes.
largest = jv(2, 2 * etas).argmax()
print(f"η = {etas[largest]:.2f}: {jv(2, 2 * etas[largest]):.3f}")

# %% [markdown]
# **2.** The half-wave plate is at 20° instead of 22.5°, the quarter-wave plate at its right angle.
# What is the ratio of the amplitudes at the drive's own frequency and at the doubled one at
# η = 0.26?

# %% tags=["hide-cell"]
# Over the mean the harmonics are 2 J₁(2η)|sin 8θ| and 2 J₂(2η)|cos 8θ|, so the drive's own is the
# larger one. The slider above shows the same.
turned = 8 * np.deg2rad(20)
print(f"{abs(jv(1, 0.52) * np.tan(turned) / jv(2, 0.52)):.2f}")
