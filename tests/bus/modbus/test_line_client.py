"""The master's end of a serial line, with a clock that the test moves."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from modbus_bench import ascii_, rtu

from fieldrig.clock import MS, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.framing_ascii import AsciiFramer
from fieldrig_bus.modbus.framing_rtu import RtuFramer, response_size
from fieldrig_bus.modbus.line_client import LineClient, fits
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse

READ, ANSWER = bytes.fromhex("03 0000 0001"), bytes.fromhex("03 02 0001")
TIMING = LineTiming(baud=9600)


class Bench:
    def __init__(self, is_ascii: bool = False) -> None:
        self.clock, self.link = VirtualClock(), RecordedLink[Any]()
        self.written: list[bytes] = []
        framer = AsciiFramer(TIMING) if is_ascii else RtuFramer(TIMING, size_of=response_size)
        self.client = LineClient(self.clock, self.link, self.written.append, framer, [7])

    def pass_ms(self, ms: int) -> None:
        self.clock.advance_to(self.clock.now_ns() + ms * MS)


@pytest.mark.parametrize("is_ascii", [False, True])
def test_a_request_goes_out_at_once_and_its_answer_comes_after_the_time_of_its_characters(is_ascii: bool) -> None:
    bench, frame = Bench(is_ascii), ascii_ if is_ascii else rtu
    bench.link.deliver(ModbusRequest(7, READ, 5))
    assert (bench.written, bench.link.interest) == ([frame(7, READ)], [7])
    bench.client.on_bytes(frame(7, ANSWER))
    assert bench.link.sent == []
    bench.pass_ms(50)
    assert bench.link.sent == [ModbusResponse(7, ANSWER, 5)]


def test_a_response_belongs_to_the_last_request_only() -> None:
    bench = Bench()
    bench.link.deliver(ModbusRequest(7, READ, 5))
    bench.link.deliver(ModbusRequest(7, READ, 6))
    for _ in range(2):
        bench.client.on_bytes(rtu(7, ANSWER))
        bench.pass_ms(50)
    assert bench.link.sent == [ModbusResponse(7, ANSWER, 6)]
    assert bench.client.foreign == 1


def test_a_broadcast_is_not_answered() -> None:
    bench = Bench()
    bench.link.deliver(ModbusRequest(0, bytes.fromhex("06 0001 0003"), 5))
    bench.client.on_bytes(rtu(0, bytes.fromhex("06 0001 0003")))
    bench.pass_ms(50)
    assert bench.link.sent == []


pdus = st.sampled_from([READ, bytes.fromhex("06 0001 0003"), bytes.fromhex("10 0001 0001 02 0003"), b"\x07"])
requests = st.builds(ModbusRequest, st.sampled_from([0, 7, 8]), pdus, st.integers(0, 9))
answers = st.sampled_from([ANSWER, bytes.fromhex("83 02"), bytes.fromhex("06 0001 0003"), b"\x07\x6d"])
frames = st.builds(rtu, st.sampled_from([7, 8]), answers) | st.builds(ascii_, st.sampled_from([7, 8]), answers)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.booleans(), st.lists(st.tuples(requests | frames | st.binary(max_size=30), st.integers(0, 60)), max_size=20))
def test_each_request_gets_at_most_one_matching_answer(
    is_ascii: bool, steps: list[tuple[ModbusRequest | bytes, int]]
) -> None:
    bench = Bench(is_ascii)
    open_: ModbusRequest | None = None
    for step, pause_ms in steps:
        if isinstance(step, ModbusRequest):
            bench.link.deliver(step)
            open_ = step
        else:
            bench.client.on_bytes(step)
        bench.pass_ms(pause_ms)
        for response in bench.link.take():
            assert open_ is not None
            assert (response.unit, response.exchange) == (open_.unit, open_.exchange)
            assert open_.unit != 0
            assert fits(open_.pdu, response.pdu)
            open_ = None
