"""Names of the messages of a PAM's ring; the bytes of the frames are those of the table in pam-ring.md."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pam_rigs import pam_rig

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.faults.note import FaultNote
from fieldrig.pytest_plugin import RigMaker
from fieldrig.traces.names import Named, namer_of
from fieldrig_bus.ring.pam.message import GROUP, Cycle, Frames, Reception, Reports
from fieldrig_devices.pamring import codec
from fieldrig_devices.pamring.described import DescribedNode, DescribedObject
from fieldrig_devices.pamring.frame_words import KINDS
from fieldrig_devices.pamring.names import PamRingNames

TURN = 2.0**32
"""Resolver units in a turn of the motor (head of frames.py)."""
AXIS = DescribedNode(
    "NOD_Belt", (DescribedObject("AXI_Belt", "AXIS", TURN / 100), DescribedObject("SBI_Eye", "BINARY_INPUT"))
)
IO = DescribedNode(
    "NOD_Io",
    (
        DescribedObject("LED_Run", "LED_OUTPUT"),
        DescribedObject("ANO_Volts", "ANALOG_OUTPUT"),
        DescribedObject("DCM_Guide", "DC_MOTOR"),
    ),
)


@pytest.fixture
def ring() -> PamRingNames:
    return PamRingNames({1: "belt", 2: "cutter"}, {1: AXIS, 33: IO})


def order(ring: PamRingNames, target: int, contents: str) -> Named:
    return ring(Cycle(7, ((target, bytes.fromhex(contents)),)), "pam")


def report(ring: PamRingNames, address: int, contents: str) -> Named:
    data = bytes.fromhex(contents)
    return ring(Reports(8, ((address, bytes((len(data),)) + data),), (1, 33)), "ring")


@pytest.mark.parametrize(
    ("target", "contents", "expected"),
    [
        (0, "01", Named("identify", "all", "")),
        (0, "02", Named("run", "all", "")),
        (1, "09 01 0000008000000000", Named("set-point", "belt", "AXI_Belt position 50")),
        (2, "09 02 0500000000000000", Named("set-point", "cutter", "axis speed 5 RU")),
        (1, "09 03 f401000000000000", Named("set-point", "belt", "AXI_Belt torque limit 50 %")),
        (1, "0a 01", Named("end of pipe", "belt", "mode position")),
        (
            1,
            "08 07000000 03 0000000001000000 0000008000000000 0000000001000000 0000000002000000",
            Named(
                "axis order", "belt",
                "AXI_Belt absolute move 100, speed 50, acceleration 100, deceleration 200 (order 7)",
            ),
        ),
        (33, "04 0100 0100000000000000 00000000", Named("set output", "NOD_Io", "LED_Run = 1")),
        (33, "04 0200 f0d8ffffffffffff 00000000", Named("set output", "NOD_Io", "ANO_Volts = -10000 mV")),
        (33, "05 0100 01", Named("blink", "NOD_Io", "LED_Run on yes")),
        (33, "07 0300 03 02010000 ffffffffffffffff", Named("motor order", "NOD_Io", "DCM_Guide run -1 (order 258)")),
        (33, "0b 05000000 0300", Named("read", "NOD_Io", "register 3 (request 5)")),
        (1, "10 0200 c900 01 01 05000000 02000000",
         Named("configure input", "belt",
               "SBI_Eye address 201, bits 1, is active high yes, period ms 5, debounce 2")),
        (9, "04 0300 0100000000000000 00000000", Named("set output", "node 9", "item 3 = 1")),
        (1, "ff 01", Named("no order", "belt", "FF 01")),
    ],
)  # fmt: skip
def test_an_order_has_its_node_its_object_and_its_values(
    ring: PamRingNames, target: int, contents: str, expected: Named
) -> None:
    assert order(ring, target, contents) == expected


@pytest.mark.parametrize(
    ("address", "contents", "expected"),
    [
        (33, "81 02 0001", Named("identity", "NOD_Io", "node type smart io, firmware 256")),
        (33, "83 0100", Named("refused", "NOD_Io", "LED_Run")),
        (1, "85 0200 0100000000000000 2c010000 00000000",
         Named("input changed", "belt", "SBI_Eye level 1, 300 us ago")),
        (33, "86 05000000 01 2a00000000000000", Named("answer", "NOD_Io", "42 (request 5)")),
        (33, "86 05000000 00 0000000000000000", Named("answer", "NOD_Io", "no such register (request 5)")),
        (33, "88 0300 01 00200000 02010000",
         Named("motor report", "NOD_Io", "DCM_Guide ready, error 002000h (order 258)")),
        (1, "89 01 0e00 02000100 05000000 10000000",
         Named("trouble", "belt", "04..W00E 10002h 5h, error word 00000010h")),
    ],
)  # fmt: skip
def test_a_report_has_its_node_its_object_and_its_values(
    ring: PamRingNames, address: int, contents: str, expected: Named
) -> None:
    assert report(ring, address, contents) == expected


@pytest.mark.manual("PAMS-049", "PAMS-055")
def test_the_bits_of_an_axis_have_their_names(ring: PamRingNames) -> None:
    named = report(ring, 1, "87 12000000 02000010 07000000 0000008000000000")
    assert named.text == "AXI_Belt at 50, in move, power off, errors: servo lag error, servo reset (order 7 done)"


@pytest.mark.manual("PAML-162")
def test_a_set_point_of_a_group_names_its_nodes(ring: PamRingNames) -> None:
    order(ring, 1, "03 03")
    order(ring, 2, "03 03")
    assert order(ring, GROUP + 3, "09 01 0000000000000000").node == "group 3 belt cutter"
    order(ring, 1, "03 00")
    assert order(ring, GROUP + 3, "09 01 0000000000000000").node == "group 3 cutter"


def test_a_cycle_with_several_frames_concerns_all_of_their_nodes(ring: PamRingNames) -> None:
    frames = ((1, bytes.fromhex("09 01 0000008000000000")), (33, bytes.fromhex("04 0100 0100000000000000 00000000")))
    named = ring(Frames(1, frames), "pam")
    assert named == Named(
        "set-point, set output", "", "belt: set-point AXI_Belt position 50; NOD_Io: set output LED_Run = 1",
        ("belt", "NOD_Io"),
    )  # fmt: skip
    assert named.concerns("nod_io")
    assert not named.concerns("cutter")


def test_an_open_ring_says_where(ring: PamRingNames) -> None:
    assert ring(Reports(1, (), (1,), Reception.NO_CARRIER, 2), "ring") == Named("cycle", "", "no carrier at cutter")
    assert ring(Cycle(1, (), Reception.CRC_ERROR), "ring") == Named("wrong CRC", "", "")
    assert ring(FaultNote(2, "break"), "belt") == Named("fault", "belt", "fault 2: break")


def test_the_buffer_of_a_node_is_named_by_its_sender(ring: PamRingNames) -> None:
    assert ring(bytes.fromhex("03 82 02 00"), "belt") == Named("accepted", "belt", "SBI_Eye")
    assert ring(b"\x09", "belt") == Named("no report", "belt", "09")


@given(contents=st.binary(max_size=60), target=st.integers(0, GROUP + 15))
def test_any_bytes_have_some_name(contents: bytes, target: int) -> None:
    ring = PamRingNames({1: "belt"}, {1: AXIS, 33: IO})
    for message in (Cycle(1, ((target, contents),)), Reports(1, ((target, contents),), ()), contents):
        assert isinstance(ring(message, "belt"), Named)


def test_every_frame_has_a_word() -> None:
    assert codec.ENCODERS.keys() == KINDS.keys()


APPLICATION = """
APPLICATION NAME = NAMES V1.00 ; BASIC_PAM_CYCLE = 6 ; END
NODE NOD_Io; ADDRESS = 33; TYPE = SMART_IO; END
NODE NOD_Belt; ADDRESS = 1; TYPE = ST1; END
BINARY_INPUT SBI_Start; NODE = NOD_Io; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
AXIS AXI_Belt; NODE = NOD_Belt; PULSES_PER_UNIT = 42949672.96; TRAVEL_SPEED = 500.0; ACCELERATION = 2000.0;
  INITIAL_POSITION = 0.0; POSITION_PERIOD = 400.0; END
BINARY_OUTPUT SBO_Lamp; NODE = NOD_Io; ADDRESS = 102; ACTIVE = HIGH; END
"""
NODES = """\
  panel: {kind: smart_io, ring_address: 33, links: {ring: ring, wires: wires}}
  belt: {kind: st1, ring_address: 1, links: {ring: ring, wires: wires}}
"""


@pytest.mark.long
def test_the_objects_of_an_application_have_the_numbers_that_the_pam_gives_them(
    fieldrig_rig: RigMaker, tmp_path: Path
) -> None:
    rig = pam_rig(fieldrig_rig, tmp_path, APPLICATION, NODES)
    name, seen = namer_of(rig.config, "ring"), list[Named]()

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if bus.name == "ring":
            seen.append(name(delivery.message, delivery.sender))

    rig.on_delivery(on_delivery)
    rig.run_until(S)
    told = " / ".join(f"{named.kind} {named.node} {named.text}" for named in seen if "configure" in named.kind)
    for expected in ("SBI_Start address 101", "SBO_Lamp address 102", "AXI_Belt initial position 0"):
        assert expected in told
    rig.set("pam/SBO_Lamp", True)
    seen.clear()
    rig.run_until(S + 20 * MS)
    assert Named("set output", "panel", "SBO_Lamp level 1") in seen
