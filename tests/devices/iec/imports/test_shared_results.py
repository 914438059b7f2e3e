"""A result that several elements of a drawing consume: each of them gets what it would get if the block were its own.

A 32-bit target computes in its registers, and cuts a result where it is stored or converted (CODESYS Online Help,
"Operators", overflow and underflow in the data type).  `tests/devices/iec/test_registers.py` tests texts against
arithmetic of its own; here drawings are compared with texts.
"""

from dataclasses import dataclass, replace
from itertools import count

import pytest
from exchange_documents import block, pou, sink, source, tc6
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS, DIALECTS, EPAS_4, Dialect
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.types import Value

LONG = replace(EPAS_4, name="epas-4 with 64 bits", has_long_types=True)
KINDS = ("SINT", "USINT", "BYTE", "INT", "UINT", "WORD", "DINT", "UDINT", "DWORD")
SIGNS = {
    "ADD": "+",
    "SUB": "-",
    "MUL": "*",
    "DIV": "/",
    "MOD": "MOD",
    "AND": "AND",
    "OR": "OR",
    "XOR": "XOR",
    "GT": ">",
}
PINS = {
    **dict.fromkeys(SIGNS, ("IN1", "IN2")),
    **dict.fromkeys(("MAX", "MIN"), ("IN1", "IN2")),
    **dict.fromkeys(("NOT", "ABS", "MOVE"), ("IN",)),
    **dict.fromkeys(("SHL", "SHR", "ROL", "ROR"), ("IN", "N")),
    "LIMIT": ("MN", "IN", "MX"),
    "SEL": ("G", "IN0", "IN1"),
    "MUX": ("K", "IN0", "IN1"),
}
FIRST = {"SEL": ("aBOOL",), "MUX": ("1",)}
"""The literals and variables at the pins in front of the values."""
LAST = dict.fromkeys(("SHL", "SHR", "ROL", "ROR"), ("3",))


@dataclass(frozen=True)
class Term:
    """A variable or literal, or a function of other terms."""

    name: str
    of: tuple["Term", ...] = ()

    @property
    def text(self) -> str:
        if not self.of:
            return self.name
        texts = [term.text for term in self.of]
        if self.name in SIGNS:
            return f"({texts[0]} {SIGNS[self.name]} {texts[1]})"
        return f"{self.name}({', '.join(texts)})"

    @property
    def pins(self) -> tuple[str, ...]:
        return PINS.get(self.name, ("IN",))


def _leaf(name: str) -> Term:
    return Term(name)


def consumers(term: Term) -> dict[str, Term]:
    """Return what takes a result, by the types of the variables that it is written to."""
    made = {kind: Term(f"TO_{kind}", (term,)) for kind in (*KINDS, "REAL", "STRING")}
    return {
        **made,
        "LINT": term,
        "LREAL": Term("TO_LREAL", (Term("ADD", (term, _leaf("1"))),)),
        "LWORD": Term("TO_LWORD", (Term("SHR", (term, _leaf("1"))),)),
        "BOOL": Term("GT", (term, _leaf("aINT"))),
    }


class Drawing:
    """Terms as blocks; with `is_shared`, a term that is there twice is one block."""

    def __init__(self, *, is_shared: bool) -> None:
        self.text, self._is_shared = "", is_shared
        self._numbers, self._known = count(), dict[Term, str]()

    def wire(self, term: Term) -> str:
        if self._is_shared and term in self._known:
            return self._known[term]
        wires = [self.wire(inner) for inner in term.of]
        number = f"e{next(self._numbers)}"
        if not term.of:
            self.text += source(number, term.name)
            return number
        self.text += block(number, term.name, dict(zip(term.pins, wires, strict=True)))
        self._known[term] = f"{number}.OUT"
        return self._known[term]

    def write(self, variable: str, term: Term) -> None:
        wire = self.wire(term)
        self.text += sink(f"s{variable}", variable, wire)


VARIABLES = {f"a{kind}": kind for kind in (*KINDS, "BOOL")}


def drawn(terms: dict[str, Term], variables: dict[str, str], *, is_shared: bool) -> str:
    made = Drawing(is_shared=is_shared)
    for variable, term in terms.items():
        made.write(variable, term)
    declared = {name: f"<{kind.lower()}/>" if kind == "STRING" else kind for name, kind in variables.items()}
    return tc6(pou(f"<FBD>{made.text}</FBD>", variables=declared))


def three(terms: dict[str, Term], variables: dict[str, str], dialect: Dialect) -> list[IecBench]:
    """Return a text, a drawing with a block for each use, and a drawing with shared blocks."""
    body = "".join(f"{name} := {term.text};\n" for name, term in terms.items())
    text = program(" ".join(f"{name} : {kind};" for name, kind in variables.items()), body)
    drawings = [drawn(terms, variables, is_shared=is_shared) for is_shared in (False, True)]
    return [IecBench(text, dialect), *(IecBench(drawing, dialect, main="P") for drawing in drawings)]


def _term(name: str, inner: tuple[Term, ...]) -> Term:
    first, last = FIRST.get(name, ()), LAST.get(name, ())
    free = len(PINS[name]) - len(first) - len(last)
    return Term(name, (*map(_leaf, first), *inner[:free], *map(_leaf, last)))


FUNCTIONS = sorted(PINS.keys() - {"DIV", "MOD", "GT"})


def _terms(kind: str) -> st.SearchStrategy[Term]:
    """Return terms of one type: functions such as MAX have operands of one type."""

    def grow(inner: st.SearchStrategy[Term]) -> st.SearchStrategy[Term]:
        return st.builds(_term, st.sampled_from(FUNCTIONS), st.tuples(inner, inner, inner))

    leaves = st.just(_leaf(f"a{kind}"))
    return grow(st.recursive(leaves, grow, max_leaves=4))


@pytest.mark.long
@pytest.mark.parametrize("dialect", [LONG, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=3, deadline=None, phases=[Phase.explicit, Phase.generate])
@given(data=st.data())
def test_a_shared_result_is_what_each_consumer_would_compute(kind: str, dialect: Dialect, data: st.DataObject) -> None:
    term = data.draw(_terms(kind))
    wanted = consumers(term)
    terms = {f"r{number}": consumer for number, consumer in enumerate(wanted.values())}
    variables = {**VARIABLES, **dict(zip(terms, wanted, strict=True))}
    benches = three(terms, variables, dialect)
    type_ = Elementary[kind]
    for value in (type_.low, type_.high, data.draw(st.integers(type_.low, type_.high))):
        found: list[dict[str, Value]] = []
        for bench in benches:
            bench[f"a{kind}"], bench["aBOOL"], bench["aINT"] = value, True, 30_000 if kind != "INT" else value
            bench.cycle()
            assert bench.thread.fault is None
            found.append({name: bench[name] for name in terms})
        assert found[1] == found[0], (term.text, value)
        assert found[2] == found[0], (term.text, value)


ADDED = Term("ADD", (_leaf("c"), _leaf("c")))


@pytest.mark.parametrize(
    ("dialect", "kind", "value", "consumer", "result", "expected"),
    [
        ("epas-4", "INT", 30_000, Term("INT_TO_DINT", (ADDED,)), "DINT", 60_000),
        ("codesys", "INT", 30_000, Term("INT_TO_DINT", (ADDED,)), "DINT", 60_000),
        ("edition-3", "INT", 30_000, Term("INT_TO_DINT", (ADDED,)), "DINT", -5_536),
        ("epas-4", "INT", 30_000, Term("SUB", (ADDED, _leaf("c"))), "DINT", 30_000),
        ("epas-4", "UINT", 40_000, Term("SHR", (ADDED, _leaf("1"))), "UINT", 40_000),
        ("epas-4", "UINT", 40_000, Term("ROL", (ADDED, _leaf("1"))), "UINT", 28_928),
        ("codesys", "USINT", 200, Term("DIV", (ADDED, _leaf("2"))), "INT", 200),
    ],
)
def test_a_result_is_not_cut_before_the_block_that_takes_it(
    dialect: str, kind: str, value: int, consumer: Term, result: str, expected: int
) -> None:
    """2 * 40000 is 16#3880 in 16 bits, and rotated 16#7100; the UINT beside each block gets the cut value."""
    terms, variables = {"r": consumer, "s": ADDED}, {"c": kind, "r": result, "s": kind}
    for bench in three(terms, variables, DIALECTS[dialect]):
        bench["c"] = value
        bench.cycle()
        bits = Elementary[kind].size * 8
        assert (bench["r"], int(bench["s"]) % 2**bits) == (expected, 2 * value % 2**bits)


@pytest.mark.parametrize("dialect", ["epas-4", "codesys", "edition-3"])
def test_a_loop_keeps_a_value_of_the_type_of_the_result(dialect: str) -> None:
    """The value of the previous cycle comes from a variable, which has cut it; 3 * 30000 - 65536 is 24464."""
    body = source("c", "c") + block("f", "ADD", {"IN1": "f.OUT", "IN2": "c"}) + sink("a", "small", "f.OUT")
    body += block("g", "INT_TO_DINT", {"IN": "f.OUT"}) + sink("b", "large", "g.OUT")
    text = tc6(pou(f"<FBD>{body}</FBD>", variables={"c": "INT", "small": "INT", "large": "DINT"}))
    bench = IecBench(text, DIALECTS[dialect], main="P")
    bench["c"] = 30_000
    found = []
    for _ in range(3):
        bench.cycle()
        found.append((bench["small"], bench["large"]))
    whole = -5_536 if dialect == "edition-3" else 60_000
    assert found == [(30_000, 30_000), (-5_536, whole), (24_464, 24_464)]
