"""ANY: an input that describes the variable that is passed (the public description of CODESYS V3)."""

import runpy

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec import any_types
from fieldrig_devices.iec.check import sfc
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3

DESCRIBED = """
FUNCTION Described : DINT
VAR_INPUT value : ANY; END_VAR
Described := value.TypeClass * 1000 + value.diSize;
END_FUNCTION
"""


@pytest.mark.parametrize(
    ("declaration", "class_number", "size"),
    [
        ("BOOL", 0, 1),
        ("LWORD", 5, 8),
        ("INT", 7, 2),
        ("STRING(7)", 16, 8),
        ("WSTRING(7)", 17, 16),
        ("TIME", 18, 4),
        ("LTIME", 37, 8),
        ("DATE_AND_TIME", 20, 4),
        ("POINTER TO INT", 22, 4),
        ("(red, green)", 25, 2),
        ("ARRAY[1..3] OF DINT", 26, 12),
        ("Pair", 28, 6),
        ("Lamp", 28, 1),
    ],
)
def test_the_class_and_the_size_are_those_of_the_variable(declaration: str, class_number: int, size: int) -> None:
    types = """
    TYPE Pair : STRUCT a : INT; b : DINT; END_STRUCT; END_TYPE
    FUNCTION_BLOCK Lamp VAR on : BOOL; END_VAR END_FUNCTION_BLOCK
    """
    text = DESCRIBED + types + program(f"v : {declaration}; x : DINT;", "x := Described(v);")
    bench = IecBench(text, CODESYS)
    bench.cycle()
    assert bench["x"] == class_number * 1000 + size


def test_values_get_a_place_of_their_own() -> None:
    text = DESCRIBED + program(
        "i : INT := 2; a, b, c, d : DINT;",
        "a := Described(i + 1); b := Described(LEN('abc')); c := Described(70000); d := Described(Described(i));",
    )
    bench = IecBench(text, CODESYS)
    bench.cycle()
    assert [bench[name] for name in "abcd"] == [7002, 7002, 8004, 8004]


READ = """
FUNCTION ReadInt : INT
VAR_INPUT value : ANY_INT; END_VAR
VAR p : POINTER TO INT; END_VAR
IF value.TypeClass = __SYSTEM.TYPE_CLASS.TYPE_INT THEN
    p := value.pValue;
    ReadInt := p^;
    p^ := p^ + 1;
END_IF;
END_FUNCTION
FUNCTION Handed : INT
VAR_INPUT value : ANY; END_VAR
Handed := ReadInt(value);
END_FUNCTION
FUNCTION OfReference : INT
VAR_IN_OUT value : INT; END_VAR
OfReference := ReadInt(value);
END_FUNCTION
FUNCTION OfStack : INT
VAR before : ARRAY[1..3] OF LREAL; value : INT := 40; END_VAR
OfStack := OfReference(value) + value;
END_FUNCTION
FUNCTION_BLOCK Reader VAR_INPUT value : ANY; END_VAR VAR_OUTPUT x : INT; END_VAR x := ReadInt(value); END_FUNCTION_BLOCK
"""


def test_the_value_is_read_and_written_by_its_address() -> None:
    text = READ + program(
        "v : INT := 5; w : REAL; r : Reader; a, b, c, d, e : INT;",
        "a := ReadInt(v); b := Handed(v); c := ReadInt(w); d := OfStack(); r(value := v); e := r.x;",
    )
    bench = IecBench(text, CODESYS)
    bench.cycle()
    assert [bench[name] for name in "abcde"] == [5, 6, 0, 81, 7]
    assert bench["v"] == 8


def test_the_standard_has_no_such_input() -> None:
    assert any("the type ANY is not declared" in message for message in refused(DESCRIBED, EDITION_3))


@pytest.mark.parametrize(("file", "name"), [(any_types.__file__, "DESCRIPTION"), (sfc.__file__, "STEP")])
def test_structures_that_all_projects_share_are_laid_out_as_a_project_does_it(file: str, name: str) -> None:
    # A project that first lays them out itself would move them beneath the code of the one before it.
    shared = runpy.run_path(file)[name]  # fresh, as in a process that has compiled nothing
    offset = 0
    for component in shared.fields.values():
        assert component.offset == offset
        offset += component.type.size
    assert shared.size == offset
