"""The type of a result that several elements consume: a drawing computes what the same calls compute in a text."""

import pytest
from exchange_documents import block, only_pou, pou, sink, source, tc6
from iec_program import IecBench, program

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.elementary import Elementary, Family

ARITHMETIC = ("ADD", "SUB", "MUL", "DIV", "MOD")
LOGIC = ("AND", "OR", "XOR")
SHIFTS = ("SHL", "SHR", "ROL", "ROR")
SAME = ("MAX", "MIN")
LONG = {Elementary.LWORD, Elementary.LINT, Elementary.ULINT}
KINDS = [kind for kind in Elementary if kind.is_integer]
CASES = [
    (dialect, kind) for dialect in DIALECTS for kind in KINDS if dialect != "epas-4" or kind not in LONG
]  # fmt: skip


def functions_for(dialect: str, kind: Elementary) -> tuple[str, ...]:
    is_strict = dialect == "edition-3"
    is_bits = kind.family is Family.BITS
    arithmetic = () if is_strict and is_bits else ARITHMETIC
    logic = () if is_strict and not is_bits else LOGIC
    return (*arithmetic, *logic, *SHIFTS, *SAME)


def drawn(functions: tuple[str, ...], kind: Elementary, literal: str) -> str:
    """Each result goes to the variable `s...` and to a comparison with c."""
    body, variables = source("c", "c") + source("l", literal), {"c": kind.name}
    for number, function in enumerate(functions):
        names = ("IN", "N") if function in SHIFTS else ("IN1", "IN2")
        body += block(f"f{number}", function, dict(zip(names, ("c", "l"), strict=True)))
        body += block(f"g{number}", "GE", {"IN1": f"f{number}.OUT", "IN2": "c"})
        body += sink(f"s{number}", f"s{number}", f"f{number}.OUT") + sink(f"q{number}", f"q{number}", f"g{number}.OUT")
        variables |= {f"s{number}": kind.name, f"q{number}": "BOOL"}
    return tc6(pou(f"<FBD>{body}</FBD>", variables=variables))


def written(functions: tuple[str, ...], kind: Elementary, literal: str, dialect: str) -> str:
    signs = {"ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/", "MOD": "MOD", "AND": "AND", "OR": "OR", "XOR": "XOR"}
    calls = [f"(c {signs[name]} {literal})" if name in signs else f"{name}(c, {literal})" for name in functions]
    names = ", ".join(f"s{number}" for number in range(len(calls)))
    truths = ", ".join(f"q{number}" for number in range(len(calls)))
    body = "".join(f"s{number} := {call}; q{number} := {call} >= c;\n" for number, call in enumerate(calls))
    return program(f"c, {names} : {kind}; {truths} : BOOL;", body)


@pytest.mark.long
@pytest.mark.parametrize("literal", ["1", "3", "16#7F"])
@pytest.mark.parametrize(("dialect", "kind"), CASES, ids=str)
def test_a_shared_result_is_what_a_text_computes(dialect: str, kind: Elementary, literal: str) -> None:
    functions = functions_for(dialect, kind)
    drawing = IecBench(drawn(functions, kind, literal), DIALECTS[dialect], main="P")
    text = IecBench(written(functions, kind, literal, dialect), DIALECTS[dialect])
    for value in (kind.low, kind.low + 1, 0, 1, 100, kind.high // 2 + 1, kind.high - 1, kind.high):
        for bench in (drawing, text):
            bench["c"] = value
            bench.cycle()
        for number, function in enumerate(functions):
            names = (f"s{number}", f"q{number}")
            assert [drawing[name] for name in names] == [text[name] for name in names], (function, value)


def bench(body: str, variables: dict[str, str], dialect: str = "edition-3") -> IecBench:
    return IecBench(tc6(pou(f"<FBD>{body}</FBD>", variables=variables)), DIALECTS[dialect], main="P")


def both(wire: str, first: str, second: str) -> str:
    """Two variables that take the same result."""
    return sink(f"one{wire}", first, wire) + sink(f"two{wire}", second, wire)


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize(
    ("left", "sign", "right", "result"),
    [
        ("DT", "SUB", "DT", "TIME"),
        ("DATE", "SUB", "DATE", "TIME"),
        ("TOD", "SUB", "TOD", "TIME"),
        ("TOD", "SUB", "TIME", "TOD"),
        ("DT", "ADD", "TIME", "DT"),
        ("TIME", "ADD", "TIME", "TIME"),
        ("TIME", "MUL", "INT", "TIME"),
        ("TIME", "DIV", "REAL", "TIME"),
    ],
)
def test_times_and_dates_have_results_of_their_own_types(
    dialect: str, left: str, sign: str, right: str, result: str
) -> None:
    body = source("a", "a") + source("b", "b") + block("f", sign, {"IN1": "a", "IN2": "b"}) + both("f.OUT", "x", "y")
    found = bench(body, {"a": left, "b": right, "x": result, "y": result}, dialect)
    found["a"], found["b"] = 120_000 if left != "DATE" else 172_800, 2 if right in ("INT", "REAL") else 0
    if right not in ("INT", "REAL"):
        found["b"] = 86_400 if right == "DATE" else 20_000
    found.cycle()
    assert found["x"] == found["y"] != 0


@pytest.mark.parametrize(
    ("function", "arguments", "kind", "expected"),
    [
        ("NOT", {"IN": "WORD#16#00FF"}, "WORD", 0xFF00),
        ("SEL", {"G": "TRUE", "IN0": "1", "IN1": "c"}, "UINT", 40000),
        ("MUX", {"K": "1", "IN0": "1", "IN1": "c"}, "UINT", 40000),
        ("LIMIT", {"MN": "1", "IN": "50000", "MX": "c"}, "UINT", 40000),
        ("ABS", {"IN": "c"}, "UDINT", 40000),
        ("MOVE", {"IN": "c"}, "UINT", 40000),
        ("ADD", {"IN1": "1", "IN2": "40000"}, "UINT", 40001),
        ("SQRT", {"IN": "4.0"}, "LREAL", 2.0),
        ("TRUNC", {"IN": "70000.5"}, "DINT", 70000),
        ("UINT_TO_DINT", {"IN": "c"}, "DINT", 40000),
        ("TO_UINT", {"IN": "c"}, "UINT", 40000),
        ("CONCAT", {"IN1": "'abc'", "IN2": f"'{'x' * 90}'"}, '<string length="100"/>', "abc" + "x" * 90),
        ("LEN", {"IN": "'abc'"}, "INT", 3),
    ],
)
def test_a_literal_takes_the_type_of_the_other_operands_or_of_the_consumer(
    function: str, arguments: dict[str, str], kind: str, expected: object
) -> None:
    """IEC 61131-3, 6.4.2."""
    body = "".join(source(f"i{name}", text) for name, text in arguments.items())
    body += block("f", function, {name: f"i{name}" for name in arguments}) + both("f.OUT", "x", "y")
    c = kind if kind == "UDINT" else "UINT"
    found = bench(body, {"c": c, "x": kind, "y": kind})
    found["c"] = 40000
    found.cycle()
    assert (found["x"], found["y"]) == (expected, expected)


@pytest.mark.parametrize("dialect", ["epas-4", "codesys"])
def test_a_shared_product_keeps_all_bits_for_those_who_take_them(dialect: str) -> None:
    """30000 * 30000 is 900000000 on a 32-bit target; the INT gets its lowest 16 bits, -5888."""
    body = source("a", "a") + block("f", "MUL", {"IN1": "a", "IN2": "a"}) + both("f.OUT", "small", "large")
    body += source("h", "1000000") + block("g", "GT", {"IN1": "f.OUT", "IN2": "h"}) + sink("s", "isLarge", "g.OUT")
    found = bench(body, {"a": "INT", "small": "INT", "large": "DINT", "isLarge": "BOOL"}, dialect)
    found["a"] = 30000
    found.cycle()
    assert (found["small"], found["large"], found["isLarge"]) == (-5888, 900_000_000, True)


def test_a_shared_result_of_a_shared_result_has_a_type() -> None:
    body = source("a", "a") + source("l", "1") + block("f", "ADD", {"IN1": "a", "IN2": "l"}) + both("f.OUT", "x", "y")
    body += block("g", "ADD", {"IN1": "f.OUT", "IN2": "l"}) + both("g.OUT", "v", "w")
    found = bench(body, dict.fromkeys(("a", "x", "y", "v", "w"), "UINT"))
    found["a"] = 40000
    found.cycle()
    assert [found[name] for name in "xyvw"] == [40001, 40001, 40002, 40002]


def test_a_counter_has_the_type_that_the_dialect_gives_it() -> None:
    """CV is an INT in edition 3, so that a literal of -1 goes with it."""
    body = block("c", "CTU", {}, "Q CV", 'instanceName="counter"') + source("l", "-1")
    body += block("f", "ADD", {"IN1": "c.CV", "IN2": "l"}) + both("f.OUT", "x", "y")
    found = bench(body, {"counter": '<derived name="CTU"/>', "x": "INT", "y": "INT"})
    found.cycle()
    assert (found["x"], found["y"]) == (-1, -1)


@pytest.mark.parametrize("kind", ["UINT", "DINT", "LREAL", "INT"])
@pytest.mark.parametrize("function", ["ADD", "MAX", "SUB"])
def test_a_result_that_comes_back_has_the_type_of_the_other_arguments(function: str, kind: str) -> None:
    """1, 2, 3 ... for ADD; the wire from OUT to IN1 carries the value of the cycle before."""
    body = source("a", "a") + block("f", function, {"IN1": "f.OUT", "IN2": "a"}) + both("f.OUT", "x", "y")
    found = bench(body, {"a": kind, "x": kind, "y": kind})
    found["a"] = 1
    for _ in range(3):
        found.cycle()
    expected = {"ADD": 3, "MAX": 1, "SUB": 65533 if kind == "UINT" else -3}[function]
    assert (found["x"], found["y"]) == (expected, expected)


def test_an_inverted_output_of_a_block_comes_back_to_it() -> None:
    """NOT(delay.Q) is a BOOL, though the loop knows it before the block has run."""
    body = block("n", "NOT", {"IN": "t.Q"}) + source("p", "T#50ms")
    body += block("t", "TON", {"IN": "n.OUT", "PT": "p"}, "Q ET", 'instanceName="delay"')
    body += block("b", "BOOL_TO_INT", {"IN": "n.OUT"}) + both("b.OUT", "x", "y") + sink("s", "z", "n.OUT")
    found = bench(body, {"delay": '<derived name="TON"/>', "x": "INT", "y": "INT", "z": "BOOL"})
    found.cycle()
    assert (found["x"], found["y"], found["z"]) == (1, 1, True)


@pytest.mark.long
@pytest.mark.parametrize("length", [3, 40, 88])
def test_a_long_loop_has_the_type_of_its_arguments(length: int) -> None:
    """Each block adds 1, and the first one begins with what the last one had in the cycle before."""

    def deep(levels: int) -> IecBench:
        """The caller of the import may itself be far from the bottom of Python's stack."""
        return deep(levels - 1) if levels else bench(body, {"a": "UINT", "x": "UINT", "y": "UINT"})

    body = source("a", "a") + both(f"f{length - 1}.OUT", "x", "y")
    for number in range(length):
        body += block(f"f{number}", "ADD", {"IN1": f"f{(number - 1) % length}.OUT", "IN2": "a"})
    found = deep(100)
    found["a"] = 1
    for _ in range(2):
        found.cycle()
    assert (found["x"], found["y"]) == (2 * length, 2 * length)


def test_the_name_of_a_conversion_says_its_type_where_its_argument_is_not_known() -> None:
    """Reader is declared in another file of the project, which the import of this one does not see."""
    body = block("r", "Reader", {}, "Text", 'instanceName="reader"') + source("l", "3")
    body += block("f", "STRING_TO_INT", {"IN": "r.Text"})
    for name in ("x", "y"):
        body += block(f"g{name}", "GE", {"IN1": "f.OUT", "IN2": "l"}) + sink(f"s{name}", name, f"g{name}.OUT")
    variables = {"reader": '<derived name="Reader"/>', "x": "BOOL", "y": "BOOL"}
    found = only_pou(tc6(pou(f"<FBD>{body}</FBD>", variables=variables)))
    hidden = [v.type for variables in found.blocks for v in variables.variables if v.name.startswith("Net1_Result")]
    assert hidden == [tree.NamedType("INT")]
