"""The variables on which a condition depends: while none of them changes, it need not be computed again."""

from fieldrig_devices.iec.program import Binary, Bit, Cell, Constant, Convert, Expression, Intrinsic, Load, Unary


def variables_of(condition: Expression) -> frozenset[str] | None:
    """Return the names, in small letters, of the variables that a condition reads.

    None if it may depend on more: on what a function or an accessor does, or on the target of a pointer or a reference.
    No recursion: conditions may be long.
    """
    waiting, found = [condition], set[str]()
    while waiting:
        match waiting.pop():
            case Constant():
                pass
            case Load(Cell(variable) | Bit(Cell(variable))) if not variable.is_reference and variable.location is None:
                found.add(variable.name.casefold())
            case Unary(_, operand) | Convert(operand):
                waiting.append(operand)
            case Binary(_, left, right):
                waiting += (left, right)
            case Intrinsic(_, arguments):
                waiting += arguments
            case _:
                return None
    return frozenset(found)
