"""The fold leaves a cycle to the steps when the position of the load has to be published again."""

from copy import copy
from random import Random

import pytest
from drive_line import CYCLE_NS, TWISTING, Line
from inner_state import inner_state

from fieldrig.clock import S
from fieldrig_devices.drives.axis import Axis
from fieldrig_devices.drives.fold import PublishedMotion
from fieldrig_devices.drives.loops import INCREMENTS, RAD
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN
from fieldrig_devices.mc4.drive import Mc4
from fieldrig_devices.mc4.energy import SLOW_NS

LOADS = pytest.mark.parametrize("load", [{}, {"gear_ratio": 7.5}, TWISTING], ids=["stiff", "geared", "twisting"])


@pytest.mark.long
@LOADS
def test_drive_on_wires_takes_the_steps_only_to_publish_and_to_look(
    monkeypatch: pytest.MonkeyPatch, load: dict[str, float]
) -> None:
    """The shaft is some turns away from the position that the encoder gives."""
    stepped: set[int] = set()
    cycle = Axis.cycle

    def spy(axis: Axis) -> None:
        stepped.add(line.rig.now_ns)
        cycle(axis)

    line = Line(1, wires=True, loads=(load,))
    line.drives[0].machine.shaft_offset = 3 * INCREMENTS_PER_TURN
    line.swing(Random(1))
    line.run(10)
    monkeypatch.setattr(Axis, "cycle", spy)
    line.said.clear()
    line.run(600)
    published = {int(said.split()[1]) for said in line.said if said.startswith("wires ") and " d1 " in said}
    looks = 600 * CYCLE_NS // SLOW_NS + 1
    assert published <= stepped
    assert len(published) > 20
    assert len(stepped - published) <= looks


class Told:
    """A swinging drive whose load was published at its true position, or elsewhere."""

    TOLERANCE = 1e-6
    """Tolerance in rad; following error and twist are larger."""

    def __init__(self, load: dict[str, float]) -> None:
        self.line, self.gear = Line(1, wires=True, loads=(load,)), load.get("gear_ratio", 1.0)
        self.line.swing(Random(1))
        self.line.run(20)
        side = self.line.drives[0]._side
        assert side is not None
        while side._following is None:
            self.line.run(1)
        self.axis, self.following = self.line.drives[0].machine.axis, side._following
        freely = side._feedback.following(self.axis, is_published=False)
        assert freely is not None
        self.freely = freely

    def stop(self) -> None:
        """Bring the axis to a standstill, free of torque."""
        for name in ("e", "v", "i", "t", "lead", "load_nm", "twist", "load_speed"):
            setattr(self.axis, name, 0.0)
        self.axis.way = 0

    def refuses(self, off: float = 0.0, speed: float = 0.0) -> bool:
        """True if the fold refuses a cycle that takes the load `off` rad from its published motion with this speed."""
        now_ns, wanted = self.line.rig.now_ns, self.axis.set_increments & 0xFFFF_FFFF
        offset, ago_ns = 2 * INCREMENTS_PER_TURN, 3 * CYCLE_NS
        then = copy(self.axis)
        assert self.freely(then, wanted, 1e99, now_ns, None) is not None
        load = ((then.set_increments - then.e * INCREMENTS + offset) * RAD - then.twist) / self.gear
        published = PublishedMotion(
            load + off - speed * ago_ns / S, speed, now_ns - ago_ns, self.TOLERANCE, self.gear, offset
        )
        before = inner_state(self.axis)
        is_refused = self.following(self.axis, wanted, 1e99, now_ns, published) is None
        assert not is_refused or inner_state(self.axis) == before
        return is_refused


@pytest.mark.long
@LOADS
@pytest.mark.parametrize(("part", "refuses"), [(-1.01, True), (-0.99, False), (0.99, False), (1.01, True)])
@pytest.mark.parametrize("speed", [0.0, 0.1])
def test_drive_whose_published_motion_is_off_is_left_to_the_steps(
    load: dict[str, float], part: float, refuses: bool, speed: float
) -> None:
    assert Told(load).refuses(part * Told.TOLERANCE, speed) is refuses


@pytest.mark.long
@LOADS
@pytest.mark.parametrize(("speed", "refuses"), [(0.0, False), (0.1, True)])
def test_drive_that_has_to_publish_its_standstill_is_left_to_the_steps(
    load: dict[str, float], speed: float, refuses: bool
) -> None:
    drive = Told(load)
    drive.stop()
    assert drive.refuses(speed=speed) is refuses


@pytest.mark.long
def test_silent_master_is_noticed_half_a_cycle_after_the_second_missing_mst() -> None:
    line = Line(1)
    line.swing(Random(1))
    line.rig.run_until(line.rig.now_ns + 20 * CYCLE_NS + CYCLE_NS * 9 // 10)
    heard_ns = max(int(said.split()[1]) for said in line.said if said.startswith("ring") and "Cycle(" in said)
    assert line.max4.firmware.cycles.bus is not None
    line.max4.firmware.cycles.bus._drop_master()
    for at_ns, phase in ((heard_ns + CYCLE_NS * 5 // 2 - 1, 4), (heard_ns + CYCLE_NS * 5 // 2, 0)):
        line.rig.run_until(at_ns)
        assert {phase_of(drive) for drive in line.drives} == {phase}


def phase_of(drive: Mc4) -> int:
    assert drive._side is not None
    return drive._side.slave.phase
