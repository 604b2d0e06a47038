"""Models of the SCPI instruments, each on a simulated one."""


class Scpi:
    """A device of text commands: what is set is kept, and told when it is asked for."""

    model = ""
    settings = ()

    def __init__(self, device, clock=None):
        self.device = device
        self.kept = dict(self.settings)

    def __call__(self, line):
        head, _, value = line.decode().strip().partition(" ")
        if value:
            self.obey(head, value)
        answer = self.answer(head[:-1]) if head.endswith("?") else ""
        return f"{answer}\n".encode() if answer else b""

    def answer(self, head):
        return f"MAKER,{self.model},1,2" if head == "*IDN" else self.kept.get(head, "")

    def obey(self, head, value):
        self.kept[head] = value


class Generator(Scpi):
    """An SDG2042X."""

    model = "SDG2042X"
    settings = (("*OPC", "1"), ("MODE", "PHASE-LOCKED"))

    def answer(self, head):
        if head.endswith("OUTP"):
            state = "ON" if self.device.output_is_on(int(head[1])) else "OFF"
            return f"{head} {state},LOAD,50,PLRT,NOR"
        if ":" in head:
            return f"{head} {self.kept.get(head, 'STATE,OFF')}"
        return super().answer(head)

    def obey(self, head, value):
        if value in ("ON", "OFF"):
            self.device.output(int(head[1]), value == "ON")
        super().obey(head, value)


class Meter(Scpi):
    """A PM100D that was left in dBm."""

    model = "PM100D"
    settings = (
        ("SENS:POW:UNIT", "DBM"),
        ("SENS:CORR:COLL:ZERO:STAT", "0"),
        ("SYST:SENS:IDN", '"S140C","1","01-JAN-2026",1,1,33'),
    )

    def answer(self, head):
        if head != "MEAS:POW":
            return super().answer(head)
        return repr(self.device.power if self.kept["SENS:POW:UNIT"] == "W" else -30.0)
