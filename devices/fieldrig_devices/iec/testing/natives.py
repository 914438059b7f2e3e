"""The native functions behind the statements of tests, as the compiled program knows them."""

from typing import Final

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    AddressOf,
    CallFunction,
    Cell,
    Constant,
    Expression,
    Place,
    Pou,
    Space,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section

JUDGE: Final = "fieldrig_judge"
"""An assertion, with the addresses of what it compares."""
NOTE: Final = "fieldrig_note"
"""Operands of the condition that is judged next, with their addresses."""
ACT: Final = "fieldrig_act"
"""A statement that does something at once."""
BEGIN: Final = "fieldrig_begin"
"""The begin of an expectation over time, with the address of its duration."""
AGAIN: Final = "fieldrig_again"
"""A look at an expectation over time; it waits for the next instant, and is TRUE until the expectation is judged."""
WAIT: Final = "fieldrig_wait"
"""A duration that passes."""
MOCKED: Final = "fieldrig_mocked"
"""A call of what Python takes the place of, with the address of its variables."""
NAMES: Final = (JUDGE, NOTE, ACT, BEGIN, AGAIN, WAIT, MOCKED)
SLOW: Final = (AGAIN, WAIT)
MOST_ADDRESSES: Final = 4


def native_pou(name: str) -> Pou:
    """Return a native function with a number and addresses, whose result is a BOOL."""
    pou = Pou(PouKind.FUNCTION, name, "tests of fieldrig", is_native=True)
    pou.result = Variable(name, Elementary.BOOL, Space.FRAME, Section.OUTPUT)
    kinds = {"number": Elementary.DINT} | {f"address{place}": Elementary.DWORD for place in range(MOST_ADDRESSES)}
    pou.variables = {key: Variable(key, kind, Space.FRAME, Section.INPUT) for key, kind in kinds.items()}
    return pou


def call_of(pou: Pou, number: int, *places: Place | None) -> CallFunction:
    """Return a call with the addresses of places; None is the address 0."""
    addresses: list[Expression] = [
        Constant(0, Elementary.DWORD) if place is None else AddressOf(place, Elementary.DWORD) for place in places
    ]
    addresses += [Constant(0, Elementary.DWORD)] * (MOST_ADDRESSES - len(addresses))
    first, *others = pou.variables.values()
    number_given: Expression = Constant(number, Elementary.DINT)
    return CallFunction(pou, ((first, number_given), *zip(others, addresses, strict=True)), Elementary.BOOL)


def cell(variable: Variable) -> Cell:
    return Cell(variable, variable.type)
