"""What a compiler has to say: where, what, and what would be right."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, order=True)
class Mistake:
    line: int
    column: int
    what: str
    expected: str = ""
    is_note: bool = False
    """Worth reading, but the program compiles."""

    def __str__(self) -> str:
        head = f"{self.line}:{self.column}: {'note: ' if self.is_note else ''}{self.what}"
        return f"{head}; expected {self.expected}" if self.expected else head


class CompileError(Exception):
    """A program that can't be compiled, with everything that is wrong in it."""

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        super().__init__("\n".join(map(str, mistakes)))
        self.mistakes = list(mistakes)


class LineError(Exception):
    """The mistake that ends the reading of one line."""

    def __init__(self, column: int, what: str, expected: str = "") -> None:
        super().__init__(what)
        self.column, self.what, self.expected = column, what, expected
