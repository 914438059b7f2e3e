"""The debugger, with a card in virtual time."""

import re
from pathlib import Path

import pytest
from arp_user_port import PortBench, client

from fieldrig_devices.arp.user_port import listing
from fieldrig_devices.arp.user_port.client import RefusedByCardError
from fieldrig_devices.arp.user_port.debugger import Debugger
from fieldrig_devices.arp.user_port.listing import Listing
from fieldrig_devices.languages.debugging.prompt import NotStoppedError

SOURCE = """\
COUNT EQU V1
BEG MAIN ; counts

LOOP:
    COUNT += 1 ; one more
    CALL SUB
    WAIT 0.005
    IF V9 = 0, GOTO LOOP
END
BEG SUB
    V2 == COUNT * 2
    CALL DEEP
END
BEG DEEP
    V3 += 1
END
"""


class Session:
    def __init__(self, found: Listing, bench: PortBench, limit_s: float = 5.0) -> None:
        self.bench, self.said = bench, list[str]()
        self.card = client(bench)
        self.debugger = Debugger(self.card, found, self.said.append, limit_s)

    def do(self, *lines: str) -> list[str]:
        """Output of the last command."""
        for line in lines:
            self.said.clear()
            self.debugger.do(line)
        return self.said


@pytest.fixture
def source(tmp_path: Path) -> Path:
    file = tmp_path / "count.I01"
    file.write_text(SOURCE)
    return file


@pytest.fixture
def session(source: Path) -> Session:
    return Session(listing.of_source(source), PortBench(SOURCE, is_enabled=True))


def test_to_a_breakpoint_and_on(session: Session) -> None:
    assert session.do("break 11") == ["breakpoint at SUB, line 11: V2 == COUNT * 2"]
    assert session.do("run") == ["paused at SUB, line 11: V2 == COUNT * 2"]
    assert session.do("where") == ["SUB, line 11: V2 == COUNT * 2", "returns to MAIN, line 7: WAIT 0.005"]
    session.do("set COUNT=41")
    assert session.do("continue") == ["paused at SUB, line 11: V2 == COUNT * 2"]
    assert session.do("print count V2 v1") == ["COUNT (V1) = 42", "V2 = 82", "V1 = 42"]


def test_a_line_without_an_instruction_means_the_next_and_a_routine_its_first(session: Session) -> None:
    assert session.do("b 3") == ["breakpoint at MAIN, line 5: COUNT += 1 ; one more"]
    assert session.do("b deep 12")[1:] == [
        "breakpoint at SUB, line 12: CALL DEEP",
        "breakpoint at DEEP, line 15: V3 += 1",
    ]
    assert session.do("delete 12") == ["2 breakpoints left"]
    assert session.do("delete") == ["0 breakpoints left"]
    assert session.do("break") == ["no breakpoints"]


def test_steps_into_and_over_subprograms(session: Session) -> None:
    session.do("break 5", "run", "delete")
    assert session.do("step") == ["paused at MAIN, line 6: CALL SUB"]
    assert session.do("step") == ["paused at SUB, line 11: V2 == COUNT * 2"]
    assert session.do("next") == ["paused at SUB, line 12: CALL DEEP"]
    assert session.do("next") == ["paused at SUB, line 13: END"]
    assert session.do("n 2")[-1].startswith("paused at MAIN, line ")
    assert session.card.breakpoints() == []


def test_next_over_a_call_stops_at_a_breakpoint_in_it(session: Session) -> None:
    session.do("break 6", "run", "break 15")
    assert session.do("next") == ["paused at DEEP, line 15: V3 += 1"]
    assert session.card.breakpoints() == [6, 15]


def test_a_step_that_stays_says_why(session: Session) -> None:
    session.do("break 7", "run", "set V9=0")
    session.do("step")
    session.bench.run_for(20)
    assert session.do("step")[-1].startswith("paused at MAIN, line ")


def test_list_marks_breakpoints_and_the_place(session: Session) -> None:
    session.do("break 11", "run")
    shown = session.do("list")
    assert ">*   11      V2 == COUNT * 2" in shown
    assert "      5      COUNT += 1 ; one more" not in shown
    assert "      6      CALL SUB" in shown
    assert session.do("list MAIN")[0] == "      1  COUNT EQU V1"


def test_without_a_source_the_object_is_shown() -> None:
    bench = PortBench(SOURCE, is_enabled=True)
    session = Session(listing.of_object(client(bench).upload()), bench)
    assert session.do("b SUB") == ["breakpoint at SUB, line 11: V2 == V1 * 2"]
    with pytest.raises(ValueError, match="not a value of the card"):
        session.do("print COUNT")


def test_a_source_is_known_from_another_program(source: Path) -> None:
    found = listing.of_source(source)
    assert found.is_of(client(PortBench(SOURCE)).upload())
    assert not found.is_of(client(PortBench("V1 == 1")).upload())


def test_a_program_that_ends_or_fails_is_shown_at_its_line(session: Session) -> None:
    session.do("set V9=1")
    assert session.do("run")[0] == "ended at MAIN, line 9: END"
    assert session.do("state")[0].startswith("STOPPED: ")
    failing = "BEG M\nWAIT 0.01\nCALL R\nEND\nBEG R\nCALL R\nEND"
    bench = PortBench(failing, is_enabled=True)
    other = Session(listing.of_object(client(bench).upload()), bench)
    assert other.do("state")[1:] == [
        "error 112: calls are nested more than 10 deep",
        "warning 204: memory was not initialised",
    ] or (other.do("state")[1:] == ["error 112: calls are nested more than 10 deep"])


@pytest.mark.long
def test_a_program_that_does_not_stop_is_reported(session: Session) -> None:
    with pytest.raises(NotStoppedError, match=r"still runs after 0.5 s\n`pause`"):
        session.do("run 0.5")
    assert session.do("pause")[0].startswith("paused at ")


def test_quit_takes_breakpoints_away_and_leaves_the_program_running(session: Session) -> None:
    session.do("break 5", "run")
    assert session.do("quit") == ["the program continues"]
    assert session.debugger.is_over
    assert (session.card.breakpoints(), session.card.condition().program) == ([], 2)


def test_leave_leaves_everything(session: Session) -> None:
    session.do("break 5", "run", "leave")
    assert session.debugger.is_over
    assert (session.card.breakpoints(), session.card.condition().program) == ([5], 3)


def test_stop_and_reset(session: Session) -> None:
    assert session.do("stop")[0].startswith("STOPPED: ")
    assert session.do(["run 0.1", " "][0] if False else "reset")[0].startswith("RESET_COMMAND: ")
    with pytest.raises(ValueError, match="is not paused"):
        session.do("continue")
    with pytest.raises(RefusedByCardError):
        session.do("step")


@pytest.mark.parametrize(
    ("line", "remedy"),
    [
        ("frobnicate", "`help` lists the commands"),
        ("st", "'st' is ambiguous: step or state or stop"),
        ("break 99", "expected a line up to 16"),
        ("break NOWHERE", "one of MAIN, SUB, DEEP"),
        ("delete 5", "`break` lists them"),
        ("print", "expected V1"),
        ("print V2000", "1 to 1000"),
        ("set V1", "V1=VALUE"),
        ("set V1=x", "expected -999999.999 to"),
        ("set F1=2", "0 or 1"),
        ("step x", "1 to 1000"),
        ("run soon", "a number of seconds"),
        ("where now", "`help` lists the commands"),
    ],
)
def test_mistakes_are_reported_with_what_was_expected(session: Session, line: str, remedy: str) -> None:
    with pytest.raises(ValueError, match=re.escape(remedy)):
        session.do(line)


def test_help_has_every_command(session: Session) -> None:
    said = "\n".join(session.do("help"))
    assert all(word in said for word in session.debugger._acts)
    assert "To begin" in said
