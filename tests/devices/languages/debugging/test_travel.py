"""Back in time with the debugger: by lines, to breakpoints, to the last change of a variable, and with the adapter."""

import os
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from debug_editor import Editor
from debug_session import DebugSession
from plc_bench import task_of
from shipped import in_virtual_time
from travelling import TravellingRig, travelling

from fieldrig import MS, Rig, RigError, S, from_dict
from fieldrig.config.rig_file import RigConfig
from fieldrig_devices.languages.debugging.adapter import Adapter
from fieldrig_devices.languages.debugging.travel import Travel

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork"),
]

TEXT = """\
FUNCTION Twice : INT
VAR_INPUT x : INT; END_VAR
Twice := x * 2;
END_FUNCTION
PROGRAM Main
VAR a, b, top : INT; due : TIME; END_VAR
a := a + 1;
b := Twice(a);
IF a = 30 THEN
  top := a;
  due := T#5s;
END_IF
END_PROGRAM
""" + task_of("Main")
IN_TWICE, FIRST, CALL, IF, TOP, DUE = 3, 7, 8, 9, 10, 11


def config_of(folder: Path) -> RigConfig:
    (folder / "plc.st").write_text(TEXT)
    controller = {"kind": "max4", "program": "plc.st"}
    return from_dict({"time": "virtual", "buses": {}, "devices": {"plc": controller}}, folder)


class Session(DebugSession):
    def __init__(self, rig: TravellingRig) -> None:
        self.rig = rig
        super().__init__(rig.ask, self._run_ms, travel=Travel("plc", rig.ask, rig.ask_rig))

    def _run_ms(self, ms: int) -> None:
        assert self.rig.is_running, "a rig that was taken back stands until the debugger lets it run"
        self.rig.run_for(ms * MS)

    def value(self, name: str) -> str:
        [line] = self.do(f"print {name}")
        return line.partition(" = ")[2]


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    """A program that has counted to some 60 in its task of 10 ms."""
    with travelling(config_of(tmp_path), "plc") as rig:
        made = Session(rig)
        rig.run_until(S)
        made.do("run")
        rig.run_until(1_600 * MS)
        yield made


def place(session: Session) -> int:
    """Return the line of the program that is next."""
    return int(session.do("where")[0].partition(":")[2].partition(":")[0])


def test_back_by_lines_and_forward_again(session: Session) -> None:
    session.do("break 9", "continue")
    count = int(session.value("Main.a"))
    assert session.do("back") == [f"T paused at Main, plc.st:{CALL}: b := Twice(a);"]
    assert int(session.value("Main.b")) == 2 * (count - 1)
    assert session.do("back 2")[0].startswith("T paused at Main, plc.st:")
    assert place(session) == IF, "of the cycle before, which did not run the lines in the IF"
    assert int(session.value("Main.a")) == count - 1
    assert session.do("break") == [f"breakpoint at plc.st:{IF}: IF a = 30 THEN"], "it belongs to the session"
    session.do("continue")
    assert (place(session), int(session.value("Main.a"))) == (IF, count)


def test_back_from_within_a_call_and_into_none(session: Session) -> None:
    session.do(f"break {IN_TWICE}", "continue")
    assert place(session) == IN_TWICE
    session.do("back")
    assert place(session) == CALL
    session.do("step")
    assert place(session) == IN_TWICE


def test_a_step_at_the_end_of_a_cycle_goes_to_the_next_cycle(session: Session) -> None:
    session.do(f"break {IF}", "continue", "delete", "next")
    assert place(session) == FIRST
    session.do("next", "next", "out")
    assert place(session) == FIRST


def test_back_of_a_task_between_two_cycles_is_to_the_line_that_ran_last(session: Session) -> None:
    session.do("pause")
    assert session.do("where") == ["the task is between two cycles"]
    count = session.value("Main.a")
    assert session.do("back") == [f"T paused at Main, plc.st:{IF}: IF a = 30 THEN"]
    assert session.value("Main.a") == count


def test_back_to_a_line_that_ran_long_ago(session: Session) -> None:
    session.do("pause")
    assert session.value("Main.top") == "30"
    session.do(f"back to {TOP}")
    assert (place(session), session.value("Main.a"), session.value("Main.top")) == (TOP, "30", "0")
    with pytest.raises(
        ValueError, match=r"plc\.st:10 has not run before this: the past that the rig remembers begins at 0 s"
    ):
        session.do(f"back to {TOP}")
    session.do("next")
    assert session.value("Main.top") == "30"


def test_a_way_back_over_an_earlier_one_stops_where_it_should(session: Session) -> None:
    """The end of the first way back is repeated on the second one, whose stop it has to leave alone."""
    session.do(f"break {IF}", "continue", "continue", "reverse-continue", "delete", "watch Main.b")
    session.do("continue", "continue")
    after = int(session.value("Main.b"))
    for back in (1, 2):
        session.do("reverse-continue")
        assert (place(session), int(session.value("Main.b"))) == (CALL, after - 2 * back)


def test_reverse_continue_goes_from_breakpoint_to_breakpoint(session: Session) -> None:
    session.do(f"break {CALL} if a = 20", f"break {TOP}")
    session.do("reverse-continue")
    assert (place(session), session.value("Main.a")) == (TOP, "30")
    session.do("rc")
    assert (place(session), session.value("Main.a")) == (CALL, "20")
    with pytest.raises(ValueError, match="there is no breakpoint and no change before this"):
        session.do("rc")
    session.do("continue")
    assert (place(session), session.value("Main.a")) == (TOP, "30")


def test_a_condition_of_then_does_not_keep_the_program_from_stopping_now(session: Session) -> None:
    session.do(f"break {CALL} if a = 1000")
    session.rig.run_for(300 * MS)
    session.do("delete", f"break {CALL} if a = 70", "rc")
    assert (place(session), session.value("Main.a")) == (CALL, "70")


def test_the_last_change_is_told_and_gone_to(session: Session) -> None:
    assert session.do("last Main.top")[0].startswith("Main.top 0 -> 30 at ")
    assert session.said[0].endswith(f" s by plc.st:{TOP}")
    assert "Main.due T#0ms -> T#5s at" in session.do("last Main.due")[0]
    before_ns = session.rig.now_ns
    assert session.rig.is_running
    assert session.rig.now_ns == before_ns, "telling goes nowhere"
    session.do("watch Main.top", "rc")
    assert (place(session), session.value("Main.top"), session.value("Main.a")) == (TOP, "0", "30")
    session.do("continue")
    assert session.said[1:] == [f"  Main.top 0 -> 30 by plc.st:{TOP}"]
    assert (place(session), session.value("Main.top")) == (DUE, "30")


def test_a_change_from_outside_is_none_of_the_program(session: Session) -> None:
    session.do("set Main.top=77")
    session.rig.run_for(50 * MS)
    told = session.do("last Main.top")[0]
    assert told.startswith("Main.top 30 -> 77 at ")
    assert told.endswith(" from outside of the program")


def test_back_to_a_time_has_every_value_of_then(session: Session) -> None:
    count = session.value("Main.a")
    now_ns = session.rig.now_ns
    session.rig.run_for(700 * MS)
    session.do(f"break {TOP}", f"back {now_ns}ns")
    assert (session.rig.now_ns, session.value("Main.a")) == (now_ns, count)
    assert session.do("break") == [f"breakpoint at plc.st:{TOP}: top := a;"]
    assert not session.rig.is_running
    session.do("quit")
    assert session.rig.is_running


def test_back_to_a_line_without_an_instruction_goes_to_the_next_one_that_has_one(session: Session) -> None:
    session.do("break 8 if a = 1000", "pause", "back to 6")
    assert place(session) == FIRST
    assert session.do("break") == ["breakpoint at plc.st:8: b := Twice(a); if a = 1000"], "none is set for the way"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("back to 99", "there is no instruction at or after plc.st:99"),
        ("back to", "expected `back to LINE`"),
        ("back to 8 if a = 3", "expected `back to LINE`"),
        ("back to none.st:8", "there is no file 'none.st'"),
        ("back 5 s", "unexpected 's'\nexpected `back 5`, `back 12.34s` or `back to LINE`"),
        ("back 5", "no task is paused"),
        ("back 12", "no task is paused"),
        ("rc", "there is nothing to stop at"),
        ("last Main.none", "Main.none is not a variable of the program"),
        ("back 100s", "it is at 1.6"),
        ("last Main", "Main is a group of values"),
    ],
)
def test_what_is_not_possible_is_said_and_changes_nothing(session: Session, line: str, said: str) -> None:
    now_ns = session.rig.now_ns
    with pytest.raises((ValueError, RigError)) as refused:
        session.do(line)
    assert said in str(refused.value)
    assert session.rig.now_ns == now_ns


def test_a_variable_that_has_not_changed_is_said(session: Session) -> None:
    session.do("back 1.1s")
    with pytest.raises(ValueError, match=r"Main\.due has not changed: the past that the rig remembers begins at 0 s"):
        session.do("last Main.due")


def test_a_paused_rig_is_named_as_what_keeps_the_program_from_going_on(session: Session) -> None:
    assert session.do("back 1.2s") == ["the program is running", "the rig is paused at 1.2 s\n  `run` lets it run"]
    session.do("run")
    session.rig.is_running = False
    assert session.do("state")[0] == "IEC 61131-3: running at 1.200 s"
    session.debugger.begin()
    assert session.said[-2:] == ["the program is running", "the rig is paused at 1.2 s\n  `fieldrig run` lets it run"]


@pytest.mark.long
def test_the_way_forward_is_gone_back_line_by_line(session: Session) -> None:
    session.do(f"break {FIRST}", "continue", f"delete {FIRST}")
    seen = [at(session)]
    for _ in range(3):
        session.do("next")
        seen.append(at(session))
    for expected in seen[-2::-1]:
        session.do("back")
        assert at(session) == expected


def at(session: Session) -> tuple[str, ...]:
    return (*session.do("where"), session.value("Main.a"), session.value("Main.b"))


# ---- a look changes nothing

LOOKED_AT = [
    ("conveyor.yaml", "max4", 3 * S),
    ("feeder.yaml", "feeder", 3 * S),
    ("pam-machine.yaml", "pam", 2 * S),
    ("arp-cell.yaml", "line", 3 * S),
]


@pytest.mark.long
@pytest.mark.parametrize(("file", "device", "until_ns"), LOOKED_AT)
def test_a_rig_does_the_same_while_its_program_is_looked_at(file: str, device: str, until_ns: int) -> None:
    found = []
    for is_looked_at in (False, True):
        with Rig(in_virtual_time(file)) as rig:
            rig.trace_hash()
            if file == "arp-cell.yaml":
                rig.set("panel/6200:01", 1)  # Enable, without which the card holds its program
            rig.run_until(until_ns // 2)
            if is_looked_at:
                files = rig.answer(device, "debug", {"command": "files"})["files"]
                places = [{"file": name, "line": line} for name in files for line in range(1, 900)]
                begin = {"command": "probe", "probe": "p", "places": places}
                rig.answer(device, "debug", begin)
            rig.run_until(until_ns)
            found.append(rig.trace_hash())
            if is_looked_at:
                assert rig.answer(device, "debug", {"command": "found", "probe": "p"})["number"] > 0
    assert found[0] == found[1]


@pytest.mark.long
@pytest.mark.parametrize(("file", "device"), [("arp-cell.yaml", "line"), ("pam-machine.yaml", "pam")])
def test_programs_of_cards_and_of_the_pam_go_back_by_lines(file: str, device: str) -> None:
    with travelling(in_virtual_time(file), device) as rig:
        if device == "line":
            rig.journey.set("panel", "6200:01", 1)  # Enable
        rig.run_until(2 * S)
        session = DebugSession(rig.ask, lambda ms: rig.run_for(ms * MS), travel=Travel(device, rig.ask, rig.ask_rig))
        session.do("pause")
        seen = [(rig.now_ns, session.do("where")[0])]
        for _ in range(3):
            session.do("back")
            seen.append((rig.now_ns, session.do("where")[0]))
        assert [now_ns for now_ns, _ in seen] == sorted((now_ns for now_ns, _ in seen), reverse=True)
        assert all(earlier != later for (_, earlier), (_, later) in pairwise(seen))


# ---- the adapter


class TravellingEditor(Editor):
    def __init__(self, rig: TravellingRig) -> None:
        super().__init__()
        self.rig = rig
        self.adapter = Adapter(rig.ask, Travel("plc", rig.ask, rig.ask_rig))

    def stopped(self) -> dict[str, Any]:
        """Let the rig run until the editor hears of a stop, and return that."""
        for _ in range(200):
            for name, body in self.events():
                if name == "stopped":
                    return dict(body)
            self.rig.run_for(5 * MS)
        raise AssertionError("it does not stop")

    def top(self) -> dict[str, Any]:
        """Return the place of the program."""
        frame: dict[str, Any] = self.request("stackTrace", threadId=1)["stackFrames"][0]
        return frame

    def value(self, name: str) -> str:
        return str(self.request("evaluate", expression=name)["result"])


@pytest.fixture
def editor(session: Session) -> TravellingEditor:
    return TravellingEditor(session.rig)


def test_an_editor_steps_back_and_continues_in_reverse(editor: TravellingEditor) -> None:
    answered = editor.request("initialize")
    assert (answered["supportsStepBack"], answered["supportsDataBreakpoints"]) == (True, True)
    editor.request("attach")
    source = {"name": "plc.st"}
    editor.request("setBreakpoints", source=source, breakpoints=[{"line": IF}])
    assert editor.stopped()["reason"] == "breakpoint"
    count = int(editor.value("Main.a"))
    editor.request("stepBack", threadId=1)
    assert editor.events()[0][1]["reason"] == "step"
    assert editor.top()["line"] == CALL
    editor.request("reverseContinue", threadId=1)
    assert editor.events()[0][1]["reason"] == "breakpoint"
    assert (editor.top()["line"], int(editor.value("Main.a"))) == (IF, count - 1)
    editor.request("next", threadId=1)
    assert editor.stopped()["reason"] == "step"
    assert editor.request("disconnect") == {}
    assert editor.rig.ask({"command": "state"})["state"] == "running"
    assert editor.rig.is_running


def test_an_editor_has_data_breakpoints_both_ways(editor: TravellingEditor) -> None:
    editor.request("attach")
    information = editor.request("dataBreakpointInfo", name="Main.b")
    assert (information["dataId"], information["accessTypes"]) == ("Main.b", ["write"])
    assert editor.request("dataBreakpointInfo", name="Main")["dataId"] is None
    assert editor.request("dataBreakpointInfo", name="Main.none")["dataId"] is None
    wanted = [{"dataId": "Main.b", "accessType": "write"}, {"dataId": "Main.none"}]
    assert [each["verified"] for each in editor.request("setDataBreakpoints", breakpoints=wanted)["breakpoints"]] == [
        True,
        False,
    ]
    stopped = editor.stopped()
    count = int(editor.value("Main.b"))
    assert (stopped["reason"], stopped["text"]) == (
        "data breakpoint",
        f"Main.b {count - 2} -> {count} by plc.st:{CALL}",
    )
    assert editor.top()["line"] == IF
    editor.request("reverseContinue", threadId=1)
    assert (editor.top()["line"], int(editor.value("Main.b"))) == (CALL, count - 2)
    editor.request("reverseContinue", threadId=1)
    assert (editor.top()["line"], int(editor.value("Main.b"))) == (CALL, count - 4)
    editor.request("setDataBreakpoints", breakpoints=[])
    editor.request("continue", threadId=1)
    editor.rig.run_for(100 * MS)
    assert editor.rig.ask({"command": "state"})["state"] == "running"


TWO_TASKS = """\
VAR_GLOBAL g : INT; END_VAR
PROGRAM Fast
VAR n : INT; END_VAR
n := n + 1;
END_PROGRAM
PROGRAM Slow
VAR s : INT; END_VAR
s := s + 1;
g := 100 + s;
END_PROGRAM
CONFIGURATION Cell
RESOURCE Main ON Controller
TASK Quick(INTERVAL := T#10ms, PRIORITY := 1);
TASK Calm(INTERVAL := T#100ms, PRIORITY := 5);
PROGRAM F WITH Quick : Fast;
PROGRAM S WITH Calm : Slow;
END_RESOURCE
END_CONFIGURATION
"""
IN_FAST, IN_SLOW = 4, 9


def test_of_two_tasks_that_stand_the_one_that_was_found_is_shown(tmp_path: Path) -> None:
    config = config_of(tmp_path)
    (tmp_path / "plc.st").write_text(TWO_TASKS)
    with travelling(config, "plc") as rig:
        session = Session(rig)
        rig.run_until(S)
        session.do("run")
        rig.run_for(250 * MS)
        session.do(f"break {IN_FAST}", "continue", "delete")
        rig.run_for(150 * MS)  # the slow one runs while the fast one stands
        value = session.value("g")
        session.do("watch g", "reverse-continue")
        assert (session.do("where")[0].partition(":")[0], session.value("g")) == ("Slow, plc.st", f"{int(value) - 1}")
        editor = TravellingEditor(rig)
        editor.request("initialize")
        editor.request("attach")
        editor.request("reverseContinue")
        stops = [body for name, body in editor.events() if name == "stopped"]
        assert (stops[0]["threadId"], stops[0]["reason"]) == (2, "data breakpoint")
        assert all(stop["preserveFocusHint"] and stop["reason"] == "breakpoint" for stop in stops[1:])


def test_a_rig_in_real_time_is_told_apart_in_a_sentence() -> None:
    editor = Editor()
    travel = Travel("plc", editor.service.answer, lambda _verb, _message: {"time": "real", "now_ns": 0})
    editor.adapter = Adapter(editor.service.answer, travel)
    assert editor.request("initialize")["supportsStepBack"] is False
    editor.request("attach")
    assert "a rig in real time cannot go back" in editor.request("stepBack", threadId=1)["error"]
    assert "a rig in real time cannot go back" in editor.request("fieldrig.back", ns=5)["error"]
    assert "a rig in real time cannot go back" in editor.request("fieldrig.lastChange", name="n")["error"]
    assert "there is nothing to stop at" in editor.request("reverseContinue", threadId=1)["error"]
    wanted = [{"dataId": "n", "accessType": "write"}]
    assert editor.request("setDataBreakpoints", breakpoints=wanted) == {"breakpoints": [{"verified": True}]}
    editor.program.run_line()
    [(name, body)] = editor.events()
    assert (name, body["reason"], body["text"]) == ("stopped", "data breakpoint", "n 0 -> 1 by count.txt:1")


def test_an_editor_without_a_way_back_is_told_so() -> None:
    editor = Editor()
    assert editor.request("initialize")["supportsStepBack"] is False
    editor.request("attach")
    assert "cannot go back" in editor.request("stepBack", threadId=1)["error"]
    assert "cannot go back" in editor.request("reverseContinue", threadId=1)["error"]
