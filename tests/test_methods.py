"""One contract for every method: range, mask, sizes, darkness, order of the steps, repetition."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_array_equal
from pytest import fixture, mark, skip
from refusals import WRONG, refused
from scores import images, scores
from walls import WRAP, lit

import cmtof
from cmtof.evaluation import measure_frame, scored_pixels
from cmtof.measurement import Measurement
from cmtof.methods import METHODS, names_of
from cmtof_rooms.rendering import Settings, render_views

NAMES = sorted(name for name, method in METHODS.items() if method.kind != "learned")
TWO = [name for name in NAMES if METHODS[name].frequencies == 2]


def given_to(name, frame, **conditions):
    return measure_frame(frame, [name], seed=3, **conditions)[name]


@mark.parametrize(
    "shape, light, hidden",
    [
        ((24, 32), 0.8, 5),
        ((1, 1), 0.8, 0),
        ((1, 9), 0.0, 0),
        ((9, 1), 0.8, 0),
        ((2, 3), 0.0, 0),
        ((2, 3), 0.8, 2),
    ],
)
@mark.parametrize("name", NAMES)
def test_results_obey_range_and_mask_and_repeat(
    tilted_wall, name, shape, light, hidden
):
    """Of images of any size, light or dark, whose first rows are masked."""
    low, high = 0.86, 1.05
    part = tilted_wall.middle(*shape)
    data = given_to(name, lit(part.depth, light, part.camera)).dataset
    data["mask"][:hidden] = False
    m = Measurement(data)
    mask = m.mask
    found = images(m, method=name, range=(low, high))
    count, depth, confidence = found
    assert (count[~mask] == -1).all()
    assert (count[mask] >= int(low / WRAP)).all()
    assert (count[mask] <= high / WRAP).all()
    assert np.isnan(depth[~mask]).all()
    assert ((depth[mask] >= low - 1e-6) & (depth[mask] < high + 1e-6)).all()
    assert ((confidence >= 0) & (confidence <= mask)).all()
    assert_array_equal(found, images(m, method=name, range=(low, high)))


@mark.parametrize("name", sorted({*TWO} - {"phasor", "crt-closed-form"}))
def test_one_wrap_in_range_leaves_no_choice(exact, name):
    m = exact(np.full((6, 7), 40.5 * WRAP), range_min=40 * WRAP, range_max=41 * WRAP)
    assert (cmtof.unwrap(m, method=name).wrap_count == 40).all()


@mark.parametrize("name", TWO)
def test_a_second_frequency_is_asked_for(exact, name):
    one = exact(np.ones((8, 9)), [7.15e9], range_max=1.0)
    with refused(f"Expected 2 frequencies for method {name}, got 1"):
        cmtof.unwrap(one, method=name)


@mark.parametrize("name", [name for name in TWO if METHODS[name].knows_truth])
def test_the_truth_is_asked_for_where_a_method_knows_it(measured, name):
    blind = Measurement(measured.dataset.drop_vars("depth"))
    with refused(f"true depth for method {name}"):
        cmtof.unwrap(blind, method=name)


@mark.parametrize("options, message", WRONG["methods"])
def test_impossible_requests_are_refused_in_one_line(measured, options, message):
    with refused(message):
        cmtof.unwrap(measured, **options)


def test_all_are_no_references():
    chosen = names_of("all")
    assert {"surfaces", "crt", "mrf", "middle"} <= set(chosen)
    assert not [name for name in chosen if METHODS[name].kind == "reference"]


def test_untrained_networks_are_left_out_of_all(monkeypatch):
    """In test_weights they warn."""
    monkeypatch.setattr("cmtof.network.weights.Card.trained", False)
    assert "fast-scnn" not in names_of("all")


@fixture(scope="module")
def multiples():
    """A wall between 2 and 5 m at the three tones of a Kinect, two of them multiples."""
    depth = np.linspace(2, 5, 24 * 32).reshape(24, 32)
    tones = (16e6, 80e6, 120e6)
    return cmtof.simulate(
        lit(depth, 0.8), protocol="full", frequencies=tones, noise=100.0
    )


REFUSING = {name for name in TWO if not name.startswith(("crt", "kde"))}


@mark.parametrize("name", sorted(REFUSING | {"fast-scnn-light"}))
def test_a_refusal_names_a_method_that_works(multiples, name):
    with refused("the method crt"):
        cmtof.unwrap(multiples, method=name)
    assert scores(multiples, method="crt")["delta_lt_1"] > 0.99


@mark.parametrize("name", ["beat", "region", "mrf", "surfaces", "crt", "kde"])
def test_a_beat_that_repeats_within_the_range_is_not_sure(name):
    """At 7.15 and 10 GHz it does so eight times."""
    frame = cmtof.load_frame("room").middle(96, 112)
    m = cmtof.simulate(frame, frequencies=(7.15e9, 10e9), noise=300.0)
    found = scores(m, method=name)
    assert found["mean_confidence"] < found["delta_lt_1"] + 0.15


def test_a_third_frequency_does_not_set_the_range():
    tones = (7.15e9, 14.32e9, 21.5e9)
    two, three = (Measurement.from_phase(np.ones((n, 2, 2)), tones[:n]) for n in (2, 3))
    assert two.range == three.range


@mark.parametrize("phases", [False, True])
@mark.parametrize("protocol", ["released", "full"])
def test_with_whole_counts_for_noise_the_remainder_is_sure(phases, protocol):
    m = cmtof.simulate(cmtof.load_frame("room"), protocol=protocol, noise_free=True)
    m = Measurement(m.dataset.round())
    if phases:
        m = Measurement.from_phase(m.phase, m.frequencies, mask=m.mask).between(
            *m.range
        )
    *_, confidence = images(m, method="crt")
    assert (confidence > 0.5)[m.mask].mean() > 0.99


@fixture(scope="module")
def rooms():
    """Views of eight rooms that nothing was trained or calibrated on."""
    return [view.frame for view in render_views(Settings(812, 8, 1, 96, 128))]


def uneven(frame):
    """The frame with depths that are rough by a tenth of a wrap or so in each pixel."""
    return replace(
        frame, depth=np.random.default_rng(1).normal(frame.depth, 0.002 * frame.depth)
    )


CASES = {
    "usual": {},
    "full": {"protocol": "full"},
    "noisy": {"noise": 2000.0},
    "noise-free": {"noise_free": True},
    "uneven": {},
}


@mark.parametrize("case", CASES)
@mark.parametrize("name", sorted({*names_of("all")} - {"middle", "mode", "uniform"}))
def test_confidence_is_no_promise_beyond_the_rate(rooms, name, case):
    """Nor low everywhere; but a single pixel's beat says little of where it is right."""
    if name not in names_of("all", CASES[case].get("protocol", "released")):
        skip("no weights")
    right = []
    said = []
    for frame in map(uneven, rooms) if case == "uneven" else rooms:
        m = given_to(name, frame, **CASES[case])
        pixels = scored_pixels(cmtof.unwrap(m, method=name), m)
        right.extend(pixels["wrap_count"] == pixels["true_count"])
        said.extend(pixels["confidence"])
    assert np.mean(said) < np.mean(right) + 0.15
    assert np.average(said, weights=right) > np.mean(said) - 0.005
