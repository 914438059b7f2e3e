"""A changed program goes on from a booted rig where the change has no effect before, and its fate is the same."""

from collections import Counter
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from st_tests import LAMP_RIG, written

from fieldrig import MS, Rig, S, load
from fieldrig_devices.iec.controller.exchange import are_quiet, exchange
from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.testing import stands, trial
from fieldrig_devices.iec.testing.blocks import BlockSource
from fieldrig_devices.iec.testing.case import Limits
from fieldrig_devices.iec.testing.in_rig import Rigs

pytestmark = [pytest.mark.lean, pytest.mark.long]

LAMP = """\
VAR_GLOBAL presses, held : INT; most : INT := 3; END_VAR
FUNCTION Limited : BOOL
VAR_INPUT n : INT; END_VAR
Limited := n <= most;
END_FUNCTION
PROGRAM PLC_PRG
VAR switch AT %IX0.0 : BOOL; lamp AT %QX0.0 : BOOL; edge : R_TRIG; late : TON; state : INT; ticks : INT; END_VAR
ticks := ticks + 1;
IF ticks = 400 THEN
  state := 1;
END_IF
edge(CLK := switch);
IF edge.Q AND Limited(presses + 1) THEN
  presses := presses + 1;
  IF presses = 2 THEN
    held := held + 1;
    lamp := FALSE;
  END_IF
END_IF
late(IN := switch, PT := T#30ms);
CASE state OF
1: lamp := late.Q;
   IF presses >= 2 THEN state := 2; END_IF
2: lamp := TRUE;
   IF presses > 2 THEN lamp := 1 / (presses - 3) = 7; END_IF
END_CASE
END_PROGRAM
"""
PLACES = """VAR
    switch AT 'wires/switch.on' : BOOL;
    lamp AT 'wires/lamp.on' : BOOL;
    presses AT 'terminal/presses' : INT;
END_VAR"""
TESTS = f"""
RIG 'lamp.yaml' AFTER T#5s;
SETUP {PLACES}
ASSERT_FALSE(lamp);
END_SETUP
TEST 'nothing' ASSERT_NEVER(lamp, T#100ms); END_TEST
TEST 'once'
switch := TRUE;
ASSERT_STAYS(NOT lamp, T#25ms);
ASSERT_WITHIN(lamp, T#50ms);
ASSERT_EQ(presses, 1);
END_TEST
TEST 'twice'
switch := TRUE; ADVANCE_TIME(T#50ms);
switch := FALSE; ADVANCE_TIME(T#50ms);
ASSERT_FALSE(lamp);
switch := TRUE; ADVANCE_TIME(T#50ms);
ASSERT_TRUE(lamp);
ASSERT_EQ(presses, 2);
END_TEST
TEST 'after a restart'
switch := TRUE; ADVANCE_TIME(T#50ms);
FAULT('terminal', 'power_off');
RUN_FOR(T#200ms);
CLEAR_FAULTS('terminal');
RUN_FOR(T#200ms);
ASSERT_LE(presses, 2);
END_TEST
"""


CONFIGS = Path(__file__).parents[4] / "configs"
QUIET_NS = 4 * S + 5 * MS
"""An instant in the middle between two cycles of the program."""


def hash_at(file: Path, end_ns: int, *, is_exchanged: bool) -> str:
    with Rig(load(file, ("time=virtual",))) as rig:
        rig.run_until(QUIET_NS)
        if is_exchanged:
            plcs = stands.plcs_in(rig)
            before = [one.program.compiled for one in plcs if one.program is not None]
            assert are_quiet(plcs)
            for compiled in before:
                exchange(plcs, compiled.files[0].name)
            assert all(one.program is not None and one.program.compiled not in before for one in plcs)
        rig.run_until(end_ns)
        return rig.trace_hash()


@pytest.mark.parametrize("file", ["conveyor.yaml", "feeder.yaml"])
def test_a_program_that_is_exchanged_for_itself_goes_on_as_before(file: str) -> None:
    """The exchange itself must not be what a test notices."""
    plain, exchanged = (hash_at(CONFIGS / file, QUIET_NS + S, is_exchanged=one) for one in (False, True))
    assert plain == exchanged


@pytest.fixture
def source(tmp_path: Path) -> BlockSource:
    (tmp_path / "lamp.yaml").write_text(LAMP_RIG)
    written(tmp_path, lamp=LAMP, lamp_test=TESTS)
    return BlockSource(tmp_path / "lamp_test.st", EDITION_3)


def tried(source: BlockSource) -> list[trial.Result]:
    work, limits = [(source, source.cases())], Limits(30.0)
    before, reached = trial.baseline(work, limits)
    assert before.bad == []
    return list(trial.results(before.changes, (), before, reached, work, limits, 1))


def test_a_change_has_the_same_fate_as_in_a_rig_of_its_own(
    source: BlockSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    boots = list[int]()
    made = Rigs._rig

    def counted(self: Rigs, use: Any) -> Any:
        boots.append(1)
        return made(self, use)

    monkeypatch.setattr(Rigs, "_rig", counted)
    chosen, with_stands = tried(source), len(boots)
    boots.clear()
    monkeypatch.setattr(stands, "present", lambda: None)
    assert [(one.change, one.fate) for one in chosen] == [(one.change, one.fate) for one in tried(source)]
    fates = Counter(one.fate for one in chosen)
    assert min(fates[fate] for fate in (trial.Fate.NOTICED, trial.Fate.MISSED, trial.Fate.NOT_RUN)) > 0, fates
    assert fates[trial.Fate.NOTICED] > 15
    assert with_stands <= len(boots) / 2  # the others change what a controller does from its first cycle on


def is_quiet(rig: Rig) -> bool:
    return are_quiet(stands.plcs_in(rig))


def test_a_rig_is_kept_between_the_cycles_of_its_tasks_only() -> None:
    """In the first cycle of the wrapper the marks of coverage shift the slices, and its second task waits meanwhile."""

    def make() -> Rig:
        return Rig(load(CONFIGS / "wrapper/wrapper.yaml", ("time=virtual",)))

    def fail(*_: Any) -> Any:
        raise AssertionError("there are no tests")

    stand = stands.Stand([], Limits(600.0), 2 * S, fail, make)
    with closing(stand):
        found = []
        for point in stand._points.values():
            with point.branch() as branch:
                found.append(branch.call(is_quiet))
    assert found == [True] * 4
