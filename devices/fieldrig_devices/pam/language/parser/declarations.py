"""Declarations of objects that consist of parameters, by the table of their kinds (section 1.3)."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from fieldrig_devices.pam.language.items import Application, BooleanEquation, Declaration, Parameter
from fieldrig_devices.pam.language.objects import KINDS, OLD_NAMES, SPECS, Rule
from fieldrig_devices.pam.language.parser.cursor import Cursor, UnexpectedError
from fieldrig_devices.pam.language.parser.expressions import expression, reference, routine_call
from fieldrig_devices.pam.language.reserved import ITEMS
from fieldrig_devices.pam.language.tree import Expression, Number, Place, RoutineCall, Word
from fieldrig_devices.pam.language.words import STRUCTURE

MANY: Final = "many"
_ENDING: Final = frozenset(word for word in STRUCTURE if word.startswith("END")) | {
    "EVENTS",
    "ON_EVENT",
    "ON_STATE",
    "SEQUENCE",
    "ROUTINE",
    "POWERON",
    "INPUT",
    "OUTPUT",
}
"""Words that end parameters, unless one is called so, as ROUTINE is."""


def declaration(cursor: Cursor) -> Declaration:
    """Read an object whose kind is the present word."""
    place, begin = cursor.place, cursor.i
    kind = _kind(cursor)
    name = cursor.name(f"the name of the {kind}")
    cursor.semicolon()
    if kind.endswith("_VAR") and not (_is_parameter(cursor, KINDS[kind]) or cursor.is_word("END")):
        return Declaration(place, kind, name)
    parts: list[Declaration] = []
    given = parameters(cursor, kind, KINDS[kind], ("END",), parts)
    cursor.close("END", begin)
    cursor.accept(";")
    return Declaration(place, kind, name, given, tuple(parts))


def _kind(cursor: Cursor) -> str:
    kind = cursor.token.text.upper()
    cursor.take()
    return kind if kind in KINDS else with_class(cursor, kind)


def with_class(cursor: Cursor, scope: str) -> str:
    """Read the class of a variable, and return its kind."""
    kind = f"{scope} {cursor.token.text.upper()}"
    if kind not in KINDS:
        classes = [known.rpartition(" ")[2] for known in KINDS if known.rpartition(" ")[0] == scope]
        raise cursor.unexpected(f"{', '.join(classes[:-1])} or {classes[-1]}")
    cursor.take()
    return kind


def parameters(
    cursor: Cursor, kind: str, rules: Mapping[str, Rule], ends: tuple[str, ...], parts: list[Declaration]
) -> tuple[Parameter, ...]:
    """Read parameters up to a word that ends them.  Traces among them are put into `parts`."""
    given: list[Parameter] = []
    place = cursor.place
    if kind == "TRACE":
        ends = (*ends, kind)  # the next one; both are parts of a MULTI_COMPARATOR
    while not cursor.is_at_end and not cursor.is_word(*ends) and not _is_outside(cursor, rules, place):
        if cursor.accept(";"):
            continue
        if "END" in ends and cursor.spells(f"END_{kind}", f"END{kind}"):
            cursor.wrong(cursor.place, f"got {cursor.token.text}", "END", "")
            cursor.tokens[cursor.i] = replace(cursor.token, text="END")
            break
        begin, depth = cursor.i, cursor.depth
        try:
            if kind == "MULTI_COMPARATOR" and cursor.is_word("TRACE"):
                parts.append(declaration(cursor))
                continue
            read = _parameter(cursor, kind, rules)
        except UnexpectedError:
            cursor.recover(begin, depth, ";", *ends, *(ITEMS - rules.keys()))
            continue
        if rules[read.name].need != MANY:
            cursor.checked_once(given, read)
        given.append(read)
    return tuple(given)


def _is_parameter(cursor: Cursor, rules: Mapping[str, Rule]) -> bool:
    """True in front of a parameter, also where = is missing, unless the word may begin another item as well."""
    return cursor.spells(*rules) and (cursor.is_next("=") or not cursor.spells(*ITEMS))


def _is_outside(cursor: Cursor, rules: Mapping[str, Rule], place: Place) -> bool:
    """True in front of another item or part of a program, so that the end of the present one is missing.

    NODE and its kind begin an item or a parameter; what is further to the left than the first parameter is an item.
    """
    if cursor.is_word(*_ENDING) and not cursor.spells(*rules):
        return True
    if not cursor.is_word(*ITEMS) or cursor.is_next("="):
        return False
    is_left = cursor.token.begins_line and cursor.place.column < place.column
    return not cursor.spells(*rules) or (is_left and cursor.following.kind == "name")


def _parameter(cursor: Cursor, kind: str, rules: Mapping[str, Rule]) -> Parameter:
    place = cursor.place
    written = cursor.token.text.upper()
    name = OLD_NAMES.get((kind, written), written)
    if cursor.token.kind != "name" or name not in rules:
        raise cursor.unexpected(f"a parameter of {kind}: {', '.join(rules)}")
    if name != written:
        cursor.note(place, f"{written} is an old name", f"Release 2.5 calls it {name}.")
    cursor.take()
    if name == "ON":
        return Parameter(place, name, (_word(cursor, rules[name]),))
    cursor.expect("=")
    parameter = Parameter(place, name, _values(cursor, rules[name]))
    cursor.semicolon()
    return parameter


def _values(cursor: Cursor, rule: Rule) -> tuple[Expression | RoutineCall, ...]:
    if rule.holds[0] == "routine":
        return (routine_call(cursor),)
    if rule.holds[0] == "file":
        return (reference(cursor),)
    if rule.need == MANY:
        return _axis_of_set(cursor)
    if rule.holds[-1] == "bit":
        return _bit_address(cursor)
    values: list[Expression | RoutineCall] = []
    for holds in rule.holds:
        is_listed = cursor.spells(*rule.words) or ("/" in holds and cursor.spells(holds.partition("(")[2].rstrip(")")))
        if holds[0] == "(" and cursor.token.kind != "name":
            raise cursor.unexpected(
                f"{', '.join(rule.words[:-1])} or {rule.words[-1]}" if rule.words[1:] else rule.words[0]
            )
        values.append(_symbol(cursor) if is_listed or holds[0] == "(" else _operand(cursor))
    return tuple(values)


def _operand(cursor: Cursor) -> Expression:
    """Read a number with its sign, or the name of an object."""
    place = cursor.place
    if cursor.token.kind == "sign" and cursor.token.text in ("+", "-"):
        is_negative = cursor.token.text == "-"
        cursor.take()
        number = _operand(cursor)
        if not isinstance(number, Number):
            raise cursor.unexpected("a number")
        spelling = f"-{number.spelling}" if is_negative else number.spelling
        return Number(place, -number.value if is_negative else number.value, spelling)
    if cursor.token.kind in ("integer", "real", "text"):
        token = cursor.token
        cursor.take()
        if isinstance(token.value, str):
            cursor.wrong(place, "a text cannot be the value of a parameter", "a number")
            return Number(place, 0, "0")
        return Number(place, token.value, token.text)
    return reference(cursor)


def _symbol(cursor: Cursor) -> Word:
    place = cursor.place
    return Word(place, cursor.take().text.upper())


def _word(cursor: Cursor, rule: Rule) -> Word:
    if not cursor.spells(*rule.words):
        raise cursor.unexpected(" or ".join(rule.words))
    return _symbol(cursor)


def _axis_of_set(cursor: Cursor) -> tuple[Expression, ...]:
    """Read an axis of an axes set with its subset."""
    axis = reference(cursor)
    place = cursor.place
    if cursor.accept("SHIFT"):
        cursor.note(place, "SHIFT is an old name", "Release 2.5 calls it SUBSET.")
    elif not cursor.accept("SUBSET"):
        return (axis,)
    cursor.expect("=")
    return axis, _operand(cursor)


def _bit_address(cursor: Cursor) -> tuple[Expression, ...]:
    """Read a byte address and the number of a bit, as in #104 BIT 3 or #104 BIT = 3 (manual lines 10628 and 10693)."""
    address = _operand(cursor)
    place = cursor.place
    if not cursor.accept("BIT"):
        return address, Number(place, 0, "0")
    cursor.accept("=")
    return address, _operand(cursor)


def application(cursor: Cursor) -> Application:
    """Read the header with the name and version."""
    place, begin = cursor.place, cursor.i
    cursor.expect("APPLICATION")
    cursor.expect("NAME")
    cursor.expect("=")
    name = cursor.name("the name of the application")
    version = _version(cursor)
    cursor.semicolon()
    given = parameters(cursor, "APPLICATION", SPECS["APPLICATION"], ("END",), [])
    cursor.close("END", begin)
    cursor.accept(";")
    return Application(place, name, version, given)


def _version(cursor: Cursor) -> str:
    """Read V 1.00 or V1.00 (manual lines 846 and 858)."""
    expected = "a version such as V1.00, with up to three digits before the point and two behind it"
    text = cursor.token.text
    if text[:1] not in ("V", "v") or (len(text) > 1 and not text[1:].isdecimal()):
        raise cursor.unexpected(expected)
    cursor.take()
    version = f"{text[1:]}{_digits(cursor, expected)}" if len(text) > 1 else _real(cursor, expected)
    whole, _, part = version.partition(".")
    if len(whole) > 3 or len(part) != 2:
        cursor.wrong(cursor.tokens[cursor.i - 1].place, f"the version {version} is wrong", expected)
    return version


def _real(cursor: Cursor, expected: str) -> str:
    if cursor.token.kind != "real":
        raise cursor.unexpected(expected)
    return cursor.take().text


def _digits(cursor: Cursor, expected: str) -> str:
    cursor.expect(".")
    if cursor.token.kind != "integer":
        raise cursor.unexpected(expected)
    return f".{cursor.take().text}"


def equation(cursor: Cursor) -> BooleanEquation:
    place, begin = cursor.place, cursor.i
    cursor.expect("BOOLEAN")
    name = cursor.name("the name of the equation")
    is_multiple = cursor.item_index()
    cursor.semicolon()
    linked = None
    if cursor.accept("LINKED_OUTPUT"):
        cursor.expect("=")
        linked = reference(cursor)
        cursor.semicolon()
    cursor.expect("EQUATION")
    cursor.accept("=")
    formula = expression(cursor)
    cursor.semicolon()
    cursor.close("END_BOOLEAN", begin)
    cursor.accept(";")
    return BooleanEquation(place, name, is_multiple, linked, formula)
