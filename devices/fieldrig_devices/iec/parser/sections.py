"""Bodies of POUs, actions and steps, in the language that their first line shows.

A body is SFC if it begins with a step, Instruction List if it begins with a line of IL, and Structured Text otherwise.
"""

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser.statements import Statements


class Bodies(Statements):
    """Reads bodies."""

    def body(self, language: str = "") -> tree.Body:
        """Read a body up to a token that ends it."""
        place = self.places[self.i]
        if self.kinds[self.i] == token.NATIVE:
            self.i += 1
            self.accept(";")
            return tree.NativeBody(place=place)
        return tree.StBody(self.statements(), place=place)
