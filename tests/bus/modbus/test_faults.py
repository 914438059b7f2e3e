"""Each fault of a Modbus bus: the bytes that a master outside gets, and what a client in the rig gets.

The exchange is the example of the application protocol V1.1b3, 6.3.  CRC and LRC come from pymodbus.
"""

from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymodbus.framer import FramerAscii, FramerRTU

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import MS
from fieldrig.faults.disturbed import medium_of
from fieldrig.faults.note import FaultNote
from fieldrig_bus.modbus import codec
from fieldrig_bus.modbus.faults import LINE_MODELS, MODELS, TCP_MODELS
from fieldrig_bus.modbus.message import ClientConnected, DamagedAnswer, ModbusRequest, ModbusResponse, OnModbus
from fieldrig_bus.modbus.virtual import ModbusVirtual, ModbusVirtualSettings

READ, ANSWER = bytes.fromhex("03 006B 0003"), bytes.fromhex("03 06 022B 0000 0064")
ON_TCP = bytes.fromhex("0007 0000 0009 11") + ANSWER
"""The answer of unit 11h to transaction 7 (messaging guide V1.0b, 3.1.3)."""
OUTSIDE, INSIDE = "tcp:1", "panel"
LATER = 10_000 * MS


def on_rtu(unit: int = 0x11, pdu: bytes = ANSWER) -> bytes:
    body = bytes((unit,)) + pdu
    return body + FramerRTU.compute_CRC(body).to_bytes(2, "big")


def on_ascii(unit: int = 0x11, pdu: bytes = ANSWER) -> bytes:
    body = bytes((unit,)) + pdu
    return b":" + (body + bytes((FramerAscii.compute_LRC(body),))).hex().upper().encode() + b"\r\n"


class Bench:
    """A device that answers each request at once, and two clients."""

    def __init__(self, *faults: dict[str, Any], seed: int = 1, **settings: Any) -> None:
        made = ModbusVirtualSettings.model_validate({"faults": list(faults), **settings})
        self.model: BusModel[OnModbus] = medium_of(ModbusVirtual("mb", made))
        self.model.begin(0, Random(f"{seed}/mb"))
        for member, units in (("device", [0x11, 0x12]), (OUTSIDE, []), (INSIDE, [])):
            self.model.join(member)
            self.model.listen(0, member, units)
        self.asked: list[bytes] = []
        self.trace: list[Delivery[Any]] = []
        self.heard: dict[str, list[tuple[int, Any]]] = {OUTSIDE: [], INSIDE: []}

    def ask(self, client: str, at_ms: int = 0, pdu: bytes = READ, unit: int = 0x11, number: int = 7) -> None:
        self.send(client, at_ms, pdu, unit, number)
        self.run()

    def send(self, client: str, at_ms: int, pdu: bytes, unit: int, number: int) -> None:
        self.model.submit(at_ms * MS, client, ModbusRequest(unit, pdu, number))

    def run(self) -> None:
        while (next_ns := self.model.next_ns()) is not None and next_ns <= LATER:
            for delivery in self.model.collect(next_ns):
                self.trace.append(delivery)
                for receiver in delivery.receivers:
                    self._hear(receiver, delivery)

    def _hear(self, receiver: str, delivery: Delivery[OnModbus]) -> None:
        message = delivery.message
        if receiver != "device":
            self.heard[receiver].append((delivery.time_ns // MS, message))
        elif isinstance(message, ModbusRequest):
            self.asked.append(message.pdu)
            pdu = ANSWER if message.pdu == READ else message.pdu
            self.model.submit(delivery.time_ns, "device", ModbusResponse(message.unit, pdu, message.exchange))

    @property
    def notes(self) -> list[str]:
        return [each.message.what for each in self.trace if isinstance(each.message, FaultNote)]

    def bytes_outside(self) -> list[bytes]:
        """The bytes of the wrong answers, with the pieces of each put together."""
        damaged = [message for _, message in self.heard[OUTSIDE] if isinstance(message, DamagedAnswer)]
        return [b"".join(data for _, data in answer.pieces) for answer in damaged]

    def answers(self, client: str) -> list[tuple[int, bytes]]:
        return [(ms, message.pdu) for ms, message in self.heard[client] if isinstance(message, ModbusResponse)]


def both(bench: Bench) -> Bench:
    bench.ask(OUTSIDE)
    bench.ask(INSIDE)
    return bench


@pytest.mark.parametrize(
    ("fault", "on_the_wire"),
    [
        ({"what": "drop"}, b""),
        ({"what": "wrong_unit"}, bytes.fromhex("0007 0000 0009 12") + ANSWER),
        ({"what": "wrong_unit", "answers_as": 255}, bytes.fromhex("0007 0000 0009 FF") + ANSWER),
        ({"what": "wrong_transaction"}, bytes.fromhex("0008 0000 0009 11") + ANSWER),
        ({"what": "wrong_transaction", "offset": -8}, bytes.fromhex("FFFF 0000 0009 11") + ANSWER),
        ({"what": "truncate"}, ON_TCP[:7]),
        ({"what": "truncate", "keep": 3}, ON_TCP[:3]),
        ({"what": "garbage", "data": "DE AD"}, b"\xde\xad" + ON_TCP),
        ({"what": "cut", "keep": 2}, ON_TCP[:2]),
    ],
    ids=str,
)
def test_a_client_outside_gets_the_bytes_and_one_inside_nothing(fault: dict[str, Any], on_the_wire: bytes) -> None:
    bench = both(Bench(fault))
    assert bench.bytes_outside() == [on_the_wire]
    assert bench.answers(OUTSIDE) == bench.answers(INSIDE) == []
    assert bench.asked == [READ, READ]
    assert len(bench.notes) == bench.model.all_faults(0)[1]["applied"] == 2


@pytest.mark.parametrize(
    ("mode", "fault", "on_the_wire", "passes"),
    [
        ("rtu", {"what": "wrong_crc"}, on_rtu()[:-2] + bytes(byte ^ 0xFF for byte in on_rtu()[-2:]), False),
        ("rtu", {"what": "wrong_unit"}, on_rtu(0x12), False),
        ("rtu", {"what": "garbage", "data": "00 FF"}, b"\x00\xff" + on_rtu(), False),
        ("rtu", {"what": "truncate", "keep": 10}, on_rtu()[:10], False),
        ("rtu", {"what": "lose_bytes", "share": 1}, b"", False),
        ("ascii", {"what": "garbage", "data": "41 42"}, b"AB" + on_ascii(), True),
        ("ascii", {"what": "wrong_unit"}, on_ascii(0x12), False),
    ],
    ids=str,
)
def test_bytes_of_a_line(mode: str, fault: dict[str, Any], on_the_wire: bytes, passes: bool) -> None:
    bench = both(Bench(fault, baud=19200, mode=mode))
    assert bench.bytes_outside() == [on_the_wire]
    assert [pdu for _, pdu in bench.answers(INSIDE)] == [ANSWER] * passes


def test_a_wrong_lrc_is_no_lrc_of_the_frame() -> None:
    bench = Bench({"what": "wrong_crc"}, baud=19200, mode="ascii")
    bench.ask(OUTSIDE)
    (frame,) = bench.bytes_outside()
    assert (frame[:-4], frame[-2:]) == (on_ascii()[:-4], b"\r\n")
    assert int(frame[-4:-2], 16) == int(on_ascii()[-4:-2], 16) + 1


def test_a_late_answer_comes_so_much_later() -> None:
    bench = both(Bench({"what": "delay", "delay_ms": 700}))
    assert bench.answers(OUTSIDE) == bench.answers(INSIDE) == [(700, ANSWER)]
    assert bench.notes == ["delayed", "delayed"]


def test_two_answers() -> None:
    assert both(Bench({"what": "duplicate"})).answers(OUTSIDE) == [(0, ANSWER), (0, ANSWER)]


@pytest.mark.parametrize(
    ("how", "pdu"), [({"data": "06 FFFF"}, "03 06 FFFF 0000 0064"), ({"xor": "01"}, "03 07 022B 0000 0064")]
)
def test_other_data_in_a_right_frame(how: dict[str, str], pdu: str) -> None:
    bench = both(Bench({"what": "replace", **how}))
    assert bench.answers(OUTSIDE) == bench.answers(INSIDE) == [(0, bytes.fromhex(pdu))]


def test_a_device_that_refuses_does_nothing() -> None:
    bench = both(Bench({"what": "exception", "code": 4}))
    assert bench.answers(OUTSIDE) == bench.answers(INSIDE) == [(0, bytes.fromhex("83 04"))]
    assert bench.asked == []


def test_an_exception_on_a_line_takes_its_time_there() -> None:
    bench = Bench({"what": "exception"}, baud=9600, mode="rtu")
    bench.ask(OUTSIDE)
    assert bench.answers(OUTSIDE) == [(22, bytes.fromhex("83 06"))]  # 13 characters and 2 silences of 11 bits


def test_a_lost_request_never_reaches_the_device() -> None:
    bench = both(Bench({"what": "drop", "of": "request"}))
    assert (bench.asked, bench.answers(OUTSIDE), bench.answers(INSIDE)) == ([], [], [])


def test_an_answer_in_two_pieces_is_whole_on_tcp_after_the_gap() -> None:
    bench = both(Bench({"what": "split", "keep": 5, "gap_ms": 30}))
    (answer,) = [message for _, message in bench.heard[OUTSIDE]]
    assert answer.pieces == ((0, ON_TCP[:5]), (30 * MS, ON_TCP[5:]))
    assert bench.answers(INSIDE) == [(30, ANSWER)]


@pytest.mark.parametrize(("gap_ms", "passes"), [(0.7, True), (0.9, False)])
def test_a_gap_of_more_than_a_character_and_a_half_ends_an_rtu_frame(gap_ms: float, passes: bool) -> None:
    """At 19200 baud 1.5 characters take 859 us (V1.02, 2.5.1.1)."""
    bench = both(Bench({"what": "split", "gap_ms": gap_ms}, baud=19200, mode="rtu"))
    assert bool(bench.answers(INSIDE)) is passes


def test_a_cut_closes_the_connection_and_a_refused_one_is_closed_at_once() -> None:
    bench = Bench({"what": "cut", "count": 1}, {"what": "refuse"})
    bench.ask(OUTSIDE)
    bench.model.submit(5 * MS, OUTSIDE, ClientConnected("127.0.0.1"))
    bench.run()
    assert [message.is_cut for _, message in bench.heard[OUTSIDE]] == [True, True]
    assert bench.notes == ["connection cut", "refused"]


def test_a_stuck_line_carries_nothing_until_it_is_free() -> None:
    bench = Bench({"what": "stuck", "duration_ms": 2_000}, baud=19200, mode="rtu")
    bench.ask(OUTSIDE)
    assert (bench.asked, bench.answers(OUTSIDE)) == ([], [])
    bench.ask(OUTSIDE, at_ms=3_000)
    assert [pdu for _, pdu in bench.answers(OUTSIDE)] == [ANSWER]


def test_a_device_at_half_the_rate_is_heard_as_other_bytes() -> None:
    """A start bit and a 0 of 9600 baud are two bits each for a receiver at 19200."""
    bench = Bench({"what": "wrong_baud", "baud": 9600}, baud=19200, mode="rtu", parity="N", stop_bits=2)
    bench.ask(OUTSIDE)
    (frame,) = bench.bytes_outside()
    assert frame[:1] == bytes((0b0000_0110,))  # of 11h: the start bit, 1 0 0 0 1, each twice
    assert frame != on_rtu()


def test_noise_is_the_same_in_every_run_of_a_seed() -> None:
    def run(seed: int) -> list[bytes]:
        bench = Bench({"what": "noise", "bit_error_rate": 0.05}, baud=19200, mode="rtu", seed=seed)
        for number in range(20):
            bench.ask(OUTSIDE, number * 100)
        return bench.bytes_outside()

    assert run(1) == run(1) != run(2)
    assert all(frame != on_rtu() and len(frame) == len(on_rtu()) for frame in run(1))


@pytest.mark.parametrize(
    ("where", "numbers"),
    [
        ({"unit": 0x12}, [1]),
        ({"function": 6}, [2]),
        ({"address": 0x6C}, [0, 1]),
        ({"address": 0x10}, [2]),
        ({"client": INSIDE}, []),
        ({"nth": 2, "count": 1}, [1]),
        ({"start_ms": 15, "duration_ms": 10}, [2]),
    ],
    ids=str,
)
def test_where_and_how_often(where: dict[str, Any], numbers: list[int]) -> None:
    bench = Bench({"what": "drop", **where})
    for number, (unit, pdu) in enumerate([(0x11, READ), (0x12, READ), (0x11, bytes.fromhex("06 0010 0003"))]):
        bench.send(OUTSIDE, 10 * number, pdu, unit, number)
    bench.run()
    dropped = [message.exchange for _, message in bench.heard[OUTSIDE] if isinstance(message, DamagedAnswer)]
    assert dropped == numbers


def test_a_fault_of_the_other_medium_is_refused() -> None:
    with pytest.raises(ValueError, match="wrong_crc is a fault of a serial line, and this bus is TCP"):
        Bench().model.add_fault(0, {"what": "wrong_crc"})
    with pytest.raises(ValueError, match="cut is a fault of TCP"):
        Bench({"what": "cut"}, baud=9600)
    assert {*TCP_MODELS, *LINE_MODELS} == {*MODELS}


def test_a_cleared_fault_does_nothing_and_costs_nothing() -> None:
    bench = Bench()
    plain = bench.model.collect
    number = bench.model.add_fault(0, {"what": "drop"})
    bench.ask(INSIDE)
    assert bench.model.collect != plain
    bench.model.clear_fault(LATER, number)
    assert (bench.model.all_faults(LATER), bench.model.collect) == ({}, plain)
    bench.ask(INSIDE)
    assert bench.answers(INSIDE) == [(0, ANSWER)]


PIECES = st.lists(st.tuples(st.integers(0, 1 << 63), st.binary(max_size=600)), max_size=4).map(tuple)


@given(st.integers(0, 255), st.binary(max_size=253), st.integers(0, 0xFFFF_FFFF), PIECES, st.booleans())
def test_damaged_answers_and_notes_come_back_from_their_bytes(
    unit: int, pdu: bytes, exchange: int, pieces: tuple[tuple[int, bytes], ...], is_cut: bool
) -> None:
    answer = DamagedAnswer(unit, pdu, exchange, pieces, is_cut)
    assert codec.decode(codec.encode(answer)) == answer
    note = FaultNote(exchange, "delayed")
    assert codec.decode(codec.encode(note)) == note
    assert codec.show(note) == f"fault {exchange}: delayed"
