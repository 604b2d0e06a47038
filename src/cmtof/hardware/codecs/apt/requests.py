"""Messages from the host to an APT controller, as bytes."""

import struct

from cmtof.hardware.codecs.apt.ids import MessageId
from cmtof.hardware.codecs.apt.message import Message
from cmtof.hardware.codecs.apt.replies import Homing


def _short(id_: MessageId, first: int = 0, second: int = 0) -> bytes:
    return Message(id_, (first, second)).to_bytes()


def _long(id_: MessageId, form: str, *values: int) -> bytes:
    try:
        data = struct.pack(form, *values)
    except struct.error:
        raise ValueError(
            f"Expected {id_.name} within 32 bits, got {values}. Keep to the stage's travel."
        ) from None
    return Message(id_, data=data).to_bytes()


def request_info() -> bytes:
    """Ask who the controller is."""
    return _short(MessageId.HW_REQ_INFO)


def no_flash_programming() -> bytes:
    """Tell the controller that no firmware follows; some wait for it after power-up."""
    return _short(MessageId.HW_NO_FLASH_PROGRAMMING)


def start_updates() -> bytes:
    """Have status updates sent unasked, about ten a second."""
    return _short(MessageId.HW_START_UPDATEMSGS)


def stop_updates() -> bytes:
    """Have no status updates sent unasked."""
    return _short(MessageId.HW_STOP_UPDATEMSGS)


def identify(channel: int = 1) -> bytes:
    """Blink the front panel."""
    return _short(MessageId.MOD_IDENTIFY, channel)


def enable(on: bool, channel: int = 1) -> bytes:
    """Turn a channel on or off."""
    return _short(MessageId.MOD_SET_CHANENABLESTATE, channel, 1 if on else 2)


def request_enabled(channel: int = 1) -> bytes:
    """Ask whether a channel is on."""
    return _short(MessageId.MOD_REQ_CHANENABLESTATE, channel)


def request_position(channel: int = 1) -> bytes:
    """Ask for the position."""
    return _short(MessageId.MOT_REQ_POSCOUNTER, channel)


def set_position(counts: int, channel: int = 1) -> bytes:
    """Call the present position ``counts``; nothing moves."""
    return _long(MessageId.MOT_SET_POSCOUNTER, "<Hi", channel, counts)


def request_velocity(channel: int = 1) -> bytes:
    """Ask for acceleration and velocity."""
    return _short(MessageId.MOT_REQ_VELPARAMS, channel)


def set_velocity(acceleration: int, maximum: int, channel: int = 1) -> bytes:
    """Set acceleration and velocity of moves, in the controller's units."""
    return _long(MessageId.MOT_SET_VELPARAMS, "<Hiii", channel, 0, acceleration, maximum)


def request_status_bits(channel: int = 1) -> bytes:
    """Ask for the status bits."""
    return _short(MessageId.MOT_REQ_STATUSBITS, channel)


def request_homing(channel: int = 1) -> bytes:
    """Ask how homing is done."""
    return _short(MessageId.MOT_REQ_HOMEPARAMS, channel)


def set_homing(homing: Homing) -> bytes:
    """Set how homing is done, in the controller's units."""
    return _long(
        MessageId.MOT_SET_HOMEPARAMS,
        "<HHHii",
        homing.channel,
        homing.direction,
        homing.limit_switch,
        homing.velocity,
        homing.offset,
    )


def move_home(channel: int = 1) -> bytes:
    """Home; MOVE_HOMED follows.

    Examples
    --------
    >>> move_home().hex(" ")
    '43 04 01 00 50 01'
    """
    return _short(MessageId.MOT_MOVE_HOME, channel)


def move_relative(counts: int, channel: int = 1) -> bytes:
    """Move by ``counts``; MOVE_COMPLETED follows."""
    return _long(MessageId.MOT_MOVE_RELATIVE, "<Hi", channel, counts)


def move_absolute(counts: int, channel: int = 1) -> bytes:
    """Move to ``counts``; MOVE_COMPLETED follows.

    Examples
    --------
    >>> move_absolute(345550).hex(" ")  # 10 mm of an MTS50-Z8
    '53 04 06 00 d0 01 01 00 ce 45 05 00'
    """
    return _long(MessageId.MOT_MOVE_ABSOLUTE, "<Hi", channel, counts)


def stop(*, profiled: bool = False, channel: int = 1) -> bytes:
    """Stop, at once or along the ramp; MOVE_STOPPED follows."""
    return _short(MessageId.MOT_MOVE_STOP, channel, 2 if profiled else 1)


def request_status(channel: int = 1, *, stepper: bool = False) -> bytes:
    """Ask for position and status of a DC motor (KDC101) or a stepper (K10CR1)."""
    name = MessageId.MOT_REQ_STATUSUPDATE if stepper else MessageId.MOT_REQ_DCSTATUSUPDATE
    return _short(name, channel)


def acknowledge() -> bytes:
    """Tell a unit that sends status updates unasked that the host still listens."""
    return _short(MessageId.MOT_ACK_DCSTATUSUPDATE)
