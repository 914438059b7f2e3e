"""VAR_CONFIG: the addresses of variables that were declared with an incomplete one, such as AT %I*."""

from collections.abc import Mapping, Sequence

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.located import location
from fieldrig_devices.iec.check.project import UNKNOWN, Project
from fieldrig_devices.iec.program import Link, Pou, Variable
from fieldrig_devices.iec.types import BlockType


def apply(
    project: Project, blocks: Sequence[tuple[tree.Variables, str]], incomplete: Mapping[Variable, tree.Direct]
) -> list[Link]:
    """Complete the addresses; a message for each that stays incomplete.

    A variable of a function block with different addresses in its instances gets none; its links are returned.
    """
    open_ones = dict(incomplete)
    linked: dict[Variable, list[Link]] = {}
    for block, file in blocks:
        context = Context(project, None, file)
        for node in block.variables:
            _complete(project, node, incomplete, open_ones, context, linked)
    for variable, address in open_ones.items():
        if project.dialect.allows_open_addresses:
            what = f"{variable.name} AT %{address.area}* has no address in VAR_CONFIG"
            project.reports.note(variable.file, address.position, what, "it is a variable like others")
            continue
        project.reports.say(
            variable.file,
            address.position,
            f"the address %{address.area}* of {variable.name} is incomplete",
            "its address in VAR_CONFIG",
            f"VAR_CONFIG PROG.{variable.name} AT %{address.area}X0.0 : {variable.type}; END_VAR",
        )
    links: list[Link] = []
    for variable, own in linked.items():
        if all(link.where == own[0].where for link in own):
            variable.location = own[0].where
        else:
            links += own
    return links


def _complete(
    project: Project,
    node: tree.Variable,
    incomplete: Mapping[Variable, tree.Direct],
    open_ones: dict[Variable, tree.Direct],
    context: Context,
    links: dict[Variable, list[Link]],
) -> None:
    variable = _find(project, node)
    if variable is None:
        context.say(node, f"there is no variable {node.name}", "a path PROGRAM.instance.variable")
        return
    is_whole = variable in incomplete or (project.dialect.has_program_instances and variable.location is None)
    if not is_whole or node.location is None:
        context.say(
            node, f"{node.name} has no incomplete address", f"{variable.name} AT %I* : {variable.type} in its POU"
        )
        return
    made = location(node.location, variable.type, context) if variable.type is not UNKNOWN else None
    if made is not None:
        links.setdefault(variable, []).append(Link(node.name, variable, made))
    open_ones.pop(variable, None)


def _find(project: Project, node: tree.Variable) -> Variable | None:
    first, *path = node.name.split(".")
    entity = project.find(project.key(first))
    variable = entity.instance if isinstance(entity, Pou) else entity if isinstance(entity, Variable) else None
    for name in path:
        kind = variable.type if variable is not None else None
        pou = kind.pou if isinstance(kind, BlockType) else None
        variable = pou.variables.get(project.key(name)) if pou is not None else None
    return variable
