"""Modbus exchanges of a log: the bytes are the examples of the application protocol V1.1b3, chapter 6."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from logs import modbus_log

from fieldrig.clock import MS
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.message import (
    ClientConnected,
    DamagedAnswer,
    LineState,
    ModbusRequest,
    ModbusResponse,
    OnModbus,
)
from fieldrig_devices.dialogues import Dialogue, ModbusExchange, Stray, dialogues
from fieldrig_devices.dialogues.modbus_dialogues import MOST_OPEN, ModbusDialogues

READ, VALUES = bytes.fromhex("03 00 6B 00 03"), bytes.fromhex("03 06 02 2B 00 00 00 64")  # 6.3
LINE = LineState()


def ask(
    pdu: bytes = READ, exchange: int = 0, unit: int = 1, client: str = "a", line: LineState | None = None
) -> tuple[str, OnModbus]:
    return client, ModbusRequest(unit, pdu, exchange, line)


def answer(pdu: bytes = VALUES, exchange: int = 0, unit: int = 1) -> tuple[str, OnModbus]:
    return "meter", ModbusResponse(unit, pdu, exchange)


def of(*messages: tuple[str, OnModbus]) -> list[Dialogue]:
    return list(dialogues(modbus_log(messages)))


def exchanges(*messages: tuple[str, OnModbus]) -> list[tuple[tuple[int, ...], bytes | None, str]]:
    """Return the messages, the response and what is wrong of each exchange; there may be no strays."""
    found = of(*messages)
    return [(one.entries, one.response, one.wrong) for one in found if isinstance(one, ModbusExchange)]


@pytest.mark.parametrize(
    ("request_", "response"),
    [
        ("01 00 13 00 13", "01 03 CD 6B 05"), ("02 00 C4 00 16", "02 03 AC DB 35"),
        ("03 00 6B 00 03", "03 06 02 2B 00 00 00 64"), ("04 00 08 00 01", "04 02 00 0A"),
        ("05 00 AC FF 00", "05 00 AC FF 00"), ("06 00 01 00 03", "06 00 01 00 03"), ("07", "07 6D"),
        ("08 00 00 A5 37", "08 00 00 A5 37"), ("0F 00 13 00 0A 02 CD 01", "0F 00 13 00 0A"),
        ("10 00 01 00 02 04 00 0A 01 02", "10 00 01 00 02"), ("16 00 04 00 F2 00 25", "16 00 04 00 F2 00 25"),
        ("17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF", "17 0C 00 FE 0A CD 00 01 00 03 00 0D 00 FF"),
        ("18 04 DE", "18 00 06 00 02 01 B8 12 84"), ("2B 0E 01 00", "2B 0E 01 01 00 00 01 00 01 41"),
    ],
)  # fmt: skip
def test_a_request_and_its_response_are_one_exchange(request_: str, response: str) -> None:
    asked, answered = bytes.fromhex(request_), bytes.fromhex(response)
    (found,) = of(ask(asked), answer(answered))
    assert found == ModbusExchange(0, MS, "mb", (0, 1), 1, "a", asked, answered, "meter")
    assert found.exception is None


def test_an_exception_is_the_answer_of_its_request() -> None:
    (found,) = of(ask(), answer(b"\x83\x02"))
    assert isinstance(found, ModbusExchange)
    assert (found.response, found.exception) == (b"\x83\x02", 2)


def test_transactions_on_tcp_may_be_answered_in_any_order() -> None:
    found = exchanges(ask(exchange=7), ask(exchange=8), answer(exchange=8), answer(exchange=7))
    assert found == [((1, 2), VALUES, ""), ((0, 3), VALUES, "")]


def test_clients_with_the_same_transaction_get_the_answer_that_fits() -> None:
    coils = b"\x01\x00\x13\x00\x13"
    found = exchanges(ask(coils), ask(client="b"), answer(), answer(b"\x01\x03\xcd\x6b\x05"))
    assert [entries for entries, _, _ in found] == [(1, 2), (0, 3)]


def test_a_client_that_asks_again_has_given_up_the_request_before() -> None:
    log = modbus_log([ask(), ask(), answer()])
    found = dialogues(entry._replace(time_ns=100 * entry.time_ns) for entry in log)
    assert [one.entries for one in found] == [(0,), (1, 2)]


def test_requests_that_are_sent_at_once_may_have_one_transaction() -> None:
    """The client of a public capture sends three writes within 1 ms; they are answered one after the other."""
    writes = [b"\x06\x00\x04\x09\xc4", b"\x06\x00\x04\x00\x00", b"\x06\x00\x05\x36\xc1"]
    found = exchanges(*map(ask, writes), *map(answer, writes))
    assert found == [((0, 3), writes[0], ""), ((1, 4), writes[1], ""), ((2, 5), writes[2], "")]


def test_a_line_has_one_exchange_at_a_time() -> None:
    found = exchanges(ask(unit=1, line=LINE), ask(unit=2, line=LINE), answer(unit=2))
    assert found == [((0,), None, "no answer"), ((1, 2), VALUES, "")]


def test_nothing_answers_a_broadcast_on_a_line() -> None:
    (found,) = of(ask(bytes.fromhex("06 00 01 00 03"), unit=0, line=LINE))
    assert isinstance(found, ModbusExchange)
    assert (found.is_broadcast, found.response, found.wrong) == (True, None, "")


def test_unit_0_on_tcp_is_answered() -> None:
    assert exchanges(ask(unit=0), answer(unit=0)) == [((0, 1), VALUES, "")]


@pytest.mark.parametrize(
    "stray",
    [
        answer(bytes.fromhex("04 06 02 2B 00 00 00 64")),  # another function
        answer(bytes.fromhex("03 04 02 2B 00 00")),  # another number of registers
        answer(unit=2),
        ("10.0.0.5:502", ModbusResponse(1, VALUES, 1)),  # another transaction, in a capture of a network
    ],
)
def test_an_answer_that_fits_to_no_request_is_a_stray(stray: tuple[str, OnModbus]) -> None:
    first, second = of(ask(), stray, answer())
    assert isinstance(first, Stray)
    assert (first.entries, second.entries) == ((1,), (0, 2))


def test_a_rig_may_number_requests_and_responses_differently() -> None:
    found = exchanges(
        ask(exchange=7), ask(exchange=8, unit=2), answer(exchange=0x2_0001, unit=2), answer(exchange=0x1_0001)
    )
    assert [entries for entries, _, _ in found] == [(1, 2), (0, 3)]


def test_an_answer_that_a_fault_has_damaged_ends_its_exchange() -> None:
    damaged = DamagedAnswer(1, VALUES, 0, ((0, b"\x00\x01"),), is_cut=True)
    assert exchanges(ask(), ("meter", damaged), ask(), answer()) == [
        ((0, 1), None, "the answer was damaged"),
        ((2, 3), VALUES, ""),
    ]


def test_a_connection_is_no_dialogue() -> None:
    assert of(("a", ClientConnected("127.0.0.1"))) == []


def test_a_log_that_ends_or_begins_in_the_middle() -> None:
    first, second = of(answer(), ask())
    assert isinstance(first, Stray)
    assert isinstance(second, ModbusExchange)
    assert (second.response, second.wrong) == (None, "the log ends before the answer")


messages = st.one_of(
    st.builds(ask, st.binary(min_size=1, max_size=8), st.integers(0, 2), st.integers(0, 2), st.sampled_from("ab"),
              st.sampled_from([None, LINE])),
    st.builds(answer, st.binary(min_size=1, max_size=8), st.integers(0, 2), st.integers(0, 2)),
)  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(st.lists(messages, max_size=40))
def test_each_message_of_any_log_is_in_exactly_one_dialogue(sent: list[tuple[str, OnModbus]]) -> None:
    numbers = sorted(number for found in of(*sent) for number in found.entries)
    assert numbers == list(range(len(sent)))


@given(st.binary(max_size=20))
def test_any_bytes_of_an_entry_are_taken(data: bytes) -> None:
    assert len(list(dialogues([TraceEntry(0, "mb", "modbus", "", data)]))) <= 1


def test_open_requests_are_bounded() -> None:
    modbus = ModbusDialogues()
    sent = modbus_log(ask(exchange=number) for number in range(MOST_OPEN + 3))
    ended = [found for number, entry in enumerate(sent) for found in modbus.take(number, entry)]
    assert [found.entries for found in ended] == [(0,), (1,), (2,)]
    assert len(modbus.unfinished()) == MOST_OPEN
