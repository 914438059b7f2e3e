"""Print a tree as source text in one layout: 4 blanks a level, keywords in capitals, nothing aligned.

Comments stay at their statements, and one empty line between statements stays.  The text of a tree parses to an equal
tree, and printing that again gives the same text.
"""

from collections.abc import Sequence

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.printer import bodies, declarations, tests
from fieldrig_devices.iec.printer.expressions import expression_text
from fieldrig_devices.iec.printer.lines import Lines

__all__ = ["expression_text", "print_body", "print_unit"]


def print_unit(unit: tree.Unit) -> str:
    """Return the text of a source file."""
    lines = Lines()
    for number, node in enumerate(_in_order(unit)):
        if number:
            lines.add("")
        if isinstance(node, tree.Test | tree.Use | tree.RigUse):
            tests.part_of_tests(lines, node)
        else:
            declarations.declaration(lines, node)
    for comment in unit.comments:
        lines.comment(comment)
    return lines.text()


def _in_order(unit: tree.Unit) -> Sequence[tree.Declaration | tree.Test | tree.Use | tree.RigUse]:
    """Return everything in a file in the order of its text."""
    if not (unit.tests or unit.uses or unit.rig):
        return unit.declarations
    rig = () if unit.rig is None else (unit.rig,)
    return sorted((*unit.declarations, *unit.tests, *unit.uses, *rig), key=lambda node: node.position)


def print_body(body: tree.Body) -> str:
    """Return the text of a body alone."""
    lines = Lines()
    bodies.body(lines, body)
    return lines.text()
