"""The generators: golden numbers of the digest (section 7), and laws of every motion."""

import math
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.pam.pipes.block import wrapped
from fieldrig_devices.pam.pipes.pmp_generator import PmpGenerator, PmpLimits, forward_backward, single
from fieldrig_devices.pam.pipes.tmp_generator import TmpGenerator

MS = 0.001
EXAMPLE = PmpLimits(first_speed=9000, last_speed=4500, acceleration=45000, jerk=450000)
"""The declaration of manual lines 6088 to 6099."""


def tmp(period: float | None = None, initial: float = 0.0) -> TmpGenerator:
    found = TmpGenerator(Limits(6, 0.3, 0.6), initial, period)
    found.start(MS)
    return found


def periods_until_ready(generator: TmpGenerator | PmpGenerator, most: int = 200_000) -> int:
    for number in range(most):
        if generator.ready:
            return number
        generator.step()
    raise AssertionError("the generator does not get ready")


@pytest.mark.manual("PAML-630")
def test_tmp_moves_450_units_in_90_s() -> None:
    generator = tmp()
    generator.relative_move(450)
    reached = {}
    for number in range(1, 90_001):
        generator.step()
        if number in (20_000, 80_000, 90_000):
            reached[number] = (round(generator.position, 6), round(generator.speed, 6))
    assert reached == {20_000: (60, 6), 80_000: (420, 6), 90_000: (450, 0)}
    assert generator.ready


TARGETS = st.integers(-7200, 7200).map(lambda tenths: tenths / 10) | st.floats(-1e4, 1e4)


def pmp(period: float | None = None, initial: float = 0.0) -> PmpGenerator:
    found = PmpGenerator(EXAMPLE, initial, period)
    found.start(MS)
    return found


@pytest.mark.parametrize("make", [tmp, pmp])
@pytest.mark.parametrize("initial", [0.0, 0.1, 12.3, -7.7])
@pytest.mark.parametrize("period", [None, 360.0])
@pytest.mark.parametrize("lead_s", [0.0, MS])
@given(st.lists(TARGETS, min_size=1, max_size=4))
@settings(max_examples=25, deadline=None)
def test_a_move_ends_at_its_target_to_the_last_bit(
    make: Callable[..., TmpGenerator | PmpGenerator],
    initial: float,
    period: float | None,
    lead_s: float,
    targets: list[float],
) -> None:
    """A program's `position = 90` holds then."""
    generator = make(period, initial)
    generator.lead_s = lead_s
    for target in targets:
        generator.absolute_move(target)
        generator._periods = math.ceil(generator._ready_s / MS)  # the steps between are those of the other tests
        assert generator.ready
        assert generator.position == wrapped(target, period)
        assert generator.step() == wrapped(target, period)


def test_tmp_goes_to_90_and_on() -> None:
    generator = TmpGenerator(Limits(10, 1000, 1000), 0.0, None)
    generator.start(MS)
    for target in (90.0, 7.0, 90.0):
        generator.absolute_move(target)
        periods_until_ready(generator)
        assert (generator.position, generator.step(), generator.speed) == (target, target, 0.0)
    generator.relative_move(-90.0)
    periods_until_ready(generator)
    assert generator.position == 0.0
    generator.run(5)
    generator.step()
    generator.absolute_move(1.1)
    periods_until_ready(generator)
    assert generator.position == 1.1


def test_a_position_that_is_set_is_exact_at_rest_and_moves_the_target_on_the_way() -> None:
    generator = TmpGenerator(Limits(10, 1000, 1000), 0.1, None)
    generator.start(MS)
    generator.set_position(90.3)
    assert generator.position == 90.3
    generator.absolute_move(100.7)
    for _ in range(10):
        generator.step()
    before = generator.position
    generator.set_position(before + 100)
    periods_until_ready(generator)
    assert generator.position == pytest.approx(200.7)


@pytest.mark.manual("PAML-603")
def test_pmp_ends_exactly_where_it_turns_back_to() -> None:
    generator = pmp(initial=0.1)
    generator.absolute_move(12000.0, 8000.3)
    periods_until_ready(generator)
    assert generator.position == 8000.3


@pytest.mark.manual("PAML-631")
def test_a_new_command_of_the_tmp_supersedes_the_running_one() -> None:
    generator = tmp()
    generator.run(3)
    assert periods_until_ready(generator) == 10_000
    assert generator.speed == pytest.approx(3)
    generator.absolute_move(100)
    periods_until_ready(generator)
    assert [generator.position, generator.speed] == pytest.approx([100, 0])


@pytest.mark.manual("PAML-633")
def test_position_of_the_tmp_steps_while_active_and_waits_otherwise() -> None:
    generator = tmp(period=678, initial=30)
    assert generator.position == 30
    generator.set_position(5)
    assert generator.step() == 5
    generator.stop()
    assert generator.position == 0
    generator.set_position(700)
    generator.start(MS)
    assert generator.position == 22


@pytest.mark.manual("PAML-600")
def test_pmp_single_move_of_4500_units() -> None:
    profile = single(4500, EXAMPLE)
    assert profile.duration_s == pytest.approx(0.8)
    positions = {0.1: 75, 0.2: 525, 0.3: 1350, 0.5: 3150, 0.6: 3975, 0.7: 4425, 0.8: 4500}
    for seconds, position in positions.items():
        assert profile.at(seconds)[0] == pytest.approx(position)
    assert profile.at(0.4)[1] == pytest.approx(9000)


@pytest.mark.manual("PAML-601")
def test_pmp_forward_and_backward_does_not_stop_between() -> None:
    profile = forward_backward(4500, 2000, EXAMPLE)
    assert profile.duration_s == pytest.approx(1.350694, abs=1e-6)
    assert profile.turning_position() == pytest.approx(4500)
    assert profile.distance == pytest.approx(2500)
    assert profile.pieces[3].seconds == pytest.approx(0.202083, abs=1e-6)
    assert [round(piece.seconds, 6) for piece in profile.pieces[4:7]] == [0.1, 0.2, 0.1]


@pytest.mark.manual("PAML-603")
def test_pmp_ignores_a_command_while_it_moves() -> None:
    generator = PmpGenerator(EXAMPLE, 0.0, None)
    generator.start(MS)
    generator.absolute_move(4500)
    for _ in range(100):
        generator.step()
    generator.absolute_move(-4500)
    assert periods_until_ready(generator) in (700, 701)
    assert generator.position == pytest.approx(4500)
    generator.absolute_move(0, 2500)
    periods_until_ready(generator)
    assert generator.position == pytest.approx(2500)
    generator.relative_move(10, 10)  # the second has to go back
    assert generator.ready


NUMBERS = st.floats(0.1, 1e4)


@pytest.mark.manual("PAML-604")
@given(st.floats(0.01, 1e5), NUMBERS, NUMBERS, NUMBERS)
def test_a_pmp_move_ends_at_its_distance_within_its_limits(
    distance: float, speed: float, acceleration: float, jerk: float
) -> None:
    profile = single(distance, PmpLimits(speed, speed, acceleration, jerk))
    assert profile.distance == pytest.approx(distance, rel=1e-9)
    for part in range(101):
        position, now, force = profile.at(profile.duration_s * part / 100)
        assert -1e-6 * distance <= position <= distance * (1 + 1e-6)
        assert -1e-6 * speed <= now <= speed * (1 + 1e-6)
        assert abs(force) <= acceleration * (1 + 1e-6)


@given(st.floats(1, 1e4), st.floats(1, 1e4), NUMBERS, NUMBERS, NUMBERS)
def test_a_pmp_return_ends_at_the_sum_of_its_distances(
    forward: float, backward: float, speed: float, acceleration: float, jerk: float
) -> None:
    profile = forward_backward(forward, backward, PmpLimits(speed, speed / 2, acceleration, jerk))
    assert profile.turning_position() == pytest.approx(forward, rel=1e-6)
    assert profile.distance == pytest.approx(forward - backward, abs=1e-6 * (forward + backward))
