"""The debugging service, with a program of two lines that counts."""

import math
from typing import Any

import pytest
from counting_program import CountingProgram
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import VirtualClock
from fieldrig_devices.languages.debugging.debuggee import ProgramState, Reset, Step
from fieldrig_devices.languages.debugging.service import DebugService


@pytest.fixture
def counter() -> CountingProgram:
    return CountingProgram()


@pytest.fixture
def service(counter: CountingProgram) -> DebugService:
    return DebugService(VirtualClock(), counter)


def ask(service: DebugService, command: str, **keys: Any) -> dict[str, Any]:
    return service.answer({"command": command, **keys})


def test_a_breakpoint_stops_and_is_counted(counter: CountingProgram, service: DebugService) -> None:
    assert ask(service, "breakpoints", file="count.txt", breakpoints=[{"line": 2}, {"line": 9}]) == {"lines": [2]}
    counter.run_line()
    state = ask(service, "state")
    assert (state["state"], state["stops"]) == ("paused", 1)
    assert ask(service, "stack")["frames"] == [{"routine": "MAIN", "file": "count.txt", "line": 2}]
    assert ask(service, "continue") == {"state": "running"}


def test_a_condition_that_does_not_hold_lets_the_program_run_on(
    counter: CountingProgram, service: DebugService
) -> None:
    ask(service, "breakpoints", file="count.txt", breakpoints=[{"line": 2, "condition": "n=3"}])
    stopped_at = []
    for _ in range(10):
        counter.run_line()
        if counter.state is ProgramState.PAUSED:
            stopped_at.append(counter.values["n"])
            counter.go_on()
    assert stopped_at == [3]
    assert ask(service, "state")["stops"] == 1


def test_a_condition_that_cannot_be_evaluated_stops(counter: CountingProgram, service: DebugService) -> None:
    ask(service, "breakpoints", file="count.txt", breakpoints=[{"line": 2, "condition": "k=3"}])
    counter.run_line()
    assert counter.state is ProgramState.PAUSED
    (thread,) = ask(service, "state")["threads"]
    assert thread["about"] == "its condition k=3 has no value here: k is not known"
    ask(service, "breakpoints", file="count.txt", breakpoints=[{"line": 2}])
    ask(service, "continue")
    assert not ask(service, "state")["threads"][0]["about"]


def test_new_breakpoints_of_a_file_replace_its_old_ones(counter: CountingProgram, service: DebugService) -> None:
    ask(service, "breakpoints", file="count.txt", breakpoints=[{"line": 2, "condition": "n=3"}])
    ask(service, "breakpoints", file="count.txt", breakpoints=[{"line": 1}])
    assert counter.stops == {"count.txt": {1}}
    ask(service, "breakpoints", file="count.txt", breakpoints=[])
    assert not counter.stops.get("count.txt")


def test_values_are_read_written_and_forced(counter: CountingProgram, service: DebugService) -> None:
    read = ask(service, "read", names=["n", "k"])["variables"]
    assert (read[0]["value"], read[1]["error"]) == (0, "k is not known")
    assert ask(service, "write", values={"m": 7})["variables"][0]["value"] == 7
    assert ask(service, "force", values={"n": 5})["variables"][0]["is_forced"] is True
    counter.run_line()
    assert counter.values["n"] == 5
    ask(service, "release", names=["n"])
    counter.run_line()
    counter.run_line()
    assert counter.values["n"] == 6


def test_a_program_arrives_in_parts(counter: CountingProgram, service: DebugService) -> None:
    ask(service, "part", file="a.st", text="old", is_first=True)
    ask(service, "part", file="a.st", text="x := ", is_first=True)
    ask(service, "part", file="a.st", text="1;")
    ask(service, "download", online=True)
    assert counter.done == [({"a.st": "x := 1;"}, True)]
    with pytest.raises(ValueError, match="nothing to download"):
        ask(service, "download")


def test_commands_reach_the_program(counter: CountingProgram, service: DebugService) -> None:
    for command in ("start", "stop"):
        ask(service, command)
    ask(service, "reset", kind="cold")
    ask(service, "step", kind="over", thread=1)
    assert counter.done == ["start", "stop", Reset.COLD, (1, Step.OVER)]


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (None, "expected an object"),
        ({}, "expected the key 'command'"),
        ({"command": "dance"}, "expected state, files"),
        ({"command": "step", "kind": "back"}, "expected into, over, out"),
        ({"command": "step", "thread": 7}, "there is no thread 7"),
        ({"command": "source", "file": "x"}, "expected count.txt"),
        ({"command": "record", "names": ["n"]}, "there is no command"),
        ({"command": "write", "values": {"n": [1]}}, "expected a number"),
        ({"command": "breakpoints", "file": "count.txt", "breakpoints": [1]}, "expected an object"),
    ],
)
def test_a_wrong_question_is_refused(service: DebugService, message: Any, expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        service.answer(message)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
COMMANDS = list(DebugService(VirtualClock(), CountingProgram())._commands)
KEYS = st.sampled_from(
    [
        "file",
        "breakpoints",
        "thread",
        "kind",
        "path",
        "names",
        "values",
        "text",
        "online",
    ]
)


@given(st.sampled_from(COMMANDS), st.dictionaries(KEYS, JSON, max_size=4))
def test_no_question_raises_anything_but_value_error(command: str, keys: dict[str, Any]) -> None:
    try:
        answer = DebugService(VirtualClock(), CountingProgram()).answer({**keys, "command": command})
    except ValueError:
        return
    assert isinstance(answer, dict)


def test_a_variable_is_a_point_that_recordings_find(counter: CountingProgram, service: DebugService) -> None:
    point = service.point("program:n")
    assert point is not None
    assert (point.read(), point.write) == (0, None)
    counter.run_line()
    counter.run_line()
    assert point.read() == counter.values["n"]
    del counter.values["n"]
    assert math.isnan(point.read())  # type: ignore[arg-type]  # it is no text
    for key in ("n", "program:", "program:k", "programn"):
        assert service.point(key) is None
