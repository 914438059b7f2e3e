"""The error word of an axis, what sets its bits, and what the servo does about it."""

from typing import Any

import pytest
from st1_bench import ProgramBench

from fieldrig_devices.pamring.axis_words import Error, Status
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.frames import AxisReport, Move, SetPointMode

# Table 12-1 and the fault that sets the bit
FAULTS = [
    (0x8000_0000, {"what": "power_stage"}),
    (0x0080_0000, {"what": "resolver"}),
    (0x0040_0000, {"what": "over_voltage"}),
    (0x0020_0000, {"what": "overload"}),
    (0x0010_0000, {"what": "supply"}),
    (0x0008_0000, {"what": "supply", "of": "auxiliary"}),
    (0x0000_0080, {"what": "motor_temperature"}),
    (0x0000_0002, {"what": "servo_reset"}),
]
LOW = 0xFFFF


@pytest.fixture
def bench() -> ProgramBench:
    return ProgramBench()


@pytest.mark.manual("PAMS-049")
@pytest.mark.parametrize(("bit", "fault"), FAULTS, ids=lambda value: str(value))
def test_a_fault_sets_its_bit_while_it_lasts(bench: ProgramBench, bit: int, fault: dict[str, Any]) -> None:
    bench.servo.causes.faults.add_fault({**fault, "duration_ms": 50})
    change = Error.CHANGE_IN_CD if bit & LOW else 0
    assert bench.report.error == bit | change
    bench.wait(100)
    bench.move(Move.UPDATE_STATUS)
    assert bench.report.error == 0


@pytest.mark.manual("PAMS-049")
@pytest.mark.parametrize(("bit", "fault"), FAULTS, ids=lambda value: str(value))
def test_a_failure_takes_the_power_away_and_a_warning_does_not(
    bench: ProgramBench, bit: int, fault: dict[str, Any]
) -> None:
    bench.move(Move.RUN, 5.0)
    bench.wait(100)
    bench.servo.causes.faults.add_fault(fault)
    assert bench.servo.is_powered is (bit == 0x80)
    if not bench.servo.is_powered:
        bench.wait(1000)  # 0.5 N m at 0.002 kg m2: from 5 turns/s to rest in 0.13 s
        assert bench.speed == 0.0
        assert bench.report.status == Status.POWER_OFF | Status.STOPPED
        bench.move(Move.POWER_ON)  # the cause is still there
        assert bench.servo.is_powered is False
        bench.servo.causes.faults.clear_fault(1)
        bench.move(Move.POWER_ON)
        bench.move(Move.UPDATE_STATUS)
        assert (bench.servo.is_powered, bench.report.error, bench.position) == (True, 0, 0.0)


@pytest.mark.manual("PAMS-049")
def test_cmasks_hides_bits_of_c_and_d() -> None:
    bench = ProgramBench(parameters={"cmasks": 0x1000})
    bench.servo.causes.faults.add_fault({"what": "motor_temperature"})
    assert bench.report.error == 0
    bench.servo.causes.faults.add_fault({"what": "resolver"})
    assert bench.report.error == Error.RESOLVER_FAILURE


@pytest.mark.manual("PAMS-049")
def test_a_shaft_that_cannot_follow_gives_a_lag_error(bench: ProgramBench) -> None:
    bench.servo.causes.faults.add_fault({"what": "jam"})
    bench.move(Move.RUN, 10.0)
    bench.wait(104)
    assert bench.report.error == Error.CHANGE_IN_CD | Error.CURRENT_LIMITED
    assert bench.lag == pytest.approx(0.99, abs=0.02)
    bench.wait(5)
    assert bench.report.error & Error.SERVO_LAG_ERROR
    assert bench.report.status == Status.POWER_OFF | Status.STOPPED
    bench.servo.causes.faults.clear_fault(1)
    bench.move(Move.POWER_ON)
    bench.move(Move.UPDATE_STATUS)
    assert bench.report.error == 0


@pytest.mark.manual("PAMS-049")
def test_a_load_within_the_torque_slows_only_what_is_too_fast(bench: ProgramBench) -> None:
    bench.servo.load(10.0)  # leaves 9.5 N m, 756 turns/s2
    bench.move(Move.RUN, 10.0, acceleration=700.0)
    bench.wait(10)
    assert (bench.lag, bench.report.error) == (0.0, 0)
    bench.move(Move.RUN, 30.0, acceleration=1000.0)
    bench.wait(15)
    assert bench.lag > 0
    assert bench.report.error & Error.CURRENT_LIMITED
    bench.wait(100)
    assert bench.lag == 0


def test_a_load_beyond_the_torque_stops_the_shaft(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 1.0)
    bench.wait(100)
    bench.servo.load(-30.0)
    bench.wait(100)
    assert bench.speed == 0.0
    assert bench.servo.is_powered
    bench.wait(2000)
    assert bench.report.error & Error.SERVO_LAG_ERROR


@pytest.mark.manual("PAML-044", "PAMS-049")
@pytest.mark.parametrize(("target", "is_out"), [(1.9, False), (2.1, True), (-0.9, False), (-1.1, True)])
def test_phil_limits_the_position(target: float, is_out: bool) -> None:
    bench = ProgramBench(parameters={"phil1": -1.0, "phil2": 2.0})
    bench.move(Move.ABSOLUTE_MOVE, target, 10.0)
    bench.cycle(1000)
    assert bool(bench.report.error & Error.OUT_OF_LIMITS) is is_out
    bench.move(Move.ABSOLUTE_MOVE, 0.0, 10.0)
    bench.cycle(1000)
    bench.move(Move.UPDATE_STATUS)
    assert bench.report.error == 0


def test_phil_limits_the_position_of_a_pipe() -> None:
    bench = ProgramBench(parameters={"phil2": 0.5})
    for cycle in range(600):
        bench.point(0.001 * cycle)
        assert bool(bench.report.error & Error.OUT_OF_LIMITS) is (cycle > 501)


@pytest.mark.manual("PAMS-108", "PAMS-049")
@pytest.mark.parametrize("fault", [RingFault.INACTIVE, RingFault.CARRIER])
def test_an_axis_stops_when_the_ring_breaks(bench: ProgramBench, fault: RingFault) -> None:
    bench.point(10.0, SetPointMode.SPEED).cycle(100)
    bench.program.ring(fault)
    assert bench.report.error == Error.COMMUNICATION_FAILURE | Error.CHANGE_IN_CD
    assert bench.servo.is_powered
    bench.wait(10)
    assert bench.speed == pytest.approx(5.0)  # ASTOP, 500 turns/s2
    bench.wait(11)
    assert (bench.speed, bench.servo.is_powered) == (0.0, False)
    bench.program.ring(RingFault.NONE)
    bench.move(Move.POWER_ON)
    bench.move(Move.UPDATE_STATUS)
    assert (bench.servo.is_powered, bench.report.error) == (True, 0)


def test_a_stop_at_a_break_may_keep_the_power() -> None:
    bench = ProgramBench(on_ring_fault="stop")
    bench.move(Move.RUN, 10.0)
    bench.wait(100)
    bench.program.ring(RingFault.INACTIVE)
    bench.wait(100)
    assert (bench.speed, bench.servo.is_powered) == (0.0, True)


@pytest.mark.manual("PAMS-108")
@pytest.mark.parametrize(("settings"), [{"firmware": 589}, {"parameters": {"cmasku": 0xEFFF}}])
def test_an_old_firmware_or_cmasku_reports_no_ring_fault(settings: dict[str, Any]) -> None:
    bench = ProgramBench(**settings)
    bench.program.ring(RingFault.INACTIVE)
    assert bench.report.error == 0


def test_damaged_frames_do_not_stop_an_axis(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 10.0)
    bench.wait(100)
    bench.program.ring(RingFault.CRC)
    bench.wait(100)
    assert bench.speed == 10.0
    assert bench.report.error & Error.COMMUNICATION_FAILURE


def test_the_pam_begins_again(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 10.0)
    bench.wait(100)
    bench.program.forget()
    bench.wait(100)
    assert (bench.speed, bench.servo.is_powered) == (0.0, False)
    bench.take(AxisReport)
    bench.wait(100)
    assert not bench.port.sent


def test_the_input_enable_disables_the_power_stage(bench: ProgramBench) -> None:
    bench.servo.switch(False)
    assert bench.report.error == Error.POWER_STAGE_DISABLED
    assert bench.servo.is_powered is False
    bench.servo.switch(True)
    bench.move(Move.POWER_ON)
    assert (bench.servo.is_powered, bench.report.error) == (True, 0)


def test_no_report_without_an_axis() -> None:
    bench = ProgramBench(power=False)
    bench.program.forget()
    bench.take(AxisReport)
    bench.program.servo.switch(False)
    assert not bench.port.sent
