"""Every unwrapping method by name, and whom it is taken from."""

from typing import Any

from cmtof.baselines.method import Method


def _of(kind: str, name: str, source: str, summary: str, where: str, **more: Any) -> Method:
    return Method(name, kind, source, summary, f"cmtof.baselines.{where}", **more)


def _learned(name: str, source: str, summary: str) -> Method:
    """A learned method, named as its model."""
    where = "cmtof.network.inference:unwrap_with_network"
    return Method(name, "learned", source, summary, where, model=name)


_BAEK = "Baek et al. 2023"

_ALL = (
    # ------------------------------------------------------------ pixel by pixel
    _of("classical", "crt", "Xia and Wang 2007",
        "search over the wraps in range for the smallest remainder, pixel by pixel",
        "crt:search"),
    _of("classical", "crt-closed-form", "Wang and Xia 2010",
        "strict Chinese remainder theorem over the full 15 m, pixel by pixel",
        "crt:closed_form"),
    _of("classical", "crt-ml", "Wang et al. 2015",
        "search in range, both phases fused by inverse variance, pixel by pixel",
        "crt:maximum_likelihood"),
    _of("classical", "phasor", "Gupta et al. 2015",
        "look-up of two close frequencies' phases in two stages, pixel by pixel",
        "phasor:phasor", tones=(7.15e9, 7.16e9)),
    # ------------------------------------------------------------ windows and surfaces
    _of("classical", "kde", "Järemo Lawin et al. 2016",
        "kernel density of every wrap in range over 11x11 px, as published",
        "kde:kde"),
    _of("classical", "kde-tuned", "Järemo Lawin et al. 2016",
        "the same with kernel and window chosen on validation rooms",
        "kde:tuned"),
    _of("classical", "beat", "Jongenelen et al. 2010",
        "coherent average of the 20 MHz beat over a window, nearest wrap in range",
        "beat:beat"),
    _of("classical", "beat-guided", "He et al. 2013",
        "average of the beat that stops at edges of amplitude and of phase",
        "beat_guided:beat_guided"),
    _of("classical", "spatial", "Herraez et al. 2002",
        "reliability-sorted unwrapping of one frequency, its offset set to mid-range",
        "spatial:spatial", frequencies=1),
    _of("classical", "region", "Herraez et al. 2002",
        "spatial unwrapping cut into regions, one pooled offset each",
        "region:region"),
    _of("classical", "mrf", "Hirschmüller 2008",
        "random field over wraps, its energy lowered along eight directions",
        "mrf:mrf"),
    _of("classical", "mrf-graphcut", "Bioucas-Dias and Valadão 2007",
        "the same field with a convex prior, its energy lowered by graph cuts",
        "mrf_graphcut:mrf_graphcut"),
    Method("cmtof", "classical", "this project",
        "planes and bent surfaces in true geometry, grown, pooled and tied to each other",
        "cmtof.surfaces.unwrapping:cmtof"),
    # ------------------------------------------------------------ learned
    _learned("u-net", "Ronneberger et al. 2015", "U-Net, narrowed: segmentation into wraps"),
    _learned("one-step", "Wang et al. 2019", "residual U-Net, narrowed: regression of depth"),
    _learned("deep-tof", "Su et al. 2018", "encoder and decoder on raw correlations, narrowed"),
    _learned("rapid", "Zhang et al. 2019", "DeepLabV3+, narrowed, its wraps mended afterwards"),
    _learned("fast-scnn", _BAEK, "the paper's network: segmentation into wraps"),
    _learned("fast-scnn-ce", _BAEK, "the paper's network, trained by cross-entropy alone"),
    _learned("fast-scnn-fourier", _BAEK, "the paper's network without phase edges"),
    _learned("fast-scnn-phase", _BAEK, "the paper's network on bare phases"),
    _learned("fast-scnn-light", "this project", "a lighter network that is given the beat"),
    # ------------------------------------------------------------ marks to measure by
    _of("trivial", "middle", "", "the middle of the range for every pixel", "trivial:middle",
        frequencies=1),
    _of("trivial", "uniform", "", "a guess, every wrap in range alike", "trivial:uniform",
        frequencies=1),
    _of("trivial", "mode", "", "the image's most frequent wrap, which only the truth tells",
        "trivial:mode", frequencies=1, knows_truth=True),
    _of("oracle", "oracle-depth", "", "the true depth, read against the measured phase",
        "trivial:true_depth", frequencies=1, knows_truth=True),
    _of("oracle", "oracle-offset", "", "true surfaces, one unknown offset each",
        "oracle_offset:oracle_offset", knows_truth=True),
    _of("oracle", "oracle-contact", "", "true bodies, creases and all, one unknown offset each",
        "oracle_offset:oracle_contact", knows_truth=True),
    _of("oracle", "oracle-plane", "", "true surfaces, one unknown offset and tilt each",
        "oracle_plane:oracle_plane", knows_truth=True),
    _of("oracle", "oracle-field", "", "true surfaces, seen through a window of 281 px",
        "oracle_field:oracle_field", knows_truth=True),
)  # fmt: skip

METHODS = {method.name: method for method in _ALL}

DEFAULT = "cmtof"


def find_method(name: str) -> Method:
    """Return the method of that name; raise a ValueError that lists them otherwise."""
    if name not in METHODS:
        raise ValueError(f"Expected a method out of {', '.join(METHODS)}, got {name}. Choose one.")
    return METHODS[name]
