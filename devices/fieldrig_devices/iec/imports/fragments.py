"""Pieces of program text inside of an XML document: expressions, bodies, types and start values, read by the parser."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.parser import parse_body, parse_declarations

_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_ADDRESS: Final = re.compile(r"%([IQM])([XBWDL]?)(\*|\d{1,9}(?:\.\d{1,9}){0,7})", re.IGNORECASE)
_BOOLEANS: Final = {"true": True, "false": False}


@dataclass(slots=True)
class Fragments:
    """Reads fragments of one file; messages go into the report."""

    report: Report
    dialect: Dialect
    around: Sequence[tree.Declaration] = ()
    """The declarations in the other files of the project, and in the libraries of the controller."""

    def expression(self, text: str, line: int) -> tree.Expression | None:
        """The expression, or None with a message."""
        stripped = text.strip()
        position = tree.Position(line, 1)
        if stripped.casefold() in _BOOLEANS:
            return tree.Literal(tree.LiteralKind.BOOL, _BOOLEANS[stripped.casefold()], stripped, position=position)
        if not stripped:
            self.report.mistake(line, "An expression is missing", "a variable, a constant or an expression")
            return None
        body, mistakes = parse_body(
            f"x :=\n{text.rstrip().rstrip(';')};", self.report.file, "ST", self.dialect, line - 1
        )
        self.report.take(mistakes)
        statements = body.statements if isinstance(body, tree.StBody) else ()
        if len(statements) == 1 and isinstance(statements[0], tree.Assign):
            return statements[0].value
        if not any(not mistake.is_note for mistake in mistakes):
            self.report.mistake(line, f"{_short(stripped)} is not an expression", "a single expression")
        return None

    def place(self, text: str, line: int) -> tree.Expression | None:
        """An expression that can be written to."""
        expression = self.expression(text, line)
        if isinstance(expression, tree.Literal | tree.Call | tree.Unary | tree.Binary):
            self.report.mistake(line, f"{_short(text.strip())} cannot be written to", "a variable")
            return None
        return expression

    def body(self, text: str, line: int, language: Literal["ST", "IL"]) -> tree.Body:
        body, mistakes = parse_body(text, self.report.file, language, self.dialect, line)
        self.report.take(mistakes)
        return body

    def variables(self, text: str, line: int) -> tuple[tree.Variables, ...]:
        """The VAR blocks of a text."""
        blocks, mistakes = parse_declarations(text, self.report.file, self.dialect, line)
        self.report.take(mistakes)
        return tuple(blocks)

    def type(self, text: str, line: int) -> tree.TypeSpec:
        """A type that is given as text, such as `ARRAY[0..3] OF INT`."""
        if _NAME.fullmatch(text.strip()):
            return tree.NamedType(text.strip(), position=tree.Position(line, 1))
        declared = self._variable(f": {text.strip()}", line)
        return declared.type if declared else tree.NamedType("", position=tree.Position(line, 1))

    def initial(self, text: str, line: int) -> tree.Initial | None:
        """A start value: an expression, or a list of values for an array or a structure."""
        declared = self._variable(f": DINT := {text.strip()}", line)
        return declared.initial if declared else None

    def address(self, text: str, line: int) -> tree.Direct | None:
        match = _ADDRESS.fullmatch(text.strip())
        if match is None:
            self.report.mistake(line, f"{_short(text)} is not an address", "for example %IX5.0, %QB3 or %MD48")
            return None
        area, size, numbers = match.groups()
        parts = () if numbers == "*" else tuple(map(int, numbers.split(".")))
        return tree.Direct(area.upper(), size.upper(), parts, position=tree.Position(line, 1))

    def is_name(self, text: str, line: int, node: str) -> bool:
        """Return whether the text may be a name (6.1.2); if not, report it as a mistake in the name `of` something."""
        if _NAME.fullmatch(text):
            return True
        self.report.mistake(
            line, f"{_short(text)} cannot be the name of {node}", "a letter, then letters, digits and _"
        )
        return False

    def _variable(self, text: str, line: int) -> tree.Variable | None:
        before = len(self.report.mistakes)
        variables = [
            variable for block in self.variables(f"VAR x {text}; END_VAR", line) for variable in block.variables
        ]
        if len(variables) == 1:
            return variables[0]
        if len(self.report.mistakes) == before:
            self.report.mistake(line, f"{_short(text)} cannot be read as a type or start value")
        return None


def _short(text: str) -> str:
    """The text in quotes, shortened for a message."""
    text = " ".join(text.split())
    return f'"{text[:60]}..."' if len(text) > 60 else f'"{text}"'
