"""The eye of a search: each sort of state that a rig has makes a new state, taken from what its devices offer."""

from pathlib import Path

import pytest
from st_tests import LAMP_RIG

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.coverage.collecting import collecting
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal
from fieldrig_devices.search.eye import Eye, State
from fieldrig_devices.search.state_places import Sort, state_places

pytestmark = [pytest.mark.lean, pytest.mark.long]
CONFIGS = Path(__file__).parents[3] / "configs"
CHART = """\
PROGRAM PLC_PRG
VAR switch AT %IX0.0 : BOOL; lamp AT %QX0.0 : BOOL; END_VAR
INITIAL_STEP off: END_STEP
STEP on: lit(N); END_STEP
TRANSITION FROM off TO on := switch; END_TRANSITION
TRANSITION FROM on TO off := NOT switch; END_TRANSITION
ACTION lit: lamp := TRUE; END_ACTION
END_PROGRAM
"""
TEXT = """\
PROGRAM PLC_PRG
VAR switch AT %IX0.0 : BOOL; lamp AT %QX0.0 : BOOL; END_VAR
IF switch THEN lamp := TRUE; ELSE lamp := FALSE; END_IF
END_PROGRAM
"""
READ_NOTHING = CanFrame(0x605, bytes.fromhex("40 00 30 00 00 00 00 00"))
"""An SDO upload of object 3000h, which node 5 does not have."""


class Seen:
    """A rig with an eye for some sorts of states."""

    def __init__(self, rig: Rig, *sorts: Sort) -> None:
        self.rig = rig
        self.eye = Eye(rig, frozenset(sorts), ())
        self.eye.forget()
        rig.run_for(200 * MS)
        self.before = self.eye.states()
        self.marks = self.eye.marks()

    def new(self) -> set[State]:
        """Return the states of the next 200 ms that were not there before."""
        self.rig.run_for(200 * MS)
        return set(self.eye.states() - self.before)

    def switch(self, name: str) -> None:
        self.rig.attach("test").link("wires").send(Signal(name, True))


def lamp(folder: Path, program: str) -> Rig:
    (folder / "rig.yaml").write_text(LAMP_RIG)
    (folder / "lamp.st").write_text(program)
    rig = Rig(load(folder / "rig.yaml"))
    rig.run_until(500 * MS)
    return rig


def test_a_branch_of_a_program_in_st(tmp_path: Path) -> None:
    with collecting(is_written=False), lamp(tmp_path, TEXT) as rig:
        seen = Seen(rig, Sort.PROGRAMS)
        seen.switch("switch.on")
        seen.new()
        assert sum(seen.eye.marks()) > sum(seen.marks)


def test_the_active_step_of_a_chart(tmp_path: Path) -> None:
    with collecting(is_written=False), lamp(tmp_path, CHART) as rig:
        seen = Seen(rig, Sort.PROGRAMS)
        seen.switch("switch.on")
        assert [state[:2] for state in seen.new()] == [("steps", 0)]


def test_a_program_that_is_loaded_again_has_the_same_branches(tmp_path: Path) -> None:
    with collecting(is_written=False), lamp(tmp_path, TEXT) as rig:
        seen = Seen(rig, Sort.PROGRAMS)
        rig.restart("terminal")
        rig.run_for(500 * MS)
        seen.switch("switch.on")
        seen.new()
        assert len(seen.eye.marks()) == len(seen.marks)
        assert sum(seen.eye.marks()) > sum(seen.marks)


def test_the_way_is_what_ran_in_the_last_50_ms(tmp_path: Path) -> None:
    with collecting(is_written=False), lamp(tmp_path, TEXT) as rig:
        seen = Seen(rig, Sort.PROGRAMS)
        before = seen.eye.way()
        seen.switch("switch.on")
        seen.new()
        way = seen.eye.way()
        assert before != way
        assert way != seen.eye.marks()  # the branch without the switch is no part of it any more


@pytest.mark.parametrize(
    ("rig_file", "place", "value"), [("pam-machine.yaml", "plc/DIF_Start", 1), ("arp-cell.yaml", "panel/6200:01", 1)]
)
def test_branches_of_programs_of_a_pam_and_in_basic(rig_file: str, place: str, value: int) -> None:
    with collecting(is_written=False), Rig(load(CONFIGS / rig_file, ("time=virtual",))) as rig:
        rig.run_until(2 * S)
        seen = Seen(rig, Sort.PROGRAMS)
        rig.set(place, value)
        rig.run_for(3 * S)
        assert sum(seen.eye.marks()) > sum(seen.marks)


def test_an_output(tmp_path: Path) -> None:
    with lamp(tmp_path, TEXT) as rig:
        seen = Seen(rig, Sort.OUTPUTS)
        seen.switch("switch.on")
        assert ("wires", frozenset({"wires/lamp.on"})) in seen.new()


def test_states_of_cia_402_and_a_number_of_a_diagnosis() -> None:
    with Rig(load(CONFIGS / "drive.yaml", ("time=virtual",))) as rig:
        rig.run_until(1 * S)
        moved, failed = Seen(rig, Sort.STATES), Seen(rig, Sort.DIAGNOSES)
        rig.set("axis/6040:00", 6)
        assert len(moved.new()) == 1
        assert not failed.new()
        rig.add_fault("axis", {"what": "overtemperature"})
        assert failed.new()


def test_the_code_of_an_aborted_transfer() -> None:
    with Rig(load(CONFIGS / "lab.yaml", ("time=virtual",))) as rig:
        rig.run_until(1 * S)
        seen = Seen(rig, Sort.ABORTS)
        rig.attach("master").link("can0").send(READ_NOTHING)
        [state] = seen.new()
        assert state == ("abort", "can0", 0x585, bytes.fromhex("00 00 02 06"))


def test_a_plan_restricts_and_adds(tmp_path: Path) -> None:
    with lamp(tmp_path, TEXT) as rig:
        assert state_places(rig, frozenset({Sort.PROGRAMS, Sort.ABORTS})) == {}
        assert "DQ0" in state_places(rig, frozenset({Sort.OUTPUTS}))["terminal"]
        eye = Eye(rig, frozenset(), ("wires/switch.on",))
        eye.forget()
        rig.attach("test").link("wires").send(Signal("switch.on", True))
        rig.run_for(200 * MS)
        assert {state for state in eye.states() if state[0] == "places"} == {("places", False), ("places", True)}


def test_a_place_of_a_device_without_power_is_a_state_of_its_own() -> None:
    with Rig(load(CONFIGS / "lab.yaml", ("time=virtual",))) as rig:
        eye = Eye(rig, frozenset(), ("io/nmt.state",))
        eye.forget()
        rig.add_fault("io", {"what": "power_off", "duration_ms": 100})
        rig.run_for(200 * MS)
        assert ("places", None) in eye.states()
