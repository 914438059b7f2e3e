"""The program of a card in the debugging service: stops, steps, values, forced terminals, trace, download."""

import struct
from contextlib import suppress
from typing import Any

import pytest
from arp_bench import CardBench
from arp_user_port import PortBench
from debug_session import DebugSession
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.language.files import encode
from fieldrig_devices.arp.watch import evaluate

PROGRAM = """\
COUNT EQU V1
LIMIT EQU 7.5
BEG MAIN ; counts
LOOP:
COUNT += 1
CALL TWICE
V3 == 0
O101 == HI
IF I101 = 1, V5 += 1
WAIT 0.01
GOTO LOOP
END
BEG TWICE
V2 == COUNT * 2
V4 == V2
END
"""
FILE = "program.I01"
FIRST, CALL, BEHIND, IN_SUB = 5, 6, 7, 14


def ask(bench: CardBench, command: str, **keys: Any) -> dict[str, Any]:
    answer: dict[str, Any] = bench.card.answer("debug", {"command": command, **keys})
    return answer


@pytest.fixture
def bench() -> CardBench:
    bench = CardBench(PROGRAM).run_for(500)
    ask(bench, "state")
    return bench.run_for(2_000)


def stop_at(bench: CardBench, line: int, condition: str = "") -> None:
    breakpoints = [{"line": line, "condition": condition}]
    assert ask(bench, "breakpoints", file=FILE, breakpoints=breakpoints) == {"lines": [line]}
    bench.run_for(30)


def value(bench: CardBench, name: str) -> Any:
    (found,) = ask(bench, "read", names=[name])["variables"]
    return found.get("value", found.get("error"))


def place(bench: CardBench) -> list[tuple[str, int]]:
    return [(frame["routine"], frame["line"]) for frame in ask(bench, "stack")["frames"]]


def test_a_breakpoint_stops_the_program_in_its_subprogram(bench: CardBench) -> None:
    stop_at(bench, IN_SUB)
    state = ask(bench, "state")
    assert (state["language"], state["state"], state["stops"]) == ("ARP BASIC", "paused", 1)
    assert [(thread["name"], thread["state"]) for thread in state["threads"]] == [("program", "paused")]
    assert place(bench) == [("TWICE", IN_SUB), ("MAIN", BEHIND)]
    count = value(bench, "COUNT")
    ask(bench, "continue")
    bench.run_for(30)
    assert (value(bench, "COUNT"), ask(bench, "state")["stops"]) == (count + 1, 2)


@pytest.mark.parametrize(
    ("line", "kind", "then"),
    [
        (FIRST, "over", [("MAIN", CALL)]),
        (CALL, "over", [("MAIN", BEHIND)]),
        (CALL, "into", [("TWICE", IN_SUB), ("MAIN", BEHIND)]),
        (IN_SUB, "out", [("MAIN", BEHIND)]),
    ],
)
def test_single_steps(bench: CardBench, line: int, kind: str, then: list[tuple[str, int]]) -> None:
    stop_at(bench, line)
    ask(bench, "step", kind=kind)
    bench.run_for(5)
    assert (ask(bench, "state")["stops"], place(bench)) == (2, then)


@pytest.mark.parametrize("condition", ["V1 > 99", "COUNT = 100", "V1 % 50 = 0 AND COUNT >= 100", "COUNT - 100 = 0"])
def test_a_condition(bench: CardBench, condition: str) -> None:
    ask(bench, "write", values={"COUNT": 80, "V2": 5})
    stop_at(bench, CALL, condition)
    bench.run_for(400)
    assert (ask(bench, "state")["stops"], value(bench, "V1")) == (1, 100)


def test_a_condition_that_has_no_value_stops_the_program(bench: CardBench) -> None:
    stop_at(bench, CALL, "V1 / V3 > 1")
    assert ask(bench, "state")["stops"] == 1


def test_the_source_is_that_of_the_rig_file_with_its_names(bench: CardBench) -> None:
    assert ask(bench, "files") == {"files": [FILE]}
    assert ask(bench, "source", file=FILE)["text"] == PROGRAM
    names = ask(bench, "variables", path="EQU")["variables"]
    assert (names[0]["name"], names[0]["about"]) == ("COUNT", "V1")
    assert value(bench, "LIMIT * 2") == 15


def test_another_program_is_shown_as_its_object(bench: CardBench) -> None:
    ask(bench, "stop")
    other = PROGRAM.replace("COUNT * 2", "COUNT * 3").replace("; counts", "")
    bench.load(encode(compile_text(other), "other", 1))
    (file,) = ask(bench, "files")["files"]
    assert file == "other.D01"
    lines = ask(bench, "source", file=file)["text"].splitlines()
    assert lines[IN_SUB - 1] == "V2 == V1 * 3"


@pytest.mark.long
def test_the_tree_of_values(bench: CardBench) -> None:
    roots = [root["name"] for root in ask(bench, "variables", path="")["variables"]]
    assert roots == ["EQU", "V", "F", "I", "O", "AXES", "ANALOG", "PAR", "PAR1", "PAR2", "CARD"]
    for root in roots:
        inside = ask(bench, "variables", path=root)["variables"]
        assert all(variable["value"] is not None or "error" in variable for variable in inside), root
    assert len(ask(bench, "variables", path="V")["variables"]) == 1_000
    assert {variable["type"] for variable in ask(bench, "variables", path="I")["variables"]} == {"bit"}


@pytest.mark.parametrize(
    ("name", "given", "then"),
    [("V7", "2.5", 2.5), ("V7", -3, -3), ("F5", "ON", 1), ("F5", True, 1), ("V7", 0.125, 0.125)],
)
def test_values_are_written_as_people_write_them(bench: CardBench, name: str, given: Any, then: Any) -> None:
    assert ask(bench, "write", values={name: given})["variables"][0]["value"] == then


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("V7", "x", "'x' is not a value"),
        ("V7", "0.0001", "'0.0001' is not a value"),
        ("I101", 1, "I101 cannot be written"),
        ("@POS1", 1, "@POS1 cannot be written"),
        ("V1001", 1, "there is no V1001"),
        ("LIMIT", 1, "'7.5' is not a value of the card"),
    ],
)
def test_what_cannot_be_written(bench: CardBench, name: str, given: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ask(bench, "write", values={name: given})


def test_a_forced_input_is_what_the_program_sees(bench: CardBench) -> None:
    assert value(bench, "V5") == 0
    assert ask(bench, "force", values={"I101": 1})["variables"][0]["is_forced"] is True
    assert value(bench.run_for(50), "V5") > 0
    assert [variable["name"] for variable in ask(bench, "forced")["variables"]] == ["I101"]
    ask(bench, "release", names=["I101"])
    seen = value(bench.run_for(5), "V5")
    assert value(bench.run_for(100), "V5") == seen
    assert ask(bench, "forced") == {"variables": []}


def test_a_forced_output_holds_its_terminal_against_the_program(bench: CardBench) -> None:
    levels = [signal.value for signal in bench.wires.take() if signal.name == "card1.O101"]
    assert levels[-1] is True
    ask(bench, "force", values={"O101": 0})
    bench.run_for(100)
    assert [signal.value for signal in bench.wires.take() if signal.name == "card1.O101"] == [False]
    ask(bench, "release", names=["O101"])
    bench.run_for(100)
    assert [signal.value for signal in bench.wires.take() if signal.name == "card1.O101"] == [True]


def test_forcing_turns_no_output_on_while_the_card_is_held(bench: CardBench) -> None:
    ask(bench, "force", values={"O102": 1})
    bench.run_for(5)
    ask(bench, "reset")
    bench.run_for(50)
    assert [signal.value for signal in bench.wires.take() if signal.name == "card1.O102"][-1] is False


@pytest.mark.parametrize(
    ("name", "why"),
    [("V1", "in the middle of a control loop"), ("I108", "Enable"), ("O201", "a node on CAN"), ("@POS1", "measures")],
)
def test_what_cannot_be_forced_says_why(bench: CardBench, name: str, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        ask(bench, "force", values={name: 1})


def test_start_stop_pause_and_reset(bench: CardBench) -> None:
    assert ask(bench, "pause") == {"state": "paused"}
    with pytest.raises(ValueError, match="the program is not running"):
        ask(bench, "pause")
    assert ask(bench, "stop") == {"state": "held"}, "it begins again at its first instruction"
    for command in ("stop", "continue", "step"):
        with pytest.raises(ValueError, match="expected"):
            ask(bench, command)
    assert ask(bench, "start") == {"state": "running"}
    with pytest.raises(ValueError, match="already running"):
        ask(bench, "start")
    assert ask(bench, "reset") == {"state": "held"}
    with pytest.raises(ValueError, match="cannot delete"):
        ask(bench, "reset", kind="origin")


def test_a_download_is_compiled_beside_the_card(bench: CardBench) -> None:
    text = PROGRAM.replace("COUNT * 2", "COUNT * 5")
    ask(bench, "part", file="five.I01", text=text, is_first=True)
    with pytest.raises(ValueError, match="the program is running: expected `stop` first"):
        ask(bench, "download")
    ask(bench, "stop")
    ask(bench, "part", file="five.I01", text=text, is_first=True)
    ask(bench, "download")
    progress = set()
    while ask(bench, "state")["progress"]:
        progress.add(ask(bench, "state")["progress"].split()[0])
        bench.run_for(1)
    assert progress >= {"compiling", "loading"}
    assert (ask(bench, "state")["problem"], ask(bench, "files")) == ("", {"files": ["five.I01"]})
    ask(bench, "start")
    bench.run_for(50)
    assert value(bench, "V2") == value(bench, "COUNT") * 5


def test_a_download_with_mistakes_leaves_the_program(bench: CardBench) -> None:
    ask(bench, "stop")
    ask(bench, "part", file="five.I01", text="BEG MAIN\nV1 == V2000\nGOTO X\nEND\n", is_first=True)
    ask(bench, "download")
    bench.run_for(1_000)
    problem = ask(bench, "state")["problem"].splitlines()
    assert [line.split(": ")[0] for line in problem] == ["five.I01:2:7", "five.I01:3:1"]
    assert ask(bench, "files") == {"files": [FILE]}
    ask(bench, "part", file="five.I01", text=PROGRAM, is_first=True)
    with pytest.raises(ValueError, match="no online change"):
        ask(bench, "download", online=True)


@pytest.mark.parametrize("loops_between", [0, 60, 200])
def test_the_later_one_of_two_downloads_counts(bench: CardBench, loops_between: int) -> None:
    ask(bench, "stop")
    good, wrong = PROGRAM.replace("COUNT * 2", "COUNT * 5"), "BEG MAIN\nV1 == V2000\nEND\n"
    for first, last, problems in ((wrong, good, []), (good, wrong, ["five.I01:2:7"])):
        for text in (first, last):
            ask(bench, "part", file="five.I01", text=text, is_first=True)
            ask(bench, "download")
            bench.run_for(loops_between if text is first else 0)
        while ask(bench, "state")["progress"]:
            bench.run_for(1)
        assert [line.split(": ")[0] for line in ask(bench, "state")["problem"].splitlines()] == problems
    assert "COUNT * 5" in ask(bench, "source", file="five.I01")["text"]


def test_a_fault_of_the_program(bench: CardBench) -> None:
    ask(bench, "stop")
    bench.load(encode(compile_text("BEG MAIN\nCALL A\nEND\nBEG A\nV1 += 1\nCALL A\nEND\n"), "deep", 1))
    ask(bench, "start")
    bench.run_for(100)
    state = ask(bench, "state")
    assert (state["state"], state["stops"]) == ("failed", 1)
    assert state["threads"][0]["about"] == "error 112: calls are nested more than 10 deep"


def test_a_card_without_a_program() -> None:
    bench = CardBench().run_for(100)
    assert ask(bench, "state")["state"] == "none"
    assert ask(bench, "files") == {"files": []}
    with pytest.raises(ValueError, match="no program"):
        ask(bench, "start")


def test_the_debugger_of_the_command_line(bench: CardBench) -> None:
    session = DebugSession(lambda message: ask(bench, **message), bench.run_for)
    assert session.do("break 13") == [f"breakpoint at {FILE}:{IN_SUB}: V2 == COUNT * 2"]
    assert session.do("stop", "run") == [f"program paused at TWICE, {FILE}:{IN_SUB}: V2 == COUNT * 2"]
    assert session.do("set COUNT=41", "out", "print COUNT V2 COUNT=41") == [
        "COUNT = 41  V1",
        "V2 = 82",
        "COUNT=41 = TRUE",
    ]


def test_the_user_port_sees_the_same_breakpoints() -> None:
    bench = PortBench(PROGRAM, is_enabled=True)
    stop_at(bench, IN_SUB)
    assert bench.ok(0x41) == struct.pack("<I", IN_SUB)
    assert bench.condition()[:2] == (3, 3)


NUMBERS = st.integers(-9_000, 9_000)


@given(NUMBERS, NUMBERS, st.sampled_from(["+", "-", "*"]), st.sampled_from(["=", "<>", "<", "<=", ">", ">="]))
def test_expressions_are_those_of_exact_arithmetic(a: int, b: int, sign: str, relation: str) -> None:
    values = {"V1": a * SCALE, "V2": b * SCALE}
    exact = {"+": a + b, "-": a - b, "*": a * b}[sign]
    if abs(exact) < 1_000_000:
        assert evaluate(f"V1 {sign} V2", values.__getitem__) == exact * SCALE
    python = {"=": "==", "<>": "!="}.get(relation, relation)
    assert evaluate(f"V1 {relation} V2", values.__getitem__) is eval(f"{a} {python} {b}")


@given(st.text(max_size=30))
def test_any_text_has_a_value_or_is_refused(text: str) -> None:
    found: int | None = None
    with suppress(ValueError):
        found = evaluate(text, lambda _name: SCALE)
    assert found is None or abs(found) < 2**31
