"""Loops that never end, as far as constants and the statements in them show it."""

from collections.abc import Sequence
from math import gcd

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Constant, Expression


def never_ends(last: Expression | None, step: Expression | None, kind: Elementary) -> bool:
    """True if a counter is never behind its end, because no value of its type is."""
    if not isinstance(last, Constant) or not isinstance(step, Constant):
        return False
    return last.value == (kind.high if int(step.value) > 0 else kind.low)


def steps_over_its_end(values: Sequence[Expression | None], step: Expression | None, kind: Elementary) -> bool:
    """True if a counter comes to no value behind its end by steps alone: FOR x := 0 TO 254 BY 2 with a BYTE.

    By wrapping around, it comes to all values that differ from the first one by a multiple of `apart`.
    """
    first, last = values
    if not isinstance(first, Constant) or not isinstance(last, Constant) or not isinstance(step, Constant):
        return False
    start, end, apart = int(first.value), int(last.value), gcd(int(step.value), 2 ** (8 * kind.size))
    if int(step.value) > 0:
        return start <= end and kind.high - (kind.high - start) % apart <= end
    return start >= end and kind.low + (start - kind.low) % apart >= end


def has_way_out(nodes: Sequence[tree.AnyStatement], *, is_inner: bool = False) -> bool:
    """True if statements have a RETURN or a jump, or an EXIT out of the loop that they are in."""
    return any(_leaves(node, is_inner) for node in nodes)


def _leaves(node: tree.AnyStatement, is_inner: bool) -> bool:
    match node:
        case tree.Return() | tree.Jump():
            return True
        case tree.Exit():
            return not is_inner
        case tree.If(branches, otherwise) | tree.Case(_, branches, otherwise):
            bodies = [*(branch.body for branch in branches), otherwise or ()]
            return any(has_way_out(body, is_inner=is_inner) for body in bodies)
        case tree.For(body=body) | tree.While(body=body) | tree.Repeat(body=body):
            return has_way_out(body, is_inner=True)
        case tree.Try(body, _, caught, final):
            return any(has_way_out(part or (), is_inner=is_inner) for part in (body, caught, final))
    return False
