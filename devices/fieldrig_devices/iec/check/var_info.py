"""__VARINFO: the description of a variable for the program itself, as a structure of constants.

Source: the public description of CODESYS V3 and TwinCAT 3.  Addresses, areas and comments are empty, because programs
that run on any machine have no use for them.
"""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.any_types import class_of
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.sizes import Sizes
from fieldrig_devices.iec.check.texts import text
from fieldrig_devices.iec.program import Cell, Expression, Load, Place, Space, Variable
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import ArrayType, InitialValue, StructType

TYPE: Final = "VAR_INFO"
"""The structure of the library."""
LONGEST: Final = 79
"""Characters of a name in it."""


def of(checker: Checker, node: tree.Call) -> Expression | None:
    """Return the structure for `__VARINFO(variable)`; None after a message."""
    context, given = checker.context, node.arguments[0].value if len(node.arguments) == 1 else None
    if given is None:
        context.say(node, f"{text(node.called)} with {len(node.arguments)} arguments", "one variable")
        return None
    kind = context.project.named_type(TYPE)
    if not isinstance(kind, StructType):
        context.say(node, f"{text(node.called)} without a variable for it", f"a variable of type __SYSTEM.{TYPE}")
        return None
    place = checker.place(given)
    if place is None:
        return None
    project = context.project
    name = f"$constant{len(project.globals)}"
    made = Variable(name, kind, Space.GLOBAL, Section.GLOBAL, _values(checker, place, text(given)), is_constant=True)
    project.globals[context.key(name)] = made
    return Load(Cell(made, kind))


def _values(checker: Checker, place: Place, symbol: str) -> dict[str, InitialValue]:
    kind, sizes = place.type, Sizes(checker.context.project)
    element = kind
    while isinstance(element, ArrayType):
        element = element.element
    bits = 8 * sizes.of(kind)
    values: dict[str, InitialValue] = {
        "BitSize": bits,
        "TypeClass": class_of(kind),
        "TypeName": str(kind)[:LONGEST],
        "NumElements": bits // max(1, 8 * sizes.of(element)) if isinstance(kind, ArrayType) else 0,
        "BaseTypeClass": class_of(element),
        "ElemBitSize": 8 * sizes.of(element),
        "Symbol": symbol[:LONGEST],
    }
    return {checker.context.key(name): value for name, value in values.items()}
