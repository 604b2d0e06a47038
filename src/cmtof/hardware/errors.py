"""What can go wrong with an instrument. All are `OSError`: the command line prints one line."""


class InstrumentError(OSError):
    """Something is wrong with an instrument or with the way to it."""


class InstrumentTimeout(InstrumentError):
    """Nothing, or not enough, came back in time."""


class ConnectionLost(InstrumentError):
    """The other end has gone."""


class BadReply(InstrumentError):
    """What came back is not what the protocol allows: cut, garbled, or for another request."""


class Refused(InstrumentError):
    """The device said no, or silently kept another setting."""


class Unsafe(InstrumentError):
    """The interlock is open, the lock is lost, or a watchdog has tripped."""
