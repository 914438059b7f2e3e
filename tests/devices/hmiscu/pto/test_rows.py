"""Rows of the manual by what is seen from outside, with figures that are worked out by hand."""

import pytest
from hmiscu_bench import PtoBench
from hmiscu_device_bench import PTO, DeviceBench
from pydantic import ValidationError

from fieldrig.clock import MS
from fieldrig_devices.hmiscu.pto.status import MotionState
from fieldrig_devices.hmiscu.settings import HmiscuSettings


def reached_ms(bench: PtoBench) -> float:
    """Return how long it takes until a velocity is reached, in ms."""
    began_ns = bench.now_ns
    bench.until(lambda: bench.velocity.outputs["InVelocity"])
    return (bench.now_ns - began_ns) / MS


@pytest.mark.manual("SCU-002")
def test_a_pulse_output_is_channel_0_only_and_takes_both_fast_outputs() -> None:
    with pytest.raises(ValidationError):
        HmiscuSettings.model_validate({"channel_1": {"mode": "pto"}})
    points = DeviceBench(channel_0=PTO).device.points()
    assert "FQ0" not in points
    assert "FQ1" not in points
    assert {"FQ0", "FQ1"} <= DeviceBench().device.points().keys()


@pytest.mark.manual("SCU-020")
@pytest.mark.parametrize(("hz_per_ms", "start_hz"), [(20, 100), (15, 87), (1, 22), (50, 158)])
def test_a_start_frequency_of_0_is_the_root_of_half_the_rate(hz_per_ms: int, start_hz: int) -> None:
    """The root of 20,000 / 2 is 100, of 7,500 it is 86.6, of 500 22.4, and of 25,000 158.1."""
    bench = PtoBench(ramps="periods", ramp_unit="Hz/ms")
    bench.run(Velocity=20_000, Acceleration=hz_per_ms, Deceleration=hz_per_ms)
    assert bench.segments[0].frequency == start_hz


@pytest.mark.manual("SCU-030")
def test_drive_ready_counts_again_when_it_is_no_longer_ignored() -> None:
    bench = PtoBench(aux="drive_ready")
    bench.simple.inputs["DIS_AuxInput"] = True
    bench.cycle()
    bench.run(Velocity=1_000)
    bench.cycle(50 * MS)
    assert not bench.simple.outputs["PTOError"]
    bench.simple.inputs["DIS_AuxInput"] = False
    bench.cycle(50 * MS)
    assert bench.simple.outputs["PTOError"]


@pytest.mark.manual("SCU-031")
def test_the_outputs_of_the_axis_show_moving_stopping_frequency_and_distance() -> None:
    bench = PtoBench()
    shown = bench.simple.outputs
    bench.cycle()
    assert (shown["PTO_REF"], shown["Moving"], shown["Stopping"], shown["Frequency"]) == (1, False, False, 0)
    bench.run(Velocity=10_000, Acceleration=1_000, Deceleration=1_000)
    bench.cycle(1_500 * MS)
    assert (shown["Moving"], shown["Stopping"], shown["Frequency"]) == (True, False, 10_000)
    assert shown["Distance"] == pytest.approx(5_000 + 5_000, abs=2)
    bench.halt(Deceleration=1_000)
    bench.cycle(500 * MS)
    assert (shown["Moving"], shown["Stopping"]) == (False, True)
    assert shown["Frequency"] == pytest.approx(5_000, abs=20)
    bench.cycle(600 * MS)
    bench.release(bench.stop)
    bench.cycle(MS)
    assert (shown["Stopping"], shown["Frequency"]) == (False, 0)
    assert shown["Distance"] == pytest.approx(15_000, abs=3)


@pytest.mark.manual("SCU-061")
def test_an_invalid_parameter_aborts_everything_and_stops_fast() -> None:
    bench = PtoBench(fast_stop=200)
    bench.run(Velocity=25_000, Acceleration=500, Deceleration=500)
    bench.cycle(1_000 * MS)
    bench.release(bench.velocity)
    bench.run(Velocity=60_000)
    assert (bench.velocity.outputs["Error"], bench.velocity.outputs["ErrID"]) == (True, 3)
    bench.cycle(MS)
    assert (bench.state, bench.simple.outputs["PTOError"]) == (MotionState.ERROR_STOP, True)
    began_ns = bench.now_ns
    assert (bench.rest_ns() - began_ns) / MS == pytest.approx(100, abs=3)  # half of 50 kHz, which takes 200 ms


@pytest.mark.manual("SCU-085", "SCU-027")
def test_the_rate_is_from_the_start_frequency_to_the_target_in_the_given_time() -> None:
    bench = PtoBench(start_frequency_hz=5_000)
    bench.run(Velocity=20_000, Acceleration=10_000, Deceleration=10_000)
    bench.cycle(5_000 * MS)
    assert bench.simple.outputs["Frequency"] == pytest.approx(12_500, abs=10)
    assert reached_ms(bench) == pytest.approx(5_000, abs=4)


@pytest.mark.manual("SCU-086")
@pytest.mark.parametrize(("velocity", "half_way"), [(20_000, 15_000), (4_000, 7_000)])
def test_the_rate_in_motion_is_from_one_velocity_to_the_other_in_the_given_time(velocity: int, half_way: int) -> None:
    bench = PtoBench(start_frequency_hz=1_000)
    bench.run(Velocity=10_000, Acceleration=500, Deceleration=500)
    reached_ms(bench)
    bench.release(bench.velocity)
    bench.run(Velocity=velocity, Acceleration=2_000, Deceleration=2_000)
    bench.cycle(1_000 * MS)
    assert bench.simple.outputs["Frequency"] == pytest.approx(half_way, abs=10)
    assert reached_ms(bench) == pytest.approx(1_000, abs=4)
