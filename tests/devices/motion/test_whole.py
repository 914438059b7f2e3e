"""A profile in whole units ends exactly where it should, and runs on without drift."""

from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import S
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.whole import at_rest, to_position, to_speed

TURN = 1 << 32
LIMITS = Limits(50.0 * TURN, 1000.0 * TURN, 500.0 * TURN)
places = st.integers(-(1 << 45), 1 << 45)
speeds = st.integers(-50 * TURN, 50 * TURN)


@given(places, speeds, places)
def test_a_move_ends_exactly_at_its_target(start: int, speed: int, target: int) -> None:
    motion = to_position(7, start, float(speed), target, LIMITS)
    assert motion.at(7) == start
    assert motion.at(motion.done_ns) == motion.at(motion.done_ns + 10**15) == target
    assert abs(motion.at(motion.done_ns - 1) - target) <= 2000  # RU in the last nanosecond, and rounding


@given(places, speeds, speeds, st.integers(0, 10**8))
def test_a_run_never_drifts(start: int, speed: int, wanted: int, seconds: int) -> None:
    motion = to_speed(0, start, float(speed), wanted, LIMITS)
    done_ns = motion.done_ns
    assert motion.speed_at(done_ns) == wanted
    assert motion.at(done_ns + seconds * S) - motion.at(done_ns) == wanted * seconds


@given(places, speeds, places)
def test_every_change_of_acceleration_comes_once(start: int, speed: int, target: int) -> None:
    motion = to_position(0, start, float(speed), target, LIMITS)
    now_ns, changes = 0, 0
    while now_ns < motion.done_ns:
        before, now_ns = now_ns, motion.next_change_ns(now_ns)
        assert now_ns > before
        changes += 1
    assert changes <= 8  # at most 4 phases, and the nanoseconds in which they are rounded


def test_other_names_move_nothing() -> None:
    motion = to_position(0, 0, 0.0, TURN, LIMITS)
    speed, place = motion.speed_at(10**7), motion.at(10**7)
    motion.shift(-3)
    assert (motion.speed_at(10**7), motion.at(10**7), motion.at(S)) == (speed, place - 3, TURN - 3)
    assert at_rest(5).at(0) == at_rest(5).at(S) == 5
