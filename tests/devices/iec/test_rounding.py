"""Real numbers to integers: halves go away from zero in CODESYS V3 and TwinCAT, and to the even neighbour elsewhere.

Source: the tests of TwinCAT.OpenFramework, in which -0.5 becomes -1 as INT and as DINT, and the documents of both tools
for 1.5 and -1.5.  CoDeSys V2.3 leaves it to the floating-point unit, and edition 3 to IEC 60559.
"""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect


def converted(call: str, value: float, dialect: Dialect) -> object:
    bench = IecBench(program(f"x : LREAL := {value!r}; y : LREAL;", f"y := {call};"), dialect)
    bench.cycle()
    return bench["y"]


@pytest.mark.parametrize("call", ["LREAL_TO_INT(x)", "TO_DINT(x)", "REAL_TO_INT(LREAL_TO_REAL(x))"])
@pytest.mark.parametrize(
    ("value", "away", "even"),
    [(0.5, 1, 0), (1.5, 2, 2), (2.5, 3, 2), (-0.5, -1, 0), (-2.5, -3, -2), (2.25, 2, 2), (-1.75, -2, -2)],
)
def test_a_half_is_rounded_as_the_tool_does(call: str, value: float, away: float, even: float) -> None:
    assert converted(call, value, CODESYS) == away
    assert converted(call, value, EPAS_4) == even
    assert converted(call, value, EDITION_3) == even


@pytest.mark.parametrize(
    ("call", "value", "expected"),
    [
        ("LREAL_TO_DINT(x)", 0.49999999999999994, 0),
        ("LREAL_TO_LINT(x)", 4503599627370495.5, 4503599627370496),
        ("LREAL_TO_ULINT(x)", 1.8446744073709550e19, 1.8446744073709550e19),
        ("LREAL_TO_BYTE(x)", 254.5, 255),
        ("TIME_TO_DINT(LREAL_TO_TIME(x))", 2.5, 3),
        ("LREAL_TO_LINT(x)", 1e300, 0),
        ("LREAL_TO_INT(2.5)", 0.0, 3),
        ("TRUNC(x)", -2.5, -2),
    ],
)
def test_every_size_is_rounded_once(call: str, value: float, expected: float) -> None:
    assert converted(call, value, CODESYS) == expected


SUBRANGE = "TYPE Small : INT(0..10); END_TYPE\n"


def test_at_run_time_a_subrange_takes_every_number_in_codesys() -> None:
    bench = IecBench(SUBRANGE + program("s : Small; n : INT := -7;", "s := n;"), CODESYS)
    bench.cycle()
    assert bench["s"] == -7


def test_check_range_signed_judges_it() -> None:
    check = """FUNCTION CheckRangeSigned : DINT
VAR_INPUT value, lower, upper : DINT; END_VAR
CheckRangeSigned := LIMIT(lower, value, upper);
END_FUNCTION
"""
    bench = IecBench(SUBRANGE + check + program("s : Small; n : INT := 70;", "s := n;"), CODESYS)
    bench.cycle()
    assert bench["s"] == 10
