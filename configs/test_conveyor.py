"""The conveyor in virtual time: the lamp flashes, and the belt starts, runs and stops without a jump of its speed."""

from collections.abc import Iterator
from itertools import pairwise
from math import pi
from pathlib import Path
from shutil import copytree

from fieldrig import MS, Rig, RigMaker, S

RIG = Path(__file__).with_name("conveyor.yaml")
ENABLED, S1_ON = 1, 3
CYCLE_NS = 4 * MS
PART_MM, SPEED, CV, CA = 200.0, 250.0, 4 * pi / (4 + pi), 4 * pi * pi / (4 + pi)
MM_PER_INCREMENT = 31.41592653589793 / 1_000_000


def booted(rig: Rig) -> Rig:
    rig.until(lambda: rig.get("max4/booted"), within=60 * S)
    rig.run_for(S // 2)
    return rig


def set_positions(rig: Rig, seconds: float) -> Iterator[float]:
    """The set position of the belt in each cycle of the ring, in mm."""
    for _ in range(round(seconds * S / CYCLE_NS)):
        rig.run_for(CYCLE_NS)
        yield float(rig.get("max4/ConveyerBelt.SetValue")) * MM_PER_INCREMENT


def test_the_lamp_flashes_in_the_steps_of_its_task(fieldrig_rig: RigMaker) -> None:
    """500 ms are over at the sixth call of a task of 100 ms (manual 3793), so a change follows after each 600 ms."""
    rig = booted(fieldrig_rig(RIG))
    edges, shown = [], rig.get("max4/O_bEquipmentOnIndicatorH1.Value")
    for _ in range(5000):
        rig.run_for(MS)
        value = rig.get("max4/O_bEquipmentOnIndicatorH1.Value")
        if value != shown:
            shown = value
            edges.append(rig.now_ns)
    assert len(edges) >= 7
    assert {later - earlier for earlier, later in pairwise(edges)} == {600 * MS}


def test_the_belt_starts_runs_and_stops_without_a_jump(fieldrig_rig: RigMaker) -> None:
    rig = booted(fieldrig_rig(RIG))
    rig.set("panel/6200:01", S1_ON)
    places = list(set_positions(rig, 4))
    rig.set("panel/6200:01", ENABLED)
    places += set_positions(rig, 4)
    speeds = [(later - earlier) * S / CYCLE_NS for earlier, later in pairwise(places)]
    rounding = 2 * MM_PER_INCREMENT * S / CYCLE_NS
    # the largest acceleration of the start cam: half the law over one part, scaled to the speed 1:1
    steepest = PART_MM / CV * CA / 2 * (SPEED / PART_MM) ** 2 * CYCLE_NS / S
    assert max(abs(later - earlier) for earlier, later in pairwise(speeds)) <= steepest + 2 * rounding
    assert abs(max(speeds) - SPEED) <= rounding
    assert (speeds[0], speeds[-1]) == (0.0, 0.0)
    parts = (places[-1] - places[0] - 2 * PART_MM / CV) / PART_MM
    assert parts >= 4
    assert abs(parts - round(parts)) < 1e-5


def test_products_reach_the_light_barriers_and_leave(fieldrig_rig: RigMaker) -> None:
    rig = booted(fieldrig_rig(RIG))
    rig.set("panel/6200:01", S1_ON)
    rig.run_for(12 * S)
    assert int(rig.get("line/discharged")) >= 2
    assert int(rig.get("line/fed")) > int(rig.get("line/discharged"))
    assert rig.get("max4/DiagCode") == 0


def test_the_emergency_stop_needs_a_new_start(fieldrig_rig: RigMaker) -> None:
    rig = booted(fieldrig_rig(RIG))
    rig.set("panel/6200:01", S1_ON)
    rig.run_for(3 * S)
    assert float(rig.get("line/speed")) > 0.2
    for outputs in (2, S1_ON):  # enable off and on again, while S1 stays on
        rig.set("panel/6200:01", outputs)
        rig.run_for(2 * S)
        assert abs(float(rig.get("line/speed"))) < 1e-3
    rig.set("panel/6200:01", ENABLED)
    rig.run_for(S)
    rig.set("max4/DiagQuit", True)
    rig.run_for(S)
    rig.set("panel/6200:01", S1_ON)
    rig.run_for(3 * S)
    assert float(rig.get("line/speed")) > 0.2


def test_the_program_is_changed_while_the_belt_runs(tmp_path: Path, fieldrig_rig: RigMaker) -> None:
    """The change of conveyor.md: a faster belt, without a stop and without a jump of its speed."""
    folder = tmp_path / "configs"
    copytree(RIG.parent, folder)
    rig = booted(fieldrig_rig(folder / RIG.name))
    rig.set("panel/6200:01", S1_ON)
    list(set_positions(rig, 3))
    program = folder / "programs" / "conveyor.st"
    state_7 = "7:  (* further cyclic cams, each one part behind the one before *)\n"
    text = program.read_text(encoding="ascii")
    assert state_7 in text
    faster = (
        "    IF MasterEncoder.Velocity < 400.0 THEN MasterEncoder.Velocity := MasterEncoder.Velocity + 2.0; END_IF;\n"
    )
    program.write_text(text.replace(state_7, state_7 + faster), encoding="ascii")
    rig.set("max4/command", "online change")
    places = list(set_positions(rig, 3))
    speeds = [(later - earlier) * S / CYCLE_NS for earlier, later in pairwise(places)]
    rounding = 2 * MM_PER_INCREMENT * S / CYCLE_NS
    assert abs(speeds[0] - SPEED) <= rounding
    assert abs(speeds[-1] - 400.0) <= rounding
    assert max(abs(later - earlier) for earlier, later in pairwise(speeds)) <= 2.0 + 2 * rounding
    assert float(rig.get("line/speed")) > 0.39
