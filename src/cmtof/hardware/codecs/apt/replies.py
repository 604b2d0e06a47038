"""Messages from an APT controller to the host: what they say."""

import struct
from dataclasses import dataclass

from cmtof.hardware.codecs.apt.ids import MessageId, Status
from cmtof.hardware.codecs.apt.message import Message
from cmtof.hardware.errors import BadReply


@dataclass(frozen=True)
class HardwareInfo:
    """HW_GET_INFO: who the controller is."""

    serial: int
    model: str
    firmware: str
    stage_id: int
    """Of the stage's memory chip: 6 PRM1-Z8, 7 MTS25-Z8, 8 MTS50-Z8, 9 Z825 (pylablib)."""
    channels: int


@dataclass(frozen=True)
class ChannelEnabled:
    """MOD_GET_CHANENABLESTATE."""

    channel: int
    enabled: bool


@dataclass(frozen=True)
class Position:
    """MOT_GET_POSCOUNTER, counts."""

    channel: int
    counts: int


@dataclass(frozen=True)
class Velocity:
    """MOT_GET_VELPARAMS, in the controller's units."""

    channel: int
    minimum: int
    acceleration: int
    maximum: int


@dataclass(frozen=True)
class Homing:
    """MOT_GET_HOMEPARAMS, in the controller's units."""

    channel: int
    direction: int
    limit_switch: int
    velocity: int
    offset: int


@dataclass(frozen=True)
class StatusBits:
    """MOT_GET_STATUSBITS."""

    channel: int
    status: Status


@dataclass(frozen=True)
class Homed:
    """MOT_MOVE_HOMED: homing is over."""

    channel: int


@dataclass(frozen=True)
class Motion:
    """MOT_MOVE_COMPLETED, MOT_MOVE_STOPPED or a status update.

    The status in MOVE_COMPLETED may still say that the motor moves: pnpq's tests hold a message of
    a real K10CR1 with both moving bits set. Ask for the status when it matters.

    Attributes
    ----------
    event : MessageId
        Which of them.
    channel : int
    counts : int or None
        Position; None where a short message told no more than the channel.
    status : Status or None
    velocity : int or None
        Velocity of a DC motor; in a stepper's update the low half of the encoder's count.
    """

    event: MessageId
    channel: int
    counts: int | None = None
    status: Status | None = None
    velocity: int | None = None


@dataclass(frozen=True)
class Fault:
    """HW_RESPONSE or HW_RICHRESPONSE: the controller complains.

    Attributes
    ----------
    about : int
        Identifier of the message it complains about, 0 where it does not say.
    code : int
    text : str
    """

    about: int = 0
    code: int = 0
    text: str = ""


Payload = (
    HardwareInfo
    | ChannelEnabled
    | Position
    | Velocity
    | Homing
    | StatusBits
    | Homed
    | Motion
    | Fault
)


_MOTION = frozenset(
    {
        MessageId.MOT_MOVE_COMPLETED,
        MessageId.MOT_MOVE_STOPPED,
        MessageId.MOT_GET_DCSTATUSUPDATE,
        MessageId.MOT_GET_STATUSUPDATE,
    }
)
# Sizes of the data of what units send; None is the short form.
SIZES: dict[int, tuple[int | None, ...]] = {
    MessageId.HW_GET_INFO: (84,),
    MessageId.HW_RESPONSE: (None,),
    MessageId.HW_RICHRESPONSE: (68,),
    MessageId.MOD_GET_CHANENABLESTATE: (None,),
    MessageId.MOT_GET_POSCOUNTER: (6,),
    MessageId.MOT_GET_VELPARAMS: (14,),
    MessageId.MOT_GET_STATUSBITS: (6,),
    MessageId.MOT_GET_HOMEPARAMS: (14,),
    MessageId.MOT_MOVE_HOMED: (None,),
    MessageId.MOT_MOVE_COMPLETED: (None, 14),
    MessageId.MOT_MOVE_STOPPED: (None, 14),
    MessageId.MOT_GET_DCSTATUSUPDATE: (14,),
    MessageId.MOT_GET_STATUSUPDATE: (14,),
}


def parse_message(message: Message) -> Payload:
    """What a message from a unit says.

    Raises
    ------
    BadReply
        If it is none of those that a unit sends, or its size is not theirs.
    """
    data = message.data
    if (None if data is None else len(data)) not in SIZES.get(message.id, ()):
        raise BadReply(
            f"Expected a message of an APT unit, got id {message.id:#06x} with "
            f"{'no data' if data is None else f'{len(data)} bytes'}. Flush and ask again."
        )
    name = MessageId(message.id)
    if data is None:
        return _parse_short(name, message.parameters)
    if name in _MOTION:
        channel, counts, velocity, _, bits = struct.unpack("<HihHI", data)
        return Motion(name, channel, counts, Status(bits), velocity)
    return _parse_long(name, data)


def _parse_short(name: MessageId, parameters: tuple[int, int]) -> Payload:
    if name is MessageId.MOT_MOVE_HOMED:
        return Homed(parameters[0])
    if name is MessageId.MOD_GET_CHANENABLESTATE:
        return ChannelEnabled(parameters[0], parameters[1] == 1)
    if name is MessageId.HW_RESPONSE:
        return Fault()
    return Motion(name, parameters[0])


def _parse_long(name: MessageId, data: bytes) -> Payload:
    if name is MessageId.HW_GET_INFO:
        return _parse_info(data)
    if name is MessageId.MOT_GET_POSCOUNTER:
        return Position(*struct.unpack("<Hi", data))
    if name is MessageId.MOT_GET_VELPARAMS:
        return Velocity(*struct.unpack("<Hiii", data))
    if name is MessageId.MOT_GET_HOMEPARAMS:
        return Homing(*struct.unpack("<HHHii", data))
    if name is MessageId.MOT_GET_STATUSBITS:
        channel, bits = struct.unpack("<HI", data)
        return StatusBits(channel, Status(bits))
    about, code, text = struct.unpack("<HH64s", data)
    return Fault(about, code, _text(text))


def _parse_info(data: bytes) -> HardwareInfo:
    serial, model, _, minor, interim, major, _ = struct.unpack_from("<I8sHBBBB", data)
    (stage,) = struct.unpack_from("<H", data, 76)
    (channels,) = struct.unpack_from("<H", data, 82)
    return HardwareInfo(serial, _text(model), f"{major}.{interim}.{minor}", stage, channels)


def _text(data: bytes) -> str:
    return data.split(b"\0", 1)[0].decode("ascii", "replace").strip()
