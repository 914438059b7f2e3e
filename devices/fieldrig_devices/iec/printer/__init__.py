"""Print a tree as source text in one layout: 4 blanks a level, keywords in capitals, nothing aligned.

Comments stay at their statements, and one empty line between statements stays.  The text of a tree parses to an equal
tree, and printing that again gives the same text.
"""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.printer import bodies, declarations
from fieldrig_devices.iec.printer.expressions import expression_text
from fieldrig_devices.iec.printer.lines import Lines

__all__ = ["expression_text", "print_body", "print_unit"]


def print_unit(unit: tree.Unit) -> str:
    """Return the text of a source file."""
    lines = Lines()
    for number, declaration in enumerate(unit.declarations):
        if number:
            lines.add("")
        declarations.declaration(lines, declaration)
    for comment in unit.comments:
        lines.comment(comment)
    return lines.text()


def print_body(body: tree.Body) -> str:
    """Return the text of a body alone."""
    lines = Lines()
    bodies.body(lines, body)
    return lines.text()
