"""Check an application: every mistake at once, with what was expected and a hint."""

from collections.abc import Iterable, Iterator

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.check.addresses import check_addresses
from fieldrig_devices.pam.language.check.declarations import check_application, check_declaration, check_parameters
from fieldrig_devices.pam.language.check.expressions import need
from fieldrig_devices.pam.language.check.pipes import check_sharing
from fieldrig_devices.pam.language.check.ports import check_port, check_ports
from fieldrig_devices.pam.language.check.statements import check_sequence, check_statements
from fieldrig_devices.pam.language.check.symbols import (
    Context,
    Names,
    Symbol,
    is_multiple,
    is_port_output,
    with_article,
)
from fieldrig_devices.pam.language.items import (
    Actions,
    Application,
    BooleanEquation,
    Declaration,
    Item,
    Program,
    Routines,
    Sequence,
    Task,
)
from fieldrig_devices.pam.language.objects import PORTS, SPECS
from fieldrig_devices.pam.language.tree import ExceptionEntry, If, Loop, Place, Statement

MOST_FORMALS = 4
"""Formal parameters of a routine (PAML-270)."""
_LINKABLE = ("BINARY_OUTPUT", "LED_OUTPUT")


def check(program: Program, file: str) -> list[Mistake]:
    """Return the mistakes and notes of an application, in the order of its text."""
    names = names_of(program, file)
    return sorted(names.mistakes, key=lambda wrong: (wrong.file, wrong.line, wrong.column))


def names_of(program: Program, file: str = "") -> Names:
    """Return the names of an application, and all messages about it; `file` is for one that is empty."""
    names = Names(defined=program.defined)
    for item in program.items:
        if isinstance(item, Task):
            names.tasks.setdefault(item.name, item)
    if not isinstance(program.items[0] if program.items else None, Application):
        place = program.items[0].place if program.items else Place(file, 1, 1)
        names.wrong(place, "the program does not begin with APPLICATION", "APPLICATION with NAME and BASIC_PAM_CYCLE")
    for item in program.items[1:]:
        if isinstance(item, Application):
            names.wrong(item.place, "there is a second APPLICATION", "one, at the beginning")
    for item in program.items:
        _check_item(item, names)
    check_addresses(program, names)
    check_sharing(program, names)
    check_ports(program, names)
    return names


def _check_item(item: Item, names: Names) -> None:
    match item:
        case Application():
            check_application(item, names)
        case Declaration(kind=kind) if kind in PORTS:
            check_port(item, names)
        case Declaration():
            check_declaration(item, names)
        case BooleanEquation():
            _check_equation(item, names)
        case Actions():
            _check_actions(item, names)
        case Routines():
            _check_routines(item, names)
        case Task():
            _check_task(item, names)


def _check_equation(equation: BooleanEquation, names: Names) -> None:
    need(equation.equation, "flag", names, Context(equation.is_multiple, where="an equation"))
    linked = equation.linked_output
    symbol = names.object(linked) if linked is not None else None
    if linked is not None and symbol is not None and not _is_linkable(symbol):
        what = f"{linked.name} is {with_article(symbol.kind)}"
        names.wrong(linked.place, what, "a BINARY_OUTPUT, an LED_OUTPUT or an output flag of a port")
    names.declare(Symbol(equation.name, "BOOLEAN", equation.place, equation.is_multiple))


def _is_linkable(symbol: Symbol) -> bool:
    return symbol.kind in _LINKABLE or (symbol.kind == "FLAG_VAR" and is_port_output(symbol))


def _check_actions(actions: Actions, names: Names) -> None:
    check_parameters("ACTIONS", SPECS["ACTIONS"], actions.specs, actions.place, names)
    has_items = any(parameter.name in ("NUMBER", "NODES_GROUP") for parameter in actions.specs)
    context = Context(has_items, where="an action", allows_service=False)
    names.declare(Symbol(actions.name, "ACTIONS", actions.place, has_items))
    for reaction in actions.reactions:
        need(reaction.condition, "flag", names, context)
        check_statements(reaction.body, names, context)
    check_statements(actions.power_on or (), names, context)


def _check_routines(routines: Routines, names: Names) -> None:
    names.declare(Symbol(routines.name, "ROUTINES", routines.place))
    for routine in routines.routines:
        if len(routine.formals) > MOST_FORMALS or len(set(routine.formals)) < len(routine.formals):
            names.wrong(routine.place, f"{routine.name} has wrong parameters", f"at most {MOST_FORMALS}, each once")
        formals = frozenset(routine.formals)
        context = Context(where="a routine", allows_service=False, formals=formals, routine=routine.name)
        check_statements(routine.body, names, context)
        names.declare(Symbol(routine.name, "ROUTINE", routine.place, routine=routine))
    check_statements(routines.power_on or (), names, Context(where="a routine", allows_service=False))


def _check_task(task: Task, names: Names) -> None:
    check_parameters("TASK", SPECS["TASK"], task.specs, task.place, names)
    names.declare(Symbol(task.name, "TASK", task.place))
    context = Context(is_multiple(task), task=task)
    seen: set[str] = set()
    for sequence in task.sequences:
        if sequence.name in seen:
            names.wrong(sequence.place, f"{task.name} has the sequence {sequence.name} already", "another name")
        seen.add(sequence.name)
        if sequence.is_multiple != context.is_multiple:
            expected = "[i] behind the name of all sequences of the task, or of none"
            names.wrong(sequence.place, f"the index of {sequence.name} does not fit its task", expected)
        _check_sequence(sequence, task, names)
    for event in task.events:
        need(event.condition, "flag", names, context)
        check_sequence(event.sequence, names, context)
    check_statements(task.power_on or (), names, context)


def _check_sequence(sequence: Sequence, task: Task, names: Names) -> None:
    check_parameters("SEQUENCE", SPECS["SEQUENCE"], sequence.specs, sequence.place, names)
    entries = list(_entries(sequence.body))
    for position, entry in enumerate(entries):
        if any(entry.label == earlier.label for earlier in entries[:position]):
            names.wrong(entry.place, f"the entry {entry.label} appears twice", "another label")
    labels = frozenset(entry.label for entry in entries)
    check_statements(sequence.body, names, Context(is_multiple(task), task=task, labels=labels))


def _entries(statements: Iterable[Statement]) -> Iterator[ExceptionEntry]:
    for statement in statements:
        match statement:
            case ExceptionEntry():
                yield statement
            case If(then=then, otherwise=otherwise):
                yield from _entries((*then, *otherwise))
            case Loop(body=body):
                yield from _entries(body)
