"""Calls as statements: instances of function blocks, programs, actions, and functions for their effects."""

from collections.abc import Callable

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import (
    access,
    calls,
    dispatch,
    enable,
    heap,
    inheritance,
    library_names,
    methods,
    open_arrays,
    references,
    special,
)
from fieldrig_devices.iec.check.arguments import Arguments, match_arguments, reference
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.project import UNKNOWN
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.library import intrinsics
from fieldrig_devices.iec.program import (
    AnyStatement,
    Assign,
    CallAction,
    CallBlock,
    CallFunction,
    Cell,
    Component,
    Evaluate,
    Expression,
    Load,
    Operator,
    Place,
    Pou,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import BlockType

Resolved = tuple[Place | None, Pou]
"""The instance, if it is not the one whose body this is, and what is called."""


def call_statement(checker: Checker, node: tree.Call, line: int) -> list[AnyStatement]:
    """Return the statements of a call: usually one; none after a message."""
    called, context = node.called, checker.context
    if isinstance(called, tree.Name) and called.text.upper() == heap.DELETE and context.project.dialect.has_heap:
        return heap.deleted(checker, node, line, call_statement)
    name = called.text if isinstance(called, tree.Name) else ""
    if name.upper() in references.QUERIES and context.find(name) is None:
        asked = checker.expression(node)
        return [Evaluate(asked, line=line)] if isinstance(asked, CallFunction) else []
    resolved = _resolve(checker, node)
    if resolved is None:
        return []
    instance, pou = resolved
    calls.note_call(checker.context, pou, node)
    if pou.is_method or (pou.kind is PouKind.FUNCTION and pou.owner is None):
        value = calls.call(checker, pou, node, instance)
        return enable.statements(value, lambda _: Evaluate(value, line=line), line) if value is not None else []
    if pou.owner is not None:
        return _action(checker, node, instance, pou, line)
    assert instance is not None
    return call_block(checker, node, instance, pou, line)


def _resolve(checker: Checker, node: tree.Call) -> Resolved | None:
    context = checker.context
    method = methods.find(checker, node.called)
    if method is not None:
        return method
    called = library_names.without_library(context, node.called)
    if methods.is_super(context, called):
        body = inheritance.body_above(context)
        if body is None and not context.project.lacks_base(context.block):
            what = (
                "SUPER() has no function block above" if isinstance(called, tree.Name) else "SUPER^() without EXTENDS"
            )
            context.say(called, what, "a call in a function block that extends another one")
        return None if body is None else (None, body)
    if isinstance(called, tree.Name):
        if context.find(called.text) is None:
            function = calls.called_function(context, called.text)
            action = context.block.actions.get(context.key(called.text)) if context.block is not None else None
            if function is None and action is None:
                _say_unknown(checker, node, called)
                return None
        else:
            function = calls.called_function(context, called.text)
        if function is not None:
            return None, function
        known = context.find(called.text)
        if isinstance(known, Pou) and known.kind is PouKind.FUNCTION:
            return None, known
    if isinstance(called, tree.Member):
        member = _member_action(checker, called)
        if member is not None:
            return member
    meaning = checker.meaning(called)
    if isinstance(meaning, Pou):
        if meaning.kind is PouKind.FUNCTION or meaning.owner is not None:
            return None, meaning
        if meaning.kind is PouKind.PROGRAM and meaning.instance is not None:
            return Cell(meaning.instance, meaning.instance.type), meaning
        hint = f"declare an instance in VAR: fb{meaning.name} : {meaning.name};"
        what = "class" if meaning.kind is PouKind.CLASS else "function block"
        context.say(called, f"{meaning.name} is a {what}, not an instance", "an instance", hint)
        return None
    if isinstance(meaning, Place):
        if isinstance(meaning.type, BlockType) and meaning.type.pou is not None:
            if meaning.type.pou.kind is not PouKind.CLASS:
                return meaning, meaning.type.pou
            _say_class(checker, called, meaning.type.pou)
            return None
        if meaning.type is not UNKNOWN:
            context.say(
                called, f"{text(called)} is {a(meaning.type)} and cannot be called", "an instance, program or function"
            )
    elif meaning is not None:
        context.say(called, f"{text(called)} cannot be called", "an instance, program or function")
    return None


def _say_class(checker: Checker, called: tree.Expression, pou: Pou) -> None:
    """A class has methods instead of a body (IEC 61131-3:2013, 6.6.5.3)."""
    open_methods = (method for method in pou.methods.values() if not method.is_accessor)
    names = [
        method.name.rpartition(".")[2] for method in open_methods if access.is_open(checker.context.project, method)
    ]
    hint = f"write {text(called)}.{names[0]}(...)" if names else f"give {pou.name} a METHOD PUBLIC"
    what = f"{text(called)} is an instance of the class {pou.name} and cannot be called"
    checker.context.say(called, what, "a call of one of its methods", hint)


def _say_unknown(checker: Checker, node: tree.Call, called: tree.Name) -> None:
    context, name = checker.context, called.text
    is_bound = name.upper() in open_arrays.FUNCTIONS and context.project.dialect.has_open_arrays
    if is_bound or intrinsics.is_standard(name) or name.upper() in special.SPECIAL:
        context.say(
            called,
            f"the result of {name.upper()} is not used",
            "a function in an expression",
            f"write x := {name}(...);",
        )
        return
    words = context.extension.words if context.extension is not None else ()
    context.say_unknown(called, name, "an instance, program, action or function", words)


def _member_action(checker: Checker, node: tree.Member) -> Resolved | None:
    """`instance.action`, as a call of the action of that instance; None for anything else."""
    if methods.is_this(checker.context, node.of):
        return None
    if isinstance(node.of, tree.Name) and checker.context.find(node.of.text) is None:
        return None
    owner = checker.meaning(node.of)
    if isinstance(owner, Pou) and owner.instance is not None:
        instance: Place = Cell(owner.instance, owner.instance.type)
        pou: Pou | None = owner
    elif isinstance(owner, Place) and isinstance(owner.type, BlockType):
        instance, pou = owner, owner.type.pou
    else:
        return None
    action = pou.actions.get(checker.context.key(node.name)) if pou is not None else None
    if action is None:
        return None
    return (None if pou is checker.context.block else instance), action


# ---- blocks


def call_block(checker: Checker, node: tree.Call, instance: Place, pou: Pou, line: int) -> list[AnyStatement]:
    parts = enable.split(checker, node, pou)
    source = checker.context.project.sources[pou]
    matched = match_arguments(checker, parts[0], pou, source.inputs, source.outputs) if parts is not None else None
    if matched is None or parts is None:
        return []
    inputs: list[tuple[Variable, Expression]] = []
    references: list[tuple[Variable, Place]] = []
    is_whole = True
    for variable, given in matched.inputs.items():
        if variable.section is Section.IN_OUT:
            place = reference(checker, given, variable)
            is_whole = is_whole and place is not None
            if place is not None:
                references.append((variable, place))
                inputs += open_arrays.limits(variable, place)
        else:
            value = checker.expression_as(given, variable.type)
            is_whole = is_whole and value is not None
            if value is not None:
                inputs.append((variable, value))
    outputs = _outputs(checker, matched, lambda variable: Component(instance, 0, variable.type, variable))
    if not is_whole or outputs is None:
        return []
    instance, pou = dispatch.body(instance, pou)
    return [CallBlock(instance, pou, tuple(inputs), tuple(references), tuple(outputs), parts[1], line=line)]


def _outputs(
    checker: Checker, matched: Arguments, pin: Callable[[Variable], Place]
) -> list[tuple[Place, Expression]] | None:
    """The assignments after the call, `Q => target`; None after a message."""
    made: list[tuple[Place, Expression]] = []
    is_whole = True
    for variable, given, is_negated in matched.outputs:
        target = checker.target(given)
        value: Expression | None = Load(pin(variable))
        if is_negated and value is not None:
            value = checker.negate(Operator.NOT, value, given)
        if target is not None and value is not None:
            value = checker.convert(value, target.type, tree.Name(variable.name, position=given.position))
        if target is None or value is None:
            is_whole = False
        else:
            made.append((target, value))
    return made if is_whole else None


# ---- actions


def _action(checker: Checker, node: tree.Call, instance: Place | None, action: Pou, line: int) -> list[AnyStatement]:
    """An action may be called with inputs, which are assigned before, and outputs, as in CoDeSys V2.3.

    One of another instance may be given its VAR_IN_OUT too; without them, it has those of the last call.
    """
    assert action.owner is not None
    source = checker.context.project.sources[action.owner]
    key = checker.context.key
    named = {key(argument.name) for argument in node.arguments if instance is not None}
    given = [one for one in source.inputs if one.section is not Section.IN_OUT or key(one.name) in named]
    matched = match_arguments(checker, node, action.owner, given, source.outputs)
    if matched is None:
        return []

    def pin(variable: Variable) -> Place:
        return (
            Component(instance, 0, variable.type, variable) if instance is not None else Cell(variable, variable.type)
        )

    before: list[AnyStatement] = []
    references: list[tuple[Variable, Place]] = []
    limits: list[tuple[Variable, Expression]] = []
    for variable, argument in matched.inputs.items():
        if variable.section is Section.IN_OUT:
            place = reference(checker, argument, variable)
            if place is None:
                return []
            references.append((variable, place))
            limits += open_arrays.limits(variable, place)
            continue
        value = checker.expression_as(argument, variable.type)
        if value is None:
            return []
        before.append(Assign(pin(variable), value, line=line))
    outputs = _outputs(checker, matched, pin)
    if outputs is None:
        return []
    after = [Assign(target, value, line=line) for target, value in outputs]
    if references and instance is not None:
        return [*before, CallBlock(instance, action, tuple(limits), tuple(references), line=line), *after]
    return [*before, CallAction(action, instance, line=line), *after]
