"""VAR_CONFIG: the addresses of variables that were declared with an incomplete one, such as AT %I*."""

from collections.abc import Mapping, Sequence

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.located import location
from fieldrig_devices.iec.check.project import UNKNOWN, Project
from fieldrig_devices.iec.program import Pou, Variable
from fieldrig_devices.iec.types import BlockType


def apply(
    project: Project, blocks: Sequence[tuple[tree.Variables, str]], incomplete: Mapping[Variable, tree.Direct]
) -> None:
    """Complete the addresses; a message for each that stays incomplete."""
    open_ones = dict(incomplete)
    for block, file in blocks:
        context = Context(project, None, file)
        for node in block.variables:
            _complete(project, node, incomplete, open_ones, context)
    for variable, address in open_ones.items():
        project.reports.say(
            variable.file,
            address.place,
            f"the address %{address.area}* of {variable.name} is incomplete",
            "its address in VAR_CONFIG",
            f"VAR_CONFIG PROG.{variable.name} AT %{address.area}X0.0 : {variable.type}; END_VAR",
        )


def _complete(
    project: Project,
    node: tree.Variable,
    incomplete: Mapping[Variable, tree.Direct],
    open_ones: dict[Variable, tree.Direct],
    context: Context,
) -> None:
    found = _find(project, node)
    if found is None:
        context.say(node, f"there is no variable {node.name}", "a path PROGRAM.instance.variable")
        return
    if found not in incomplete or node.location is None:
        context.say(node, f"{node.name} has no incomplete address", f"{found.name} AT %I* : {found.type} in its POU")
        return
    made = location(node.location, found.type, context) if found.type is not UNKNOWN else None
    if made is not None and found.location is not None and found.location != made:
        # The code of a function block is the same for all instances, and so are its addresses.
        context.say(
            node,
            f"{found.name} has another address in another instance",
            "one address for a variable of a function block",
            "pass the input or output to the block through VAR_INPUT or VAR_OUTPUT",
        )
    elif made is not None:
        found.location = made
    open_ones.pop(found, None)


def _find(project: Project, node: tree.Variable) -> Variable | None:
    first, *path = node.name.split(".")
    entity = project.find(project.key(first))
    found = entity.instance if isinstance(entity, Pou) else entity if isinstance(entity, Variable) else None
    for name in path:
        kind = found.type if found is not None else None
        pou = kind.pou if isinstance(kind, BlockType) else None
        found = pou.variables.get(project.key(name)) if pou is not None else None
    return found
