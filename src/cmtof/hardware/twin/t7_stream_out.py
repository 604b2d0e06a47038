"""Stream-out of the simulated T7: values that a running stream writes to a port, one a scan.

Sources: T-Series Datasheet 3.2.3 Stream-Out; ljm_constants.json, registers and errors. Not
verified: that it goes on where it stopped when the next stream starts.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cmtof.hardware.twin.modbus_frames import DEVICE_FAILURE, ILLEGAL_VALUE, ModbusError
from cmtof.hardware.twin.t7_registers import T7Registers

_TARGETS = (1000, 1002, 2500, 2501, 2502, 2503)  # DACs and ports; no single line is streamable
_LARGEST = 16384
_BUFFER_FULL, _TARGET_INVALID, _SIZE_INVALID, _NO_BUFFER = 2613, 2614, 2615, 2617


class StreamOut:
    """One of the four stream-outs.

    Parameters
    ----------
    registers : T7Registers
    number : int
    locked : callable
        Raises `ModbusError` while a stream runs.
    """

    def __init__(self, registers: T7Registers, number: int, locked: Callable[[], None]) -> None:
        self._name, self._locked = f"STREAM_OUT{number}", locked
        self._registers = registers
        self._data: list[int] = []
        self._place = 0
        registers.on_write(f"{self._name}_TARGET", self._set_target)
        registers.on_write(f"{self._name}_BUFFER_ALLOCATE_NUM_BYTES", self._allocate)
        registers.on_write(f"{self._name}_SET_LOOP", self._set_loop)
        registers.on_read(f"{self._name}_BUFFER_STATUS", lambda: float(self._room()))
        registers.on_buffer_write(f"{self._name}_BUFFER_U16", lambda data: self._fill(data, 2))
        registers.on_buffer_write(f"{self._name}_BUFFER_F32", lambda data: self._fill(data, 4))

    @property
    def enabled(self) -> bool:
        """Whether it may stand in a scan list."""
        return bool(self._value("ENABLE"))

    @property
    def target(self) -> int:
        """Address that it writes to."""
        return int(self._value("TARGET"))

    def take(self, scans: int) -> NDArray[np.int64] | None:
        """Values of the next scans, (scans,); None without data.

        After its end the data is repeated from ``LOOP_NUM_VALUES`` before the end, or stays.
        """
        if not self._data:
            return None
        size = len(self._data)
        loop = min(int(self._value("LOOP_NUM_VALUES")), size)
        index = self._place + np.arange(scans)
        over = size - loop + (index - size) % loop if loop else size - 1
        index = np.where(index < size, index, over)
        self._place += scans
        if loop and self._place > size:
            self._place = size - loop + (self._place - size) % loop
        return np.array(self._data, np.int64)[index]

    def _value(self, name: str) -> float:
        return self._registers.value(f"{self._name}_{name}")

    def _room(self) -> int:
        return int(self._value("BUFFER_ALLOCATE_NUM_BYTES")) // 2 - len(self._data)

    def _set_target(self, value: float) -> None:
        self._locked()
        if value not in _TARGETS:
            raise ModbusError(DEVICE_FAILURE, _TARGET_INVALID)

    def _allocate(self, value: float) -> None:
        self._locked()
        size = int(value)
        if size > _LARGEST or size & (size - 1):
            raise ModbusError(DEVICE_FAILURE, _SIZE_INVALID)
        self._data, self._place = [], 0

    def _fill(self, data: bytes, size: int) -> None:
        """Append data; a voltage takes two bytes like everything else, and is not simulated."""
        words = [int.from_bytes(data[i : i + 2], "big") for i in range(0, len(data), size)]
        if not self._value("BUFFER_ALLOCATE_NUM_BYTES"):
            raise ModbusError(DEVICE_FAILURE, _NO_BUFFER)
        if len(words) > self._room():
            raise ModbusError(DEVICE_FAILURE, _BUFFER_FULL)
        self._data += words

    def _set_loop(self, value: float) -> None:
        """New data is used at once; synchronising several outputs is not simulated."""
        if value not in (1, 2, 3):
            raise ModbusError(ILLEGAL_VALUE)
        self._place = 0
