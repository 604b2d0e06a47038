"""How noisy each pixel's phases are, read off the correlations themselves."""

import numpy as np
from numpy.typing import NDArray

from cmtof.correlation import residual_noise
from cmtof.measurement import Measurement


def phase_noise(measurement: Measurement) -> NDArray[np.float64]:
    """Phase noise of the first two frequencies (2, H, W), rad, ``sqrt(2 / K) s / a``.

    s is the noise of one correlation sample, from what the fit leaves over, a the amplitude; one
    radian where only phases were kept or three steps, infinite where a pixel tells nothing.
    """
    phase, amplitude = measurement.phase[:2], measurement.amplitude[:2].astype(float)
    known = np.isfinite(phase) & np.isfinite(amplitude) & (amplitude > 0)
    dataset = measurement.dataset
    if "correlation" not in dataset or dataset.sizes["step"] < 4:
        return np.where(known, 1.0, np.inf)
    images, psi = dataset["correlation"].to_numpy(), dataset["psi"].to_numpy()
    sample = np.array([_finite_noise(images[i], psi[i]) for i in (0, 1)])
    linear = np.sqrt(2 / psi.shape[1]) * sample[:, None, None]
    return np.where(known, linear / np.where(known, amplitude, 1), np.inf)


def _finite_noise(images: NDArray, psi: NDArray[np.floating]) -> float:
    """Noise of one sample, counts, from the pixels whose samples are all finite."""
    finite = np.isfinite(images).all(axis=0)
    if not finite.any():
        return 0.0
    return residual_noise(images if finite.all() else images[:, finite], psi)
