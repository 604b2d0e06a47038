"""CRC-16/CCITT-FALSE, the checksum of the RF drivers' line protocol."""

from binascii import crc_hqx


def crc16(data: bytes) -> int:
    """CRC-16/CCITT-FALSE of the bytes: polynomial 0x1021, start 0xFFFF, nothing reflected.

    The name is the one of Greg Cook's catalogue of parametrised CRC algorithms (also listed there
    as CRC-16/IBM-3740), whose check value is the example.

    Examples
    --------
    >>> hex(crc16(b"123456789"))
    '0x29b1'
    """
    return crc_hqx(data, 0xFFFF)
