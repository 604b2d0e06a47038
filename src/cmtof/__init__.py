"""Centimetre-wave free-space time-of-flight imaging: simulation, measurement, unwrapping.

The most used functions are at the top level::

    measurement = cmtof.simulate(cmtof.load_frame("still_life"), seed=0)
    measurement = cmtof.open("scan.nc")
    result = cmtof.unwrap(measurement)

Everything else is in modules named by subject. The names below are resolved on first use,
so that ``import cmtof`` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"
__all__ = ["Measurement", "load_frame", "open", "simulate", "unwrap"]

if TYPE_CHECKING:
    from cmtof.measurement import Measurement
    from cmtof.measurement import open_measurement as open
    from cmtof.scenes import load_frame
    from cmtof.simulation import simulate
    from cmtof.unwrapping import unwrap

# Module of each top-level name.
WHERE = {
    "Measurement": "cmtof.measurement",
    "load_frame": "cmtof.scenes",
    "open": "cmtof.measurement",
    "simulate": "cmtof.simulation",
    "unwrap": "cmtof.unwrapping",
}


def __getattr__(name: str) -> Any:
    if name not in WHERE:
        raise AttributeError(f"module 'cmtof' has no attribute {name!r}")
    return getattr(
        import_module(WHERE[name]), "open_measurement" if name == "open" else name
    )
