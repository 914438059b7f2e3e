"""Make a tree from the text of an application."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from difflib import get_close_matches
from typing import Final

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.items import Item, Program
from fieldrig_devices.pam.language.other_words import corrected
from fieldrig_devices.pam.language.parser import declarations, ports, programs
from fieldrig_devices.pam.language.parser.cursor import Cursor, UnexpectedError
from fieldrig_devices.pam.language.preprocessor import Preprocessor, Reader, no_files
from fieldrig_devices.pam.language.reserved import ITEMS, declared_names
from fieldrig_devices.pam.language.tokens import LONGEST_SOURCE, Token, mistake, split
from fieldrig_devices.pam.language.tree import Place
from fieldrig_devices.pam.language.words import PREDECLARED

_PROGRAMS: Final[Mapping[str, Callable[[Cursor], Item]]] = {
    "APPLICATION": declarations.application,
    "BOOLEAN": declarations.equation,
    "DUAL_PORT": ports.dual_port,
    "VME": ports.port,
    "RS422": ports.port,
    "ACTIONS": programs.actions,
    "ROUTINES": programs.routines,
    "TASK": programs.task,
}
_PARTS: Final[Mapping[str, str]] = {
    "SEQUENCE": "TASK",
    "EVENTS": "TASK",
    "ROUTINE": "ROUTINES",
    "ON_EVENT": "TASK or ACTIONS",
    "ON_STATE": "TASK or ACTIONS",
}
"""Words of parts, and the item that they belong in."""
_ENDS: Final = ("END_TASK", "END_ACTIONS", "END_ROUTINES", "END_DUALPORT", "END_PORT")
MOST_MISTAKES: Final = 500


def parse(
    text: str, file: str, read: Reader = no_files, *, ignores_case: bool = False
) -> tuple[Program, list[Mistake]]:
    """Return the tree of an application, and every mistake and note in its order.

    `read` returns the text of an included file.  A program with mistakes has a tree as well, without the wrong items.
    With `ignores_case` the tree has each name in its first spelling.
    """
    if len(text) > LONGEST_SOURCE:
        start = Place(file, 1, 1)
        return Program(()), [mistake(start, "the source is too long", f"at most {LONGEST_SOURCE} characters")]
    preprocessor = Preprocessor(read)
    source = split(text, file)
    preprocessor.file(source)
    tokens = unified(preprocessor.tokens, PREDECLARED) if ignores_case else preprocessor.tokens
    names = declared_names(tokens)
    tokens = corrected(tokens, names, preprocessor.mistakes)
    end = Token("end", "the end of the text", source.tokens[-1].place)
    cursor = Cursor([*tokens, end], frozenset() if ignores_case else names)
    items: list[Item] = []
    while not cursor.is_at_end and len(cursor.mistakes) < MOST_MISTAKES:
        begin = cursor.i
        cursor.depth = 0
        try:
            items.append(_item(cursor))
        except UnexpectedError:
            cursor.i = max(cursor.i, begin + 1)
            _skip_to_item(cursor)
    mistakes = sorted(
        [*preprocessor.mistakes, *cursor.mistakes], key=lambda wrong: (wrong.file, wrong.line, wrong.column)
    )
    return Program(tuple(items), tuple(preprocessor.names)), mistakes


def _item(cursor: Cursor) -> Item:
    word = cursor.token.text.upper()
    if word in _PROGRAMS:
        return _PROGRAMS[word](cursor)
    if cursor.is_word(*ITEMS):
        return declarations.declaration(cursor)
    close = get_close_matches(word, (*ITEMS, *_PROGRAMS), 1, 0.7) if cursor.token.kind == "name" else []
    hint = f"Perhaps {close[0]} is meant." if close else ""
    if word in _PARTS:
        hint = f"A part that begins with {word} belongs in {_PARTS[word]}."
    raise cursor.unexpected("the kind of an object, such as NODE, AXIS or TASK", hint)


def _skip_to_item(cursor: Cursor) -> None:
    """Go on behind the END of what could not be read, or at the next item that begins a line."""
    while not cursor.is_at_end:
        line = cursor.tokens[cursor.i - 1].place.line
        if cursor.is_word("END") or cursor.token.text.upper() in _ENDS:
            cursor.take()
            return
        if cursor.place.line != line and cursor.is_word(*ITEMS) and not cursor.is_next("="):
            return
        cursor.take()


def unified(tokens: Iterable[Token], known: Iterable[str]) -> list[Token]:
    """Return the tokens with each name in its first spelling.  The names in `known` keep their own.

    This is for the reading in which AXI_Axes and AXI_axes of the listings are one object (section 15.1).
    """
    first = {name.casefold(): name for name in known}
    return [
        replace(token, text=first.setdefault(token.text.casefold(), token.text)) if token.kind == "name" else token
        for token in tokens
    ]
