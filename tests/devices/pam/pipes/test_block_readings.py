"""Blocks of pipes where the manual can be read in two ways: each reading does what it says."""

from itertools import pairwise

import pytest

from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.pam.pipes.corrector import Corrector, Settings
from fieldrig_devices.pam.pipes.pmp_generator import PmpGenerator, PmpLimits
from fieldrig_devices.pam.pipes.tmp_generator import TmpGenerator

MS = 0.001


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
