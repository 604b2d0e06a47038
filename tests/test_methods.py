"""One contract for every method: range, mask, sizes, darkness, order of the steps, repetition."""

import numpy as np
import pytest

import cmtof
from cmtof.correlation import phase_from_depth, wrap_length
from cmtof.evaluation import measured
from cmtof.frame import Frame
from cmtof.measurement import Measurement
from cmtof.methods import ALIASES, DEFAULT, METHODS, find_method, names_of

NAMES = sorted(name for name, method in METHODS.items() if method.kind != "learned")
TWO = [name for name in NAMES if METHODS[name].frequencies == 2]
IMAGES = ("wrap_count", "depth", "confidence")


def wall(height, width, light=0.8):
    """A tilted wall inside the released range."""
    y, x = np.indices((height, width))
    depth = 0.85 + 0.2 * x / max(width, 8) + 0.05 * y / max(height, 8)
    camera = np.array([1.2 * max(height, width)] * 2 + [width / 2, height / 2])
    return Frame(depth, np.full(depth.shape, light), camera, "wall")


def given_to(name, frame, **conditions):
    return measured(frame, [name], seed=3, **conditions)[name]


def images(measurement, name, **options):
    result = cmtof.unwrap(measurement, method=name, **options)
    return [result[image].to_numpy() for image in IMAGES]


def masked(measurement, mask, **images):
    return Measurement(measurement.dataset.assign(mask=(("y", "x"), mask), **images))


def results_obey_range_and_mask_and_repeat(name):
    low, high = 0.86, 1.05
    m = given_to(name, wall(24, 32))
    mask = m.mask & (np.indices(m.shape)[0] >= 5)
    m = masked(m, mask)
    count, depth, confidence = images(m, name, range=(low, high))
    assert (count[~mask] == -1).all() and (count[mask] >= int(low / wrap_length(7.15e9))).all()
    assert np.isnan(depth[~mask]).all()
    assert ((depth[mask] >= low - 1e-6) & (depth[mask] < high + 1e-6)).all()
    assert not confidence[~mask].any() and ((confidence >= 0) & (confidence <= 1)).all()
    again = images(m, name, range=(low, high))
    for one, other in zip((count, depth, confidence), again, strict=True):
        np.testing.assert_array_equal(one, other)


def masked_pixels_may_be_nan(name):
    m = given_to(name, wall(24, 32))
    samples, mask = m.dataset["correlation"].to_numpy().copy(), m.mask.copy()
    samples[:, :, 7:9, 3], mask[7:9, 3] = np.nan, False
    holed = masked(m, mask, correlation=(m.dataset["correlation"].dims, samples))
    count, depth, _ = images(holed, name)
    assert (count[7:9, 3] == -1).all() and np.isnan(depth[7:9, 3]).all()
    assert (count >= 0).sum() == m.mask.sum() - 2


def any_size_light_or_dark_or_masked(name):
    for shape, light, valid in [((1, 1), 0.8, True), ((1, 9), 0.0, True), ((9, 1), 0.8, True),
                                ((2, 3), 0.0, True), ((2, 3), 0.8, False)]:  # fmt: skip
        m = given_to(name, wall(*shape, light))
        count, depth, confidence = images(masked(m, np.full(shape, valid)), name)
        assert count.shape == shape
        assert np.isfinite(depth).all() == valid
        assert ((confidence >= 0) & (confidence <= 1)).all()


def the_order_of_the_steps_does_not_matter(name):
    m = given_to(name, wall(24, 32), noise_free=True)
    shuffled = Measurement(m.dataset.isel(step=[2, 0, 3, 1]))
    count, again = images(m, name)[0], images(shuffled, name)[0]
    assert np.mean(count == again) > 0.98 or name == "uniform"  # wraps end within a pixel


@pytest.mark.parametrize("name", NAMES)
def test_contract_of_every_method(name):
    results_obey_range_and_mask_and_repeat(name)
    masked_pixels_may_be_nan(name)
    any_size_light_or_dark_or_masked(name)
    the_order_of_the_steps_does_not_matter(name)


def test_one_wrap_in_range_leaves_no_choice():
    wrap = float(wrap_length(7.15e9))
    depth = np.full((6, 7), 40.5 * wrap)
    phase = np.stack([phase_from_depth(depth, f) for f in (7.15e9, 14.32e9)])
    m = Measurement.from_phase(phase, (7.15e9, 14.32e9), depth=depth, range_min=40 * wrap,
                               range_max=41 * wrap)  # fmt: skip
    for name in set(TWO) - {"phasor", "crt-closed-form"}:
        assert (cmtof.unwrap(m, method=name).wrap_count == 40).all(), name


def test_what_a_method_needs_is_asked_for(measured):
    one = Measurement.from_phase(np.ones((1, 8, 9)), [7.15e9], depth=np.ones((8, 9)), range_max=1.0)
    blind = Measurement(measured.dataset.drop_vars("depth"))
    multiples = Measurement.from_phase(np.ones((2, 3, 3)), (7e9, 14e9), depth=np.ones((3, 3)))
    for name in TWO:
        with pytest.raises(ValueError, match=f"Expected 2 frequencies for method {name}, got 1"):
            cmtof.unwrap(one, method=name)
        if METHODS[name].knows_truth:
            with pytest.raises(ValueError, match=f"true depth for method {name}"):
                cmtof.unwrap(blind, method=name)
        if name.split("-")[0] not in ("crt", "kde", "phasor"):
            with pytest.raises(ValueError, match="no multiples"):
                cmtof.unwrap(multiples, method=name)


REFUSED = [
    ({"method": "magic"}, "Expected a method out of crt, crt-closed-form"),
    ({"range": (5.0, 6.0)}, "that meets the data's"),
    ({"range": (-1.0, 0.9)}, "MIN < MAX"),
    ({"method": "beat", "window": 4}, "odd window"),
    ({"method": "phasor"}, "two close frequencies whose beat covers"),
]


def test_bad_requests_are_refused_in_one_line(measured):
    for options, message in REFUSED:
        with pytest.raises(ValueError, match=message) as error:
            cmtof.unwrap(measured, **options)
        assert "\n" not in str(error.value)


def test_names_aliases_and_all():
    assert find_method("cmtof").name == DEFAULT == "surfaces"
    assert {find_method(name).name for name in ALIASES} <= METHODS.keys()
    chosen = names_of("all")
    assert {"surfaces", "crt", "mrf", "middle"} <= set(chosen)
    assert not [name for name in chosen if METHODS[name].kind == "reference"]
    assert names_of("oracle-field,beat") == ["reference-field", "beat"]
    assert all(METHODS[name].summary and METHODS[name].name == name for name in METHODS)


def test_learned_methods_tell_their_state(measured, monkeypatch):
    from cmtof.network import weights

    monkeypatch.setattr(weights, "state", lambda model, protocol: "untrained")
    method = find_method("fast-scnn")
    monkeypatch.setitem(method.__dict__, "run", lambda m: None)
    with pytest.warns(UserWarning, match="fast-scnn is untrained"):
        method(measured)
    assert "fast-scnn" not in names_of("all")
