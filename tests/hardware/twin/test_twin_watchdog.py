"""The simulated T7 guards its lines itself when no host speaks."""

import pytest
from twin_stand_in import StandInWorld, wait_until

from cmtof.hardware.codecs.registers import register
from cmtof.hardware.drivers.labjack_t7 import LabJackT7
from cmtof.hardware.transport import TcpTransport
from cmtof.hardware.twin.faults import Fault, Watch
from cmtof.hardware.twin.lines import TcpLine
from cmtof.hardware.twin.modbus_server import T7Server
from cmtof.instrument.panel import Panel

SAFE = {"FIO0": False, "FIO1": False, "FIO6": False}


@pytest.fixture
def bench():
    """Panel, server, faults and driver of one T7 with laser on and shutter open."""
    panel, watch = Panel(), Watch("daq")
    server = T7Server(panel, StandInWorld(), watch)
    streams = TcpLine("127.0.0.1", 0, None, "s")
    server.stream.publish = streams.broadcast
    commands = TcpLine("127.0.0.1", 0, server.serve, "c")
    ports = [TcpTransport("127.0.0.1", line.port) for line in (commands, streams)]
    driver = LabJackT7(*ports, safe_lines=SAFE, timeout=0.3)
    for line in SAFE:
        driver.set_line(line, True)
    assert panel.laser_on and panel.shutter_open and not panel.beam_block_in
    yield panel, server, watch, driver
    driver.close()
    server.stop()
    commands.stop()
    streams.stop()


def dark(panel):
    return not panel.laser_on and not panel.shutter_open and panel.beam_block_in


def test_lines_go_safe_when_the_host_falls_silent(bench):
    panel, _, _, driver = bench
    driver.watchdog(1)
    assert panel.laser_on
    wait_until(lambda: dark(panel), timeout=5)


def test_lines_go_safe_when_the_host_is_gone(bench):
    panel, _, _, driver = bench
    driver.watchdog(1)
    driver.close()
    wait_until(lambda: dark(panel), timeout=5)


def test_a_device_that_hears_nothing_is_not_fed(bench):
    panel, _, watch, driver = bench
    driver.watchdog(1)
    watch.add(Fault("daq", "silence", times=0))
    wait_until(lambda: dark(panel), timeout=5)
    watch.clear()


def test_without_a_time_nothing_bites(bench):
    panel, server, _, driver = bench
    driver.watchdog(1)
    driver.watchdog(0)
    assert server.registers.value("WATCHDOG_ENABLE_DEFAULT") == 0
    with pytest.raises(AssertionError):
        wait_until(lambda: dark(panel), timeout=1.5)


def test_lines_that_are_not_safe_lines_stay(bench):
    panel, _, _, driver = bench
    driver.set_line("FIO5", True)
    driver.watchdog(1)
    wait_until(lambda: dark(panel), timeout=5)
    assert panel.flip_mirror_in
    assert register("WATCHDOG_DIO_INHIBIT_DEFAULT").address == 61636


def test_it_bites_again_after_the_next_silence(bench):
    panel, _, _, driver = bench
    driver.watchdog(1)
    wait_until(lambda: dark(panel), timeout=5)
    driver.set_line("FIO0", True)
    assert panel.laser_on
    wait_until(lambda: dark(panel), timeout=5)
