"""The position loop of a controlled axis, on a motor with its load: manual 2, 3.2 (@ParX[3], [10] to [16]), 4.0."""

import pytest
from arp_axes import AxesBench, Motor

from fieldrig_devices.arp.motion.flags import AxisFlag

GAINS = ((1, 10, 0.001), (1, 11, 2.0), (1, 12, 5.0), (1, 13, 0.05))
LIMITS = ((1, 7, 500.0), (1, 8, 2000.0))


def held(*parameters: tuple[int, int, float]) -> AxesBench:
    """Axis 1 controlled, its encoder at rest at count 0, proportional gain 1 V/unit."""
    bench = AxesBench((1, 4, 2.0), (1, 11, 1.0), *parameters)
    bench.counts[1] = 0
    return bench.loop()


def driven(*parameters: tuple[int, int, float]) -> AxesBench:
    """Axis 1 with a motor of 2500 unit/s2 per volt; a unit is 4 counts."""
    bench = AxesBench((1, 4, 2.0), (1, 1, 4.0), *GAINS, *LIMITS, *parameters)
    bench.motors[1] = Motor(10_000.0, friction=2.0)
    return bench.loop()


@pytest.mark.manual("ARP-002", "ARP-028")
def test_card_moves_a_motor_to_the_target_by_its_torque_alone() -> None:
    bench = driven((1, 14, 20.0))
    bench.axes.move_to(1, 300_000)
    most = 0.0
    while bench.loop().F[263]:
        most = max(most, abs(bench.axes.tracking_error(1) / 1000))
    assert 0 < most < 5.0  # it follows throughout
    bench.until_flag(1, AxisFlag.ARRIVED)
    bench.loop(1000)
    assert bench.motors[1].position / 4 == pytest.approx(300.0, abs=0.3)
    assert bench.errors.error == 0


@pytest.mark.manual("ARP-002")
def test_motor_that_is_pushed_is_brought_back() -> None:
    bench = driven()
    bench.motors[1].position += 40.0
    bench.loop()
    volts = bench.axes.volts(1)
    assert volts is not None
    assert volts < 0
    bench.loop(2000)
    assert bench.motors[1].position == pytest.approx(0.0, abs=1.0)


@pytest.mark.manual("ARP-027")
def test_each_gain_has_its_share_in_the_reference() -> None:
    """Digest 12: FF x speed reference + KP e + KI sum(e) T + KD de/T."""
    bench = held((1, 10, 0.01), (1, 11, 0.5), (1, 12, 2.0), (1, 13, 0.001), (1, 7, 100.0), (1, 8, 100_000.0))
    bench.axes.move_at(1, 100_000)
    error = total = 0.0
    for loop in range(1, 11):
        bench.loop()
        position = 0.05 + 0.1 * (loop - 1)  # full speed after 1 ms
        total += position * 0.001
        expected = 0.01 * 100 + 0.5 * position + 2.0 * total + 0.001 * (position - error) / 0.001
        error = position
        assert bench.axes.volts(1) == pytest.approx(expected)


@pytest.mark.manual("ARP-027")
def test_reference_is_clamped_and_the_sum_waits_meanwhile() -> None:
    bench = held((1, 12, 10.0))
    bench.counts[1] = -100
    bench.loop(1000)
    assert bench.axes.volts(1) == 10.0
    bench.counts[1] = 100
    bench.loop()
    assert bench.axes.volts(1) == -10.0
    bench.counts[1] = 0
    assert bench.loop().axes.volts(1) == pytest.approx(0.0, abs=2.0)  # 100 unit s would be 1000 V


@pytest.mark.manual("ARP-027")
@pytest.mark.parametrize(("lag", "expected"), [(0.01, 0.06), (-0.01, -0.01 - 5000 * 0.01 * 0.101)])
def test_sum_waits_at_the_limit_only_for_an_error_that_drives_it_further_out(lag: float, expected: float) -> None:
    """FF alone demands 20 V.  An error of 0.01 unit for 100 samples of 1 ms would add 5 V to the integrator."""
    bench = held((1, 1, 1000.0), (1, 10, 0.2), (1, 12, 5000.0), (1, 7, 100.0), (1, 8, 100_000.0))
    bench.axes.move_at(1, 100_000)
    for loop in range(100):
        bench.counts[1] = round((0.05 + 0.1 * loop - lag) * 1000)
        assert bench.loop().axes.volts(1) == 10.0
    bench.set(1, 10, 0.0)
    bench.counts[1] = (bench.counts[1] or 0) + 100
    assert bench.loop().axes.volts(1) == pytest.approx(expected)


@pytest.mark.manual("ARP-021")
@pytest.mark.parametrize(("signs", "volts"), [(0, -2.0), (1, 2.0), (2, 2.0), (3, -2.0)])
def test_sign_mode_reverses_encoder_and_output(signs: int, volts: float) -> None:
    bench = held((1, 3, signs))
    bench.counts[1] = 2
    assert bench.loop().axes.volts(1) == pytest.approx(volts)


@pytest.mark.manual("ARP-028")
def test_blocked_motor_is_a_loss_of_control_and_the_program_goes_on() -> None:
    """A24."""
    bench = driven((1, 14, 10.0))
    bench.until_flag(1, AxisFlag.ARRIVED)
    bench.motors[1].is_blocked = True
    bench.load("BEG MAIN\nPAC 1, 300\nL: V2 += 1\nV1 == ERROR\nGOTO L\nEND")
    bench.until(lambda: bench.V[1])
    assert bench.V[1] == 116_000
    assert (bench.errors.error, bench.errors.error_axis) == (116, 1)
    assert bench.axes.volts(1) == 0.0
    frozen = bench.F[260], bench.F[264]
    count = bench.V[2]
    bench.loop(500)
    assert (bench.F[260], bench.F[264]) == frozen == (0, 0)
    assert bench.F[263] == 0
    assert bench.V[2] > count
    assert bench.axes.volts(1) == 0.0
    bench.axes.move_to(1, 0)
    assert bench.F[263] == 0  # nothing moves it
    bench.counts[1] = 77
    bench.motors.clear()
    assert bench.loop().reading(1) == 77 / 4  # but it is read


@pytest.mark.manual("ARP-028", "ARP-049")
def test_only_a_cycle_of_enable_brings_lost_control_back() -> None:
    bench = held((1, 14, 5.0))
    bench.counts[1] = 6
    assert bench.loop().errors.error == 116
    for kind in (1.0, 2.0):  # another kind of axis takes control, but not of a lost axis
        bench.set(1, 4, kind)
        bench.axes.move_by(1, 1_000)
        assert bench.loop().F[263] == 0
    bench.counts[1] = 7
    assert bench.loop().axes.volts(1) == 0.0
    bench.axes.release()
    bench.axes.engage()
    bench.counts[1] = 8
    assert bench.loop().axes.volts(1) == pytest.approx(-1.0)


@pytest.mark.manual("ARP-028")
def test_other_axis_keeps_its_control() -> None:
    bench = held((2, 4, 2.0), (1, 14, 5.0))
    bench.counts[2] = 0
    bench.loop()
    bench.counts[1] = 6
    bench.counts[2] = 2
    bench.loop()
    assert bench.errors.error == 116
    assert bench.axes.volts(1) == 0.0
    assert bench.axes.volts(2) == pytest.approx(-2.0)
    bench.axes.engage()
    bench.counts[1] = 7
    assert bench.loop().axes.volts(1) == pytest.approx(-1.0)


@pytest.mark.manual("ARP-028")
def test_error_at_its_maximum_is_still_allowed() -> None:
    bench = held((1, 14, 5.0))
    bench.counts[1] = 5
    assert bench.loop().errors.error == 0
    bench.counts[1] = 6
    assert bench.loop().errors.error == 116


@pytest.mark.manual("ARP-029")
def test_arrival_waits_until_the_error_stays_in_the_window() -> None:
    bench = held((1, 15, 0.010), (1, 16, 2.0))
    bench.until_flag(1, AxisFlag.ARRIVED)
    bench.axes.move_by(1, 3_000)
    bench.until_flag(1, AxisFlag.RUNNING, 0)
    assert bench.loop(100).F[260] == 0  # 3 units short of the target
    bench.counts[1] = 1
    bench.loop(9)
    bench.counts[1] = 0
    bench.loop()  # the window is left too early
    bench.counts[1] = 1
    assert bench.until_flag(1, AxisFlag.ARRIVED) == 11
    bench.counts[1] = 9
    assert bench.loop(5).F[260] == 1  # until the next move begins


def test_error_is_the_same_across_the_wrap() -> None:
    bench = held((1, 5, 100.0), (1, 6, 0.0), (1, 7, 1000.0))
    bench.axes.move_by(1, 105_000)
    for position in range(103):
        bench.counts[1] = position
        bench.loop()
    bench.until_flag(1, AxisFlag.RUNNING, 0)
    assert bench.position(1) == 5.0
    assert bench.reading(1) == 2.0
    assert bench.axes.tracking_error(1) == 3_000
    bench.counts[1] = 98
    assert bench.loop().axes.tracking_error(1) == 7_000


@pytest.mark.manual("ARP-055")
def test_preset_keeps_the_tracking_error() -> None:
    bench = held((1, 5, 100.0), (1, 6, 0.0))
    bench.counts[1] = 3
    bench.loop()
    bench.axes.preset_position(1, 98_000)
    volts = bench.axes.volts(1)
    assert bench.loop().axes.tracking_error(1) == -3_000
    assert bench.axes.volts(1) == volts
    assert bench.position(1) == 98.0
    assert bench.reading(1) == pytest.approx(1.0)


def test_encoder_heard_of_late_is_no_jump() -> None:
    bench = AxesBench((1, 4, 2.0), (1, 14, 5.0))
    bench.loop(10)
    bench.counts[1] = 5000
    assert bench.loop().axes.volts(1) == 0.0
    assert [bench.axes.diagnostic(1, code) for code in (3, 9)] == [0, 0]  # nor a speed
    assert bench.errors.error == 0
    assert bench.axes.position(1) == 5_000_000


@pytest.mark.manual("ARP-027")
def test_sum_begins_at_0_with_each_time_under_control() -> None:
    bench = held((1, 12, 10.0))
    bench.counts[1] = -1
    bench.loop(500)
    assert bench.axes.volts(1) == pytest.approx(1.0 + 5.0)
    bench.axes.release()
    bench.axes.engage()
    assert bench.loop().axes.volts(1) == 0.0


def test_output_is_0_without_control_and_free_on_other_kinds() -> None:
    bench = held()
    bench.counts[1] = 4
    bench.loop()
    bench.axes.release()
    assert bench.axes.volts(1) == 0.0
    bench.counts[1] = 60
    assert bench.loop().axes.volts(1) == 0.0
    assert bench.axes.position(1) == 60_000  # reading continues
    bench.axes.engage()
    assert bench.loop().axes.volts(1) == 0.0
    bench.set(1, 4, 3.0)
    assert bench.axes.volts(1) is None
