"""TRUNC where no integer is wanted: a DINT in CODESYS V3 and TwinCAT, and an INT in CoDeSys V2.3, which EPAS-4 is.

Source: CODESYS Online Help and TwinCAT's manual, "TRUNC": REAL to DINT, and in V2.3 and TwinCAT 2 REAL to INT.
"""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect


def value_of(expression: str, kind: str, dialect: Dialect) -> object:
    text = program(f"x : LREAL := 70000.9; s : STRING := 'abcdef'; y : {kind};", f"y := {expression};")
    bench = IecBench(text, dialect)
    bench.cycle()
    return bench["y"]


@pytest.mark.parametrize(
    ("expression", "kind", "expected"),
    [
        ("TRUNC(x) * 1.5", "LREAL", 105_000.0),
        ("x * 40.0 - TRUNC(x * 40.0) / 1.0", "LREAL", 0.0),
        ("TRUNC(-x)", "LREAL", -70_000.0),
        ("TRUNC(x)", "REAL", 70_000.0),
        ("TRUNC(x) > 40000", "BOOL", True),
        ("MAX(TRUNC(x), 3) = 70000", "BOOL", True),
        ("TO_STRING(TRUNC(x))", "STRING", "70000"),
        ("TO_STRING(TRUNC(70000.9))", "STRING", "70000"),
        ("LREAL_TO_LINT(TRUNC(x) + 0.0)", "LINT", 70_000),
    ],
)
def test_of_todays_tools_it_has_32_bits(expression: str, kind: str, expected: object) -> None:
    assert value_of(expression, kind, CODESYS) == expected


@pytest.mark.parametrize(
    ("expression", "kind", "expected"),
    [
        ("TRUNC(x)", "INT", 70_000 - 2**16),
        ("TRUNC(x) + 1", "INT", 70_001 - 2**16),
        ("TRUNC(x + 7.5E9)", "LINT", 7_500_070_000),
        ("INT_TO_REAL(TRUNC(x))", "REAL", 70_000.0 - 2**16),
        ("LEFT(s, TRUNC(3.9))", "STRING", "abc"),
        ("MID(s, LEN(s) - TRUNC(3.9), 2)", "STRING", "bcd"),
    ],
)
def test_where_an_integer_is_wanted_it_has_its_type(expression: str, kind: str, expected: object) -> None:
    assert value_of(expression, kind, CODESYS) == expected


@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3])
def test_elsewhere_it_has_16_bits(dialect: Dialect) -> None:
    assert value_of("TRUNC(x)", "REAL", dialect) == 70_000.0 - 2**16
    assert value_of("TRUNC(x)", "DINT", dialect) == 70_000
