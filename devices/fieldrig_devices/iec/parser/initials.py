"""Start values of variables: constants, lists for arrays, and components for structures.

Source: PacDrive manual 772 to 808 and 1062 to 1091.  The start values of an array have no brackets, as in the manual,
or square brackets, as in the standard; both are read in both dialects.
"""

from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser.sections import Bodies

_RESERVED_TEXT = """
    BOOL BYTE WORD DWORD LWORD SINT INT DINT LINT USINT UINT UDINT ULINT REAL LREAL TIME DATE TOD DT TIME_OF_DAY
    DATE_AND_TIME STRING
    """
RESERVED: Final = frozenset(_RESERVED_TEXT.split())
"""Names of types, which nothing else can have."""


class Initials(Bodies):
    """Reads start values."""

    def initial_value(self, spec: tree.TypeSpec | None = None) -> tree.Initial:
        """Read a start value; several with commas are an array."""
        at = self.i
        first = self._element()
        is_array = isinstance(first, tree.Repeated) or isinstance(spec, tree.ArraySpec)
        if self.kinds[self.i] != "," and not is_array:
            return self._one([first], at)
        if self.kinds[self.i] == "," and isinstance(spec, tree.NamedType) and spec.name.upper() in RESERVED:
            self._decimal_comma(spec)
        if self.kinds[self.i] != "," and isinstance(first, tree.ArrayInitial):
            return first
        elements = [first]
        while self.accept(","):
            elements.append(self._element())
        return tree.ArrayInitial(tuple(elements), position=self.positions[at])

    def _decimal_comma(self, spec: tree.NamedType) -> None:
        raise self.unexpected(f"; behind the start value of a {spec.name.upper()}", self.decimal_hint())

    def _element(self) -> tree.Initial | tree.Repeated:
        """Read one start value, `3(value)`, `(field := value)`, `()` or `[value, value]`."""
        at = self.i
        kinds = self.kinds
        if kinds[at] == token.INTEGER and kinds[at + 1] == "(":
            self.enter()
            count = self._primary(token.INTEGER)
            self.i += 1
            values = [self._element()]
            while self.accept(","):
                values.append(self._element())
            self.close(")", at + 1)
            self.depth -= 1
            return tree.Repeated(count, self._one(values, at), position=self.positions[at])
        if kinds[at] == "[":
            return self._array_in_brackets()
        if kinds[at] == "(" and (kinds[at + 1] == ")" or (self._is_identifier(at + 1) and kinds[at + 2] == ":=")):
            return self._struct()
        return self.expression()

    def _array_in_brackets(self) -> tree.ArrayInitial:
        at = self.i
        self.enter()
        self.i += 1
        elements = []
        if self.kinds[self.i] != "]":
            elements.append(self._element())
            while self.accept(","):
                elements.append(self._element())
        self.close("]", at)
        self.depth -= 1
        return tree.ArrayInitial(tuple(elements), position=self.positions[at])

    def _struct(self) -> tree.StructInitial:
        at = self.i
        self.enter()
        self.i += 1
        fields = [self._field()] if self.kinds[self.i] != ")" else []
        while fields and self.accept(","):
            fields.append(self._field())
        self.close(")", at)
        self.depth -= 1
        return tree.StructInitial(tuple(fields), position=self.positions[at])

    def _field(self) -> tree.FieldInitial:
        """Read `name := value`; further values with commas are an array, up to the next name with :=."""
        at = self.i
        if not self._is_identifier(at):
            raise self.unexpected("the name of a component with :=")
        self.i += 1
        self.expect(":=")
        elements = [self._element()]
        while self.kinds[self.i] == "," and not (self._is_identifier(self.i + 1) and self.kinds[self.i + 2] == ":="):
            self.i += 1
            elements.append(self._element())
        return tree.FieldInitial(self.texts[at], self._one(elements, at + 2), position=self.positions[at])

    def _one(self, elements: list[tree.Initial | tree.Repeated], at: int) -> tree.Initial:
        """Return a single value as it is, and several as an array."""
        first = elements[0]
        if len(elements) == 1 and not isinstance(first, tree.Repeated):
            return first
        return tree.ArrayInitial(tuple(elements), position=self.positions[at])
