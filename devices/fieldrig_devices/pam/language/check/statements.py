"""Statements: what they may do to an object, and where they may be (sections 1.4 and 2.13 to 2.17 of the digest)."""

from collections.abc import Iterable

from fieldrig.points.values import counted
from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.check.constants import check_constants, constant
from fieldrig_devices.pam.language.check.expressions import check_argument, fitting, indexed, need, rule_of, type_of
from fieldrig_devices.pam.language.check.pipes import check_pipe
from fieldrig_devices.pam.language.check.symbols import (
    Context,
    Names,
    Symbol,
    is_multiple,
    is_port_input,
    listed,
    sequence_of,
    with_article,
)
from fieldrig_devices.pam.language.functions import EXECUTIVE, REPLACED, VALUES, WRITABLE

SERVICE = (
    tree.Condition,
    tree.DuplicateStart,
    tree.Wait,
    tree.Case,
    tree.ArmException,
    tree.ExceptionEntry,
    tree.RemoveException,
)


def check_statements(statements: Iterable[tree.Statement], names: Names, context: Context) -> None:
    for statement in statements:
        if isinstance(statement, SERVICE) and not context.allows_service:
            names.wrong(statement.place, f"{context.where} must not wait", "a statement that takes no time")
        elif isinstance(statement, tree.StartTask) and not context.allows_service:
            names.wrong(statement.place, f"{context.where} starts no task", "an assignment, a function, CALL or IF")
            continue
        _check(statement, names, context)


def _check(statement: tree.Statement, names: Names, context: Context) -> None:
    match statement:
        case tree.Assign():
            _assign(statement, names, context)
        case tree.Execute():
            _execute(statement, names, context)
        case tree.Modify():
            _modify(statement, names, context)
        case tree.Ask(inquiry=inquiry):
            type_of(inquiry, names, context)
        case tree.Connect():
            check_pipe(statement, names)
        case tree.Call(call=call):
            check_routine_call(call, names, context)
        case tree.If(condition=condition, then=then, otherwise=otherwise):
            need(condition, "flag", names, context)
            check_statements(then, names, context)
            check_statements(otherwise, names, context)
        case tree.Loop(body=body, until=until):
            check_statements(body, names, context)
            need(until, "flag", names, context)
        case tree.StartSequence() | tree.StartTask():
            _check_action(statement, names, context)
        case tree.Condition(condition=condition, timeout=timeout):
            need(condition, "flag", names, context)
            check_timeout(timeout, names, context)
        case tree.Wait(duration=duration):
            _check_wait(duration, names, context)
        case tree.Case(branches=branches, timeout=timeout):
            _case(branches, timeout, names, context)
        case tree.ArmException(condition=condition, timeout=timeout, action=action):
            need(condition, "flag", names, context)
            check_timeout(timeout, names, context)
            _check_action(action, names, context)
        case tree.DuplicateStart() | tree.ExceptionEntry() | tree.RemoveException():
            pass


def check_timeout(timeout: tree.Expression | None, names: Names, context: Context) -> None:
    """Report a time in milliseconds that is no number.  A constant below 0 is worth a note."""
    if timeout is None:
        return
    need(timeout, "real", names, context)
    value = constant(timeout)
    if value is not None and value < 0:
        hint = "The sequence ends here, with 03..E031 or 03..E032."
        names.note(timeout.place, f"the time-out is {value:g} ms", hint)


def _check_wait(duration: tree.Expression, names: Names, context: Context) -> None:
    need(duration, "real", names, context)
    value = constant(duration)
    if value is not None and value < 0:
        names.wrong(duration.place, f"the time is {value:g} ms", "a time that is not negative")


def _target(reference: tree.Reference, names: Names, context: Context) -> Symbol | None:
    if reference.name in context.formals:
        names.wrong(reference.place, f"{reference.name} is a parameter of the routine", "an object")
        return None
    symbol = names.object(reference)
    if symbol is not None:
        indexed(reference, symbol, names, context, is_target=True)
        if is_port_input(symbol):
            hint = "Only the master of the port changes its inputs."
            names.wrong(reference.place, f"{symbol.name} is an input of a port", "an output or another variable", hint)
    return symbol


def _assign(statement: tree.Assign, names: Names, context: Context) -> None:
    symbol = _target(statement.target, names, context)
    value = statement.value
    if symbol is None:
        type_of(value, names, context)
    elif symbol.kind not in WRITABLE:
        known = sorted(EXECUTIVE.get(symbol.kind, {}))
        expected = listed(known) if known else "an object that can be changed"
        names.wrong(statement.place, f"{with_article(symbol.kind)} takes no value", expected)
    elif (
        isinstance(value, tree.Reference)
        and value.name.islower()
        and value.name not in names.symbols | dict.fromkeys(context.formals)
    ):
        known = sorted(EXECUTIVE.get(symbol.kind, {}))
        names.wrong(value.place, f"{with_article(symbol.kind)} has no function {value.name}", listed(known))
    elif symbol.kind == "PAMDISPLAY" and (axis := _axis(value, names, context)) is not None:
        indexed(axis[0], axis[1], names, context)  # manual line 8766: the display shows its position
    else:
        need(value, VALUES[symbol.kind], names, context)


def _axis(value: tree.Expression, names: Names, context: Context) -> tuple[tree.Reference, Symbol] | None:
    """Return an expression that is nothing but an axis."""
    if not isinstance(value, tree.Reference) or value.name in context.formals:
        return None
    symbol = names.symbols.get(value.name)
    return (value, symbol) if symbol is not None and symbol.kind == "AXIS" else None


def _execute(statement: tree.Execute, names: Names, context: Context) -> None:
    symbol = _target(statement.target, names, context)
    if symbol is None:
        return
    forms = EXECUTIVE.get(symbol.kind, {}).get(statement.function)
    if forms is not None:
        fitting(statement.function, forms, statement.arguments, statement.target, names, context)
        check_constants(symbol.kind, statement, names)
    elif statement.function in REPLACED and len(statement.arguments) == 1:
        parameter = REPLACED[statement.function]
        hint = f"Release 2.5 writes {symbol.name}:{parameter} <- value."
        names.note(statement.place, f"{statement.function} is a function of an earlier release", hint)
        check_argument(statement.arguments[0], "number", names, context)
    else:
        known = sorted(EXECUTIVE.get(symbol.kind, {}))
        what = f"{with_article(symbol.kind)} has no function {statement.function}"
        others = sorted(kind for kind, forms in EXECUTIVE.items() if statement.function in forms)
        of_others = (
            f"an object of the kind {listed(others)}" if others else f"no call, as no object has {statement.function}"
        )
        names.wrong(statement.place, what, listed(known) if known else of_others)


def _modify(statement: tree.Modify, names: Names, context: Context) -> None:
    symbol = _target(statement.target.subject, names, context)
    rule = rule_of(statement.target, symbol, names) if symbol is not None else None
    if symbol is None or rule is None:
        return
    if rule.access not in ("WO", "RW"):
        expected = "a parameter with WO or RW"
        names.wrong(statement.place, f"{rule.name} of {symbol.kind} cannot be changed by a program", expected)
        return
    value = statement.value
    if isinstance(value, tree.RoutineCall):
        check_routine_call(value, names, context)
    elif rule.holds[0][0] == "<":
        check_argument(value, rule.holds[0], names, context)
    elif isinstance(value, tree.Word) and value.name in "|".join(rule.holds):
        pass
    elif rule.holds[0][0] == "(":
        names.wrong(value.place, f"{rule.name} is wrong", listed(list(rule.words)))
    elif len(rule.holds) > 1:
        names.wrong(statement.place, f"{rule.name} has two values", "a parameter with a single value")
    else:
        need(value, "real", names, context)


def check_routine_call(call: tree.RoutineCall, names: Names, context: Context, *, is_constant: bool = False) -> None:
    """Report a routine that does not exist, calls itself, or gets the wrong arguments (PAML-271, PAML-276)."""
    for argument in call.arguments:
        number = argument.operand if isinstance(argument, tree.Unary) and argument.operator != "!" else argument
        if is_constant and not isinstance(number, tree.Number):
            names.wrong(argument.place, "the argument of a routine is not a constant here", "a number")
        elif not is_constant:
            type_of(argument, names, context)
    if not call.routine:
        return
    if call.routine == context.routine:
        names.wrong(call.place, f"{call.routine} calls itself", "another routine")
        return
    symbol = names.object(tree.Reference(call.place, call.routine))
    if symbol is None:
        return
    if symbol.routine is None:
        names.wrong(call.place, f"{call.routine} is {with_article(symbol.kind)}", "a routine")
    elif len(symbol.routine.formals) != len(call.arguments):
        what = f"{call.routine} is called with {counted(len(call.arguments), 'argument')}"
        names.wrong(call.place, what, f"{len(symbol.routine.formals)} of them")


def _case(branches: Iterable[tree.Branch], timeout: tree.Branch | None, names: Names, context: Context) -> None:
    for branch in branches:
        need(branch.condition, "flag", names, context)
        check_sequence(branch.sequence, names, context)
    if timeout is not None:
        check_timeout(timeout.condition, names, context)
        check_sequence(timeout.sequence, names, context)


def check_sequence(reference: tree.SequenceRef, names: Names, context: Context) -> None:
    """Report a sequence that the task does not have, or with a wrong index."""
    task = context.task
    if task is None:
        names.wrong(reference.place, f"{context.where} has no sequences", "a statement without a sequence")
        return
    started = sequence_of(task, reference.name)
    if started is None:
        expected = listed([sequence.name for sequence in task.sequences])
        names.wrong(reference.place, f"{task.name} has no sequence {reference.name}", expected)
    elif reference.is_indexed != is_multiple(task):
        expected = reference.name + ("" if reference.is_indexed else "[i]")
        names.wrong(reference.place, f"the index of {reference.name} does not fit its task", expected)


def _check_action(action: tree.ExceptionAction, names: Names, context: Context) -> None:
    if isinstance(action, tree.StartSequence):
        check_sequence(action.sequence, names, context)
    elif isinstance(action, tree.EntryAction):
        if action.label not in context.labels:
            expected = f"EXCEPTION_ENTRY {action.label} in the same sequence"
            names.wrong(action.place, f"there is no entry {action.label}", expected)
    elif isinstance(action, tree.StartTask):
        task = names.tasks.get(action.task)
        if task is None:
            names.wrong(action.place, f"there is no task {action.task}", listed(sorted(names.tasks)))
        else:
            check_sequence(action.sequence, names, Context(task=task))
