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
    found: dict[Variable, list[Link]] = {}
    for block, file in blocks:
        context = Context(project, None, file)
        for node in block.variables:
            _complete(project, node, incomplete, open_ones, context, found)
    for variable, address in open_ones.items():
        if project.dialect.allows_open_addresses:
            what = f"{variable.name} AT %{address.area}* has no address in VAR_CONFIG"
            project.reports.note(variable.file, address.place, what, "it is a variable like others")
            continue
        project.reports.say(
            variable.file,
            address.place,
            f"the address %{address.area}* of {variable.name} is incomplete",
            "its address in VAR_CONFIG",
            f"VAR_CONFIG PROG.{variable.name} AT %{address.area}X0.0 : {variable.type}; END_VAR",
        )
    links: list[Link] = []
    for variable, own in found.items():
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
    found = _find(project, node)
    if found is None:
        context.say(node, f"there is no variable {node.name}", "a path PROGRAM.instance.variable")
        return
    if found not in incomplete or node.location is None:
        context.say(node, f"{node.name} has no incomplete address", f"{found.name} AT %I* : {found.type} in its POU")
        return
    made = location(node.location, found.type, context) if found.type is not UNKNOWN else None
    if made is not None:
        links.setdefault(found, []).append(Link(node.name, found, made))
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
