"""Serial lines with Modbus: the frames are published examples of simplymodbus.ca; those of ASCII are by pymodbus."""

from itertools import pairwise

from hypothesis import given, settings
from hypothesis import strategies as st
from logs import can_log

from fieldrig.clock import MS, S
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.framing_rtu import rtu_frame
from fieldrig_devices.dialogues import ModbusExchange, dialogues
from fieldrig_devices.dialogues.rtu_lines import MOST_KEPT, RtuLines

ASK, VALUES = bytes.fromhex("11 03 00 6B 00 03 76 87"), bytes.fromhex("11 03 06 AE 41 56 52 43 40 49 AD")
EXCHANGE = (17, ASK[1:-2], VALUES[1:-2])


def line(*pieces: bytes, senders: str = " ", gap_ns: int = MS) -> list[TraceEntry]:
    return [
        TraceEntry(number * gap_ns, "tty", "serial", senders[number % len(senders)].strip(), b"\x00" + piece)
        for number, piece in enumerate(pieces)
    ]


def exchanges(entries: list[TraceEntry]) -> list[tuple[int, bytes, bytes | None]]:
    found = dialogues(RtuLines().of(entries))
    return [(one.unit, one.request, one.response) for one in found if isinstance(one, ModbusExchange)]


def test_requests_and_responses_of_a_tap_are_exchanges() -> None:
    assert exchanges(line(ASK, VALUES, ASK, VALUES)) == [EXCHANGE, EXCHANGE]
    assert exchanges(line(ASK, VALUES, ASK, VALUES, senders="ms")) == [EXCHANGE, EXCHANGE]


def test_a_single_exchange_is_enough_if_there_is_nothing_else() -> None:
    assert exchanges(line(ASK)) == [(17, ASK[1:-2], None)]


@settings(max_examples=50, deadline=None)
@given(st.sets(st.integers(1, 2 * len(ASK + VALUES) - 1)))
def test_any_cut_of_the_bytes_gives_the_same_exchanges(cuts: set[int]) -> None:
    data = (ASK + VALUES) * 2
    pieces = [data[begin:end] for begin, end in pairwise([0, *sorted(cuts), len(data)])]
    assert exchanges(line(*pieces)) == [EXCHANGE, EXCHANGE]


IDENTIFY = bytes.fromhex("2B 0E 01 00")  # V1.1b3, 6.21
IDENTITY = bytes.fromhex(
    "2B 0E 01 01 00 00 03 00 16 436F6D70616E79206964656E74696669636174696F6E 01 04 434F4445 02 05 56322E3131"
)


@settings(max_examples=50, deadline=None)
@given(st.sets(st.integers(1, 110)))
def test_a_device_identification_is_put_together_from_any_pieces(cuts: set[int]) -> None:
    data = (rtu_frame(1, IDENTIFY) + rtu_frame(1, IDENTITY)) * 2
    pieces = [data[begin:end] for begin, end in pairwise([0, *sorted(cuts), len(data)])]
    assert exchanges(line(*pieces)) == [(1, IDENTIFY, IDENTITY)] * 2


ASCII_ASK, ASCII_VALUES = b":1103006B00037E\r\n", b":110306AE4156524340CC\r\n"


@settings(max_examples=50, deadline=None)
@given(st.sets(st.integers(1, 2 * len(ASCII_ASK + ASCII_VALUES) - 1)))
def test_ascii_is_put_together_from_any_pieces(cuts: set[int]) -> None:
    data = (ASCII_ASK + ASCII_VALUES) * 2
    pieces = [data[begin:end] for begin, end in pairwise([0, *sorted(cuts), len(data)])]
    assert exchanges(line(*pieces)) == [EXCHANGE, EXCHANGE]


def test_damaged_ascii_is_skipped_up_to_the_next_colon() -> None:
    lines = RtuLines()
    damaged = ASCII_ASK.replace(b"7E", b"7F") + b":1103" + b"noise"
    pieces = [ASCII_ASK, ASCII_VALUES, damaged, ASCII_ASK, ASCII_VALUES]
    found = list(lines.of(line(*pieces, gap_ns=S)))
    assert [one.data[:1] for one in found] == [b"\x03", b"\x00"] * 2
    assert lines.skipped == {"tty": len(damaged)}


def test_unit_58_of_rtu_is_no_ascii() -> None:
    """Its first byte is a colon; the checksum is that of pymodbus."""
    ask = bytes.fromhex("3A 03 00 6B 00 03 70 9C")
    assert exchanges(line(ask)) == [(58, ask[1:-2], None)]


def test_a_request_without_an_answer_is_unanswered() -> None:
    assert exchanges(line(ASK, ASK, VALUES, gap_ns=S)) == [(17, ASK[1:-2], None), EXCHANGE]


def test_bytes_of_a_damaged_frame_are_counted() -> None:
    lines = RtuLines()
    assert len(list(lines.of(line(ASK, VALUES, ASK[:-1] + b"\x00", ASK, VALUES, gap_ns=S)))) == 4
    assert lines.skipped == {"tty": len(ASK)}


def test_a_line_with_another_protocol_stays_as_it_is() -> None:
    entries = line(*[b"MOVE 1 100\r\n"] * 10)
    assert list(RtuLines().of(entries)) == entries
    many = line(*[b"x"] * (MOST_KEPT + 50))
    assert list(RtuLines().of(many)) == many


def test_other_buses_and_lines_that_are_known_pass() -> None:
    both = [*can_log("080#"), *line(ASK, VALUES)]
    assert list(RtuLines(lambda bus: bus == "tty").of(both)) == both


@given(st.lists(st.binary(max_size=12), max_size=30))
def test_any_bytes_are_a_line(pieces: list[bytes]) -> None:
    assert len(list(RtuLines().of(line(*pieces)))) <= 2 * sum(map(len, pieces)) + len(pieces)
