"""Addresses of instruments: from text to an open line."""

from collections.abc import Iterable
from urllib.parse import parse_qsl, urlsplit

from cmtof.hardware.transport.buffered import Transport
from cmtof.hardware.transport.serial_line import SerialTransport
from cmtof.hardware.transport.tcp import TcpTransport
from cmtof.hardware.transport.visa import VisaTransport


def open_transport(address: str) -> Transport:
    """Open the line that an address names.

    Parameters
    ----------
    address : str
        ``tcp://HOST:PORT``, ``serial:PATH?baud=115200&rtscts=1`` or ``visa:RESOURCE?backend=@py``;
        what follows the question mark may be left out.

    Raises
    ------
    ValueError
        If the address is not of these forms.
    InstrumentError
        If the line cannot be opened.
    """
    kind, colon, rest = address.partition(":")
    makers = {"tcp": _open_tcp, "serial": _open_serial, "visa": _open_visa}
    if not colon or kind not in makers:
        raise _bad_address(address)
    return makers[kind](address, rest)


def _bad_address(address: str, problem: str = "") -> ValueError:
    return ValueError(
        "Expected tcp://HOST:PORT, serial:PATH?baud=115200&rtscts=1 or visa:RESOURCE, got "
        f"{address!r}{problem and ': '}{problem}. Correct the address."
    )


def _options(address: str, text: str, known: Iterable[str]) -> dict[str, str]:
    try:
        pairs = parse_qsl(text, strict_parsing=True, keep_blank_values=True) if text else []
    except ValueError:
        raise _bad_address(address, "options are NAME=VALUE&NAME=VALUE") from None
    options = dict(pairs)
    if len(options) < len(pairs) or set(options) - set(known):
        raise _bad_address(address, f"options are {', '.join(known)}, each once") from None
    return options


def _open_tcp(address: str, rest: str) -> Transport:
    try:
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port
    except ValueError:
        raise _bad_address(address, "port is a number to 65535") from None
    extra = parts.path or parts.query or parts.fragment or parts.username
    if not host or not port or extra or not rest.startswith("//"):
        raise _bad_address(address, "needs a host and a port, nothing else")
    return TcpTransport(host, port)


def _open_serial(address: str, rest: str) -> Transport:
    path, _, query = rest.partition("?")
    options = _options(address, query, ("baud", "rtscts"))
    baud, rtscts = options.get("baud", "115200"), options.get("rtscts", "0")
    if not path:
        raise _bad_address(address, "the path is missing")
    if not (baud.isascii() and baud.isdigit() and 50 <= int(baud) <= 4_000_000):
        raise _bad_address(address, "baud is 50 to 4000000")
    if rtscts not in ("0", "1"):
        raise _bad_address(address, "rtscts is 0 or 1")
    return SerialTransport(path, baud=int(baud), rtscts=rtscts == "1")


def _open_visa(address: str, rest: str) -> Transport:
    resource, _, query = rest.partition("?")
    options = _options(address, query, ("backend",))
    if not resource:
        raise _bad_address(address, "the resource is missing")
    return VisaTransport(resource, backend=options.get("backend", ""))
