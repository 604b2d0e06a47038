"""What the extra `hardware` promises: the drivers of every instrument."""

import serial

from cmtof.hardware import apt, rf, scpi, t7

for name in (apt.Motor, rf.RfDriver, scpi.PowerMeter, scpi.SignalGenerator, t7.LabJackT7):
    assert isinstance(name, type)
rf.open_serial("loop://").close()
try:
    scpi.open_visa("TCPIP::127.0.0.1::1::SOCKET")
except (OSError, serial.SerialException) as error:
    assert "pip install" not in str(error)
