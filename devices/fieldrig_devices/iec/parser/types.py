"""Types: elementary and declared ones, strings, subranges, arrays, pointers, structures and enumerations.

Source: PacDrive manual 757 to 951.
"""

from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.parser.expressions import RANKS
from fieldrig_devices.iec.parser.initials import Initials

UNKNOWN: Final = {
    "REFERENCE": "Use POINTER TO, or pass the variable as VAR_IN_OUT.",
    "UNION": "Overlapping data are variables AT the same address.",
    "EXTENDS": "Types and blocks cannot be derived; declare a variable of the other type in it.",
}

INTEGERS: Final = frozenset(kind.name for kind in Elementary if kind.is_integer)


class Types(Initials):
    """Reads types, apart from structures, whose components are declarations."""

    def type_spec(self) -> tree.TypeSpec:
        """Read a type."""
        at = self.i
        kind = self.kinds[at]
        position = self.positions[at]
        if kind == token.NAME:
            return self._named_type()
        self.enter()
        try:
            if kind == "ARRAY":
                return self._array()
            if kind == "POINTER":
                self.i += 1
                self.expect("TO")
                return tree.PointerSpec(self.type_spec(), position=position)
            if kind == "REFERENCE":
                self.i += 1
                self.expect("TO")
                return tree.PointerSpec(self.type_spec(), True, position=position)
            if kind == "REF_TO":
                self.i += 1
                return tree.PointerSpec(self.type_spec(), position=position)
            if kind == "(":
                return self._enumeration()
        finally:
            self.depth -= 1
        raise self.unexpected("a type")

    def _named_type(self) -> tree.TypeSpec:
        at = self.i
        position = self.positions[at]
        name = self.texts[at]
        self.i += 1
        upper = name.upper()
        if upper in UNKNOWN:
            raise self.unexpected("a type", UNKNOWN[upper], at)
        if upper == "STRING" or (upper == "WSTRING" and self.dialect.has_wide_strings):
            return self._string(position, is_wide=upper == "WSTRING")
        while self.kinds[self.i] == ".":
            self.i += 1
            name += f".{self.name('the name of a type')}"
        if self.kinds[self.i] == "<" and self.dialect.has_generic_constants:
            named = tree.NamedType(name, parameters=self.generic_constants(), position=position)
            named.arguments = self.arguments() if self.kinds[self.i] == "(" else ()
            return named
        if self.kinds[self.i] == "[" and self.kinds[self.i + 1] != "(" and self.kinds[self.i + 2] in ("]", ".."):
            return self._array_of_other_languages(name)
        if self.kinds[self.i] == "[" and self.dialect.has_constructors:
            return tree.NamedType(name, rows=self._rows(), position=position)
        if self.kinds[self.i] != "(":
            return tree.NamedType(name, position=position)
        opening = self.i
        if self.dialect.has_typed_enumerations and upper in INTEGERS and self._is_enumeration():
            enumeration = self._enumeration()
            enumeration.base = "" if upper == "INT" else upper
            return enumeration
        if self.dialect.has_constructors and not self._is_subrange(opening):
            return tree.NamedType(name, self.arguments(), position=position)
        self.i += 1
        if self.kinds[self.i + 1 : self.i + 2] == [":="]:
            raise self.unexpected("; or :=", f"Start values are written : {name} := (...);", opening)
        low = self.expression()
        self.expect("..", "A part of an integer type is written INT(0..100).")
        high = self.expression()
        self.close(")", opening)
        return tree.SubrangeSpec(tree.NamedType(name, position=position), low, high, position=position)

    def generic_constants(self) -> tuple[tree.Expression, ...]:
        """Read `<10, SIZE + 1>`; a comparison has to be in brackets there."""
        opening = self.i
        self.i += 1
        read = [self.expression(RANKS["+"])]
        while self.accept(","):
            read.append(self.expression(RANKS["+"]))
        self.close(">", opening)
        return tuple(read)

    def _array_of_other_languages(self, name: str) -> tree.TypeSpec:
        """Report `INT[5]`, and go on behind it."""
        at = self.i
        self.i += 1
        inside = self.expression()
        is_number = isinstance(inside, tree.Literal) and inside.kind is tree.LiteralKind.INTEGER
        limits = f"1..{inside.text}" if isinstance(inside, tree.Literal) and is_number else "1..10"
        if self.accept(".."):
            limits = "1..10"
            self.expression()
        self.close("]", at)
        hint = "The limits of an array are in front of the type of its elements."
        self.say(at, f"got {name}[", f"ARRAY[{limits}] OF {name}", hint)
        return tree.NamedType("", position=self.positions[at])

    def _rows(self) -> tuple[tuple[tree.Argument, ...], ...]:
        """Read the arguments of FB_init for each element of an array."""
        at = self.i
        rows: list[tuple[tree.Argument, ...]] = []
        while self.kinds[self.i] in ("[", ","):
            self.i += 1
            if self.kinds[self.i] != "(":
                raise self.unexpected("(", "The arguments of each element are in brackets.")
            rows.append(self.arguments())
        self.close("]", at)
        return tuple(rows)

    def _is_subrange(self, opening: int) -> bool:
        """True if the brackets contain limits and no arguments."""
        depth = 0
        for at in range(opening, len(self.kinds)):
            kind = self.kinds[at]
            depth += (kind == "(") - (kind == ")")
            if depth == 0 or kind in (";", token.END):
                return False
            if kind == ".." and depth == 1:
                return True
        return False

    def _is_enumeration(self) -> bool:
        """True if names of values follow the bracket, and no limits of a subrange."""
        return self.kinds[self.i + 1] == token.NAME and self.kinds[self.i + 2] in (",", ":=", ")")

    def _string(self, position: tree.Position, *, is_wide: bool) -> tree.StringSpec:
        opening = self.i
        closing = {"(": ")", "[": "]"}.get(self.kinds[opening])
        if closing is None:
            return tree.StringSpec(is_wide=is_wide, position=position)
        self.i += 1
        length = self.expression()
        self.close(closing, opening)
        return tree.StringSpec(length, is_wide, position=position)

    def _array(self) -> tree.ArraySpec | tree.OpenArraySpec:
        at = self.i
        self.i += 1
        opening = self.i
        self.expect("[", "An array is written ARRAY[1..10] OF INT.")
        if self.kinds[self.i] == "*":
            return self._open_array(at, opening)
        dimensions = [self._range()]
        while self.accept(","):
            dimensions.append(self._range())
        self.close("]", opening)
        self.expect("OF")
        return tree.ArraySpec(tuple(dimensions), self.type_spec(), position=self.positions[at])

    def _open_array(self, at: int, opening: int) -> tree.OpenArraySpec:
        if not self.dialect.has_open_arrays:
            self.say(self.i, "got *", "limits such as 1..10", "ARRAY[*] is known in the dialect edition-3.")
        count = 1
        self.i += 1
        while self.accept(","):
            self.expect("*", "Either all limits are *, or none.")
            count += 1
        self.close("]", opening)
        self.expect("OF")
        return tree.OpenArraySpec(count, self.type_spec(), position=self.positions[at])

    def _range(self) -> tree.Range:
        position = self.positions[self.i]
        low = self.expression()
        self.expect("..", "The limits of an array are written 1..10.")
        return tree.Range(low, self.expression(), position=position)

    def _enumeration(self) -> tree.EnumSpec:
        at = self.i
        self.i += 1
        values = [self._enum_value()]
        while self.accept(","):
            values.append(self._enum_value())
        self.close(")", at)
        return tree.EnumSpec(tuple(values), self._base_behind(), position=self.positions[at])

    def _base_behind(self) -> str:
        """Read the type of the values behind an enumeration, as today's tools write it."""
        if self.kinds[self.i] != token.NAME or self.is_next_line():
            return ""
        base = self.texts[self.i].upper()
        if base != "INT" and not (self.dialect.has_typed_enumerations and base in INTEGERS):
            what = f"got {self.texts[self.i]} behind an enumeration"
            self.say(self.i, what, ";", f"Its values are INT. Remove {self.texts[self.i]}.")
        self.i += 1
        return base if base in INTEGERS and base != "INT" else ""

    def _enum_value(self) -> tree.EnumValue:
        at = self.i
        self.gather()
        front = self.taken()
        name = self.name("the name of a value")
        value = None
        if self.kinds[self.i] == "=":
            self.say(self.i, "got =", ":=", "A value is written with :=.")
            self.i += 1
            value = self.expression()
        elif self.accept(":="):
            value = self.expression()
        self.gather_from(at)
        if self.kinds[self.i] == ",":  # a remark follows the comma or precedes it
            self.gather()
        node = tree.EnumValue(name, value, position=self.positions[at], comments=front + self.taken())
        line = self.positions[self.i - 1].line
        following = self.i + 1 if self.kinds[self.i] == "," else self.i
        behind = self.comments.get(following, [])
        if behind and self.positions[following - 1].line == line:
            node.remark = " ".join(text for begin, text in behind if begin == line)
            rest = [(begin, text) for begin, text in behind if begin != line]
            if rest:
                self.comments[following] = rest
            else:
                del self.comments[following]
        return node
