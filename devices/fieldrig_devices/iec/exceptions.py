"""The numbers that __CATCH gives for faults of a program, and the faults that these numbers stand for.

The numbers are those of RTSEXCPT_... in the enumeration ExceptionCode (`library/twincat.st`).  A fault of the tool,
such as an assertion of a test that has failed, has no number, and passes every __CATCH.
"""

from typing import Final, NoReturn

from fieldrig_devices.languages.faults import RunError

ACCESS_VIOLATION: Final = 0x51
ARRAY_BOUNDS: Final = 0x101
DIVIDE_BY_ZERO: Final = 0x102
NON_CONTINUABLE: Final = 0x104
FPU_OVERFLOW: Final = 0x155
FPU_INVALID_OPERATION: Final = 0x154


class RaisedError(RunError):
    """The fault that a program raises with F_RaiseException."""

    def __init__(self, number: int) -> None:
        super().__init__("exception", f"the program has raised the exception 16#{number:X}")
        self.number = number


_OF_ERRORS: Final = {
    "pointer": ACCESS_VIOLATION,
    "array bounds": ARRAY_BOUNDS,
    "division": DIVIDE_BY_ZERO,
    "subrange": NON_CONTINUABLE,
    "native": NON_CONTINUABLE,
    "arithmetic": FPU_INVALID_OPERATION,
}
_OF_TYPES: Final[tuple[tuple[type[BaseException], int], ...]] = (
    (ZeroDivisionError, DIVIDE_BY_ZERO),
    (IndexError, ACCESS_VIOLATION),
    (TypeError, ACCESS_VIOLATION),
    (AttributeError, ACCESS_VIOLATION),
    (OverflowError, FPU_OVERFLOW),
    (ValueError, FPU_INVALID_OPERATION),
)
_OF_FLOATS: Final = frozenset({FPU_OVERFLOW, FPU_INVALID_OPERATION})
_AGAIN: Final = {
    ACCESS_VIOLATION: ("pointer", "a pointer to no variable"),
    ARRAY_BOUNDS: ("array bounds", "an index outside its array"),
    DIVIDE_BY_ZERO: ("division", "a division by zero"),
    NON_CONTINUABLE: ("subrange", "a value outside its range"),
}


def number_of(fault: BaseException) -> int | None:
    """Return the number of a fault; None for one that no program can catch."""
    if isinstance(fault, RaisedError):
        return fault.number
    if isinstance(fault, RunError):
        return _OF_ERRORS.get(fault.code)
    return next((number for kind, number in _OF_TYPES if isinstance(fault, kind)), None)


def thrown(number: int) -> NoReturn:
    """Raise the fault with this number again, behind a __FINALLY that it has passed."""
    if number not in _AGAIN and number not in _OF_FLOATS:
        raise RaisedError(number)
    raise RunError(*_AGAIN.get(number, ("arithmetic", "a result outside the range of numbers")))
