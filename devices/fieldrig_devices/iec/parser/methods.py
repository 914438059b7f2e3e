"""Methods of function blocks and programs, as edition 3 of the standard and today's tools write them.

A method comes before the body of its POU, behind it, or behind the POU.
"""

from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser.configuration import Configurations
from fieldrig_devices.iec.parser.cursor import UnexpectedError

MODIFIERS: Final = frozenset({"PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL", "ABSTRACT", "FINAL", "OVERRIDE"})
"""Words in front of the name of a method.  The access that they give is not checked."""


class Methods(Configurations):
    """Reads methods."""

    def method(self) -> tree.Method:
        """Read METHOD name ... END_METHOD."""
        opening = self.i
        self.gather()
        front = self.taken()
        self.enter()
        self.i += 1
        found = tree.Method("", None, (), tree.StBody(()), place=self.places[opening])
        try:
            self._method_header(found)
        except UnexpectedError:
            line = self.places[opening].line
            while self.places[self.i].line == line and self.kinds[self.i] != token.END:
                self.i += 1
        found.blocks, found.body = self.blocks(), self.body()
        self.gather()
        found.after = self.taken()
        self._end("END_METHOD", opening, "METHOD")
        self.depth -= 1
        self.gather_from(opening)
        found.comments, found.remark = front + self.taken(), self.remark()
        return found

    def _method_header(self, found: tree.Method) -> None:
        while self.texts[self.i].upper() in MODIFIERS and self.kinds[self.i + 1] == token.NAME:
            if self.begins_line(self.i + 1):
                break
            found.modifiers += (self.texts[self.i].upper(),)
            self.i += 1
        found.name = self.name("the name of the method")
        if self.accept(":"):
            found.result = self.type_spec()
        if not self.is_next_line():
            self.accept(";")

    def begins_line(self, at: int) -> bool:
        """True for the first token of a line."""
        return self.places[at].line != self.places[at - 1].line
