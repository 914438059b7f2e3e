"""An ST1 where the manual can be read in two ways: the key `readings` selects the reading."""

from typing import Any

import pytest
from pydantic import ValidationError
from st1_bench import ProgramBench

from fieldrig_devices.pamring.axis_words import Error
from fieldrig_devices.pamring.frames import InputChanged, InputItem, Move


@pytest.mark.parametrize(
    ("trips", "fault", "is_powered"),
    [
        (["MOTOR_TEMPERATURE"], "motor_temperature", False),
        (["MOTOR_TEMPERATURE"], "overload", True),
        ([], "power_stage", False),
    ],
)
def test_the_errors_that_switch_the_power_off(trips: list[str], fault: str, is_powered: bool) -> None:
    bench = ProgramBench(readings={"trips": trips})
    bench.servo.causes.faults.add_fault({"what": fault})
    assert bench.servo.is_powered is is_powered
    bench.move(Move.POWER_ON)
    assert bench.servo.is_powered is is_powered


def test_a_lag_error_that_does_not_switch_the_power_off() -> None:
    bench = ProgramBench(readings={"trips": []})
    bench.servo.causes.faults.add_fault({"what": "jam"})
    bench.move(Move.RUN, 10.0)
    bench.wait(200)
    assert bench.report.error & Error.SERVO_LAG_ERROR
    assert bench.servo.is_powered


def test_only_errors_of_the_table_switch_the_power_off() -> None:
    with pytest.raises(ValidationError, match="CHANGE_IN_CD"):
        ProgramBench(readings={"trips": ["CHANGE_IN_CD"]})


@pytest.mark.parametrize(("reading", "before", "after"), [("refused", 0, 1 << 31), ("off", 1 << 31, 1 << 31)])
def test_an_axis_without_power_has_an_error_or_only_a_refused_order(reading: str, before: int, after: int) -> None:
    bench = ProgramBench(power=False, readings={"power_stage_disabled": reading})
    bench.program.run()
    assert bench.report.error == before
    number = bench.move(Move.RUN, 1.0)
    assert (bench.report.error, bench.report.number) == (after, number)
    bench.move(Move.POWER_ON)
    assert (bench.servo.is_powered, bench.report.error) == (True, 0)
    bench.move(Move.POWER_OFF)
    assert bench.report.error == before


@pytest.mark.parametrize("stopped", ["at_rest", "after_stop"])
def test_an_axis_is_stopped_at_rest_or_only_after_a_stop(stopped: str) -> None:
    bench = ProgramBench(readings={"stopped": stopped})
    at_rest = 32 if stopped == "at_rest" else 0
    assert bench.report.status == at_rest
    bench.move(Move.RUN, 1.0)
    bench.wait(100)
    bench.move(Move.STOP)
    assert bench.report.status == 0
    bench.wait(100)
    assert bench.report.status == 32
    bench.point(0.0)
    assert bench.report.status == 1
    bench.end()
    assert bench.report.status == at_rest
    bench.move(Move.STOP)
    assert bench.report.status == 32
    bench.move(Move.RELATIVE_MOVE, 0.1, 10.0, 1000.0, 1000.0)
    assert bench.report.status == 2
    bench.wait(1000)
    assert bench.report.status == at_rest


@pytest.mark.parametrize(("on_pam_reset", "is_powered"), [("stop_and_power_off", False), ("stop", True)])
def test_an_axis_stops_when_the_pam_begins_again(on_pam_reset: str, is_powered: bool) -> None:
    bench = ProgramBench(readings={"on_pam_reset": on_pam_reset})
    bench.move(Move.RUN, 10.0)
    bench.wait(1000)
    bench.program.forget()
    bench.wait(1000)
    assert (bench.speed, bench.servo.is_powered) == (0.0, is_powered)


def with_input(debounce: int, **readings: Any) -> ProgramBench:
    """A node that samples the input 17 every 10 ms."""
    bench = ProgramBench(power=False, readings=readings)
    assert bench.program.accept(InputItem(5, 202, 1, True, 10, debounce))
    bench.program.run()
    bench.take(InputChanged)
    return bench


@pytest.mark.parametrize(("time_stamps", "age_us"), [("IN16", 0), ("all", 27_500)])
def test_a_report_has_the_age_of_its_edge_or_none(time_stamps: str, age_us: int) -> None:
    bench = with_input(3, time_stamps=time_stamps)
    bench.wait(2.5)
    bench.program.boards.put(17, True)  # seen by the samples at 10, 20 and 30 ms
    bench.wait(30)
    assert bench.take(InputChanged) == [InputChanged(5, 1, age_us)]
