"""TEST blocks with a rig around them: points, wires, faults, and expectations at each instant."""

from pathlib import Path

import pytest
from st_tests import LAMP_RIG, iec_test, outcomes, written

from fieldrig_devices.iec.testing.case import Verdict

pytestmark = pytest.mark.lean

LAMP = """\
VAR_GLOBAL g_uiPresses : UINT; g_bBlock : BOOL; g_rSpeed : REAL := 1.5; END_VAR
PROGRAM PLC_PRG
VAR bSwitch AT %IX0.0 : BOOL; bLamp AT %QX0.0 : BOOL; edge : R_TRIG; END_VAR
edge(CLK := bSwitch);
IF edge.Q THEN g_uiPresses := g_uiPresses + 1; END_IF
bLamp := bSwitch AND NOT g_bBlock;
END_PROGRAM
"""
PLACES = """VAR
    switch AT 'wires/switch.on' : BOOL;
    lamp AT 'wires/lamp.on' : BOOL;
    presses AT 'terminal/g_uiPresses' : UINT;
    block AT 'terminal/g_bBlock' : BOOL;
END_VAR
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "lamp.yaml").write_text(LAMP_RIG)
    return written(tmp_path, lamp=LAMP)


def with_rig(folder: Path, body: str, places: str = PLACES, after: str = " AFTER T#5s") -> Path:
    written(folder, lamp_test=f"TEST 'it'\nRIG 'lamp.yaml'{after};\n{places}{body}\nEND_TEST\n")
    return folder / "lamp_test.st"


RIGHT = [
    "switch := TRUE; ASSERT_WITHIN(lamp, T#50ms); ASSERT_EQ(presses, 1);",
    "ASSERT_FALSE(lamp); switch := TRUE; ADVANCE_TIME(T#50ms); ASSERT_TRUE(lamp, 'on');",
    "block := TRUE; switch := TRUE; ASSERT_NEVER(lamp, T#200ms); ASSERT_EQ(presses, 1);",
    "switch := TRUE; ASSERT_WITHIN(lamp, T#50ms); ASSERT_STAYS(lamp, T#200ms);",
    "switch := TRUE; ASSERT_UNTIL(NOT lamp, presses = 1, T#50ms);",
    "presses := 7; switch := TRUE; RUN_FOR(T#50ms); ASSERT_EQ(presses, 8);",
    "FAULT('terminal', 'power_off'); switch:=TRUE; RUN_FOR(T#1s); CLEAR_FAULTS('terminal'); ASSERT_WITHIN(lamp,T#9s);",
]


@pytest.mark.long
@pytest.mark.parametrize("body", RIGHT)
def test_what_the_machine_does_passes(folder: Path, body: str) -> None:
    outcome = outcomes(with_rig(folder, body))["it"]
    assert (outcome.verdict, outcome.failures) == (Verdict.PASSED, ())


@pytest.mark.long
def test_each_test_begins_with_the_booted_rig(folder: Path) -> None:
    body = "switch := TRUE; ASSERT_EQ(presses, 0); ASSERT_WITHIN(lamp, T#50ms); ASSERT_EQ(presses, 1);"
    test = f"TEST '{{}}' {PLACES} {body} END_TEST\n"
    written(folder, lamp_test="RIG 'lamp.yaml' AFTER T#5s;\n" + "".join(test.format(name) for name in "abc"))
    done = outcomes(folder / "lamp_test.st")
    assert [one.verdict for one in done.values()] == [Verdict.PASSED] * 3
    assert len({one.duration_ns for one in done.values()}) == 1


@pytest.mark.long
def test_the_rig_may_be_named_behind_the_variables(folder: Path) -> None:
    body = "RIG 'lamp.yaml' AFTER T#5s; VAR n : INT; END_VAR ASSERT_FALSE(lamp);"
    written(folder, lamp_test=f"TEST 'it' {PLACES} {body} END_TEST")
    assert outcomes(folder / "lamp_test.st")["it"].failures == ()


@pytest.mark.long
def test_without_branches_each_test_has_a_rig_of_its_own(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fieldrig.virtual.may_branch.HAS_FORK", False)
    body = "switch := TRUE; ASSERT_EQ(presses, 0); ASSERT_WITHIN(lamp, T#50ms); ASSERT_EQ(presses, 1);"
    test = f"TEST '{{}}' {PLACES} {body} END_TEST\n"
    written(folder, lamp_test="RIG 'lamp.yaml' AFTER T#5s;\n" + "".join(test.format(name) for name in "ab"))
    assert [one.failures for one in outcomes(folder / "lamp_test.st").values()] == [(), ()]


@pytest.mark.long
def test_a_failure_has_the_signals_of_the_machine(folder: Path) -> None:
    body = "switch := TRUE;\nRUN_FOR(T#100ms);\nswitch := FALSE;\nASSERT_STAYS(lamp, T#1s, 'the lamp');"
    (failure,) = outcomes(with_rig(folder, body))["it"].failures
    assert (failure.kind, failure.actual, failure.message) == ("ASSERT_STAYS", "FALSE", "the lamp")
    assert 100_000_000 < failure.at_ns < 150_000_000
    lines = {line.split()[0]: line for line in failure.diagram}
    assert list(lines)[:4] == ["switch", "presses", "block", "lamp"]
    assert lines["lamp"].endswith("▔▁")


@pytest.mark.long
def test_a_pulse_within_one_instant_is_seen(folder: Path) -> None:
    """Two messages of a wire at one instant are a pulse without a length, which a sample would miss."""
    from fieldrig import Rig, load
    from fieldrig_bus.wires import Signal
    from fieldrig_devices.iec.dialect import EDITION_3
    from fieldrig_devices.iec.testing.case import Case, Limits
    from fieldrig_devices.iec.testing.compiled import compile_tests
    from fieldrig_devices.iec.testing.in_rig import InRig, Prepared
    from fieldrig_devices.iec.testing.runner import Runner
    from fieldrig_devices.languages.source_file import SourceFile

    file = with_rig(folder, "ASSERT_NEVER(lamp, T#1s);", "VAR lamp AT 'wires/pulse.on' : BOOL; END_VAR ")
    tested = compile_tests([SourceFile(str(file), file.read_text())], EDITION_3)
    with Rig(load(folder / "lamp.yaml")) as rig:
        node = rig.attach("pulse")
        link = node.link("wires")
        link.send(Signal("pulse.on", False))
        rig.run_for(1_000_000)

        def pulse() -> None:
            link.send(Signal("pulse.on", True))
            link.send(Signal("pulse.on", False))

        node.clock.call_at(20_000_000, pulse)
        case = Case("it", "s", file, 1)
        outcome = Runner(tested, InRig(rig, tested.blocks[0], Prepared(tested))).run(case, tested.blocks[0], Limits())
    assert [(one.kind, one.at_ns) for one in outcome.failures] == [("ASSERT_NEVER", 19_000_000)]


MISTAKES = [
    ("", "VAR x AT 'terminal/nowhere' : BOOL; END_VAR ", "", "terminal has no value 'nowhere'"),
    ("", "VAR x AT 'nowhere/x' : BOOL; END_VAR ", "", "the rig has no device 'nowhere'"),
    ("", "VAR x AT 'terminal' : BOOL; END_VAR ", "", "'terminal' is not a point"),
    ("", "VAR x AT 'terminal/g_rSpeed' : STRING; END_VAR ", "", ", and x is a STRING"),
    ("", "VAR x AT 'terminal/g_uiPresses' : ARRAY[1..2] OF INT; END_VAR ", "", "x is an ARRAY[1..2] OF INT"),
    ("", "", " AFTER 5", "the time behind AFTER in line 2 is no time"),
]


@pytest.mark.long
@pytest.mark.parametrize(("body", "places", "after", "what"), MISTAKES)
def test_what_the_rig_does_not_have_is_a_mistake(folder: Path, body: str, places: str, after: str, what: str) -> None:
    with_rig(folder, body, places, after)
    done = iec_test(folder)
    assert (done.exit_code, f"{folder}/lamp_test.st:2: " in done.stdout) == (2, True), done.output
    assert what in done.stdout


@pytest.mark.long
def test_a_wrong_rig_file_is_a_mistake(folder: Path) -> None:
    (folder / "lamp.yaml").write_text(LAMP_RIG.replace("hmiscu", "hmiscux"))
    with_rig(folder, "")
    done = iec_test(folder)
    assert done.exit_code == 2
    assert "hmiscux" in done.stdout


FAULTS = [
    ("FAULT('terminal', 'melt');", "there is no fault 'melt'"),
    ("FAULT('nowhere', 'power_off');", "the rig has no bus or device 'nowhere'"),
    ("FAULT('terminal', 'power_off twice');", "'twice' is no key of a fault"),
    ("CLEAR_FAULTS('nowhere');", "the rig has no bus or device 'nowhere'"),
    ("RUN_FOR(T#20d);", "the test took more than 0.5 s"),
]


@pytest.mark.long
@pytest.mark.parametrize(("body", "what"), FAULTS)
def test_what_the_rig_refuses_is_an_error_at_its_line(folder: Path, body: str, what: str) -> None:
    outcome = outcomes(with_rig(folder, body, ""), timeout_s=0.5)["it"]
    assert outcome.verdict is Verdict.ERROR
    (failure,) = outcome.failures
    assert (failure.line, what in failure.actual) == (3, True), failure
