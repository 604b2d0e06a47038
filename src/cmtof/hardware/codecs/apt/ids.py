"""Numbers of the APT protocol: identifiers, addresses, status bits."""

from enum import IntEnum, IntFlag

HOST, UNIT = 0x01, 0x50
"""Addresses of the host and of a controller on its own USB line."""
HEADER_SIZE = 6
LONG = 0x80
# rack controller, bays 1 to 10, USB unit
SOURCES = frozenset({0x11, *range(0x21, 0x2B), UNIT})


class MessageId(IntEnum):
    """Identifiers of the messages that this rig uses, named as in the protocol document."""

    HW_NO_FLASH_PROGRAMMING = 0x0018
    HW_START_UPDATEMSGS = 0x0011
    HW_STOP_UPDATEMSGS = 0x0012
    HW_REQ_INFO = 0x0005
    HW_GET_INFO = 0x0006
    HW_RESPONSE = 0x0080
    HW_RICHRESPONSE = 0x0081
    MOD_SET_CHANENABLESTATE = 0x0210
    MOD_REQ_CHANENABLESTATE = 0x0211
    MOD_GET_CHANENABLESTATE = 0x0212
    MOD_IDENTIFY = 0x0223
    MOT_SET_POSCOUNTER = 0x0410
    MOT_REQ_POSCOUNTER = 0x0411
    MOT_GET_POSCOUNTER = 0x0412
    MOT_SET_VELPARAMS = 0x0413
    MOT_REQ_VELPARAMS = 0x0414
    MOT_GET_VELPARAMS = 0x0415
    MOT_REQ_STATUSBITS = 0x0429
    MOT_GET_STATUSBITS = 0x042A
    MOT_SET_HOMEPARAMS = 0x0440
    MOT_REQ_HOMEPARAMS = 0x0441
    MOT_GET_HOMEPARAMS = 0x0442
    MOT_MOVE_HOME = 0x0443
    MOT_MOVE_HOMED = 0x0444
    MOT_MOVE_RELATIVE = 0x0448
    MOT_MOVE_ABSOLUTE = 0x0453
    MOT_MOVE_COMPLETED = 0x0464
    MOT_MOVE_STOP = 0x0465
    MOT_MOVE_STOPPED = 0x0466
    MOT_REQ_STATUSUPDATE = 0x0480
    MOT_GET_STATUSUPDATE = 0x0481
    MOT_REQ_DCSTATUSUPDATE = 0x0490
    MOT_GET_DCSTATUSUPDATE = 0x0491
    MOT_ACK_DCSTATUSUPDATE = 0x0492


class Status(IntFlag):
    """Status bits of a motor.

    Public drivers disagree on which of the first two is forward (thorlabs-apt-protocol) and which
    backward (pylablib), so they are called clockwise and counter-clockwise here. Not verified.
    """

    LIMIT_CW = 1 << 0
    LIMIT_CCW = 1 << 1
    MOVING_CW = 1 << 4
    MOVING_CCW = 1 << 5
    JOGGING_CW = 1 << 6
    JOGGING_CCW = 1 << 7
    CONNECTED = 1 << 8
    HOMING = 1 << 9
    HOMED = 1 << 10
    TRACKING = 1 << 12
    SETTLED = 1 << 13
    MOTION_ERROR = 1 << 14
    CURRENT_LIMIT = 1 << 24
    ENABLED = 1 << 31

    @property
    def moving(self) -> bool:
        """Whether the motor moves, jogs or homes."""
        return bool(self & _IN_MOTION)


_IN_MOTION = (
    Status.MOVING_CW | Status.MOVING_CCW | Status.JOGGING_CW | Status.JOGGING_CCW | Status.HOMING
)
