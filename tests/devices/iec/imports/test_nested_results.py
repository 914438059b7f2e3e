"""Functions in functions, whose result several elements consume: a drawing computes what a text computes.

A literal takes the type of the other operands or of the consumer, through functions of literals alone as well, and the
functions that select one of several values take operands with and without a sign (IEC 61131-3, 6.4.2).
"""

from collections.abc import Iterator, Mapping
from itertools import count, product
from typing import Final

import pytest
from exchange_documents import block, pou, sink, source, tc6
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.languages.mistakes import CompileError

Nested = str | tuple["Nested", ...]
PINS: Final[Mapping[str, tuple[str, ...]]] = {
    "ABS": ("IN",),
    "LIMIT": ("MN", "IN", "MX"),
    "SEL": ("G", "IN0", "IN1"),
    "MUX": ("K", "IN0", "IN1"),
    **dict.fromkeys(("MAX", "MIN", "ADD", "AND", "EXPT"), ("IN1", "IN2")),
}
SIGNS: Final = {"ADD": "+", "AND": "AND"}
OF_LITERALS: Final[tuple[Nested, ...]] = (
    ("ABS", "7"),
    ("ABS", "-7"),
    ("MAX", "200", "3"),
    ("ADD", "200", "1"),
    ("EXPT", "2", "3"),
    ("SEL", "TRUE", "1", "200"),
    ("MUX", "1", "1", "7"),
    ("LIMIT", "1", "7", "100"),
    ("MIN", ("ABS", "7"), ("MAX", "3", "4")),
)
MIXED: Final[tuple[Nested, ...]] = (
    ("MAX", "a", "b"),
    ("MIN", "b", "a"),
    ("LIMIT", "a", "b", "1"),
    ("LIMIT", "-1", "a", "b"),
    ("SEL", "TRUE", "a", "b"),
    ("SEL", "FALSE", "-1", "b"),
    ("MUX", "1", "a", "b"),
    ("MUX", "0", "b", "-1"),
    ("MIN", ("ADD", "40000", "1"), "-1"),
    ("MUX", "0", ("MUX", "1", ("MAX", "40000", "1"), "-1"), "-1"),
    ("SEL", "FALSE", ("MAX", ("MIN", "1", "-1"), ("SEL", "FALSE", "40000", "40000")), ("ABS", "b")),
)


def text_of(of: Nested) -> str:
    if isinstance(of, str):
        return of
    name, *arguments = map(text_of, of)
    return f"({f' {SIGNS[name]} '.join(arguments)})" if name in SIGNS else f"{name}({', '.join(arguments)})"


def drawn(of: Nested, ids: Iterator[int]) -> tuple[str, str]:
    """Return the elements of an expression, and the wire of its result."""
    if isinstance(of, str):
        name = f"i{next(ids)}"
        return source(name, of), name
    function, *arguments = of
    assert isinstance(function, str)
    elements, pins = "", {}
    for pin, argument in zip(PINS[function], arguments, strict=True):
        more, pins[pin] = drawn(argument, ids)
        elements += more
    name = f"f{next(ids)}"
    return elements + block(name, function, pins), f"{name}.OUT"


def of_text(of: Nested, variables: Mapping[str, str], dialect: str) -> IecBench | None:
    """Return the program, or None if a text with this expression is refused."""
    declared = "".join(f"{name} : {kind};" for name, kind in variables.items())
    try:
        return IecBench(program(declared, f"x := {text_of(of)}; y := {text_of(of)};"), DIALECTS[dialect])
    except CompileError:
        return None


def of_drawing(of: Nested, variables: Mapping[str, str], dialect: str) -> IecBench:
    elements, wire = drawn(of, count())
    elements += sink("s1", "x", wire) + sink("s2", "y", wire)
    return IecBench(tc6(pou(f"<FBD>{elements}</FBD>", variables=dict(variables))), DIALECTS[dialect], main="P")


def compare(of: Nested, kinds: Mapping[str, str], values: Mapping[str, tuple[int, ...]], dialect: str) -> bool:
    """Compare both for all values.  Return False if a text may not do this: then a drawing need not do it."""
    text = of_text(of, kinds, dialect)
    if text is None:
        return False
    drawing = of_drawing(of, kinds, dialect)
    for row in product(*values.values()):
        for bench in (text, drawing):
            for name, value in zip(values, row, strict=True):
                bench[name] = value
            bench.cycle()
        assert (drawing["x"], drawing["y"]) == (text["x"], text["y"]), (text_of(of), kinds, row)
    return True


@pytest.mark.long
@pytest.mark.parametrize("kind", ["BYTE", "SINT", "USINT", "UINT", "LREAL"])
@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_function_of_literals_alone_has_the_type_of_what_is_beside_it(dialect: str, kind: str) -> None:
    functions = product(("AND", "ADD", "MAX"), OF_LITERALS)
    kinds = dict.fromkeys("axy", kind)
    assert sum(compare((name, inner, "a"), kinds, {"a": (3, 100)}, dialect) for name, inner in functions) > 9


@pytest.mark.long
@pytest.mark.parametrize("kinds", ["INT UINT", "UINT INT", "SINT UDINT", "DINT WORD", "BYTE SINT"])
@pytest.mark.parametrize("dialect", ["epas-4", "codesys"])
def test_operands_with_and_without_sign_are_selected_as_in_a_text(dialect: str, kinds: str) -> None:
    """Edition 3 refuses most of these."""
    a, b = kinds.split()
    signed = {kind: (-3, 100) if kind.removesuffix("INT") in ("", "S", "D") else (3, 100) for kind in (a, b)}
    values = {"a": signed[a], "b": signed[b]}
    done = [
        compare(of, {"a": a, "b": b, "x": result, "y": result}, values, dialect)
        for of, result in product(MIXED, (a, b))
    ]
    assert any(done)
