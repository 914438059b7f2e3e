"""The bodies of a POU and of its actions, each in its language."""

from fieldrig_devices.iec import memory_functions, tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.il import lower_il
from fieldrig_devices.iec.check.project import PouSource, Project
from fieldrig_devices.iec.check.sfc import come_from, lower_sfc
from fieldrig_devices.iec.check.startup import Startup
from fieldrig_devices.iec.check.statements import Statements
from fieldrig_devices.iec.program import AnyStatement, Pou


def has_no_chart(source: PouSource) -> bool:
    return not isinstance(source.tree.body, tree.SfcBody)


def check_pou(project: Project, source: PouSource, startup: Startup) -> None:
    source.pou.body = _body(project, source, source.pou, source.tree.body)
    source.pou.body[:0] = project.preludes.get(source.pou, [])
    first = startup.in_calls(source)
    if first:
        added = _body(project, source, source.pou, tree.StBody(tuple(first)))
        come_from(added, {})
        source.pou.body[:0] = added
    for name, (node, level) in source.actions.items():
        action = source.pou.actions[name]
        action.body = _body(project, source, action, node.body, level)


def _body(project: Project, source: PouSource, pou: Pou, body: tree.Body, level: int = 0) -> list[AnyStatement]:
    context = Context(project, source, pou.file, pou, level)
    match body:
        case tree.StBody():
            return Statements(context).body(body.statements)
        case tree.NativeBody():
            _check_native(project, source, pou)
            return []
        case tree.IlBody():
            made = lower_il(body, context)
            lines = {line.position.line: line for line in reversed(body.instructions)}
            for statement in made:
                statement.origin = lines.pop(statement.line, None)
            return made
        case tree.SfcBody():
            return lower_sfc(body, context, lambda action, inner: _body(project, source, action, inner, level))


def _check_native(project: Project, source: PouSource, pou: Pou) -> None:
    """The host must implement a POU whose body is {native}."""
    name = pou.name.casefold()
    if source.is_library and name in memory_functions.NAMES:
        return
    if not any(name in library.functions or name in library.blocks for library in project.host.libraries):
        position = source.tree.body.position if source.tree.body.position.line else source.tree.position
        project.reports.say(
            pou.file,
            position,
            f"the controller does not implement {pou.name}",
            "a body",
            "only libraries have {native} bodies",
        )
