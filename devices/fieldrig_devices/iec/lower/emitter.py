"""Collects the lines and the cost of one instruction."""

from typing import Final

from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.lower.names import CUTS, REALS
from fieldrig_devices.iec.lower.values import LARGEST, Value, outside
from fieldrig_devices.iec.types import StringType

INDENT: Final = "    "
LONGEST_TEXT: Final = 400
"""Longer expressions are divided, so that their brackets never exceed what CPython's parser takes."""


class Emitter:
    def __init__(self, costs: Costs) -> None:
        self.costs = costs
        self.lines: list[str] = []
        self.cost = 0
        self._temporaries = 0
        self._reals = 0
        self._indent = ""

    # ---- lines

    def add(self, line: str) -> None:
        self.lines.append(self._indent + line)

    def deeper(self) -> None:
        self._indent += INDENT

    def outer(self, line: str) -> str:
        """Return a line for the level above this one."""
        return self._indent[len(INDENT) :] + line

    def back(self) -> None:
        self._indent = self._indent[len(INDENT) :]

    def new(self, text: str) -> str:
        """Add a line that stores an expression in a new variable; return the variable."""
        name = f"t{self._temporaries}"
        self._temporaries += 1
        self.add(f"{name} = {text}")
        return name

    def atom(self, value: Value) -> Value:
        """Return the value as a variable or number, which can be used more than once."""
        if value.is_atom:
            return value
        return Value(self.new(value.text), value.type, value.low, value.high)

    def short(self, value: Value) -> Value:
        """Return the value with a text that is not too long to be part of a larger one."""
        return value if len(value.text) <= LONGEST_TEXT else self.atom(value)

    # ---- values

    def single(self, text: str, kind: Elementary) -> Value:
        """Return a real number, rounded if the type is REAL."""
        if kind is not Elementary.REAL:
            return Value(text, kind)
        if self._reals == REALS:
            return Value(f"SINGLE({text})", kind)
        name = f"F[{self._reals}]"
        self._reals += 1
        self.add(f"{name} = {text}")
        return Value(name, kind)

    def cut(self, value: Value) -> Value:
        """Return the value in the range of its type, by wrapping around."""
        kind = value.type
        if value.fits:
            return value
        assert isinstance(kind, Elementary)
        if kind in (Elementary.TOD, Elementary.LTOD):
            return Value(f"({value.text}) % {kind.high + 1}", kind, 0, kind.high)
        if not kind.is_signed:
            return Value(f"({value.text} & {kind.high})", kind, 0, kind.high)
        name = self.new(value.text)
        self.add(f"if {outside(name, value)}:")
        self.add(f"{INDENT}{name} = {CUTS[kind]}({name})")
        return Value(name, kind, kind.low, kind.high)

    def limited(self, value: Value) -> Value:
        """Return the value, cut if its range is too large to go on with."""
        if value.low >= -LARGEST and value.high <= LARGEST:
            return self.short(value)
        return self.cut(value)

    def charge(self, cost_ns: int) -> None:
        self.cost += cost_ns

    def charge_for(self, kind: Elementary | StringType) -> None:
        """Charge an operation on values of this type."""
        if isinstance(kind, StringType):
            self.cost += self.costs.text_ns
        else:
            self.cost += self.costs.real_ns if kind.is_real else self.costs.operation_ns
