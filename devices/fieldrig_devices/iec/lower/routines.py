"""A routine for the body of each POU and action, and the lowered program as a whole."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from fieldrig.coverage.places import Marked
from fieldrig_devices.iec.costs import CODE_PER_NS, CODE_PER_ROUTINE, Costs
from fieldrig_devices.iec.host import NativeBlock, NativeFunction
from fieldrig_devices.iec.layout import STACK_SIZE
from fieldrig_devices.iec.lower.body import Body, Context
from fieldrig_devices.iec.lower.names import BEGIN, NATIVE
from fieldrig_devices.iec.lower.statements import Statements
from fieldrig_devices.iec.program import Pou, Program
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import Type, Value
from fieldrig_devices.languages.instructions import Routine

Natives = Mapping[str, NativeFunction | NativeBlock]


@dataclass(slots=True)
class Lowered:
    routines: dict[str, Routine] = field(default_factory=dict)
    files: dict[str, str] = field(default_factory=dict)
    """The source file of each routine."""
    titles: dict[str, str] = field(default_factory=dict)
    """The name of the POU of each routine, as declared."""
    forms: list[Type] = field(default_factory=list)
    constants: list[list[Value]] = field(default_factory=list)
    natives: list[str] = field(default_factory=list)
    """The native POUs that are called, by number."""
    keeps_stack_addresses: bool = False
    """True if a pointer or a VAR_IN_OUT may outlive the call whose variable it refers to."""
    marked: Marked = field(default_factory=Marked)
    """The marks in the code; empty without any."""
    code_size: int = 0
    deep: list[Pou] = field(default_factory=list)
    """Programs that need more than the stack even without recursion."""
    callees_first: list[Pou] = field(default_factory=list)
    """All POUs and actions, each behind those that it calls, apart from recursions."""


def lower(
    program: Program,
    natives: Natives,
    costs: Costs,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    is_covered: Callable[[Pou], bool] = lambda pou: False,
) -> Lowered:
    """Lower all POUs, with marks in those that are covered.  Their offsets must have been set by `layout.place`."""
    context, lowered = Context(costs, is_covered), Lowered()
    bodies = [body for pou in program.pous.values() for body in (pou, *pou.actions.values())]
    parts: dict[str, tuple[Body, Pou]] = {}
    for number, pou in enumerate(bodies):
        name = context.routine(pou)
        parts[name] = (_native(pou, natives, context, lowered) if pou.is_native else _routine(pou, context)), pou
        lowered.files[name], lowered.titles[name] = pou.file, pou.name
        on_progress(number + 1, len(bodies))
    needs = _stack_needs(parts)
    lowered.callees_first = [parts[name][1] for name in needs]
    is_deep = False
    for name, (_, pou) in parts.items():
        if pou.kind is PouKind.PROGRAM and needs[name] > STACK_SIZE:
            is_deep = True
    for name, (part, _) in parts.items():
        assembler, registers = part.assembler, frozenset(part.places.registers)
        made = assembler.finished(is_deep=is_deep)
        lowered.routines[name] = Routine(made, part.frame_size, registers, assembler.guards())
        lowered.marked.places += part.marks.places
        lowered.keeps_stack_addresses |= part.places.keeps_stack_addresses
        lowered.code_size += CODE_PER_ROUTINE + round(assembler.cost * CODE_PER_NS)
    lowered.forms, lowered.constants = context.forms, context.constants
    lowered.marked.hits.extend(bytes(context.marks))
    return lowered


def _routine(pou: Pou, context: Context) -> Body:
    part = _attempt(pou, context, 0)
    return part if part.used == 0 else _attempt(pou, context, part.used)


def _attempt(pou: Pou, context: Context, intermediate: int) -> Body:
    """Lower a body with this number of bytes for intermediate results in its frame."""
    part = Body(context, pou, intermediate)
    part.begin(pou.body[0].line if pou.body else 0)
    statements = Statements(part)
    statements.prologue()
    statements.add(pou.body)
    part.assembler.end()
    return part


def _native(pou: Pou, natives: Natives, context: Context, lowered: Lowered) -> Body:
    part = Body(context, pou, 0)
    number = len(lowered.natives)
    lowered.natives.append(pou.name.lower())
    known = natives.get(pou.name.lower())
    Statements(part).native(
        (NATIVE if known is None or not known.is_slow else BEGIN).format(number),
        is_block=pou.kind is not PouKind.FUNCTION,
        is_slow=known is not None and known.is_slow,
        cost_ns=known.cost_ns if known is not None else 0,
    )
    return part


def _stack_needs(parts: Mapping[str, tuple[Body, Pou]]) -> dict[str, float]:
    """Return the bytes that each routine needs with all that it calls, callees first; infinite for a recursion.

    It is no recursive function, because programs may have longer rows of calls than Python has room for.
    """
    needs: dict[str, float] = {}
    for root in parts:
        path = [(root, list(parts[root][0].assembler.calls))] if root not in needs else []
        busy = {root}
        while path:
            name, rest = path[-1]
            if rest:
                called = rest.pop()
                if called in busy:
                    needs[called] = float("inf")
                elif called not in needs:
                    busy.add(called)
                    path.append((called, list(parts[called][0].assembler.calls)))
                continue
            part = parts[name][0]
            deepest = max((needs[called] for called in part.assembler.calls), default=0.0)
            needs[name] = max(part.frame_size + deepest, needs.get(name, 0.0))
            busy.discard(name)
            path.pop()
    return needs
