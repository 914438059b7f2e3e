"""Error frames and error counters, with bit times counted by hand.  At 1 Mbit/s a bit takes 1 us.

`SHORT` is all zeros up to its CRC's end, with a recessive stuff bit at 5, 11, 17, 23, 29, 35.  Numbered from 0, the
DLC is at 18 to 22, the CRC delimiter at 40, the ACK slot at 41, its delimiter at 42,
the end of frame at 43 to 49.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import pytest

from fieldrig.bus import Delivery
from fieldrig.clock import US, S
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.member import Controller
from fieldrig_bus.can.model import LONGEST_QUEUE, CanBusModel
from fieldrig_bus.can.notices import BusState, CanControl, CanError, CanState, ErrorKind

SHORT = CanFrame(0)
SHORT_BITS = 50
INTERMISSION = 3
LATER = 10 * S


def bus(*members: str, **settings: Any) -> CanBusModel:
    model = CanBusModel(1_000_000, **settings)
    for member in members:
        model.join(member)
        model.listen(0, member, None)
    return model


def seen(model: CanBusModel, kind: type, until_ns: int = LATER) -> list[tuple[int, str, Any]]:
    """Time in bits, sender, and message of each delivery of a kind."""
    return [
        (each.time_ns // US, each.sender, each.message)
        for each in model.collect(until_ns)
        if isinstance(each.message, kind)
    ]


def counters(model: CanBusModel, member: str, now_ns: int = 0) -> tuple[int, int, CanState]:
    each = model.members[member]
    return each.tec, each.rec, each.state


class Row(NamedTuple):
    """One bit is flipped on the wire: the errors that follow, and the bit in which the second attempt has arrived."""

    bit: int
    error_bit: int
    kind: ErrorKind
    place: Place
    free_bit: int


# The sender sees its bit flipped and sends a flag from the next bit on, 6 bits; receivers see the sixth equal bit,
# or the wrong fixed bit, and send theirs; then 8 bits of delimiter and 3 of intermission.
ONE_BIT_TURNED = [
    # In the DLC, among zeros with stuff bits at 17 and 23, 20 becomes recessive.  Flag 21-26, the sixth dominant bit
    # in a row is 26: flag of the receivers 27-32, delimiter 33-40, intermission 41-43.
    Row(20, 20, ErrorKind.BIT, Place.DLC, 44),
    # CRC delimiter dominant: sender flags 41-46, and so do the receivers, which see a form error in the same bit.
    Row(40, 40, ErrorKind.BIT, Place.CRC_DELIMITER, 58),
    # ACK slot recessive again: the sender misses the acknowledge and flags 42-47; the receivers see that as a dominant
    # ACK delimiter, 42, and flag 43-48; delimiter 49-56.
    Row(41, 41, ErrorKind.ACK, Place.ACK, 60),
    # The first bit of the end of frame: all see it, and flag 44-49.
    Row(43, 43, ErrorKind.BIT, Place.END_OF_FRAME, 61),
]


@pytest.mark.parametrize("row", ONE_BIT_TURNED)
def test_a_turned_bit_is_answered_by_an_error_frame_and_the_frame_comes_again(row: Row) -> None:
    model = bus("a", "b", "c")
    model.add_fault(0, {"what": "corrupt", "bit": row.bit, "count": 1})
    model.submit(0, "a", SHORT)
    deliveries = model.collect(row.free_bit * US)
    (error,) = [each.message for each in deliveries if isinstance(each.message, CanError)]
    assert (error.kind, error.bit, error.place) == (row.kind, row.error_bit, row.place)
    assert (error.is_transmitter, error.tec, error.rec) == (True, 8, 0)
    assert counters(model, "b")[:2] == counters(model, "c")[:2] == (0, 1)
    assert seen(model, CanFrame) == [(row.free_bit + SHORT_BITS, "a", SHORT)]
    assert counters(model, "a")[:2] == (7, 0)
    assert counters(model, "b")[:2] == (0, 0)


def test_a_dominant_last_bit_of_the_end_of_frame_makes_the_frame_arrive_twice() -> None:
    """ISO 11898-1: a frame is valid for receivers from the last but one bit on, for the transmitter from the last."""
    model = bus("a", "b")
    model.add_fault(0, {"what": "corrupt", "bit": 49, "count": 1})
    model.submit(0, "a", SHORT)
    assert [message for _, _, message in seen(model, CanFrame)] == [SHORT, SHORT]


def test_a_lone_node_becomes_error_passive_and_stays_there() -> None:
    """Active: ACK slot 41, flag 42-47, delimiter 48-55, intermission 56-58; passive also 8 bits of suspension."""
    model = bus("a")
    model.submit(0, "a", SHORT)
    states = seen(model, BusState)
    assert states == [
        (59 * 11 + 56, "a", BusState(CanState.WARNING, 96, 0)),
        (59 * 15 + 56, "a", BusState(CanState.PASSIVE, 128, 0)),
    ]
    assert model.next_ns() is None
    assert counters(model, "a") == (128, 0, CanState.PASSIVE)
    attempts = 16 + -(-(10_000_000 - (16 * 59 + 8)) // 67)
    assert model.statistics(LATER)["retransmissions"] == attempts
    assert model.statistics(LATER)["load_percent"] == pytest.approx(100, abs=0.1)


def test_a_member_that_joins_hears_the_next_attempt_of_a_lone_node() -> None:
    model = bus("a")
    model.submit(0, "a", SHORT)
    model.collect(5 * S)
    model.join("b")
    model.listen(5 * S, "b", None)
    attempt = 16 * 59 + 8 + -(-(5_000_000 - (16 * 59 + 8)) // 67) * 67
    assert model.next_ns() == (attempt + SHORT_BITS) * US
    assert seen(model, CanFrame) == [(attempt + SHORT_BITS, "a", SHORT)]
    assert counters(model, "a") == (127, 0, CanState.WARNING)


@pytest.mark.long
def test_frames_of_a_lone_node_are_kept_up_to_the_limit() -> None:
    model = bus("a")
    for _ in range(LONGEST_QUEUE + 5):
        model.submit(0, "a", SHORT)
    model.collect(S)
    assert model.statistics(S)["lost_frames"] == 5


def test_two_senders_of_one_identifier_collide_until_they_are_passive() -> None:
    """Both fail 16 times; then, error passive, the loser signals nothing and the other gets through."""
    model = bus("a", "b", "c")
    model.submit(0, "a", CanFrame(0x100, b"\x01"))
    model.submit(0, "b", CanFrame(0x100, b"\x02"))
    errors = [each for _, _, each in seen(model, CanError, 16 * 50 * US)]
    assert {(each.kind, each.tec) for each in errors if each.is_transmitter} >= {
        (ErrorKind.BIT, 8),
        (ErrorKind.BIT, 128),
    }
    frames = seen(model, CanFrame)
    assert [(sender, message.data) for _, sender, message in frames] == [("a", b"\x01"), ("b", b"\x02")]
    assert counters(model, "c")[:2] < (0, 128)


def test_a_transmitter_under_a_dominant_wire_goes_bus_off_and_comes_back() -> None:
    """Data bit 28 is forced.  Bit error 28 (+8), flag 29-34, then +8 after 8, 16, .. dominant bits: 256 is reached
    with 34 + 31 * 8 = 282.  It recovers 128 times 11 recessive bits after the wire is released.
    """
    model = bus("a", "b")
    model.listen(0, "a", ["state"])
    model.add_fault(0, {"what": "short", "start_ms": 0.024, "duration_ms": 1})
    model.submit(0, "a", CanFrame(0, b"\xff"))
    states = seen(model, BusState)
    assert [(sender, state.state) for _, sender, state in states[:2]] == [
        ("a", CanState.BUS_OFF),
        ("b", CanState.PASSIVE),
    ]
    assert states[-1] == (1024 + 128 * 11, "a", BusState(CanState.ACTIVE, 0, 0))
    assert model.statistics(LATER)["lost_frames"] == 1


def test_with_manual_recovery_a_member_asks_to_come_back() -> None:
    model = bus("a", "b", is_recovering_by_itself=False)
    model.add_fault(0, {"what": "short", "start_ms": 0.024, "duration_ms": 1})
    model.submit(0, "a", CanFrame(0, b"\xff"))
    model.collect(S)
    assert counters(model, "a")[2] is CanState.BUS_OFF
    model.submit(S, "a", SHORT)
    assert seen(model, CanFrame) == []
    model.submit(LATER, "a", CanControl(recover=True))
    assert model.next_ns() == LATER + 128 * 11 * US
    model.collect(2 * LATER)
    assert counters(model, "a") == (0, 0, CanState.ACTIVE)


def test_busy_time_counts_one_sequence_a_frame_for_recovery() -> None:
    model = bus("a", "b", "c", is_recovering_by_itself=False)
    model.add_fault(0, {"what": "short", "start_ms": 0.024, "duration_ms": 1})
    model.submit(0, "a", CanFrame(0, b"\xff"))
    model.collect(S)
    for _ in range(300):
        model.submit(S, "b", SHORT)
    model.submit(S, "a", CanControl(recover=True))
    ((at, state),) = [(at, state) for at, sender, state in seen(model, BusState, 2 * S) if sender == "a"]
    assert state == BusState(CanState.ACTIVE, 0, 0)
    suspended = 127 * 8  # the short made b error passive, too
    assert at == 1_000_000 + 128 * (SHORT_BITS + INTERMISSION) + suspended


def test_a_one_shot_member_gives_up_after_an_error() -> None:
    model = bus("a", "b", controllers={"a": Controller(one_shot=True)})
    model.add_fault(0, {"what": "error_frame", "bit": 30, "count": 1})
    model.submit(0, "a", SHORT)
    model.submit(0, "a", CanFrame(1))
    ((_, _, error),) = seen(model, CanError, 60 * US)
    assert error.is_given_up
    assert [message.identifier for _, _, message in seen(model, CanFrame)] == [1]
    assert model.statistics(LATER)["lost_frames"] == 1


def test_a_one_shot_member_gives_up_when_it_loses_arbitration() -> None:
    model = bus("a", "b")
    model.submit(0, "a", CanControl(is_one_shot=True))
    model.submit(0, "a", CanFrame(0x100))
    model.submit(0, "b", SHORT)
    ((at, sender, error),) = seen(model, CanError)
    assert (at, sender, error.kind, error.is_given_up) == (SHORT_BITS, "a", ErrorKind.ARBITRATION_LOST, True)
    assert model.statistics(LATER)["frames"] == 1


def test_a_passive_transmitter_waits_eight_bits_more() -> None:
    model = bus("a", "b")
    model.members["a"].tec = 140
    model.submit(0, "a", CanControl())
    model.submit(0, "a", SHORT)
    model.submit(0, "a", SHORT)
    assert [at for at, _, _ in seen(model, CanFrame)] == [50, 53 + 8 + 50]
    assert counters(model, "a")[0] == 138


def test_lost_arbitration_is_counted() -> None:
    model = bus("a", "b", "c")
    for member, identifier in (("a", 1), ("b", 2), ("c", 3)):
        model.submit(0, member, CanFrame(identifier))
    model.collect(LATER)
    assert model.statistics(LATER)["arbitration_lost"] == 2 + 1


def test_a_classical_member_destroys_fd_frames_until_it_is_passive() -> None:
    model = bus("a", "b", "old", controllers={"old": Controller(classical=True)})
    model.submit(0, "a", CanFrame(0x123, bytes(8), is_fd=True))
    heard = [each for each in model.collect(LATER) if isinstance(each.message, CanFrame)]
    assert [each.receivers for each in heard] == [("b",)]
    assert model.statistics(LATER)["error_frames"] > 0
    assert counters(model, "old")[1] >= 127


def test_a_listen_only_member_hears_but_acknowledges_nothing() -> None:
    model = bus("a", "b", controllers={"b": Controller(listen_only=True)})
    model.submit(0, "a", SHORT)
    assert seen(model, CanFrame, S) == []
    model.join("c")
    model.listen(S, "c", None)
    (delivery,) = [each for each in model.collect(LATER) if isinstance(each.message, CanFrame)]
    assert delivery.receivers == ("b", "c")


def receivers_of(deliveries: Sequence[Delivery[CanMessage]], kind: type) -> list[Sequence[str]]:
    return [each.receivers for each in deliveries if isinstance(each.message, kind)]


def test_errors_and_states_are_delivered_on_request() -> None:
    model = bus("a", "b", "c")
    model.listen(0, "a", ["errors", "state"])
    model.listen(0, "b", ["errors"])
    model.add_fault(0, {"what": "corrupt", "bit": 30, "count": 12})
    model.submit(0, "a", SHORT)
    deliveries = model.collect(LATER)
    assert receivers_of(deliveries, CanError) == [("a",), ("b",)] * 12
    assert receivers_of(deliveries, BusState) == [("a",), ("a",)]  # warning at 96, and active again


def test_an_error_flag_after_the_error_frame_delays_nothing() -> None:
    """A classical and an FD frame diverge early; their error frame ends before bit 33, where a flag begins."""
    model = bus("a", "b", "c")
    model.add_fault(0, {"what": "error_frame", "bit": 33, "count": 1})
    model.submit(0, "a", CanFrame(2))
    model.submit(0, "b", CanFrame(2, is_fd=True))
    assert len(seen(model, CanFrame)) == 2
