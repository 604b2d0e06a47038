"""Terms of the error budget: what each switches on in an instrument without errors."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cmtof.instrument.settings import TwinSettings

Change = Callable[[TwinSettings], TwinSettings]

LOUD = 100.0
"""Factor on a noise that cannot be had without the photons'; the error is divided by it."""


# --- switches: each turns one thing of the real settings on ---------------------------------------


def with_real(*names: str) -> Change:
    """Return a change that gives fields, such as ``drive.leakage``, their real values.

    Raises
    ------
    ValueError
        For what is no field.

    Examples
    --------
    >>> with_real("drive.leakage")(TwinSettings.ideal()).drive.leakage
    0.0001
    """
    real = TwinSettings()
    values: dict[str, dict[str, Any]] = {}
    for name in names:
        section, _, entry = name.partition(".")
        part = getattr(real, section, None)
        if not entry or not hasattr(part, entry):
            raise ValueError(
                f"Expected names like drive.leakage, got {name!r}. Name a field of TwinSettings."
            )
        values.setdefault(section, {})[entry] = getattr(part, entry)

    def change(settings: TwinSettings) -> TwinSettings:
        new = {one: replace(getattr(settings, one), **held) for one, held in values.items()}
        return replace(settings, **new)

    return change


def photons(settings: TwinSettings) -> TwinSettings:
    """Switch on shot noise with the avalanche's excess, and no other noise."""
    detector = replace(settings.detector, noise_density=0.0, converter_noise=0.0)
    return replace(settings, noise=True, detector=detector)


def loud_amplifier(settings: TwinSettings) -> TwinSettings:
    """Switch on the noise of detector and amplifier, `LOUD` times, beside which photons vanish."""
    density = LOUD * TwinSettings().detector.noise_density
    detector = replace(settings.detector, noise_density=density, converter_noise=0.0)
    return replace(settings, noise=True, detector=detector)


def loud_converter(settings: TwinSettings) -> TwinSettings:
    """Switch on the converter's noise and rounding, 10 `LOUD` times."""
    counts = 10 * LOUD * np.hypot(TwinSettings().detector.converter_noise, 12**-0.5)
    detector = replace(settings.detector, noise_density=0.0, converter_noise=float(counts))
    return replace(settings, noise=True, detector=detector)


def modulators(settings: TwinSettings) -> TwinSettings:
    """Splitters that leak, and wave plates off by 0.14 (motorised) and 1 degree (by hand).

    The first is the accuracy of a K10CR1 (known), the second assumed.
    """
    settings = with_real("emission.transmitted_extinction", "emission.reflected_extinction",
                         "detection.transmitted_extinction", "detection.reflected_extinction",
                         )(settings)  # fmt: skip
    angles = {"half_wave_angle_error": np.deg2rad(0.14), "quarter_wave_angle_error": np.deg2rad(1)}
    return replace(
        settings,
        emission=replace(settings.emission, **angles),
        detection=replace(settings.detection, **angles),
    )


def unchanged(settings: TwinSettings) -> TwinSettings:
    """Switch on nothing."""
    return settings


def everything(_: TwinSettings) -> TwinSettings:
    """Return the instrument as its settings describe it."""
    return TwinSettings()


# --- terms ----------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Term:
    """One line of the budget."""

    label: str
    change: Change = unchanged
    """What is switched on during the sweep."""
    reference: Change | None = None
    """What was on while the reference was read; None for the same."""
    ranging: Mapping[str, Any] = field(default_factory=dict)
    """Fields of `OpticalRanger` during the sweep."""
    reference_ranging: Mapping[str, Any] | None = None
    """The same while the reference was read; None for those of the sweep."""
    cyclic: bool = False
    """Whether it is a function of the phase, that repeats with it."""
    scale: float = 1.0
    """What errors are divided by."""

    @property
    def before(self) -> Change:
        """What was on while the reference was read."""
        return self.change if self.reference is None else self.reference

    @property
    def lab_before(self) -> Mapping[str, Any]:
        """Fields of `OpticalRanger` while the reference was read."""
        return self.ranging if self.reference_ranging is None else self.reference_ranging


MEASURED_AIR = {"temperature_error": 0.5, "pressure_error": 100.0}
"""Errors of thermometer, K, and barometer, Pa, rms (assumed)."""
STILL_AIR = {"temperature_error": 0.0, "pressure_error": 0.0}
_STAGE = {"stage_error": 5e-8}  # m (Sec. 8.2)

TERMS: dict[str, Term] = {
    "photons": Term(label="photon noise", change=photons),
    "amplifier": Term(label="amplifier", change=loud_amplifier, scale=LOUD),
    "converter": Term(label="converter", change=loud_converter, scale=10 * LOUD),
    "laser": Term(label="laser drift", change=with_real("laser.fibre_low", "laser.fibre_high")),
    "drift": Term(label="RF phase drift", change=with_real("drive.phase_drift")),
    "codes": Term(label="phase codes", change=with_real("drive.phase_step_error"), cyclic=True),
    "imbalance": Term(label="I/Q imbalance", change=with_real("drive.iq_imbalance"), cyclic=True),
    "leakage": Term(label="RF leakage", change=with_real("drive.leakage"), cyclic=True),
    "back": Term(label="back-reflection", change=with_real("optics.back_fraction"), cyclic=True),
    "four": Term(label="harmonics, 4 steps", ranging={"phases": 4, "samples": 80}, cyclic=True),
    "sixteen": Term(label="harmonics, 16 steps", cyclic=True),
    "modulators": Term(label="plates, extinction", change=modulators),
    "spot": Term(
        label="spot and speckle",
        change=with_real("optics.exit_radius", "optics.divergence", "optics.speckle"),
    ),
    "air": Term(label="air ignored", change=with_real("air.pressure"), ranging={"air": "ignored"}),
    "thermometer": Term(
        label="air, instruments", change=with_real("air.pressure"), ranging=MEASURED_AIR
    ),
    "weather": Term(
        label="air, changed since",
        change=with_real("air.pressure"),
        ranging=MEASURED_AIR,
        reference_ranging=STILL_AIR,
    ),
    "stage": Term(label="stage", ranging=_STAGE),
    "reference": Term(label="reference's noise", reference=photons),
}
"""The budget, by name. Four steps and ignored air are no part of the whole: they are choices."""

TOGETHER = Term(
    label="all together",
    change=everything,
    ranging=_STAGE | MEASURED_AIR,
    reference_ranging=_STAGE | STILL_AIR,
)
"""All terms at once, 16 steps and air corrected for, but changed since the reference."""
