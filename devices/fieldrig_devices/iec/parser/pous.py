"""Programs, function blocks, functions and their actions; and a whole source file.

Source: PacDrive manual 1093 to 1262.  An ACTION follows the body of its POU, in front of
END_PROGRAM or behind it.
"""

from typing import Final, NamedTuple

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser.cursor import UnexpectedError
from fieldrig_devices.iec.parser.declarations import SECTIONS
from fieldrig_devices.iec.parser.statements import OTHER_DIALECTS
from fieldrig_devices.iec.parser.tests import Tests

POUS: Final = {kind.value: kind for kind in tree.PouKind}
_POU_ENDS: Final = frozenset(f"END_{word}" for word in POUS)
_PARTS: Final = ("ACTION", "METHOD", "PROPERTY")
_TOP: Final = frozenset(
    (*POUS, *_PARTS, "TYPE", "VAR_GLOBAL", "VAR_CONFIG", "CONFIGURATION", "RESOURCE", "INTERFACE", token.END)
)
_OOP: Final = frozenset({"METHOD", "PROPERTY", "INTERFACE", "NAMESPACE", "CLASS"})

_MODIFIERS: Final = frozenset({"PUBLIC", "INTERNAL", "ABSTRACT", "FINAL"})


class _Header(NamedTuple):
    """The first line of a POU."""

    name: str
    result: tree.TypeSpec | None = None
    extends: str = ""
    extends_with: tuple[tree.Expression, ...] = ()
    """The generic constants behind EXTENDS."""
    implements: tuple[str, ...] = ()
    in_front: tuple[tree.Variables, ...] = ()
    """The blocks with generic constants in front of EXTENDS and IMPLEMENTS, where TwinCAT has them."""


class Units(Tests):
    """Reads source files."""

    _namespaces: list[int]
    """The tokens of the namespaces that are open."""

    def unit(self) -> tree.Unit:
        """Read everything."""
        declarations: list[tree.Declaration] = []
        self._namespaces = []
        while self.kinds[self.i] != token.END:
            at = self.i
            self.gather()
            try:
                if not self._is_in_namespace():
                    declarations += self._declaration(declarations)
            except UnexpectedError:
                self._synchronise_unit(at)
        for opening in self._namespaces:
            line = self.positions[opening].line
            self.say(self.i, f"got {self.shown(self.i)}", f"END_NAMESPACE for the NAMESPACE in line {line}")
        self.gather_from(0)
        self.gather()
        return tree.Unit(self.file, tuple(declarations), self.taken(), tuple(self.tests), tuple(self.uses), self.rig)

    def _is_in_namespace(self) -> bool:
        """Read a beginning or an end of a NAMESPACE, or USING, if there is one."""
        if not self.dialect.has_namespace_blocks or self.kinds[self.i] != token.NAME:
            return False
        opening = self.i
        if self.accept_word("NAMESPACE"):
            if self.is_word("INTERNAL") and self.kinds[self.i + 1] == token.NAME and not self.begins_line(self.i + 1):
                self.i += 1
            self.qualified_name("the name of the namespace")
            self.accept(";")
            self._namespaces.append(opening)
        elif self._namespaces and self.accept_word("END_NAMESPACE"):
            self.accept(";")
            self._namespaces.pop()
        else:
            self._using()
        return self.i > opening

    def _using(self) -> None:
        """Read `USING Tools.Valves, Tools.Pumps;`, as often as it is there."""
        while self.dialect.has_namespace_blocks and self.accept_word("USING"):
            self.qualified_name("the name of a namespace")
            while self.accept(","):
                self.qualified_name("the name of a namespace")
            self.semicolon()

    def _declaration(self, before: list[tree.Declaration]) -> list[tree.Declaration]:
        kind = self.kinds[self.i]
        if kind == token.NAME and self.is_part_of_tests():
            self.part_of_tests()
            return []
        if kind in POUS:
            return [self._pou()]
        if kind == "TYPE":
            return list(self.type_declarations())
        if kind in ("VAR_GLOBAL", "VAR_CONFIG"):
            return [self.block_of_variables()]
        if kind in ("CONFIGURATION", "RESOURCE"):
            return [self.configuration()]
        if kind == "INTERFACE":
            return [self._interface()]
        if kind in _PARTS:
            self._part_of(before[-1] if before else None)
            return []
        if kind == ";":
            self.i += 1
            return []
        self._wrong_declaration(kind)
        return []

    def _interface(self) -> tree.Interface:
        """Read INTERFACE name EXTENDS others ... END_INTERFACE."""
        opening = self.i
        front = self.taken()
        self.i += 1
        if self.texts[self.i].upper() in ("PUBLIC", "INTERNAL") and not self.begins_line(self.i + 1):
            self.i += self.kinds[self.i + 1] == token.NAME and self.texts[self.i + 1].upper() != "EXTENDS"
        name = self.name("the name of the interface")
        self._using()
        extends = self._names_behind("EXTENDS")
        if not self.is_next_line():
            self.accept(";")
        methods: list[tree.Method] = []
        while self.kinds[self.i] in ("METHOD", "PROPERTY"):
            methods += self.methods(is_interface=True)
        self._end("END_INTERFACE", opening, "INTERFACE")
        interface = tree.Interface(name, extends, tuple(methods), position=self.positions[opening])
        interface.comments, interface.remark = front, self.remark()
        return interface

    def _names_behind(self, word: str) -> tuple[str, ...]:
        """Read a list of names of interfaces behind a word, if it is there."""
        if not self.accept_word(word):
            return ()
        names = [self.qualified_name("the name of an interface")]
        while self.accept(","):
            names.append(self.qualified_name("the name of an interface"))
        return tuple(names)

    def _part_of(self, pou: tree.Declaration | None) -> None:
        """Read an action or a method that follows its POU."""
        what, position = self.kinds[self.i].lower(), self.positions[self.i]
        parts = [self.action()] if what == "action" else self.methods()
        if not isinstance(pou, tree.Pou):
            self.say_at(
                position, f"the {what} {parts[0].name if parts else ''} belongs to no POU", "a POU in front of it"
            )
            return
        for part in parts:
            if isinstance(part, tree.Action):
                pou.actions += (part,)
            else:
                pou.methods += (part,)

    def _wrong_declaration(self, kind: str) -> None:
        hint = ""
        word = self.texts[self.i].upper()
        if kind.startswith("VAR"):
            hint = "Variables outside of a POU are declared in VAR_GLOBAL."
        elif kind.startswith("END_"):
            hint = f"There is no beginning for this {kind}."
        elif word == "CLASS" and self.dialect.has_methods:
            hint = "Classes need the dialect edition-3. Here a FUNCTION_BLOCK with methods does the same."
        elif word in ("NAMESPACE", "USING", "END_NAMESPACE") and self.dialect.has_methods:
            hint = "Namespaces need the dialect edition-3. Here a library's name in front of a name does no harm."
        elif word in _OOP:
            hint = f"{word} is not supported. Use a FUNCTION or a FUNCTION_BLOCK."
            hint += f" {OTHER_DIALECTS}" if word not in ("CLASS", "NAMESPACE") else ""
        elif kind in (token.NAME, "IF", "CASE", "FOR", "WHILE", "REPEAT"):
            hint = "Statements belong into a POU, such as PROGRAM name ... END_PROGRAM."
        raise self.unexpected("PROGRAM, FUNCTION_BLOCK, FUNCTION, TYPE, VAR_GLOBAL or CONFIGURATION", hint)

    def _synchronise_unit(self, start: int) -> None:
        """Go on at the next declaration."""
        if self.i == start and self.kinds[self.i] != token.END:
            self.i += 1
        self.is_test = False
        while (
            self.kinds[self.i] not in _TOP
            and not self.is_part_of_tests()
            and not (self._namespaces and self.is_word("END_NAMESPACE"))
        ):
            self.i += 1
        self._open.clear()
        self.height = self.depth = 0
        self.gather_from(start)

    def body_alone(self, language: str) -> tree.Body:
        """Read a text that is a body, and report what does not belong to it."""
        body: tree.Body = tree.StBody(())
        while True:
            at = self.i
            part = self.body(language)
            body = part if at == 0 else body
            if self.kinds[self.i] == token.END:
                return body
            self.say(self.i, f"got {self.shown(self.i)}", "a statement")
            self.i += 1

    def declarations_alone(self) -> tuple[tree.Variables, ...]:
        """Read a text that consists of blocks of variables."""
        blocks: tuple[tree.Variables, ...] = ()
        while self.kinds[self.i] != token.END:
            blocks += self.blocks()
            if self.kinds[self.i] != token.END:
                self.say(self.i, f"got {self.shown(self.i)}", "VAR, VAR_INPUT or another block of variables")
                while self.kinds[self.i] not in SECTIONS and self.kinds[self.i] != token.END:
                    self.i += 1
        return blocks

    # ---- POUs

    def _pou(self) -> tree.Pou:
        opening = self.i
        front = self.taken()
        kind = POUS[self.kinds[opening]]
        self.i += 1
        modifiers = self._modifiers(kind)
        name, result, extends, extends_with, implements, in_front = self._pou_header(kind)
        blocks = in_front + self.blocks()
        self.actions = []
        methods: list[tree.Method] = []
        while self.kinds[self.i] in ("METHOD", "PROPERTY"):
            methods += self.methods()
        body = self.body()
        actions = self.actions
        self.gather()
        rest = () if self.kinds[self.i] in _PARTS else self.taken()
        while self.kinds[self.i] in _PARTS:
            if self.kinds[self.i] == "ACTION":
                actions.append(self.action())
            else:
                methods += self.methods()
        word = f"END_{kind.value}"
        end = self.positions[self.i]
        self.gather()
        rest += self.taken()
        self._end_of_pou(word, kind, name, opening)
        parts = tuple(actions), tuple(methods)
        position = self.positions[opening]
        pou = tree.Pou(kind, name, result, blocks, body, *parts, extends, modifiers, implements, end, position=position)
        pou.extends_with, pou.blocks_in_front = extends_with, len(in_front)
        pou.comments, pou.remark = front, self.remark()
        pou.after = rest
        return pou

    def _end_of_pou(self, word: str, kind: tree.PouKind, name: str, opening: int) -> None:
        if self.kinds[self.i] in _POU_ENDS:
            if self.kinds[self.i] != word:
                hint = f"{kind.value} ends with {word}."
                self.say(self.i, f"got {self.kinds[self.i]} at the end of {kind.value} {name}", word, hint)
            self.i += 1
            self.accept(";")
            return
        if self.kinds[self.i] not in _TOP:
            self.say(self.i, f"got {self.shown(self.i)}", f"a statement, or {word}")
            while self.kinds[self.i] not in _TOP and self.kinds[self.i] != word:
                self.i += 1
            if self.accept(word):
                return
        line = self.positions[opening].line
        self.say(self.i, f"got {self.shown(self.i)}", f"{word} for {kind.value} {name} in line {line}")

    def _modifiers(self, kind: tree.PouKind) -> tuple[str, ...]:
        """Read words such as ABSTRACT in front of the name."""
        words: list[str] = []
        while self.texts[self.i].upper() in _MODIFIERS and self.kinds[self.i + 1] == token.NAME:
            if self.begins_line(self.i + 1):
                break
            if self.dialect.has_methods:
                words.append(self.texts[self.i].upper())
            else:
                what = f"the name of the {kind.value}"
                self.say(self.i, f"got {self.texts[self.i]}", what, f"Remove {self.texts[self.i]}.")
            self.i += 1
        return tuple(words)

    def _pou_header(self, kind: tree.PouKind) -> _Header:
        """Read the name, the type of a function's result, and what a function block extends and implements."""
        at = self.i
        try:
            name = self.name(f"the name of the {kind.value}")
            self._using()
            front: tuple[tree.Variables, ...] = ()
            while self.kinds[self.i] == "VAR_GENERIC" and kind.has_instances:
                front += (self.block_of_variables(),)
            extends, extends_with = "", tuple[tree.Expression, ...]()
            if self.dialect.has_methods and kind.has_instances and self.accept_word("EXTENDS"):
                extends = self.qualified_name(
                    "the name of a class" if kind is tree.PouKind.CLASS else "the name of a function block"
                )
                if self.kinds[self.i] == "<" and self.dialect.has_generic_constants:
                    extends_with = self.generic_constants()
            implements: tuple[str, ...] = ()
            if self.dialect.has_methods and kind.has_instances:
                implements = self._names_behind("IMPLEMENTS")
            if self.is_word("EXTENDS") or self.is_word("IMPLEMENTS"):
                hint = "Blocks cannot be derived. Declare an instance of the other block in it."
                if self.is_word("IMPLEMENTS"):
                    hint = "There are no interfaces. Remove IMPLEMENTS."
                hint += f" {OTHER_DIALECTS}" if not self.dialect.has_methods else ""
                raise self.unexpected("VAR_INPUT or another declaration", hint)
            result = None
            if self.kinds[self.i] == ":":
                self.i += 1
                if kind is not tree.PouKind.FUNCTION:
                    self.say(self.i, f"a {kind.value} has no result", "VAR_OUTPUT", "Only a FUNCTION has a result.")
                result = self.type_spec()
            if not self.is_next_line():
                self.accept(";")
            self._using()
        except UnexpectedError:
            line = self.positions[at - 1].line
            while self.positions[self.i].line == line and self.kinds[self.i] != token.END:
                self.i += 1
            return _Header(self.texts[at] if self.kinds[at] == token.NAME else "")
        result = result if kind is tree.PouKind.FUNCTION else None
        return _Header(name, result, extends, extends_with, implements, front)
