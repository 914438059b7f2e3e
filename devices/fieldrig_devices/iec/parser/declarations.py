"""Declarations of variables and types.

Source: PacDrive manual 951 to 1091.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser.blocks import OUTER
from fieldrig_devices.iec.parser.cursor import TEXTS, UnexpectedError
from fieldrig_devices.iec.parser.initials import RESERVED
from fieldrig_devices.iec.parser.types import UNKNOWN, Types

SECTIONS: Final = {section.value: section for section in tree.Section}
_LONG: Final = frozenset({"LWORD", "LINT", "ULINT"})
BEHIND: Final = frozenset({"FUNCTION", "FUNCTION_BLOCK", "CLASS", "TYPE", "ACTION", "METHOD", "RESOURCE"})
"""Words that show that the END of a block of declarations is missing."""
_OUTSIDE: Final = BEHIND | {"PROGRAM", "CONFIGURATION", "IF", "CASE", "FOR", "WHILE", "REPEAT", token.NATIVE}
"""Words that begin what is behind a block of declarations."""
_ENDS: Final = frozenset({"END_VAR", "END_STRUCT", "END_UNION", "END_TYPE"})

_TYPES: Final = frozenset({token.NAME, "ARRAY", "POINTER", "REFERENCE", "REF_TO", "STRUCT", "UNION"})
"""Tokens that a type begins with."""

_HINTS: Final = {
    **dict.fromkeys(("-", "/", "+"), "A name has letters, digits and underscores only."),
    "[": "An array is declared name : ARRAY[1..10] OF INT.",
}
"""Hints about what is between a name and its type, by the token."""


class Declarations(Types):
    """Reads declarations of variables and types.

    A variable whose declaration is wrong behind its name is declared with a type without a name, so that the checker
    does not report it as unknown.
    """

    _names: Sequence[tuple[str, tree.Position]] = ()
    """Names of the declaration that is being read."""

    # ---- blocks of variables

    def blocks(self) -> tuple[tree.Variables, ...]:
        """Read all blocks VAR ... END_VAR that follow."""
        read = []
        while self.kinds[self.i] in SECTIONS or self.kinds[self.i] == "VAR_ACCESS":
            read.append(self.block_of_variables())
        return tuple(read)

    def block_of_variables(self) -> tree.Variables:
        at = self.i
        self.gather()
        front = self.taken()
        word = self.kinds[at]
        self.i += 1
        if word == "VAR_ACCESS":
            self.say(at, "VAR_ACCESS is not supported", "VAR_GLOBAL", "OPC UA and the symbol list show all variables.")
        section = SECTIONS.get(word, tree.Section.GLOBAL)
        access = self._access()
        attributes = self._attributes()
        access = access or self._access()
        variables = self.variables(is_path=section is tree.Section.CONFIG)
        if self.kinds[self.i] == "END_VAR":
            self.i += 1
            if not self.is_next_line():
                self.accept(";")
        else:
            self.say(self.i, f"got {self.shown(self.i)}", f"END_VAR for the {word} in line {self.positions[at].line}")
            if self.kinds[self.i] in _ENDS:
                self.i += 1
        comments = front + (self.taken() if not variables else ())
        block = tree.Variables(section, variables, *attributes, access, position=self.positions[at], comments=comments)
        block.remark = self.remark()
        return block

    def _access(self) -> str:
        """Read PUBLIC and the like, unless it is the name of a variable."""
        word = self.texts[self.i].upper()
        if word not in tree.ACCESS or not self.dialect.has_methods or self.kinds[self.i + 1] in (":", ",", "AT"):
            return ""
        self.i += 1
        return word

    def _attributes(self) -> tuple[bool, bool, bool]:
        """Read RETAIN, PERSISTENT and CONSTANT in any order."""
        words = set()
        while self.kinds[self.i] in ("RETAIN", "PERSISTENT", "CONSTANT") or self.is_word("NON_RETAIN"):
            words.add(self.kinds[self.i])
            self.i += 1
        return "RETAIN" in words, "PERSISTENT" in words, "CONSTANT" in words

    def type_spec(self) -> tree.TypeSpec:
        at = self.i
        kind = self.kinds[at]
        if kind not in ("STRUCT", "UNION"):
            return super().type_spec()
        self.enter()
        try:
            self.i += 1
            fields = self.variables()
            self._end(f"END_{kind}", at, kind, has_semicolon=False)
            return tree.StructSpec(fields, kind == "UNION", position=self.positions[at])
        finally:
            self.depth -= 1

    def variables(self, is_path: bool = False) -> tuple[tree.Variable, ...]:
        """Read declarations up to END_VAR or END_STRUCT."""
        read: list[tree.Variable] = []
        while self.kinds[self.i] not in _ENDS:
            at = self.i
            is_spaced = self.is_spaced(at)
            self.gather()
            if self._is_outside(at):
                break
            front = self.taken()
            try:
                declared = self._variable(is_path)
            except UnexpectedError:
                self._pending[:0] = front
                self._synchronise_declaration(at)
                read += [tree.Variable(name, tree.NamedType(""), position=position) for name, position in self._names]
                continue
            self.gather_from(at)
            declared[0].comments, declared[0].is_spaced = front + self.taken(), is_spaced
            declared[-1].remark = self.remark()
            read += declared
        self.gather()
        if read:
            read[-1].after += self.taken()
        return tuple(read)

    def _is_outside(self, at: int) -> bool:
        """True if a token shows that END_VAR was forgotten."""
        kind = self.kinds[at]
        if kind in _OUTSIDE or kind in SECTIONS:
            return self.kinds[at + 1] != ":"  # a keyword with a colon is a variable with a wrong name
        if kind.startswith("END_") or kind == token.END:
            return True
        if kind != token.NAME or self.kinds[at + 1] not in (":=", "(", ".", "["):
            return False
        return not self._is_declared(at) and not self._ends_later(at)

    def _ends_later(self, at: int) -> bool:
        """True if END_VAR comes before anything that cannot be in a declaration."""
        while self.kinds[at] not in OUTER:
            at += 1
        return self.kinds[at] == "END_VAR"

    def _is_declared(self, at: int) -> bool:
        """True if there is a colon in the line of a name, as in a path or in a declaration that is wrong elsewhere."""
        line = self.positions[at].line
        while self.kinds[at] not in (";", token.END) and self.positions[at].line == line:
            if self.kinds[at] == ":":
                return True
            at += 1
        return False

    def _synchronise_declaration(self, start: int) -> None:
        """Go on behind the semicolon of a wrong declaration, or at the end of its line if it has none."""
        kinds = self.kinds
        if self.i == start and kinds[self.i] not in _ENDS:
            self.i += 1
        while kinds[self.i] not in _ENDS:
            if kinds[self.i - 1] == ";":
                break
            is_inside = kinds[self.i] == token.NAME and not self.is_next_line()  # such as BYTE in by : BYTE := 2;
            if not is_inside and self._is_outside(self.i):
                break
            if self.is_next_line() and kinds[self.i] == token.NAME and kinds[self.i + 1] in (":", "AT"):
                break
            self.i += 1
        self.gather_from(start)
        self.height = 0

    def _variable(self, is_path: bool) -> list[tree.Variable]:
        """Read `a, b AT %QX0.0 : BOOL := TRUE;`."""
        self._names = []
        if self.kinds[self.i] == "AT" and self.kinds[self.i + 1] == token.DIRECT:
            raise self.unexpected("a name in front of AT", "Addresses need no declaration: write them in statements.")
        self._names = names = [self._declared_name(is_path)]
        while self.accept(","):
            names.append(self._declared_name(is_path))
        location, place = None, ""
        if self.accept("AT"):
            if self.is_test and self.kinds[self.i] in TEXTS:
                place = self.quoted("the name of a point")
            elif self.kinds[self.i] != token.DIRECT:
                raise self.unexpected("an address such as %QX1.0")
            else:
                location = self.direct(self.texts[self.i], self.i)
                self.i += 1
        if self.kinds[self.i] in _TYPES and not self.is_next_line():
            self.missing(":")
        elif not self.accept(":"):
            hint = _HINTS.get(self.kinds[self.i], "")
            raise self.unexpected(": and a type", hint)
        spec = self.type_spec()
        edge = self._edge()
        initial = self._initial(spec)
        self._end_of_declaration(spec)
        made = [tree.Variable(name, spec, initial, location, edge, position=position) for name, position in names]
        for variable in made:
            variable.place = place
        return made

    def _edge(self) -> str:
        """Read R_EDGE or F_EDGE, if it is there."""
        if not self.is_word("R_EDGE") and not self.is_word("F_EDGE"):
            return ""
        word = self.texts[self.i].upper()
        if not self.dialect.has_edges:
            hint = f"Call an instance of {word[0]}_TRIG with the input, or choose the dialect edition-3."
            self.say(self.i, f"{word} is not known in this dialect", ";", hint)
        self.i += 1
        return word if self.dialect.has_edges else ""

    def _is_reserved(self, name: str) -> bool:
        """True for the name of an elementary type; LINT is a name where that type is not known (manual 1284)."""
        upper = name.upper()
        return upper in RESERVED and (self.dialect.has_long_types or upper not in _LONG)

    def _declared_name(self, is_path: bool) -> tuple[str, tree.Position]:
        at = self.i
        name = self.name("the name of a variable")
        if self._is_reserved(name):
            self.say(at, f"{name} is the name of a type", "another name for the variable")
        parts = [name]
        while is_path and self.accept("."):
            parts.append(self.name("the name of a variable"))
        while self._is_part_of_name():
            parts[-1] += f"_{self.texts[self.i]}"
            self.say(at, f"the name {name} {self.texts[self.i]} has a blank in it", "one word", f"Write {parts[-1]}.")
            self.i += 1
        return ".".join(parts), self.positions[at]

    def _is_part_of_name(self) -> bool:
        """True if a name has a blank in it, as in `Intermediate result : BOOL`."""
        if self.kinds[self.i] != token.NAME or self.is_next_line():
            return False
        at = self.i
        while self.kinds[at] == token.NAME:
            at += 1
        return self.kinds[at] in (":", ",", "AT")

    def _initial(self, spec: tree.TypeSpec) -> tree.Initial | None:
        if self.kinds[self.i] == "=":
            self.say(self.i, "got =", ":=", "A start value is written with :=.")
        elif self._is_reference_to(spec):
            self.i += 1
        elif self.kinds[self.i] != ":=":
            return None
        self.i += 1
        return self.initial_value(spec)

    def _is_reference_to(self, spec: tree.TypeSpec) -> bool:
        """True at the `REF=` that may be behind a `REFERENCE TO` instead of `:=`."""
        is_reference = isinstance(spec, tree.PointerSpec) and spec.is_reference
        return is_reference and self.is_word("REF") and self.kinds[self.i + 1] == "=" and self.is_adjacent(self.i + 1)

    def _end_of_declaration(self, spec: tree.TypeSpec) -> None:
        if self.accept(";"):
            while self.dialect.allows_empty_declarations and self.accept(";"):
                pass
            return
        if isinstance(spec, tree.StructSpec) and self.kinds[self.i - 1] in ("END_STRUCT", "END_UNION"):
            return
        if self.is_next_line() or self.kinds[self.i] in _ENDS:
            self.missing(";")
            return
        raise self.unexpected(
            ";", "Two declarations are separated by a semicolon." if self.kinds[self.i] == token.NAME else ""
        )

    # ---- TYPE ... END_TYPE

    def type_declarations(self) -> list[tree.TypeDeclaration]:
        """Read TYPE ... END_TYPE with all types in it."""
        opening = self.i
        self.gather()
        front = self.taken()
        self.i += 1
        declarations: list[tree.TypeDeclaration] = []
        while self.kinds[self.i] != "END_TYPE":
            at = self.i
            self.gather()
            if self._is_outside(at) and self.kinds[at] not in ("END_STRUCT", "END_UNION", "END_VAR"):
                break
            front += self.taken()
            try:
                declared = self._type_declaration()
            except UnexpectedError:
                self._synchronise_declaration(at)
                while self.kinds[self.i] in ("END_STRUCT", "END_UNION", "END_VAR"):
                    self.i += 1
                    self.accept(";")
                continue
            self.gather_from(at)
            declared.comments = front + self.taken()
            declared.remark = self.remark()
            front = ()
            declarations.append(declared)
        self.gather()
        self._pending[:0] = front
        if declarations:
            declarations[-1].after += self.taken()
        self._end("END_TYPE", opening, "TYPE")
        return declarations

    def qualified_name(self, expected: str) -> str:
        """Read a name, which may have the name of a library in front."""
        name = self.name(expected)
        while self.accept("."):
            name += f".{self.name(expected)}"
        return name

    def _type_declaration(self) -> tree.TypeDeclaration:
        at = self.i
        if self.dialect.has_methods and self.texts[at].upper() in tree.ACCESS and self.kinds[at + 1] == token.NAME:
            self.i += 1  # a project is one name space, in which every type is known
        name = self.name("the name of a type")
        if self._is_reserved(name):
            self.say(at, f"{name} is an elementary type", "another name for the type")
        extends = ""
        if self.dialect.has_methods and self.accept_word("EXTENDS"):
            extends = self.qualified_name("the name of a structure")
        elif self.is_word("EXTENDS"):
            raise self.unexpected(":", UNKNOWN["EXTENDS"])
        self.expect(":")
        spec = self.type_spec()
        if extends and isinstance(spec, tree.StructSpec):
            spec.extends = extends
        elif extends:
            self.say(at, f"{name} extends {extends} and is no structure", "STRUCT behind the colon")
        initial = self._initial(spec)
        self._end_of_declaration(spec)
        return tree.TypeDeclaration(name, spec, initial, position=self.positions[at])
