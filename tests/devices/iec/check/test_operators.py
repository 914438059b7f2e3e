"""The types of expressions, operator by operator (digest 2.3), and which value becomes which by itself (PD-367)."""

import pytest
from iec_check import messages, program, type_of

from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.elementary import Elementary

ALL = (
    "b : BOOL; bt : BYTE; w : WORD; dw : DWORD; si : SINT; i : INT; di : DINT; usi : USINT; ui : UINT; udi : UDINT; "
    "r : REAL; lr : LREAL; t : TIME; d : DATE; td : TOD; dt_ : DT; s : STRING; e : Color; n : INT(1..5); "
    "p : POINTER TO INT; "
)
COLOR = "TYPE Color : (cyan, magenta); END_TYPE"


TYPES = [
    # arithmetic: the larger type; at the same size the signed one
    ("i + i", "INT"), ("si + i", "INT"), ("i + di", "DINT"), ("bt + w", "WORD"), ("bt + bt", "BYTE"),
    ("usi + bt", "USINT"),
    ("i + w", "INT"), ("ui + i", "INT"), ("udi - dw", "UDINT"), ("r * i", "REAL"), ("r * lr", "LREAL"),
    ("i / i", "INT"),
    ("i MOD si", "INT"), ("w MOD bt", "WORD"), ("n + 1", "INT"), ("e + 1", "INT"), ("p + 2", "DWORD"),
    # literals take the type of the other operand if they fit
    ("si + 100", "SINT"), ("si + 200", "INT"), ("usi + 255", "USINT"), ("bt + 16#FF", "BYTE"), ("i + 100000", "DINT"),
    ("i * 1.5", "REAL"), ("lr * 1.5", "LREAL"), ("r + 1", "REAL"), ("lr + 1", "LREAL"), ("2 * di", "DINT"),
    # bits
    ("b AND b", "BOOL"), ("bt AND bt", "BYTE"), ("bt OR w", "WORD"), ("dw XOR bt", "DWORD"), ("NOT w", "WORD"),
    ("NOT b", "BOOL"),
    ("bt AND 2#1000_1010", "BYTE"), ("i AND 7", "INT"), ("NOT 2#1001_0011", "BYTE"), ("NOT 16#1FF", "WORD"),
    # comparisons, of all elementary types and STRING
    *((f"{name} {sign} {name}", "BOOL") for sign in ("=", "<>", "<", "<=", ">", ">=")
      for name in ("b", "bt", "w", "dw", "si", "i", "di", "usi", "ui", "udi", "r", "lr", "t", "d", "td",
                   "dt_", "s", "e", "n")),
    ("i < ui", "BOOL"), ("di < udi", "BOOL"), ("r > di", "BOOL"), ("e = cyan", "BOOL"), ("e = 1", "BOOL"),
    ("p = ADR(i)", "BOOL"),
    ("s = 'abc'", "BOOL"), ("b = (i > 3)", "BOOL"), ("i > 3 = b", "BOOL"), ("b = 1", "BOOL"),
    # times and dates
    ("t + t", "TIME"), ("t - T#1s", "TIME"), ("t * 2", "TIME"), ("3 * t", "TIME"), ("t / i", "TIME"),
    ("t * 2.5", "TIME"), ("t / r", "TIME"),
    ("dt_ + t", "DT"), ("t + dt_", "DT"), ("td - t", "TOD"), ("dt_ - dt_", "TIME"), ("d - d", "TIME"),
    ("td - td", "TIME"),
    # signs
    ("-i", "INT"), ("-r", "REAL"), ("-usi", "INT"), ("-w", "DINT"), ("+i", "INT"), ("-n", "INT"),
    # functions
    ("ABS(i)", "INT"), ("SQRT(r)", "REAL"), ("SQRT(lr)", "LREAL"), ("MAX(i, di, 3)", "DINT"), ("SEL(b, i, 3)", "INT"),
    ("MUX(i, r, 2.5)", "REAL"), ("LIMIT(0, i, 10)", "INT"), ("SHL(bt, 2)", "BYTE"), ("INT_TO_REAL(i)", "REAL"),
    ("LEN(s)", "INT"),
    ("ADD(i, 2, 4)", "INT"), ("GT(i, 2, 1)", "BOOL"), ("TIME()", "TIME"), ("ADR(i)", "DWORD"), ("i.3", "BOOL"),
    ("%MW5 + 1", "WORD"),
    ("%IX5.0", "BOOL"), ("%QB3", "BYTE"), ("%MD48", "DWORD"), ("%Q75", "BOOL"), ("p^", "INT"),
    ("CONCAT(s, s)", "STRING(255)"),
]  # fmt: skip


@pytest.mark.parametrize(("expression", "expected"), TYPES)
def test_the_type_of_an_expression(expression: str, expected: str) -> None:
    assert str(type_of(expression, ALL, before=COLOR)) == expected


REFUSED = [
    "b + b", "b + 1", "t + i", "t * t", "t / t", "d + d", "d + t", "td + td", "dt_ + dt_", "s + s",
    "-b", "-t", "-s", "NOT r", "NOT t",
    "NOT s", "r AND r", "b AND i", "b OR w", "t AND t", "r MOD r", "i MOD 2.0", "t MOD t", "s > 1", "t > 1",
    "b > i", "i = b", "d = dt_",
    "td = t", "s = i", "lr AND lr", "20 > 30 > 40", "i + s", "e = b",
]  # fmt: skip


@pytest.mark.parametrize("expression", REFUSED)
def test_operators_are_not_for_all_types(expression: str) -> None:
    found = messages(program(f"{ALL} result_ : LREAL;", f"result_ := {expression};", COLOR))
    assert len(found) == 1, found


NUMBERS = ("BYTE", "WORD", "DWORD", "SINT", "INT", "DINT", "USINT", "UINT", "UDINT")
OTHERS = ("BOOL", "REAL", "LREAL", "TIME", "DATE", "TOD", "DT", "STRING")


def _goes_into(source: str, target: str, dialect: str = "epas-4") -> bool:
    """The manual's rule by sizes, written once more: 2564 to 2572, and what CoDeSys V2.3 adds."""
    sizes = {"BYTE": 1, "SINT": 1, "USINT": 1, "WORD": 2, "INT": 2, "UINT": 2, "DWORD": 4, "DINT": 4, "UDINT": 4}
    if source in sizes and target in sizes:
        return sizes[source] <= sizes[target]
    if source in sizes or source == "REAL":
        return target in ("REAL", "LREAL")
    return source == target


@pytest.mark.manual("PD-367")
@pytest.mark.parametrize("source", [*NUMBERS, *OTHERS])
def test_a_value_goes_only_into_a_type_that_is_not_smaller(source: str) -> None:
    for target in (*NUMBERS, *OTHERS):
        if source == target:
            continue
        found = messages(program(f"x : {source}; y : {target};", "y := x;"))
        assert (not found) == _goes_into(source, target), (source, target, found)


@pytest.mark.manual("PD-367")
@pytest.mark.parametrize("source", [*NUMBERS, *OTHERS])
def test_every_elementary_type_has_a_conversion_into_every_other(source: str) -> None:
    others = [target for target in (*NUMBERS, *OTHERS) if target != source]
    declarations = f"x : {source}; " + " ".join(f"y_{target} : {target};" for target in others)
    assert (
        messages(program(declarations, " ".join(f"y_{target} := {source}_TO_{target}(x);" for target in others))) == []
    )


def test_edition_3_keeps_signs_and_bit_strings_apart() -> None:
    kept = [("SINT", "INT"), ("USINT", "INT"), ("UINT", "DINT"), ("BYTE", "WORD"), ("INT", "REAL"), ("DINT", "LREAL")]
    refused = [("INT", "UINT"), ("UINT", "INT"), ("WORD", "INT"), ("INT", "WORD"), ("DINT", "REAL"), ("BYTE", "INT")]
    for source, target in kept:
        assert messages(program(f"x : {source}; y : {target};", "y := x;"), dialect=EDITION_3) == []
    for source, target in refused:
        assert len(messages(program(f"x : {source}; y : {target};", "y := x;"), dialect=EDITION_3)) == 1
    assert type_of("x + y", "x : INT; y : UINT;", EDITION_3) is Elementary.DINT
    assert type_of("x + y", "x : DINT; y : UDINT;", EDITION_3) is Elementary.LINT


def test_a_real_that_cannot_hold_every_dint_is_noted() -> None:
    text = program("r : REAL; x : DINT;", "r := x;")
    assert messages(text) == []
    assert messages(text, notes=True)[-1] == "3:6 a REAL does not hold every DINT: 7 digits are kept"


@pytest.mark.parametrize(
    ("literal", "kind", "is_fitting"),
    [
        ("127", "SINT", True),
        ("128", "SINT", False),
        ("-128", "SINT", True),
        ("-129", "SINT", False),
        ("255", "BYTE", True),
        ("256", "BYTE", False),
        ("-1", "BYTE", False),
        ("16#FFFF", "INT", True),
        ("65535", "INT", False),
        ("16#1_0000", "INT", False),
        ("4294967295", "UDINT", True),
        ("4294967296", "UDINT", False),
        ("INT#5", "DINT", True),
        ("DINT#5", "INT", False),
        ("1", "BOOL", True),
        ("2", "BOOL", False),
        ("5", "REAL", True),
        ("5.0", "INT", False),
        ("100 * 300", "INT", True),
        ("200 * 200", "INT", False),
        ("200 * 200", "DINT", True),
        ("7 / 2", "INT", True),
        ("T#5s", "TIME", True),
        ("5", "TIME", False),
        ("T#5s", "DWORD", False),
        ("D#1998-12-07", "DATE", True),
        ("'a'", "STRING", True),
        ("1E38 * 1E10", "REAL", False),
        ("1E38 * 1E10", "LREAL", True),
    ],
)
def test_a_literal_takes_a_type_that_its_value_fits(literal: str, kind: str, is_fitting: bool) -> None:
    assert (not messages(program(f"x : {kind};", f"x := {literal};"))) == is_fitting
