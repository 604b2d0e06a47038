"""Bytes to and from an instrument: TCP, serial line, VISA, or the replay of a dialogue."""

from cmtof.hardware.transport.address import open_transport
from cmtof.hardware.transport.buffered import Transport
from cmtof.hardware.transport.replay import ReplayTransport
from cmtof.hardware.transport.serial_line import SerialTransport
from cmtof.hardware.transport.tcp import TcpTransport
from cmtof.hardware.transport.visa import VisaTransport

__all__ = [
    "ReplayTransport",
    "SerialTransport",
    "TcpTransport",
    "Transport",
    "VisaTransport",
    "open_transport",
]
