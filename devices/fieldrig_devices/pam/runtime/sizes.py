"""The sizes of an application and of the workspaces of its sequences, by a stated model.

The manual gives the limits only: 262,144 bytes for an application (PAML-013), and a workspace for each sequence that
runs (PAML-300).  The model counts what a compiler of 1995 for a processor with registers of 32 bits makes: some bytes
for each parameter, statement and operand of the application; and in a workspace the frame of the sequence, one for each
statement that encloses others, one for each level of an expression, and one for each routine that it calls.
"""

from collections.abc import Iterable, Mapping
from typing import Final

from fieldrig_devices.pam.language import items, tree
from fieldrig_devices.pam.language.tree import Node, Statement
from fieldrig_devices.pam.runtime.walk import nodes

MOST_BYTES: Final = 262_144
"""Bytes of an application that is not compressed (PAML-013)."""

_OBJECT: Final = 64
"""Bytes of a declaration."""
_PARAMETER: Final = 16
_STATEMENT: Final = 24
_OPERAND: Final = 8
_SEQUENCE: Final = 160
"""Bytes of the frame of a sequence."""
_NESTED: Final = 48
"""Bytes of a LOOP or IF around statements."""
_TEMPORARY: Final = 16
_CALL: Final = 96


def application(program: items.Program) -> int:
    """Return the bytes of an application."""
    return sum(map(_bytes, nodes(*program.items)))


def _bytes(node: Node) -> int:
    if isinstance(node, items.Item):
        return _OBJECT
    if isinstance(node, items.Parameter):
        return _PARAMETER
    return _STATEMENT if isinstance(node, Statement) else _OPERAND


def workspace(body: Iterable[Statement], routines: Mapping[str, items.Routine]) -> int:
    """Return the bytes that a sequence needs while it runs."""
    return _SEQUENCE + max((_statement(statement, routines) for statement in body), default=0)


def _statement(statement: Statement, routines: Mapping[str, items.Routine]) -> int:
    match statement:
        case tree.If(condition=condition, then=then, otherwise=otherwise):
            inner = [_statement(one, routines) for one in (*then, *otherwise)]
            return _NESTED + max([_expression(condition), *inner])
        case tree.Loop(body=body, until=until):
            return _NESTED + max([_expression(until), *(_statement(one, routines) for one in body)])
        case tree.Call(call=call):
            called = routines.get(call.routine)
            own = [_statement(one, routines) for one in called.body] if called is not None else []
            return _CALL + _TEMPORARY * len(call.arguments) + max(own, default=0)
    return max((_expression(part) for part in nodes(statement) if isinstance(part, tree.Expression)), default=0)


def _expression(expression: Node) -> int:
    """Return the bytes of the temporaries of an expression: one for each of its levels."""
    deepest, waiting = 0, [(expression, 1)]
    while waiting:
        node, depth = waiting.pop()
        deepest = max(deepest, depth)
        match node:
            case tree.Binary(left=left, right=right):
                waiting += [(left, depth + 1), (right, depth + 1)]
            case tree.Unary(operand=operand) | tree.Reduction(operand=operand):
                waiting.append((operand, depth + 1))
            case tree.Inquiry(subject=subject, arguments=arguments):
                waiting += [(part, depth + 1) for part in (subject, *arguments)]
    return _TEMPORARY * deepest
