"""`fieldrig debug` with a program of the MAx-4 in virtual time: words, places, steps, values, traces."""

import io
import os
import signal
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
import typer
from debug_session import DebugSession
from hypothesis import given
from hypothesis import strategies as st
from plc_bench import PlcBench, task_of
from program_traces import RigTraces

from fieldrig_devices.languages.debugging.debugger_words import WORDS
from fieldrig_devices.languages.debugging.prompt import NotStoppedError, converse
from fieldrig_devices.languages.debugging.tracing import wanted_of
from fieldrig_devices.languages.debugging.values import words_of

TEXT = """\
FUNCTION Twice : INT
VAR_INPUT x : INT; END_VAR
Twice := x * 2;
END_FUNCTION
PROGRAM Main
VAR a, b : INT; on : BOOL; s : STRING; ramp : ARRAY[0..2] OF REAL; END_VAR

a := a + 1;
b := Twice(a);
on := a > 100;
END_PROGRAM
""" + task_of("Main")
IN_FUNCTION, FIRST, CALL, LAST = 3, 8, 9, 10


class Session(DebugSession):
    def __init__(self, folder: Path) -> None:
        self.bench = PlcBench(folder, TEXT).run(100)
        self.questions: list[str] = []
        self.traces = RigTraces(self.bench.rig, "max4")
        super().__init__(self._ask, self.bench.run)

    def _ask(self, message: Any) -> dict[str, Any]:
        self.questions.append(message["command"])
        return self.traces(message)


@pytest.fixture
def session(tmp_path: Path) -> Session:
    return Session(tmp_path)


def test_to_a_breakpoint_and_on_by_steps(session: Session) -> None:
    assert session.do("break 7") == [f"breakpoint at plc.st:{FIRST}: a := a + 1;"], "the next line with an instruction"
    session.bench.run(20)
    session.debugger.show_place()
    assert session.said[-1] == f"T paused at Main, plc.st:{FIRST}: a := a + 1;"
    assert session.do("set Main.a=40") == ["Main.a = 40"]
    assert session.do("next", "print a b") == ["Main.a = 41", f"Main.b = {session.bench.value('Main.b')}"]
    assert session.do("step") == [f"T paused at Twice, plc.st:{IN_FUNCTION}: Twice := x * 2;"]
    assert session.do("where")[1] == f"called at Main, plc.st:{CALL}: b := Twice(a);"
    assert session.do("print x x*10+1") == ["x = 41", "x*10+1 = 411"]
    assert session.do("locals")[1] == "x = 41"
    assert "Main.a = 41" in session.do("locals 1")
    assert session.do("out") == [f"T paused at Main, plc.st:{CALL}: b := Twice(a);"], "the result is not assigned yet"
    assert session.do("next") == [f"T paused at Main, plc.st:{LAST}: on := a > 100;"]
    assert session.do("print Main.b") == ["Main.b = 82"]
    assert session.do("continue", "p a") == ["Main.a = 41"], "it has stopped in the next cycle"


def test_a_condition(session: Session) -> None:
    session.do("set Main.a=0", f"break plc.st:{CALL} if a = 20")
    assert session.do("break") == [f"breakpoint at plc.st:{CALL}: b := Twice(a); if a = 20"]
    session.bench.run(400)
    assert session.do("print Main.a") == ["Main.a = 20"]
    assert session.do("delete 9") == ["0 breakpoints left"]
    assert session.do("continue") == ["the program is running"], "without a breakpoint nothing is waited for"


@pytest.mark.parametrize("word", ["run", "continue", "continue 5"])
def test_a_program_that_runs_is_waited_for(session: Session, word: str) -> None:
    session.do("set Main.a=0", f"break {CALL} if a = 20")
    session.questions.clear()
    assert session.do(word, "print a") == ["Main.a = 20"]
    assert not {"start", "continue"} & set(session.questions)


def test_the_source_around_a_line(session: Session) -> None:
    session.do(f"break {CALL}")
    session.bench.run(20)
    listed = session.do("list")
    assert (listed[0], listed[5]) == ("      4  END_FUNCTION", f">*{CALL:5}  b := Twice(a);")
    assert session.do("list 1")[0] == "      1  FUNCTION Twice : INT"


def test_values_are_printed_written_and_forced(session: Session) -> None:
    assert session.do("print") == ["Main: Main"]
    assert [line.partition(" = ")[0] for line in session.do("print Main.ramp")] == [
        "Main.ramp[0]",
        "Main.ramp[1]",
        "Main.ramp[2]",
    ]
    assert session.do("set Main.s='two words' Main.a=16#10") == ["Main.s = 'two words'", "Main.a = 16"]
    assert session.do("force Main.a=7") == ["Main.a = 7 (forced)"]
    session.bench.run(50)
    assert session.do("forced") == ["Main.a = 7 (forced)"]
    assert session.do("release") == ["Main.a = 7"]
    assert session.do("forced") == session.do("release") == ["no value is forced"]


def test_a_trace_as_a_table(session: Session) -> None:
    session.do("set Main.a=0")
    lines = session.do("trace Main.a Main.on every 5 depth 4 trigger Main.on rising before 1")
    assert lines[0].split() == ["time/s", "Main.a", "Main.on"]
    rows = [line.split() for line in lines[1:]]
    assert [row[2] for row in rows] == ["FALSE", "TRUE", "TRUE", "TRUE"]
    assert [int(row[1]) for row in rows] == [int(rows[0][1]) + 2 * place for place in range(4)], "20 ms are two cycles"
    assert float(rows[1][0]) - float(rows[0][0]) == pytest.approx(0.02)


def test_a_trace_as_csv(session: Session, tmp_path: Path) -> None:
    assert session.do("trace Main.a depth 3 csv")[0] == "time/s,Main.a"
    file = tmp_path / "a.csv"
    assert session.do(f"trace Main.a depth 3 csv {file}") == [f"{file}: 3 samples"]
    assert len(file.read_text().splitlines()) == 4
    assert session.do(f"trace Main.a depth 1 csv {file}") == [f"{file}: 1 sample"]
    assert not session.traces.recordings, "a trace ends its recording"


@pytest.mark.long
def test_a_trace_without_its_trigger_ends_at_the_limit_and_by_ctrl_c(session: Session) -> None:
    with pytest.raises(NotStoppedError, match="the trigger has not come"):
        session.do("trace Main.a trigger Main.a falling -5")
    session.interrupts_after = 3
    assert len(session.do("trace Main.a depth 1000")) > 2


def test_ctrl_c_pauses_a_program_that_is_waited_for(session: Session) -> None:
    session.do("stop", f"break {FIRST} if a = -1")
    session.interrupts_after = 4
    said = session.do("run")
    assert said[-1].startswith("T paused")
    with pytest.raises(NotStoppedError, match=r"the program still runs after 0\.1 s"):
        session.do("continue 0.1")


def test_leaving_removes_breakpoints_and_lets_the_program_go_on(session: Session) -> None:
    session.do(f"break {FIRST}")
    session.bench.run(20)
    assert session.do("quit") == ["0 breakpoints left", "the program continues"]
    a = session.bench.value("Main.a")
    assert session.bench.run(100).value("Main.a") != a
    assert session.debugger.is_over


def test_a_reset_waits_for_a_device_that_starts_again() -> None:
    """A PAM has its application again when it has booted."""
    states = iter(["running", "none", "none", "held", "held"])
    asked = []

    def ask(question: Any) -> dict[str, Any]:
        asked.append(question["command"])
        return {"state": next(states), "threads": [{"state": "held"}]} if question["command"] == "state" else {}

    session = DebugSession(ask, lambda _: None)
    assert session.do("reset") == ["the program is held"]
    assert asked[:4] == ["state", "reset", "state", "state"]


def test_state_threads_and_reset(session: Session) -> None:
    assert session.do("state")[0].startswith("IEC 61131-3: running at 0.")
    assert session.do("threads 1") == [">  1  T  running"]
    assert session.do("reset cold") == ["the program is held"]
    assert session.do("start") == ["the program is running"]
    assert session.do("reset origin") == ["there is no program"]


def test_a_fault_is_shown_with_its_text(session: Session, tmp_path: Path) -> None:
    text = TEXT.replace("a := a + 1;", "a := 1 / (b - b);")
    for command in ({"command": "part", "file": "plc.st", "text": text, "is_first": True}, {"command": "download"}):
        session.bench.max4.answer("debug", command)
    session.bench.run(500)
    session.do("start 1")
    assert session.said[0].startswith(f"T failed at Main, plc.st:{FIRST}")
    assert "division" in session.said[1]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("dance", "'dance' is not a command"),
        ("s 0", "'0' is not a count"),
        ("continue", "the program is not paused"),
        ("break x", "'x' is not a place"),
        ("break other.st:3", r"there is no file 'other.st'\nexpected plc.st"),
        ("break 900", r"there is no instruction at or after plc.st:900"),
        ("break 8 when a", "unexpected 'when a'"),
        ("delete 8", "there is no such breakpoint"),
        ("print Main.z", "Main.z is not a variable"),
        ("set Main.a", "'Main.a' has no value"),
        ("set Main.a=x", "Main.a: expected a constant"),
        ("threads 9", "'9' is not a task"),
        ("reset hot", "kind: expected warm, cold, origin"),
        ("trace", "nothing to record"),
        ("trace Main.a every x", "expected a number after every, got 'x'"),
        ("trace Main.a before 3", "`before` needs a trigger"),
        ("run soon", "'soon' is not a time"),
    ],
)
def test_wrong_commands_say_what_was_expected(session: Session, line: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        session.do(line)
    assert session.bench.value("Main.a") != 0


@pytest.mark.long
def test_help_has_every_command(session: Session) -> None:
    text = "\n".join(session.do("help"))
    for name in session.debugger._acts:
        assert WORDS.find(name) == name
        assert f"  {name}" in text


@pytest.mark.long
@given(st.lists(st.sampled_from(["every", "depth", "trigger", "before", "csv", "5", "x", "rising", "2.5"]), max_size=8))
def test_any_words_of_a_trace_are_read_or_refused(words: list[str]) -> None:
    try:
        found = wanted_of(words)
    except ValueError:
        return
    assert found.names
    assert found.question()["command"] == "record"


@pytest.mark.long
@given(st.lists(st.from_regex(r"[a-z=0-9]+('[a-z ]*')?", fullmatch=True)))
def test_words_are_split_at_blanks_outside_of_texts(words: list[str]) -> None:
    assert words_of("  ".join(words)) == words


@pytest.fixture
def no_handlers() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def run_script(session: Session, monkeypatch: pytest.MonkeyPatch, *lines: str) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("\n".join(lines)))
    converse(session.debugger, "", (NotStoppedError,))


@pytest.mark.usefixtures("no_handlers")
@pytest.mark.parametrize(
    ("last", "end"),
    [
        ("print nothing_of_this_name", typer.Exit),
        ("continue 0.1", typer.Exit),
        ("interrupt", KeyboardInterrupt),
        ("signal", SystemExit),
        ("where", None),
    ],
)
def test_every_end_removes_breakpoints_and_lets_the_program_go_on(
    session: Session, monkeypatch: pytest.MonkeyPatch, last: str, end: type[BaseException] | None
) -> None:
    acts = session.debugger._acts
    monkeypatch.setitem(acts, "where", acts["where"])
    if last == "interrupt":
        monkeypatch.setitem(acts, "where", lambda _: (_ for _ in ()).throw(KeyboardInterrupt))
    elif last == "signal":
        monkeypatch.setitem(acts, "where", lambda _: os.kill(os.getpid(), signal.SIGHUP))
    word = "where" if last in ("interrupt", "signal") else last
    condition = "" if last == "where" else f" if a = {'-1' if last.startswith('continue') else '20'}"
    with pytest.raises(end) if end is not None else nullcontext():
        run_script(session, monkeypatch, f"break {CALL}{condition}", *(() if condition else ["run"]), word)
    answer = session.bench.max4.answer
    assert answer("debug", {"command": "breakpoints"}) == {"breakpoints": []}
    assert answer("debug", {"command": "state"})["state"] == "running"
    a = session.bench.value("Main.a")
    assert session.bench.run(100).value("Main.a") != a


def test_a_session_shows_what_another_one_has_left(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    session.do("force Main.b=7", f"break {CALL} if a > 5", "run", "leave")
    other = DebugSession(session._ask, session.bench.run)
    other.debugger.begin()
    shown = f"plc.st:{CALL}: b := Twice(a);"
    assert other.said == [
        f"T paused at Main, {shown}",
        f"breakpoint at {shown} if a > 5",
        "Main.b = 7 (forced)",
    ]
    assert other.do(f"delete {CALL}") == ["0 breakpoints left"]
    assert session.do("break") == ["no breakpoints"]
    assert other.do("quit") == ["1 forced value left, until `release`", "the program continues"]


def test_the_words_of_help_stand_in_columns(session: Session) -> None:
    lines = [line for line in session.do("help") if line.startswith("  ")]
    beginnings = {
        line.index(about) for line in lines for about in ("start the program;", "go back to the last") if about in line
    }
    assert len(beginnings) == 1, lines


def test_a_breakpoint_goes_to_the_next_instruction_however_far_it_is(tmp_path: Path) -> None:
    far = TEXT.replace("\na := a + 1;", "\n" * 200 + "a := a + 1;")
    bench = PlcBench(tmp_path, far).run(100)
    session = DebugSession(lambda message: bench.max4.answer("debug", message), bench.run)
    assert session.do("break 7") == [f"breakpoint at plc.st:{FIRST + 199}: a := a + 1;"]
    with pytest.raises(ValueError, match="there is no instruction at or after"):
        session.do("break 500")
