"""PAM applications and programs of ARP cards under test in Python."""

from pathlib import Path
from typing import Any

import pytest
from pam_programs import MACHINE

from fieldrig import MS, ArgumentError, ConfigError, ProgramBench, RigError, S, program
from fieldrig.errors import UsageError

COUNTING = (
    MACHINE
    + "TASK TSK_a; SPECS CYCLES = 1; END_SPECS EVENTS ON_EVENT SBI_Start XEQ_SEQUENCE SEQ_a; END_EVENTS SEQUENCE SEQ_a;"
    " LOOP CWV_Count <- CWV_Count + {step}; WAIT_TIME 100; END_LOOP !SBI_Start; END_SEQUENCE END_TASK\n"
)
BLINKS = """\
LAMP    EQU O101
COUNT   EQU V5
BEG BLINKS
  COUNT == 3
LOOP:
  LAMP == I101
  IF I101 = LO, LOOP
  COUNT == COUNT + 1
  WAIT 1
  GOTO LOOP
END
"""


@pytest.fixture
def pam(tmp_path: Path) -> ProgramBench:
    (tmp_path / "a.pam").write_text(COUNTING.format(step=1))
    return program(tmp_path / "a.pam")


def test_an_application_runs_while_time_passes(pam: ProgramBench) -> None:
    pam.advance(1 * S)
    assert pam["CWV_Count"] == 0
    pam.start()
    pam["SBI_Start"] = True
    pam.advance(1 * S)
    assert (pam["CWV_Count"], pam.now_ns) == (10, 2 * S)
    pam.stop()
    pam.advance(1 * S)
    assert pam["CWV_Count"] == 10
    pam.reset()
    assert (pam["CWV_Count"], pam.now_ns) == (0, 0)


def test_a_variable_of_an_application_may_be_forced(pam: ProgramBench) -> None:
    pam.start()
    pam["SBI_Start"] = True
    pam.force("CWV_Count", 500)
    pam.advance(1 * S)
    assert pam["CWV_Count"] == 500
    pam.release("CWV_Count")
    pam.until(lambda: pam["CWV_Count"] > 505, within=1 * S)


def test_a_fatal_error_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "a.pam").write_text(COUNTING.format(step=2_000_000_000))
    pam = program(tmp_path / "a.pam")
    pam.start()
    pam["SBI_Start"] = True
    with pytest.raises(RigError, match=r"02\.\.FFF2 an integer overflow in TSK_a.SEQ_a"):
        pam.advance(1 * S)


def test_mistakes_of_an_application_are_all_listed(tmp_path: Path) -> None:
    (tmp_path / "a.pam").write_text(MACHINE + "TASK TSK_a; SEQUENCE SEQ_a; AXI_Blt <- stop; END_SEQUENCE END_TASK\n")
    with pytest.raises(ConfigError, match="AXI_Blt is not declared here"):
        program(tmp_path / "a.pam")


@pytest.fixture
def card(tmp_path: Path) -> ProgramBench:
    (tmp_path / "blinks.I01").write_text(BLINKS)
    return program(tmp_path / "blinks.I01")


@pytest.mark.long
def test_a_card_runs_its_program(card: ProgramBench) -> None:
    card.advance(500 * MS)
    assert (card["COUNT"], card["LAMP"], card.now_ns) == (3, 0, 500 * MS)
    card.force("I101", 1)
    card.until(lambda: card["COUNT"] == 5, within=3 * S)
    assert card["O101"] == 1
    card.release("I101")
    card.advance(1 * S)
    assert card["LAMP"] == 0
    card["V5"] = 70
    assert card["COUNT"] == 70
    card.reset()
    assert card.now_ns == 0


@pytest.mark.long
def test_an_open_enable_stops_the_card(card: ProgramBench) -> None:
    card["I108"] = False
    with pytest.raises(RigError, match="105"):
        card.advance(1 * S)


@pytest.mark.parametrize("kind", ["pam", "card"])
def test_what_a_language_does_not_have_is_refused(kind: str, request: pytest.FixtureRequest) -> None:
    bench: ProgramBench = request.getfixturevalue(kind)
    calls: list[Any] = [lambda: bench.block("X"), lambda: bench.function("X"), lambda: bench.mock("X")]
    calls += [lambda: bench["NOWHERE"], lambda: bench.set("NOWHERE", 1), lambda: bench.advance(-1)]
    for call in calls:
        with pytest.raises(ArgumentError):
            call()


def test_options_and_files_of_other_languages_are_refused(tmp_path: Path) -> None:
    for name, text in (("a.pam", MACHINE), ("a.I01", BLINKS)):
        (tmp_path / name).write_text(text)
        with pytest.raises(ArgumentError, match="no option 'dialect'"):
            program(tmp_path / name, dialect="codesys")
        with pytest.raises(UsageError):
            program(tmp_path / name, tmp_path / name)
