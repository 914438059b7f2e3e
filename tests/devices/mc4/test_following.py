"""A drive that only follows its set position, by one function for a cycle, does what it does otherwise."""

from random import Random

import pytest
from drive_line import CYCLE_NS, GEARED, TWISTING, Line, course

from fieldrig_devices.mc4.axis import Axis
from fieldrig_devices.mc4.drive import Mc4
from fieldrig_devices.mc4.feedback import Feedback


def follow_by_steps(_feedback: Feedback, _axis: Axis, *, is_told: bool) -> None:
    """There is no such function."""


@pytest.mark.parametrize(("seed", "wires"), [(1, False), (2, True), (3, False), (4, True), (5, False), (6, True)])
def test_what_drives_say_and_do_is_the_same_either_way(monkeypatch: pytest.MonkeyPatch, seed: int, wires: bool) -> None:
    loads: tuple[dict[str, float], ...] = (GEARED, {}, TWISTING)
    short = course(seed, wires, loads)
    monkeypatch.setattr(Feedback, "following", follow_by_steps)
    long = course(seed, wires, loads)
    assert short.followed > 20
    assert long.followed == 0
    assert short.said == long.said
    assert short.states() == long.states()


def test_silent_master_is_noticed_half_a_cycle_after_the_second_mst_that_is_missing() -> None:
    line = Line(1)
    line.swing(Random(1))
    line.rig.run_until(line.rig.now_ns + 20 * CYCLE_NS + CYCLE_NS * 9 // 10)
    heard_ns = max(int(said.split()[1]) for said in line.said if said.startswith("ring") and "Cycle(" in said)
    assert line.max4.bus is not None
    line.max4.bus._drop_master()
    for at_ns, phase in ((heard_ns + CYCLE_NS * 5 // 2 - 1, 4), (heard_ns + CYCLE_NS * 5 // 2, 0)):
        line.rig.run_until(at_ns)
        assert {phase_of(drive) for drive in line.drives} == {phase}


def phase_of(drive: Mc4) -> int:
    assert drive._side is not None
    return drive._side.slave.phase
