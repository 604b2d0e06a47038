"""Sets of rooms from a seed: rendered, exposed, and written in Hypersim's layout, resumable."""

import io
import json
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from multiprocessing import get_context, parent_process
from pathlib import Path
from threading import Thread
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from cmtof.files import atomic_output, exclusive_lock, read_document
from cmtof.frame import Frame, brightness
from cmtof.hypersim import FILES, View, write_metadata
from cmtof.terminal import delay_interrupts
from cmtof.types import Shape
from cmtof_rooms.cameras import Lens
from cmtof_rooms.interior import Picture
from cmtof_rooms.rooms import (
    EXPOSURE,
    LENS,
    FurnishedRoom,
    build_room,
    count_views,
    room_name,
    stream,
)

SETTINGS = "rooms.json"  # file in a set's folder that says what it was made from

LARGEST = 4096  # height and width of a view at most, px


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
        px; by default each room has a lens of its own, from 60 degrees across (Hypersim's usual
        one) down to 35.
    """

    seed: int = 0
    scenes: int = 20
    views: int = 5
    height: int = 512
    width: int = 512
    focal: float | None = None

    def lens(self, index: int) -> Lens:
        """Lens of one room.

        Raises
        ------
        ValueError
            If the focal length is not one of 1 to 1e6 px.
        """
        angle = np.radians(
            stream(self.seed, index, LENS).choice([60, 60, 60, 52, 44, 35])
        )
        focal = self.focal
        if focal is None:
            focal = float(self.width / 2 / np.tan(angle / 2))
        if not 1 <= focal < 1e6:
            raise ValueError(
                f"Expected a focal length of 1 to 1e6 px, got {focal}. Try the width."
            )
        return Lens((self.height, self.width), focal)


class RenderedView(NamedTuple):
    """One rendered view, in memory."""

    view: View
    room: FurnishedRoom
    lens: Lens
    picture: Picture

    @property
    def frame(self) -> Frame:
        """Frame for the simulator: range, linear green, camera."""
        return Frame(
            self.picture.depth,
            self.picture.color[..., 1],
            self.lens.camera,
            f"{self.view.scene}/{self.view.camera}",
        )


def split_of(index: int) -> str:
    """Partition of a room: of ten, eight train, one validates, one tests.

    >>> [split_of(i) for i in range(7, 11)]
    ['train', 'val', 'test', 'train']
    """
    return {8: "val", 9: "test"}.get(index % 10, "train")


def shape_from_text(text: str) -> Shape:
    """Height and width, px, of a size like ``768x1024``.

    Raises
    ------
    ValueError
        If it is none, or not of 1 to `LARGEST` px.
    """
    try:
        height, width = map(int, text.lower().split("x"))
    except ValueError as error:
        raise ValueError(
            f"Expected a size like 512x512, got {text}. Try 768x1024."
        ) from error
    if not (1 <= height <= LARGEST and 1 <= width <= LARGEST):
        raise ValueError(
            f"Expected 1 to {LARGEST} px, got a size of {text}. Try 768x1024."
        )
    return height, width


# Found on other seeds, for the brightness of all pixels to be spread as Hypersim's.
DIM_SHARE = 0.2  # share of views in twilight
MEDIAN = 0.38  # median brightness of the other views
CONTRAST = 0.85  # standard deviation of the logarithm of views' brightness
DIM = 2.6  # what twilight takes from that logarithm


def expose(seen: Picture, rank: float) -> Picture:
    """Scale a view's light as photographs come out: its median log-normal, one in five dim.

    Parameters
    ----------
    seen : Picture
    rank : float
        0 to 1: which of all views, by brightness.
    """
    middle = np.median(brightness(seen.color)[np.isfinite(seen.depth)])
    dim = rank < DIM_SHARE
    within = rank / DIM_SHARE if dim else (rank - DIM_SHARE) / (1 - DIM_SHARE)
    wanted = MEDIAN * np.exp(CONTRAST * ndtri(np.clip(within, 0.01, 0.99)) - DIM * dim)
    return seen._replace(color=seen.color * np.float32(wanted / max(middle, 1e-6)))


def render_views(settings: Settings) -> Iterator[RenderedView]:
    """Render a set in this process, view by view, without writing anything."""
    for index in range(settings.scenes):
        yield from views_of_room(settings, index, list_views(settings, index))


def list_views(settings: Settings, index: int) -> list[View]:
    """Views of a room: those across it (``cam_00``), then those close to things (``cam_01``)."""
    name = room_name(settings.seed, index)
    counts = count_views(index, settings.views).items()
    return [View(name, camera, k) for camera, count in counts for k in range(count)]


def views_of_room(
    settings: Settings, index: int, views: list[View]
) -> Iterator[RenderedView]:
    """Render and expose some of the views of one room.

    Exposures step by the golden section through rooms and views: even small sets have their share
    of dark and bright ones.
    """
    room = build_room(settings.seed, index)
    lens = settings.lens(index)
    cameras = room.cameras(settings.views, lens)
    start = stream(settings.seed, 0, EXPOSURE).uniform()
    for view in views:
        pose = cameras[view.camera][view.number]
        seen = room.interior.render(pose.position, lens.rays(pose.orientation))
        # this count of a view does not depend on how many there are
        count = 7 * index + view.number + 4 * (view.camera == "cam_01")
        rank = (start + 0.6180339887498949 * count) % 1
        yield RenderedView(view, room, lens, expose(seen, rank))


def view_exists(root: Path, view: View) -> bool:
    """Whether all four files of a view are there, and therefore whole."""
    return all(view.file(root, kind).is_file() for kind in FILES)


def write_view(root: Path, view: View, **arrays: ArrayLike) -> None:
    """Write color (linear radiance), depth (m), normal, instance: whole, equal bytes each time."""
    import h5py

    for kind, (_, _, dtype) in FILES.items():
        path = view.file(root, kind)
        path.parent.mkdir(parents=True, exist_ok=True)
        with np.errstate(
            over="ignore"
        ):  # light beyond float16 is infinite, as in the original
            stored = np.asarray(arrays[kind]).astype(dtype)
        with h5py.File(
            content := io.BytesIO(), "w"
        ) as file:  # a full disk would end the process
            file.create_dataset(
                "dataset",
                data=stored,
                track_times=False,
                compression="gzip",
                compression_opts=1,
                shuffle=True,
            )
        with atomic_output(path) as part:
            part.write_bytes(content.getvalue())


def render_room(root: Path, settings: Settings, index: int) -> int:
    """Write the views of one room that are not there yet, and return how many these were."""
    views = list_views(settings, index)
    missing = [view for view in views if not view_exists(root, view)]
    for seen in views_of_room(settings, index, missing) if missing else ():
        write_view(root, seen.view, **seen.picture._asdict())
    return len(missing)


def render_rooms(
    root: Path,
    settings: Settings,
    *,
    workers: int | None = None,
    progress: Callable[[str], None] = lambda scene: None,
) -> int:
    """Render a set of rooms; views that are there already are kept.

    Parameters
    ----------
    root : Path
        Folder, made where it is missing. It may hold more or fewer rooms or views of the same
        settings; listed are then those of this call.
    settings : Settings
    workers : int, optional
        Processes; by default one a core.
    progress : callable
        Called with the name of each room as it is done.

    Returns
    -------
    int
        How many views were rendered.

    Raises
    ------
    ValueError
        If the folder holds a set of other settings or other files, or the focal length is
        impossible.
    """
    scenes = {
        room_name(settings.seed, index): (
            split_of(index),
            settings.lens(index).focal,
            [view[1:3] for view in list_views(settings, index)],
        )
        for index in range(settings.scenes)
    }
    rendered = 0
    root.mkdir(parents=True, exist_ok=True)
    with exclusive_lock(root, wait=True):
        _claim(root, settings)
        write_metadata(root, (settings.height, settings.width), scenes)
        counts = _each(root, settings, workers)
        for scene, count in zip(scenes, counts, strict=True):
            progress(scene)
            rendered += count
    return rendered


def _each(root: Path, settings: Settings, workers: int | None) -> Iterator[int]:
    """Render rooms in order by one process or several; none begins after Ctrl-C.

    Yields how many views of each were rendered.
    """
    render = partial(render_room, root, settings)
    if workers == 1:
        yield from map(render, range(settings.scenes))
        return
    spawn = get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawn, initializer=_follow) as pool:
        try:
            with delay_interrupts():  # Ctrl-C is for the parent
                counts = pool.map(render, range(settings.scenes))
            yield from counts
        finally:
            pool.shutdown(cancel_futures=True)


def _follow() -> None:
    """End this worker with its parent, however that ends."""
    parent: Any = parent_process()
    Thread(target=lambda: (parent.join(), os._exit(1)), daemon=True).start()


def _claim(root: Path, settings: Settings) -> None:
    """Write a set's settings into its folder; a ValueError if the folder holds anything else."""
    from cmtof import __version__

    for part in root.rglob(".*.part-*"):  # what a killed run had begun
        part.unlink(missing_ok=True)
    path = root / SETTINGS
    wanted = asdict(settings) | {"version": __version__}
    if path.is_file():
        found = read_document(path)
        # a set may grow
        if found | {"scenes": settings.scenes, "views": settings.views} != wanted:
            raise ValueError(
                f"Expected an empty folder or one with {wanted}, got {found} in {path}. "
                "Choose another folder."
            )
    elif any(root.iterdir()):
        raise ValueError(
            f"Expected an empty folder or a set of rooms, got other files in {root}. "
            "Choose another folder."
        )
    with atomic_output(path) as part:
        part.write_text(json.dumps(wanted, indent=2) + "\n", encoding="utf-8")
