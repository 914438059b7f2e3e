"""The terminal as a CANopen node: bytes in and out, messages in its EEPROM, the printer, refused requests.

The objects are ours; frames are written by hand from CiA 301 and the tables of docs/devices/arp/arp-terminal.md.
"""

import subprocess
import sys
from pathlib import Path

import pytest
from arp_terminal import START, TerminalBench
from full_store import FullStore
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.config.rig_file import from_dict
from fieldrig.errors import ControlError
from fieldrig.storage.store import FileStore
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.arp.terminal import objects
from fieldrig_devices.arp.terminal.messages import Messages
from fieldrig_devices.arp.terminal.settings import EDS, TerminalSettings
from fieldrig_devices.canopen.eds.check import check_eds
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.options import Options
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

WRITE_AUTOMATIC_CYCLE = [  # message 35, CiA 301 7.2.4.3.3: 15 bytes in segments
    ("614#21 00 21 23 0f 00 00 00", "594#60 00 21 23 00 00 00 00"),
    ("614#00 41 55 54 4f 4d 41 54", "594#20 00 00 00 00 00 00 00"),
    ("614#10 49 43 20 43 59 43 4c", "594#30 00 00 00 00 00 00 00"),
    ("614#0d 45 00 00 00 00 00 00", "594#20 00 00 00 00 00 00 00"),
]


@pytest.fixture
def bench() -> TerminalBench:
    return TerminalBench()


@pytest.mark.manual("ARP-119")
def test_it_starts_as_a_canopen_node_and_tells_keys_and_that_nothing_was_edited(bench: TerminalBench) -> None:
    assert bench.boot == ["714#00", "194#00 00 00 00", "294#00 00 00 00 00 00 00"]


@pytest.mark.manual("ARP-119")
def test_heartbeat_comes_as_often_as_the_master_asks(bench: TerminalBench) -> None:
    assert bench.send("614#2b 17 10 00 64 00 00 00") == ["594#60 17 10 00 00 00 00 00", "714#05"]
    assert bench.after(250) == ["714#05"] * 2


@pytest.mark.parametrize(("model", "product", "name"), [("TR4", "04", "54 52 34"), ("TR5", "05", "54 52 35")])
@pytest.mark.manual("ARP-119")
def test_it_says_which_model_it_is(model: str, product: str, name: str) -> None:
    bench = TerminalBench(model=model)
    assert bench.send("614#40 18 10 02 00 00 00 00") == [f"594#43 18 10 02 {product} 00 00 00"]
    assert bench.send("614#40 08 10 00 00 00 00 00") == [f"594#47 08 10 00 {name} 00"]


@pytest.mark.manual("ARP-114", "ARP-119")
def test_message_comes_by_sdo_and_is_shown(bench: TerminalBench) -> None:
    for request, answer in WRITE_AUTOMATIC_CYCLE:
        assert bench.send(request) == [answer]
    assert bench.get("message.35") == "AUTOMATIC CYCLE"
    assert bench.send("314#04 01 01 23 00 03") == []
    assert bench.screen == ["", "", "", "AUTOMATIC CYCLE", "", "", "", ""]


@pytest.mark.long
@pytest.mark.manual("ARP-114")
def test_messages_251_to_500_are_in_the_second_object(bench: TerminalBench) -> None:
    assert bench.send("614#23 01 21 fa 4f 4b 21 21") == ["594#60 01 21 fa 00 00 00 00"]
    assert bench.get("message.500") == "OK!!"
    assert bench.send("614#40 01 21 fa 00 00 00 00") == ["594#43 01 21 fa 4f 4b 21 21"]
    assert bench.send("614#2b 00 21 fa 41 42 00 00") == ["594#60 00 21 fa 00 00 00 00"]
    assert bench.get("message.250") == "AB"
    assert bench.send("614#40 01 21 fb 00 00 00 00") == ["594#80 01 21 fb 11 00 09 06"]  # there is no message 501


# Requests from the network, and the abort that answers each.
REFUSED = [
    ("a message that cannot be shown", "614#2b 00 21 01 41 07 00 00", "594#80 00 21 01 30 00 09 06"),
    ("an unknown command", "614#2f 10 20 05 07 00 00 00", "594#80 10 20 05 30 00 09 06"),
    ("an unknown print command", "614#2f 12 20 03 03 00 00 00", "594#80 12 20 03 30 00 09 06"),
    ("keys, which only the operator presses", "614#23 00 20 00 01 00 00 00", "594#80 00 20 00 02 00 01 06"),
]


@pytest.mark.parametrize(("what", "request_", "answer"), REFUSED)
def test_what_can_not_be_is_refused(bench: TerminalBench, what: str, request_: str, answer: str) -> None:
    assert bench.send(request_) == [answer]
    assert bench.get("message.1") == ""


def test_message_of_17_characters_is_refused(bench: TerminalBench) -> None:
    bench.send("614#21 00 21 01 11 00 00 00", "614#00 41 41 41 41 41 41 41", "614#10 41 41 41 41 41 41 41")
    assert bench.send("614#09 41 41 41 00 00 00 00") == ["594#80 00 21 01 12 00 07 06"]
    assert bench.get("message.1") == ""


# 2010h: line, column, height, message; then command 3.
WRONG_SHOWS = [("height 0", "01 01 00 01 00"), ("height 4", "01 01 04 01 00"), ("message 0", "01 01 01 00 00")]
WRONG_SHOWS += [("message 501", "01 01 01 f5 01")]


@pytest.mark.parametrize(("what", "fields"), WRONG_SHOWS)
def test_show_that_can_not_be_is_dropped_in_a_pdo_and_refused_by_sdo(
    bench: TerminalBench, what: str, fields: str
) -> None:
    bench.store_message(1, "A")
    bench.send("314#02 02 01 01 00 03")
    assert bench.send(f"314#{fields} 03") == []
    assert bench.send("614#2f 10 20 05 03 00 00 00") == ["594#80 10 20 05 30 00 09 06"]
    assert bench.screen[:3] == ["", " A", ""]


@pytest.mark.manual("ARP-115")
def test_every_screen_command_by_its_bytes(bench: TerminalBench) -> None:
    bench.store_message(1, "L=##.#")
    bench.send("314#02 03 01 01 00 03")  # show
    assert bench.get("texts") == "2 3 1 L=##.#"
    bench.send("314#03 01 02 01 00 04", "414#03 01 d2 04 00 00")  # show with a value: 1.234
    assert bench.get("texts") == "2 3 1 L=##.#\n3 1 2 L= 1.2"
    bench.send("314#02 03 01 00 00 02")  # erase
    assert bench.get("texts") == "3 1 2 L= 1.2"
    bench.send("314#00 00 01 00 00 00")  # nothing
    assert bench.get("texts") == "3 1 2 L= 1.2"
    bench.send("314#00 00 01 00 00 01")  # clear
    assert bench.get("texts") == ""


def test_the_same_by_sdo_for_a_master_without_pdos(bench: TerminalBench) -> None:
    bench.store_message(7, "HELLO")
    bench.send("000#80 14")
    for subindex, number in ((1, 8), (2, 2), (3, 1)):
        bench.send(f"614#2f 10 20 {subindex:02x} {number:02x} 00 00 00")
    bench.send("614#2b 10 20 04 07 00 00 00")
    assert bench.send("614#2f 10 20 05 03 00 00 00") == ["594#60 10 20 05 00 00 00 00"]
    assert bench.screen[7] == " HELLO"


def test_reset_node_empties_the_screen_and_keeps_messages(bench: TerminalBench) -> None:
    bench.store_message(1, "A")
    bench.send("314#01 01 01 01 00 03", "214#7f")
    bench.send("000#82 14", START)  # communication only
    assert bench.screen[0] == "A"
    bench.send("000#81 14", START)
    assert (bench.screen[0], bench.get("message.1"), bench.get("led.F7")) == ("", "A", False)


@pytest.mark.manual("ARP-114")
def test_messages_are_there_after_power_off() -> None:
    before = TerminalBench()
    for number, text in ((1, "FIRST"), (2, "x" * 16), (500, "LAST")):
        before.store_message(number, text)
    after = TerminalBench(before.store)
    assert [after.get(f"message.{number}") for number in (1, 2, 3, 500)] == ["FIRST", "x" * 16, "", "LAST"]


KILLED_AFTER_A_MESSAGE = """
import os, signal, sys
from pathlib import Path
from fieldrig.storage.store import FileStore
from fieldrig_devices.arp.terminal import objects
from fieldrig_devices.arp.terminal.messages import Messages
Messages(FileStore(Path(sys.argv[1])))[35] = "AUTOMATIC CYCLE"
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.system
@pytest.mark.manual("ARP-114")
def test_message_survives_a_kill(tmp_path: Path) -> None:
    killed = subprocess.run([sys.executable, "-c", KILLED_AFTER_A_MESSAGE, str(tmp_path / "tr")], check=False)
    assert killed.returncode == -9
    assert Messages(FileStore(tmp_path / "tr"))[35] == "AUTOMATIC CYCLE"


def test_message_that_the_memory_does_not_take_is_a_hardware_error() -> None:
    store = FullStore()
    store.has_ram = False
    bench = TerminalBench(store)
    index, subindex = objects.place_of_message(1)
    write = f"614#23 {index & 0xFF:02x} {index >> 8:02x} {subindex:02x} 41 42 43 44"
    (answer,) = bench.send(write)
    assert answer == f"594#80 {index & 0xFF:02x} {index >> 8:02x} {subindex:02x} 00 00 06 06"
    with pytest.raises(ControlError, match="message 1 cannot be stored: No space left on device"):
        bench.store_message(1, "ABCD")
    assert bench.get("message.1") == ""
    store.has_ram = True
    (answer,) = bench.send(write)
    assert (answer[:6], bench.get("message.1")) == ("594#60", "ABCD")


@pytest.mark.long
@pytest.mark.parametrize("text", ["x" * 17, "A\nB", "€"])
def test_point_of_a_message_refuses_an_invalid_message(bench: TerminalBench, text: str) -> None:
    with pytest.raises(ControlError, match="up to 16 characters of ISO 8859-1"):
        bench.set("message.1", text)


@pytest.mark.manual("ARP-116")
def test_printer_gets_one_line_for_each_message(bench: TerminalBench) -> None:
    bench.store_message(35, "AUTOMATIC CYCLE")
    bench.store_message(2, "LEN = #####.# mm")
    bench.send("514#00 00 00 00 23 00 01", "514#1c 96 98 00 02 00 02", "514#1c 96 98 00 02 00 01")
    assert bench.printer.sent == [b"AUTOMATIC CYCLE\r\n", b"LEN =  9999.9 mm\r\n", b"LEN = #####.# mm\r\n"]
    assert bench.get("printer") == "AUTOMATIC CYCLE\nLEN =  9999.9 mm\nLEN = #####.# mm"


@pytest.mark.manual("ARP-116")
def test_print_0_is_date_and_time_of_the_terminal_on_two_lines() -> None:
    bench = TerminalBench(time="2026-11-21T10:15:00")
    bench.after(61_000)
    bench.send("514#00 00 00 00 00 00 01")
    assert bench.printer.sent == [b"21/11/2026\r\n", b"10:16:01\r\n"]


@pytest.mark.manual("ARP-116")
def test_time_object_sets_the_clock_of_the_terminal(bench: TerminalBench) -> None:
    bench.send("100#a0 0c 33 02 31 3d")  # 10:15:00.000 of day 15665 after 1984-01-01
    bench.send("514#00 00 00 00 00 00 01")
    assert bench.get("printer") == "21/11/2026\n10:15:00"


def test_rounded_decimals_are_a_setting() -> None:
    bench = TerminalBench(decimals="rounded")
    bench.store_message(1, "#.#")
    bench.send("314#01 01 01 01 00 04", "414#01 01 b6 03 00 00", "514#b6 03 00 00 01 00 02")  # 0.950
    assert (bench.screen[0], bench.get("printer")) == ("1.0", "1.0")


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"model": "TR6"}, "TR4"),
        ({"node_id": 128}, "127"),
        ({"password": "abc"}, "pattern"),
        ({"password": ""}, "pattern"),
        ({"time": "noon"}, "2026-11-21T10:00:00"),
        ({"time": "1970-01-01"}, "1984"),
    ],
)
def test_wrong_settings_say_what_was_expected(wrong: dict[str, object], says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        TerminalSettings.model_validate(wrong)


def test_the_eds_is_faultless() -> None:
    assert [finding for finding in check_eds(EDS) if "no clear mapping direction" not in finding.what] == []


@pytest.mark.long
@pytest.mark.manual("ARP-119")
def test_it_conforms_to_cia_301() -> None:
    devices = {"tr": {"kind": "terminal.tr", "links": {"can": "can0"}}}
    config = from_dict({"time": "virtual", "buses": {"can0": {"kind": "can.virtual"}}, "devices": devices})
    with Rig(config) as rig:
        report = conform_virtual(rig, "can0", Description(EDS, 20), choose(()), Options(is_alone=True))
    assert {result.case.number: result.reason for result in report.of(Verdict.FAILED)} == {}
    assert len(report.of(Verdict.PASSED)) > 80


FRAMES = st.builds(
    lambda identifier, data: CanFrame(identifier, data),
    st.sampled_from([0x000, 0x100, 0x214, 0x314, 0x414, 0x514, 0x614]),
    st.binary(max_size=8),
)


@given(st.lists(FRAMES, max_size=30))
@settings(max_examples=60, deadline=None)
@pytest.mark.long
def test_nothing_from_the_bus_breaks_it(frames: list[CanFrame]) -> None:
    bench = TerminalBench()
    for number in range(1, 4):
        bench.store_message(number, "A=##.# B")
    for frame in frames:
        bench.can.deliver(frame)
        bench.after(1)
    bench.press("4 CR DOWN 1 CR")
    assert [len(line) for line in str(bench.get("screen")).split("\n")] == [16] * 8
