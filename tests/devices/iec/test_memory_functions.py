"""MEMCPY, MEMMOVE, MEMSET and MEMCMP do what a loop over the bytes does, in a time that grows with their number."""

import pytest
from executed_lines import executed_lines
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import IecBench

from fieldrig_devices.iec.dialect import CODESYS

TEXT = """
TYPE Area :
    STRUCT
        isOn : BOOL;
        name : STRING(7);
        list : ARRAY[0..3] OF INT;
        wide : WSTRING(3);
        long : LINT;
        texts : ARRAY[0..1] OF STRING(4);
        last : BYTE;
    END_STRUCT;
END_TYPE

FUNCTION Compared : DINT
VAR_INPUT one, other : POINTER TO BYTE; n : UDINT; END_VAR
VAR i : UDINT; END_VAR
WHILE i < n DO
    IF one[i] <> other[i] THEN
        Compared := SEL(one[i] > other[i], -1, 1);
        RETURN;
    END_IF;
    i := i + 1;
END_WHILE;
END_FUNCTION

PROGRAM PLC_PRG
VAR
    kind, target, source, n : UDINT;
    fill : USINT;
    begin : ARRAY[0..199] OF BYTE;
    one, other : Area;
    p, q : POINTER TO BYTE;
    i, result : UDINT;
    order, expected : DINT;
END_VAR
p := ADR(one);
q := ADR(other);
FOR i := 0 TO SIZEOF(Area) - 1 DO
    p[i] := begin[i];
    q[i] := begin[i];
END_FOR;
CASE kind OF
    0:
        result := MEMCPY(p + target, p + source, n);
        IF target <= source THEN
            FOR i := 1 TO n DO q[target + i - 1] := q[source + i - 1]; END_FOR;
        ELSE
            FOR i := n TO 1 BY -1 DO q[target + i - 1] := q[source + i - 1]; END_FOR;
        END_IF;
    1:
        result := MEMSET(p + target, fill, n);
        FOR i := 1 TO n DO q[target + i - 1] := USINT_TO_BYTE(fill); END_FOR;
    2:
        result := n;
        order := MEMCMP(p + target, q + source, n);
        expected := Compared(p + target, q + source, n);
END_CASE;
END_PROGRAM
"""
SIZE = 1 + 8 + 8 + 8 + 8 + 10 + 1
PLACE = st.integers(0, SIZE)


@pytest.fixture(scope="module")
def bench() -> IecBench:
    return IecBench(TEXT, CODESYS)


def bytes_of(bench: IecBench, name: str) -> bytes:
    address = bench.runtime.compiled.program.pous["plc_prg"].variables[name].offset
    return bench.runtime.contents.bytes_at(address + bench.runtime.compiled.layout.slots["plc_prg"].address, SIZE)


@settings(deadline=None, max_examples=150)
@given(st.integers(0, 2), PLACE, PLACE, PLACE, st.integers(0, 255), st.binary(min_size=SIZE, max_size=SIZE))
def test_bytes_are_those_of_a_loop(
    bench: IecBench, kind: int, target: int, source: int, n: int, fill: int, begin: bytes
) -> None:
    n = min(n, SIZE - max(target, source))
    bench["kind"], bench["target"], bench["source"], bench["n"], bench["fill"] = kind, target, source, n, fill
    for number, byte in enumerate(begin):
        bench[f"begin[{number}]"] = byte
    bench.cycle()
    assert bench.thread.fault is None, bench.thread.fault
    assert bench["result"] == n
    assert bytes_of(bench, "one") == bytes_of(bench, "other")
    assert bench["order"] == bench["expected"]


def lines(size: int) -> int:
    """Return how many lines of Python a cycle executes."""
    declarations = f"a, b : STRING({size}); list : ARRAY[1..{size}] OF BYTE; n : DINT;"
    body = f"MEMSET(ADR(a), 65, {size}); MEMCPY(ADR(b), ADR(a), {size}); MEMCPY(ADR(list), ADR(b), {size});"
    body += f"n := MEMCMP(ADR(list), ADR(a), {size});"
    bench = IecBench(f"PROGRAM PLC_PRG VAR {declarations} END_VAR {body} END_PROGRAM", CODESYS)
    executed = executed_lines(bench.cycle)
    assert (bench["n"], bench[f"list[{size}]"], len(str(bench["b"]))) == (0, 65, size)
    return executed


def test_a_text_is_copied_in_a_time_that_grows_with_its_length_only() -> None:
    assert lines(8_000) < 12 * lines(1_000)  # 8 if it is linear, 64 if it is quadratic


@pytest.mark.parametrize("call", ["MEMCPY(p, ADR(x), n)", "MEMCPY(ADR(x), p, n)", "MEMSET(p, 1, n)", "MEMCMP(p, p, n)"])
def test_bytes_that_the_program_does_not_have_are_a_fault(call: str) -> None:
    text = (
        f"PROGRAM PLC_PRG VAR x : INT; p : POINTER TO BYTE := 16#7000_0000; n : UDINT := 4_000_000_000; END_VAR {call};"
    )
    bench = IecBench(f"{text} END_PROGRAM", CODESYS)
    bench.cycle()
    assert bench.thread.fault is not None
    assert "a pointer to no variable" in str(bench.thread.fault)


def test_an_address_of_0_is_answered() -> None:
    declarations = "x : INT; p : PVOID; a, b, c, e : UDINT := 9; d : DINT; n : UDINT := 2;"
    body = "a := MEMCPY(p, ADR(x), n); b := MEMMOVE(ADR(x), p, n); c := MEMSET(p, 1, n); d := MEMCMP(ADR(x), p, n);"
    bench = IecBench(
        f"PROGRAM PLC_PRG VAR {declarations} END_VAR {body} e := MEMCPY(ADR(x), ADR(x), 0); END_PROGRAM", CODESYS
    )
    bench.cycle()
    assert [bench[name] for name in "abcde"] == [0, 0, 0, 255, 0]
