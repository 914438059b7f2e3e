"""Random questions to the debugging service of a controller are answered or refused, and its program goes on."""

import random
from pathlib import Path
from typing import Any, Final

import pytest
from plc_bench import PlcBench, task_of
from program_traces import RigTraces

pytestmark = pytest.mark.system

SEED: Final = 2026
TEXT: Final = (
    """\
FUNCTION_BLOCK Counter
VAR_IN_OUT total : DINT; END_VAR
VAR own : DINT; text : STRING(20); END_VAR
total := total + 1;
own := own + total; text := DINT_TO_STRING(own);
END_FUNCTION_BLOCK
FUNCTION Twice : DINT
VAR_INPUT x : DINT; END_VAR
VAR list : ARRAY[1..5] OF DINT; END_VAR
list[1] := x;
Twice := list[1] * 2;
END_FUNCTION
PROGRAM Main
VAR n, double : DINT; counter : Counter; a : ARRAY[0..9] OF INT; small : INT(0..10); r : REAL; END_VAR
n := n + 1;
double := Twice(n); counter(total := n);
"""
    + "a[3] := a[4] + 1;\n" * 200
    + "END_PROGRAM\n"
    + task_of("Main")
)
CHANGES: Final = (
    ("VAR own", "VAR more, own"),
    ("n, double", "extra, n, double"),
    ("", ""),
    ("END_PROGRAM", "x := 1; END_PROGRAM"),
)
NAMES: Final = (
    "Main.n", "n", "Main.counter.total", "Main.counter.text", "Main.a[3]", "Main.a[99]", "Main.a", "Main.small",
    "@1:0.list[1]", "@1:0.x", "@1:1.n", "@1:0", "@9:9", "x", "total", "Main.extra", "Main.r", "n / 0", "r / r",
    "n * n * n * n * n * n", "n > 5", "text = 'a'", "", "((", "\ud800", "PacDriveM.Timer1", "-" * 500 + "n",
)  # fmt: skip
VALUES: Final = (
    0,
    1,
    -1,
    2**31,
    2**70,
    1.5,
    float("nan"),
    float("inf"),
    True,
    "3",
    "T#5s",
    "x" * 300,
    None,
    [1],
    {"a": 1},
)


def _question(chance: random.Random) -> dict[str, Any]:
    names = [chance.choice(NAMES) for _ in range(chance.randrange(1, 4))]
    places = [{"line": chance.randrange(0, 220), "condition": chance.choice(NAMES)} for _ in range(chance.randrange(3))]
    trigger = {"name": chance.choice(NAMES), "level": chance.choice(VALUES), "before": chance.randrange(-1, 5)}
    question: dict[str, Any] = chance.choice([
        {"command": "breakpoints", "file": "plc.st", "breakpoints": places},
        {"command": "step", "thread": chance.randrange(3), "kind": chance.choice(("into", "over", "out"))},
        {"command": "reset", "kind": chance.choice(("warm", "cold"))},
        *({"command": word} for word in ("start", "stop", "pause", "continue", "state", "stack", "forced", "samples")),
        {"command": chance.choice(("write", "force")), "values": {name: chance.choice(VALUES) for name in names}},
        {"command": "release", "names": names},
        {"command": "read", "names": names, "thread": chance.randrange(3), "frame": chance.randrange(-1, 3)},
        {"command": "variables", "path": chance.choice(NAMES)},
        {"command": "record", "names": names, "trigger": chance.choice((None, trigger))},
        {"command": "download", "online": chance.random() < 0.8},
    ])  # fmt: skip
    if chance.random() < 0.1:
        question[chance.choice(list(question))] = chance.choice(VALUES)
    return question


def test_a_controller_answers_the_next_debugger(tmp_path: Path, inputs_a_target: int) -> None:
    chance = random.Random(f"{SEED}/debugging")
    bench = PlcBench(tmp_path, TEXT).run(100)
    traces = RigTraces(bench.rig, "max4")

    def ask(question: Any) -> Any:
        try:
            return traces(question)
        except ValueError:  # refused with its reason
            return None

    for _ in range(inputs_a_target):
        question = _question(chance)
        if question["command"] == "download":
            ask({"command": "part", "file": "plc.st", "text": TEXT.replace(*chance.choice(CHANGES)), "is_first": True})
        ask(question)
        bench.run(chance.randrange(20))
    bench.run(10_000)
    for word in ("stop", "reset"):
        ask({"command": word})
    ask({"command": "breakpoints", "file": "plc.st", "breakpoints": []})
    ask({"command": "release", "names": [variable["path"] for variable in ask({"command": "forced"})["variables"]]})
    ask({"command": "start"})
    before = bench.run(100).value("Main.n")
    assert bench.run(100).value("Main.n") == int(before) + 20, "ten cycles, each with two increments"
