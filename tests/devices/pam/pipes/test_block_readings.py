"""Blocks of pipes where the manual can be read in two ways: each reading does what it says."""

from itertools import pairwise

import pytest

from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.pam.pipes.amplifier import Amplifier
from fieldrig_devices.pam.pipes.comparator import Comparator, Readings
from fieldrig_devices.pam.pipes.corrector import Corrector, Settings
from fieldrig_devices.pam.pipes.multi_comparator import Reference, Trace
from fieldrig_devices.pam.pipes.pmp_generator import PmpGenerator, PmpLimits
from fieldrig_devices.pam.pipes.shapes import shape_of
from fieldrig_devices.pam.pipes.tmp_generator import TmpGenerator

MS = 0.001


@pytest.mark.parametrize(("limits_output", "gain", "periods"), [(False, 2, 10), (True, 2, 20), (True, 0, 1)])
def test_the_slope_is_that_of_the_offset_or_of_the_output(limits_output: bool, gain: float, periods: int) -> None:
    block = Amplifier(gain, 0, offset_slope=100, limits_output=limits_output)
    block.start(MS)
    block.pass_on(7)
    block.set_offset(1)
    outputs = [block.pass_on(7)]
    while not block.ready:
        outputs.append(block.pass_on(7))
    assert len(outputs) == periods
    assert outputs[-1] == gain * 8
    steps = [after - before for before, after in pairwise(outputs)]
    assert steps == pytest.approx([100 * MS * (1 if limits_output else gain)] * (periods - 1))


@pytest.mark.parametrize("starts", [False, True])
def test_the_first_value_of_a_comparator_is_an_edge_or_none(starts: bool) -> None:
    block = Comparator(180, readings=Readings(starts_at_activation=starts))
    started: list[str] = []
    block.routine = lambda: started.append("up")
    block.start(MS)
    block.pass_on(200)
    assert block.ready
    assert started == ["up"] * starts


@pytest.mark.parametrize("forward_only", [False, True])
def test_a_limit_of_the_period_counts_in_both_directions_or_forward_only(forward_only: bool) -> None:
    block = Comparator(326, is_through_zero=True, readings=Readings(forward_only=forward_only))
    block.period = 500
    block.start(MS)
    seen = []
    for value in (20, 490, 480, 10, 330):
        block.pass_on(value)
        seen.append(block.ready)
    assert seen == [False, not forward_only, not forward_only, False, True]


@pytest.mark.parametrize("rearms", [False, True])
def test_a_comparator_through_zero_waits_for_the_limit_once_or_each_time(rearms: bool) -> None:
    block = Comparator(326, is_through_zero=True, readings=Readings(rearms=rearms))
    block.period = 500
    started: list[float] = []
    block.routine = lambda: started.append(value)
    block.start(MS)
    for value in (490, 10, 200, 330, 300, 340, 490, 20, 200, 350):
        block.pass_on(value)
    assert started == ([330, 350] if rearms else [330, 340, 350])


@pytest.mark.parametrize("is_ended", [False, True])
def test_trigger_off_lets_a_correction_complete_or_brakes_it(is_ended: bool) -> None:
    settings = Settings(is_immediate=True, is_output=True, is_repetitive=True, is_ended_by_trigger_off=is_ended)
    block = Corrector(settings, slope=1000, level=100, delay_s=0)
    block.start(MS)
    block.pass_on(0)
    block.trigger(20)
    block.event()
    before = [block.pass_on(0) for _ in range(100)]  # 5 units, to the speed of 100 u/s
    assert before[-1] == pytest.approx(5)
    block.trigger_off()
    flow = before[-1:]
    while not block.ready:
        flow.append(block.pass_on(0))
    assert block.state == "standby"
    assert flow[-1] == pytest.approx(10 if is_ended else 20)  # 5 units more to brake from 100 u/s
    assert block.pass_on(0) == flow[-1]
    steps = [after - before for before, after in pairwise(flow)]
    assert max(steps) <= 100 * MS * (1 + 1e-9)
    assert min(steps) >= 0


@pytest.mark.parametrize(("learns_by_reference", "time"), [(False, None), (True, 0.2)])
def test_learned_times_belong_to_the_order_or_to_the_reference(learns_by_reference: bool, time: float | None) -> None:
    first, second = Reference("POSITIVE", "IMMEDIATE", 10), Reference("POSITIVE", "IMMEDIATE", 20)
    trace = Trace(learns_by_reference=learns_by_reference)
    for reference, elapsed_s in ((first, 0.1), (second, 0.2)):
        trace.install(reference, 0, None)
        trace.fire(elapsed_s)
    trace.begin()
    trace.install(second, 0, None)
    assert trace.time_of(second) == time
    trace.begin()
    trace.install(first, 0, None)
    assert trace.time_of(first) == 0.1


def after(generator: TmpGenerator | PmpGenerator, periods: int) -> tuple[bool, float]:
    """Return `ready` and the speed of a generator after some periods."""
    for _ in range(periods):
        generator.step()
    return generator.ready, round(generator.speed, 6)


@pytest.mark.parametrize("is_ready", [False, True])
@pytest.mark.parametrize(
    "generator",
    [TmpGenerator(Limits(60, 3000, 3000), 0, None), PmpGenerator(PmpLimits(60, 60, 3000, 1e6), 0, None)],
    ids=["TMP", "PMP"],
)
def test_a_run_is_ready_at_its_speed_or_when_it_ends(generator: TmpGenerator | PmpGenerator, is_ready: bool) -> None:
    generator.run_is_ready_at_speed = is_ready
    generator.start(MS)
    generator.run(30)
    assert after(generator, 1)[0] is False
    assert after(generator, 100) == (is_ready, 30)
    generator.run(0)
    assert after(generator, 1)[0] is False
    assert after(generator, 100) == (True, 0)


@pytest.mark.parametrize("at", [0.05, 0.2, 0.4, 0.65])
@pytest.mark.parametrize("supersedes", [False, True])
def test_a_command_to_a_moving_pmp_is_ignored_or_replaces_the_motion(supersedes: bool, at: float) -> None:
    """The move of 4500 units takes 0.8 s; the command comes on either ramp or between them."""
    generator = PmpGenerator(PmpLimits(9000, 4500, 45000, 450000), 0, None)
    generator.supersedes = supersedes
    generator.start(MS)
    generator.relative_move(4500)
    flow = [generator.step() for _ in range(round(at / MS))]
    generator.absolute_move(100)
    while not generator.ready:
        flow.append(generator.step())
    assert flow[-1] == pytest.approx(100 if supersedes else 4500)
    speeds = [(after - before) / MS for before, after in pairwise(flow)]
    accelerations = [(after - before) / MS for before, after in pairwise(speeds)]
    assert max(map(abs, speeds)) <= 9000 * (1 + 1e-6)
    assert max(map(abs, accelerations)) <= 45000 * (1 + 1e-6)
    jerks = [(after - before) / MS for before, after in pairwise(accelerations)]
    assert max(map(abs, jerks)) <= 450000 * (1 + 1e-3)


@pytest.mark.parametrize("is_periodic", [False, True])
def test_a_closed_cam_is_natural_or_periodic(is_periodic: bool) -> None:
    shape = shape_of(b"0 0\n0.2 0.5\n0.5 1\n0.7 0.4\n1 0\n", closed_is_periodic=is_periodic)
    begin, end = (shape(1e-6) - shape(0)) / 1e-6, (shape(1) - shape(1 - 1e-6)) / 1e-6
    assert (begin == pytest.approx(end, abs=1e-3)) is is_periodic
