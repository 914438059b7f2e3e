"""The lines of one instruction, and the values that they compute."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.pam.language.functions import Type
from fieldrig_devices.pam.language.tree import Expression

INDENT: Final = "    "
LOW: Final = -(2**31)
HIGH: Final = 2**31 - 1
"""The range of integers (PAML-222)."""
LONGEST_TEXT: Final = 300
"""Longer expressions are divided, so that their brackets never exceed what CPython's parser takes."""


@dataclass(frozen=True, slots=True)
class Operand:
    """A value as Python text without side effects."""

    text: str
    type: Type
    low: int = LOW
    high: int = HIGH
    """The range of an integer, so that only results that may leave it are checked."""
    is_finite: bool = True
    """False for a real that may be infinite; it is checked before it can become finite again."""

    @property
    def is_atom(self) -> bool:
        return self.text.lstrip("-").replace(".", "").isalnum()

    @property
    def constant(self) -> int | None:
        """The value of an integer that is known now."""
        return self.low if self.type == "integer" and self.low == self.high else None


class Emitter:
    """Collects the lines of one instruction.

    An infinite real stays infinite or becomes NaN by +, - and *, so it is enough to check a result before it is
    stored, compared, divided by, or given to a function (PAML-228).
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._temporaries = 0

    def new(self, text: str) -> str:
        """Add a line that stores an expression in a new variable; return the variable."""
        name = f"t{self._temporaries}"
        self._temporaries += 1
        self.lines.append(f"{name} = {text}")
        return name

    def atom(self, operand: Operand) -> Operand:
        """Return the operand as a variable or number, which can be used more than once."""
        if operand.is_atom:
            return operand
        return Operand(self.new(operand.text), operand.type, operand.low, operand.high, operand.is_finite)

    def short(self, operand: Operand) -> Operand:
        return operand if len(operand.text) <= LONGEST_TEXT else self.atom(operand)

    def in_range(self, operand: Operand) -> Operand:
        """Return an integer that has 32 bits: a result outside stops the program (02..FFF2)."""
        if operand.low >= LOW and operand.high <= HIGH:
            return operand
        name = self.new(operand.text)
        self.lines += [f"if not {LOW} <= {name} <= {HIGH}:", f"{INDENT}overflow()"]
        return Operand(name, "integer")

    def finite(self, operand: Operand) -> Operand:
        """Return a real that is a number: any other stops the program (02..FFF3)."""
        if operand.type != "real" or operand.is_finite:
            return operand
        name = operand.text if operand.is_atom else self.new(operand.text)
        self.lines += [f"if {name} - {name}:", f"{INDENT}invalid()"]
        return Operand(name, "real")

    # ---- conversions

    def flag(self, operand: Operand) -> Operand:
        """Return a value as a flag; a listing writes 0 and 1 (manual line 5775)."""
        if operand.type == "flag":
            return operand
        if operand.constant is not None:
            return Operand(str(bool(operand.constant)), "flag")
        return Operand(f"({operand.text} != 0)", "flag")

    def number(self, operand: Operand) -> Operand:
        """Return a value as a number; a flag is 0 or 1."""
        return Operand(operand.text, "integer", 0, 1) if operand.type == "flag" else operand

    def integer(self, operand: Operand) -> Operand:
        """Return a value as an integer; the fraction of a real is dropped (PAML-227)."""
        operand = self.number(operand)
        if operand.type == "integer":
            return self.in_range(operand)
        return Operand(self.new(f"truncated({self.finite(operand).text})"), "integer")

    def real(self, operand: Operand) -> Operand:
        operand = self.number(operand)
        if operand.type == "real":
            return self.finite(operand)
        if operand.constant is not None:
            return Operand(repr(float(operand.constant)), "real")
        return Operand(f"({operand.text} + 0.0)", "real")

    def as_type(self, operand: Operand, value_type: Type) -> Operand:
        """Return a value as a variable of this type stores it."""
        match value_type:
            case "flag":
                return self.flag(operand)
            case "integer":
                return self.integer(operand)
        return self.real(operand)

    def checked(self, operand: Operand) -> Operand:
        """Return a value of any type as it may be compared, stored or given away."""
        return self.in_range(operand) if operand.type == "integer" else self.finite(operand)


OperandOf = Callable[[Expression, Emitter], Operand]
"""Computes a part of an expression, with lines of the emitter."""
