"""Centimetre-wave free-space time-of-flight imaging, rebuilt from the light up.

The three verbs of everyday use stand at the top level::

    measurement = cmtof.simulate(cmtof.load_frame("still_life"), seed=0)
    measurement = cmtof.open("scan.nc")
    result = cmtof.unwrap(measurement)

Everything else lives in modules named after the thing. The names below are resolved on first use,
so that ``import cmtof`` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from cmtof.measurement import Measurement
    from cmtof.measurement import open_measurement as open
    from cmtof.scenes import load_frame
    from cmtof.simulation import simulate
    from cmtof.unwrapping import unwrap

_WHERE = {
    "Measurement": ("cmtof.measurement", "Measurement"),
    "load_frame": ("cmtof.scenes", "load_frame"),
    "open": ("cmtof.measurement", "open_measurement"),
    "simulate": ("cmtof.simulation", "simulate"),
    "unwrap": ("cmtof.unwrapping", "unwrap"),
}
_MODULES = {"correlation", "measurement", "metrics", "paper", "plotting", "unwrapping"}

__all__ = ["Measurement", "load_frame", "open", "simulate", "unwrap"]


def __getattr__(name: str) -> Any:
    if name in _WHERE:
        module, attribute = _WHERE[name]
        return getattr(import_module(module), attribute)
    if name in _MODULES:
        return import_module(f"cmtof.{name}")
    raise AttributeError(f"module 'cmtof' has no attribute {name!r}")
