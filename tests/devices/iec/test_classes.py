"""CLASS of edition 3 with its access specifiers, and ABSTRACT, FINAL and OVERRIDE (IEC 61131-3:2013, 6.6.5)."""

import pytest
from iec_program import IecBench, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit

COUNTER = """
CLASS Counter
VAR
    present : INT;
    most : INT := 100;
END_VAR
VAR PUBLIC
    steps : INT := 1;
END_VAR
VAR PRIVATE
    calls : INT;
END_VAR

METHOD PUBLIC Up : INT
VAR_INPUT times : INT := 1; END_VAR
    present := LIMIT(0, present + times * steps, most);
    Note();
    Up := THIS.present;
END_METHOD

METHOD PUBLIC Number : INT
    Number := calls;
END_METHOD

METHOD Cap
VAR_INPUT most : INT; END_VAR
    THIS.most := most;
END_METHOD

METHOD PRIVATE Note
    calls := calls + 1;
END_METHOD
END_CLASS
"""
DOUBLE = """
CLASS FINAL DoubleCounter EXTENDS Counter
METHOD PUBLIC OVERRIDE Up : INT
VAR_INPUT times : INT := 1; END_VAR
    Cap(50);
    Up := SUPER.Up(times := 2 * times);
END_METHOD
END_CLASS
"""


def bench_of(before: str, declarations: str, body: str, dialect: Dialect = EDITION_3) -> IecBench:
    bench = IecBench(f"{before}\nPROGRAM PLC_PRG\nVAR\n{declarations}\nEND_VAR\n{body}\nEND_PROGRAM\n", dialect)
    bench.cycle()
    assert bench.thread.fault is None, bench.thread.fault
    return bench


def test_a_class_has_variables_for_each_instance_and_methods() -> None:
    bench = bench_of(
        COUNTER,
        "a, b : Counter := (steps := 3); list : ARRAY[1..2] OF Counter; x, y, z, n : INT;",
        """x := a.Up(); b.steps := 10; y := b.Up(times := 4); list[2].Up(7);
        z := list[2].Up() + list[1].Up(200); n := a.Number();""",
    )
    assert [bench[name] for name in ("x", "y", "z", "n", "list[2].present")] == [3, 40, 108, 1, 8]


def test_a_class_extends_another_one_and_calls_its_methods() -> None:
    bench = bench_of(
        COUNTER + DOUBLE, "d : DoubleCounter; x, y, n : INT;", "x := d.Up(5); y := d.Up(30); n := d.Number();"
    )
    assert [bench[name] for name in ("x", "y", "n")] == [10, 50, 2]


def test_the_code_of_an_abstract_class_reaches_the_methods_of_the_classes_that_extend_it() -> None:
    text = """
    INTERFACE I_Shape METHOD Area : REAL END_METHOD END_INTERFACE
    CLASS ABSTRACT Shape IMPLEMENTS I_Shape
    METHOD PUBLIC ABSTRACT Area : REAL END_METHOD
    METHOD PUBLIC Weight : REAL VAR_INPUT each : REAL; END_VAR Weight := each * Area(); END_METHOD
    END_CLASS
    CLASS Square EXTENDS Shape
    VAR PUBLIC side : REAL; END_VAR
    METHOD PUBLIC OVERRIDE Area : REAL Area := side * side; END_METHOD
    END_CLASS
    CLASS Disc EXTENDS Shape
    VAR PUBLIC radius : REAL; END_VAR
    METHOD PUBLIC OVERRIDE Area : REAL Area := 3.0 * radius * radius; END_METHOD
    END_CLASS
    """
    bench = bench_of(
        text,
        "s : Square := (side := 2.0); d : Disc := (radius := 3.0); a, b : REAL;",
        "a := s.Weight(10.0); b := d.Weight(0.5);",
    )
    assert (bench["a"], bench["b"]) == (40.0, 13.5)


def test_a_function_block_extends_a_class_and_has_a_body() -> None:
    text = (
        COUNTER
        + """
    FUNCTION_BLOCK Button EXTENDS Counter
    VAR_INPUT pressed : BOOL; END_VAR
    VAR_OUTPUT count : INT; END_VAR
    IF pressed THEN count := Up(2); END_IF
    END_FUNCTION_BLOCK
    """
    )
    bench = bench_of(text, "b : Button;", "b(pressed := TRUE); b(pressed := TRUE); b(pressed := FALSE);")
    assert bench["b.count"] == 4


def test_variables_of_a_class_may_be_retained_and_constant() -> None:
    text = """
    CLASS Hours
    VAR CONSTANT step : INT := 5; END_VAR
    VAR RETAIN total : INT; END_VAR
    METHOD PUBLIC Add : INT total := total + step; Add := total; END_METHOD
    END_CLASS
    """
    bench = bench_of(text, "h : Hours; n : INT;", "n := h.Add();")
    assert bench["n"] == 5
    assert bench.runtime.find("PLC_PRG.h.total").is_retain


def class_with(part: str, head: str = "A") -> str:
    return f"CLASS {head}\n{part}\nEND_CLASS\nPROGRAM PLC_PRG END_PROGRAM\n"


BASE = (
    "CLASS Base METHOD PUBLIC m : INT m := 1; END_METHOD "
    "METHOD PUBLIC FINAL f END_METHOD METHOD PRIVATE p END_METHOD END_CLASS\n"
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (class_with("VAR n : INT; END_VAR\nn := 1;"), "main.st:3:1: the class A has a body; expected only methods"),
        (
            class_with("ACTION x: END_ACTION"),
            "main.st:2:1: the class A has an action; expected METHOD x ... END_METHOD",
        ),
        (class_with("VAR_INPUT n : INT; END_VAR"), "main.st:2:1: VAR_INPUT in a class; expected VAR, VAR PUBLIC"),
        (
            (
                "CLASS A\nVAR_OUTPUT n : INT; END_VAR\nEND_CLASS\n"
                "PROGRAM PLC_PRG VAR a : A; n : INT; END_VAR n := a.n; END_PROGRAM"
            ),
            "main.st:2:1: VAR_OUTPUT in a class; expected VAR, VAR PUBLIC",
        ),
        (
            class_with("METHOD ABSTRACT m END_METHOD"),
            "the method m is ABSTRACT, and A is not; expected CLASS ABSTRACT A",
        ),
        (class_with("METHOD ABSTRACT m ; RETURN; END_METHOD", "ABSTRACT A"), "the method m is ABSTRACT and has a body"),
        (class_with("METHOD OVERRIDE m END_METHOD"), "the method m of A overrides nothing"),
        (BASE + class_with("METHOD PUBLIC m : INT END_METHOD", "A EXTENDS Base"), "expected METHOD PUBLIC OVERRIDE m"),
        (
            BASE + class_with("METHOD PUBLIC OVERRIDE m : DINT END_METHOD", "A EXTENDS Base"),
            "the method m of A differs from the one that it overrides",
        ),
        (BASE + class_with("METHOD PUBLIC OVERRIDE f END_METHOD", "A EXTENDS Base"), "the method f is FINAL above A"),
        (BASE + class_with("METHOD OVERRIDE p END_METHOD", "A EXTENDS Base"), "the method p is PRIVATE in Base"),
        (BASE.replace("CLASS Base", "CLASS FINAL Base", 1) + class_with("", "A EXTENDS Base"), "Base is FINAL"),
        (
            "CLASS ABSTRACT Base METHOD PUBLIC ABSTRACT m END_METHOD END_CLASS\n" + class_with("", "A EXTENDS Base"),
            "main.st:2:1: A has no code for m, which is ABSTRACT above it",
        ),
        (
            "FUNCTION_BLOCK Base END_FUNCTION_BLOCK\n" + class_with("", "A EXTENDS Base"),
            "Base is a FUNCTION_BLOCK; expected a class that A extends",
        ),
        (
            "INTERFACE I METHOD m END_METHOD END_INTERFACE\n" + class_with("METHOD m END_METHOD", "A IMPLEMENTS I"),
            "the method m of A is PROTECTED; expected PUBLIC for the interface I",
        ),
        (
            "CLASS Base METHOD m SUPER.n(); END_METHOD END_CLASS PROGRAM PLC_PRG END_PROGRAM",
            "SUPER.n",
        ),
    ],
)
def test_a_wrong_class_is_refused_with_what_is_expected(text: str, expected: str) -> None:
    found = refused(text, EDITION_3)
    assert any(expected in message for message in found), found
    assert sum("note:" not in message for message in found) == 1, found


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("c();", "c is an instance of the class Counter and cannot be called; expected a call of one of its methods"),
        ("Counter();", "Counter is a class, not an instance"),
        ("c.Cap(3);", "the method Cap of Counter is PROTECTED; expected a method that may be used here"),
        ("c.Note();", "the method Note of Counter is PRIVATE"),
        ("n := c.present;", "present is PROTECTED in Counter; expected a variable in VAR PUBLIC"),
        ("c.calls := 1;", "calls is PRIVATE in Counter"),
        ("n := c.Upp();", "Counter has no variable Upp"),
    ],
)
def test_what_is_not_public_cannot_be_used_from_outside(body: str, expected: str) -> None:
    found = refused(f"{COUNTER} PROGRAM PLC_PRG VAR c : Counter; n : INT; END_VAR {body} END_PROGRAM", EDITION_3)
    assert any(expected in message for message in found), found
    assert sum("note:" not in message for message in found) == 1, found


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("calls := 5;", "calls is PRIVATE in Counter; expected a variable of Heir"),
        ("THIS.calls := 5;", "calls is PRIVATE in Counter"),
        ("Note();", "the method Note of Counter is PRIVATE"),
        ("SUPER.Note();", "the method Note of Counter is PRIVATE"),
        ("SUPER();", "SUPER() has no function block above"),
    ],
)
def test_what_is_private_cannot_be_used_in_a_class_that_extends_it(statement: str, expected: str) -> None:
    heir = f"CLASS Heir EXTENDS Counter METHOD PUBLIC Try {statement} END_METHOD END_CLASS"
    found = refused(f"{COUNTER}{heir} PROGRAM PLC_PRG END_PROGRAM", EDITION_3)
    assert any(expected in message for message in found), found


@pytest.mark.parametrize("type", ["Shape", "ARRAY[1..2] OF Shape", "STRUCT s : Shape; END_STRUCT"])
def test_there_are_no_instances_of_an_abstract_class(type: str) -> None:
    shape = "CLASS ABSTRACT Shape METHOD ABSTRACT m END_METHOD END_CLASS"
    found = refused(f"{shape} PROGRAM PLC_PRG VAR s : {type}; END_VAR END_PROGRAM", EDITION_3)
    assert any("s is an instance of Shape, which is ABSTRACT" in message for message in found), found
    IecBench(f"{shape} FUNCTION f : INT VAR_IN_OUT s : Shape; END_VAR f := 1; END_FUNCTION {MAIN}", EDITION_3)


MAIN = "PROGRAM PLC_PRG END_PROGRAM"


# ---- function blocks in the dialects of tools


BLOCKS = """
FUNCTION_BLOCK ABSTRACT Base
VAR n : INT; END_VAR
METHOD ABSTRACT Weight : INT END_METHOD
METHOD PROTECTED Twice : INT Twice := 2 * Weight(); END_METHOD
METHOD FINAL Total : INT Total := Twice() + n; END_METHOD
PROPERTY ABSTRACT Size : INT GET END_GET END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK FINAL Heavy EXTENDS Base
METHOD Weight : INT Weight := 50; END_METHOD
PROPERTY Size : INT GET Size := 7; END_GET END_PROPERTY
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS])
def test_abstract_function_blocks(dialect: Dialect) -> None:
    bench = bench_of(BLOCKS, "h : Heavy; x, y : INT;", "x := h.Total(); y := h.Size;", dialect)
    assert (bench["x"], bench["y"]) == (100, 7)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "METHOD Weight : INT Weight := 50; END_METHOD",
            "",
            "Heavy has no code for Weight, which is ABSTRACT above it",
        ),
        ("PROPERTY Size : INT GET Size := 7; END_GET END_PROPERTY", "", "Heavy has no code for Size"),
        ("Weight := 50", "Weight := SUPER^.Weight()", "Weight is ABSTRACT above Heavy and has no code"),
        ("Weight : INT Weight := 50", "Weight : DINT Weight := 50", "the method Weight of Heavy differs"),
        ("METHOD FINAL Total", "METHOD PRIVATE Total", "the method Total of Base is PRIVATE"),
        ("h : Heavy", "h : Base", "h is an instance of Base, which is ABSTRACT"),
        ("x := h.Total()", "x := h.Twice()", "the method Twice of Base is PROTECTED"),
        ("FUNCTION_BLOCK ABSTRACT Base", "FUNCTION_BLOCK Base", "the method Weight is ABSTRACT, and Base is not"),
    ],
)
def test_wrong_function_blocks_are_refused(old: str, new: str, expected: str) -> None:
    text = f"{BLOCKS} PROGRAM PLC_PRG VAR h : Heavy; x : INT; END_VAR x := h.Total(); END_PROGRAM"
    assert text.count(old) == 1
    found = refused(text.replace(old, new), CODESYS)
    assert any(expected in message for message in found), found


def test_a_variable_of_a_function_block_may_be_public() -> None:
    text = "FUNCTION_BLOCK f VAR PUBLIC a : INT; END_VAR VAR public : INT; END_VAR public := a; END_FUNCTION_BLOCK"
    bench = bench_of(text, "x : f; n : INT;", "x.a := 5; x(); n := x.a;", CODESYS)
    assert (bench["n"], bench["x.public"]) == (5, 5)
    found = refused("FUNCTION f : INT VAR PUBLIC a : INT; END_VAR f := a; END_FUNCTION " + MAIN, EDITION_3)
    assert any("PUBLIC in a FUNCTION; expected VAR PUBLIC in a class or function block" in text for text in found)


# ---- the text


def test_a_class_is_printed_as_it_was_written() -> None:
    text = """\
CLASS ABSTRACT Counter EXTENDS Base IMPLEMENTS I_Up, I_Down
VAR PUBLIC RETAIN
    present : INT;
END_VAR

METHOD PUBLIC ABSTRACT Up : INT
END_METHOD
END_CLASS
"""
    unit, mistakes = parse(text, "main.st", EDITION_3)
    assert mistakes == []
    assert print_unit(unit) == text


@pytest.mark.parametrize(
    ("dialect", "expected"),
    [
        (CODESYS, "Classes need the dialect edition-3. Here a FUNCTION_BLOCK with methods does the same."),
        (EPAS_4, "CLASS is not supported. Use a FUNCTION or a FUNCTION_BLOCK."),
    ],
)
def test_other_dialects_have_no_classes(dialect: Dialect, expected: str) -> None:
    _, mistakes = parse("CLASS c END_CLASS", "main.st", dialect)
    assert mistakes[0].hint == expected


def test_a_variable_may_be_called_this_and_class_where_these_are_no_words() -> None:
    bench = bench_of(
        "TYPE s : STRUCT n : INT; END_STRUCT END_TYPE", "this : s; class : INT;", "this.n := 3; class := 4;", CODESYS
    )
    assert (bench["this.n"], bench["class"]) == (3, 4)
