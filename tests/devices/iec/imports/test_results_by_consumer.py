"""A result whose type depends on what takes it: each consumer of the wire gets what a text would give it.

TRUNC and EXPT have the type that they are assigned to, LEN and FIND of edition 3 are any integer, and a function of
literals has the type of its consumer (IEC 61131-3, 6.4.2).
"""

from itertools import product
from typing import Final

import pytest
from exchange_documents import block, pou, sink, source, tc6
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.languages.mistakes import CompileError

CALLS: Final = {
    "TRUNC(r)": ("TRUNC", {"IN": "r"}),
    "EXPT(i, j)": ("EXPT", {"IN1": "i", "IN2": "j"}),
    "LEN(s)": ("LEN", {"STR": "s"}),
    "FIND(s, 'l')": ("FIND", {"STR1": "s", "STR2": "'l'"}),
    "MAX(200, 3)": ("MAX", {"IN1": "200", "IN2": "3"}),
    "SHR(16#FF, 1)": ("SHR", {"IN": "16#FF", "N": "1"}),
    "ABS(-7)": ("ABS", {"IN": "-7"}),
}
RESULTS: Final = ("BYTE", "INT", "UINT", "DINT", "REAL")
VARIABLES: Final = {"r": "REAL", "i": "INT", "j": "INT", "s": "STRING"}


def of_text(call: str, kinds: tuple[str, str], dialect: str) -> IecBench | None:
    """Return the program, or None if a text is refused: then a drawing need not do it."""
    declared = "".join(f"{name} : {kind};" for name, kind in {**VARIABLES, "x": kinds[0], "y": kinds[1]}.items())
    try:
        return IecBench(program(declared, f"x := {call}; y := {call};"), DIALECTS[dialect])
    except CompileError:
        return None


def of_drawing(call: str, kinds: tuple[str, str], dialect: str) -> IecBench:
    name, pins = CALLS[call]
    body = "".join(source(pin, value) for pin, value in pins.items()) + block("f", name, {pin: pin for pin in pins})
    body += sink("s1", "x", "f.OUT") + sink("s2", "y", "f.OUT")
    variables = {**VARIABLES, "s": "<string/>", "x": kinds[0], "y": kinds[1]}
    return IecBench(tc6(pou(f"<FBD>{body}</FBD>", variables=variables)), DIALECTS[dialect], main="P")


@pytest.mark.long
@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("dialect", DIALECTS)
def test_each_consumer_gets_the_result_in_its_own_type(dialect: str, call: str) -> None:
    done = 0
    for kinds in product(RESULTS, RESULTS):
        text = of_text(call, kinds, dialect)
        if text is None:
            continue
        drawing = of_drawing(call, kinds, dialect)
        for bench in (text, drawing):
            bench["r"], bench["i"], bench["j"], bench["s"] = -7.25, 7, 5, "hello"
            bench.cycle()
            assert bench.thread.fault is None
        assert (drawing["x"], drawing["y"]) == (text["x"], text["y"]), kinds
        done += 1
    assert done


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_result_is_not_cut_for_a_consumer_by_the_type_of_another_one(dialect: str) -> None:
    """300.5 is 300 as a number, and 44 in the eight bits of a USINT."""
    body = source("a", "r") + block("f", "TRUNC", {"IN": "a"}) + sink("s1", "small", "f.OUT")
    body += block("g", "TO_STRING", {"IN": "f.OUT"}) + sink("s2", "shown", "g.OUT")
    variables = {"r": "REAL", "small": "USINT", "shown": "<string/>"}
    bench = IecBench(tc6(pou(f"<FBD>{body}</FBD>", variables=variables)), DIALECTS[dialect], main="P")
    bench["r"] = 300.5
    bench.cycle()
    assert bench["shown"] == "300"


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_shift_of_a_literal_is_as_wide_as_what_it_is_compared_with(dialect: str) -> None:
    """One bit at place 20 is lost in the eight bits that the literal would have by itself."""
    body = source("o", "1") + source("n", "n") + block("f", "SHL", {"IN": "o", "N": "n"}) + sink("s1", "x", "f.OUT")
    body += source("c", "c") + block("g", "EQ", {"IN1": "f.OUT", "IN2": "c"}) + sink("s2", "isEqual", "g.OUT")
    variables = {"n": "INT", "c": "DWORD", "x": "DWORD", "isEqual": "BOOL"}
    bench = IecBench(tc6(pou(f"<FBD>{body}</FBD>", variables=variables)), DIALECTS[dialect], main="P")
    bench["n"], bench["c"] = 20, 1 << 20
    bench.cycle()
    assert (bench["x"], bench["isEqual"]) == (1 << 20, True)
