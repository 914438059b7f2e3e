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
        head = tree.Method("", None, (), tree.StBody(()), place=self.places[opening])
        self._header(head)
        found: list[tree.Method] = []
        while self.is_word("GET") or self.is_word("SET"):
            found.append(self._accessor(head))
        if not found and is_interface and head.name:
            found.append(
                tree.Method(head.name, head.result, (), tree.StBody(()), head.modifiers, "GET", place=head.place)
            )
        elif not found:
            self.say(opening, f"the property {head.name} cannot be read or written", "GET ... END_GET")
        self._end("END_PROPERTY", opening, "PROPERTY")
        self.depth -= 1
        if found:
            found[0].comments = front + found[0].comments
        return found

    def _accessor(self, head: tree.Method) -> tree.Method:
        opening, word = self.i, self.texts[self.i].upper()
        self.i += 1
        found = tree.Method(
            head.name, head.result, (), tree.StBody(()), head.modifiers, word, place=self.places[opening]
        )
        found.blocks, found.body = self.blocks(), self.body()
        self.gather()
        found.after = self.taken()
        self._end(f"END_{word}", opening, word)
        self.gather_from(opening)
        found.comments, found.remark = self.taken(), self.remark()
        return found

    def method(self) -> tree.Method:
        """Read METHOD name ... END_METHOD."""
        opening = self.i
        self.gather()
        front = self.taken()
        self.enter()
        self.i += 1
        found = tree.Method("", None, (), tree.StBody(()), place=self.places[opening])
        self._header(found)
        found.blocks, found.body = self.blocks(), self.body()
        self.gather()
        found.after = self.taken()
        self._end("END_METHOD", opening, "METHOD")
        self.depth -= 1
        self.gather_from(opening)
        found.comments, found.remark = front + self.taken(), self.remark()
        return found

    def _header(self, found: tree.Method) -> None:
        """Read what is in the first line, and skip the line after a mistake."""
        line = found.place.line
        try:
            self._method_header(found)
        except UnexpectedError:
            while self.places[self.i].line == line and self.kinds[self.i] != token.END:
                self.i += 1

    def _method_header(self, found: tree.Method) -> None:
        while self.texts[self.i].upper() in MODIFIERS and self.kinds[self.i + 1] in (token.NAME, "ACTION"):
            if self.begins_line(self.i + 1):
                break
            found.modifiers += (self.texts[self.i].upper(),)
            self.i += 1
        if self.kinds[self.i] == "ACTION" and not self.begins_line(self.i):
            self.i += 1  # a word that only charts need
            found.name = self.texts[self.i - 1]
        else:
            found.name = self.name("the name of the method")
        if self.accept(":"):
            found.result = self.type_spec()
        if not self.is_next_line():
            self.accept(";")

    def begins_line(self, at: int) -> bool:
        """True for the first token of a line."""
        return self.places[at].line != self.places[at - 1].line
