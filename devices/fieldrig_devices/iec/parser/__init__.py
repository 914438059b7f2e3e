"""The parser of IEC 61131-3: it turns a source text into its tree, and reports all mistakes at once.

It is a recursive descent by hand, a class for each layer of the grammar with the one below as its base: `cursor`,
`expressions`, `statements`, `sections` (bodies, with Instruction List and SFC), `declarations`, `configuration`,
`methods`, `tests`, `pous`.  A layer calls only those below it, and all of them move the one cursor, in more than every
third line.  No text makes the parser raise an exception, and a limit of nesting keeps it away from Python's own.
"""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import EPAS_4, Dialect
from fieldrig_devices.iec.parser.pous import Units
from fieldrig_devices.iec.tokens import tokens
from fieldrig_devices.languages.mistakes import Mistake


def parse(text: str, file: str, dialect: Dialect = EPAS_4) -> tuple[tree.Unit, list[Mistake]]:
    """Parse a source file as far as possible, and return it with its mistakes in the order of the text."""
    reader = Units(tokens(text, file, dialect), file, dialect)
    unit = reader.unit()
    return unit, _in_order(reader.mistakes)


def parse_body(
    text: str, file: str, language: str, dialect: Dialect = EPAS_4, first_line: int = 1
) -> tuple[tree.Body, list[Mistake]]:
    """Parse a body alone, in the language "ST", "IL" or "SFC"; an empty language takes that of the first line."""
    reader = Units(tokens(text, file, dialect, first_line), file, dialect)
    return reader.body_alone(language), _in_order(reader.mistakes)


def parse_declarations(
    text: str, file: str, dialect: Dialect = EPAS_4, first_line: int = 1
) -> tuple[tuple[tree.Variables, ...], list[Mistake]]:
    """Parse blocks VAR ... END_VAR alone."""
    reader = Units(tokens(text, file, dialect, first_line), file, dialect)
    return reader.declarations_alone(), _in_order(reader.mistakes)


def _in_order(mistakes: list[Mistake]) -> list[Mistake]:
    """Return the mistakes in the order of the text, one at each place: that of the parser, which knows more."""
    by_place = {(mistake.line, mistake.column): mistake for mistake in mistakes}
    return sorted(by_place.values())
