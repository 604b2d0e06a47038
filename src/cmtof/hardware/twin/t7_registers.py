"""The T7's registers: a memory of 16-bit words behind the published map, and what watches it.

Sources: ljm_constants.json (addresses, types, access, error numbers), T-Series Datasheet.
"""

import struct
from collections.abc import Callable

from cmtof.hardware.codecs.registers import REGISTERS, Register
from cmtof.hardware.twin.modbus_frames import ILLEGAL_ADDRESS, ILLEGAL_VALUE, ModbusError
from cmtof.instrument.electronics import CENTRE, RANGES, SLOPE

FLASH_ADDRESS = 0x3C4000
"""Where the calibration stands in the internal flash (LabJack's C example for streaming)."""

_BY_ADDRESS: dict[int, Register] = {entry.address: entry for entry in REGISTERS.values()}
_SINGLE_WORDS = (55100, 55101)  # TEST: may be read word by word, the map says
_DEFAULTS: dict[str, float | str] = {
    "TEST": 0x00112233,
    "TEST_UINT16": 0x0011,
    "TEST_UINT32": 0x00112233,
    "TEST_INT32": 0x8899AABB - 2**32,
    "TEST_FLOAT32": -9999.0,
    "PRODUCT_ID": 7.0,
    "HARDWARE_VERSION": 1.35,
    "FIRMWARE_VERSION": 1.0301,
    "BOOTLOADER_VERSION": 0.94,
    "HARDWARE_INSTALLED": 0,
    "SERIAL_NUMBER": 470012345,
    "DEVICE_NAME_DEFAULT": "cmtof-twin",
    "TDAC_SERIAL_NUMBER": 10012345,
    "AIN_ALL_NEGATIVE_CH": 199,
    **{f"AIN{n}_NEGATIVE_CH": 199 for n in range(14)},
}

Getter = Callable[[], float]
Setter = Callable[[float], None]


class T7Registers:
    """Registers with hooks: getters fill them before a read, setters learn of a write.

    A setter may raise `ModbusError`; what is written then stays as it was.
    """

    def __init__(self) -> None:
        self._memory = bytearray(2 * 65536)
        self._getters: dict[int, Getter] = {}
        self._setters: dict[int, Setter] = {}
        self._readers: dict[int, Callable[[int], bytes]] = {}
        self._writers: dict[int, Callable[[bytes], None]] = {}
        for name, value in _DEFAULTS.items():
            self.put(name, value)

    def put(self, name: str, value: float | str) -> None:
        """Set a value from inside the device."""
        entry = REGISTERS[name]
        data = entry.bytes_from_value(value)
        self._memory[2 * entry.address : 2 * entry.address + len(data)] = data

    def value(self, name: str) -> float:
        """Value as it was last written."""
        entry = REGISTERS[name]
        return float(entry.value_from_bytes(self._stored(entry)))

    def on_read(self, name: str, getter: Getter) -> None:
        """Ask ``getter`` for the value whenever it is read."""
        self._getters[REGISTERS[name].address] = getter

    def on_write(self, name: str, setter: Setter) -> None:
        """Tell ``setter`` the value whenever it is written."""
        self._setters[REGISTERS[name].address] = setter

    def on_buffer_read(self, name: str, reader: Callable[[int], bytes]) -> None:
        """Ask ``reader`` for so many bytes of a buffer."""
        self._readers[REGISTERS[name].address] = reader

    def on_buffer_write(self, name: str, writer: Callable[[bytes], None]) -> None:
        """Give ``writer`` what is written to a buffer."""
        self._writers[REGISTERS[name].address] = writer

    def read(self, address: int, count: int) -> bytes:
        """Bytes of ``count`` registers; whole values only."""
        entry = _BY_ADDRESS.get(address)
        if entry is not None and entry.buffer:
            if address not in self._readers or count % entry.size:
                raise ModbusError(ILLEGAL_ADDRESS)
            return self._readers[address](2 * count)
        if not (address in _SINGLE_WORDS and count == 1):
            for one in self._values(address, count, "R"):
                if (getter := self._getters.get(one.address)) is not None:
                    data = one.bytes_from_value(getter())
                    self._memory[2 * one.address : 2 * one.address + len(data)] = data
        return bytes(self._memory[2 * address : 2 * (address + count)])

    def write(self, address: int, data: bytes) -> None:
        """Set registers; whole values only."""
        entry = _BY_ADDRESS.get(address)
        if entry is not None and entry.buffer:
            if address not in self._writers or len(data) % (2 * entry.size):
                raise ModbusError(ILLEGAL_ADDRESS)
            self._writers[address](data)
            return
        for one in self._values(address, len(data) // 2, "W"):
            place = 2 * (one.address - address)
            self._write_value(one, data[place : place + 2 * one.size])

    def _write_value(self, entry: Register, data: bytes) -> None:
        value = entry.value_from_bytes(data)
        if isinstance(value, float) and not abs(value) < 1e30:  # nan and infinity, too
            raise ModbusError(ILLEGAL_VALUE)
        if (setter := self._setters.get(entry.address)) is not None:
            setter(float(value))
        self._memory[2 * entry.address : 2 * entry.address + len(data)] = data

    def _values(self, address: int, count: int, access: str) -> list[Register]:
        """Entries that fill the span exactly, each with the access that is wanted."""
        found, end = [], address + count
        while address < end:
            entry = _BY_ADDRESS.get(address)
            if entry is None or entry.buffer or access not in entry.access:
                raise ModbusError(ILLEGAL_ADDRESS)
            found.append(entry)
            address += entry.size
        if address != end:
            raise ModbusError(ILLEGAL_ADDRESS)
        return found

    def _stored(self, entry: Register) -> bytes:
        return bytes(self._memory[2 * entry.address : 2 * (entry.address + entry.size)])


def calibration_flash() -> bytes:
    """The 41 floats of the calibration: nominal values (T-Series Datasheet, 20.0.1).

    Four gains of the high-speed converter, four of the high-resolution one, each with positive
    slope, negative slope, centre and offset; DAC0, DAC1 slope and offset; temperature slope and
    offset; 10 uA and 200 uA sources; bias current.
    """
    negative = -3.15805800e-4
    gains = [
        value
        for volts in RANGES
        for value in (SLOPE * volts / 10, negative * volts / 10, CENTRE, -1.0586956522 * volts)
    ]
    rest = [13200.0, 0.0, 13200.0, 0.0, -92.6, 467.6, 1e-5, 2e-4, 1.5e-8]
    return struct.pack(">41f", *gains, *gains, *rest)
