"""The debugging service of an application: breakpoints, steps, values, forcing, and traces."""

import pytest
from pam_bench import OBJECTS, sequence

from fieldrig.clock import VirtualClock
from fieldrig.device import Value
from fieldrig.loop.background import VirtualBackground
from fieldrig_devices.languages.debugging.debuggee import ProgramState, Reset, Step
from fieldrig_devices.languages.debugging.service import DebugService
from fieldrig_devices.pam.runtime.compiler import Compiled, compile_application
from fieldrig_devices.pam.runtime.machine_debuggee import MachineDebuggee
from fieldrig_devices.pam.runtime.solo import Solo

MS = 1_000_000
PROGRAM = (
    OBJECTS
    + """ROUTINES RGR_a;
ROUTINE RTN_Add WITH a;
w <- w + a;
END_ROUTINE
END_ROUTINES
ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS
ON_EVENT SBI_b ACTION
at <- at + 1;
CALL RTN_Add WITH 100;
END_ACTION
END_ACTIONS
"""
    + sequence("LOOP\nn <- n + 1;\nCALL RTN_Add WITH n;\nWAIT_TIME 10;\nEND_LOOP n = 50;")
)
LINES = PROGRAM.splitlines()


def line(text: str) -> int:
    return LINES.index(text) + 1


class Session:
    """A debugging service with its application, after the sequence has been started."""

    def __init__(self) -> None:
        self.solo = Solo(compile_application(PROGRAM, "a.pam"))
        self.service = DebugService(VirtualClock(), self.solo)
        self.solo.start()
        self.solo.write("SBI_a", "true")
        self._now_ms = 0

    def run(self, milliseconds: int = 1) -> None:
        self._now_ms += milliseconds
        self.solo.run_until(self._now_ms * MS)

    def breakpoints(self, *wanted: int, condition: str = "") -> list[int]:
        places = [{"line": number, "condition": condition} for number in wanted]
        answer = self.service.answer({"command": "breakpoints", "file": "a.pam", "breakpoints": places})
        found: list[int] = answer["lines"]
        return found

    @property
    def stops(self) -> int:
        count: int = self.service.answer({"command": "state"})["stops"]
        return count

    def value(self, name: str) -> object:
        return self.solo.evaluate(name).value


@pytest.fixture
def session() -> Session:
    return Session()


def test_a_breakpoint_inside_a_statement_is_where_it_begins() -> None:
    body = ["n <- 1 +", "  2;", "IF n = 3", "THEN", "  n <-", "    4;", "END_IF", "n <- 5;"]
    text = OBJECTS + sequence("\n".join(body))
    first = text.splitlines().index(body[0]) + 1
    service = DebugService(VirtualClock(), Solo(compile_application(text, "a.pam")))
    places = [{"line": first + place} for place in range(len(body))]
    question = {"command": "breakpoints", "file": "a.pam", "breakpoints": places, "move": True}
    found = service.answer(question)["places"]
    assert [line - first + 1 for line in found] == [1, 1, 3, 3, 5, 5, 8, 8]


def test_a_breakpoint_stops_one_task_and_the_others_go_on(session: Session) -> None:
    assert session.breakpoints(line("n <- n + 1;"), 1) == [line("n <- n + 1;")]
    session.run(5)
    assert (session.stops, session.solo.state, session.value("n")) == (1, ProgramState.PAUSED, 0)
    (frame,) = session.solo.stack(1)
    assert (frame.routine, frame.file, frame.line) == ("TSK_a.SEQ_a", "a.pam", line("n <- n + 1;"))
    session.solo.write("SBI_b", "true")
    session.run(3)
    assert session.value("at") == 1  # the action has run meanwhile
    session.solo.go_on()
    session.run(15)
    assert (session.stops, session.value("n")) == (2, 1)


def test_a_conditional_breakpoint(session: Session) -> None:
    session.breakpoints(line("WAIT_TIME 10;"), condition="n = 4 + 1")
    session.run(100)
    assert (session.stops, session.value("n"), session.value("w")) == (1, 5, 15)


def test_steps_into_over_and_out(session: Session) -> None:
    session.breakpoints(line("CALL RTN_Add WITH n;"))
    session.run(5)

    def step(kind: Step) -> list[int]:
        session.solo.step(1, kind)
        session.run(30)
        return [frame.line for frame in session.solo.stack(1)]

    assert step(Step.INTO) == [line("w <- w + a;"), line("CALL RTN_Add WITH n;")]
    (formal,) = session.solo.variables("@1:0")
    assert (formal.name, formal.type, formal.value, session.solo.evaluate("a", 1).value) == ("a", "integer", 1, 1)
    assert step(Step.OUT) == [line("WAIT_TIME 10;")]
    assert step(Step.OVER) == [line("END_LOOP n = 50;")]  # after the time
    assert step(Step.OVER) == [line("n <- n + 1;")]
    assert step(Step.OVER) == [line("CALL RTN_Add WITH n;")]
    assert step(Step.OVER) == [line("WAIT_TIME 10;")]
    assert session.value("w") == 3


def test_a_breakpoint_in_an_action_and_in_a_routine(session: Session) -> None:
    session.breakpoints(line("w <- w + a;"))
    session.solo.write("SBI_a", "false")
    session.solo.write("SBI_b", "1")
    session.solo.runtime.tasks[0].events[0][0].take()
    session.run(5)
    assert [frame.routine for frame in session.solo.stack(2)] == ["RTN_Add", "ACT_a.1"]
    assert session.solo.threads()[1].state is ProgramState.PAUSED
    session.solo.go_on()
    session.run(5)
    assert (session.value("w"), session.solo.state) == (100, ProgramState.RUNNING)


def test_a_pause_holds_all_programs(session: Session) -> None:
    session.run(5)
    session.solo.pause()
    before = session.value("n")
    session.run(100)
    assert (session.value("n"), session.solo.state) == (before, ProgramState.PAUSED)
    session.solo.go_on()
    session.run(100)
    assert session.value("n") != before


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("n", 0),
        ("we[2]", 0),
        ("n + 2 * 3", 6),
        ("fe[all+] + SBI_a", True),
        ("x ? sqrt", 0.0),
        ("AXI_Each[i] ? ready", True),
    ],
)
def test_values_and_expressions(session: Session, text: str, value: object) -> None:
    assert session.solo.evaluate(text).value == value


@pytest.mark.parametrize(
    "text", ["nothing", "we[4]", "n +", "n ) 2", "1 / w", "f + 2", "SBI_a <- 1", "x" * 2000, "AXI_Each", "", "(" * 400]
)
def test_an_expression_without_a_value_is_refused(session: Session, text: str) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        session.solo.evaluate(text)


def test_writing_and_forcing(session: Session) -> None:
    solo = session.solo
    for path, value in [("w", "#10"), ("we[3]", "-7"), ("x", "2.5"), ("f", "true"), ("SBO_a", "1"), ("SBI_c", "1")]:
        solo.write(path, value)
    assert [session.value(path) for path in ("w", "we[3]", "x", "f", "SBO_a", "SBI_c")] == [
        16,
        -7,
        2.5,
        True,
        True,
        True,
    ]
    solo.force("w", 5)
    session.run(100)
    assert session.value("w") == 5  # although the sequence adds to it
    assert [(one.path, one.is_forced) for one in solo.forced()] == [("w", True)]
    solo.force("h", "true")
    session.run()
    assert session.value("h") is True
    solo.force("w", None)
    assert [one.path for one in solo.forced()] == ["h"]
    refused: list[tuple[str, Value]] = [
        ("w", "x"),
        ("w", 2**31),
        ("f", 3),
        ("we", 1),
        ("AXI_Each", 1),
        ("x", "1" * 400 + ".0"),
    ]
    for path, wrong in refused:
        with pytest.raises(ValueError, match=r"\w"):
            solo.write(path, wrong)
    for path in ("SBI_a", "we", "none"):
        with pytest.raises(ValueError, match=r"\w"):
            solo.force(path, 1)


def test_variables_are_listed_with_their_items(session: Session) -> None:
    roots = {variable.path: variable for variable in session.solo.variables("")}
    assert (roots["we"].value, roots["we"].type, roots["n"].value) == (None, "WORD_VAR [3]", 0)
    assert [variable.path for variable in session.solo.variables("we")] == ["we[1]", "we[2]", "we[3]"]
    assert "AXI_Each" not in roots
    assert roots["SBI_a"].value is True


def test_stop_start_and_reset(session: Session) -> None:
    session.run(50)
    session.solo.stop()
    before = session.value("n")
    session.run(50)
    assert (session.value("n"), session.solo.state) == (before, ProgramState.HELD)
    session.solo.reset(Reset.COLD)
    assert (session.value("n"), session.solo.state) == (0, ProgramState.HELD)
    session.solo.start()
    session.solo.write("SBI_a", "1")
    session.run(25)
    assert session.value("n") == 3


def test_a_fault_is_shown_with_its_place(session: Session) -> None:
    session.solo.write("w", 2**31 - 1)
    session.run(5)
    assert session.solo.state is ProgramState.FAILED
    (failed,) = [thread for thread in session.solo.threads() if thread.state is ProgramState.FAILED]
    assert failed.about.startswith("02..FFF2: an integer overflow in RTN_Add (a.pam:")
    assert [frame.routine for frame in session.solo.stack(failed.number)] == ["RTN_Add", "TSK_a.SEQ_a"]
    assert session.solo.events == ["02..FFF2 " + failed.about.removeprefix("02..FFF2: ")]


# ---- the application of a PAM in a rig


class Rig:
    """A PAM with a debuggee, whose application can be replaced."""

    def __init__(self, *, ignores_case: bool = False) -> None:
        self.clock = VirtualClock()
        self.solo = Solo(compile_application(PROGRAM, "a.pam"))
        self.resets = 0
        background = VirtualBackground(self.clock)
        self.debuggee = MachineDebuggee(
            background, lambda: self.solo.runtime, self.reset, self.load, ignores_case=ignores_case
        )
        self.service = DebugService(self.clock, self.debuggee)
        self.debuggee.attach(self.solo.runtime)

    def reset(self) -> None:
        self.resets += 1
        self.solo.reset(Reset.COLD)
        self.debuggee.attach(self.solo.runtime)

    def load(self, compiled: Compiled) -> None:
        self.solo = Solo(compiled)
        self.debuggee.attach(self.solo.runtime)


def test_a_download_replaces_the_application_and_keeps_breakpoints() -> None:
    rig = Rig()
    places = [{"line": line("n <- n + 1;"), "condition": ""}]
    rig.service.answer({"command": "breakpoints", "file": "a.pam", "breakpoints": places})
    rig.debuggee.download({"a.pam": "// new\n" + PROGRAM}, is_online=False)
    assert rig.debuggee.progress == "compiling 0 %"
    rig.clock.advance_to(1000 * MS)
    assert (rig.debuggee.progress, rig.debuggee.problem) == ("", "")
    answer = rig.service.answer({"command": "breakpoints", "file": "a.pam"})
    assert answer["lines"] == [line("n <- n + 1;") + 1]


def test_a_download_with_mistakes_leaves_the_application() -> None:
    rig = Rig()
    before = rig.solo.runtime
    rig.debuggee.download({"a.pam": PROGRAM.replace("n <- n + 1;", "m <- 1;")}, is_online=False)
    rig.clock.advance_to(1000 * MS)
    assert rig.debuggee.problem.startswith(f"a.pam:{line('n <- n + 1;')}:1: m is not declared here")
    assert rig.solo.runtime is before


@pytest.mark.parametrize(("ignores_case", "is_loaded"), [(False, False), (True, True)])
def test_a_download_is_compiled_as_the_application_was(ignores_case: bool, is_loaded: bool) -> None:
    rig = Rig(ignores_case=ignores_case)
    before = rig.solo.runtime
    rig.debuggee.download({"a.pam": PROGRAM.replace("n <- n + 1;", "N <- n + 1;")}, is_online=False)
    rig.clock.advance_to(1000 * MS)
    assert (rig.solo.runtime is not before) is is_loaded


def test_start_stop_and_reset_of_a_machine() -> None:
    rig = Rig()
    states = []
    for order in (rig.debuggee.stop, rig.debuggee.start):
        order()
        states.append(rig.debuggee.state)
    assert states == [ProgramState.PAUSED, ProgramState.RUNNING]
    rig.debuggee.reset(Reset.WARM)
    assert rig.resets == 1
    with pytest.raises(ValueError, match="expected a download"):
        rig.debuggee.reset(Reset.ORIGIN)
    with pytest.raises(ValueError, match="expected the source file"):
        rig.debuggee.download({}, is_online=False)
    with pytest.raises(ValueError, match="expected a download"):
        rig.debuggee.download({"a.pam": PROGRAM}, is_online=True)
