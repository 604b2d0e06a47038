"""The LabJack T7's published Modbus map, as data: what the host asks for and a T7 answers to.

Source of names, addresses, types and access: ``ljm_constants.json`` of the repository
labjack/ljm_constants (versions 2016.05.16.A and 2019.02.08.A compared entry by entry with this
table; later ones add registers). An entry with ``verified=False`` is not in that file or could not
be compared.

Numbers are big-endian, high word first. A name with a number in it is a family: its members lie
one value apart, so a FLOAT32 or UINT32 family steps by two addresses, a UINT16 family by one.
"""

import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

Kind = Literal["UINT16", "UINT32", "INT32", "FLOAT32", "STRING"]
Access = Literal["R", "W", "RW"]

_FORMATS: dict[Kind, str] = {"UINT16": ">H", "UINT32": ">I", "INT32": ">i", "FLOAT32": ">f"}
_STRING_SIZE = 50  # DEVICE_NAME_DEFAULT: up to 49 characters and the closing zero


@dataclass(frozen=True)
class Register:
    """One value of the map.

    Attributes
    ----------
    address : int
        Number of the first 16-bit register.
    kind : str
        Type of the value: UINT16, UINT32, INT32, FLOAT32 or STRING.
    access : str
        "R", "W" or "RW".
    note : str
        Unit, default and pitfalls.
    buffer : bool
        True where any number of values goes to, or comes from, this one address.
    verified : bool
        Whether the entry was compared with the published map.
    """

    address: int
    kind: Kind
    access: Access = "RW"
    note: str = ""
    buffer: bool = False
    verified: bool = True

    @property
    def size(self) -> int:
        """Number of 16-bit registers of one value."""
        return (
            struct.calcsize(_FORMATS[self.kind]) if self.kind in _FORMATS else _STRING_SIZE
        ) // 2

    def bytes_from_value(self, value: float | str) -> bytes:
        """Bytes of one value as they go over the wire.

        Raises
        ------
        ValueError
            If the value is not of this type or out of its range.

        Examples
        --------
        >>> register("TEST_FLOAT32").bytes_from_value(-9999.0).hex()
        'c61c3c00'
        """
        if self.kind == "STRING":
            text = str(value).encode("ascii", "replace")[: _STRING_SIZE - 1]
            return text.ljust(_STRING_SIZE, b"\0")
        try:
            number = float(value) if self.kind == "FLOAT32" else _whole(value)
            return struct.pack(_FORMATS[self.kind], number)
        except (struct.error, OverflowError, ValueError, TypeError):
            raise ValueError(
                f"Expected a {self.kind} for register {self.address}, got {value!r}. "
                "Keep to the range of the type."
            ) from None

    def value_from_bytes(self, data: bytes) -> float | int | str:
        """Value of the bytes that came over the wire.

        Raises
        ------
        ValueError
            If there are not as many bytes as the type has.
        """
        if len(data) != 2 * self.size:
            raise ValueError(
                f"Expected {2 * self.size} bytes of register {self.address}, got {len(data)}. "
                "Read as many registers as its type has."
            )
        if self.kind == "STRING":
            return data.split(b"\0", 1)[0].decode("ascii", "replace")
        return struct.unpack(_FORMATS[self.kind], data)[0]


def _whole(value: float | str) -> int:
    number = int(value)
    if number != float(value):
        raise ValueError
    return number


def _family(name: str, numbers: Iterable[int], first: Register) -> Iterator[tuple[str, Register]]:
    """Members of a family; ``#`` in the name is replaced by their number."""
    for step, number in enumerate(numbers):
        yield (
            name.replace("#", str(number)),
            Register(
                first.address + step * first.size,
                first.kind,
                first.access,
                first.note,
                first.buffer,
                first.verified,
            ),
        )


def _analog() -> Iterator[tuple[str, Register]]:
    built_in = range(14)
    yield from _family("AIN#", built_in, Register(0, "FLOAT32", "R", "V, calibrated"))
    yield from _family(
        "AIN#_RANGE", built_in, Register(40000, "FLOAT32", "RW", "V: 10, 1, 0.1, 0.01; 0 is 10")
    )
    yield from _family(
        "AIN#_NEGATIVE_CH", built_in, Register(41000, "UINT16", "RW", "199 is single-ended")
    )
    yield from _family(
        "AIN#_RESOLUTION_INDEX", built_in, Register(41500, "UINT16", "RW", "T7 0-8, T7-Pro 0-12")
    )
    yield from _family(
        "AIN#_SETTLING_US", built_in, Register(42000, "FLOAT32", "RW", "us, 0 is automatic")
    )
    yield from _family("AIN#_BINARY", built_in, Register(50000, "UINT32", "R", "24 bit"))
    yield "AIN_ALL_RANGE", Register(43900, "FLOAT32", "RW", "mixed settings read -9999")
    yield "AIN_ALL_NEGATIVE_CH", Register(43902, "UINT16", "RW", "mixed settings read 0xFFFF")
    yield "AIN_ALL_RESOLUTION_INDEX", Register(43903, "UINT16", "RW", "mixed read 0xFFFF")
    yield "AIN_ALL_SETTLING_US", Register(43904, "FLOAT32", "RW", "mixed settings read -9999")
    yield from _family("DAC#", range(2), Register(1000, "FLOAT32", "RW", "V, about 0 to 5"))
    yield from _family(
        "TDAC#",
        range(23),
        Register(30000, "FLOAT32", "W", "V, LJTick-DAC +-10 V; even is DACA, odd DACB"),
    )
    # A read re-reads the calibration of the LJTick-DAC that the last write to TDAC# named.
    yield "TDAC_SERIAL_NUMBER", Register(55200, "UINT32", "R", "a read reloads the calibration")
    yield (
        "TDAC_SPEED_THROTTLE",
        Register(55202, "UINT32", "RW", "newer map only", verified=False),
    )


def _digital() -> Iterator[tuple[str, Register]]:
    note = "0 low, 1 high; makes the line an input when read, an output when written"
    for name, address, count in (("FIO#", 2000, 8), ("EIO#", 2008, 8), ("CIO#", 2016, 4)):
        yield from _family(name, range(count), Register(address, "UINT16", "RW", note))
    yield from _family("MIO#", range(3), Register(2020, "UINT16", "RW", note))
    yield from _family("DIO#", range(23), Register(2000, "UINT16", "RW", note))
    inhibit = "bits 0-7 lines, bits 8-15 inhibit a line's change"
    for step, port in enumerate(("FIO", "EIO", "CIO", "MIO")):
        yield f"{port}_STATE", Register(2500 + step, "UINT16", "RW", f"{inhibit}; no direction")
        yield f"{port}_DIRECTION", Register(2600 + step, "UINT16", "RW", f"1 is output; {inhibit}")
    yield "DIO_STATE", Register(2800, "UINT32", "RW", "all 23 lines, under DIO_INHIBIT")
    yield "DIO_DIRECTION", Register(2850, "UINT32", "RW", "1 is output, under DIO_INHIBIT")
    yield "DIO_INHIBIT", Register(2900, "UINT32", "RW", "1 keeps a line from changing")


def _stream() -> Iterator[tuple[str, Register]]:
    yield "STREAM_SCANRATE_HZ", Register(4002, "FLOAT32", "RW", "reads back the true rate")
    yield "STREAM_NUM_ADDRESSES", Register(4004, "UINT32", "RW", "entries of the scan list")
    yield "STREAM_SAMPLES_PER_PACKET", Register(4006, "UINT32", "RW", "at most 512 over Ethernet")
    yield "STREAM_SETTLING_US", Register(4008, "FLOAT32", "RW", "us, below 1 is automatic")
    yield "STREAM_RESOLUTION_INDEX", Register(4010, "UINT32", "RW", "0-8, 0 is 1")
    yield "STREAM_BUFFER_SIZE_BYTES", Register(4012, "UINT32", "RW", "power of 2, to 32768")
    yield "STREAM_CLOCK_SOURCE", Register(4014, "UINT32", "RW", "0 crystal, 2 CIO3")
    yield (
        "STREAM_AUTO_TARGET",
        Register(4016, "UINT32", "RW", "bit 0 Ethernet port 702, bit 1 USB, bit 4 by command"),
    )
    # In no version of ljm_constants; T-Series Datasheet 3.2.4 and LabJack's C example write 0.
    yield "STREAM_DATATYPE", Register(4018, "UINT32", "RW", "write 0")
    yield "STREAM_NUM_SCANS", Register(4020, "UINT32", "RW", "0 runs until it is stopped")
    yield "STREAM_EXTERNAL_CLOCK_DIVISOR", Register(4022, "UINT32", "RW", "pulses per scan")
    yield "STREAM_TRIGGER_INDEX", Register(4024, "UINT32", "RW", "0 none, 2000 DIO_EF0")
    newer: tuple[tuple[str, int, Kind, Access, str], ...] = (
        ("STREAM_START_TIME_STAMP", 4026, "UINT32", "R", "CORE_TIMER at the first scan"),
        ("STREAM_AUTORECOVER_DISABLE", 4028, "UINT32", "RW", "1 stops at a full buffer"),
        ("STREAM_SCANRATE_HZ_ACTUAL", 4494, "FLOAT32", "R", "Hz"),
    )
    for name, address, kind, access, note in newer:
        yield name, Register(address, kind, access, f"{note}; newer map only", verified=False)
    yield from _family(
        "STREAM_SCANLIST_ADDRESS#", range(128), Register(4100, "UINT32", "RW", "what a scan reads")
    )
    yield "STREAM_DATA_CR", Register(4500, "UINT32", "R", "samples by command", buffer=True)
    yield "STREAM_DATA_CAPTURE_16", Register(4899, "UINT16", "R", "high half of 32 bit channels")
    yield "STREAM_ENABLE", Register(4990, "UINT32", "RW", "1 starts, 0 stops; written last")


def _stream_out() -> Iterator[tuple[str, Register]]:
    four = range(4)
    settings: tuple[tuple[str, int, Access, str], ...] = (
        ("TARGET", 4040, "RW", "address that is written; set before data"),
        ("BUFFER_ALLOCATE_NUM_BYTES", 4050, "RW", "power of 2, to 16384, 2 bytes a value"),
        ("LOOP_NUM_VALUES", 4060, "RW", "values at the end of the data that repeat"),
        ("SET_LOOP", 4070, "W", "1 uses new data at once, 2 waits for synch, 3 is synch"),
        ("BUFFER_STATUS", 4080, "R", "free values"),
        ("ENABLE", 4090, "RW", "1 on: one value a scan of a running stream"),
    )
    for name, address, access, note in settings:
        yield from _family(f"STREAM_OUT#_{name}", four, Register(address, "UINT32", access, note))
    yield from _family(
        "STREAM_OUT#_BUFFER_F32", four, Register(4400, "FLOAT32", "W", "volts for DACs", True)
    )
    yield from _family(
        "STREAM_OUT#_BUFFER_U32", four, Register(4410, "UINT32", "W", "not in use", True)
    )
    yield from _family(
        "STREAM_OUT#_BUFFER_U16", four, Register(4420, "UINT16", "W", "states of a port", True)
    )
    # Counts against the scan rate, returns no sample.
    yield from _family(
        "STREAM_OUT#", four, Register(4800, "UINT16", "R", "entry of the scan list, no sample")
    )


def _system() -> Iterator[tuple[str, Register]]:
    yield "CORE_TIMER", Register(61520, "UINT32", "R", "40 MHz, wraps in 107 s")
    yield "TEST", Register(55100, "UINT32", "R", "0x00112233")
    yield "TEST_UINT16", Register(55110, "UINT16", "RW", "0x0011")
    yield "TEST_UINT32", Register(55120, "UINT32", "RW", "0x00112233")
    yield "TEST_INT32", Register(55122, "INT32", "RW", "0x8899AABB")
    yield "TEST_FLOAT32", Register(55124, "FLOAT32", "RW", "-9999.0")
    yield (
        "LAST_ERR_DETAIL",
        Register(55000, "UINT16", "R", "LabJack's code; newer map only", verified=False),
    )
    yield "PRODUCT_ID", Register(60000, "FLOAT32", "R", "7")
    yield "HARDWARE_VERSION", Register(60002, "FLOAT32", "R")
    yield "FIRMWARE_VERSION", Register(60004, "FLOAT32", "R")
    yield "BOOTLOADER_VERSION", Register(60006, "FLOAT32", "R")
    yield "HARDWARE_INSTALLED", Register(60010, "UINT32", "R", "bit 0: T7-Pro's converter")
    yield "SERIAL_NUMBER", Register(60028, "UINT32", "R")
    yield "DEVICE_NAME_DEFAULT", Register(60500, "STRING", "RW", "to 49 characters")
    yield "IO_CONFIG_SET_CURRENT_TO_FACTORY", Register(61990, "UINT16", "W", "write 1")
    yield "INTERNAL_FLASH_READ_POINTER", Register(61810, "UINT32", "RW", "where reads start")
    yield "INTERNAL_FLASH_READ", Register(61812, "UINT32", "R", "data from the pointer on", True)
    for kind, address, count in (("F32", 46000, 40), ("U32", 46100, 40)):
        yield from _family(
            f"USER_RAM#_{kind}",
            range(count),
            Register(address, "FLOAT32" if kind == "F32" else "UINT32", "RW", "free for any use"),
        )


def _watchdog() -> Iterator[tuple[str, Register]]:
    """Watchdog: to be disabled before anything else of it is written (error 2671 SWDT_ENABLED).

    The published names end in _DEFAULT: the settings live in flash and survive a power cycle.
    """
    settings: tuple[tuple[str, int, Kind, str], ...] = (
        ("ENABLE", 61600, "UINT32", "1 on, 0 off"),
        ("ADVANCED", 61602, "UINT32", "bit 0: factory settings on time-out"),
        ("TIMEOUT_S", 61604, "UINT32", "s without any communication"),
        ("STARTUP_DELAY_S", 61606, "UINT32", "s, first time-out after power-up"),
        ("RESET_ENABLE", 61620, "UINT32", "1: the device restarts on time-out"),
        ("DIO_ENABLE", 61630, "UINT32", "1: digital lines change on time-out"),
        ("DIO_STATE", 61632, "UINT32", "their levels"),
        ("DIO_DIRECTION", 61634, "UINT32", "their directions"),
        ("DIO_INHIBIT", 61636, "UINT32", "lines that stay as they are"),
        ("DAC0_ENABLE", 61640, "UINT32", "1: DAC0 changes on time-out"),
        ("DAC0", 61642, "FLOAT32", "V"),
        ("DAC1_ENABLE", 61650, "UINT32", "1: DAC1 changes on time-out"),
        ("DAC1", 61652, "FLOAT32", "V"),
    )
    for name, address, kind, note in settings:
        yield f"WATCHDOG_{name}_DEFAULT", Register(address, kind, "RW", note)


REGISTERS: Mapping[str, Register] = MappingProxyType(
    {
        name: entry
        for part in (_analog, _digital, _stream, _stream_out, _system, _watchdog)
        for name, entry in part()
    }
)
"""Every register of the table by its published name."""


def register(name: str) -> Register:
    """Entry of the register of that name.

    Raises
    ------
    ValueError
        If the table has no such name.

    Examples
    --------
    >>> register("TDAC2").address, register("STREAM_OUT1_TARGET").address
    (30004, 4042)
    """
    try:
        return REGISTERS[name]
    except KeyError:
        raise ValueError(
            f"Expected the name of a T7 register, got {name!r}. See codecs/registers.py."
        ) from None
