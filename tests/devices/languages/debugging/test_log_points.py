"""Breakpoints that count, and that log instead of stopping (Debug Adapter Protocol, SourceBreakpoint)."""

from typing import Any

import pytest
from counting_program import CountingProgram
from debug_editor import Editor

from fieldrig_devices.languages.debugging.debuggee import ProgramState


@pytest.fixture
def editor() -> Editor:
    editor = Editor()
    editor.request("initialize")
    editor.request("attach", sources="/work")
    return editor


def stopped_at(program: CountingProgram, times: int = 10) -> list[Any]:
    """Run the program, and return n at each stop in front of line 2."""
    found = []
    for _ in range(2 * times):
        program.run_line()
        if program.state is ProgramState.PAUSED:
            found.append(program.values["n"])
            program.go_on()
    return found


def break_at_2(editor: Editor, **words: str) -> dict[str, Any]:
    answer = editor.request("setBreakpoints", source={"path": "/work/count.txt"}, breakpoints=[{"line": 2, **words}])
    (shown,) = answer["breakpoints"]
    return dict(shown)


@pytest.mark.parametrize(
    ("count", "stops"),
    [
        ("3", [3]),
        ("= 3", [3]),
        ("==3", [3]),
        (">= 8", [8, 9, 10]),
        ("> 8", [9, 10]),
        ("<= 2", [1, 2]),
        ("< 2", [1]),
        ("% 4", [4, 8]),
        ("%0", []),
        ("", list(range(1, 11))),
    ],
)
def test_a_breakpoint_stops_at_its_count(editor: Editor, count: str, stops: list[int]) -> None:
    assert break_at_2(editor, hitCondition=count)["verified"] is True
    assert stopped_at(editor.program) == stops


def test_what_its_condition_refuses_does_not_count(editor: Editor) -> None:
    break_at_2(editor, hitCondition="1", condition="n=7")
    assert stopped_at(editor.program) == [7]


def test_a_breakpoint_that_is_set_again_as_it_was_goes_on_counting(editor: Editor) -> None:
    break_at_2(editor, hitCondition="5")
    assert stopped_at(editor.program, 3) == []
    break_at_2(editor, hitCondition="5")
    assert stopped_at(editor.program, 3) == [5]
    break_at_2(editor, hitCondition="2")
    assert stopped_at(editor.program, 3) == [8]


@pytest.mark.parametrize("count", ["five", ">", "-1", "3 times", "1234567890"])
def test_a_count_that_is_none_leaves_its_breakpoint_unverified(editor: Editor, count: str) -> None:
    places = [{"line": 2, "hitCondition": count}, {"line": 1}]
    wrong, right = editor.request("setBreakpoints", source={"path": "count.txt"}, breakpoints=places)["breakpoints"]
    assert (wrong["verified"], wrong["message"]) == (False, "expected a number, perhaps behind =, >, >=, <, <= or %")
    assert (right["verified"], right["line"]) == (True, 1)


def test_a_log_point_shows_its_text_and_does_not_stop(editor: Editor) -> None:
    break_at_2(editor, logMessage="n is {n}, twice { k }{}", hitCondition="% 2")
    assert stopped_at(editor.program, 4) == []
    shown = [body for name, body in editor.events() if name == "output"]
    assert [body["output"] for body in shown] == [
        "n is 2, twice {k: k is not known}{}\n",
        "n is 4, twice {k: k is not known}{}\n",
    ]
    assert (shown[0]["line"], shown[0]["source"]["name"], shown[0]["category"]) == (2, "count.txt", "stdout")
    assert editor.events() == []


def test_the_service_keeps_the_last_texts_for_several_readers(editor: Editor) -> None:
    break_at_2(editor, logMessage="{n}")
    stopped_at(editor.program, 1_100)
    ask = editor.service.answer
    assert ask({"command": "state"})["logged"] == 1_100
    entries = ask({"command": "logged"})["entries"]
    assert (len(entries), entries[0]["text"], entries[-1]["number"]) == (1_000, "101", 1_100)
    assert [entry["text"] for entry in ask({"command": "logged", "after": 1_099})["entries"]] == ["1100"]


def test_an_editor_says_that_it_may_count_and_log() -> None:
    known = Editor().request("initialize")
    assert (known["supportsLogPoints"], known["supportsHitConditionalBreakpoints"]) == (True, True)
