"""Statements and expressions of Structured Text, by the listings of the manual."""

import pytest

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.parser import parse_body
from fieldrig_devices.iec.tree import Literal, LiteralKind, Name


def statements(text: str, dialect: Dialect = EPAS_4) -> tuple[tree.AnyStatement, ...]:
    body, mistakes = parse_body(text, "test.st", "ST", dialect)
    assert mistakes == []
    assert isinstance(body, tree.StBody)
    return body.statements


def number(value: int) -> Literal:
    return Literal(LiteralKind.INTEGER, value)


def binary(left: object, operator: str, right: object) -> tree.Binary:
    return tree.Binary(operator, operand(left), operand(right))


def operand(of: object) -> tree.Expression:
    return Name(of) if isinstance(of, str) else number(of) if isinstance(of, int) else of  # type: ignore[return-value]


# Strongest first: ** (edition 3 only), signs and NOT, * / MOD, + -, < > <= >=, = <>, AND, XOR, OR.
PRECEDENCE = [
    ("a / b * c", binary(binary("a", "/", "b"), "*", "c")),
    ("a - b + c", binary(binary("a", "-", "b"), "+", "c")),
    ("a + b * c", binary("a", "+", binary("b", "*", "c"))),
    ("a MOD b * c", binary(binary("a", "MOD", "b"), "*", "c")),
    ("-a * b", binary(tree.Unary("-", Name("a")), "*", "b")),
    ("NOT a = b", binary(tree.Unary("NOT", Name("a")), "=", "b")),
    ("a = b < c", binary("a", "=", binary("b", "<", "c"))),
    ("a + 1 > b AND c", binary(binary(binary("a", "+", 1), ">", "b"), "AND", "c")),
    ("a OR b XOR c AND d", binary("a", "OR", binary("b", "XOR", binary("c", "AND", "d")))),
    ("a AND b XOR c OR d", binary(binary(binary("a", "AND", "b"), "XOR", "c"), "OR", "d")),
    ("a & b", binary("a", "AND", "b")),
    ("(a + b) * c", binary(binary("a", "+", "b"), "*", "c")),
    ("20 > 30 > 40", binary(binary(20, ">", 30), ">", 40)),
]


@pytest.mark.parametrize(("text", "expected"), PRECEDENCE)
def test_operators_bind_as_the_table_of_the_manual_says(text: str, expected: tree.Expression) -> None:
    assert statements(f"x := {text};") == (tree.Assign(Name("x"), expected),)


def test_power_is_an_operator_of_edition_3_only() -> None:
    assert statements("x := a ** 2 * b;", EDITION_3) == (
        tree.Assign(Name("x"), binary(binary("a", "**", 2), "*", "b")),
    )
    _, mistakes = parse_body("x := a ** 2;", "test.st", "ST")
    assert [(mistake.column, mistake.expected) for mistake in mistakes] == [(8, "EXPT(base, exponent)")]
