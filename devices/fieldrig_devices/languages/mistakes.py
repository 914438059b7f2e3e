"""Messages of the compilers: where a mistake is, what is wrong, what was expected, and a hint."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum


class Code(StrEnum):
    """The kinds of mistakes that other code asks for; the texts are for people."""

    OTHER = "other"
    NO_TYPE = "no type"
    """A type, or a block that another one extends, is not declared."""
    NO_FUNCTION = "no function"
    """A function is not declared."""
    NOT_CONSTANT = "not constant"
    """A start value or a limit depends on what is known at run time only."""


@dataclass(frozen=True, slots=True, order=True)
class Mistake:
    line: int
    column: int
    what: str
    expected: str = ""
    is_note: bool = False
    """True if the program compiles all the same."""
    file: str = ""
    """The source file, for languages whose programs have several."""
    hint: str = ""
    """The way to put it right, in the words of the engineer."""
    code: Code = field(default=Code.OTHER, compare=False)
    name: str = field(default="", compare=False)
    """The name that is not declared, without the namespaces in front of it."""

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.file else f"{self.line}:{self.column}"
        head = f"{place}: {'note: ' if self.is_note else ''}{self.what}"
        expected = f"{head}; expected {self.expected}" if self.expected else head
        return f"{expected}\n  hint: {self.hint}" if self.hint else expected


class CompileError(Exception):
    """A program that cannot be compiled, with every mistake in it."""

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        super().__init__("\n".join(map(str, mistakes)))
        self.mistakes = list(mistakes)


class LineError(Exception):
    """The mistake that stops the parser in one line."""

    def __init__(self, column: int, what: str, expected: str = "") -> None:
        super().__init__(what)
        self.column, self.what, self.expected = column, what, expected
