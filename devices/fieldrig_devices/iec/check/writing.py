"""Which places may be written, and to which a reference can point."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import (
    access,
    check_functions,
    dispatch,
    open_arrays,
)
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import START
from fieldrig_devices.iec.check.texts import text
from fieldrig_devices.iec.program import (
    AddressOf,
    Binary,
    Bit,
    Cell,
    Component,
    Element,
    Located,
    OpenElement,
    Parameter,
    Place,
    Result,
    Target,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import (
    BlockType,
    ObjectType,
    Type,
)


def has_cell(place: Place) -> bool:
    """False for bits, also those of %I, %Q and %M, and for parameters of objects: no reference can point to them."""
    return not isinstance(place, Bit | Parameter) and not (isinstance(place, Located) and place.bit >= 0)


def is_writable(context: Context, place: Place, node: tree.Node) -> bool:
    """True if the place may be written here; a message otherwise."""
    what, hint = _obstacle(context, place, node)
    check_functions.writes(place)
    if what:
        context.say(node, what, "a variable that may be written here", hint)
    return not what


def _obstacle(context: Context, place: Place, node: tree.Node) -> tuple[str, str]:
    whole = place
    while True:
        match place:
            case Cell(declared):
                return _variable_obstacle(context, declared)
            case Component(variable=Variable() as declared):
                is_part = place is not whole and context.project.dialect.writes_parts_of_outputs
                is_free = is_part or context.extension is not None  # a test sets the outputs of a mock
                if declared.section is Section.OUTPUT and not is_free and not _is_start(context):
                    return f"{text(node)} is an output and only its block writes it", "outputs are read: x := inst.Q;"
                if declared.is_constant:
                    return f"{text(node)} is a constant", ""
                if _is_local(context, declared, place):
                    return f"{text(node)} belongs to its block", "from outside it can only be read"
                return "", ""
            case Component(of=of) | Element(of=of) | OpenElement(of=of) | Bit(of=of):
                place = of
            case Located():
                is_input = place.area == "I" and context.extension is None  # a test sets the inputs
                return _input_obstacle(context, node) if is_input else ("", "")
            case Target(AddressOf(place=of)) | Target(Binary(left=AddressOf(place=of))):  # a part of a union or value
                place = of
            case Result():
                return f"{text(node)} is a part of a result", ""
            case Parameter():
                return ("", "") if place.is_writable else (f"the parameter {text(node)} can only be read", "")
            case _:
                return "", ""


def _is_start(context: Context) -> bool:
    """True for the code that gives variables their start values."""
    return context.owner is not None and START in context.owner.name


def _is_local(context: Context, declared: Variable, place: Component) -> bool:
    """True for a variable of a function block that only the code of the block may write."""
    kind = place.of.type
    is_block = isinstance(kind, BlockType) and kind.pou is not None and kind.pou.kind is PouKind.FUNCTION_BLOCK
    is_inside = declared.section is Section.LOCAL and not access.is_open(context.project, declared)
    if not is_block or not is_inside or _is_start(context) or context.extension is not None:
        return False
    return not _is_of_the_same_block(context, kind)


def _is_of_the_same_block(context: Context, kind: Type) -> bool:
    """True for an instance of the function block whose code this is, or of one that it extends."""
    own = context.block.type if context.block is not None else None
    is_allowed = context.project.dialect.writes_locals_of_its_kind
    return is_allowed and own is not None and dispatch.is_or_derives(context.project, own, kind)


def _input_obstacle(context: Context, node: tree.Node) -> tuple[str, str]:
    what = f"{text(node)} is an input"
    if not context.project.dialect.writes_inputs:
        return what, "inputs are only read"
    context.note(node, f"{what}, and the program writes it", "an input of the machine overwrites it in each cycle")
    return "", ""


def _variable_obstacle(context: Context, declared: Variable) -> tuple[str, str]:
    if declared.is_constant or declared.is_fixed:
        return f"{declared.name} is a constant", "remove CONSTANT from its declaration if it has to change"
    is_input = declared.section is Section.INPUT and not isinstance(declared.type, ObjectType)
    if is_input and open_arrays.is_open(declared):
        return f"{declared.name} is a VAR_INPUT, of which there is no copy", "declare it in VAR_IN_OUT"
    if is_input and not context.project.dialect.allows_changed_inputs:
        # Manual table 4-6: an input comes from outside and cannot be changed within the POU.
        return f"{declared.name} is a VAR_INPUT and cannot be changed within its POU", "copy it into a variable of VAR"
    if isinstance(declared.type, BlockType) and context.block is not None and declared is context.block.instance:
        return f"{declared.name} is a program", ""
    return "", ""
