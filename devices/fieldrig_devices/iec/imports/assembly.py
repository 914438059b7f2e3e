"""The POUs of a document, first as they are declared, then with their bodies: a body may use any declaration."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.networks.bodies import Bodies
from fieldrig_devices.iec.imports.networks.graph import Condition, Drawn
from fieldrig_devices.iec.imports.networks.hidden import Hidden
from fieldrig_devices.iec.imports.networks.kinds import Kinds


@dataclass(slots=True)
class Part:
    """An action or a transition of a POU, with a name of its own."""

    name: str
    line: int
    body: Drawn
    comments: tuple[str, ...] = ()


@dataclass(slots=True)
class Raw:
    """A POU with bodies as the document has them."""

    kind: tree.PouKind
    name: str
    line: int
    result: tree.TypeSpec | None = None
    blocks: tuple[tree.Variables, ...] = ()
    bodies: list[Drawn] = field(default_factory=list)
    actions: list[Part] = field(default_factory=list)
    transitions: list[Part] = field(default_factory=list)
    comments: tuple[str, ...] = ()
    methods: list["Raw"] = field(default_factory=list)
    """Methods, and the accessors of properties."""
    accessor: str = ""
    """GET or SET for an accessor, whose property has the type `result`."""
    extends: str = ""
    implements: tuple[str, ...] = ()
    modifiers: tuple[str, ...] = ()


def assemble(raws: Sequence[Raw], others: Sequence[tree.Declaration], fragments: Fragments) -> list[tree.Pou]:
    """The POUs with their bodies.  `others` are the types and global variables of the document."""
    kinds = _kinds(raws, others, fragments)
    return [_pou(raw, kinds, fragments) for raw in raws]


def _kinds(raws: Sequence[Raw], others: Sequence[tree.Declaration], fragments: Fragments) -> Kinds:
    kinds = Kinds(fragments.dialect)
    kinds.take(fragments.around)
    kinds.take(others)
    kinds.take(_stub(raw) for raw in raws)
    return kinds


def _stub(raw: Raw) -> tree.Pou:
    """Return a POU as it is declared, without its bodies."""
    methods = tuple(
        tree.Method(method.name, method.result, method.blocks, tree.StBody(()), accessor=method.accessor)
        for method in raw.methods
    )
    return tree.Pou(raw.kind, raw.name, raw.result, raw.blocks, tree.StBody(()), methods=methods, extends=raw.extends)


def _pou(raw: Raw, kinds: Kinds, fragments: Fragments) -> tree.Pou:
    names = {v.name.casefold() for block in raw.blocks for v in block.variables}
    parts = {part.name.casefold() for part in (*raw.actions, *raw.transitions)}
    taken = {raw.name.casefold(), *names, *parts, *kinds.variables, *kinds.pous, *kinds.types}
    inner = kinds.of_pou(raw.name, raw.blocks, raw.result)
    hidden = Hidden(taken, raw.kind is not tree.PouKind.FUNCTION, inner.variables, inner.narrow)
    bodies = Bodies(fragments, hidden, inner)
    for part in raw.transitions:
        bodies.conditions[part.name.casefold()] = Condition(part.line, body=part.body)
    position = tree.Position(raw.line, 1)
    with fragments.report.inside(f"{raw.kind.value} {raw.name[:60]}"):
        main = _joined([bodies.body(drawn) for drawn in raw.bodies], fragments, position)
        actions = [_action(part, bodies, fragments) for part in raw.actions]
        methods = [_method(method, raw, kinds, fragments) for method in raw.methods]
    return tree.Pou(
        raw.kind,
        raw.name,
        raw.result,
        (*raw.blocks, *hidden.block()),
        main,
        (*actions, *bodies.actions),
        tuple(methods),
        raw.extends,
        raw.modifiers,
        raw.implements,
        comments=raw.comments,
        position=position,
        end=tree.Position(max((drawn.line for drawn in raw.bodies), default=raw.line), 1),
    )


def _method(raw: Raw, outer: Raw, kinds: Kinds, fragments: Fragments) -> tree.Method:
    inner = kinds.of_pou(outer.name, outer.blocks, None).of_pou(raw.name, raw.blocks, raw.result)
    position = tree.Position(raw.line, 1)
    hidden = Hidden(
        {raw.name.casefold(), *inner.variables, *inner.pous, *inner.types}, False, inner.variables, inner.narrow
    )
    with fragments.report.inside(f"method {raw.name[:60]}"):
        bodies = Bodies(fragments, hidden, inner)
        body = _joined([bodies.body(drawn) for drawn in raw.bodies], fragments, position)
    blocks = (*raw.blocks, *hidden.block())
    return tree.Method(
        raw.name, raw.result, blocks, body, raw.modifiers, raw.accessor, comments=raw.comments, position=position
    )


def prototype(raw: Raw) -> tree.Method:
    """Return a method of an interface, which has no code, no access specifier and no variables but its arguments."""
    kinds = (tree.Section.INPUT, tree.Section.OUTPUT, tree.Section.IN_OUT)
    arguments = tuple(block for block in raw.blocks if block.section in kinds)
    position, comments = tree.Position(raw.line, 1), raw.comments
    return tree.Method(
        raw.name, raw.result, arguments, tree.StBody(()), accessor=raw.accessor, comments=comments, position=position
    )


def _action(part: Part, bodies: Bodies, fragments: Fragments) -> tree.Action:
    position = tree.Position(part.line, 1)
    with fragments.report.inside(f"ACTION {part.name[:60]}"):
        fragments.is_name(part.name, part.line, "an action")
        return tree.Action(part.name, bodies.body(part.body), comments=part.comments, position=position)


def _joined(bodies: list[tree.Body], fragments: Fragments, position: tree.Position) -> tree.Body:
    """Several worksheets of a POU are executed one after the other."""
    if len(bodies) == 1:
        return bodies[0]
    statements: list[tree.AnyStatement] = []
    for body in bodies:
        if isinstance(body, tree.StBody):
            statements += body.statements
        else:
            fragments.report.mistake(
                body.position.line, "A body of several worksheets has one in IL or SFC", "worksheets in ST, LD or FBD"
            )
    return tree.StBody(tuple(statements), position=position)
