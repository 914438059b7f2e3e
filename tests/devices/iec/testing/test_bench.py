"""Programs of IEC 61131-3 under test in Python: calls, values of all types, time, forces and mocks."""

from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

import pytest

from fieldrig import MS, US, ArgumentError, ConfigError, ProgramBench, RigError, S, T, UnmetError, program
from fieldrig.errors import UsageError

TEXT = """
TYPE
    Mode : (IDLE, RUNNING);
    Pair : STRUCT a : INT; b : ARRAY[1..3] OF REAL; END_STRUCT;
    Percent : INT (0..100);
END_TYPE
FUNCTION_BLOCK Motor
VAR_INPUT start, stop : BOOL; pair : Pair; longest : TIME := T#1s; END_VAR
VAR_IN_OUT total : INT; END_VAR
VAR_OUTPUT run : BOOL; calls : INT; mode : Mode; END_VAR
VAR timer : TON; END_VAR
IF start AND NOT stop THEN run := TRUE; mode := RUNNING; END_IF;
IF stop THEN run := FALSE; mode := IDLE; END_IF
timer(IN := run, PT := longest);
calls := calls + Step(1);
total := total + calls;
IF timer.Q THEN run := FALSE; END_IF
END_FUNCTION_BLOCK
FUNCTION Step : INT
VAR_INPUT size : INT; END_VAR
Step := size;
END_FUNCTION
FUNCTION Divide : INT
VAR_INPUT a : INT; b : INT := 2; END_VAR
VAR_OUTPUT rest : INT; END_VAR
Divide := a / b; rest := a MOD b;
END_FUNCTION
FUNCTION Total : REAL
VAR_INPUT values : ARRAY[1..3] OF REAL; pair : Pair; END_VAR
Total := values[1] + values[2] + values[3] + pair.b[3];
END_FUNCTION
FUNCTION_BLOCK Endless
WHILE TRUE DO ; END_WHILE
END_FUNCTION_BLOCK
VAR_GLOBAL
    b : BOOL; i : LINT; u : USINT; w : WORD; r : REAL; lr : LREAL; s : STRING(5); ws : WSTRING; t : TIME; lt : LTIME;
    ch : CHAR; wch : WCHAR; ld : LDATE; lclock : LTOD; lstamp : LDT; link : REF_TO INT;
    d : DATE; clock : TOD; stamp : DT; m : Mode; p : Percent; q : Pair; grid : ARRAY[0..1, 5..6] OF DINT;
END_VAR
PROGRAM Main
VAR cycles : INT; fault : BOOL; zero : INT; END_VAR
cycles := cycles + Step(1);
IF fault THEN cycles := 1 / zero; END_IF
END_PROGRAM
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bench") / "motor.st"
    path.write_text(TEXT)
    return path


@pytest.fixture
def plc(file: Path) -> ProgramBench:
    return program(file, dialect="edition-3")


def test_a_block_is_called_with_inputs_and_its_variables_are_attributes(plc: ProgramBench) -> None:
    motor = plc.block("Motor")
    assert motor(start=True, total=5).run
    assert (motor.calls, motor.total, motor.mode, motor.timer.ET) == (1, 6, "RUNNING", 0)
    plc.advance(T("999ms"))
    assert motor(start=False).run
    plc.advance(1 * MS)
    assert not motor().run
    assert (motor.calls, motor.total, motor.timer.Q, plc.now_ns) == (3, 11, True, 1 * S)


def test_instances_have_their_own_variables_and_one_clock(plc: ProgramBench) -> None:
    first = plc.block("motor")
    first(start=True)
    second = plc.block("Motor")
    plc.advance(1 * S)
    first()
    assert (first.run, first.calls, second.run, second.calls) == (False, 2, False, 0)


def test_a_variable_may_be_set_also_inside(plc: ProgramBench) -> None:
    motor = plc.block("Motor")
    motor.calls = 41
    motor.timer.PT = T("5s")
    motor.pair = {"b": [1, 2.5, 3]}
    motor(pair={"a": 7})
    assert (motor.calls, motor.pair) == (42, {"a": 7, "b": [1.0, 2.5, 3.0]})


def test_a_function_returns_its_result_and_has_its_outputs(plc: ProgramBench) -> None:
    divide: Any = plc.function("Divide")
    assert (divide(7, 3), divide.outputs) == (2, {"rest": 1})
    assert (divide(b=4, a=9), divide(7)) == (2, 3)  # b begins again with its start value
    assert plc.function("Total")([1, 2, 3], {"b": [0, 0, 4.5]}) == 10.5


VALUES = [
    ("b", True),
    ("i", -(2**63)),
    ("u", 255),
    ("w", 0xFFFF),
    ("r", 1.5),
    ("lr", 1.1),
    ("s", "abcde"),
    ("ws", "€"),
    ("t", 1500 * MS),
    ("lt", 1 * US + 1),
    ("d", date(2026, 11, 29)),
    ("clock", time(12, 30, 15, 1000)),
    ("stamp", datetime(2026, 11, 29, 1, 2, 3)),  # noqa: DTZ001  the language knows no zones
    ("ch", "x"),
    ("wch", "€"),
    ("ld", date(2026, 11, 29)),
    ("lclock", 123_456_789),
    ("lstamp", 1_700_000_000_123_456_789),
    ("link", 0),
    ("m", "RUNNING"),
    ("p", 100),
    ("q", {"a": 1, "b": [1.0, 2.0, 3.0]}),
    ("q.b", [4.0, 5.0, 6.0]),
    ("q.b[2]", 9.5),
    ("grid", [[1, 2], [3, 4]]),
    ("grid[1,6]", -5),
]


@pytest.mark.parametrize(("path", "value"), VALUES)
def test_a_value_of_every_type_is_one_of_python(plc: ProgramBench, path: str, value: Any) -> None:
    plc[path] = value
    assert plc[path] == value


WRONG = [
    ("b", 1, "expected True or False"),
    ("i", 1.5, "expected a whole number"),
    ("u", 256, "expected 0 to 255"),
    ("u", "x", "expected a value of type USINT"),
    ("s", "abcdef", "at most 5 characters"),
    ("s", 5, "at most 5 characters"),
    ("t", 1, "expected a multiple of 1000000 ns"),
    ("t", "1s", "expected a time in nanoseconds"),
    ("ch", "xy", "expected a text of one character"),
    ("ch", "€", "up to '\\xff'"),
    ("wch", 65, "expected a text of one character"),
    ("link", "b", "expected None; only the program itself"),
    ("m", "STOPPED", "expected one of IDLE, RUNNING"),
    ("p", 101, "expected 0 to 100"),
    ("q", 5, "expected a dict"),
    ("q", {"c": 5}, "there are: a, b"),
    ("q", {"b": [1, 2]}, "expected a list of 3 values"),
    ("q", {"b": [1, 2, "x"]}, "expected a value of type REAL"),
    ("grid", [1, 2], "expected a list of 2 values"),
    ("d", None, "expected a time"),
    ("nowhere", 5, "expected a path"),
]


@pytest.mark.parametrize(("path", "value", "expected"), WRONG)
def test_a_value_that_does_not_fit_is_refused(plc: ProgramBench, path: str, value: Any, expected: str) -> None:
    with pytest.raises(ArgumentError, match=path) as refused:
        plc[path] = value
    assert expected in str(refused.value)


def test_tasks_run_when_they_are_started(plc: ProgramBench) -> None:
    plc.advance(1 * S)
    assert plc["Main.cycles"] == 0
    plc.start()
    plc.advance(95 * MS)
    assert plc["Main.cycles"] == 10
    plc.stop()
    plc.advance(1 * S)
    assert plc["Main.cycles"] == 10


def test_a_program_may_be_called_as_a_block(plc: ProgramBench) -> None:
    main = plc.block("Main")
    main()
    main()
    assert (main.cycles, plc["Main.cycles"]) == (2, 2)


def test_a_forced_variable_keeps_its_value(plc: ProgramBench) -> None:
    plc.force("Main.cycles", 7)
    plc.start()
    plc.advance(50 * MS)
    assert plc["Main.cycles"] == 7
    plc.release("main.cycles")
    plc.advance(50 * MS)
    assert plc["Main.cycles"] == 12


def test_until_waits_for_a_condition_and_says_when_it_does_not_come(plc: ProgramBench) -> None:
    plc.start()
    plc.until(lambda: plc["Main.cycles"] == 5, within=100 * MS)
    assert plc.now_ns // MS == 40
    with pytest.raises(UnmetError, match="within 20 ms"):
        plc.until(lambda: plc["Main.cycles"] == 5000, within=20 * MS)


def test_an_expectation_over_time_ends_at_the_instant_at_which_it_fails(plc: ProgramBench) -> None:
    plc.start()
    plc.stays(lambda: plc["Main.cycles"] < 5, during=39 * MS)
    plc.never(lambda: plc["Main.cycles"] == 6, during=10 * MS)
    with pytest.raises(UnmetError, match=r"the condition held at 5\d"):
        plc.never(lambda: plc["Main.cycles"] == 6, during=1 * S)
    with pytest.raises(UnmetError, match=r"the condition no longer held at 10\d"):
        plc.stays(lambda: plc["Main.cycles"] < 11, during=1 * S)
    plc.stays(lambda: plc["Main.cycles"] < 20, during=1 * S, until=lambda: plc["Main.cycles"] == 15)
    assert plc["Main.cycles"] == 15
    with pytest.raises(UnmetError, match="the end did not come within 20 ms"):
        plc.stays(lambda: True, during=20 * MS, until=lambda: plc["Main.cycles"] == 150)


def test_a_fault_of_a_task_is_an_error(plc: ProgramBench) -> None:
    plc["Main.fault"] = True
    plc.start()
    with pytest.raises(RigError, match=r"a division by zero in Main .*motor.st:43"):
        plc.advance(1 * S)


def test_a_fault_of_a_call_is_an_error(plc: ProgramBench) -> None:
    with pytest.raises(RigError, match=r"a division by zero in Divide .*motor.st:26"):
        plc.function("Divide")(1, 0)


def test_a_python_function_takes_the_place_of_a_function(plc: ProgramBench) -> None:
    motor = plc.block("Motor")
    motor(total=0)
    step = plc.mock("Step", lambda size: size + 40)
    motor()
    assert (motor.calls, motor.total, step.calls, step.arguments) == (42, 43, 1, [(1,)])
    step.stop()
    motor()
    assert motor.calls == 43
    assert plc.mock("Step", returns=-3).calls == 0
    assert motor().calls == 40


def test_a_python_function_takes_the_place_of_a_block(plc: ProgramBench) -> None:
    motor = plc.block("Motor")

    def timer(instance: Any) -> None:
        instance.Q = instance.IN

    plc.mock("TON", timer)
    motor(start=True)
    assert not motor.run


def test_a_mock_that_does_not_take_the_inputs_is_told_what_it_gets(plc: ProgramBench) -> None:
    plc.mock("Divide", lambda a: a)
    with pytest.raises(ArgumentError, match=r"the mock of Divide cannot be called: .*\n.*its inputs: a, b"):
        plc.function("Divide")(7, 2)


@pytest.mark.parametrize("expectation", ["until", "stays", "never"])
def test_a_condition_is_a_function(plc: ProgramBench, expectation: str) -> None:
    with pytest.raises(ArgumentError, match="a condition cannot be True"):
        getattr(plc, expectation)(True, 5 * MS)


def test_inputs_of_a_block_have_names(plc: ProgramBench) -> None:
    motor = plc.block("Motor")
    with pytest.raises(ArgumentError, match=r"Motor is given True without a name\n.*expected start="):
        motor(True)


def test_what_a_mock_raises_is_raised_in_the_test(plc: ProgramBench) -> None:
    def broken(size: int) -> int:
        raise LookupError("no sensor")

    plc.mock("Step", broken)
    with pytest.raises(LookupError, match="no sensor"):
        plc.block("Motor")()
    plc.mock("Step", lambda size: "much")
    with pytest.raises(ArgumentError, match="the result of Step"):
        plc.block("Motor")()


def test_reset_begins_again(plc: ProgramBench) -> None:
    motor = plc.block("Motor")
    motor(start=True)
    plc.mock("Step", returns=9)
    plc["i"], plc["s"] = 5, "x"
    plc.force("u", 3)
    plc.advance(1 * S)
    plc.reset()
    assert (plc.now_ns, plc["i"], plc["s"], plc["u"]) == (0, 0, "", 0)
    again = plc.block("Motor")
    assert (again.run, again.calls, again().calls) == (False, 0, 1)


def test_what_a_test_sees_has_values_and_last_changes(plc: ProgramBench) -> None:
    motor = plc.block("Motor")
    motor(start=True)
    plc.advance(1 * S)
    motor(start=False)
    assert repr(motor).startswith("Motor(start=FALSE, stop=FALSE, longest=T#1s, run=FALSE, calls=2")
    assert "Motor.run = FALSE since T#1s; before TRUE at T#0ms" in plc.told()


@pytest.mark.parametrize(
    ("name", "hint"), [("Moto", "did you mean Motor?"), ("Step", 'expected function("Step")'), (5, "there are: ")]
)
def test_an_unknown_block_is_refused(plc: ProgramBench, name: Any, hint: str) -> None:
    with pytest.raises(ArgumentError) as refused:
        plc.block(name)
    assert hint in str(refused.value)


def test_an_unknown_input_or_variable_is_refused(plc: ProgramBench) -> None:
    motor = plc.block("Motor")
    with pytest.raises(ArgumentError, match=r"did you mean start\?"):
        motor(strt=True)
    with pytest.raises(AttributeError, match=r"did you mean run\?"):
        assert motor.rum
    with pytest.raises(ArgumentError, match="takes 2 arguments"):
        plc.function("Divide")(1, 2, 3)
    with pytest.raises(ArgumentError, match="no further input 'c'"):
        plc.function("Divide")(c=3)


def test_a_program_with_mistakes_lists_all_of_them(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.st"
    wrong.write_text("PROGRAM Main\nVAR a : INT; END_VAR\na := b;\na := TRUE;\nEND_PROGRAM")
    with pytest.raises(ConfigError) as refused:
        program(wrong)
    assert [mistake.line for mistake in refused.value.mistakes] == [3, 4]


@pytest.mark.parametrize("files", [["gone.st"], [__file__], [5], []])
def test_a_file_that_is_no_program_is_refused(files: list[Any]) -> None:
    with pytest.raises((UsageError, ArgumentError)):
        program(*files)


@pytest.mark.parametrize("options", [{"dialekt": "epas-4"}, {"dialect": "edition-9"}])
def test_an_unknown_option_is_refused(file: Path, options: dict[str, str]) -> None:
    with pytest.raises(ArgumentError, match=r"did you mean|there are"):
        program(file, **options)


def test_t_takes_durations_as_the_language_writes_them() -> None:
    assert T("T#1h_30m") == T("1h30m") == T("90min") == 5_400 * S
    assert (T("TIME#1d"), T("LTIME#5ns"), T("1.5ms"), T("0s")) == (86_400 * S, 5, 1_500_000, 0)


def test_a_name_that_a_file_beside_the_program_declares_has_that_file_as_its_hint(tmp_path: Path) -> None:
    (tmp_path / "types.st").write_text("TYPE Box : STRUCT n : INT; END_STRUCT; END_TYPE")
    (tmp_path / "main.st").write_text("PROGRAM Main VAR b : Box; c : Unheard; END_VAR END_PROGRAM")
    with pytest.raises(ConfigError) as refused:
        program(tmp_path / "main.st")
    assert "types.st beside it declares it: give this file too" in str(refused.value)
    assert "Unheard is not declared\n    expected a type" in str(refused.value)


def test_an_index_outside_an_array_and_a_date_outside_its_type_say_what_is_possible(tmp_path: Path) -> None:
    (tmp_path / "main.st").write_text("PROGRAM Main VAR l : ARRAY[1..4] OF INT; d : DATE; END_VAR END_PROGRAM")
    plc = program(tmp_path / "main.st")
    with pytest.raises(ArgumentError, match="expected an index from 1 to 4"):
        plc["Main.l[5]"] = 1
    with pytest.raises(ArgumentError, match="expected 1970-01-01 to 2106-02-07"):
        plc["Main.d"] = date(1969, 12, 31)


@pytest.mark.parametrize("duration", ["soon", "10", 10, None, "-1s", "", "1h30", "T#", "1 s"])
def test_t_takes_durations_only(duration: Any) -> None:
    with pytest.raises(ArgumentError, match="is not a duration"):
        T(duration)


def test_instances_are_started_with_fb_init(tmp_path: Path) -> None:
    counter = """FUNCTION_BLOCK Counter
VAR n : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR
n := 7;
END_METHOD
n := n + 1;
END_FUNCTION_BLOCK"""
    (tmp_path / "counter.st").write_text(counter)
    plc = program(tmp_path / "counter.st", dialect="codesys")
    first = plc.block("Counter")
    assert first().n == 8
    second = plc.block("Counter")
    assert (first.n, second.n, second().n) == (8, 7, 8)
    plc.reset()
    assert plc.block("Counter").n == 7


LOCATED = """VAR_GLOBAL switch AT %IX0.0 : BOOL; lamp AT %QX1.3 : BOOL; total AT %MD4 : DINT; END_VAR
PROGRAM PLC_PRG
VAR enable AT %IX0.1 : BOOL; END_VAR
lamp := switch AND enable; total := total + 5;
END_PROGRAM
"""


def test_variables_with_an_address_are_read_and_set_like_others(tmp_path: Path) -> None:
    (tmp_path / "io.st").write_text(LOCATED)
    plc = program(tmp_path / "io.st")
    main = plc.block("PLC_PRG")
    plc["switch"] = main.enable = True
    main()
    assert (main.enable, plc["PLC_PRG.enable"], plc["lamp"], plc["total"]) == (True, True, True, 5)
    plc.reset()
    assert (plc["switch"], plc["lamp"], plc["total"]) == (False, False, 0)


def test_blocks_with_long_names_have_instances_of_their_own(tmp_path: Path) -> None:
    name = "ABlockWithANameOfThirtyOneChars"
    (tmp_path / "long.st").write_text(f"FUNCTION_BLOCK {name}\nVAR_INPUT x : INT; END_VAR\nEND_FUNCTION_BLOCK")
    plc = program(tmp_path / "long.st")  # names of EPAS-4 count to their 32nd character
    first, second = plc.block(name), plc.block(name)
    first(x=1)
    assert (first.x, second(x=2).x, first.x) == (1, 2, 1)


OBJECTS = """
TYPE Flags : STRUCT ready : BIT; lost : BIT; END_STRUCT END_TYPE
TYPE Split : UNION whole : DWORD; low : WORD; bytes : ARRAY[0..3] OF BYTE; END_UNION END_TYPE
FUNCTION_BLOCK Base
VAR_INPUT flags : Flags; split : Split; target : REFERENCE TO INT; END_VAR
VAR n : INT; END_VAR
METHOD Inc : INT
VAR_INPUT amount : INT := 1; END_VAR
VAR_OUTPUT twice : INT; END_VAR
n := n + amount; Inc := n; twice := 2 * n;
END_METHOD
METHOD Clear
n := 0;
END_METHOD
METHOD PRIVATE Secret : INT
Secret := 1;
END_METHOD
PROPERTY Count : INT
GET
Count := n;
END_GET
SET
n := Count;
END_SET
END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK Counter EXTENDS Base
METHOD Clear
n := 100;
END_METHOD
n := n + 10;
END_FUNCTION_BLOCK
"""


@pytest.fixture
def counter(tmp_path: Path) -> Any:
    (tmp_path / "counter.st").write_text(OBJECTS)
    return program(tmp_path / "counter.st", dialect="codesys").block("Counter")


def test_methods_and_properties_are_those_of_the_instance(counter: Any) -> None:
    assert (counter.Inc(), counter.Inc(5), counter.Inc.outputs) == (1, 6, {"twice": 12})
    assert (counter.inc(amount=2), counter.Count) == (8, 8)
    counter.Count = 50
    assert (counter.n, counter().n) == (50, 60)
    counter.Clear()
    assert counter.n == 100  # the method of the block that extends the other one
    assert counter.Secret() == 1  # a test sees all of a block
    with pytest.raises(ArgumentError, match="takes 1 argument\n"):
        counter.Inc(1, 2)


def test_components_of_unions_and_bits_are_read_and_written(counter: Any) -> None:
    counter.flags = {"lost": True}
    assert counter.flags == {"ready": False, "lost": True}
    counter.split = {"whole": 0x01020304}
    assert counter.split == {"whole": 0x01020304, "low": 0x0304, "bytes": [4, 3, 2, 1]}
    counter(split={"low": 0xFFFF})
    assert counter.split["whole"] == 0x0102FFFF


def test_a_reference_to_nothing_is_none_or_its_address(counter: Any) -> None:
    assert counter.target in (None, 0)


INIT = """FUNCTION_BLOCK Counter
VAR n : INT; name : STRING; delay : TIME; gain : REAL; on : BOOL; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains, bInCopyCode : BOOL; start : INT; text : STRING; wait : TIME; k : REAL; ready : BOOL; END_VAR
n := start; name := text; delay := wait; gain := k; on := ready;
END_METHOD
n := n + 1;
END_FUNCTION_BLOCK"""


def test_arguments_of_fb_init_are_given_by_name(tmp_path: Path) -> None:
    (tmp_path / "counter.st").write_text(INIT)
    plc = program(tmp_path / "counter.st", dialect="codesys")
    rest: dict[str, Any] = {"text": "it's $5", "wait": timedelta(seconds=2), "k": -1.5, "ready": True}
    first, second = plc.block("Counter", start=7, **rest), plc.block("Counter", start=-40, **rest)
    assert (first().n, second().n, first.name, first.delay, first.gain, first.on) == (
        8,
        -39,
        "it's $5",
        2 * S,
        -1.5,
        True,
    )
    with pytest.raises(ConfigError, match="start"):
        plc.block("Counter")
    with pytest.raises(ArgumentError, match="cannot be a constant"):
        plc.block("Counter", start=[1])
    assert (first.n, second().n) == (8, -38)
