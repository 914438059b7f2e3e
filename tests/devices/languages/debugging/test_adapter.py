"""The debug adapter, against messages as the specification of the Debug Adapter Protocol shows them."""

import json
from typing import Any

import pytest
from debug_editor import Editor, read
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.languages.debugging.debuggee import ProgramState, Step
from fieldrig_devices.languages.debugging.framing import Framer, framed

INITIALIZE = (
    b'Content-Length: 96\r\n\r\n{"seq":1,"type":"request","command":"initialize",'
    b'"arguments":{"adapterID":"x","pathFormat":"p"}}'
)


@pytest.fixture
def editor() -> Editor:
    editor = Editor()
    editor.request("initialize")
    editor.request("attach", sources="/work")
    return editor


def test_initialize_as_bytes() -> None:
    adapter = Editor().adapter
    first, second = read(adapter.feed(INITIALIZE[:20]) + adapter.feed(INITIALIZE[20:]))
    assert (first["request_seq"], first["success"]) == (1, True)
    assert first["body"]["supportsConfigurationDoneRequest"] is True
    assert (second["type"], second["event"]) == ("event", "initialized")
    assert (first["seq"], second["seq"]) == (1, 2)


def test_a_breakpoint_stops_the_program_and_shows_where(editor: Editor) -> None:
    source = {"path": "/work/count.txt"}
    answer = editor.request("setBreakpoints", source=source, breakpoints=[{"line": 2}, {"line": 8}])
    first, second = answer["breakpoints"]
    assert first == {"id": 1, "verified": True, "line": 2}
    assert (second["verified"], second["message"]) == (False, "there is no instruction from this line on")
    assert editor.events() == []
    editor.program.run_line()
    assert editor.events() == [("stopped", {"reason": "breakpoint", "threadId": 1, "allThreadsStopped": False})]
    assert editor.request("threads") == {"threads": [{"id": 1, "name": "main"}]}
    (frame,) = editor.request("stackTrace", threadId=1)["stackFrames"]
    assert (frame["name"], frame["line"], frame["source"]) == (
        "MAIN",
        2,
        {"name": "count.txt", "path": "/work/count.txt"},
    )


def test_values_are_shown_and_changed(editor: Editor) -> None:
    frame = editor.request("stackTrace", threadId=1)["stackFrames"][0]["id"]
    scope = editor.request("scopes", frameId=frame)["scopes"][-1]["variablesReference"]
    shown = editor.request("variables", variablesReference=scope)["variables"]
    assert [(variable["name"], variable["value"], variable["type"]) for variable in shown] == [
        ("n", "0", "INT"),
        ("m", "0", "INT"),
    ]
    assert editor.request("setVariable", variablesReference=scope, name="m", value="7")["value"] == "'7'"
    assert editor.program.values["m"] == "7"  # the language reads the text
    assert editor.request("evaluate", expression="n=0", frameId=frame)["result"] == "TRUE"
    assert editor.request("evaluate", expression="k") == {"error": "k is not known"}


def test_a_step_is_reported_as_a_step(editor: Editor) -> None:
    editor.request("pause")
    editor.request("next", threadId=1)
    assert editor.program.done == [(1, Step.OVER)]
    editor.program.on_stop()
    assert editor.events()[0][1]["reason"] == "step"


def test_own_requests_reach_the_service(editor: Editor) -> None:
    assert editor.request("fieldrig.force", values={"n": 3})["variables"][0]["is_forced"] is True
    assert "expected state, files" in editor.request("fieldrig.dance")["error"]


def test_disconnecting_removes_breakpoints_and_lets_the_program_run(editor: Editor) -> None:
    editor.request("setBreakpoints", source={"name": "count.txt"}, breakpoints=[{"line": 2}])
    editor.program.run_line()
    editor.request("disconnect")
    assert (editor.program.state.value, editor.program.stops.get("count.txt")) == ("running", None)
    assert editor.adapter.is_over


def test_a_file_that_the_program_does_not_have(editor: Editor) -> None:
    error = editor.request("setBreakpoints", source={"path": "/x/other.txt"}, breakpoints=[])["error"]
    assert error == "the program has no file 'other.txt'; expected count.txt"
    assert editor.request("source", source={"sourceReference": 1})["content"].startswith("n := n + 1;")


JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**63) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
KEYS = st.sampled_from(["source", "breakpoints", "threadId", "frameId", "variablesReference", "name", "value"])


@pytest.mark.long
@given(st.sampled_from([*Editor().adapter._commands, "?"]), st.dictionaries(KEYS, JSON, max_size=4))
def test_every_request_gets_one_response(command: str, arguments: dict[str, Any]) -> None:
    message = {"seq": 5, "type": "request", "command": command, "arguments": arguments}
    responses = [answer for answer in read(Editor().adapter.feed(framed(message))) if answer["type"] == "response"]
    assert [response["request_seq"] for response in responses] == [5]


@given(st.lists(JSON.map(lambda value: {"value": value}), max_size=4), st.integers(1, 50))
def test_messages_survive_any_cutting(messages: list[Any], size: int) -> None:
    data = b"".join(
        b"Content-Length: %d\r\n\r\n%s" % (len(body), body)
        for body in (json.dumps(message).encode() for message in messages)
    )
    framer = Framer()
    found = [message for at in range(0, len(data), size) for message in framer.feed(data[at : at + size])]
    assert found == messages


@given(st.binary(max_size=200))
def test_any_bytes_are_survived(data: bytes) -> None:
    adapter = Editor().adapter
    adapter.feed(data)
    assert all(message["type"] in ("response", "event") for message in read(adapter.feed(b"\r\n\r\n" + INITIALIZE)))


def test_a_pause_stops_all_threads(editor: Editor) -> None:
    editor.request("pause", threadId=1)
    assert editor.events() == [("stopped", {"reason": "pause", "threadId": 1, "allThreadsStopped": False})]
    assert editor.events() == []
    editor.request("continue", threadId=1)
    source = {"path": "/work/count.txt"}
    editor.request("setBreakpoints", source=source, breakpoints=[{"line": 2}])
    editor.program.run_line()
    assert [body["reason"] for _, body in editor.events()] == ["breakpoint"]


def test_a_breakpoint_goes_to_the_next_line_with_an_instruction(editor: Editor) -> None:
    editor.program.files = {"count.txt": "(* two lines\n of a comment *)\nn := n + 1;\n\nm := n;\n"}
    editor.program.code_lines = {3, 5}
    source = {"path": "/work/count.txt"}
    asked = [{"line": line} for line in (1, 3, 4, 5, 6)]
    answer = editor.request("setBreakpoints", source=source, breakpoints=asked)["breakpoints"]
    assert [place["line"] for place in answer] == [3, 3, 5, 5, 6]
    assert [place["verified"] for place in answer] == [True] * 4 + [False]
    assert editor.program.stops == {"count.txt": {3, 5}}


def test_what_another_session_has_left_is_shown(editor: Editor) -> None:
    editor.request("setBreakpoints", source={"path": "count.txt"}, breakpoints=[{"line": 2}])
    editor.program.run_line()
    other = Editor(editor.program, editor.service)
    other.request("initialize")
    other.request("attach", sources="/work")
    answers = other.messages("configurationDone")
    (event,) = [message["body"] for message in answers if message["type"] == "event"]
    assert (event["reason"], event["breakpoint"]["line"]) == ("new", 2)
    assert event["breakpoint"]["source"] == {"name": "count.txt", "path": "/work/count.txt"}
    assert [body["reason"] for _, body in other.events()] == ["breakpoint"]


def test_an_editor_that_dies_leaves_nothing_behind(editor: Editor) -> None:
    editor.request("setBreakpoints", source={"path": "count.txt"}, breakpoints=[{"line": 2}])
    editor.program.run_line()
    editor.adapter.end()
    assert (editor.program.state, editor.program.stops) == (ProgramState.RUNNING, {})
