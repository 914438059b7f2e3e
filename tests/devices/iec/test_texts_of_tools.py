"""Texts of values as CODESYS V3 and TwinCAT read and write them, in STRING and in WSTRING alike."""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, Dialect

TEXTS = [
    ("REAL_TO_{}(1.0E10)", "1.0E10", "1e+10"),
    ("LREAL_TO_{}(1.0E-100)", "1.0E-100", "1e-100"),
    ("DT_TO_{}(DT#2024-02-29-12:00:00)", "DT#2024-02-29-12:00:00", "DT#2024-02-29-12:00"),
    ("TIME_TO_{}(T#1h5s)", "T#1h5s", "T#1h0m5s"),
]


def value(kind: str, expression: str, dialect: Dialect) -> object:
    bench = IecBench(program(f"y : {kind};", f"y := {expression};"), dialect)
    bench.cycle()
    return bench["y"]


@pytest.mark.parametrize("kind", ["STRING", "WSTRING"])
@pytest.mark.parametrize(("call", "tools", "standard"), TEXTS)
def test_both_kinds_of_texts_are_written_alike(kind: str, call: str, tools: str, standard: str) -> None:
    assert value(kind, call.format(kind), CODESYS) == tools
    assert value(kind, call.format(kind), EDITION_3) == standard


@pytest.mark.parametrize(
    ("text", "expected_ms"), [("T#1.5s", 1_500), ("T#1m90s", 150_000), ("TIME#0.5ms", 0), ("T#-5s", 0), ("1.5s", 0)]
)
@pytest.mark.parametrize("call", ["STRING_TO_TIME('{}')", 'WSTRING_TO_TIME("{}")'])
def test_a_time_is_read_as_its_constants_are_written(call: str, text: str, expected_ms: int) -> None:
    assert value("TIME", call.format(text), CODESYS) == expected_ms
