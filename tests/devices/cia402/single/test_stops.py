"""Stops of a drive with inertia by each option code of CiA 402-2: power is kept until the axis stands.

6085h and 60C6h are what the profile may do, and the torque is what the motor can do: with the largest 60C6h the set
value is 0 in a cycle, and the motor follows later.
"""

import pytest
from single_drive_bench import SingleDriveBench

PV = 3
STATE = 0x6F
QUICK_STOP_ACTIVE, SWITCH_ON_DISABLED = 0x07, 0x40
THRESHOLD = 10_000
"""The speed of 606Fh: an axis that is slower stands."""
FAULT_REACTION, FAULT = 0x0F, 0x08


def turning() -> SingleDriveBench:
    """A drive at two turns per second."""
    bench = SingleDriveBench()
    bench.put(0x6083, 20_000_000).put(0x6084, 2_000_000).put(0x6085, 10_000_000).enabled(PV)
    bench.put(0x60FF, 2_000_000).after(500)
    assert bench.get(0x606C) == pytest.approx(2_000_000, rel=0.01)
    return bench


def speed_after(bench: SingleDriveBench, mask: int, state: int) -> int:
    """The speed when a state is left, which is soon."""
    assert bench.status(mask) == state
    bench.until(lambda: bench.status(mask) != state, within_ms=2_000)
    return abs(bench.get(0x606C))


@pytest.mark.parametrize("code", [1, 2, 3, 4])
def test_a_quick_stop_keeps_the_power_until_the_axis_stands(code: int) -> None:
    bench = turning()
    bench.put(0x605A, code).control(0x02)
    assert speed_after(bench, STATE, QUICK_STOP_ACTIVE) <= THRESHOLD
    assert bench.status(STATE) == SWITCH_ON_DISABLED


@pytest.mark.parametrize("code", [1, 2, 3, 4])
def test_a_fault_reaction_keeps_the_power_until_the_axis_stands(code: int) -> None:
    bench = turning()
    bench.put(0x605E, code)
    bench.drive.add_fault({"what": "error", "code": 0x5441})
    bench.after(2)
    assert speed_after(bench, 0x4F, FAULT_REACTION) <= THRESHOLD
    assert bench.status(0x4F) == FAULT


def test_a_load_that_goes_on_turning_the_axis_does_not_keep_the_drive_from_its_fault() -> None:
    bench = turning()
    bench.put(0x605E, 2).put(0x6072, 100).wire("axis.load_torque", -1.0)
    bench.drive.add_fault({"what": "error", "code": 0x5441})
    bench.until(lambda: bench.status(0x4F) == FAULT, within_ms=2_000)
    assert bench.get(0x606C) > 10 * THRESHOLD


@pytest.mark.parametrize(("limit", "value"), [(0x607F, 1_000_000), (0x6080, 60)], ids=["607Fh", "6080h"])
def test_a_limit_of_the_speed_acts_on_an_axis_that_turns(limit: int, value: int) -> None:
    """CiA 402-2, profile velocity mode: the limit function is in front of the ramps, for as long as the mode acts."""
    bench = turning()
    free = bench.get(limit)
    bench.put(limit, value).after(1_000)
    assert bench.get(0x606C) == pytest.approx(1_000_000, rel=0.01)
    assert bench.status(0x0800) == 0x0800
    bench.put(limit, free).after(1_000)
    assert bench.get(0x606C) == pytest.approx(2_000_000, rel=0.01)
    assert bench.status(0x0800) == 0


def test_a_limit_that_is_written_in_a_halt_acts_behind_it() -> None:
    bench = turning()
    bench.control(0x010F).after(1_500)
    bench.put(0x6080, 60).after(100)
    assert abs(bench.get(0x606C)) <= THRESHOLD
    bench.control(0x000F).after(1_000)
    assert bench.get(0x606C) == pytest.approx(1_000_000, rel=0.01)


@pytest.mark.parametrize(
    ("limit", "mode", "target"), [(0x6072, PV, 0x60FF), (0x6073, PV, 0x60FF), (0x6072, 10, 0x6071)]
)
def test_a_limit_of_0_leaves_no_torque_until_another_one_is_written(limit: int, mode: int, target: int) -> None:
    """CiA 402-2, 6072h: the maximum permissible torque; a 0 of a master is no torque, and not the default."""
    bench = SingleDriveBench().put(0x6065, 0xFFFF_FFFF)
    bench.put(limit, 0).enabled(mode).put(target, 500).after(200)
    assert (bench.get(0x6077), bench.get(0x606C)) == (0, 0)
    bench.put(limit, 1_000).after(500)
    assert bench.get(0x606C) > 0


@pytest.mark.parametrize(("act", "to_0_ms"), [(0x02, 100), (0x06, 333), (0x07, 333), (0x17F, 333)])
def test_the_demand_of_velocity_mode_follows_the_ramp_of_a_stop(act: int, to_0_ms: int) -> None:
    """6043h is the output of the ramp function: 300 min-1 by 3000 (604Ah) and 900 (6049h) min-1 in a second."""
    bench = SingleDriveBench().put(0x6049, 900, 1).put(0x6049, 1, 2).put(0x604A, 3_000, 1).put(0x604A, 1, 2)
    bench.put(0x605A, 6).put(0x605B, 1).enabled(2).control(0x7F).put(0x6042, 300).after(2_000)
    bench.control(act).after(to_0_ms // 2)
    assert bench.get(0x6043) == pytest.approx(150, abs=10)
    assert bench.until(lambda: bench.get(0x6043) == 0) == pytest.approx(to_0_ms / 2, abs=3)
