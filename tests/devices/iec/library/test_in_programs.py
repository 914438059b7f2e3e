"""Standard functions and conversions in a compiled program, against results that are computed another way."""

import ctypes
import math
import struct
from collections.abc import Callable
from decimal import ROUND_HALF_EVEN, Decimal
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from library_bench import Bench

Inputs = dict[str, Any]


def f32(value: float) -> float:
    try:
        (rounded,) = struct.unpack("<f", struct.pack("<f", value))
    except OverflowError:
        return math.copysign(math.inf, value)
    return float(rounded)


def i16(value: int) -> int:
    return ctypes.c_int16(value).value


def i32(value: int) -> int:
    return ctypes.c_int32(value).value


def nearest(value: float) -> int:
    return int(Decimal(value).to_integral_value(ROUND_HALF_EVEN))


def turned(value: int, count: int, bits: int) -> int:
    text = f"{value:0{bits}b}"
    count %= bits
    return int(text[count:] + text[:count], 2)


# The type of the result, the expression, and the result for the values of its variables.
EXPRESSIONS: list[tuple[str, str, Callable[..., Any]]] = [
    ("DINT", "MAX(d, i, 7)", lambda d, i, **_: max(d, i, 7)),
    ("DINT", "MIN(d, u)", lambda d, u, **_: min(d, u)),
    ("REAL", "LIMIT(-10.5, r, i)", lambda r, i, **_: min(max(r, -10.5), f32(i))),
    ("INT", "SEL(b, i, 5)", lambda b, i, **_: 5 if b else i),
    ("DINT", "MUX(y, d, i, 3)", lambda y, d, i, **_: [d, i, 3][min(y, 2)]),
    ("INT", "ABS(i)", lambda i, **_: i16(abs(i))),
    ("WORD", "SHL(w, y)", lambda w, y, **_: (w << y) % 65_536),
    ("WORD", "SHR(w, y)", lambda w, y, **_: w >> y),
    ("INT", "SHR(i, y)", lambda i, y, **_: i >> y),
    ("WORD", "ROL(w, y)", lambda w, y, **_: turned(w, y, 16)),
    ("DWORD", "ROR(DINT_TO_DWORD(d), y)", lambda d, y, **_: turned(d % 2**32, -y, 32)),
    ("DINT", "EXPT(d, 3)", lambda d, **_: i32(d**3)),
    ("INT", "TRUNC(r)", lambda r, **_: i16(math.trunc(r))),
    ("DINT", "TRUNC(r)", lambda r, **_: i32(math.trunc(r))),
    ("REAL", "SQRT(ABS(r))", lambda r, **_: f32(math.sqrt(abs(r)))),
    ("REAL", "SIN(r) + COS(i)", lambda r, i, **_: f32(f32(math.sin(r)) + f32(math.cos(i)))),
    ("LREAL", "ATAN(INT_TO_LREAL(i))", lambda i, **_: math.atan(i)),
    ("SINT", "INT_TO_SINT(i)", lambda i, **_: ctypes.c_int8(i).value),
    ("UINT", "DINT_TO_UINT(d)", lambda d, **_: d % 65_536),
    ("INT", "REAL_TO_INT(r)", lambda r, **_: i16(nearest(r))),
    ("UDINT", "REAL_TO_UDINT(r)", lambda r, **_: nearest(r) % 2**32),
    ("REAL", "DINT_TO_REAL(d)", lambda d, **_: f32(d)),
    ("BOOL", "REAL_TO_BOOL(r)", lambda r, **_: r != 0),
    ("TIME", "DINT_TO_TIME(d)", lambda d, **_: d % 2**32),
    ("TOD", "DINT_TO_TOD(d)", lambda d, **_: d % 2**32 % 86_400_000),
    ("STRING", "CONCAT(s, INT_TO_STRING(i))", lambda s, i, **_: f"{s}{i}"[:80]),
    ("STRING(5)", "MID(s, 9, y)", lambda s, y, **_: s[y - 1 : y + 4] if y else ""),
    ("INT", "FIND(s, 'a')", lambda s, **_: s.find("a") + 1),
    ("INT", "LEN(INSERT(s, 'xyz', y))", lambda s, **_: len(s) + 3),
    ("DINT", "STRING_TO_DINT(DINT_TO_STRING(d))", lambda d, **_: d),
    ("DWORD", "PUTBIT(DINT_TO_DWORD(d), 4, b)", lambda d, b, **_: d % 2**32 & ~16 | 16 * b),
    ("BOOL", "EXTRACT(DINT_TO_DWORD(d), y)", lambda d, y, **_: bool(d % 2**32 >> y & 1)),
    ("INT", "BCD_TO_INT(INT_TO_BCD(y))", lambda y, **_: y),
    ("BOOL", "GT(d, i, 0)", lambda d, i, **_: d > i > 0),
    ("DINT", "ADD(d, i, 1)", lambda d, i, **_: i32(d + i + 1)),
    ("TIME", "ADD_TIME(DINT_TO_TIME(d), T#1s)", lambda d, **_: (d + 1_000) % 2**32),
]

VALUES = st.fixed_dictionaries(
    {
        "b": st.booleans(),
        "d": st.integers(-(2**31), 2**31 - 1),
        "i": st.integers(-(2**15), 2**15 - 1),
        "u": st.integers(0, 2**16 - 1),
        "w": st.integers(0, 2**16 - 1),
        "y": st.integers(0, 255),
        "r": st.floats(-(2.0**40), 2.0**40, width=32),
        "s": st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=80),
    }
)


@pytest.fixture(scope="module")
def bench() -> Bench:
    results = "\n".join(f"    o{number} : {kind};" for number, (kind, _, _) in enumerate(EXPRESSIONS))
    body = "\n".join(f"o{number} := {text};" for number, (_, text, _) in enumerate(EXPRESSIONS))
    inputs = "b : BOOL; d : DINT; i : INT; u : UINT; w : WORD; y : BYTE; r : REAL; s : STRING;"
    return Bench(f"PROGRAM PLC_PRG\nVAR\n    {inputs}\n{results}\nEND_VAR\n{body}\nEND_PROGRAM\n")


@pytest.mark.long
@settings(max_examples=200)
@given(VALUES)
def test_results_are_those_of_another_computation(bench: Bench, values: Inputs) -> None:
    for name, value in values.items():
        bench.write(f"PLC_PRG.{name}", value)
    bench.call(0)
    for number, (_, text, expected) in enumerate(EXPRESSIONS):
        assert bench.read(f"PLC_PRG.o{number}") == expected(**values), text
