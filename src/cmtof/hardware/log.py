"""Log of requests to devices and their replies."""

from datetime import datetime
from typing import Any, TextIO

TALK = ("write", "read", "read_until", "ask")


class Logged:
    """A connection whose requests and replies go into a file as well, each with its time."""

    def __init__(self, connection: Any, name: str, log: TextIO) -> None:
        vars(self).update(_connection=connection, _name=name, _log=log)

    def __getattr__(self, attribute: str) -> Any:
        found = getattr(self._connection, attribute)

        def call(*arguments: Any) -> Any:
            if attribute in ("write", "ask"):
                self._note(">", arguments[0])
            try:
                reply = found(*arguments)
            except Exception as error:
                self._note("!", error)
                raise
            if isinstance(reply, str | bytes) and reply:
                self._note("<", reply)
            return reply

        return call if attribute in TALK else found

    def __setattr__(self, attribute: str, value: Any) -> None:
        setattr(self._connection, attribute, value)

    def _note(self, direction: str, content: object) -> None:
        text = content.hex(" ") if isinstance(content, bytes) else str(content).strip()
        try:
            self._log.write(
                f"{datetime.now().isoformat(timespec='milliseconds')} "
                f"{self._name} {direction} {text}\n"
            )
            self._log.flush()
        except OSError:  # a full disk must not keep a request from the device
            pass
