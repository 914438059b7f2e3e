"""Ports to a PLC with their variables (sections 11.8, 12.5 and 13.1 of the digest).

A Simatic DUAL_PORT has no name and consists of parameters; its variables are declarations of their own.
"""

from typing import Final

from fieldrig_devices.pam.language.items import Declaration
from fieldrig_devices.pam.language.objects import KINDS, PORTS
from fieldrig_devices.pam.language.parser.cursor import Cursor, UnexpectedError
from fieldrig_devices.pam.language.parser.declarations import parameters, with_class
from fieldrig_devices.pam.language.parser.statements import begins_item
from fieldrig_devices.pam.language.reserved import ITEMS

_SECOND_WORD: Final = {"VME": "DUALPORT", "RS422": "PORT"}
_DIRECTIONS: Final = ("INPUT", "OUTPUT")


def dual_port(cursor: Cursor) -> Declaration:
    place, begin = cursor.place, cursor.i
    cursor.expect("DUAL_PORT")
    cursor.accept(";")
    given = parameters(cursor, "DUAL_PORT", KINDS["DUAL_PORT"], ("END",), [])
    cursor.close("END", begin)
    cursor.accept(";")
    return Declaration(place, "DUAL_PORT", PORTS["DUAL_PORT"], given)


def port(cursor: Cursor) -> Declaration:
    """Read VME DUALPORT or RS422 PORT up to its END_DUALPORT or END_PORT."""
    place, begin = cursor.place, cursor.i
    family = cursor.token.text.upper()
    cursor.take()
    kind, end = f"{family} {_SECOND_WORD[family]}", f"END_{_SECOND_WORD[family]}"
    cursor.expect(_SECOND_WORD[family])
    cursor.accept(";")
    first = cursor.i
    cursor.expect("SPECS")
    specs = parameters(cursor, kind, KINDS[kind], ("END_SPECS",), [])
    cursor.close("END_SPECS", first)
    cursor.accept(";")
    variables: list[Declaration] = []
    while not cursor.is_at_end and not cursor.is_word(end) and not begins_item(cursor):
        first, depth = cursor.i, cursor.depth
        try:
            variables.append(_variable(cursor, family, end))
        except UnexpectedError:
            cursor.recover(first, depth, *_DIRECTIONS, end, *ITEMS)
    cursor.close(end, begin)
    cursor.accept(";")
    return Declaration(place, kind, PORTS[kind], specs, tuple(variables))


def _variable(cursor: Cursor, family: str, end: str) -> Declaration:
    """Read a variable.  END may be missing, with parameters as well (manual line 10017)."""
    place = cursor.place
    if not cursor.is_word(*_DIRECTIONS):
        raise cursor.unexpected(f"INPUT, OUTPUT or {end}")
    direction = cursor.token.text.upper()
    cursor.take()
    kind = with_class(cursor, f"{family} {direction}")
    name = cursor.name("the name of the variable")
    cursor.semicolon(is_optional=True)  # the syntax boxes of the manual leave it out (10036, 10048)
    given = parameters(cursor, kind, KINDS[kind], ("END", *_DIRECTIONS, end), [])
    if cursor.accept("END"):
        cursor.accept(";")
    return Declaration(place, kind, name, given)
