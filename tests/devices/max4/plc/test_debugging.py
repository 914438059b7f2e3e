"""The program of the controller in the debugging service: stops, steps, values, trace, download."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from plc_bench import PlcBench, task_of
from program_traces import RigTraces

from fieldrig_devices.languages.debugging.adapter import Adapter
from fieldrig_devices.languages.debugging.framing import Framer, framed

TEXT = (
    """\
FUNCTION Twice : INT
VAR_INPUT x : INT; END_VAR
Twice := x * 2;
END_FUNCTION
FUNCTION_BLOCK Counter
VAR_INPUT inc : INT; END_VAR
VAR_OUTPUT n : INT; END_VAR
VAR old : INT; END_VAR
old := n;
n := n + inc;
END_FUNCTION_BLOCK
PROGRAM Main
VAR c : Counter; a, b : INT; s : STRING; END_VAR
a := a + 1;
c(inc := 2);
b := Twice(a);
END_PROGRAM
PROGRAM Other
VAR n : DINT; END_VAR
n := n + 1;
END_PROGRAM
"""
    + task_of("Main")
    + """
CONFIGURATION d RESOURCE s ON PLC
TASK U(INTERVAL := T#20ms, PRIORITY := 20);
PROGRAM q WITH U : Other;
END_RESOURCE END_CONFIGURATION
"""
)
FILE = "plc.st"
IN_FUNCTION, IN_BLOCK, FIRST, CALL_BLOCK, CALL_FUNCTION = 3, 9, 14, 15, 16


@pytest.fixture
def bench(tmp_path: Path) -> PlcBench:
    text = TEXT.replace("END_RESOURCE END_CONFIGURATION\n\nCONFIGURATION d RESOURCE s ON PLC\n", "")
    return PlcBench(tmp_path, text).run(100)


def ask(bench: PlcBench, command: str, **keys: Any) -> dict[str, Any]:
    answer: dict[str, Any] = bench.max4.answer("debug", {"command": command, **keys})
    return answer


def traces_of(bench: PlcBench) -> Callable[..., dict[str, Any]]:
    traces = RigTraces(bench.rig, "max4")
    return lambda command, **keys: traces({"command": command, **keys})


def stop_at(bench: PlcBench, line: int, condition: str = "") -> None:
    breakpoints = [{"line": line, "condition": condition}]
    assert ask(bench, "breakpoints", file=FILE, breakpoints=breakpoints) == {"lines": [line]}
    bench.run(40)


def place(bench: PlcBench) -> list[tuple[str, int]]:
    return [(frame["routine"], frame["line"]) for frame in ask(bench, "stack", thread=1)["frames"]]


@pytest.mark.manual("PD-222", "PD-221")
def test_a_breakpoint_stops_its_task_and_the_others_go_on(bench: PlcBench) -> None:
    stop_at(bench, CALL_BLOCK)
    state = ask(bench, "state")
    assert (state["state"], state["stops"]) == ("paused", 1)
    assert [thread["state"] for thread in state["threads"]] == ["paused", "running"]
    assert bench.state("T") == 5
    a, n, timer = bench.value("Main.a"), int(bench.value("Other.n")), int(bench.get("Timer1"))
    bench.run(100)
    assert (bench.value("Main.a"), int(bench.value("Other.n"))) == (a, n + 5)
    assert int(bench.get("Timer1")) == timer + 100, "Timer1 runs while the task stands"
    ask(bench, "breakpoints", file=FILE, breakpoints=[])
    ask(bench, "continue")
    assert bench.run(100).value("Main.a") != a


@pytest.mark.parametrize(
    ("line", "kind", "then"),
    [
        (FIRST, "over", [("Main", CALL_BLOCK)]),
        (CALL_BLOCK, "over", [("Main", CALL_FUNCTION)]),
        (CALL_BLOCK, "into", [("Counter", IN_BLOCK), ("Main", CALL_BLOCK)]),
        (CALL_FUNCTION, "into", [("Twice", IN_FUNCTION), ("Main", CALL_FUNCTION)]),
        (IN_BLOCK, "out", [("Main", CALL_FUNCTION)]),
    ],
)
@pytest.mark.manual("PD-222")
def test_single_steps(bench: PlcBench, line: int, kind: str, then: list[tuple[str, int]]) -> None:
    stop_at(bench, line)
    ask(bench, "step", kind=kind, thread=1)
    bench.run(5)
    assert ask(bench, "state")["stops"] == 2
    assert place(bench) == then


@pytest.mark.parametrize("condition", ["a = 25", "Main.a > 24 AND b <> 0", "c.n = a * 2"])
def test_a_condition(bench: PlcBench, condition: str) -> None:
    ask(bench, "write", values={"Main.a": 20, "Main.c.n": 40})
    stop_at(bench, CALL_FUNCTION, condition)
    bench.run(100)
    if condition.startswith("c"):
        assert ask(bench, "state")["stops"] == 1
    else:
        assert bench.value("Main.a") == 25


def test_names_are_looked_up_where_the_task_stands(bench: PlcBench) -> None:
    stop_at(bench, IN_BLOCK + 1)
    block = ask(bench, "read", names=["inc", "old", "c.n", "Main.c.n"], thread=1)["variables"]
    assert [variable.get("value") for variable in block] == [2, block[3]["value"], None, block[3]["value"]]
    stop_at(bench, IN_FUNCTION)
    ask(bench, "breakpoints", file=FILE, breakpoints=[{"line": IN_FUNCTION}])
    ask(bench, "continue")
    bench.run(30)
    (x,) = ask(bench, "read", names=["x + 1"], thread=1)["variables"]
    assert x["value"] == int(bench.value("Main.a")) + 1


NESTED = """\
FUNCTION Inner : INT
VAR_INPUT x : INT; END_VAR
VAR list : ARRAY[1..2] OF INT := 3, 4; END_VAR
list[1] := 5;
Inner := x + list[2];
END_FUNCTION
FUNCTION Outer : INT
VAR_INPUT x : INT; END_VAR
VAR_IN_OUT sum : INT; END_VAR
Outer := Inner(x + 1);
END_FUNCTION
FUNCTION_BLOCK Block
VAR n : INT := 20; s : INT := 30; END_VAR
n := Outer(n, s);
END_FUNCTION_BLOCK
PROGRAM Main
VAR one : INT; b : ARRAY[1..2] OF Block; END_VAR
b[2]();
END_PROGRAM
""" + task_of("Main")


def test_the_variables_of_every_frame_are_shown(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, NESTED).run(89)
    stop_at(bench, 5)
    assert [name for name, _ in place(bench)] == ["Inner", "Outer", "Block", "Main"]
    inside = [ask(bench, "variables", path=f"@1:{frame}")["variables"] for frame in range(4)]
    assert [[(part["path"], part["value"]) for part in frame] for frame in inside] == [
        [("@1:0.Inner", 0), ("@1:0.x", 21), ("@1:0.list", None)],
        [("@1:1.Outer", 0), ("@1:1.x", 20), ("@1:1.sum", 30)],
        [("Main.b[2].n", 20), ("Main.b[2].s", 30)],
        [("Main.one", 0), ("Main.b", None)],
    ]
    parts = ask(bench, "variables", path="@1:0.list")["variables"]
    assert [(part["path"], part["value"]) for part in parts] == [("@1:0.list[1]", 5), ("@1:0.list[2]", 4)]
    read = ask(bench, "read", names=["x + sum", "n"], thread=1, frame=1)["variables"]
    assert (read[0]["value"], "not a variable" in read[1]["error"]) == (50, True)
    ask(bench, "write", values={"@1:0.x": 100, "@1:1.sum": 31})
    assert bench.value("Main.b[2].s") == 31
    ask(bench, "breakpoints", file=FILE, breakpoints=[{"line": 18}])
    ask(bench, "continue")
    bench.run(20)
    assert bench.value("Main.b[2].n") == 104


def test_an_array_without_limits_has_those_of_its_argument(tmp_path: Path) -> None:
    text = """\
FUNCTION Inner : INT
VAR_IN_OUT page : ARRAY[*, *] OF INT; END_VAR
Inner := page[2, 5];
END_FUNCTION
FUNCTION_BLOCK Block
VAR_IN_OUT list : ARRAY[*] OF INT; END_VAR
list[8] := list[7];
END_FUNCTION_BLOCK
PROGRAM Main
VAR a : ARRAY[2..2, 4..5] OF INT := 1, 2; b : Block; c : ARRAY[7..8] OF INT := 3, 4; x : INT; END_VAR
x := Inner(a);
b(list := c);
END_PROGRAM
"""
    bench = PlcBench(tmp_path, text + task_of("Main"), dialect="edition-3").run(89)
    stop_at(bench, 3)
    (_, page) = ask(bench, "variables", path="@1:0")["variables"]
    assert (page["path"], page["type"]) == ("@1:0.page", "ARRAY[2..2] OF ARRAY[4..5] OF INT")
    (row,) = ask(bench, "variables", path="@1:0.page")["variables"]
    parts = ask(bench, "variables", path=row["path"])["variables"]
    assert [(part["path"], part["value"]) for part in parts] == [("@1:0.page[2,4]", 1), ("@1:0.page[2,5]", 2)]
    ask(bench, "write", values={"@1:0.page[2,5]": 30})
    ask(bench, "breakpoints", file=FILE, breakpoints=[{"line": 7}])
    ask(bench, "continue")
    bench.run(20)
    assert bench.value("Main.x") == 30
    (item,) = ask(bench, "variables", path="@1:0")["variables"]
    assert (item["path"], item["type"]) == ("@1:0.list", "ARRAY[7..8] OF INT")
    read = ask(bench, "read", names=["list[7] + list[8]", "list[9]"], thread=1)["variables"]
    assert (read[0]["value"], "not a variable" in read[1]["error"]) == (7, True)


@pytest.mark.parametrize("path", ["@1:9", "@2:0", "@1:0.nothing", "@1:0.list[7]", "@", "@1", "@1:x", "@1:0x"])
def test_a_frame_or_variable_that_is_not_there_is_refused(tmp_path: Path, path: str) -> None:
    bench = PlcBench(tmp_path, NESTED).run(89)
    stop_at(bench, 4)
    for command in ({"command": "variables", "path": path}, {"command": "write", "values": {path: 1}}):
        with pytest.raises(ValueError, match=r"expected|not a variable"):
            bench.max4.answer("debug", command)
    with pytest.raises(ValueError, match="expected"):
        bench.max4.answer("debug", {"command": "force", "values": {"@1:0.x": 1}})


def test_the_tree_of_variables(bench: PlcBench) -> None:
    roots = ask(bench, "variables", path="")["variables"]
    assert {root["name"]: root["value"] for root in roots} == {"Main": None, "Other": None}
    inside = ask(bench, "variables", path="Main.c")["variables"]
    assert [(variable["path"], variable["type"]) for variable in inside] == [
        ("Main.c.inc", "INT"),
        ("Main.c.n", "INT"),
        ("Main.c.old", "INT"),
    ]


def test_values_are_written_as_constants_of_the_language(bench: PlcBench) -> None:
    written = ask(bench, "write", values={"Main.a": "16#10", "Main.s": "two words"})
    assert [variable["value"] for variable in written["variables"]] == [16, "two words"]
    for wrong in ("40000", "b", "1.5", "'x'"):
        with pytest.raises(ValueError, match=r"Main\.a: expected"):
            ask(bench, "write", values={"Main.a": wrong})


@pytest.mark.manual("PD-223", "PD-224")
def test_parameters_are_observed_like_variables(bench: PlcBench) -> None:
    timer = int(bench.get("Timer1"))
    read = ask(bench, "read", names=["PacDriveM.Timer1", "pacdrivem.timer1 - 5", "PacDriveM", "PacDriveM.Speed"])
    own, less, group, unknown = read["variables"]
    assert (own["path"], own["type"], own["value"], less["value"]) == ("PacDriveM.Timer1", "UDINT", timer, timer - 5)
    assert (group["value"], "not a variable" in unknown["error"]) == (None, True)
    inside = {variable["path"]: variable for variable in ask(bench, "variables", path="PacDriveM")["variables"]}
    assert inside["PacDriveM.Timer1"]["is_writable"] is False
    trace = traces_of(bench)
    trace("record", names=["PacDriveM.Timer1"], depth=5)
    bench.run(100)
    times = [sample[1] for sample in trace("samples")["samples"]]
    assert [after - before for before, after in pairwise(times)] == [4, 4, 4, 4]


@pytest.mark.parametrize("is_online", [False, True])
def test_a_download_that_does_not_fit_on_the_disk_says_so(bench: PlcBench, is_online: bool) -> None:
    disk = bench.max4.firmware.disk
    disk.write("\\FILL.BIN", bytes(disk.free - 8_192))
    text = ask(bench, "source", file=FILE)["text"] + f"(* {'x' * 20_000} *)"
    ask(bench, "part", file=FILE, text=text)
    ask(bench, "download", online=is_online)
    bench.run(5_000)
    problem = ask(bench, "state")["problem"]
    assert problem.startswith("the program is loaded until the next power-off, but not stored: the flash disk")
    assert ask(bench, "source", file=FILE)["text"] == text
    disk.delete("\\FILL.BIN")
    ask(bench, "part", file=FILE, text=text)
    ask(bench, "download", online=is_online)
    bench.run(5_000)
    assert ask(bench, "state")["problem"] == ""


LARGE = (
    "PROGRAM Main\nVAR a, b : DINT; END_VAR\na := a + 1;\n"
    + "IF a > 0 THEN b := b + 1; END_IF\n" * 100
    + "END_PROGRAM\n"
    + task_of("Main")
)


@pytest.mark.long
def test_breakpoints_of_a_large_program_are_prepared_beside_the_controller(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, LARGE).run(100)
    routines = bench.loaded.runtime.code.routines
    assert not any(routine.for_debugging for routine in routines)
    assert ask(bench, "breakpoints", file=FILE, breakpoints=[{"line": 50}]) == {"lines": [50]}
    assert not any(routine.for_debugging for routine in routines)
    assert not any(thread.is_watched for thread in bench.loaded.runtime.threads)
    bench.run(40)
    assert [bool(routine.for_debugging) for routine in routines].count(True) == 1, "the one that is called"
    assert place(bench) == [("Main", 50)]
    ask(bench, "step", thread=1, kind="over")
    bench.run(5)
    assert place(bench) == [("Main", 51)]
    text = ask(bench, "source", file=FILE)["text"]
    ask(bench, "breakpoints", file=FILE, breakpoints=[])
    ask(bench, "continue")
    ask(bench, "part", file=FILE, text=text.replace("a + 1", "a + 2"))
    ask(bench, "download", online=True)
    bench.run(3_000)
    ask(bench, "breakpoints", file=FILE, breakpoints=[{"line": 60, "condition": "a > 1000"}])
    ask(bench, "write", values={"Main.a": 900})
    bench.run(2_000)
    assert place(bench) == [("Main", 60)]
    assert bench.value("Main.a") in (1001, 1002)


def test_a_pause_prepares_steps_as_well(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, LARGE).run(100)
    ask(bench, "pause")
    bench.run(10)
    assert any(routine.for_debugging for routine in bench.loaded.runtime.code.routines)


def test_a_trace_outlives_its_variables(bench: PlcBench) -> None:
    stop_at(bench, IN_FUNCTION)
    trace = traces_of(bench)
    trace("record", names=["@1:0.x", "Main.b", "Other.n"], trigger={"name": "@1:0.x", "level": 1e9})
    trace("record", names=["@1:0.x", "Main.b", "Other.n"])
    bench.run(20)
    ask(bench, "breakpoints", file=FILE, breakpoints=[])
    ask(bench, "continue")
    bench.run(20)
    text = ask(bench, "source", file=FILE)["text"]
    ask(bench, "part", file=FILE, text=text.replace("a, b : INT", "a, bb : INT").replace("b := ", "bb := "))
    ask(bench, "download", online=True)
    bench.run(3_000)
    assert ask(bench, "state")["problem"] == ""
    samples = trace("samples")["samples"]
    assert samples[0][1] is not None
    assert samples[-1][1:3] == [None, None]
    assert samples[-1][3] == int(bench.value("Other.n"))


@pytest.mark.parametrize("expression", ["*".join(["a"] * 400), "*".join(["4000000000"] * 3), "1.0 / 0"])
def test_an_expression_without_a_value_that_can_be_shown_is_refused(bench: PlcBench, expression: str) -> None:
    ask(bench, "write", values={"Main.a": 32_000})
    stop_at(bench, CALL_BLOCK)
    (found,) = ask(bench, "read", names=[expression], thread=1)["variables"]
    assert found["error"] in ("the result is too large", "a division by zero")
    with pytest.raises(ValueError, match=r"too large|zero|not a variable"):
        traces_of(bench)("record", names=[expression])


def test_parameters_are_written_by_the_rules_of_the_controller(bench: PlcBench) -> None:
    written = ask(bench, "write", values={"PacDriveM.MsgFilter": "16#F"})["variables"][0]
    assert (written["value"], int(bench.get("MsgFilter"))) == (15, 15)
    for values in ({"PacDriveM.Timer1": 1}, {"PacDriveM.MsgFilter": "1.5"}):
        with pytest.raises(ValueError, match="expected"):
            ask(bench, "write", values=values)
    with pytest.raises(ValueError, match="it is a parameter of the controller"):
        ask(bench, "force", values={"PacDriveM.MsgFilter": 1})


def test_a_forced_variable_keeps_its_value(bench: PlcBench) -> None:
    assert ask(bench, "force", values={"Main.a": 7})["variables"][0]["is_forced"] is True
    assert bench.run(50).value("Main.a") == 7
    assert bench.value("Main.b") == 16
    ask(bench, "release", names=["Main.a"])
    assert bench.run(20).value("Main.a") == 9


@pytest.mark.manual("PD-224")
def test_a_trace_has_a_sample_in_every_cycle_of_the_real_time_process(bench: PlcBench) -> None:
    trace = traces_of(bench)
    trace("record", names=["Main.a", "Other.n"], depth=20, trigger={"name": "Main.a", "level": 12.5})
    bench.run(200)
    answer = trace("samples")
    assert answer["is_full"]
    times = [sample[0] for sample in answer["samples"]]
    assert {after - before for before, after in pairwise(times)} == {4_000_000}
    assert answer["samples"][0][1] == 13


@pytest.mark.parametrize("is_online", [True, False])
def test_breakpoints_go_with_their_lines_into_a_changed_program(bench: PlcBench, is_online: bool) -> None:
    bench.run(5)
    lines = [FIRST, CALL_BLOCK, CALL_FUNCTION]
    breakpoints = [{"line": line, "condition": "a < 0"} for line in lines]
    ask(bench, "breakpoints", file=FILE, breakpoints=breakpoints)
    editor = Adapter(lambda question: bench.max4.answer("debug", question))
    request = {"seq": 1, "type": "request"}
    editor.feed(framed({**request, "command": "attach"}))
    asked = {"source": {"name": FILE}, "breakpoints": [{"line": line, "condition": "a < 0"} for line in lines]}
    editor.feed(framed({**request, "command": "setBreakpoints", "arguments": asked}))
    text = bench.file.read_text()
    changed = text.replace("PROGRAM Main\n", "(* more *)\nPROGRAM Main\n").replace("c(inc := 2);", "c(inc := 3);")
    ask(bench, "part", file=FILE, text=changed, is_first=True)
    loads = ask(bench, "state")["loads"]
    ask(bench, "download", online=is_online)
    bench.run(500)
    assert ask(bench, "state")["loads"] == loads + 1
    answer = ask(bench, "breakpoints", file=FILE)
    assert answer["lines"] == [FIRST + 1, CALL_FUNCTION + 1]
    assert answer["moves"] == {str(FIRST): FIRST + 1, str(CALL_BLOCK): None, str(CALL_FUNCTION): CALL_FUNCTION + 1}
    events = [message["body"] for message in Framer().feed(editor.poll()) if message.get("event") == "breakpoint"]
    assert [(body["breakpoint"]["line"], body["breakpoint"]["verified"]) for body in events] == [
        (FIRST + 1, True),
        (CALL_BLOCK, False),
        (CALL_FUNCTION + 1, True),
    ]
    ask(bench, "start")
    ask(bench, "write", values={"Main.a": -9})
    bench.run(40)
    assert place(bench) == [("Main", FIRST + 1)]


@pytest.mark.manual("PD-225", "PD-220")
def test_an_online_change_keeps_values_and_a_wrong_program_changes_nothing(bench: PlcBench) -> None:
    a = int(bench.value("Main.a"))
    text = bench.file.read_text()
    ask(bench, "part", file=FILE, text=text.replace("a := a + 1;", "a := a + 100;"), is_first=True)
    ask(bench, "download", online=True)
    bench.run(500)
    assert ask(bench, "state")["problem"] == ""
    assert int(bench.value("Main.a")) > a + 100
    ask(bench, "part", file=FILE, text="PROGRAM Main a := ; END_PROGRAM", is_first=True)
    ask(bench, "download", online=False)
    bench.run(500)
    state = ask(bench, "state")
    assert (state["state"], "plc.st:1:" in state["problem"]) == ("running", True)


def test_pause_and_reset(bench: PlcBench) -> None:
    ask(bench, "pause")
    a = bench.value("Main.a")
    assert bench.run(100).value("Main.a") == a
    assert ask(bench, "state")["state"] == "paused"
    ask(bench, "continue")
    assert bench.run(100).value("Main.a") != a
    ask(bench, "reset", kind="cold")
    assert (ask(bench, "state")["state"], bench.value("Main.a")) == ("held", 0)
