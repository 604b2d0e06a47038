"""Cameras: files in their order, and a GenICam back end against a stand-in."""

import sys
from contextlib import contextmanager
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from cmtof.hardware.drivers.camera import FileCamera, GenicamCamera


@pytest.fixture
def folder(tmp_path):
    np.save(tmp_path / "frame_2.npy", np.full((3, 4), 2, np.uint16))
    Image.fromarray(np.full((3, 4), 9, np.uint8)).save(tmp_path / "frame_9.png")
    Image.fromarray(np.full((3, 4), 1000, np.uint16)).save(tmp_path / "frame_10.tif")
    (tmp_path / "notes.txt").write_text("no image")
    return tmp_path


def test_images_come_by_number(folder):
    camera = FileCamera(folder)
    assert len(camera) == 3
    frames = [camera.frame() for _ in camera.paths]
    assert [int(frame[0, 0]) for frame in frames] == [2, 9, 1000]
    assert [frame.shape for frame in frames] == [(3, 4)] * 3
    with pytest.raises(EOFError, match="Expected one of 3 images, got to the end"):
        camera.frame()


def test_images_repeat(folder):
    camera = FileCamera([folder / "frame_10.tif", folder / "frame_2.npy"], repeat=True)
    assert [int(camera.frame()[0, 0]) for _ in range(3)] == [1000, 2, 1000]


def test_colours_become_grey(tmp_path):
    colours = np.zeros((2, 2, 3), np.uint8) + np.uint8([30, 60, 90])
    Image.fromarray(colours).save(tmp_path / "a.png")
    assert FileCamera(tmp_path).frame().tolist() == [[60, 60], [60, 60]]


def test_no_images(tmp_path, folder):
    empty = tmp_path / "empty"
    empty.mkdir()
    for source in (empty, empty / "nothing", [folder / "frame_3.npy"], []):
        with pytest.raises(FileNotFoundError, match="Expected images"):
            FileCamera(source)


@pytest.mark.parametrize("name", ["a.npy", "a.png", "a.tif"])
def test_a_file_that_is_no_image(tmp_path, name):
    (tmp_path / name).write_bytes(b"\x80\x04garbage")
    with pytest.raises(ValueError, match=f"Expected an image in .*{name}"):
        FileCamera(tmp_path).frame()


def test_an_array_that_is_no_image(tmp_path):
    np.save(tmp_path / "a.npy", np.zeros(5))
    with pytest.raises(ValueError, match=r"image \(H, W\) in .*a.npy, got \(5,\)"):
        FileCamera(tmp_path).frame()


def test_nothing_is_unpickled(tmp_path):
    np.save(tmp_path / "a.npy", np.array([{"a": 1}]), allow_pickle=True)
    with pytest.raises(ValueError, match="Expected an image"):
        FileCamera(tmp_path).frame()


@pytest.fixture
def harvesters(monkeypatch, tmp_path):
    """A stand-in for the package: it shows that our calls fit together, not that they are right."""
    log = []

    class Device:
        def start(self):
            log.append("start")

        @contextmanager
        def fetch(self, timeout):
            image = SimpleNamespace(data=np.arange(6, dtype=np.uint8), height=2, width=3)
            yield SimpleNamespace(payload=SimpleNamespace(components=[image]))
            image.data[:] = 0  # the buffer is used again

        def destroy(self):
            log.append("destroy")

    class Harvester:
        device_info_list = ("one",)

        def add_file(self, path):
            log.append(path)

        def update(self): ...

        def create(self, index):
            return Device()

        def reset(self):
            log.append("reset")

    core = ModuleType("harvesters.core")
    core.Harvester = Harvester
    monkeypatch.setitem(sys.modules, "harvesters", ModuleType("harvesters"))
    monkeypatch.setitem(sys.modules, "harvesters.core", core)
    producer = tmp_path / "producer.cti"
    producer.touch()
    return producer, log


def test_a_genicam_camera_copies_its_buffer(harvesters):
    producer, log = harvesters
    camera = GenicamCamera(producer)
    assert camera.frame().tolist() == [[0, 1, 2], [3, 4, 5]]
    camera.close()
    assert log == [str(producer), "start", "destroy", "reset"]
    with pytest.raises(FileNotFoundError, match="Expected camera 1, got 1 cameras"):
        GenicamCamera(producer, 1)


def test_a_genicam_camera_needs_its_package(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "harvesters", None)
    monkeypatch.setitem(sys.modules, "harvesters.core", None)
    producer = tmp_path / "producer.cti"
    with pytest.raises(FileNotFoundError, match="Expected a GenTL producer"):
        GenicamCamera(producer)
    producer.touch()
    with pytest.raises(ImportError, match="pip install harvesters"):
        GenicamCamera(producer)
