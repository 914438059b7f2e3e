"""Each fault of a serial line: what arrives at the other end, and when.  8N1 at 9600 baud is 10 bits a character."""

from random import Random
from typing import Any

import pytest

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import MS
from fieldrig.faults.disturbed import medium_of
from fieldrig.faults.note import FaultNote
from fieldrig_bus.serial import codec
from fieldrig_bus.serial.line import SerialVirtual, SerialVirtualSettings
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage

HELLO, LATER = b"HELLO", 1000 * MS
OFF = ControlLines(dtr=False, rts=False, ri=False, dcd=False)


class Bench:
    def __init__(self, *faults: dict[str, Any], seed: int = 1, **settings: Any) -> None:
        made = SerialVirtualSettings.model_validate(
            {"baud": 9600, "chunk_us": 100_000, "faults": list(faults), **settings}
        )
        self.model: BusModel[SerialMessage] = medium_of(SerialVirtual("com1", made))
        self.model.begin(0, Random(f"{seed}/com1"))
        for member in ("plc", "printer"):
            self.model.join(member)
            self.model.listen(0, member, ["data", "lines", "break"])
        self.trace: list[Delivery[Any]] = []

    def send(self, data: SerialMessage, at_ms: int = 0, sender: str = "plc") -> None:
        self.model.submit(at_ms * MS, sender, data)

    def heard(self, receiver: str = "printer") -> list[tuple[int, SerialMessage]]:
        """The milliseconds and the messages that one end has heard by now."""
        while (next_ns := self.model.next_ns()) is not None and next_ns <= LATER:
            self.trace += self.model.collect(next_ns)
        return [(each.time_ns // MS, each.message) for each in self.trace if receiver in each.receivers]


@pytest.mark.parametrize(
    ("fault", "arrives"),
    [
        ({"what": "drop"}, []),
        ({"what": "drop", "end": "printer"}, [(5, HELLO)]),
        ({"what": "delay", "delay_ms": 20}, [(25, HELLO)]),
        ({"what": "duplicate"}, [(5, HELLO), (5, HELLO)]),
        ({"what": "replace", "data": "41"}, [(5, b"AELLO")]),
        ({"what": "replace", "xor": "0001"}, [(5, b"HDLLO")]),
        ({"what": "garbage", "data": "FF00"}, [(5, b"\xff\x00HELLO")]),
        ({"what": "lose_bytes", "share": 1}, []),
        ({"what": "stuck"}, []),
        ({"what": "stuck", "level": "low", "duration_ms": 500}, [(0, Break(500))]),
        ({"what": "break", "length_ms": 2}, [(0, Break(2)), (5, HELLO)]),
        ({"what": "break", "length_ms": 50}, [(0, Break(50))]),
    ],
    ids=str,
)
def test_what_arrives(fault: dict[str, Any], arrives: list[tuple[int, SerialMessage]]) -> None:
    bench = Bench()
    bench.model.add_fault(0, fault)
    bench.send(HELLO)
    assert bench.heard() == arrives


def test_half_the_rate_makes_each_bit_two() -> None:
    """55h is 0 1010 1010 1 on the line; at half the rate the receiver reads 0 0110 0110, which is 66h, and so on."""
    bench = Bench({"what": "wrong_baud", "baud": 4800})
    bench.send(b"\x55")
    ((_, data),) = bench.heard()
    assert isinstance(data, bytes)
    assert data[:1] == b"\x66"


def test_noise_inverts_bits_and_is_the_same_in_every_run() -> None:
    def run(seed: int) -> list[tuple[int, SerialMessage]]:
        bench = Bench({"what": "noise", "bit_error_rate": 0.2}, seed=seed)
        bench.send(HELLO)
        return bench.heard()

    assert run(1) == run(1) != run(2)
    assert len(run(1)) == 1


def test_a_cable_that_is_pulled_out_takes_the_control_lines_with_it() -> None:
    bench = Bench()
    bench.send(ControlLines(dtr=True, rts=False))
    bench.model.collect(0)
    bench.model.add_fault(10 * MS, {"what": "unplugged", "duration_ms": 100})
    bench.send(HELLO, 20)
    bench.send(ControlLines(dtr=True, rts=True), 50)
    bench.send(HELLO, 200)
    off = [(10, OFF), (50, OFF), (110, ControlLines())]
    assert bench.heard() == [*off, (205, HELLO)]
    assert [message for _, message in bench.heard("plc")] == [OFF, ControlLines()]


def test_a_cable_pulled_out_twice_is_back_when_both_faults_are_over() -> None:
    bench = Bench({"what": "unplugged", "duration_ms": 100}, {"what": "unplugged", "start_ms": 50, "duration_ms": 100})
    assert bench.heard() == [(0, OFF), (150, ControlLines())]


def test_a_format_that_is_set_without_a_cable_is_known_when_the_cable_is_back() -> None:
    bench = Bench({"what": "unplugged", "duration_ms": 100})
    bench.model.listen(0, "printer", ["data", "format"])
    bench.send(Format(1200), 50)
    assert bench.heard() == [(100, Format(1200))]


@pytest.mark.parametrize("level", ["high", "low"])
def test_an_end_that_is_held_sends_no_break(level: str) -> None:
    bench = Bench({"what": "stuck", "level": level, "start_ms": 10, "duration_ms": 400})
    bench.send(Break(100), 100)
    bench.send(Break(100), 500)
    held = [(10, Break(400))] if level == "low" else []
    assert bench.heard() == [*held, (600, Break(100))]


def test_a_line_that_is_at_space_or_unplugged_gets_no_second_break() -> None:
    low = {"what": "stuck", "level": "low", "duration_ms": 100}
    bench = Bench(low, {"what": "break", "start_ms": 50}, {**low, "start_ms": 300})
    assert bench.heard() == [(0, Break(100)), (300, Break(100))]
    unplugged = Bench({"what": "unplugged"}, {"what": "break", "start_ms": 50})
    assert unplugged.heard() == [(0, OFF)]


def test_a_break_does_not_overtake_bytes_that_are_late() -> None:
    bench = Bench({"what": "delay", "delay_ms": 50})
    bench.send(HELLO)
    bench.send(Break(10))
    assert bench.heard() == [(55, HELLO), (55, Break(10))]


def test_every_application_is_in_the_trace_and_counted() -> None:
    bench = Bench({"what": "drop", "nth": 2, "count": 1})
    for at_ms in (0, 100, 200):
        bench.send(HELLO, at_ms)
    assert [ms for ms, _ in bench.heard()] == [5, 205]
    notes = [each for each in bench.trace if isinstance(each.message, FaultNote)]
    assert [(each.time_ns // MS, each.sender, codec.show(each.message)) for each in notes] == [
        (105, "plc", "fault 1: 5 bytes lost")
    ]
    assert codec.decode(codec.encode(notes[0].message)) == notes[0].message
    assert bench.model.all_faults(LATER)[1] == {
        "what": "drop", "nth": 2, "count": 1, "state": "over", "applied": 1,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("fault", "wrong"),
    [
        ({"what": "drop", "end": "plcc"}, "the line has no end 'plcc'\n.*plc"),
        ({"what": "replace"}, "either data or xor"),
        ({"what": "break", "duration_ms": 5}, "length_ms instead"),
        ({"what": "late"}, "there is no fault 'late'"),
    ],
    ids=str,
)
def test_what_is_no_fault_of_a_line_is_refused(fault: dict[str, Any], wrong: str) -> None:
    with pytest.raises(ValueError, match=wrong):
        Bench().model.add_fault(0, fault)
