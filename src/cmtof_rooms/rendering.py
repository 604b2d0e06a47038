"""Rooms from a seed: built, seen, exposed, and written in Hypersim's layout, resumable."""

import io
import json
import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from multiprocessing import get_context, parent_process
from pathlib import Path
from threading import Thread
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from cmtof.files import alone, read_document, written_whole
from cmtof.frame import Frame, brightness
from cmtof.hypersim import FILES, View, write_metadata
from cmtof.validation import expect
from cmtof_rooms.cameras import Camera, Lens, close_cameras, room_cameras
from cmtof_rooms.engine import Light, Picture, World
from cmtof_rooms.furnishing import Furnishing, household, presets
from cmtof_rooms.shell import Rectangle, Shell, build_shell

SETTINGS = "rooms.json"
"""File in a set's folder that says what it was made from."""

CLOSE_SHARE = 0.05
"""Share of a set's views that are taken from 0.5 to 1.2 m."""

LIGHTS = 4
"""Lights that a room has at most: rays are sent to each."""

# streams of random numbers of one scene, so that more views never change the room
_ROOM, _VIEWS, _CLOSE, _LENS, _EXPOSURE = range(5)


@dataclass(frozen=True)
class Settings:
    """What a set of rooms is made from; equal settings give equal bytes.

    Attributes
    ----------
    seed : int
    scenes, views : int
        How many rooms, and how many views of each.
    height, width : int
        px.
    focal : float or None
        px; by default each scene has a lens of its own, from 60 degrees across (Hypersim's usual
        one) down to 35.
    """

    seed: int = 0
    scenes: int = 20
    views: int = 5
    height: int = 512
    width: int = 512
    focal: float | None = None

    def __post_init__(self) -> None:
        most = {"scenes": 100_000, "views": 1000, "height": 4096, "width": 4096}
        for name, limit in most.items():
            found = getattr(self, name)
            expect(1 <= found <= limit, f"{name} of 1 to {limit}", found, "Choose another.")
        expect(0 <= self.seed < 2**63, "a seed of 0 to 2^63", self.seed, "Choose another.")
        known = self.focal is None or 1 <= self.focal < 1e6
        expect(known, "a focal length of 1 to 1e6 px", self.focal, "Try the width.")

    def lens(self, index: int) -> Lens:
        """Lens of one scene."""
        angle = np.radians(stream(self.seed, index, _LENS).choice([60, 60, 60, 52, 44, 35]))
        drawn = self.width / 2 / np.tan(angle / 2)
        return Lens((self.height, self.width), float(self.focal or drawn))


@dataclass(frozen=True)
class Scene:
    """A furnished room with its light; cameras are drawn from it."""

    seed: int
    index: int
    kind: str
    world: World
    floor: list[Rectangle]
    height: float
    furniture: range
    """Numbers of the things that do not belong to the house itself."""

    @property
    def name(self) -> str:
        """Folder of the scene, as in ``room_000_007``: seed and place in the set."""
        return f"room_{self.seed:03d}_{self.index:03d}"

    def cameras(self, views: int, lens: Lens) -> dict[str, list[Camera]]:
        """Poses of ``cam_00`` (across the room) and ``cam_01`` (close to things).

        Together ``views``; the first ones stay the same when more are asked for.
        """
        close = close_views(self.index, views)
        across, near = (stream(self.seed, self.index, use) for use in (_VIEWS, _CLOSE))
        where = {"floor": self.floor, "height": self.height}
        return {
            "cam_00": room_cameras(views - close, self.world, lens, rng=across, **where),
            "cam_01": close_cameras(
                close, self.world, lens, things=np.array(self.furniture), rng=near
            ),
        }


class Shown(NamedTuple):
    """One rendered view, in memory."""

    scene: Scene
    camera: str
    """``cam_00`` across the room, ``cam_01`` close to things."""
    picture: Picture
    frame: Frame


class Done(NamedTuple):
    """What one scene cost, in seconds of one core; views already there do not count."""

    scene: str
    rendered: int
    build_s: float
    views_s: float
    write_s: float


def stream(seed: int, index: int, use: int) -> np.random.Generator:
    """Random numbers of one scene that no other and no other use of it share."""
    return np.random.default_rng([seed, index, use])


def close_views(index: int, views: int) -> int:
    """How many of a scene's views are close ones; over many scenes a share of `CLOSE_SHARE`.

    >>> [close_views(i, 5) for i in range(8)]
    [0, 0, 0, 1, 0, 0, 0, 1]
    """
    share = round(views * CLOSE_SHARE, 9)
    return int((index + 1) * share) - int(index * share)


def split_of(index: int) -> str:
    """Partition of a scene: of ten, eight train, one validates, one tests.

    >>> [split_of(i) for i in range(7, 11)]
    ['train', 'val', 'test', 'train']
    """
    return {8: "val", 9: "test"}.get(index % 10, "train")


def shape_from_text(text: str) -> tuple[int, int]:
    """Height and width, px, of a size like ``768x1024``."""
    try:
        height, width = (int(part) for part in text.lower().split("x"))
    except ValueError as error:
        raise ValueError(f"Expected a size like 512x512, got {text}. Try 768x1024.") from error
    return height, width


def build(seed: int, index: int) -> Scene:
    """Build, furnish and light one room; the same pair of numbers gives the same room."""
    rng, rooms = stream(seed, index, _ROOM), presets()["rooms"]
    odds = np.array([room["weight"] for room in rooms.values()], float)
    kind = str(rng.choice(list(rooms), p=odds / odds.sum()))
    kit = household(rng)
    shell = build_shell(kit, rooms[kind])
    inside = Furnishing(shell, kit)
    tidy = kit.between(0.7, 1.5)
    inside.fill({name: tidy * mean for name, mean in rooms[kind]["things"].items()})
    for wall in shell.beyond:
        room = Shell(0.0, 0.0, 2.0, [wall], [(-99.0, 99.0, -99.0, 99.0)])
        far = Furnishing(room, kit)
        far.fill({"sideboard": 0.5, "picture": 0.7, "big_plant": 0.5, "bookcase": 0.3})
        inside.things += far.things
    first = len(shell.things) + 1
    things = shell.things + inside.things
    low, high = (0.1, 0.1, 0.1), (shell.width - 0.1, shell.depth - 0.1, shell.height - 0.1)
    world = World(things, _chosen(shell, inside.lights), (low, high), sky=shell.sky)
    numbers = range(first if inside.things else 1, len(things) + 1)
    return Scene(seed, index, kind, world, shell.floor, shell.height, numbers)


def _chosen(shell: Shell, lamps: list[Light]) -> list[Light]:
    """At most `LIGHTS` lights; the strongest lamps shine for those that were left out."""
    if not shell.lights and not lamps:  # a lamp that nobody sees
        middle = (shell.width / 2, shell.depth / 2, shell.height - 0.05)
        lamps = [Light(middle, (0.3, 0, 0), (0, 0.3, 0), (0, 0, -1), 2.0)]
    dimmed = 0.15 if shell.day else 1.0
    lamps = [lamp._replace(power=lamp.power * dimmed) for lamp in lamps]
    every = sorted([*shell.lights, *lamps], key=lambda light: -light.power)
    kept = every[:LIGHTS]
    more = sum(light.power for light in every) / sum(light.power for light in kept)
    return [light._replace(power=light.power * more) for light in kept]


DIM_SHARE, MEDIAN, CONTRAST, DIM = 0.2, 0.38, 0.85, 2.6
"""Share of views in twilight; a view's median brightness, its spread and what twilight takes, log.

They were found on other seeds, for the brightness of all pixels to be spread as Hypersim's.
"""


def expose(seen: Picture, rank: float) -> Picture:
    """Scale a view's light as photographs come out: its median log-normal, one in five dim.

    Parameters
    ----------
    rank : float
        0 to 1: which of all views, by brightness.
    """
    middle = float(np.median(brightness(seen.color)[np.isfinite(seen.depth)]))
    dim = rank < DIM_SHARE
    within = rank / DIM_SHARE if dim else (rank - DIM_SHARE) / (1 - DIM_SHARE)
    wanted = MEDIAN * np.exp(CONTRAST * ndtri(np.clip(within, 0.01, 0.99)) - DIM * dim)
    return seen._replace(color=seen.color * np.float32(wanted / max(middle, 1e-6)))


def render_view(scene: Scene, camera: Camera, lens: Lens, number: int) -> Picture:
    """One exposed view; ``number`` counts a scene's views.

    Exposures step by the golden section through scenes and views: even small sets have their
    share of dark and bright ones.
    """
    seen = scene.world.picture(camera.position, lens.rays(camera.orientation))
    start = stream(scene.seed, 0, _EXPOSURE).uniform()
    return expose(seen, (start + 0.6180339887498949 * (7 * scene.index + number)) % 1)


def rendered_views(settings: Settings) -> Iterator[Shown]:
    """Render a set in this process, view by view, without writing anything."""
    for index in range(settings.scenes):
        scene, lens = build(settings.seed, index), settings.lens(index)
        for camera, poses in scene.cameras(settings.views, lens).items():
            for number, pose in enumerate(poses):
                seen = render_view(scene, pose, lens, _number(camera, number))
                yield Shown(scene, camera, seen, frame_of(seen, lens, f"{scene.name}/{camera}"))


def frame_of(seen: Picture, lens: Lens, name: str) -> Frame:
    """Frame for the simulator: range, linear green, camera."""
    camera = np.array([lens.focal, lens.focal, lens.shape[1] / 2, lens.shape[0] / 2])
    return Frame(seen.depth, seen.color[..., 1], camera, name)


def _number(camera: str, frame: int) -> int:
    """Count of a view within its scene that does not depend on how many there are."""
    return frame + 4 * int(camera[-2:])


def view_exists(root: str | Path, scene: str, camera: str, frame: int) -> bool:
    """Whether all four files of a view are there, and therefore whole."""
    return all(View(scene, camera, frame).file(root, kind).is_file() for kind in FILES)


def write_view(root: str | Path, scene: str, camera: str, frame: int, **arrays: ArrayLike) -> None:
    """Write color (linear radiance), depth (m), normal and instance, whole and always alike."""
    import h5py

    for kind, (_, _, dtype) in FILES.items():
        path = View(scene, camera, frame).file(root, kind)
        path.parent.mkdir(parents=True, exist_ok=True)
        with np.errstate(over="ignore"):  # light beyond float16 is infinite, as in the original
            stored = np.asarray(arrays[kind]).astype(dtype)
        packed: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
        with h5py.File(content := io.BytesIO(), "w") as file:  # a full disk would end the process
            file.create_dataset("dataset", data=stored, track_times=False, **packed)
        with written_whole(path) as part:
            part.write_bytes(content.getvalue())


def render_scene(root: Path, settings: Settings, index: int) -> Done:
    """Write the views of one scene that are not there yet."""
    name, lens = f"room_{settings.seed:03d}_{index:03d}", settings.lens(index)
    missing = [v for v in _views(index, settings.views) if not view_exists(root, name, *v)]
    if not missing:
        return Done(name, 0, 0.0, 0.0, 0.0)
    start = process_time()
    scene = build(settings.seed, index)
    built = process_time()
    cameras = scene.cameras(settings.views, lens)
    writing = 0.0
    for camera, frame in missing:
        seen = render_view(scene, cameras[camera][frame], lens, _number(camera, frame))
        before = process_time()
        write_view(root, name, camera, frame, **seen._asdict())
        writing += process_time() - before
    return Done(name, len(missing), built - start, process_time() - built - writing, writing)


def _views(index: int, views: int) -> list[tuple[str, int]]:
    """Camera and frame of a scene's views: those across the room, then the close ones."""
    close = close_views(index, views)
    return [("cam_00", i) for i in range(views - close)] + [("cam_01", i) for i in range(close)]


def render_rooms(
    root: Path,
    settings: Settings,
    *,
    workers: int | None = None,
    progress: Callable[[Done], None] = lambda done: None,
) -> list[Done]:
    """Render a set of rooms; views that are there already are kept.

    Parameters
    ----------
    root : Path
        Folder, made where it is missing. It may hold a smaller set of the same settings.
    workers : int, optional
        Processes; by default one a core.
    progress : callable
        Called with each scene as it is done.

    Raises
    ------
    ValueError
        If the folder holds a set of other settings.
    """
    scenes = {
        f"room_{settings.seed:03d}_{i:03d}": (
            split_of(i),
            settings.lens(i).focal,
            _views(i, settings.views),
        )
        for i in range(settings.scenes)
    }
    results = []
    root.mkdir(parents=True, exist_ok=True)
    with alone(root, wait=True):
        _claim(root, settings)
        write_metadata(root, (settings.height, settings.width), scenes)
        for done in _each(root, settings, workers or os.cpu_count() or 1):
            progress(done)
            results.append(done)
    return results


def _each(root: Path, settings: Settings, workers: int) -> Iterator[Done]:
    """Scenes in order, by one process or several; an interrupted run begins no other."""
    if workers == 1:
        yield from (render_scene(root, settings, i) for i in range(settings.scenes))
        return
    spawn = get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawn, initializer=_follow) as pool:
        try:
            yield from pool.map(partial(render_scene, root, settings), range(settings.scenes))
        finally:
            pool.shutdown(cancel_futures=True)


def _follow() -> None:
    """End this worker with its parent, however that ends; Ctrl-C is for the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent: Any = parent_process()
    Thread(target=lambda: (parent.join(), os._exit(1)), daemon=True).start()


def _claim(root: Path, settings: Settings) -> None:
    """Write down what a folder holds, or make sure that it holds the same."""
    from cmtof import __version__

    for part in root.rglob(".*.part-*"):  # what a killed run had begun
        part.unlink(missing_ok=True)
    path = root / SETTINGS
    wanted = asdict(settings) | {"version": __version__}
    free = ("scenes", "views")  # a set may grow
    if path.is_file():
        found = read_document(path)
        if any(found.get(k) != v for k, v in wanted.items() if k not in free):
            raise ValueError(
                f"Expected an empty folder or one with {wanted}, got {found} in {path}. "
                "Choose another folder."
            )
    elif any(root.iterdir()):
        raise ValueError(
            f"Expected an empty folder or a set of rooms, got other files in {root}. "
            "Choose another folder."
        )
    with written_whole(path) as part:
        part.write_text(json.dumps(wanted, indent=2) + "\n", encoding="utf-8")
