"""Slices, faults, stacks, breakpoints, steps, and everything that a program does beyond arithmetic."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import ENOUGH_NS, IecBench, PlainHost, program

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.host import Library, NativeBlock, NativeFunction, Pending, Results
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.thread import Fault
from fieldrig_devices.iec.types import ObjectParameter, ObjectType, Value
from fieldrig_devices.languages.debugging.debuggee import Step


def state_of(bench: IecBench) -> WorkState:
    """The present state, which mypy must not take for the one that was compared before."""
    return bench.thread.state


EVERYTHING = """
TYPE Axis : STRUCT pos : REAL; speed : INT; name : STRING(8); END_STRUCT END_TYPE

FUNCTION Twice : DINT
VAR_INPUT x : DINT; END_VAR
VAR local : DINT := 3; END_VAR
Twice := x * 2 + local - 3;
local := 0;
END_FUNCTION

FUNCTION Longest : INT
VAR_INPUT a, b : STRING; END_VAR
VAR_OUTPUT both : INT; END_VAR
both := LEN(a) + LEN(b);
Longest := MAX(LEN(a), LEN(b));
END_FUNCTION

FUNCTION_BLOCK Ramp
VAR_INPUT target : REAL; END_VAR
VAR_OUTPUT value : REAL; reached : BOOL; END_VAR
VAR_IN_OUT count : INT; END_VAR
VAR n : INT; END_VAR
IF value < target THEN
  value := value + 0.5;
  n := n + 1;
ELSIF value > target THEN
  value := value - 0.25;
END_IF;
reached := value = target;
count := count + 1;
END_FUNCTION_BLOCK

PROGRAM PLC_PRG
VAR
  i, j, k, odd : INT;
  total, sum : DINT;
  text : STRING(12);
  axes : ARRAY[0..3] OF Axis;
  ramps : ARRAY[1..3] OF Ramp;
  counts : ARRAY[1..3] OF INT;
  state, chars : INT;
  flags : WORD;
  pt : POINTER TO INT;
  copy : Axis;
END_VAR
FOR i := 0 TO 3 DO
  axes[i].speed := axes[i].speed + i;
  axes[i].pos := axes[i].pos + Twice(i) * 0.1;
  FOR j := 0 TO 2 DO
    total := total + Twice(total) MOD 7 + Twice(Twice(j));
    IF j = 1 AND i > 1 THEN
      EXIT;
    END_IF;
  END_FOR;
  CASE i OF
    0: state := state + 1;
    1, 3: state := state + 10;
      axes[i].name := CONCAT(axes[i].name, 'x');
  ELSE
    state := state - 1;
  END_CASE;
END_FOR;
k := 3;
WHILE k > 0 DO
  ramps[k](target := k, count := counts[k]);
  k := k - 1;
END_WHILE;
REPEAT
  k := k + 1;
  IF k / 2 * 2 <> k THEN
    odd := odd + 1;
  END_IF;
  flags.3 := NOT flags.3;
UNTIL k >= 5 END_REPEAT;
chars := chars + Longest(a := axes[1].name, b := 'abc');
text := CONCAT(text, 'hello');
pt := ADR(counts[2]);
pt^ := pt^ + 100;
copy := axes[3];
END_PROGRAM
"""


@pytest.mark.long
@settings(max_examples=12, deadline=None)
@given(budgets=st.lists(st.integers(1, 3_000), min_size=1, max_size=3), cycles=st.integers(1, 3))
def test_slices_do_not_change_what_a_program_does(budgets: list[int], cycles: int) -> None:
    """Preempted after any instruction, the program has the same results and takes the same processor time."""
    whole, sliced = IecBench(EVERYTHING), IecBench(EVERYTHING)
    used = whole.cycle(cycles)
    taken = 0
    for _ in range(cycles):
        sliced.thread.start()
        turn = 0
        while sliced.thread.state is WorkState.READY:
            budget = budgets[turn % len(budgets)]
            taken += budget - sliced.thread.run(budget)
            turn += 1
    assert sliced.values() == whole.values()
    assert taken == used


def test_single_instructions_do_the_same_as_the_whole() -> None:
    whole, stepped = IecBench(EVERYTHING), IecBench(EVERYTHING)
    used = whole.cycle(2)
    taken = 0
    for _ in range(2):
        stepped.thread.start()
        while stepped.thread.state is not WorkState.ENDED:
            stepped.thread.step(Step.INTO)
            while stepped.thread.state is WorkState.READY:
                taken += 10_000 - stepped.thread.run(10_000)
    assert stepped.values() == whole.values()
    assert taken == used


ALIASES = """
TYPE Pair : STRUCT a, b : INT; END_STRUCT END_TYPE
VAR_GLOBAL shared : Acc; total : INT; END_VAR
FUNCTION_BLOCK Acc
VAR_INPUT x : INT; END_VAR
VAR_OUTPUT sum : INT; END_VAR
VAR n : INT; END_VAR
n := n + x;
shared.x := shared.x + 1;
sum := sum + shared.x + x + x + n;
total := total + sum + shared.sum + x + total;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Via
VAR_IN_OUT v : INT; END_VAR
v := v + 1; v := v + v;
END_FUNCTION_BLOCK
FUNCTION Bump : INT
VAR_IN_OUT v : INT; END_VAR
v := v + 3; Bump := v + v;
END_FUNCTION
PROGRAM PLC_PRG
VAR
  i, x, y, z : INT; p : POINTER TO INT; a : ARRAY[0..3] OF INT; one, two : Pair; own : Acc; via : Via;
  n AT %MW7 : INT; w : WORD;
END_VAR
p := ADR(x);
FOR i := 0 TO 3 DO
  x := x + 1; p^ := p^ * 2; y := y + x + x + x;
END_FOR
FOR i := 0 TO 3 DO
  a[1] := a[1] + 1; a[i] := a[i] + 10; z := z + a[1] + a[1] + a[1] + a[3];
END_FOR
FOR i := 0 TO 3 DO
  one.a := one.a + 1; two.a := two.a + 5; one.b := one.a + two.a + one.a; two := one; y := y + two.a + two.b;
END_FOR
FOR i := 0 TO 3 DO
  x := x + 1; via(v := x); y := y + x + x; y := y + Bump(x) + x;
END_FOR
FOR i := 0 TO 3 DO
  shared(x := i); own(x := shared.sum); y := y + shared.sum + own.sum + total;
END_FOR
FOR i := 0 TO 3 DO
  n := n + 1; %MW7 := %MW7 + 2; y := y + n; w.1 := NOT w.1; w := w + 1; w.15 := w > 3;
END_FOR
END_PROGRAM
"""


def test_what_is_reached_in_two_ways_is_one_and_the_same() -> None:
    """The fast build keeps cells in local variables; single instructions read each from memory."""
    whole, stepped = IecBench(ALIASES), IecBench(ALIASES)
    for _ in range(3):
        whole.cycle()
        stepped.thread.start()
        while stepped.thread.state is not WorkState.ENDED:
            stepped.thread.step(Step.INTO)
            while stepped.thread.state is WorkState.READY:
                stepped.thread.run(10_000)
        assert stepped.values() == whole.values()
        assert [stepped[path] for path in ("total", "shared.sum", "shared.x")] == [
            whole[path] for path in ("total", "shared.sum", "shared.x")
        ]


def test_a_fault_in_an_inlined_block_has_its_own_place() -> None:
    text = """FUNCTION_BLOCK Inner
VAR_INPUT x : INT; END_VAR
VAR y : INT; END_VAR
y := y + 1;
y :=
 y / x;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Outer
VAR inner : Inner; END_VAR
inner(x := 0);
END_FUNCTION_BLOCK
"""
    bench = IecBench(text + program("outer : Outer;", "outer();"))
    bench.cycle()
    fault = bench.thread.fault
    assert fault is not None
    assert (fault.code, fault.pou, fault.line) == ("division", "Inner", 5)
    assert [(place.routine, place.line) for place in fault.calls] == [("Outer", 10), ("PLC_PRG", 16)]
    assert bench["outer.inner.y"] == 1


def test_everything_has_the_results_of_python() -> None:
    """The same program written in Python."""
    bench = IecBench(EVERYTHING)
    bench.cycle(2)
    total = 0
    for _ in range(2):
        for i in range(4):
            for j in range(3):
                total += total * 2 % 7 + 4 * j
                if j == 1 and i > 1:
                    break
    assert bench["total"] == total
    assert [bench[f"counts[{k}]"] for k in (1, 2, 3)] == [2, 202, 2]
    assert [bench[f"ramps[{k}].value"] for k in (1, 2, 3)] == [1.0, 1.0, 1.0]
    assert (bench["state"], bench["odd"], bench["flags"], bench["text"]) == (40, 6, 0, "hellohello")
    assert (bench["chars"], bench["copy.name"], bench["axes[3].speed"]) == (6, "xx", 6)


# ---- faults

FAULTS = [
    ("a : ARRAY[1..3] OF INT; i : INT := 4;", "a[i] := 1;", "array bounds"),
    ("a : ARRAY[1..3] OF INT; i : INT := 0; x : INT;", "x := a[i];", "array bounds"),
    ("a : ARRAY[1..3, 0..1] OF INT; i : INT := 2;", "a[1, i] := 1;", "array bounds"),
    ("x, y : INT;", "x := 1 / y;", "division"),
    ("x, y : INT;", "x := 1 MOD y;", "division"),
    ("x, y : REAL;", "x := 1.0 / y;", "division"),
    ("x, y : LREAL;", "x := 1.0 / y;", "division"),
    ("p : POINTER TO INT; x : INT;", "x := p^;", "pointer"),
    ("p : POINTER TO INT;", "p^ := 5;", "pointer"),
    ("p : POINTER TO INT; x : INT;", "p := 16#FFFFFFFF; x := p^;", "pointer"),
    ("p : POINTER TO INT;", "p := 16#0FFFFFFF; p^ := 1;", "pointer"),
    ("p : POINTER TO TON; x : INT;", "p := ADR(x); p^(IN := TRUE);", "pointer"),
    ("s : INT(1..5); i : INT := 6;", "s := i;", "subrange"),
]


@pytest.mark.manual("PD-102")
@pytest.mark.parametrize(("declarations", "body", "code"), FAULTS)
def test_a_fault_stops_the_task_with_its_place(declarations: str, body: str, code: str) -> None:
    bench = IecBench(program(declarations, f"\n\n{body}"))
    bench.cycle()
    fault = bench.thread.fault
    assert fault is not None
    assert (fault.code, fault.pou, fault.file, fault.line, fault.calls) == (code, "PLC_PRG", "main.st", 7, ())
    assert bench.thread.run(1_000) == 1_000


RECURSION = """FUNCTION Down : DINT
VAR_INPUT n : DINT; END_VAR
IF n > 0 THEN
  Down := Down(n - 1) + n;
END_IF;
END_FUNCTION
PROGRAM PLC_PRG
VAR n, sum : DINT; END_VAR
sum := Down(n);
END_PROGRAM
"""


@pytest.mark.manual("PD-317")
def test_recursion_works_as_far_as_the_stack_has_room() -> None:
    bench = IecBench(RECURSION)
    bench["n"] = 200
    bench.cycle()
    assert bench["sum"] == 20_100
    bench["n"] = 1_000_000
    bench.cycle()
    fault = bench.thread.fault
    assert isinstance(fault, Fault)
    assert fault.code == "stack"
    assert 250 < len(fault.calls) <= 10_240 // 20
    bench["n"] = 3
    bench.cycle()
    assert bench["sum"] == 6


def test_an_endless_loop_gives_way() -> None:
    bench = IecBench(program("n : DINT;", "WHILE TRUE DO n := n + 1; END_WHILE"))
    bench.thread.start()
    for _ in range(10):
        assert bench.thread.run(100_000) <= 0
    assert bench.thread.state is WorkState.READY


# ---- calls

ORDER = """VAR_GLOBAL trace : STRING; n : INT; END_VAR
FUNCTION Note : INT
VAR_INPUT what : STRING(4); value : INT; END_VAR
trace := CONCAT(trace, what);
n := n + 1;
Note := value;
END_FUNCTION
PROGRAM PLC_PRG
VAR a, b : INT; c, d : BOOL; x : ARRAY[1..3] OF INT; END_VAR
a := Note('a', 1) + Note('b', Note('c', 5)) * Note('d', 3);
b := n + Note('e', 10) + n;
c := Note('f', 0) = 1 AND Note('g', 1) = 1;
x[Note('h', 2)] := Note('i', 7);
IF Note('j', 1) = 1 THEN d := Note('k', 1) > 0; END_IF;
END_PROGRAM
"""


def test_functions_in_expressions_are_called_from_left_to_right() -> None:
    bench = IecBench(ORDER)
    bench.cycle()
    assert bench["trace"] == "acbdefgihjk"
    assert (bench["a"], bench["b"], bench["x[2]"], bench["d"]) == (16, 4 + 10 + 5, 7, True)


IN_OUT = """TYPE Pair : STRUCT a, b : INT; END_STRUCT END_TYPE
FUNCTION Swap : BOOL
VAR_IN_OUT p : Pair; n : INT; END_VAR
VAR t : INT; END_VAR
t := p.a; p.a := p.b; p.b := t; n := n + 1; Swap := TRUE;
END_FUNCTION
PROGRAM PLC_PRG
VAR pairs : ARRAY[0..2] OF Pair; i : INT := 1; done : BOOL; m AT %MW5 : INT; END_VAR
pairs[1].a := 3; pairs[1].b := 4;
done := Swap(pairs[i], pairs[0].a);
done := Swap(pairs[i], m);
END_PROGRAM
"""


@pytest.mark.manual("PD-352")
def test_in_out_is_passed_by_address_and_markers_are_copied_back() -> None:
    bench = IecBench(IN_OUT)
    bench.cycle()
    assert (bench["pairs[1].a"], bench["pairs[1].b"], bench["pairs[0].a"], bench["m"]) == (3, 4, 1, 1)
    assert bench.runtime.markers[10:12] == b"\x01\x00"


ACTIONS = """FUNCTION_BLOCK Box
VAR_INPUT x : INT; END_VAR
VAR n : INT; END_VAR
n := n + x;
Reset;
ACTION Reset:
IF n > 10 THEN
  n := 0;
END_IF;
END_ACTION
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR b : Box; END_VAR
b(x := 4);
END_PROGRAM
"""


def test_actions_work_on_the_instance_of_their_block() -> None:
    bench = IecBench(ACTIONS)
    seen = []
    for _ in range(4):
        bench.cycle()
        seen.append(bench["b.n"])
    assert seen == [4, 8, 0, 4]


# ---- memory


def test_pointers_to_another_type_see_the_bytes() -> None:
    bench = IecBench(
        program(
            "d : DWORD := 16#44332211; w : WORD; r : REAL := 1.0; bits : DWORD; a : ARRAY[0..3] OF BYTE; i : INT;"
            "s : STRING(5) := 'AB'; first : BYTE; pw : POINTER TO WORD; pd : POINTER TO DWORD; pb : POINTER TO BYTE;",
            "pw := ADR(d); w := pw^; pd := ADR(r); bits := pd^; pd := ADR(a); pd^ := 16#04030201;"
            "pb := ADR(i) + 1; pb^ := 16#80; pb := ADR(s) + 1; first := pb^; pb^ := 16#43;",
        )
    )
    bench.cycle()
    assert (bench["w"], bench["bits"], bench["first"], bench["s"]) == (0x2211, 0x3F800000, 0x42, "AC")
    assert [bench[f"a[{number}]"] for number in range(4)] == [1, 2, 3, 4]
    assert bench["i"] == -32768


def test_a_pointer_to_a_variable_of_a_function_works_while_it_runs() -> None:
    text = """FUNCTION Inner : INT VAR_INPUT p : POINTER TO INT; END_VAR p^ := p^ + 1; Inner := p^; END_FUNCTION
    FUNCTION Outer : INT VAR x : INT := 41; r : INT; END_VAR r := Inner(ADR(x)); Outer := x; END_FUNCTION
    """
    bench = IecBench(text + program("n : INT;", "n := Outer();"))
    bench.cycle(2)
    assert bench["n"] == 42


@pytest.mark.manual("PD-070", "PD-364", "PD-384")
def test_located_variables_are_read_and_written_at_once() -> None:
    bench = IecBench(
        program(
            "a AT %IX5.2 : BOOL; w AT %IW3 : INT; q AT %QB7 : BYTE; m AT %MD48 : DINT; r AT %MD1 : REAL; b : BOOL;",
            "%QX2.1 := a; q := 16#55; m := w; b := %IX5.2; r := 0.5; %QW10 := 16#1234;",
        )
    )
    host = bench.host
    host.inputs[10], host.inputs[6:8] = 4, b"\xfe\xff"
    bench.cycle()
    assert (bench["b"], host.outputs[4], host.outputs[7]) == (True, 2, 0x55)
    assert host.outputs[20:22] == b"\x34\x12"
    assert host.written == [4, 7, 20, 21]
    assert bench.runtime.markers[192:196] == b"\xfe\xff\xff\xff"
    assert bench.runtime.markers[4:8] == b"\x00\x00\x00\x3f"


def test_strings_are_cut_to_the_length_of_the_variable() -> None:
    bench = IecBench(program("s : STRING(5); t : STRING := 'abcdefgh'; n : INT;", "s := t; n := LEN(s);"))
    bench.cycle()
    assert (bench["s"], bench["n"]) == ("abcde", 5)


# ---- the host

LIBRARY = """FUNCTION Plus : INT VAR_INPUT a, b : INT; END_VAR {native} END_FUNCTION
FUNCTION Slow : INT VAR_INPUT a : INT; END_VAR {native} END_FUNCTION
FUNCTION_BLOCK Tally VAR_INPUT step : INT; END_VAR VAR_OUTPUT sum : INT; big : BOOL; END_VAR {native}
END_FUNCTION_BLOCK
"""


class Library1:
    """Native functions and a block that keeps its sums by the address of the instance."""

    def __init__(self) -> None:
        self.sums: dict[int, int] = {}
        self.asked: list[Pending] = []
        self.library = Library(
            "test.lib",
            LIBRARY,
            {"plus": NativeFunction(lambda a, b: (a + b,)), "slow": NativeFunction(self._slow, is_slow=True)},
            {"tally": NativeBlock(self._tally, forget=self.sums.clear)},
        )

    def _slow(self, a: Value) -> Pending:
        self.asked.append(Pending())
        return self.asked[-1]

    def _tally(self, address: int, step: int) -> Results:
        self.sums[address] = self.sums.get(address, 0) + step
        return self.sums[address], self.sums[address] > 10


def test_native_functions_and_blocks() -> None:
    native = Library1()
    host = PlainHost([native.library])
    bench = IecBench(
        program(
            "t, u : Tally; n : INT; b : BOOL;", "t(step := 4, big => b); u(step := 1); n := Plus(t.sum, Plus(1, 2));"
        ),
        host=host,
    )
    bench.cycle(3)
    assert (bench["t.sum"], bench["u.sum"], bench["b"], bench["n"]) == (12, 3, True, 15)


def test_a_slow_function_holds_its_task_until_the_answer() -> None:
    native = Library1()
    bench = IecBench(program("n, m : INT;", "m := m + 1; n := Slow(1) + 100;"), host=PlainHost([native.library]))
    thread = bench.thread
    thread.start()
    left = thread.run(ENOUGH_NS)
    assert 0 < left < ENOUGH_NS
    assert thread.state is WorkState.WAITING
    assert thread.wake is native.asked[0]
    assert thread.run(ENOUGH_NS) == ENOUGH_NS
    native.asked[0].finish(7)
    assert state_of(bench) is WorkState.READY
    thread.run(ENOUGH_NS)
    assert (bench["n"], bench["m"], state_of(bench)) == (107, 1, WorkState.ENDED)


KIND = ObjectType(
    "MC_4",
    (
        ObjectParameter("Speed", 3, Elementary.REAL, is_writable=True),
        ObjectParameter("Name", 4, Elementary.DINT, is_writable=True, is_slow=True),
    ),
)


def test_parameters_of_configuration_objects() -> None:
    host = PlainHost(objects=[ConfiguredObject("Axis_1", KIND, 1_000)])
    host.parameters[1_003] = 2.5
    text = """FUNCTION_BLOCK Drive
    VAR_INPUT r_MC_4 : MC_4; END_VAR
    VAR_OUTPUT speed : REAL; END_VAR
    speed := r_MC_4.Speed;
    END_FUNCTION_BLOCK
    """
    bench = IecBench(
        text
        + program(
            "d : Drive; n : DINT;",
            "d(r_MC_4 := Axis_1); Axis_1.Speed := d.speed * 2; n := Axis_1.Name + 1; Axis_1.Name := n;",
        ),
        host=host,
    )
    thread = bench.thread
    thread.start()
    thread.run(ENOUGH_NS)
    assert (host.parameters[1_003], thread.state) == (5.0, WorkState.WAITING)
    address, value, pending = host.pending[0]
    assert (address, value) == (1_004, None)
    pending.finish(41)
    thread.run(ENOUGH_NS)
    address, value, pending = host.pending[1]
    assert (address, value) == (1_004, 42)
    pending.finish()
    thread.run(ENOUGH_NS)
    assert (thread.state, bench["n"]) == (WorkState.ENDED, 42)
    del host.parameters[1_003]
    bench.cycle()
    assert bench.thread.fault is not None
    assert bench.thread.fault.code == "pointer"


# ---- debugging


def test_a_breakpoint_stops_the_thread_and_shows_its_calls() -> None:
    bench = IecBench(EVERYTHING)
    line = 1 + EVERYTHING[: EVERYTHING.index("n := n + 1")].count("\n")
    assert bench.runtime.break_at({"main.st": {line, 9_999}}) == {"main.st": {line}}
    thread = bench.thread
    thread.start()
    thread.run(ENOUGH_NS)
    assert thread.state is WorkState.STOPPED
    call = 1 + EVERYTHING[: EVERYTHING.index("ramps[k](")].count("\n")
    assert [(frame.routine, frame.line) for frame in thread.stack] == [("Ramp", line), ("PLC_PRG", call)]
    thread.go_on()
    thread.run(ENOUGH_NS)
    assert (thread.state, bench["k"]) == (WorkState.STOPPED, 2)
    bench.runtime.break_at({})
    thread.go_on()
    thread.run(ENOUGH_NS)
    assert state_of(bench) is WorkState.ENDED


STEPS = """FUNCTION F : INT
VAR_INPUT x : INT; END_VAR
F := x + 1;
F := F * 2;
END_FUNCTION
PROGRAM PLC_PRG
VAR a, b : INT; END_VAR
a := 1;
b := F(a);
a := 2;
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("kinds", "places"),
    [
        ([Step.OVER] * 2, [("PLC_PRG", 9), ("PLC_PRG", 10)]),
        ([Step.INTO] * 3, [("PLC_PRG", 9), ("F", 3), ("F", 4)]),
        ([Step.INTO, Step.INTO, Step.OUT], [("PLC_PRG", 9), ("F", 3), ("PLC_PRG", 9)]),
    ],
)
def test_single_steps(kinds: list[Step], places: list[tuple[str, int]]) -> None:
    bench = IecBench(STEPS)
    bench.thread.start()
    seen = []
    for kind in kinds:
        bench.thread.step(kind)
        while bench.thread.state is WorkState.READY:
            bench.thread.run(100)
        seen.append((bench.thread.stack[0].routine, bench.thread.stack[0].line))
    assert seen == places
    bench.thread.go_on()
    bench.thread.run(ENOUGH_NS)
    assert (bench["b"], bench.thread.state) == (4, WorkState.ENDED)


BODIES = """PROGRAM PLC_PRG
VAR a, i : INT; END_VAR
a := 1;
WHILE i < 1 DO
  i := i + 1;
  IF a = 2 THEN
    a := 3;
  END_IF
END_WHILE
CASE a OF
1:
  IF i = 5 THEN
    a := 4;
  END_IF
2:
  a := 5;
END_CASE
IF a = 6 THEN
  a := 7;
END_IF
END_PROGRAM
"""


def test_steps_stop_at_no_line_that_does_not_run_and_go_on_in_the_next_cycle() -> None:
    bench = IecBench(BODIES)
    bench.thread.start()
    seen = []
    for _ in range(10):
        bench.thread.step(Step.OVER)
        while bench.thread.state is WorkState.READY:
            bench.thread.run(100)
        if bench.thread.state is WorkState.ENDED:
            bench.thread.start()
        seen.append(bench.thread.stack[0].line)
    assert seen == [4, 5, 6, 4, 10, 12, 18, 3, 4, 10]
    assert bench.thread.state is WorkState.STOPPED


def test_a_step_beyond_the_end_of_a_cycle_can_be_forgotten() -> None:
    bench = IecBench(STEPS)
    bench.thread.start()
    bench.thread.step(Step.OUT)
    bench.thread.run(ENOUGH_NS)
    assert state_of(bench) is WorkState.ENDED
    bench.thread.forget_step()
    bench.thread.start()
    assert state_of(bench) is WorkState.READY
