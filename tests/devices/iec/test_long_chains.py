"""Rows of operators such as a OR b OR c may be long: they are no nesting."""

from functools import cache, reduce
from operator import and_, or_, xor

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import IecBench, program

from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.iec.types import Value

OPERATORS = {"OR": or_, "AND": and_, "XOR": xor}


def ran(text: str, name: str) -> Value:
    bench = IecBench(text)
    bench.cycle()
    assert bench.thread.fault is None, bench.thread.fault
    return bench[name]


@pytest.mark.long
@given(st.data())
@settings(max_examples=5, deadline=None)
def test_a_chain_of_a_thousand_terms_has_its_value(data: st.DataObject) -> None:
    sign = data.draw(st.sampled_from(list(OPERATORS)))
    random = data.draw(st.randoms(use_true_random=False))
    values = [random.random() < 0.5 for _ in range(8)]
    terms = [random.randrange(8) for _ in range(1_000)]
    variables = "".join(f"v{number} : BOOL := {value};" for number, value in enumerate(values))
    text = program(variables + "x : BOOL;", "x := " + f" {sign} ".join(f"v{term}" for term in terms) + ";")
    assert ran(text, "x") == reduce(OPERATORS[sign], (values[term] for term in terms))
    once = print_unit(parse(text, "a.st")[0])
    assert once.count(f" {sign} ") == 999
    assert print_unit(parse(once, "b.st")[0]) == once


@pytest.mark.long
def test_a_long_sum_is_computed_from_left_to_right_with_its_calls() -> None:
    text = """VAR_GLOBAL called : DINT; END_VAR
    FUNCTION Next : DINT VAR_INPUT x : DINT; END_VAR called := called + 1; Next := called * x; END_FUNCTION
    """
    sum_ = " + ".join(f"Next({number % 3})" if number % 5 == 0 else "a" for number in range(1_000))
    calls = [number % 3 for number in range(1_000) if number % 5 == 0]
    expected = 800 * 7 + sum(position * factor for position, factor in enumerate(calls, 1))
    assert ran(text + program("a : DINT := 7; x : DINT;", f"x := {sum_};"), "x") == expected


@pytest.mark.long
def test_a_long_chain_in_a_condition_an_index_and_an_argument() -> None:
    ones = " + ".join(["one"] * 300)
    body = f"IF {' AND '.join(['TRUE_'] * 300)} THEN a[{ones}] := ABS({ones}); END_IF;"
    assert ran(program("TRUE_ : BOOL := TRUE; one : INT := 1; a : ARRAY[1..300] OF INT;", body), "a[300]") == 300


@pytest.mark.long
@given(st.integers(-1, 1_001))
@settings(max_examples=10, deadline=None)
def test_an_if_may_have_any_number_of_alternatives(x: int) -> None:
    bench = bench_of_alternatives()
    bench["x"], bench["inner"] = x, -1
    bench.cycle()
    assert bench["y"] == (x if 0 <= x < 1_000 else -7)
    assert bench["inner"] == (x % 200 if x == 999 else -1)


def alternatives(count: int, last: str, variable: str) -> str:
    parts = [f"IF ABS(x) = x AND x MOD {count} = {n} AND x < 1000 THEN {variable} := {n};" for n in range(count)]
    return f"{' ELS'.join(parts)} {last} END_IF;"


@cache
def bench_of_alternatives() -> IecBench:
    inner = alternatives(200, "", "inner")
    return IecBench(program("x, y, inner : INT;", alternatives(1_000, inner + "ELSE y := -7;", "y")))


def test_mixed_signs_keep_their_brackets() -> None:
    text = program("x, a : INT;", "x := (a + 1) * 2 - (3 - a) * ((a - 1) + 2) * 3;")
    printed = print_unit(parse(text, "a.st")[0])
    assert "(a + 1) * 2 - (3 - a) * (a - 1 + 2) * 3" in printed


@pytest.mark.long
def test_a_chain_beyond_the_limit_is_refused() -> None:
    _, mistakes = parse(program("x : INT;", "x := " + "x + " * 20_001 + "x;"), "a.st")
    assert [mistake.expected for mistake in mistakes] == ["at most 20000 operators in a row"]
