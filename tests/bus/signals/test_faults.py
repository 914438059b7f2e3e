"""Each fault of wires: what the receivers of a wire get while it is on, and when it is over."""

from random import Random
from typing import Any

import pytest

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import MS, S
from fieldrig.faults.disturbed import medium_of
from fieldrig.faults.note import FaultNote
from fieldrig_bus.signals import traced
from fieldrig_bus.wires import Motion, Signal, WiresSettings, WiresVirtual


class Bench:
    def __init__(self, *faults: dict[str, Any], seed: int = 1) -> None:
        bus = WiresVirtual("wires", WiresSettings.model_validate({"faults": list(faults)}))
        self.model: BusModel[Signal] = medium_of(bus)
        self.model.begin(0, Random(f"{seed}/wires"))
        for member, interest in (("plant", []), ("io", ["level", "switch", "other"])):
            self.model.join(member)
            self.model.listen(0, member, interest)
        self.trace: list[Delivery[Any]] = []

    def drive(self, at_ms: int, name: str, value: bool | float, unit: str = "") -> None:
        self.run(at_ms)
        self.model.submit(at_ms * MS, "plant", Signal(name, value, unit))
        self.run(at_ms)

    def run(self, until_ms: int) -> None:
        while (next_ns := self.model.next_ns()) is not None and next_ns <= until_ms * MS:
            self.trace += self.model.collect(next_ns)

    def got(self, name: str) -> list[tuple[float, Any]]:
        """The milliseconds and values that the receiver of a wire has got."""
        return [
            (each.time_ns / MS, each.message.value)
            for each in self.trace
            if "io" in each.receivers and each.message.name == name
        ]


def test_a_stuck_wire_keeps_its_value_until_the_fault_ends() -> None:
    bench = Bench()
    bench.drive(0, "level", 1.0, "m")
    bench.model.add_fault(10 * MS, {"what": "stuck", "wire": "level", "duration_ms": 100})
    bench.drive(50, "level", 2.0, "m")
    bench.run(200)
    assert bench.got("level") == [(0, 1.0), (10, 1.0), (50, 1.0), (110, 2.0)]
    assert bench.trace[-1].message == Signal("level", 2.0, "m")


@pytest.mark.parametrize(
    ("fault", "wrong"),
    [
        ({"what": "stuck", "wire": "levle"}, "wire: nothing drives or reads the wire 'levle'\ndid you mean level?"),
        ({"what": "drop_out", "wire": "motr"}, "did you mean motor?"),  # nothing reads it by name
        ({"what": "swapped", "wire": "level", "other": "swich"}, "other: .*\ndid you mean switch?"),
    ],
)
def test_a_wire_that_is_probably_mistyped_is_refused(fault: dict[str, Any], wrong: str) -> None:
    bench = Bench()
    bench.drive(0, "motor", True)
    with pytest.raises(ValueError, match=wrong.replace("?", "[?]")):
        bench.model.add_fault(10 * MS, fault)
    assert bench.model.add_fault(10 * MS, {"what": "stuck", "wire": "other.level"}) == 1, "one that may come"


@pytest.mark.parametrize(
    ("fault", "during"),
    [
        ({"what": "stuck", "value": 7.5}, 7.5),
        ({"what": "stuck", "value": "7.5"}, 7.5),
        ({"what": "offset", "offset": 0.5}, 2.5),
        ({"what": "offset", "offset": 1, "factor": -2}, -3.0),
        ({"what": "drop_out"}, 0),
    ],
    ids=str,
)
def test_an_analog_value_is_wrong_from_begin_to_end(fault: dict[str, Any], during: float) -> None:
    bench = Bench()
    bench.drive(0, "level", 2.0, "m")
    number = bench.model.add_fault(5 * MS, {"wire": "level", **fault})
    bench.run(10)
    bench.model.clear_fault(20 * MS, number)
    bench.run(30)
    assert bench.got("level") == [(0, 2.0), (5, during), (20, 2.0)]


def test_a_moving_value_with_an_offset_keeps_moving() -> None:
    bench = Bench({"what": "offset", "wire": "level", "offset": 10})
    bench.model.submit(0, "plant", Motion("level", 1, "count", 0, 5.0))
    bench.run(1)
    moving = bench.trace[-1].message
    assert (moving.at(2 * S), moving.speed_at(0)) == (21.0, 5.0)


def test_a_receiver_that_listens_later_gets_the_wrong_value_too() -> None:
    bench = Bench({"what": "stuck", "wire": "level", "value": 3})
    bench.drive(0, "level", 1.0)
    bench.model.join("late")
    bench.model.listen(5 * MS, "late", ["level"])
    bench.run(5)
    assert [each.message.value for each in bench.trace if "late" in each.receivers] == [3]


def test_noise_is_there_without_a_new_value_and_the_same_in_every_run() -> None:
    def run(seed: int) -> list[tuple[float, Any]]:
        bench = Bench({"what": "noise", "wire": "level", "amplitude": 0.1, "period_ms": 10}, seed=seed)
        bench.drive(0, "level", 5.0)
        bench.run(100)
        return bench.got("level")

    values = [value for _, value in run(1)]
    assert run(1) == run(1) != run(2)
    assert len(set(values)) == len(values) == 11  # when it is driven, and ten times after it
    assert all(abs(value - 5.0) <= 0.1 for value in values)


def test_a_contact_bounces_after_each_change_only() -> None:
    bench = Bench({"what": "bounce", "wire": "switch", "length_ms": 4, "pulses": 2})
    for at_ms, value in ((0, False), (10, True), (20, True), (30, False)):
        bench.drive(at_ms, "switch", value)
    bench.run(100)
    rising = [(10, True), (11, False), (12, True), (13, False), (14, True)]
    falling = [(30, False), (31, True), (32, False), (33, True), (34, False)]
    assert bench.got("switch") == [(0, False), *rising, (20, True), *falling]


def test_swapped_wires_carry_the_value_of_each_other() -> None:
    bench = Bench()
    bench.drive(0, "switch", True)
    bench.drive(0, "other", False)
    number = bench.model.add_fault(10 * MS, {"what": "swapped", "wire": "switch", "other": "other"})
    bench.run(10)
    assert (bench.got("switch")[-1], bench.got("other")[-1]) == ((10, False), (10, True))
    bench.model.clear_fault(20 * MS, number)
    bench.run(20)
    assert (bench.got("switch")[-1], bench.got("other")[-1]) == ((20, True), (20, False))


def test_the_fault_is_in_the_trace_and_counted() -> None:
    bench = Bench({"what": "drop_out", "wire": "switch"})
    bench.drive(3, "switch", True)
    note = next(each.message for each in bench.trace if isinstance(each.message, FaultNote))
    assert traced.show(traced.decode(traced.encode(note))) == "fault 1: dropped out"
    assert WiresVirtual.standing_of(note) is None
    assert bench.model.all_faults(3 * MS)[1]["applied"] == 1


@pytest.mark.parametrize(
    ("fault", "wrong"),
    [
        ({"what": "offset", "wire": "level"}, "offset, factor or both"),
        ({"what": "swapped", "wire": "a", "other": "a"}, "is the wire itself"),
        ({"what": "stuck"}, "wire: "),
        ({"what": "noise", "wire": "level", "amplitude": "nan"}, "amplitude: "),
    ],
    ids=str,
)
def test_what_is_no_fault_of_a_wire_is_refused(fault: dict[str, Any], wrong: str) -> None:
    with pytest.raises(ValueError, match=wrong):
        Bench().model.add_fault(0, fault)
