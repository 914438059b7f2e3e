"""R_EDGE and F_EDGE: in its body, such an input is TRUE only in a call that finds an edge.

Source: IEC 61131-3:2013, 6.6.3.3: as if the body began with a call of R_TRIG or F_TRIG.  From outside the input has the
value that it was given.
"""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import Edge, PouSource, Project
from fieldrig_devices.iec.check.texts import a
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import AnyStatement, Assign, Binary, Cell, Load, Operator, Space, Unary, Variable
from fieldrig_devices.iec.tree import PouKind, Section

BOOL: Final = Elementary.BOOL


def check(source: PouSource | None, made: Variable, node: tree.Variable, context: Context) -> None:
    """Refuse an edge at anything but an input of type BOOL."""
    if node.edge and not _may_have_edge(source, made):
        context.say(node, f"{node.name} has {node.edge}", "it in VAR_INPUT of a function block or program")
    elif node.edge and made.type is not BOOL:
        context.say(node, f"{node.name} with {node.edge} is {a(made.type)}", "BOOL")


def _may_have_edge(source: PouSource | None, made: Variable) -> bool:
    has_body = source is not None and source.pou.kind in (PouKind.FUNCTION_BLOCK, PouKind.PROGRAM)
    return has_body and made.section is Section.INPUT


def in_body(project: Project, source: PouSource, made: Variable, node: tree.Variable) -> Variable:
    """Return what the body means by the name of a variable: for an input with an edge, a hidden one."""
    if not node.edge or not _may_have_edge(source, made):
        return made
    seen, before = (
        Variable(f"${what}.{node.name}", BOOL, Space.INSTANCE, Section.LOCAL, position=node.position, file=made.file)
        for what in ("edge", "before")
    )
    for hidden in (seen, before):
        source.pou.variables[project.key(hidden.name)] = hidden
    source.edges.append(Edge(made, seen, before, node.edge == "F_EDGE"))
    return seen


def begin_bodies(project: Project) -> None:
    """Let each body begin with the search for the edges of its inputs."""
    for source in project.sources.values():
        pou = source.pou
        line = pou.body[0].line if pou.body else source.tree.position.line
        pou.body[:0] = [statement for edge in source.edges for statement in _search(edge, line)]


def _search(edge: Edge, line: int) -> list[AnyStatement]:
    signal = Load(Cell(edge.input, BOOL))
    now = Unary(Operator.NOT, signal, BOOL) if edge.is_falling else signal
    before = Unary(Operator.NOT, Load(Cell(edge.before, BOOL)), BOOL)
    return [
        Assign(Cell(edge.seen, BOOL), Binary(Operator.AND, now, before, BOOL), line=line),
        Assign(Cell(edge.before, BOOL), now, line=line),
    ]
