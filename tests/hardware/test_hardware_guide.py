"""The book's hardware guide says what the code does: protocol, RIG file, devices, commands."""

import inspect
import re
import shlex
from dataclasses import fields
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
import typer
import yaml

from cmtof.cli import app
from cmtof.hardware import bench, rig_settings
from cmtof.hardware.codecs.crc import crc16
from cmtof.hardware.codecs.registers import REGISTERS
from cmtof.hardware.codecs.rf_line import LIMIT, SEQUENCES, Reply, parse_line, request, table_crc
from cmtof.hardware.drivers import rf_driver
from cmtof.hardware.drivers.stage_table import STAGES
from cmtof.hardware.rig import Rig
from cmtof.hardware.rig_settings import DRIVERS, SECTIONS, DeviceSettings, settings_from_dict
from cmtof.hardware.twin import rf_server
from cmtof.hardware.twin.faults import KINDS, Watch
from cmtof.instrument.panel import Panel
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.world import World

PAGE = Path(__file__).resolve().parents[2] / "book" / "hardware.md"
TEXT = PAGE.read_text(encoding="utf-8")
CLASSES = {
    "RfDriver": "rf_driver",
    "SignalGenerator": "signal_generator",
    "LabJackT7": "labjack_t7",
    "Galvo": "galvo",
    "Stage": "apt_stage",
    "Interlock": "interlock",
    "PowerMeter": "power_meter",
    "FileCamera": "camera",
    "GenicamCamera": "camera",
}


@cache
def table(heading: str) -> list[list[str]]:
    """Cells of the table whose head begins with a heading."""
    lines = TEXT.splitlines()
    (first,) = [n for n, line in enumerate(lines) if line.startswith(f"| {heading} |")]
    rows = []
    for line in lines[first + 2 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def code(text: str) -> list[str]:
    """What stands in backticks."""
    return re.findall(r"`([^`]+)`", text)


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)


def driver_class(name: str) -> type:
    return getattr(import_module(f"cmtof.hardware.drivers.{CLASSES[name]}"), name)


def server() -> rf_server.RfServer:
    world = World(TwinSettings(), seed=0)
    return rf_server.RfServer(Panel(), world, "emission", Watch("rf_emission"))


# --- the line protocol -----------------------------------------------------------------------


def lines_of_the_page() -> list[str]:
    return re.findall(r"^[<>!][^*\n]*\*[0-9A-F]{4}$", TEXT, re.MULTILINE)


@pytest.mark.parametrize("line", lines_of_the_page())
def test_checksums_of_the_examples(line):
    body, _, check = line.rpartition("*")
    assert check == f"{crc16(body.encode()):04X}"
    if line[0] != ">":
        parse_line(line.encode())


def test_every_request_of_the_dialogue_is_what_the_codec_sends():
    asked = [line for line in lines_of_the_page() if line[0] == ">"]
    assert len(asked) > 5
    for line in asked:
        sequence, word, *arguments = line.rpartition("*")[0][1:].split(" ")
        assert request(int(sequence), word, *arguments) == f"{line}\n".encode()


def test_the_simulated_driver_answers_as_in_the_dialogue():
    driver = server()
    page = lines_of_the_page()
    answers = {
        re.match(r"<(\d+)", line)[1]: line for line in page if re.match(r"<\d", line)
    }  # by sequence number
    stated = {">14", ">8", ">12", ">15"}  # those that do not hang on the state of a lock
    for line in page:
        if line.split(" ")[0] in stated:
            reply = driver._reply(line.encode()).decode().strip()
            assert reply == answers[line.split(" ")[0][1:]]
    assert driver._reply(b">1 PING*0000").decode().strip() in page


def test_worked_example_of_the_checksum():
    (example,) = [block for block in blocks("python") if "def checksum" in block]
    scope: dict = {}
    exec(example, scope)
    assert scope["sent"].encode() == request(7, "PING")
    assert scope["checksum"]("123456789") == "29B1"
    assert "29B1" in TEXT
    assert b">7 PING".hex(" ").upper() in TEXT


def test_words_are_those_of_the_simulated_driver():
    assert sorted(word for row in table("word") for word in code(row[0])) == sorted(server()._words)


def test_words_are_all_that_our_driver_says():
    source = inspect.getsource(rf_driver)
    said = set(re.findall(r'(?:_question|_command|_values|_switch|_ask)\(\s*"([A-Z?]+)"', source))
    assert len(said) > 10
    assert said <= {code(row[0])[0] for row in table("word")}


def test_limits_of_the_protocol():
    cells = {code(row[0])[0]: row[1] for row in table("word")}
    assert f"{rf_server.BAND[0]} to {rf_server.BAND[1]}" in cells["FREQ"]
    assert f"0 to {rf_server.CODES - 1}" in cells["PHAS"]
    assert f"{rf_server.POWER[0]:g} to {rf_server.POWER[1]:g}" in cells["POWR"].replace("−", "-")
    assert f"{rf_server.DEAD_MAN[0]:g} to {rf_server.DEAD_MAN[1]:g}" in cells["DEAD"]
    assert f"1 to {rf_server.TABLE_SIZE}" in cells["TABL"]
    assert f"at most {LIMIT} bytes" in TEXT
    assert f"0 to {SEQUENCES - 1}, chosen by the host" in TEXT
    assert f"{table_crc([0, 49152, 32768, 16384]):04X}" in TEXT
    assert f"dead man's time {server()._dead_man:g} s" in TEXT


def test_errors_of_the_protocol():
    stated = {code(row[0])[0] for row in table("error")}
    source = inspect.getsource(rf_server)
    raised = set(re.findall(r'_Refusal\("([A-Z]+)"', source))
    raised |= set(re.findall(r"<\?\? ERR ([A-Z]+)", source))
    assert stated == raised
    assert set(rf_driver._UNSAFE) <= stated | {"LOCK", "UNLOCKED", "INTERLOCK"}


@pytest.mark.parametrize(
    ("line", "error"),
    [
        ("12 PING*0000", "CHECKSUM"),
        (">1 HELLO", "WORD"),
        (">1 FREQ", "ARGS"),
        (">1 FREQ 1", "RANGE"),
        ("nothing", "FORM"),
    ],
)
def test_the_simulated_driver_refuses_as_stated(line, error):
    sent = line if "*" in line else f"{line}*{crc16(line.encode()):04X}"
    reply = parse_line(server()._reply(sent.encode()))
    assert isinstance(reply, Reply)
    assert reply.code == error
    assert (reply.sequence is None) == (error in ("CHECKSUM", "FORM"))


# --- the RIG file ------------------------------------------------------------------------------


def test_every_key_of_the_rig_file_is_explained():
    stated = [key for row in table("key | default") for key in code(row[0])]
    known = ["name", "devices"]
    known += [f"{name}.{one.name}" for name, kind in SECTIONS.items() for one in fields(kind)]
    assert sorted(stated) == sorted([*known, "twin"])


def test_defaults_are_those_of_the_shipped_file():
    settings = Rig.default().settings
    for name, default, _ in table("key | default"):
        (key,) = code(name)
        if "." not in key:
            continue
        section, member = key.split(".")
        value = getattr(getattr(settings, section), member)
        stated = yaml.safe_load(default.strip("`"))
        if isinstance(value, str):
            assert stated == value, key
        elif isinstance(value, tuple):
            assert tuple(stated) == value, key
        else:
            assert float(stated) == value, key


def test_keys_of_a_device():
    stated = {code(row[0])[0] for row in table("key | meaning")}
    assert stated == {one.name for one in fields(DeviceSettings)}


def test_roles_drivers_and_what_a_scan_needs():
    rows = {code(row[0])[0]: row for row in table("role | drivers")}
    assert {role: tuple(code(row[1])) for role, row in rows.items()} == DRIVERS
    assert {role for role, row in rows.items() if row[2] == "yes"} == set(bench.ROLES)


def test_the_bench_example_is_a_rig_file():
    (example,) = blocks("yaml")
    settings = settings_from_dict(yaml.safe_load(example))
    assert settings.devices["daq"].stream.endswith(":702")


def test_sections_of_the_twin():
    (sentence,) = re.findall(r"Below `twin` stand.*", TEXT)
    named = set(code(sentence))
    assert {one.name for one in fields(TwinSettings)} <= named


# --- wiring, devices, numbers -----------------------------------------------------------------


def test_wiring_is_that_of_the_default_rig():
    lines = Rig.default().settings.lines
    stated = {code(row[1])[0]: row[0] for row in table("line") if row[1]}
    assert stated == {one.name: getattr(lines, one.name) for one in fields(lines)}


def test_what_high_means():
    from cmtof.hardware.drivers import interlock

    high = {code(row[1])[0]: row[3] for row in table("line") if row[1]}
    assert interlock.LASER_ON
    assert interlock.SHUTTER_OPEN
    assert interlock.MIRROR_IN
    assert interlock.BLOCK_OUT
    assert interlock.LOOP_CLOSED
    assert "on" in high["laser"]
    assert "open" in high["shutter"]
    assert "reference target" in high["flip_mirror"]
    assert "out" in high["beam_block"]
    assert "closed" in high["interlock"]


def test_drivers_of_the_bill_of_materials_exist():
    named = {name for row in table("part") for name in code(row[3])}
    assert named == set(CLASSES)
    for name in named:
        assert driver_class(name).__name__ == name


def test_methods_that_a_scan_calls_exist():
    for roles, name, methods in table("role | class"):
        kind = driver_class(code(name)[0])
        for method in [*code(methods), "safe_state", "close"]:
            assert callable(getattr(kind, method)), (roles, method)


def test_methods_that_the_bench_calls_are_stated():
    stated = {m for row in table("role | class") for m in code(row[2])}
    source = inspect.getsource(bench)
    called = set(
        re.findall(r"\b(?:rf|stage|moved|plate|clock|meter|detection|daq)\.(\w+)\(", source)
    )
    assert called <= stated
    assert "load_table" in called


@pytest.mark.parametrize(
    "words",
    [
        f"{bench.CLOCK_FREQUENCY / 1e6:g} MHz, {bench.CLOCK_AMPLITUDE:g} V peak to peak into "
        f"{bench.CLOCK_LOAD:g} Ω",
        f"T7's watchdog, {bench.WATCHDOG:g} s",
        f"`drive.dead_man`, {rig_settings.DriveSettings().dead_man:g} s",
        f"{STAGES['mts50-z8'].scale / 1e3:.2f} a mm",
    ],
)
def test_numbers(words):
    assert words in TEXT


def test_registers_that_could_not_be_verified_are_named():
    (row,) = [row for row in table("fact") if row[0] == "T7 registers"]
    named = set(code(row[2]))
    assert {name for name, one in REGISTERS.items() if not one.verified} | {
        "STREAM_DATATYPE"
    } == named


def test_faults_are_those_of_the_twin():
    assert [code(row[0])[0] for row in table("fault")] == list(KINDS)


def test_order_of_stopping():
    from cmtof.hardware.rig import Instruments

    everything = {one.name: one.name for one in fields(Instruments)}
    order = Instruments(**everything).in_order_of_stopping()
    words = ["interlock", "mirrors", "RF of", "plates", "stage", "T7", "clock", "power meter"]
    names = ["interlock", "galvo", "rf_emission", "plate_emission", "stage", "daq", "clock"]
    (sentence,) = re.findall(r"in this order: (interlock lines.*?)\. One", TEXT)
    assert [sentence.index(word) for word in words] == sorted(sentence.index(w) for w in words)
    places = [order.index(name) for name in [*names, "power_meter"]]
    assert places == sorted(places)


# --- code and commands ---------------------------------------------------------------------------


def test_the_example_of_a_driver_runs():
    scope: dict = {}
    parts = [block for block in blocks("python") if "Attenuator" in block]
    assert len(parts) == 2
    for block in parts:
        exec(block, scope)


def test_the_import_of_an_export_exists():
    (block,) = [block for block in blocks("python") if "import export" in block]
    assert callable(import_module("cmtof.hardware.export").export)
    assert 'export("m.nc.journal", "so_far.nc")' in block


def commands() -> list[str]:
    lines = "\n".join(blocks("bash")).splitlines()
    return [line for line in lines if line.startswith("cmtof ")]


@pytest.mark.parametrize("line", commands())
def test_commands_exist_with_their_options(line):
    _, name, *arguments = shlex.split(line)
    command = typer.main.get_command(app).commands[name]
    command.make_context(name, arguments)  # parses; a wrong option is an error


def test_the_page_shows_how_to_copy_the_rig_file():
    from importlib.resources import files

    assert (files("cmtof.hardware") / "rig.yml").is_file()
    assert 'files("cmtof.hardware") / "rig.yml"' in TEXT
