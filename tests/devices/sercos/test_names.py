"""Names of the messages of a ring.

The handshake is written by hand from IEC 61491: bits 0 to 5 of the control word are MHS, write, last, and the element;
bits 0 to 2 of the status word are AHS, busy, error.
"""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mc4_bench import DriveBench

from fieldrig.bus import Bus, Delivery
from fieldrig.traces.names import Named
from fieldrig_bus.ring.sercos.message import Answers, Cycle
from fieldrig_devices.mc4.settings import Mc4Settings
from fieldrig_devices.sercos.names import KnownDrive, SercosNames

CP2, CP4 = bytes.fromhex("FF 02"), bytes.fromhex("FF 04")
GAIN = "S-0-0104 position loop Kv-factor"


@pytest.fixture
def ring() -> SercosNames:
    table = {datum.idn: datum for datum in Mc4Settings(ring_address=1).operation_data()}
    return SercosNames({1: KnownDrive("belt", table), 2: KnownDrive("jaw", table)})


def exchange(ring: SercosNames, mdt: str, at: str) -> tuple[str, str]:
    """Return the texts of a step of the master and of the drive's answer."""
    asked = ring(Cycle(1, CP2, bytes.fromhex(mdt)))
    answered = ring(Answers(2, (bytes.fromhex(at),), ring_closed=True))
    assert (asked.kind, answered.kind) == ("CP2 MDT", "CP2 AT")
    return asked.text, answered.text.partition("belt: ")[2]


def opened(ring: SercosNames) -> SercosNames:
    """Open S-0-0104 (0068h) in the channel of drive 1."""
    exchange(ring, "01 00 00 00 00", "01 00 00 00 00")
    exchange(ring, "01 0F 00 68 00", "01 01 00 00 00")
    return ring


def test_a_read_has_the_name_of_its_idn_and_the_answer_its_value(ring: SercosNames) -> None:
    asked, answered = exchange(opened(ring), "01 3C 00 00 00", "01 00 00 68 01")
    assert (asked, answered) == (f"belt: read {GAIN}", f"{GAIN} = 3.6 (m/min)/mm")


def test_a_write_is_named_and_acknowledged_or_refused(ring: SercosNames) -> None:
    opened(ring)
    assert exchange(ring, "01 3E 00 F0 00", "01 00 00 00 00") == (
        f"belt: write {GAIN} = 2.4 (m/min)/mm", f"{GAIN} written",
    )  # fmt: skip
    assert exchange(ring, "01 3F 00 00 00", "01 05 00 06 70")[1] == f"{GAIN}: 7006h below minimum"


def test_a_busy_drive_has_not_answered_yet(ring: SercosNames) -> None:
    opened(ring)
    assert exchange(ring, "01 3C 00 00 00", "01 03 00 00 00")[1] == ""
    assert exchange(ring, "01 3C 00 00 00", "01 00 00 68 01")[1] == f"{GAIN} = 3.6 (m/min)/mm"


def test_a_ring_that_is_open_says_so(ring: SercosNames) -> None:
    ring(Cycle(1, CP4, b""))
    named = ring(Answers(2, (), ring_closed=False, errors=1))
    assert named == Named("CP4 AT", "", "0 drives, ring open, 1 with a wrong FCS")
    assert ring(Cycle(3, b"", b"")).kind == "MST failed"


def test_cyclic_values_have_the_names_that_the_master_has_configured() -> None:
    bench = DriveBench({})
    table = {datum.idn: datum for datum in Mc4Settings(ring_address=1).operation_data()}
    ring, seen = SercosNames({1: KnownDrive("d1", table)}), dict[str, Named]()

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if bus.name == "ring":
            named = ring(delivery.message)
            seen[named.kind] = named

    bench.rig.on_delivery(on_delivery)
    bench.up().enable()
    assert seen["CP4 AT"].node == "d1"
    assert f"S-0-0051 {bench.rig.get('d1/position')} incr" in seen["CP4 AT"].text
    assert "S-0-0047 " in seen["CP4 MDT"].text


def test_a_ring_that_runs_already_is_named_by_what_the_drives_say() -> None:
    bench = DriveBench({}).up().enable()
    table = {datum.idn: datum for datum in Mc4Settings(ring_address=1).operation_data()}
    ring, seen = SercosNames({1: KnownDrive("d1", table)}), dict[str, Named]()
    (keys,) = ring.wants().values()
    ring.learn("d1", {key: bench.rig.get(f"d1/{key}") for key in keys})

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if bus.name == "ring":
            seen.update({(named := ring(delivery.message)).kind: named})

    bench.rig.on_delivery(on_delivery)
    bench.run(20)
    assert f"S-0-0051 {bench.rig.get('d1/position')} incr" in seen["CP4 AT"].text
    assert "S-0-0047 " in seen["CP4 MDT"].text


@given(
    mst=st.binary(max_size=3),
    mdt=st.binary(max_size=40),
    ats=st.lists(st.binary(max_size=20), max_size=3).map(tuple),
)
def test_any_telegram_has_some_name(mst: bytes, mdt: bytes, ats: tuple[bytes, ...]) -> None:
    table = {datum.idn: datum for datum in Mc4Settings(ring_address=1).operation_data()}
    ring = SercosNames({1: KnownDrive("belt", table)})
    for message in (Cycle(1, mst, mdt), Answers(2, ats, ring_closed=True), Cycle(3, CP4, mdt)):
        assert isinstance(ring(message), Named)
