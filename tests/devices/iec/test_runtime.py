"""Cold and warm start, retained data, online change, forcing, and variables by name."""

import pickle

import pytest
from iec_program import IecBench, PlainHost, program

from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.thread import Start
from fieldrig_devices.languages.mistakes import CompileError

RETAIN = """TYPE Pair : STRUCT a : INT; b : REAL := 0.5; END_STRUCT END_TYPE
FUNCTION_BLOCK Hours
VAR_INPUT run : BOOL; END_VAR
VAR RETAIN total : DINT; END_VAR
VAR cycles : INT; END_VAR
IF run THEN total := total + 1; END_IF
cycles := cycles + 1;
END_FUNCTION_BLOCK
VAR_GLOBAL RETAIN g : INT := 7; name : STRING := 'x'; pairs : ARRAY[0..1] OF Pair; END_VAR
PROGRAM PLC_PRG
VAR hours : Hours; plain : INT := 3; END_VAR
VAR RETAIN kept : LREAL := 1.5; END_VAR
hours(run := TRUE);
g := g + 1; plain := plain + 1; kept := kept * 2; name := CONCAT(name, 'y'); pairs[1].a := g;
END_PROGRAM
"""
PATHS = ("hours.total", "hours.cycles", "plain", "kept", "g", "name", "pairs[1].a", "pairs[0].b")


def values(bench: IecBench) -> list[object]:
    return [bench[path] for path in PATHS]


@pytest.mark.manual("PD-051", "PD-056")
def test_a_cold_start_resets_everything_and_a_warm_start_keeps_retained_variables() -> None:
    bench = IecBench(RETAIN)
    first = values(bench)
    assert first == [0, 0, 3, 1.5, 7, "x", 0, 0.5]
    bench.cycle(2)
    assert values(bench) == [2, 2, 5, 6.0, 9, "xyy", 9, 0.5]
    bench.runtime.initialise(Start.WARM)
    assert values(bench) == [2, 0, 3, 6.0, 9, "xyy", 9, 0.5]
    bench.runtime.initialise(Start.COLD)
    assert values(bench) == first


# ---- online change


@pytest.mark.manual("PD-225")
def test_an_online_change_keeps_the_values_of_all_variables_that_stay() -> None:
    bench = IecBench(RETAIN)
    bench.cycle(2)
    changed = (
        RETAIN.replace("cycles : INT;", "cycles : INT; more : INT := 5;")
        .replace("VAR_GLOBAL RETAIN", "VAR_GLOBAL RETAIN first : LREAL := 2.5;")
        .replace("plain := plain + 1;", "plain := plain + 100;")
    )
    compiled = bench.compile(changed, previous=bench.compiled)
    before = values(bench)
    where = bench.runtime.find("g").steps
    bench.runtime.change(compiled)
    assert values(bench) == before
    assert (bench["first"], bench["hours.more"]) == (2.5, 5)
    assert bench.runtime.find("g").steps == where
    bench.cycle()
    assert (bench["plain"], bench["hours.cycles"], bench["hours.total"]) == (105, 3, 3)


@pytest.mark.long
def test_many_online_changes_do_not_use_up_the_memory() -> None:
    bench = IecBench(program("a : ARRAY[1..1000] OF INT; n : INT;", "n := n + 1;"))
    compiled = bench.compiled
    sizes = set()
    for number in range(6):
        text = program(f"a : ARRAY[1..{1000 + number % 2}] OF INT; n : INT;", "n := n + 1;")
        compiled = bench.compile(text, previous=compiled)
        bench.runtime.change(compiled)
        bench.cycle()
        sizes.add(len(bench.runtime.memory))
    assert bench["n"] == 6
    assert len(sizes) <= 2


def test_a_program_that_does_not_compile_leaves_the_running_one() -> None:
    bench = IecBench(RETAIN)
    with pytest.raises(CompileError) as caught:
        bench.compile("PROGRAM PLC_PRG VAR x : INT; END_VAR x := y; z := 1; END_PROGRAM", previous=bench.compiled)
    assert sum(not mistake.is_note for mistake in caught.value.mistakes) == 2
    bench.cycle()
    assert bench["g"] == 8


def test_a_thread_whose_program_is_gone_says_so() -> None:
    bench = IecBench("PROGRAM Other END_PROGRAM " + program("n : INT;", "n := n + 1;"))
    thread = bench.runtime.thread(bench.compiled.program.pous["other"], 1)
    bench.runtime.change(bench.compile(program("n : INT;", "n := n + 1;"), previous=bench.compiled))
    with pytest.raises(ValueError, match="Other"):
        thread.start()


def test_a_compiled_program_comes_from_another_process() -> None:
    bench = IecBench(RETAIN)
    runtime = Runtime(pickle.loads(pickle.dumps(bench.compiled)), PlainHost())
    thread = runtime.thread(runtime.compiled.program.pous["plc_prg"])
    thread.start()
    thread.run(10**9)
    assert (thread.state, runtime.read(runtime.find("g"))) == (WorkState.ENDED, 8)
    line = 1 + RETAIN[: RETAIN.index("IF run")].count("\n")
    assert runtime.break_at({"main.st": {line}}) == {"main.st": {line}}
    thread.start()
    thread.run(10**9)
    assert (thread.state, thread.stack[0].line) == (WorkState.STOPPED, line)


# ---- values by name


def test_forced_variables_are_written_at_both_ends_of_a_cycle() -> None:
    bench = IecBench(program("a, b, seen : INT; q AT %QX0.3 : BOOL;", "seen := a; a := a + 1; b := b + 1; q := FALSE;"))
    runtime = bench.runtime
    runtime.force(runtime.find("PLC_PRG.a"), 40)
    runtime.force(runtime.find("PLC_PRG.q"), True)
    bench.cycle(2)
    assert (bench["seen"], bench["a"], bench["b"], bench.host.outputs[0]) == (40, 40, 2, 8)
    assert runtime.forced == {"PLC_PRG.a": 40, "PLC_PRG.q": True}
    runtime.force(runtime.find("PLC_PRG.a"), None)
    bench.cycle()
    assert bench["a"] == 41


def test_the_tree_of_variables() -> None:
    bench = IecBench(RETAIN)
    symbols = bench.runtime.symbols
    assert {"PLC_PRG", "g", "name", "pairs"} <= {symbol.name for symbol in symbols.children()}
    assert [symbol.path for symbol in symbols.children("plc_prg.HOURS")] == [
        "PLC_PRG.hours.run",
        "PLC_PRG.hours.total",
        "PLC_PRG.hours.cycles",
    ]
    assert [symbol.path for symbol in symbols.children("pairs")] == ["pairs[0]", "pairs[1]"]
    assert [symbol.path for symbol in symbols.children("pairs[1]")] == ["pairs[1].a", "pairs[1].b"]
    for path in ("", ".", "pairs[2]", "pairs.a", "pairs[0", "nothing", "g.x", "g[1]", "PLC_PRG.hours.x", "pairs]0["):
        assert symbols.find(path) is None


def test_two_indices_may_be_written_both_ways() -> None:
    bench = IecBench(program("a : ARRAY[1..2, 0..3] OF INT;", "a[2, 3] := 9;"))
    bench.cycle()
    symbols = bench.runtime.symbols
    first, second = symbols.find("PLC_PRG.a[2,3]"), symbols.find("plc_prg.a[2][3]")
    assert first == second
    assert first is not None
    assert first.path == "PLC_PRG.a[2,3]"
    assert bench.runtime.read(first) == 9


WRONG = [
    ("small", 200),
    ("small", 1.5),
    ("small", "x"),
    ("flag", 2),
    ("text", "abcdef"),
    ("text", 5),
    ("text", "€"),
    ("part", 9),
    ("light", 3),
    ("number", "1"),
    ("fixed", 1),
]


@pytest.mark.parametrize(("name", "value"), WRONG)
def test_a_value_that_does_not_fit_is_refused(name: str, value: float | str) -> None:
    bench = IecBench(
        "TYPE Light : (red, green); END_TYPE VAR_GLOBAL CONSTANT fixed : INT := 4; END_VAR "
        + program("small : SINT; flag : BOOL; text : STRING(5); part : INT(1..5); light : Light; number : REAL;", "")
    )
    with pytest.raises(ValueError, match="expected"):
        bench[name] = value


def test_good_values_are_stored_as_their_type() -> None:
    bench = IecBench(program("r : REAL; b : BOOL; l : LREAL; s : STRING;", ""))
    bench["r"], bench["b"], bench["l"], bench["s"] = 0.1, 1, 3, "Öl"
    assert bench["r"] == 0.100000001490116119384765625
    assert (bench["b"], type(bench["b"]), bench["l"], type(bench["l"]), bench["s"]) == (True, bool, 3.0, float, "Öl")


def test_the_sizes_that_are_compared_with_the_limits() -> None:
    small, large = (
        IecBench(program("n : INT;", "")),
        IecBench(program("n : INT; a : ARRAY[1..5000] OF INT;", "n := n + 1;")),
    )
    assert large.compiled.data_size - small.compiled.data_size == 10_000
    assert 4 <= large.compiled.code_size - small.compiled.code_size <= 40


def test_costs_are_scaled() -> None:
    from fieldrig_devices.iec.compiler import compile_project
    from fieldrig_devices.iec.costs import Costs
    from fieldrig_devices.languages.source_file import SourceFile

    text = program("n, i : INT;", "FOR i := 1 TO 100 DO n := n + i * 3; END_FOR")
    bench = IecBench(text)
    plain = bench.cycle()
    compiled = compile_project([SourceFile("main.st", text)], bench.host, costs=Costs(scale=3.0))
    bench.runtime = Runtime(compiled, bench.host)
    bench.thread = bench.runtime.thread(compiled.program.pous["plc_prg"])
    assert bench.cycle() == 3 * plain
