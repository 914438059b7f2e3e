"""The bus as a function of time.  At 1 Mbit/s a bit takes 1 us; lengths are counted by hand in `test_length`."""

from collections.abc import Sequence

import pytest

from fieldrig.bus import Delivery
from fieldrig.clock import US, S
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.arbitration import priority
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.model import LONGEST_QUEUE, CanBusModel

SHORT = CanFrame(0)  # 53 bits with its 3 of intermission
SHORT_NS = 53 * US
INTERMISSION_NS = 3 * US
LATER = 1 * S


def bus(*members: str, bitrate: int | None = 1_000_000, data_bitrate: int | None = None) -> CanBusModel:
    model = CanBusModel(bitrate, data_bitrate, is_acknowledged=True)
    for member in members:
        model.join(member)
        model.listen(0, member, None)
    return model


def heard(model: CanBusModel, until_ns: int = LATER) -> list[tuple[int, str, int]]:
    return [(each.time_ns, each.sender, frame_of(each).identifier) for each in model.collect(until_ns)]


def frame_of(delivery: Delivery[CanMessage]) -> CanFrame:
    assert isinstance(delivery.message, CanFrame)
    return delivery.message


def identifiers(model: CanBusModel) -> list[int]:
    return [identifier for _, _, identifier in heard(model)]


def test_a_frame_arrives_with_its_last_bit_and_the_bus_is_free_three_bits_later() -> None:
    model = bus("a", "b")
    model.submit(1000, "a", SHORT)
    model.submit(1000, "a", SHORT)
    assert model.next_ns() == 1000 + SHORT_NS - INTERMISSION_NS
    assert heard(model) == [
        (1000 + SHORT_NS - INTERMISSION_NS, "a", 0),
        (1000 + 2 * SHORT_NS - INTERMISSION_NS, "a", 0),
    ]
    assert model.next_ns() is None


def test_nothing_arrives_before_its_instant() -> None:
    model = bus("a", "b")
    model.submit(0, "a", SHORT)
    end_ns = model.next_ns()
    assert end_ns is not None
    assert model.collect(end_ns - 1) == []
    assert len(model.collect(end_ns)) == 1


# In the order of arbitration, from the frame that wins over all others.
ORDER_OF_ARBITRATION = [
    CanFrame(0x000),
    CanFrame(0x0FF, is_remote=True),
    CanFrame(0x100),
    CanFrame(0x100, is_remote=True),
    CanFrame(0x100 << 18, is_extended=True),
    CanFrame(0x100 << 18, is_extended=True, is_remote=True),
    CanFrame(0x100 << 18 | 1, is_extended=True),
    CanFrame(0x101),
    CanFrame(0x7FF, is_remote=True),
    CanFrame(0x1FFF_FFFF, is_extended=True),
    CanFrame(0x1FFF_FFFF, is_extended=True, is_remote=True),
]


def test_arbitration_compares_as_on_the_wire() -> None:
    keys = [priority(frame) for frame in ORDER_OF_ARBITRATION]
    assert keys == sorted(set(keys))


def test_the_lowest_identifier_wins_regardless_of_the_order_of_asking() -> None:
    members = [f"m{number}" for number in range(len(ORDER_OF_ARBITRATION))]
    model = bus(*members)
    for member, frame in zip(members, reversed(ORDER_OF_ARBITRATION), strict=True):
        model.submit(0, member, frame)
    assert [each.message for each in model.collect(LATER)] == ORDER_OF_ARBITRATION


def test_a_frame_on_the_wire_is_not_interrupted() -> None:
    model = bus("a", "b", "c")
    model.submit(0, "a", CanFrame(0x700))
    model.submit(1, "b", CanFrame(0x600))
    model.submit(SHORT_NS // 2, "c", CanFrame(0x100))
    assert identifiers(model) == [0x700, 0x100, 0x600]


def test_a_frame_asked_for_during_intermission_takes_part_in_arbitration() -> None:
    model = bus("a", "b", "c")
    model.submit(0, "a", SHORT)
    model.submit(1, "b", CanFrame(0x200))
    (arrival,) = model.collect(SHORT_NS - INTERMISSION_NS)
    model.submit(arrival.time_ns, "c", CanFrame(0x100))
    assert identifiers(model) == [0x100, 0x200]


def test_each_member_sends_first_in_first_out() -> None:
    model = bus("a", "b")
    for identifier in (0x300, 0x100, 0x200):
        model.submit(0, "a", CanFrame(identifier))
    model.submit(0, "b", CanFrame(0x150))
    assert identifiers(model) == [0x150, 0x300, 0x100, 0x200]


def test_the_same_frame_from_two_members_at_once_is_one_on_the_wire() -> None:
    model = bus("first", "second", "third")
    model.submit(0, "second", SHORT)
    model.submit(0, "first", SHORT)
    end_ns = SHORT_NS - INTERMISSION_NS
    assert model.next_ns() == end_ns
    assert heard(model) == [(end_ns, "first", 0), (end_ns, "second", 0)]


def test_without_bit_times_the_same_identifier_goes_in_order_of_joining() -> None:
    model = bus("first", "second", bitrate=None)
    model.submit(0, "second", CanFrame(0, b"2"))
    model.submit(0, "first", CanFrame(0, b"1"))
    assert [sender for _, sender, _ in heard(model)] == ["first", "second"]


def test_a_late_submission_with_an_earlier_instant_wins_if_nothing_was_collected() -> None:
    model = bus("a", "b")
    model.submit(100, "a", CanFrame(0x100))
    model.submit(40, "b", SHORT)
    assert heard(model)[0] == (40 + SHORT_NS - INTERMISSION_NS, "b", 0)


def test_nothing_starts_before_the_end_of_what_was_collected() -> None:
    model = bus("a", "b")
    model.submit(0, "a", SHORT)
    assert heard(model) == [(SHORT_NS - INTERMISSION_NS, "a", 0)]
    model.submit(5, "b", SHORT)
    assert heard(model) == [(2 * SHORT_NS - INTERMISSION_NS, "b", 0)]


@pytest.mark.parametrize("bitrate", [500_000, 83_333, 33_333, 1_000_000, 95_238])
def test_times_do_not_drift(bitrate: int) -> None:
    model = bus("a", "b", bitrate=bitrate)
    for _ in range(1000):
        model.submit(0, "a", SHORT)
    bits = 1000 * 53 - 3
    last_ns = heard(model, 100 * S)[-1][0]
    assert last_ns == -(-bits * S // bitrate)  # rounded once, up


def test_the_data_of_fd_goes_at_its_own_bit_rate() -> None:
    frame = CanFrame(0, is_fd=True, is_bit_rate_switched=True)  # 31 bits nominal, 33 switched
    model = bus("a", "b", bitrate=500_000, data_bitrate=2_000_000)
    model.submit(0, "a", frame)
    assert model.next_ns() == (31 - 3) * 2000 + 33 * 500


def test_without_a_data_bit_rate_fd_takes_the_nominal_time() -> None:
    model = bus("a", "b")
    model.submit(0, "a", CanFrame(0, is_fd=True, is_bit_rate_switched=True))
    assert model.next_ns() == (31 + 33 - 3) * US


def test_an_unpaced_bus_takes_no_time_and_still_arbitrates() -> None:
    model = bus("a", "b", bitrate=None)
    model.submit(10, "a", CanFrame(0x300))
    model.submit(10, "b", CanFrame(0x200))
    model.submit(20, "a", CanFrame(0x100))
    assert heard(model, 10) == [(10, "b", 0x200), (10, "a", 0x300)]
    assert model.next_ns() == 20
    assert heard(model, 20) == [(20, "a", 0x100)]


def receivers(model: CanBusModel, sender: str, frame: CanFrame) -> Sequence[str]:
    model.submit(0, sender, frame)
    (delivery,) = model.collect(LATER)
    return delivery.receivers


def test_all_listeners_but_the_sender_hear_in_order_of_joining() -> None:
    model = bus("c", "a", "b")
    assert receivers(model, "a", SHORT) == ("c", "b")


def test_a_member_that_never_listened_hears_nothing() -> None:
    model = bus("a")
    model.join("deaf")
    assert receivers(model, "a", SHORT) == ()


def test_a_changed_interest_counts_at_once() -> None:
    model = bus("a", "b")
    assert receivers(model, "a", CanFrame(0x181)) == ("b",)
    model.listen(0, "b", [[0x201, 0x7FF]])
    assert receivers(model, "a", CanFrame(0x181)) == ()
    assert receivers(model, "a", CanFrame(0x201)) == ("b",)
    assert receivers(model, "a", CanFrame(0x201 << 18, is_extended=True)) == ()
    model.listen(0, "b", [[0x201 << 18 | EXTENDED, 0x1FFF_FFFF | EXTENDED]])
    assert receivers(model, "a", CanFrame(0x201 << 18, is_extended=True)) == ("b",)
    model.listen(0, "b", [])
    assert receivers(model, "a", CanFrame(0x201)) == ()


def test_a_member_that_joins_later_hears_the_next_frame() -> None:
    model = bus("a")
    assert receivers(model, "a", SHORT) == ()
    model.join("b")
    model.listen(0, "b", None)
    assert receivers(model, "a", SHORT) == ("b",)


def test_own_frames_confirm_that_they_were_sent() -> None:
    model = bus("a", "b")
    model.listen(0, "a", ["own"])
    assert receivers(model, "a", SHORT) == ("a", "b")
    assert receivers(model, "b", SHORT) == ()
    sent = CanFrame(0x55)
    model.submit(0, "a", sent)
    assert model.collect(LATER)[0].message is sent


def test_a_wrong_interest_is_refused_and_changes_nothing() -> None:
    model = bus("a", "b")
    with pytest.raises(ValueError, match="not an acceptance filter"):
        model.listen(0, "b", [[1]])
    assert receivers(model, "a", SHORT) == ("b",)


def test_a_leaving_member_drops_its_queue_but_not_the_frame_on_the_wire() -> None:
    model = bus("a", "b", "c")
    for identifier in (0x100, 0x101, 0x102):
        model.submit(0, "a", CanFrame(identifier))
    model.submit(1, "b", CanFrame(0x200))
    model.leave("a")
    assert [(sender, identifier) for _, sender, identifier in heard(model)] == [("a", 0x100), ("b", 0x200)]


@pytest.mark.parametrize("asked_ns", [0, 1])
def test_a_member_that_leaves_while_another_sends_sends_nothing_more(asked_ns: int) -> None:
    model = bus("a", "b")
    model.submit(0, "a", SHORT)
    model.submit(asked_ns, "b", CanFrame(0x200))
    model.leave("b")
    assert identifiers(model) == [0]
    model.submit(0, "b", SHORT)  # its last message came too late
    assert model.next_ns() is None


def test_a_member_that_left_may_join_again() -> None:
    model = bus("a", "b")
    model.leave("b")
    assert receivers(model, "a", SHORT) == ()
    model.join("b")
    model.listen(0, "b", None)
    assert receivers(model, "a", SHORT) == ("b",)


def test_a_name_is_taken_once() -> None:
    with pytest.raises(ValueError, match="already"):
        bus("a", "a")


def test_the_newest_of_too_many_frames_are_lost() -> None:
    model = bus("a", "b")
    for _ in range(LONGEST_QUEUE + 2):
        model.submit(0, "a", SHORT)
    assert model.statistics(0)["lost_frames"] == 2
    assert model.statistics(0)["waiting_frames"] == LONGEST_QUEUE


def test_statistics_count_frames_bits_and_load() -> None:
    model = bus("a", "b")
    frames_of_half_a_second = S // 2 // SHORT_NS
    for _ in range(frames_of_half_a_second):
        model.submit(0, "a", SHORT)
    model.collect(S - 1)
    statistics = model.statistics(S - 1)
    assert statistics["frames"] == frames_of_half_a_second
    assert statistics["bits"] == 53 * frames_of_half_a_second
    assert statistics["waiting_frames"] == 0
    assert statistics["load_percent"] == pytest.approx(50, abs=0.1)
    assert model.statistics(S + S // 2)["load_percent"] == pytest.approx(25, abs=0.1)
    assert model.statistics(5 * S)["load_percent"] == 0


@pytest.mark.long
def test_a_full_bus_has_a_load_of_100_percent() -> None:
    model = bus("a", "b")
    model.submit(0, "a", SHORT)
    for _ in range(2 * S // SHORT_NS):
        next_ns = model.next_ns()
        assert next_ns is not None
        (delivery,) = model.collect(next_ns)
        model.submit(delivery.time_ns, "a", SHORT)
    assert model.statistics(delivery.time_ns)["load_percent"] == pytest.approx(100, abs=0.1)


def test_an_unpaced_bus_has_no_load() -> None:
    model = bus("a", "b", bitrate=None)
    model.submit(0, "a", SHORT)
    model.collect(0)
    assert model.statistics(0)["load_percent"] == 0
