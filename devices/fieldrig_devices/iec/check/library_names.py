"""Names with that of a library or of a namespace in front."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import OUTSIDE, Context
from fieldrig_devices.iec.check.project import Entity
from fieldrig_devices.iec.library import intrinsics
from fieldrig_devices.iec.program import Pou


def without_library(context: Context, node: tree.Expression) -> tree.Expression:
    """Return a name without that of a library in front, `Tc2_Standard.LEN`, or that of a namespace, `A.B.Name`."""
    if not isinstance(node, tree.Member):
        return node
    first: tree.Expression = node.of
    while isinstance(first, tree.Member) and _may_be_outside(context, first.name):
        if context.find(first.name) is not None:
            return node  # a component of something that has a library in front, `Library.Instance.Output`
        first = first.of
    if not isinstance(first, tree.Name):
        return node
    project, library, name = context.project, context.key(first.text), context.key(node.name)
    known = (project.types, project.lists, project.facades, {"this": None, "super": None})
    if _is_value(context.find(first.text)) or any(library in names for names in known):
        return node
    is_listed = name in project.types or name in project.lists
    is_ours = project.find(name) is not None or is_listed or intrinsics.is_standard(node.name)
    if not is_ours:
        return node
    is_hidden = name in context.names and (project.find(name) is not None or intrinsics.is_standard(node.name))
    return tree.Name(f"{OUTSIDE}{node.name}" if is_hidden else node.name, position=node.position)


def _may_be_outside(context: Context, name: str) -> bool:
    """True for what may have a library in front of it: a namespace, and the list of a library's global variables."""
    return context.project.dialect.has_namespace_blocks or context.key(name) == context.key("Global_Variables")


def _is_value(entity: Entity | None) -> bool:
    """False for a function block, whose name may be that of its library, as components are those of instances."""
    return entity is not None and not (isinstance(entity, Pou) and entity.kind.has_instances)
