"""Bus-off and its recovery (ISO 11898-1:2015, 12.1.4).  At 1 Mbit/s a bit takes 1 us, and a tick is a nanosecond."""

from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import US
from fieldrig_bus.can.bus_off import BusOff
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.medium import Medium
from fieldrig_bus.can.member import Controller, Member
from fieldrig_bus.can.notices import BusState, CanState

SEQUENCE = 11 * US


def bench(*, is_automatic: bool) -> tuple[Medium, BusOff, Member]:
    """A bus at 1 Mbit/s with one member that has just reached bus-off, with two frames waiting."""
    medium = Medium(1_000_000, None, is_acknowledged=False)
    bus_off = BusOff(medium, is_automatic=is_automatic)
    member = medium.members["node"] = Member("node", 1, Controller())
    member.queue.extend(medium.request(0, member, CanFrame(identifier)) for identifier in (1, 2))
    member.tec, member.state = 256, CanState.BUS_OFF
    medium.free = 100 * US
    bus_off.enter(member)
    return medium, bus_off, member


def test_a_controller_that_goes_off_gives_up_what_waits() -> None:
    medium, _, member = bench(is_automatic=True)
    assert (len(member.queue), medium.lost) == (0, 2)


def test_it_recovers_after_128_sequences_of_which_the_error_flag_is_followed_by_the_first() -> None:
    _, bus_off, member = bench(is_automatic=True)
    assert bus_off.next() == (100 * US + 127 * SEQUENCE, member)


def test_manual_recovery_waits_for_the_member_and_then_for_128_sequences() -> None:
    _, bus_off, member = bench(is_automatic=False)
    assert bus_off.next() is None
    assert not bus_off.is_recovering(member)
    assert bus_off.recover(500_000, member)
    assert not bus_off.recover(600_000, member)
    assert bus_off.next() == (500_000 + 128 * SEQUENCE, member)


def test_a_member_that_is_not_off_can_not_recover() -> None:
    _, bus_off, _ = bench(is_automatic=True)
    assert not bus_off.recover(0, Member("other", 2, Controller()))


@given(st.lists(st.integers(0, 5000), max_size=20))
def test_every_frame_counts_as_one_sequence_and_the_idle_bus_by_its_bits(idles_bits: list[int]) -> None:
    medium, bus_off, member = bench(is_automatic=True)
    missing = 127
    for idle_bits in idles_bits:
        start = medium.free + idle_bits * US
        bus_off.count(start)
        medium.free = start + 53 * US
        missing = max(0, missing - idle_bits // 11 - 1)
    assert bus_off.next() == (medium.free + missing * SEQUENCE, member)


def test_after_recovery_it_is_error_active_with_counters_of_0() -> None:
    _, bus_off, member = bench(is_automatic=True)
    member.rec, member.wants_state = 5, True
    ((time_ns, sender, message, receivers),) = bus_off.end(member, 1_497_000)
    assert (time_ns, sender, receivers) == (1_497_000, "node", ("node",))
    assert message == BusState(CanState.ACTIVE, 0, 0)
    assert (member.tec, member.rec, member.may_send, bus_off.next()) == (0, 0, True, None)


def test_a_member_that_leaves_recovers_no_more() -> None:
    _, bus_off, member = bench(is_automatic=True)
    bus_off.leave(member)
    assert bus_off.next() is None
