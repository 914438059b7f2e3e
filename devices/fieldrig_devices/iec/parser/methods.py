"""Methods and properties of function blocks and programs, as edition 3 of the standard and today's tools write them.

They come before the body of their POU, behind it, or behind the POU.  A property consists of a method that reads it and
a method that writes it, of which one may be missing.
"""

from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser.configuration import Configurations
from fieldrig_devices.iec.parser.cursor import UnexpectedError

MODIFIERS: Final = tree.ACCESS | {"ABSTRACT", "FINAL", "OVERRIDE"}
"""Words in front of the name of a method."""


_MARKS: Final = frozenset({":=", "(", ".", "^", "["})
"""The tokens that may follow a name at the beginning of a statement."""


class Methods(Configurations):
    """Reads methods and properties."""

    def methods(self, is_interface: bool = False) -> list[tree.Method]:
        """Read a method, or the parts of a property."""
        return [self.method()] if self.kinds[self.i] == "METHOD" else self._property(is_interface)

    def _property(self, is_interface: bool) -> list[tree.Method]:
        """Read PROPERTY name : type GET ... END_GET SET ... END_SET END_PROPERTY.

        A property of an interface with neither can be read.
        """
        opening = self.i
        self.gather()
        front = self.taken()
        self.enter()
        self.i += 1
        head = tree.Method("", None, (), tree.StBody(()), position=self.positions[opening])
        self._header(head)
        accessors: list[tree.Method] = []
        while self.is_word("GET") or self.is_word("SET"):
            accessors.append(self._accessor(head))
        if not accessors and is_interface and head.name:
            accessors.append(
                tree.Method(head.name, head.result, (), tree.StBody(()), head.modifiers, "GET", position=head.position)
            )
        elif not accessors:
            self.say(opening, f"the property {head.name} cannot be read or written", "GET ... END_GET")
        self._end("END_PROPERTY", opening, "PROPERTY")
        self.depth -= 1
        if accessors:
            accessors[0].comments = front + accessors[0].comments
        return accessors

    def _accessor(self, head: tree.Method) -> tree.Method:
        opening, word = self.i, self.texts[self.i].upper()
        self.i += 1
        modifiers = head.modifiers
        while self.kinds[self.i] == token.NAME and self.texts[self.i].upper() in MODIFIERS and self._is_alone():
            own = self.texts[self.i].upper()
            modifiers = (*(word for word in modifiers if own not in tree.ACCESS or word not in tree.ACCESS), own)
            self.i += 1
        method = tree.Method(
            head.name, head.result, (), tree.StBody(()), modifiers, word, position=self.positions[opening]
        )
        method.blocks, method.body = self.blocks(), self.body()
        self.gather()
        method.after = self.taken()
        self._end(f"END_{word}", opening, word)
        self.gather_from(opening)
        method.comments, method.remark = self.taken(), self.remark()
        return method

    def _is_alone(self) -> bool:
        """True for a word that no statement begins with: another line follows it, or what ends the accessor."""
        return self.begins_line(self.i + 1) or (
            self.kinds[self.i + 1] != token.NAME and self.texts[self.i + 1] not in _MARKS
        )

    def method(self) -> tree.Method:
        """Read METHOD name ... END_METHOD."""
        opening = self.i
        self.gather()
        front = self.taken()
        self.enter()
        self.i += 1
        node = tree.Method("", None, (), tree.StBody(()), position=self.positions[opening])
        self._header(node)
        node.blocks, node.body = self.blocks(), self.body()
        self.gather()
        node.after = self.taken()
        self._end("END_METHOD", opening, "METHOD")
        self.depth -= 1
        self.gather_from(opening)
        node.comments, node.remark = front + self.taken(), self.remark()
        return node

    def _header(self, method: tree.Method) -> None:
        """Read what is in the first line, and skip the line after a mistake."""
        line = method.position.line
        try:
            self._method_header(method)
        except UnexpectedError:
            while self.positions[self.i].line == line and self.kinds[self.i] != token.END:
                self.i += 1

    def _method_header(self, method: tree.Method) -> None:
        while self.texts[self.i].upper() in MODIFIERS and self.kinds[self.i + 1] in (token.NAME, "ACTION"):
            if self.begins_line(self.i + 1):
                break
            method.modifiers += (self.texts[self.i].upper(),)
            self.i += 1
        if self.kinds[self.i] == "ACTION" and not self.begins_line(self.i):
            self.i += 1  # a word that only charts need
            method.name = self.texts[self.i - 1]
        else:
            method.name = self.name("the name of the method")
        if self.accept(":"):
            method.result = self.type_spec()
        if not self.is_next_line():
            self.accept(";")

    def begins_line(self, at: int) -> bool:
        """True for the first token of a line."""
        return self.positions[at].line != self.positions[at - 1].line
