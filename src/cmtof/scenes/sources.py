"""Frames that are still on disk: listed at once, loaded one by one, broken ones skipped."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from cmtof.scenes.rgbd import Frame


@dataclass(frozen=True)
class Source:
    """A frame that can be loaded.

    Attributes
    ----------
    name : str
        Which frame it is.
    load : callable
        Loads it; raises ValueError or OSError where it is broken or missing.
    """

    name: str
    load: Callable[[], Frame]


@dataclass
class Frames:
    """Frames of some sources in their order, those left out that cannot be loaded.

    Attributes
    ----------
    sources : iterable of Source
    skipped : dict
        Name and reason of each frame that was left out since the latest start.

    Examples
    --------
    >>> def broken() -> Frame:
    ...     raise ValueError("Expected a whole file, got a part. Fetch it anew.")
    >>> good = Source("good", lambda: Frame([[1.0]], [[0.5]], name="good"))
    >>> frames = Frames([good, Source("bad", broken)])
    >>> [frame.name for frame in frames], frames.skipped
    (['good'], {'bad': 'Expected a whole file, got a part. Fetch it anew.'})
    """

    sources: Iterable[Source]
    skipped: dict[str, str] = field(default_factory=dict)

    def __iter__(self) -> Iterator[Frame]:
        self.skipped.clear()
        for source in self.sources:
            try:
                frame = source.load()
            except (ValueError, OSError) as error:
                self.skipped[source.name] = str(error)
                continue
            yield frame
