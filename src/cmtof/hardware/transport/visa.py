"""A VISA resource: for instruments on USBTMC, GPIB or VXI-11."""

from typing import Any

from cmtof.hardware.errors import InstrumentTimeout
from cmtof.hardware.transport.buffered import Buffered, imported


class VisaTransport(Buffered):
    """VISA resource, for text that ends in newlines; needs pyvisa and a back end.

    Parameters
    ----------
    resource : str
        As ``TCPIP0::192.168.1.5::INSTR``.
    backend : str
        VISA library, as ``@py``; empty for the system's.

    Raises
    ------
    ConnectionLost
        If there is no such resource.
    """

    def __init__(self, resource: str, *, backend: str = "", timeout: float = 2.0) -> None:
        super().__init__()
        self.name = f"visa:{resource}"
        self._resource_name, self._backend, self._timeout = resource, backend, timeout
        self._manager: Any = None
        self._resource: Any = None
        self._open()

    def _open(self) -> None:
        visa = imported("pyvisa", "pyvisa", None)
        try:
            self._manager = visa.ResourceManager(self._backend)
            self._resource = self._manager.open_resource(
                self._resource_name, open_timeout=round(1000 * self._timeout)
            )
            self._resource.read_termination = self._resource.write_termination = "\n"
        except (visa.Error, OSError, ValueError) as error:
            raise self._lost(error) from error

    def _shut(self) -> None:
        for part in (self._resource, self._manager):
            if part is not None:
                part.close()
        self._resource = self._manager = None

    def write(self, data: bytes) -> None:
        """Send all of the bytes."""
        if self._call("write_raw", self._timeout, data) is None:
            raise InstrumentTimeout(
                f"Expected {self.name} to take {len(data)} bytes within {self._timeout:g} s, "
                "got no room. Reconnect."
            )

    def _receive(self, timeout: float) -> bytes:
        # VISA takes 0 ms for "at once", which some back ends round to no reading at all
        return self._call("read_raw", max(timeout, 1e-3)) or b""

    def _call(self, method: str, timeout: float, *arguments: bytes) -> Any:
        """Result of a method of the resource, None when the time is over."""
        if self._resource is None:
            raise self._lost("closed")
        visa = imported("pyvisa", "pyvisa", None)
        try:
            self._resource.timeout = 1000 * timeout
            return getattr(self._resource, method)(*arguments)
        except visa.VisaIOError as error:
            if error.error_code == visa.constants.StatusCode.error_timeout:
                return None
            raise self._lost(error) from error
        except (visa.Error, OSError) as error:
            raise self._lost(error) from error
