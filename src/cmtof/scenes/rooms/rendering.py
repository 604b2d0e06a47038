"""Rooms on disk: many scenes, all cores, in Hypersim's layout, whole or absent, resumable."""

import json
import os
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from time import process_time
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from cmtof.files import written_whole
from cmtof.scenes.frame import Frame, brightness
from cmtof.scenes.hypersim import view_exists, write_metadata, write_scene, write_view
from cmtof.scenes.rooms.cameras import Camera, Lens
from cmtof.scenes.rooms.scene import Scene, build, close_views, scene_name, stream
from cmtof.scenes.rooms.view import Picture, picture

SETTINGS = "rooms.json"
"""File in a set's folder that says what it was made from."""

DIM_SHARE = 0.2
"""Share of views that are taken in twilight."""

_LENS, _EXPOSURE = 8, 9  # streams of random numbers


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
        for name in ("scenes", "views", "height", "width"):
            if getattr(self, name) < 1:
                raise ValueError(
                    f"Expected {name} of at least 1, got {getattr(self, name)}. Ask for more."
                )
        if self.seed < 0:
            raise ValueError(f"Expected a seed >= 0, got {self.seed}. Choose another.")

    def lens(self, index: int) -> Lens:
        """Lens of one scene."""
        angle = np.radians(stream(self.seed, index, _LENS).choice([60, 60, 60, 52, 44, 35]))
        drawn = self.width / 2 / np.tan(angle / 2)
        return Lens((self.height, self.width), float(self.focal or drawn))


def shape_from_text(text: str) -> tuple[int, int]:
    """Height and width, px, of a size like ``768x1024``."""
    try:
        height, width = (int(part) for part in text.lower().split("x"))
    except ValueError as error:
        raise ValueError(f"Expected a size like 512x512, got {text}. Try 768x1024.") from error
    return height, width


class Done(NamedTuple):
    """What one scene cost, all in seconds of one core."""

    scene: str
    rendered: int
    """Views written; those that were there already do not count."""
    build_s: float
    views_s: float
    """Rendering, without building and writing."""
    write_s: float
    rays: int
    """All rays, those for cameras and for the light of the scene too."""
    rays_s: float
    """Time within Embree alone for those rays."""

    @property
    def total_s(self) -> float:
        """All of it."""
        return self.build_s + self.views_s + self.write_s


def split_of(index: int) -> str:
    """Partition of a scene: of ten, eight train, one validates, one tests.

    Examples
    --------
    >>> [split_of(i) for i in range(7, 11)]
    ['train', 'val', 'test', 'train']
    """
    return {8: "val", 9: "test"}.get(index % 10, "train")


def expose(seen: Picture, rank: float) -> Picture:
    """Scale a view's light as photographs come out: its median log-normal, one in five dim.

    Parameters
    ----------
    rank : float
        0 to 1: which of all views, by brightness. Width and share of dim views were found on
        other seeds, for the brightness of all pixels to be spread as Hypersim's.
    """
    middle = float(np.median(brightness(seen.color)[np.isfinite(seen.depth)]))
    dim = rank < DIM_SHARE
    within = rank / DIM_SHARE if dim else (rank - DIM_SHARE) / (1 - DIM_SHARE)
    wanted = 0.38 * np.exp(0.85 * ndtri(np.clip(within, 0.01, 0.99)) - 2.6 * dim)
    return seen._replace(color=seen.color * np.float32(wanted / max(middle, 1e-6)))


def render_view(scene: Scene, camera: Camera, lens: Lens, number: int) -> Picture:
    """One exposed view; ``number`` counts a scene's views.

    Exposures step by the golden section through scenes and views: even small sets have their
    share of dark and bright ones.
    """
    seen = picture(scene.light, camera.position, lens.rays(camera.orientation))
    start = stream(scene.seed, 0, _EXPOSURE).uniform()
    return expose(seen, (start + 0.6180339887498949 * (7 * scene.index + number)) % 1)


class Shown(NamedTuple):
    """One rendered view, in memory."""

    scene: Scene
    camera: str
    """``cam_00`` across the room, ``cam_01`` close to things."""
    picture: Picture
    frame: Frame


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


def render_scene(root: Path, settings: Settings, index: int) -> Done:
    """Write the views of one scene that are not there yet."""
    name, lens = scene_name(settings.seed, index), settings.lens(index)
    missing = [v for v in _views(index, settings.views) if not view_exists(root, name, *v)]
    if not missing:
        return Done(name, 0, 0.0, 0.0, 0.0, 0, 0.0)
    start = process_time()
    scene = build(settings.seed, index)
    built = process_time()
    cameras = scene.cameras(settings.views, lens)
    tracer = scene.light.tracer
    poses = {c: (np.stack([p.position for p in v]), np.stack([p.orientation for p in v]))
             for c, v in cameras.items() if v}  # fmt: skip
    write_scene(root, name, cameras=poses)
    writing = 0.0
    for camera, frame in missing:
        seen = render_view(scene, cameras[camera][frame], lens, _number(camera, frame))
        before = process_time()
        write_view(root, name, camera, frame, **seen._asdict())
        writing += process_time() - before
    views_s = process_time() - built - writing
    costs = (built - start, views_s, writing, tracer.rays, tracer.seconds)
    return Done(name, len(missing), *costs)


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
        Told of each scene as it is done.

    Raises
    ------
    ValueError
        If the folder holds a set of other settings.
    """
    _claim(root, settings)
    names = {scene_name(settings.seed, i): i for i in range(settings.scenes)}
    write_metadata(
        root,
        {name: split_of(i) for name, i in names.items()},
        shape=(settings.height, settings.width),
        focal={name: settings.lens(i).focal for name, i in names.items()},
        views={name: _views(i, settings.views) for name, i in names.items()},
    )
    results = []
    for done in _each(root, settings, workers or os.cpu_count() or 1):
        progress(done)
        results.append(done)
    return sorted(results)


def _each(root: Path, settings: Settings, workers: int) -> Iterator[Done]:
    """Scenes as they are done; a few are under way at a time, so that Ctrl-C stops soon."""
    if workers == 1:
        yield from (render_scene(root, settings, i) for i in range(settings.scenes))
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        waiting: set[Future[Done]] = set()
        try:
            for index in range(settings.scenes):
                waiting.add(pool.submit(render_scene, root, settings, index))
                if len(waiting) > workers:
                    ready, waiting = wait(waiting, return_when=FIRST_COMPLETED)
                    yield from (future.result() for future in ready)
            while waiting:
                ready, waiting = wait(waiting, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in ready)
        finally:
            pool.shutdown(cancel_futures=True)


def _claim(root: Path, settings: Settings) -> None:
    """Write down what a folder holds, or make sure that it holds the same."""
    from cmtof import __version__

    root.mkdir(parents=True, exist_ok=True)
    path = root / SETTINGS
    wanted = asdict(settings) | {"version": __version__}
    free = ("scenes", "views")  # a set may grow
    if path.is_file():
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise ValueError(
                f"Expected settings in {path}, got {error}. Choose an empty folder."
            ) from error
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
