"""Names of the messages of serial lines by what the devices at them speak; the frames are those of the docs' tables."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.config.rig_file import from_dict
from fieldrig.faults.note import FaultNote
from fieldrig.traces.names import Named, Namer, namer_of
from fieldrig_bus.serial.message import Break, ControlLines, Format
from fieldrig_devices.arp.user_port.names import UserPortReader
from fieldrig_devices.line_names.serial import SerialNames

CONFIGS = Path(__file__).parents[3] / "configs"


def line_of(**device: Any) -> Namer:
    buses = {"line": {"kind": "serial.virtual"}, "telephone": {"kind": "telephone.virtual"}}
    return namer_of(from_dict({"time": "virtual", "buses": buses, "devices": {"card": device}}, CONFIGS), "line")


@pytest.fixture(scope="module")
def plain() -> Namer:
    return line_of(kind="modem", links={"line": "line", "telephone": "telephone"})


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (b"ATZ\r", Named("AT command", "card", "ATZ")),
        (ControlLines(dtr=True, rts=False), Named("control lines", "pc", "DTR=on RTS=off RI=off")),
        (Format(19_200, 8, "E", 1), Named("format", "pc", "19200 8E1")),
        (Break(100), Named("break", "pc", "break 100 ms")),
        (FaultNote(4, "noise"), Named("fault", "pc", "fault 4: noise")),
    ],
)
def test_each_message_has_its_kind(plain: Namer, message: Any, expected: Named) -> None:
    assert plain(message, "pc") == expected


def test_the_user_port_of_an_arp_has_its_commands() -> None:
    """The conversation in docs/devices/arp/arp-user-port.md, with its bytes."""
    name = line_of(kind="arp", number=1, links={"user": "line"})
    dialogue = [
        ("pc", "7e 01 ff 00 01 1f 37 7e", "HELLO", "any card"),
        ("card", "7e 01 01 00 81 00 01 00 01 5d 57 7e", "HELLO answer", "card 01: card 01, 256 octets, program none"),
        ("pc", "7e 01 01 01 12 01 00 c4 09 00 00 6f d0 7e", "WRITE_VARIABLES", "card 01: V1 = 2.5"),
        ("card", "7e 01 01 01 92 00 b9 a8 7e", "WRITE_VARIABLES answer", "card 01"),
        ("pc", "7e 01 01 02 10 56 01 00 02 00 5f 69 7e", "READ", "card 01: V1 to V2"),
        ("card", "7e 01 01 02 90 00 c4 09 00 00 00 00 00 00 61 6d 7e", "READ answer", "card 01: V1 = 2.5, V2 = 0"),
        ("pc", "7e 01 01 03 02 c3 b3 7e", "STATE", "card 01"),
        ("card", "7e 01 01 03 82 00 01 00 69 00 00 cc 00 00 00 00 00 00 63 38 7e", "STATE answer",
         "card 01: RESET_ENABLE, program none, ERROR 105, WARNING 204"),
        ("pc", "7e 01 01 05 13 0e b2 b7 7e", "WRITE_BITS", "card 01: 0E"),
        ("card", "7e 01 01 05 93 03 9b e0 7e", "WRITE_BITS answer", "card 01: LENGTH"),
    ]  # fmt: skip
    for sender, sent, kind, text in dialogue:
        assert name(bytes.fromhex(sent), sender) == Named(kind, "card", text)


def test_a_part_of_a_frame_is_shown_as_it_is() -> None:
    name = line_of(kind="arp", number=1, links={"user": "line"})
    assert name(bytes.fromhex("7e 01 ff"), "pc") == Named("part", "card", "7E 01 FF")
    assert name(bytes.fromhex("00 01 1f 37 7e"), "pc").kind == "HELLO"


@given(st.lists(st.tuples(st.sampled_from(["pc", "card"]), st.binary(max_size=40)), max_size=6))
def test_any_bytes_have_some_name(sent: list[tuple[str, bytes]]) -> None:
    arp = SerialNames(["card"], UserPortReader())
    for sender, data in sent:
        assert isinstance(arp(data, sender), Named)
