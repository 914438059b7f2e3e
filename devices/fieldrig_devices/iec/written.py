"""The outputs and the pins of global instances that a program writes, for a device that protects them from others."""

from collections.abc import Iterator
from dataclasses import fields
from typing import Final, NamedTuple

from fieldrig_devices.iec import program as ir


class Written(NamedTuple):
    """The outputs and pins that the statements of a program write."""

    bits: frozenset[tuple[int, int]]
    """Byte and bit of the area %Q."""
    pins: frozenset[tuple[str, str]]
    """Names of global variables that are instances and of their variables, in small letters."""


NOTHING: Final = Written(frozenset(), frozenset())


def written_by(program: ir.Program) -> Written:
    """Return what a checked program writes.  The bodies of its POUs are still there, as before they are lowered."""
    bits, pins = set[tuple[int, int]](), set[tuple[str, str]]()
    for pou in program.pous.values():
        for place in targets([pou.body, *(action.body for action in pou.actions.values())]):
            if isinstance(place, ir.Located) and place.area == "Q":
                bits |= set(_bits(place))
            elif isinstance(place, ir.Component) and isinstance(place.of, ir.Cell) and place.variable is not None:
                pins.add((place.of.variable.name.casefold(), place.variable.name.casefold()))
    return Written(frozenset(bits), frozenset(pins))


def _bits(place: ir.Located) -> Iterator[tuple[int, int]]:
    if place.bit >= 0:
        yield place.byte, place.bit
        return
    yield from ((place.byte + byte, bit) for byte in range(place.type.size) for bit in range(8))


def targets(node: object) -> Iterator[ir.Place]:
    """Yield the places that statements write."""
    for found in statements(node):
        if isinstance(found, ir.Assign):
            yield found.place
        elif isinstance(found, ir.CallBlock):
            yield from (ir.Component(found.instance, 0, pin.type, pin) for pin, _ in found.inputs)
            yield from (place for place, _ in found.outputs)


def statements(body: object) -> Iterator[ir.Statement]:
    """Yield all statements of a body, with those inside of others, in their order.

    The list of what waits is no recursion, because an IF with a thousand ELSIF is as many statements in each other.
    """
    waiting = [body]
    while waiting:
        node = waiting.pop()
        if isinstance(node, list | tuple):
            waiting.extend(reversed(node))
        elif isinstance(node, ir.Statement):
            yield node
            waiting.extend(getattr(node, field.name) for field in reversed(fields(node)))
