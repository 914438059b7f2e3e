from types import SimpleNamespace

import pytest

from fieldrig import sandbox
from fieldrig.sandbox import Arithmetic, ForbiddenPythonError, Rules, Values

ESCAPES = [
    "import os",
    "x = 1",
    "def f(pc): import os",
    "def f(pc): return pc.__class__",
    "def f(pc): return ().__class__.__bases__[0].__subclasses__()",
    "def f(pc): return open",
    "def f(pc): return open(1)",
    "def f(pc): return __builtins__",
    "def f(pc): return eval('1')",
    "def f(pc): return 'text'",
    "def f(pc): return f'{pc}'",
    "def f(pc): return b'bytes'",
    "def f(pc): return 1.5",
    "def f(pc): return None",
    "def f(pc): return [pc for pc in V]",
    "def f(pc): return lambda: 1",
    "def f(pc): return (yield)",
    "def f(pc): global V",
    "def f(pc): V = 1",
    "def f(pc): known = 1",
    "def f(pc): pc()",
    "def f(pc): V[0]()",
    "def f(pc): known(x=1)",
    "def f(pc): known(*V)",
    "def f(pc): return V[0][0]",
    "def f(pc): return V[0:1]",
    "def f(pc): return 2 ** pc",
    "def f(pc): return 1 << pc",
    "def f(pc): return (x := 1)",
    "def f(pc): return unknown",
    "def f(pc):\n    def g(): return 1\n    return g()",
    "def f(pc):\n    try: return 1\n    except: return 2",
    "def f(pc):\n    with known: return 1",
    "def f(pc):\n    del V[0]",
    "def f(pc):\n    raise known",
    "def f(pc=known(1)): return pc",
    "@known\ndef f(pc): return pc",
    "def f(pc) -> known(1): return pc",
    "def f(pc: known(1)): return pc",
    "def f(pc: known(1), /): return pc",
    "def f(*, pc=1): return pc",
    "def f(*pc): return pc",
    "def f(**pc): return pc",
    "class f: pass",
    "async def f(pc): return 1",
]


def test_plain_arithmetic_on_given_tables_runs() -> None:
    table = [1, 2]
    source = "def f(pc, n):\n    while n > 0:\n        V[0] = V[1] + g(pc)\n        n -= 1\n    return pc, n\n"
    functions = sandbox.load(source + "def g(pc):\n    return known(pc)\n", {"V": table, "known": abs})
    assert functions["f"](-5, 1) == (-5, 0)
    assert table == [7, 2]


def test_there_are_no_builtins() -> None:
    functions = sandbox.load("def f(pc):\n    return pc\n", {})
    assert functions["f"].__globals__["__builtins__"] == {}


FORMULA = Arithmetic({"axis": {"e", "v"}})
FORMULA_ESCAPES = [
    "def f(axis): return axis.__class__",
    "def f(axis): return axis.e.real",
    "def f(axis): return axis.twist",
    "def f(axis):\n    axis.twist = 1.0",
    "def f(axis): return axis.e()",
    "def f(other): return other.e",
    "def f(axis): return 'text'",
    "def f(axis): return 2.0 ** axis.e",
    "def f(axis): return (known := 1)",
    "def f(axis): return [e for e in axis]",
]


NEW_WITH_VALUES = ("return 'text'", "return 1.5", "V[0:1]", "(x := 1)")
VALUES = Values(frozenset({"V"}))
VALUE_ESCAPES = [
    *(source for source in ESCAPES if not any(part in source for part in NEW_WITH_VALUES)),
    "def f(pc): return known",
    "def f(pc):\n    V[0] = known",
    "def f(pc): return V(1)",
    "def f(pc): return ''.join",
    "def f(pc): return 'x'.format(V)",
    "def f(pc): return ('x')[0]",
    "def f(pc): return known[0]",
    "def f(pc): return known[0:1]",
    "def f(pc): return pc[0]",
    "def f(pc): return known(known)",
    "def f(pc): return (x := known)",
    "def f(pc): return f",
    "def f(pc): return __builtins__[0:1]",
    "def f(pc): return 2.0 ** pc",
    "def f(pc): return 'x' @ pc",
    "def f(pc): return None",
    "def f(pc): return ...",
    "def f(pc): return 1j",
    "def f(pc): return [1]",
    "def f(pc): return {1: 2}",
    "def f(pc): return (known := 1)",
    "def f(pc): return 1 is pc",
]  # fmt: skip


CASES: list[tuple[str, Rules | None]] = [
    *((source, None) for source in ESCAPES),
    *((source, FORMULA) for source in FORMULA_ESCAPES),
    *((source, VALUES) for source in VALUE_ESCAPES),
]


@pytest.mark.parametrize(("source", "rules"), CASES)
def test_what_could_get_out_is_refused(source: str, rules: Rules | None) -> None:
    with pytest.raises(ForbiddenPythonError):
        sandbox.load(source, {"V": [0], "known": int}, rules)


def test_a_formula_reads_and_sets_named_attributes() -> None:
    axis = SimpleNamespace(e=1.5, v=-2.0)
    source = (
        "def f(axis):\n    if not axis.e > 0.0:\n        return None\n"
        "    axis.v = e = (x := axis.e / 2.0) + x\n    return e\n"
    )
    assert sandbox.load(source, {}, FORMULA)["f"](axis) == 1.5
    assert axis == SimpleNamespace(e=1.5, v=1.5)


def test_values_are_numbers_strings_and_slices_of_tables() -> None:
    table: list[object] = ["Greifer", 0, 1.5, True]
    source = (
        "def f(pc):\n    x = V[0]\n    V[1] = x[:3] + 'n'\n    V[2:4] = V[0:2]\n"
        "    return 3.0 / pc if (y := pc) else y\n"
    )
    assert sandbox.load(source, {"V": table, "known": abs}, VALUES)["f"](2) == 1.5
    assert table == ["Greifer", "Gren", "Greifer", "Gren"]


def test_checked_code_is_bound_to_other_names_later() -> None:
    code = sandbox.compiled("def f(pc):\n    return V[pc]\n", {"V"}, VALUES, "<one>")
    assert code.co_filename == "<one>"
    scope = {"V": [1, 2]}
    assert sandbox.bind(code, scope)["f"](1) == 2
