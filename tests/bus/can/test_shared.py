"""One link for several ends.  test_link_conformance shows that each of them is a link like any other."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.link import Link
from fieldrig.testing import RecordedLink
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.acceptance import EXTENDED, filters_of, passes, received
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BitRate, BusState, CanError, CanState, ErrorKind
from fieldrig_bus.can.shared import SharedLink

EXACT = 0x7FF | EXTENDED
NMT, SDO, HEARTBEAT = CanFrame(0, b"\x01\x00"), CanFrame(0x601, bytes(8)), CanFrame(0x701, b"\x05")
EVERYTHING: Any = None
OFF: Any = BusState(CanState.BUS_OFF, 256, 0)
ERROR: Any = CanError(ErrorKind.ACK, Place.ACK, 41, 1, True, False, 8, 0)


class Bench:
    """A shared link on a link that records what is sent; ends are named by letters."""

    def __init__(self) -> None:
        self.can = RecordedLink[CanFrame]()
        self.shared = SharedLink(self.can)
        self.ends: dict[str, Link[CanFrame]] = {}
        self.heard: list[tuple[str, Any]] = []

    def share(self, name: str, interest: list[Any] | None = None, **options: Any) -> Link[CanFrame]:
        self.ends[name] = self.shared.share(**options)
        self.listen(name, interest)
        return self.ends[name]

    def listen(self, name: str, interest: list[Any] | None = None) -> None:
        self.ends[name].on_receive(lambda message: self.heard.append((name, message)), interest)

    @property
    def interest(self) -> Any:
        return self.can.interest

    def deliver(self, *messages: Any) -> list[tuple[str, Any]]:
        before = len(self.heard)
        for message in messages:
            self.can.deliver(message)
        return self.heard[before:]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_bus_is_asked_for_what_all_want_together(bench: Bench) -> None:
    bench.share("a", [[0x701, EXACT], [0x600, 0x780]])
    bench.share("b", [[0x701, EXACT], [0, EXACT]])
    assert bench.interest == [[0x701, EXACT], [0x600, 0x780], [0, EXACT]]


def test_an_end_that_wants_everything_wants_it_for_the_link(bench: Bench) -> None:
    bench.share("a", [[0x701, EXACT]])
    bench.share("b")
    assert bench.interest == EVERYTHING
    bench.listen("a", [[0x701, EXACT], "state"])
    assert bench.interest == [[0, 0], "state"]
    bench.listen("b", [])
    assert bench.interest == [[0x701, EXACT], "state"]


def test_bus_is_not_asked_again_for_what_it_gives_already(bench: Bench) -> None:
    bench.share("a", [[0x701, EXACT]])
    asked = bench.interest
    bench.share("b", [[0x701, EXACT]])
    assert bench.interest is asked


def test_a_frame_goes_to_the_ends_that_want_it(bench: Bench) -> None:
    bench.share("a", [[0x701, EXACT]])
    bench.share("b", [[0x700, 0x780]])
    bench.share("c", [[0x601, EXACT]])
    expected = [("a", HEARTBEAT), ("b", HEARTBEAT), ("c", SDO)]
    assert bench.deliver(HEARTBEAT, SDO) == expected
    assert bench.deliver(HEARTBEAT, SDO) == expected  # the second time from the dictionary


def test_changed_interest_holds_at_once(bench: Bench) -> None:
    bench.share("a", [[0x701, EXACT]])
    bench.share("b", [[0x601, EXACT]])
    bench.deliver(HEARTBEAT)
    bench.listen("a", [])
    bench.listen("b", [[0x701, EXACT]])
    assert bench.deliver(HEARTBEAT, SDO) == [("b", HEARTBEAT)]


def test_end_that_never_listened_hears_nothing(bench: Bench) -> None:
    bench.shared.share()
    bench.share("b")
    assert bench.deliver(NMT) == [("b", NMT)]


def test_notices_go_to_the_ends_that_ask_for_them(bench: Bench) -> None:
    bench.share("a", ["state"])
    bench.share("b", ["errors", [0, EXACT]])
    bench.share("c")
    assert bench.interest == [[0, 0], "errors", "state"]
    assert bench.deliver(OFF, ERROR) == [("a", OFF), ("b", ERROR)]


def test_everything_sent_reaches_the_bus(bench: Bench) -> None:
    a, b = bench.share("a"), bench.share("b")
    a.send(NMT)
    b.send(SDO)
    rate: Any = BitRate(250_000)
    b.send(rate)
    assert bench.can.sent == [NMT, SDO, rate]
    assert bench.heard == []


# Frames of other ends of the same device


@pytest.fixture
def device(bench: Bench) -> Bench:
    """A master, and two slaves that obey it."""
    bench.share("master", [[0x701, EXACT]])
    bench.share("slave", [[0, EXACT]], hears_others=True)
    bench.share("other slave", [[0, EXACT]], hears_others=True)
    return bench


def test_master_reaches_slaves_of_its_own_device(device: Bench) -> None:
    device.ends["master"].send(NMT)
    assert device.heard == []  # it isn't on the wire yet
    assert device.interest == [[0x701, EXACT], [0, EXACT], "own", "state"]
    assert device.deliver(NMT) == [("slave", NMT), ("other slave", NMT)]


def test_a_sender_does_not_hear_itself(device: Bench) -> None:
    device.ends["slave"].send(NMT)
    assert device.deliver(NMT) == [("other slave", NMT)]
    assert device.deliver(NMT) == [("slave", NMT), ("other slave", NMT)]  # this frame is another device's


def test_what_was_lost_on_the_way_is_not_waited_for(device: Bench) -> None:
    device.ends["slave"].send(SDO)
    device.ends["slave"].send(NMT)
    assert device.deliver(NMT) == [("other slave", NMT)]
    assert device.deliver(SDO) == []
    device.ends["slave"].send(NMT)
    device.deliver(OFF)  # the controller gives up waiting frames
    assert device.deliver(NMT) == [("slave", NMT), ("other slave", NMT)]


def test_an_end_may_ask_for_its_own_frames_as_on_any_link(device: Bench) -> None:
    device.listen("master", [[0x701, EXACT], "own"])
    device.ends["master"].send(NMT)
    assert device.deliver(NMT) == [("master", NMT), ("slave", NMT), ("other slave", NMT)]


def test_device_without_such_ends_does_not_ask_for_its_own_frames(device: Bench) -> None:
    device.listen("slave", [])
    device.listen("other slave", [])
    assert device.interest == [[0x701, EXACT]]


def test_nmt_command_reaches_slaves_inside_and_outside_at_one_instant() -> None:
    buses = {"can0": {"kind": "can.virtual", "bitrate": 500_000}}
    with Rig(from_dict({"time": "virtual", "buses": buses, "devices": {}})) as rig:
        heard: list[tuple[str, int]] = []
        inside, outside = rig.attach("inside"), rig.attach("outside")
        shared = SharedLink(inside.link("can0"))
        master, slave = shared.share(), shared.share(hears_others=True)
        slave.on_receive(lambda frame: heard.append(("slave", inside.clock.now_ns())), [[0, EXACT]])
        outside.link("can0").on_receive(lambda frame: heard.append(("outside", outside.clock.now_ns())))
        rig.run_until(1 * MS)
        master.send(NMT)
        rig.run_until(2 * MS)
        assert sorted(heard) == [("outside", heard[0][1]), ("slave", heard[0][1])]
        assert heard[0][1] > 1 * MS


frames = st.builds(
    lambda identifier, is_extended, is_remote: CanFrame(identifier, b"", is_extended, is_remote),
    st.sampled_from([0, 1, 0x7F, 0x80, 0x181, 0x7FF]),
    st.booleans(),
    st.booleans(),
)
words = st.sampled_from([0, 1, 0x7F, 0x80, 0x181, 0x7FF, 0x780, EXTENDED, EXACT, 0xFFFF_FFFF, 0xC000_07FF])
interests = st.none() | st.lists(st.tuples(words, words).map(list), max_size=3)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.lists(interests, min_size=1, max_size=4), st.lists(frames, max_size=12))
def test_each_end_hears_what_its_filters_let_pass(wanted: list[Any], arriving: list[CanFrame]) -> None:
    bench = Bench()
    bench.share("another end", [[0x7FE, EXACT]])
    for number, interest in enumerate(wanted):
        bench.share(str(number), interest)
    merged = filters_of(bench.interest)
    for frame in arriving:
        expected = [
            (str(number), frame)
            for number, interest in enumerate(wanted)
            if passes(received(frame), filters_of(interest))
        ]
        assert bench.deliver(frame) == expected
        assert passes(received(frame), merged) == bool(expected)
