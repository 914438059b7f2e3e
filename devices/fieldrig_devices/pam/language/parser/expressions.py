"""Expressions, by the table of precedence (table 6-1 of the manual; all operators group from the left)."""

from typing import Final, Literal

from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.functions import INQUIRY_NAMES
from fieldrig_devices.pam.language.parser.cursor import Cursor
from fieldrig_devices.pam.language.words import SYMBOLIC

_LEVELS: Final = (("=", "<>"), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/", "%", "^"))
"""The operators of two operands, loosest first."""
_COMPARISONS: Final = 1
AS_IN: Final = "A value is changed as in {name} <- {name} {sign} 1."
LONGEST_CHAIN: Final = 1000
"""Operators of one level in a row."""


def expression(cursor: Cursor) -> tree.Expression:
    cursor.deeper()
    parsed = _level(cursor, 0)
    cursor.higher()
    return parsed


def _level(cursor: Cursor, level: int) -> tree.Expression:
    if level == len(_LEVELS):
        return _inquiry(cursor)
    begin = cursor.i
    left = _level(cursor, level + 1)
    if level == _COMPARISONS and cursor.token.text == "<-" and cursor.is_one_line(begin):
        left = _below_negative(cursor, left)
    length = 0
    while cursor.token.kind == "sign" and (operator := _operator(cursor)) in _LEVELS[level]:
        place = cursor.place
        if operator != cursor.token.text:
            cursor.wrong(place, f"got {cursor.token.text}", operator)
        length += 1
        if length > LONGEST_CHAIN:
            raise cursor.unexpected(f"at most {LONGEST_CHAIN} operators in a row")
        cursor.take()
        left = tree.Binary(place, operator, left, _level(cursor, level + 1))
    return left


def _operator(cursor: Cursor) -> str:
    """Return the sign that is there; | of other languages is that of OR."""
    return "+" if cursor.token.text == "|" else cursor.token.text


def _below_negative(cursor: Cursor, left: tree.Expression) -> tree.Expression:
    """Read a<-5, which is an assignment by its signs, as the comparison that it must mean."""
    place = cursor.take().place
    cursor.wrong(place, "got <-", "< -, with a blank between them")
    return tree.Binary(place, "<", left, tree.Unary(place, "-", _level(cursor, _COMPARISONS + 1)))


def _inquiry(cursor: Cursor) -> tree.Expression:
    subject = _unary(cursor)
    length = 0
    while _asks(cursor):
        place = cursor.place
        length += 1
        if length > LONGEST_CHAIN:
            raise cursor.unexpected(f"at most {LONGEST_CHAIN} inquiries in a row")
        subject = tree.Inquiry(place, subject, function_name(cursor), arguments(cursor))
    return subject


def _asks(cursor: Cursor) -> bool:
    """Pass over the question mark of an inquiry, also over a point in its place and where it is missing."""
    if cursor.accept("?"):
        return True
    is_point = cursor.token.text == "." and cursor.following.kind == "name"
    asked = cursor.following if is_point else cursor.token
    is_forgotten = cursor.i > 0 and cursor.tokens[cursor.i - 1].kind == "name" and not cursor.token.begins_line
    if asked.kind != "name" or cursor.is_name(asked) or asked.text.lower() not in INQUIRY_NAMES:
        return False
    if is_point:
        cursor.wrong(cursor.take().place, "got .", "?")
    elif is_forgotten:
        cursor.missing("?")
    return is_point or is_forgotten


def function_name(cursor: Cursor) -> str:
    """Read the name of a function, in any case (manual lines 8512 and 8585)."""
    if cursor.token.kind != "name":
        raise cursor.unexpected("the name of a function")
    return cursor.take().text.lower()


def arguments(cursor: Cursor) -> tuple[tree.Expression, ...]:
    """Read the arguments of a function in parentheses, if there are any."""
    place = cursor.place
    if not cursor.accept("("):
        return ()
    if cursor.accept(")"):
        cursor.wrong(place, "got ()", "arguments, or no parentheses")
        return ()
    expressions = [expression(cursor)]
    while cursor.accept(","):
        expressions.append(expression(cursor))
    cursor.close(")")
    return tuple(expressions)


def _unary(cursor: Cursor) -> tree.Expression:
    place = cursor.place
    signs: tuple[Literal["+", "-", "!"], ...] = ("+", "-", "!")
    for sign in signs:
        if cursor.token.kind == "sign" and cursor.token.text == sign:
            cursor.take()
            cursor.deeper()
            operation = tree.Unary(place, sign, _unary(cursor))
            cursor.higher()
            return operation
    return _primary(cursor)


def _primary(cursor: Cursor) -> tree.Expression:
    token = cursor.token
    if token.kind in ("integer", "real"):
        cursor.take()
        assert not isinstance(token.value, str)
        return tree.Number(token.place, token.value, token.text)
    if token.kind == "text":
        cursor.take()
        return tree.Text(token.place, str(token.value))
    if cursor.accept("("):
        inside = expression(cursor)
        cursor.close(")")
        return _reduced(cursor, inside)
    if cursor.is_word(*SYMBOLIC) and not cursor.is_next(":"):
        cursor.take()
        return tree.Word(token.place, token.text.upper())
    if cursor.token.kind != "name":
        is_changed = cursor.i > 1 and cursor.tokens[cursor.i - 1].text == cursor.tokens[cursor.i - 2].text in ("+", "-")
        raise cursor.unexpected("a value", AS_IN.format(name="M", sign="+") if is_changed else "")
    return object_or_parameter(cursor, "It has no value here.")


def _reduced(cursor: Cursor, inside: tree.Expression) -> tree.Expression:
    place = cursor.place
    index = cursor.index()
    if index is None:
        return inside
    if index == "i" or index == "all":
        cursor.wrong(place, f"an expression has the index [{index}]", "[all+] or [all*]")
        return inside
    return tree.Reduction(place, inside, index)


def reference(cursor: Cursor, hint: str = "Choose another name.") -> tree.Reference:
    """Read the name of an object; `hint` says what to do about a reserved word."""
    place = cursor.place
    name = cursor.name("the name of an object", hint)
    return tree.Reference(place, name, cursor.index())


def object_or_parameter(cursor: Cursor, hint: str = "Choose another name.") -> tree.Reference | tree.ParameterOf:
    subject = reference(cursor, hint)
    if not cursor.accept(":"):
        return subject
    if cursor.token.kind != "name":
        raise cursor.unexpected("the name of a parameter")
    return tree.ParameterOf(subject.place, subject, cursor.take().text.upper())


def routine_call(cursor: Cursor) -> tree.RoutineCall:
    """Read NONE, or a routine with what it is called with."""
    place = cursor.place
    if cursor.is_word("NONE"):
        cursor.take()
        return tree.RoutineCall(place, "")
    routine = cursor.name("the name of a routine")
    if cursor.token.text == "(":
        raise cursor.unexpected("WITH and the arguments, without parentheses")
    values: list[tree.Expression] = []
    if cursor.accept("WITH"):
        values.append(expression(cursor))
        while cursor.accept(","):
            values.append(expression(cursor))
    return tree.RoutineCall(place, routine, tuple(values))
