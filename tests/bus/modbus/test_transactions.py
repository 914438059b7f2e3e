"""A client's end of a TCP connection: Modbus messaging on TCP/IP implementation guide V1.0b, 3.1.3 and 4.4.1."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from segments import segments

from fieldrig.clock import MS
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.transactions import MOST_PENDING, Transactions

READ = ModbusRequest(7, bytes.fromhex("03 006B 0003"), 0xABCD)
TIMEOUT_NS = 100 * MS
ANSWER = "03 06 022B 0000 0064"


def asked(unit: int = 7) -> Transactions:
    """A client whose transaction 1 is open."""
    transactions = Transactions(TIMEOUT_NS)
    assert transactions.ask(0, READ, unit) == bytes.fromhex("0001 0000 0006") + bytes((unit,)) + READ.pdu
    return transactions


@pytest.mark.parametrize(
    ("unit", "frame"),
    [
        (7, f"0001 0000 0009 07 {ANSWER}"),
        (7, f"0001 0000 0009 FF {ANSWER}"),  # a unit that is not significant
        (7, f"0001 0000 0009 00 {ANSWER}"),
        (255, f"0001 0000 0009 FF {ANSWER}"),
        (1, f"0001 0000 0009 01 {ANSWER}"),  # it is 7 for the rig, 1 for its server
        (7, f"0009 0000 0009 07 {ANSWER} 0001 0000 0009 07 {ANSWER}"),  # another transaction before it
        (7, f"0001 0001 0009 07 {ANSWER} 0001 0000 0009 07 {ANSWER}"),  # another protocol before it
    ],
)
def test_a_response_goes_to_its_client(unit: int, frame: str) -> None:
    responses = asked(unit).feed(bytes.fromhex(frame))
    assert responses == [ModbusResponse(7, bytes.fromhex(ANSWER), 0xABCD)]


@pytest.mark.parametrize(
    "frame",
    [
        f"0000 0000 0009 07 {ANSWER}",  # no pending transaction
        f"0002 0000 0009 07 {ANSWER}",
        f"0100 0000 0009 07 {ANSWER}",
        f"0001 0000 0009 08 {ANSWER}",  # another unit behind a gateway
        f"0001 0001 0009 07 {ANSWER}",  # another protocol
        "0001 0000 0001 07",  # no PDU
        f"0001 0000 0009 07 {ANSWER}"[:-2],  # incomplete
    ],
)
def test_other_responses_are_discarded_and_the_right_one_is_still_waited_for(frame: str) -> None:
    transactions = asked()
    assert transactions.feed(bytes.fromhex(frame)) == []
    assert transactions.next_ns() == TIMEOUT_NS
    assert not transactions.is_lost


def test_a_response_is_taken_once() -> None:
    transactions, frame = asked(), bytes.fromhex(f"0001 0000 0009 07 {ANSWER}")
    assert len(transactions.feed(frame + frame)) == 1
    assert (transactions.foreign, transactions.next_ns()) == (1, None)


def test_what_the_pdu_says_is_for_the_client_to_judge() -> None:
    assert asked().feed(bytes.fromhex("0001 0000 0003 07 83 02"))[0].pdu == bytes.fromhex("83 02")
    assert asked().feed(bytes.fromhex("0001 0000 0003 07 99 02"))[0].pdu == bytes.fromhex("99 02")


def test_pipelined_transactions_may_be_answered_in_any_order() -> None:
    transactions = asked()
    transactions.ask(1, ModbusRequest(8, READ.pdu, 9), 8)
    both = transactions.feed(bytes.fromhex("0002 0000 0003 08 83 02 0001 0000 0003 07 83 03"))
    assert [(response.unit, response.exchange, response.pdu[1]) for response in both] == [(8, 9, 2), (7, 0xABCD, 3)]


def test_a_late_response_belongs_to_nothing() -> None:
    transactions = asked()
    assert transactions.expire(TIMEOUT_NS - 1) == 0
    assert transactions.expire(TIMEOUT_NS) == 1
    transactions.ask(TIMEOUT_NS, READ, 7)
    assert transactions.feed(bytes.fromhex(f"0001 0000 0009 07 {ANSWER}")) == []
    assert transactions.foreign == 1


def test_numbers_begin_anew_after_65535() -> None:
    transactions = Transactions(TIMEOUT_NS)
    frames = []
    for _ in range(0x1_0001):
        frames.append(transactions.ask(0, READ, 7)[:2].hex())
        transactions.expire(TIMEOUT_NS)
    assert (frames[0], frames[-3:]) == ("0001", ["ffff", "0000", "0001"])


def test_no_more_than_sixteen_are_open() -> None:
    transactions = Transactions(TIMEOUT_NS)
    for _ in range(MOST_PENDING):
        assert not transactions.is_full
        transactions.ask(0, READ, 7)
    assert transactions.is_full


def test_a_stream_out_of_step_is_lost() -> None:
    transactions = asked()
    assert transactions.feed(bytes.fromhex("0001 0000 FFFF 07")) == []
    assert transactions.is_lost


def head(number: int, protocol: int, unit: int, pdu: bytes) -> bytes:
    return b"".join(value.to_bytes(2, "big") for value in (number, protocol, len(pdu) + 1)) + bytes((unit,)) + pdu


frames = st.builds(head, st.integers(0, 4), st.integers(0, 1), st.integers(6, 8), st.binary(max_size=253))


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.lists(frames | st.binary(max_size=30), max_size=12).map(b"".join), st.lists(st.integers(0, 400), max_size=6))
def test_any_stream_gives_at_most_one_answer_per_request(stream: bytes, cuts: list[int]) -> None:
    transactions = Transactions(TIMEOUT_NS)
    for number in (1, 2, 3):
        transactions.ask(0, ModbusRequest(7, READ.pdu, number), 7)
    heard = [response for segment in segments(stream, cuts) for response in transactions.feed(segment)]
    numbers = [response.exchange for response in heard]
    assert len(set(numbers)) == len(numbers)
    assert set(numbers) <= {1, 2, 3}
    assert all(1 <= len(response.pdu) <= 253 for response in heard)
    assert transactions.expire(TIMEOUT_NS) == 3 - len(heard)
