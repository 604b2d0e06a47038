"""Thorlabs APT: binary messages of the motor controllers KDC101, K10CR1 and their kin.

A message is a header of six bytes, ``id u16, parameter u8, parameter u8, destination u8, source
u8``, or, with the top bit of the destination set, ``id u16, length u16, destination u8, source u8``
and as many bytes of data; all little-endian (Thorlabs, APT Communications Protocol, "Description of
the message header"; InstrumentKit's and pylablib's drivers do the same). Units send MOVE_HOMED,
MOVE_COMPLETED, MOVE_STOPPED and status updates unasked, at any time.

Positions and velocities are in the controller's own counts here; their scale belongs to the stage.
"""

from cmtof.hardware.codecs.apt.ids import HOST, UNIT, MessageId, Status
from cmtof.hardware.codecs.apt.message import Message
from cmtof.hardware.codecs.apt.replies import (
    ChannelEnabled,
    Fault,
    HardwareInfo,
    Homed,
    Homing,
    Motion,
    Payload,
    Position,
    StatusBits,
    Velocity,
    parse_message,
)
from cmtof.hardware.codecs.apt.requests import (
    acknowledge,
    enable,
    identify,
    move_absolute,
    move_home,
    move_relative,
    no_flash_programming,
    request_enabled,
    request_homing,
    request_info,
    request_position,
    request_status,
    request_status_bits,
    request_velocity,
    set_homing,
    set_position,
    set_velocity,
    start_updates,
    stop,
    stop_updates,
)
from cmtof.hardware.codecs.apt.unpacker import Unpacker

__all__ = [
    "HOST",
    "UNIT",
    "ChannelEnabled",
    "Fault",
    "HardwareInfo",
    "Homed",
    "Homing",
    "Message",
    "MessageId",
    "Motion",
    "Payload",
    "Position",
    "Status",
    "StatusBits",
    "Unpacker",
    "Velocity",
    "acknowledge",
    "enable",
    "identify",
    "move_absolute",
    "move_home",
    "move_relative",
    "no_flash_programming",
    "parse_message",
    "request_enabled",
    "request_homing",
    "request_info",
    "request_position",
    "request_status",
    "request_status_bits",
    "request_velocity",
    "set_homing",
    "set_position",
    "set_velocity",
    "start_updates",
    "stop",
    "stop_updates",
]
