"""Small programs of the kind that courses and libraries contain, with results that were worked out by hand.

The first line of a program names its dialects, and the last ones its results: `(* sum = 15 *)` is a variable of PLC_PRG
after the last cycle, and `(* fault: array bounds *)` the fault that stops the program.
"""

import re
from ast import literal_eval
from pathlib import Path

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, DIALECTS, EDITION_3, EPAS_4, Dialect

FILES = sorted((Path(__file__).parent / "programs").glob("*.st"))
HEAD = re.compile(r"\(\* dialects: ([\w, -]+?)(?:; cycles: (\d+), every (\d+) ms)? \*\)")
RESULT = re.compile(r"^\(\* ([\w.\[\],]+) = (.+) \*\)$", re.MULTILINE)
FAULT = re.compile(r"^\(\* fault: (.+) \*\)$", re.MULTILINE)
WORDS = {"TRUE": True, "FALSE": False}


def dialects_of(file: Path) -> list[str]:
    head = HEAD.match(file.read_text(encoding="ascii"))
    assert head is not None, file
    return head[1].split(", ")


CASES = [(file, dialect) for file in FILES for dialect in dialects_of(file)]


@pytest.mark.parametrize(("file", "dialect"), CASES, ids=lambda case: case.stem if isinstance(case, Path) else case)
def test_a_small_program_has_the_results_that_were_worked_out(file: Path, dialect: str) -> None:
    text = file.read_text(encoding="ascii")
    head, fault = HEAD.match(text), FAULT.search(text)
    assert head is not None
    bench = IecBench(text, DIALECTS[dialect])
    for number in range(int(head[2] or 1)):
        bench.host.ms = number * int(head[3] or 0)
        bench.cycle()
    if fault is not None:
        assert bench.thread.fault is not None
        assert bench.thread.fault.code == fault[1]
        return
    assert bench.thread.fault is None, bench.thread.fault
    results = RESULT.findall(text)
    assert results
    for name, shown in results:
        wanted = WORDS[shown] if shown in WORDS else literal_eval(shown)
        found = bench[name]
        assert type(found) is type(wanted), name
        assert found == (pytest.approx(wanted, rel=1e-6) if isinstance(wanted, float) else wanted), name


# ---- what the programs above do only where a dialect allows it


VOID = "FUNCTION Raise VAR_IN_OUT x : INT; END_VAR x := x + 1; END_FUNCTION "


@pytest.mark.parametrize(
    ("dialect", "body", "expected"),
    [
        (EPAS_4, "Raise(n);", "main.st:1:1: the function Raise has no type; expected FUNCTION Raise : INT"),
        (EDITION_3, "n := Raise(n);", "the function Raise has no result; expected a function with a type"),
        (CODESYS, "n := 1 + Raise(x := n);", "the function Raise has no result"),
    ],
)
def test_a_function_without_a_type_has_no_result(dialect: Dialect, body: str, expected: str) -> None:
    """Before, it was called nowhere, and nothing was said."""
    found = refused(VOID + program("n : INT;", body), dialect)
    assert any(expected in message for message in found), found
    assert sum("note:" not in message for message in found) == 1, found


@pytest.mark.parametrize(
    ("dialect", "body", "expected"),
    [
        (EPAS_4, "b := w.%B0;", "%B0 is a part of a value; expected the number of a bit"),
        (EDITION_3, "b := w.%B2;", "WORD has no part %B2; expected %B0 to %B1"),
        (EDITION_3, "w := w.%W0;", "WORD has no part %W0; expected a smaller part"),
        (EDITION_3, "x := b.%X8;", "BYTE has no bit 8; expected 0 to 7"),
        (EDITION_3, "b := r.%B0;", "r is a REAL and has no bits"),
        (EDITION_3, "k.%B0 := b;", "k is a constant"),
    ],
)
def test_a_part_that_a_value_does_not_have_is_refused(dialect: Dialect, body: str, expected: str) -> None:
    declarations = "w : WORD; b : BYTE; r : REAL; x : BOOL; END_VAR VAR CONSTANT k : ARRAY[0..0] OF WORD;"
    found = refused(program(declarations, body.replace("k.", "k[0].")), dialect)
    assert any(expected in message or "is a constant" in message for message in found), found


@pytest.mark.parametrize(
    ("kind", "body", "expected"),
    [
        (
            "U : UNION a : WORD; b : DWORD; END_UNION;",
            "v := TO_BIG_ENDIAN(u);",
            "TO_BIG_ENDIAN with a U; expected one of",
        ),
        ("U : STRUCT p : POINTER TO INT; END_STRUCT;", "v := FROM_BIG_ENDIAN(u);", "FROM_BIG_ENDIAN with a U"),
        ("U : STRUCT t : ARRAY[0..1] OF TOD; END_STRUCT;", "v := TO_LITTLE_ENDIAN(u);", "TO_LITTLE_ENDIAN with a U"),
        ("U : STRUCT w : WSTRING; END_STRUCT;", "v := TO_BIG_ENDIAN(u);", "TO_BIG_ENDIAN with a U"),
        ("U : STRUCT b : TON; END_STRUCT;", "v := TO_BIG_ENDIAN(u);", "TO_BIG_ENDIAN with a U"),
        ("U : STRUCT a : INT; END_STRUCT;", "n := Changed(TO_BIG_ENDIAN(u));", "is passed to the VAR_IN_OUT one"),
        ("U : STRUCT a : INT; END_STRUCT;", "n := TO_BIG_ENDIAN(u);", "TO_BIG_ENDIAN(...) is a U; expected INT"),
    ],
)
@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS], ids=str)
def test_a_structure_whose_bytes_have_no_other_order_is_refused(
    dialect: Dialect, kind: str, body: str, expected: str
) -> None:
    changed = "FUNCTION Changed : INT VAR_IN_OUT one : U; END_VAR Changed := 1; END_FUNCTION "
    found = refused(f"TYPE {kind} END_TYPE {changed}{program('u, v : U; n : INT;', body)}", dialect)
    assert [message for message in found if "note:" not in message and expected in message], found


@pytest.mark.parametrize(
    ("dialect", "declaration", "expected"),
    [
        (EPAS_4, "w AT %QW0.0.2 : WORD;", "the address %QW0.0.2 does not exist in the control configuration"),
        (EDITION_3, "w AT %QW0.0.128 : WORD;", "the last number of %QW0.0.128 is too large; expected 0 to 127"),
        (
            EDITION_3,
            "w AT %QW0.1.0 : WORD; b AT %QB65535 : BYTE;",
            "%QB65535 is where the addresses with several levels",
        ),
        (EDITION_3, "b AT %QB65535 : BYTE; w AT %QW0.1.0 : WORD;", "there is no place for %QW0.1.0 in its area"),
        (EPAS_4, "s : STRING(256);", "a STRING of 256 characters; expected 1 to 255 characters"),
        (EDITION_3, "s : WSTRING(32768);", "a WSTRING of 32768 characters; expected 1 to 32767 characters"),
        (EDITION_3, "s : STRING(0);", "a STRING of 0 characters; expected 1 to 32767 characters"),
        (CODESYS, "s : STRING(-1);", "a STRING of -1 characters; expected 0 to 1000000 characters"),
        (EPAS_4, "r AT %MB8 : REAL;", "the address %MB8 does not have the size of REAL; expected %MD"),
        (EPAS_4, "r AT %MD8 : LREAL;", "the size of LREAL; expected a type of at most 4 bytes"),
        (EDITION_3, "r AT %MD8 : LREAL;", "the size of LREAL; expected %ML"),
        (EDITION_3, "s AT %MB8 : STRING;", "a variable of type STRING cannot have an address"),
        (CODESYS, "r AT %MB65533 : REAL;", "the variable at %MB65533 ends at byte 65537 of its area"),
        (CODESYS, "r AT %MX8.0 : REAL;", "the address %MX8.0 does not have the size of REAL"),
        (CODESYS, "r AT %MB8 : BOOL;", "the address %MB8 does not have the size of BOOL; expected %MX"),
        (
            EDITION_3,
            "s : STRING(5); END_VAR VAR c : CHAR; END_VAR c := s[6]; VAR",
            "the index 6 is outside the array; expected 1 to 5",
        ),
        (CODESYS, "b : BOOL R_EDGE;", "R_EDGE is not known in this dialect; expected ;"),
        (EDITION_3, "b : BOOL R_EDGE;", "b has R_EDGE; expected it in VAR_INPUT of a function block or program"),
        (EDITION_3, "AT %MX8.0 : BOOL;", "got AT; expected a name in front of AT"),
    ],
)
def test_a_variable_that_its_address_or_its_length_does_not_allow_is_refused(
    dialect: Dialect, declaration: str, expected: str
) -> None:
    found = refused(program(declaration, ""), dialect)
    assert any(expected in message for message in found), found


BLOCK = "FUNCTION_BLOCK Tank VAR level : INT; END_VAR level := level + 1; END_FUNCTION_BLOCK "


def test_a_variable_of_an_instance_can_be_read_but_not_written_from_outside() -> None:
    found = refused(BLOCK + program("t : Tank;", "t.level := 5;"), CODESYS)
    assert any("t.level belongs to its block" in message for message in found), found
    found = refused(BLOCK + program("t : Tank; n : INT;", "n := t.level;"), EDITION_3)
    assert any("level is a VAR of Tank and not known outside" in message for message in found), found


def test_an_array_of_epas_has_all_start_values_or_none() -> None:
    found = refused(program("a : ARRAY[1..3] OF INT := 1, 2;", ""), EPAS_4)
    assert any("2 start values for 3 elements" in message for message in found), found
    bench = IecBench(
        program("a : ARRAY[1..2, 1..3] OF INT := [1, 2, 3, 4]; b : ARRAY[1..2] OF T := [5];", "").join(
            ["TYPE T : INT := 9; END_TYPE ", ""]
        ),
        EDITION_3,
    )
    assert [bench[name] for name in ("a[2,1]", "a[2,2]", "b[1]")] == [4, 0, 5]


COUNTED = """
FUNCTION Next : INT
VAR_STAT n : INT := 10; END_VAR
n := n + 1; Next := n;
END_FUNCTION
FUNCTION_BLOCK Ticket
VAR_STAT sold : INT; END_VAR
VAR_OUTPUT number : INT; END_VAR
METHOD Sell VAR_STAT calls : INT; END_VAR calls := calls + 1; sold := sold + 1; number := sold; END_METHOD
END_FUNCTION_BLOCK
"""


def test_static_variables_exist_once_and_keep_their_values_over_an_online_change() -> None:
    text = COUNTED + program("a, b : Ticket; n : INT;", "a.Sell(); b.Sell(); n := Next();")
    bench = IecBench(text, CODESYS)
    bench.cycle(2)
    names = ("a.number", "b.number", "n", "Next.n", "Ticket.sold", "Ticket.Sell.calls")
    assert [bench[name] for name in names] == [3, 4, 12, 12, 4, 4]
    changed = text.replace("VAR_STAT n : INT", "VAR_STAT more : INT; n : INT").replace("sold : INT;", "sold : DINT;")
    changed = changed.replace("number := sold", "number := DINT_TO_INT(sold)")
    bench.runtime.change(bench.compile(changed, previous=bench.compiled))
    bench.cycle()
    assert [bench[name] for name in ("n", "Next.more", "Ticket.sold")] == [13, 0, 2]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("b := s[4];", "the index 4 is outside the array; expected 0 to 3"),
        ("p['a'] := 1;", "the index is a STRING"),
        ("k[0] := 1;", "k is not a variable"),
    ],
)
def test_a_wrong_index_of_a_string_or_pointer_is_refused(body: str, expected: str) -> None:
    declarations = "s : STRING(3); b : BYTE; p : POINTER TO INT; END_VAR VAR CONSTANT k : STRING := 'x';"
    found = refused(program(declarations, body), CODESYS)
    assert any(expected in message for message in found), found
    assert any("not an array" in message for message in refused(program(declarations, "b := s[1];"), EPAS_4))
    assert any(
        "is a CHAR; expected BYTE" in message for message in refused(program(declarations, "b := s[1];"), EDITION_3)
    )


def test_variables_of_instances_belong_to_methods() -> None:
    text = "FUNCTION_BLOCK B VAR_INST n : INT; END_VAR END_FUNCTION_BLOCK "
    assert any("VAR_INST in a FUNCTION_BLOCK" in message for message in refused(text + program("", ""), CODESYS))


@pytest.mark.parametrize(
    ("dialect", "body", "expected"),
    [
        (EDITION_3, "n := n := 1;", "A statement assigns to one variable only"),
        (CODESYS, "n := 1 := n;", "1 is a value; expected a variable"),
    ],
)
def test_a_chained_assignment_has_variables_in_front(dialect: Dialect, body: str, expected: str) -> None:
    assert any(expected in message for message in refused(program("n : INT;", body), dialect))


@pytest.mark.parametrize(
    ("dialect", "body", "expected"),
    [
        (EDITION_3, "n := F(n);", "VAR_IN_OUT CONSTANT; expected CONSTANT behind VAR"),
        (CODESYS, "n := F(n + 1);", "n + 1 is passed to the VAR_IN_OUT k"),
        (CODESYS, "n := F('a');", "'a' is a STRING(1); expected INT"),
        (CODESYS, "n := G(n);", "k is a constant"),
    ],
)
def test_a_constant_reference_is_only_read(dialect: Dialect, body: str, expected: str) -> None:
    text = "FUNCTION F : INT VAR_IN_OUT CONSTANT k : INT; END_VAR F := k; END_FUNCTION "
    text += "FUNCTION G : INT VAR_IN_OUT CONSTANT k : INT; END_VAR k := 1; END_FUNCTION " if "G" in body else ""
    assert any(expected in message for message in refused(text + program("n : INT;", body), dialect))


@pytest.mark.parametrize(
    ("dialect", "call", "expected"),
    [
        (EDITION_3, "F(1)", "the arguments b, x are missing in the call of F"),
        (EDITION_3, "F(a := 1)", "the argument x is missing in the call of F"),
        (EPAS_4, "F(a := 1, x := n)", "the argument b is missing in the call of F"),
        (CODESYS, "F(a := 1, x := n)", "the argument b is missing in the call of F"),
    ],
)
def test_only_a_call_with_names_leaves_inputs_out_in_edition_3(dialect: Dialect, call: str, expected: str) -> None:
    text = "FUNCTION F : INT VAR_INPUT a, b : INT; END_VAR VAR_IN_OUT x : INT; END_VAR F := a; END_FUNCTION "
    found = refused(text + program("n : INT;", f"n := {call};"), dialect)
    assert any(expected in message for message in found), found


def test_a_comment_in_edition_3_ends_where_all_of_it_do() -> None:
    found = refused("(* a (* b *) " + program("n : INT;", "n := 1;"), EDITION_3)
    assert any("the comment is not closed" in message for message in found), found


@pytest.mark.parametrize(
    ("dialect", "value", "expected"),
    [
        (EPAS_4, "T#-5s", "a time cannot be negative; expected T#0ms or more"),
        (CODESYS, "T#-5s", "a time cannot be negative; expected T#0ms or more"),
        (EPAS_4, "T#1s - T#2s", "the difference of these times is negative; expected T#0s or more"),
        (CODESYS, "SUB_TIME(T#1s, T#2s)", "the difference of these times is negative"),
        (CODESYS, "D#1998-02-13 - D#1998-02-14", "the difference of these times is negative"),
        (CODESYS, "LTIME#1us - LTIME#2us", "the difference of these times is negative"),
        (EPAS_4, "T#1s * -1", "the result is a negative time; expected T#0s or more"),
        (EPAS_4, "-3 * T#1s", "the result is a negative time"),
        (CODESYS, "T#1s * -1.5", "the result is a negative time"),
        (CODESYS, "T#1s / -2", "the result is a negative time"),
        (CODESYS, "t / INT#-2", "the result is a negative time"),
        (CODESYS, "MULTIME(t, -2)", "the result is a negative time"),
        (CODESYS, "LTIME#1us * -1", "the result is a negative time"),
        (CODESYS, "-t", "a minus sign in front of a TIME; expected a number"),
        (EDITION_3, "T#24d20h31m23s648ms", "is too long; expected T#-24d20h31m23s648ms to T#24d20h31m23s647ms"),
        (EPAS_4, "T#49d17h2m47s296ms", "is too long; expected at most T#49d17h2m47s295ms"),
    ],
)
def test_a_time_that_the_dialect_does_not_have_is_refused(dialect: Dialect, value: str, expected: str) -> None:
    found = refused(program("t : TIME;", f"t := {value};"), dialect)
    assert any(expected in message for message in found), found


SHARED = "UNION w : UINT; s : {} END_UNION"
START = "STRUCT n : INT := 77; m : SECOND; END_STRUCT;"


@pytest.mark.parametrize("second", ["BIT", "INT", "LREAL"])
@pytest.mark.parametrize(
    ("types", "kind"),
    [
        (f"TYPE V : {SHARED.format(START)}; END_TYPE", "V"),
        (
            f"TYPE V : {SHARED.format('ARRAY[0..1] OF T;')}; END_TYPE TYPE T : STRUCT k : {START} END_STRUCT; END_TYPE",
            "V",
        ),
        (f"TYPE V : UNION b : BYTE; v : {SHARED.format(START)}; END_UNION; END_TYPE", "V"),
        ("", SHARED.format(START)),
    ],
)
def test_a_union_has_the_start_values_of_its_structures(types: str, kind: str, second: str) -> None:
    text = f"{types}\n{program(f'u : {kind};', ';')}".replace("SECOND", second)
    bench = IecBench(text, CODESYS)
    assert bench["u.v.w" if "v : UNION" in types else "u.w"] == 77


@pytest.mark.parametrize("dialect", [EPAS_4, CODESYS], ids=lambda dialect: dialect.name)
def test_nothing_less_a_time_is_the_largest_time_in_public_programs(dialect: Dialect) -> None:
    """CYCLE_TIME of OSCAT begins a search for the smallest time with T#0s - T#1ms."""
    bench = IecBench(program("t : TIME;", "t := T#0s - T#1ms;"), dialect)
    bench.cycle()
    assert bench["t"] == 2**32 - 1


def test_a_program_writes_its_inputs_in_edition_3_alone() -> None:
    text = program("i AT %IX0.1 : BOOL; w AT %IW4 : INT; m : INT; b : BOOL;", "m := w; b := i; i := NOT i; w := w + 1;")
    bench = IecBench(text, EDITION_3)
    bench.cycle(3)
    assert [bench[name] for name in ("i", "w", "m", "b")] == [True, 3, 2, False]
    for dialect in (EPAS_4, CODESYS):
        assert any("i is an input" in message for message in refused(text, dialect))
