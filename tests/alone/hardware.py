"""What the extra `hardware` promises: the drivers of every instrument."""

import serial

from cmtof.hardware import apt, rf, scpi, t7  # noqa: F401

rf.open_serial("loop://").close()
try:
    scpi.open_visa("TCPIP::127.0.0.1::1::SOCKET")
except (OSError, serial.SerialException) as error:
    assert "pip install" not in str(error)
