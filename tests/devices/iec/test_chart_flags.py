"""Variables such as SFCInit and SFCPause steer a chart, as CoDeSys V2.3, CODESYS V3 and TwinCAT 3 describe them."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig import MS, program

FLAGS = "VAR SFCInit, SFCReset, SFCPause, SFCTrans, SFCTip, SFCTipMode : BOOL; SFCCurrentStep : STRING; END_VAR"
CHART = """
FUNCTION_BLOCK Filler
VAR_INPUT go, done : BOOL; END_VAR
{flags}
VAR lamp, kept, late : BOOL; begun, idle : INT; END_VAR
INITIAL_STEP Wait:
ENTRY begun := begun + 1; END_ENTRY
ACTIVE idle := idle + 1; END_ACTIVE
END_STEP
TRANSITION FROM Wait TO Fill := go; END_TRANSITION
STEP Fill: lamp(N); kept(S); late(SD, T#20ms); END_STEP
TRANSITION FROM Fill TO Drain := done; END_TRANSITION
STEP Drain: END_STEP
TRANSITION FROM Drain TO Wait := FALSE; END_TRANSITION
END_FUNCTION_BLOCK
"""


class Bench:
    def __init__(self, folder: Path, flags: str, dialect: str) -> None:
        path = folder / "filler.st"
        path.write_text(CHART.replace("{flags}", flags))
        self.plc = program(path, dialect=dialect)
        self.filler = self.plc.block("Filler")

    def cycles(self, count: int = 1, **values: Any) -> str:
        """Set variables, run cycles of 10 ms, and return the name of the step that is active then."""
        for name, value in values.items():
            setattr(self.filler, name, value)
        for _ in range(count):
            self.filler()
            self.plc.advance(10 * MS)
        return next(name for name in ("Wait", "Fill", "Drain") if getattr(self.filler, name).x)

    @property
    def lights(self) -> tuple[bool, bool, bool]:
        return self.filler.lamp, self.filler.kept, self.filler.late


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path, FLAGS, "codesys")


def test_a_chart_that_pauses_runs_nothing_and_goes_on(bench: Bench) -> None:
    assert bench.cycles(2, go=True) == "Fill"
    assert bench.cycles(3, SFCPause=True, done=True) == "Fill"
    assert bench.cycles(SFCPause=False) == "Drain"


def test_init_is_at_the_initial_step_without_running_it(bench: Bench) -> None:
    bench.cycles(4, go=True)
    assert bench.lights == (True, True, True)
    begun, idle = bench.filler.begun, bench.filler.idle
    assert bench.cycles(3, SFCInit=True) == "Wait"
    assert (bench.lights, bench.filler.begun, bench.filler.idle) == ((False, False, False), begun, idle)
    assert bench.cycles(SFCInit=False, go=False) == "Wait"
    assert (bench.filler.begun, bench.filler.idle, bench.lights) == (begun + 1, idle + 1, (False, False, False))


def test_reset_runs_the_initial_step_once_begun(bench: Bench) -> None:
    bench.cycles(4, go=True)
    idle = bench.filler.idle
    assert bench.cycles(3, SFCReset=True) == "Wait"
    assert (bench.lights, bench.filler.begun, bench.filler.idle) == ((False, False, False), 2, idle + 3)
    assert bench.cycles(SFCReset=False) == "Fill"


def test_a_transition_that_fires_is_noted_for_a_cycle(bench: Bench) -> None:
    noted = []
    for _ in range(4):
        bench.cycles(go=True)
        noted.append(bench.filler.SFCTrans)
    assert noted == [True, False, False, False]


def test_tip_mode_moves_on_by_hand(bench: Bench) -> None:
    assert bench.cycles(3, SFCTipMode=True, go=True) == "Wait"
    assert bench.cycles(SFCTip=True, go=False) == "Fill"
    assert bench.cycles(3) == "Fill"
    bench.cycles(SFCTip=False)
    assert bench.cycles(SFCTip=True) == "Drain"


def test_the_active_step_has_its_name(bench: Bench) -> None:
    bench.cycles()
    assert bench.filler.SFCCurrentStep == "Wait"
    bench.cycles(go=True)
    assert bench.filler.SFCCurrentStep == "Fill"


@pytest.mark.parametrize("dialect", ["epas-4", "edition-3"])
def test_other_dialects_have_variables_like_any_others(tmp_path: Path, dialect: str) -> None:
    bench = Bench(tmp_path, FLAGS, dialect)
    assert bench.cycles(2, SFCPause=True, SFCInit=True, go=True) == "Fill"
    assert bench.filler.SFCCurrentStep == ""


@pytest.mark.parametrize("flags", ["", "VAR SFCPause, SFCCurrentStep : INT := 1; SFCTipMode : BOOL := TRUE; END_VAR"])
def test_what_is_not_declared_as_such_a_flag_steers_nothing(tmp_path: Path, flags: str) -> None:
    assert Bench(tmp_path, flags, "codesys").cycles(go=True) == "Fill"


def test_a_global_flag_steers_all_charts(tmp_path: Path) -> None:
    bench = Bench(tmp_path, "", "codesys")
    path = tmp_path / "filler.st"
    path.write_text(path.read_text() + "VAR_GLOBAL SFCPause : BOOL := TRUE; END_VAR")
    bench.plc = program(path, dialect="codesys")
    bench.filler = bench.plc.block("Filler")
    assert bench.cycles(3, go=True) == "Wait"
    bench.plc["SFCPause"] = False
    assert bench.cycles() == "Fill"
