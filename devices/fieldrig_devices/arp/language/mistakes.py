"""Messages of the compiler: where a mistake is, what is wrong, and what was expected."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, order=True)
class Mistake:
    line: int
    column: int
    what: str
    expected: str = ""
    is_note: bool = False
    """True if the program compiles all the same."""

    def __str__(self) -> str:
        head = f"{self.line}:{self.column}: {'note: ' if self.is_note else ''}{self.what}"
        return f"{head}; expected {self.expected}" if self.expected else head


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
