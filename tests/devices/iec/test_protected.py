"""Others may not set what each cycle overwrites before it uses it, and may set all else."""

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import IecBench

from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.protected import Protected

DECLARED = """\
TYPE Pair : STRUCT x : INT; y : INT; END_STRUCT; END_TYPE
VAR_GLOBAL
    g0, g1, g2, g3 : INT;
    pair, other : Pair;
    row : ARRAY[0..2] OF INT;
    m AT %MW4 : INT;
    inst : Block;
END_VAR
FUNCTION_BLOCK Block
VAR_INPUT p, free : INT; END_VAR
VAR_OUTPUT q : INT; END_VAR
VAR kept, gone : INT; END_VAR
{block}
END_FUNCTION_BLOCK
FUNCTION Double : INT
VAR_INPUT p : INT; END_VAR
{function}
Double := 2 * p;
END_FUNCTION
PROGRAM PLC_PRG
VAR
    l0, l1, i : INT;
    ok : BOOL;
    fb : Block;
END_VAR
{body}
END_PROGRAM
"""
BLOCK = "gone := p; kept := kept + 1; q := gone + kept;"


def bench_of(body: str, block: str = BLOCK, function: str = "") -> IecBench:
    return IecBench(DECLARED.format(body=body, block=block, function=function), EDITION_3)


def protected(bench: IecBench) -> Callable[[str], bool]:
    return Protected(bench.compiled.written, bench.compiled.symbols).has


OVERWRITTEN = [
    ("g0 := 1;", "g0"),
    ("g0 := g1 + Double(3);", "g0"),
    ("l0 := g1;", "PLC_PRG.l0"),
    ("m := 3;", "m"),
    ("%MW4 := 3;", "m"),
    ("IF g1 > 0 THEN g0 := 1; ELSE g0 := 2; END_IF;", "g0"),
    ("IF g1 > 0 THEN g0 := 1; ELSIF g2 > 0 THEN g0 := 3; ELSE g0 := 2; END_IF;", "g0"),
    ("CASE g1 OF 1: g0 := 1; 2: g0 := 2; ELSE g0 := 3; END_CASE;", "g0"),
    ("IF g1 > 0 THEN g0 := 0; RETURN; END_IF; g0 := 1;", "g0"),
    ("FOR g0 := 1 TO 2 DO g1 := g1 + 1; END_FOR;", "g0"),
    ("pair.x := 1;", "pair.x"),
    ("pair := other; l0 := pair.y;", "pair.y"),
    ("row[1] := 1;", "row[1]"),
    ("g0 := 1; g0 := g0 + 1;", "g0"),
    ("fb(p := 3, q => g0);", "g0"),
    ("fb(EN := g1 > 0, p := 3, ENO => ok);", "PLC_PRG.ok"),
    ("g1 := Double(p := g2); g0 := g1;", "g1"),
    ("fb(p := 3);", "PLC_PRG.fb.p"),
    ("IF g1 > 0 THEN fb(p := 3); END_IF;", "PLC_PRG.fb.p"),
    ("fb.p := 3; fb();", "plc_prg.FB.P"),
    ("inst(p := 3);", "inst.p"),
    ("fb();", "PLC_PRG.fb.q"),
    ("fb();", "PLC_PRG.fb.gone"),
]
TAKEN = [
    ("IF g0 > 0 THEN g0 := 0; END_IF;", "g0"),
    ("l0 := g0; g0 := 0;", "g0"),
    ("l0 := Double(g0); g0 := 0;", "g0"),
    ("g0 := g0 + 1;", "g0"),
    ("IF g1 > 0 THEN g0 := 1; END_IF;", "g0"),
    ("CASE g1 OF 1: g0 := 1; END_CASE;", "g0"),
    ("IF g1 > 0 THEN RETURN; END_IF; g0 := 1;", "g0"),
    ("WHILE g1 > 0 DO g0 := 1; g1 := g1 - 1; END_WHILE;", "g0"),
    ("g0.3 := TRUE;", "g0"),
    ("pair.x := 1;", "pair.y"),
    ("row[LIMIT(0, g1, 2)] := 1;", "row[1]"),
    ("l0 := row[LIMIT(0, g1, 2)]; row[1] := 2;", "row[1]"),
    ("other := pair; pair.x := 1;", "pair.x"),
    ("fb(p := 3);", "PLC_PRG.fb.free"),
    ("fb();", "PLC_PRG.fb.kept"),
    ("fb(p := 3);", "inst.p"),
    ("fb(EN := g1 > 0, p := 3, q => g0);", "g0"),
    ("fb(p := 3, q => row[LIMIT(0, g0, 2)]); g0 := 1;", "g0"),
    ("l0 := 1;", "nothing"),
]


@pytest.mark.parametrize(("body", "path"), OVERWRITTEN)
def test_what_each_cycle_overwrites_is_protected(body: str, path: str) -> None:
    assert protected(bench_of(body))(path)


@pytest.mark.parametrize(("body", "path"), TAKEN)
def test_what_is_used_first_or_overwritten_now_and_then_takes_values(body: str, path: str) -> None:
    assert not protected(bench_of(body))(path)


def test_what_a_called_block_or_function_overwrites_or_uses_counts_where_it_is_called() -> None:
    text = "g0 := 1; gone := g2; g3 := gone;"
    is_protected = protected(bench_of("fb(p := 1); g3 := 2;", block=text))
    assert [is_protected(path) for path in ("g0", "g2", "g3")] == [True, False, True]
    is_protected = protected(bench_of("g2 := 1; l1 := Double(1); g2 := 2;", function="g1 := g2;"))
    assert is_protected("g2")
    assert not protected(bench_of("l1 := Double(1); g2 := 2;", function="g1 := g2;"))("g2")
    assert protected(bench_of("fb();", block="IF p > 0 THEN q := p; END_IF;"))("PLC_PRG.fb.q")
    for body in ("IF l0 > 0 THEN fb(); END_IF;", "fb(EN := l0 > 0);"):
        assert not protected(bench_of(body, block="g0 := 1;"))("g0")


# ---- random programs: a value from outside changes nothing if it is refused

PLACES = ["g0", "g1", "g2", "pair.x", "pair.y", "row[1]", "row[LIMIT(0, g3, 2)]"]
TERMS = [*PLACES, "1", "Double(g1)"]
operands = st.sampled_from(TERMS)
plain = st.one_of(
    st.builds("{} := {};".format, st.sampled_from(PLACES), operands),
    st.builds("{} := {} + {};".format, st.sampled_from(PLACES), operands, operands),
    st.sampled_from(["pair := other;", "other := pair;", "RETURN;"]),
)
in_program = st.one_of(plain, st.builds("fb(p := {});".format, operands), st.sampled_from(["l0 := fb.q;", "g1 := l0;"]))


def branches(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    body = st.lists(inner, max_size=3).map(" ".join)
    return st.one_of(
        st.builds("IF {} > 0 THEN {} END_IF;".format, operands, body),
        st.builds(
            "IF {} > 0 THEN {} ELSIF {} > 1 THEN {} ELSE {} END_IF;".format, operands, body, operands, body, body
        ),
        st.builds("CASE {} OF 0: {} 1: {} ELSE {} END_CASE;".format, operands, body, body, body),
    )


in_loop = st.lists(st.recursive(plain, branches, max_leaves=3), max_size=3).map(" ".join)
"""The body of a loop has no loop, because one with the same variable would keep it from its end."""


def nested(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return branches(inner) | st.builds("FOR i := 1 TO {} DO {} END_FOR;".format, st.sampled_from("012"), in_loop)


def bodies(statement: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.lists(st.recursive(statement, nested, max_leaves=6), min_size=2, max_size=6).map("\n".join)


PATHS = ["g0", "g1", "g2", "g3", "pair.x", "pair.y", "other.x", *(f"row[{n}]" for n in range(3)), "l0", "fb.gone"]


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(bodies(in_program), st.lists(plain.filter(lambda text: text != "RETURN;"), max_size=2).map(" ".join))
def test_a_value_that_is_refused_would_have_changed_nothing(body: str, function: str) -> None:
    bench = bench_of(body, function=function.replace("Double(g1)", "g1"))
    is_protected = protected(bench)
    bench.cycle()
    before = list(bench.runtime.memory)
    bench.cycle()
    after = everything(bench)
    for path in PATHS:
        if is_protected(path if bench.runtime.symbols.find(path) else f"PLC_PRG.{path}"):
            bench.runtime.memory[:] = before
            bench[path] = 77
            bench.cycle()
            assert everything(bench) | own(path, after) == after, path


def own(path: str, values: dict[str, object]) -> dict[str, object]:
    """Return the value of a variable of an instance that the program need not call; nothing for others."""
    return {name: value for name, value in values.items() if name == f"PLC_PRG.{path}" and "." in path}


def everything(bench: IecBench) -> dict[str, object]:
    runtime = bench.runtime
    return {symbol.path: runtime.read(symbol) for symbol in runtime.symbols.values() if len(symbol.steps) == 1}
