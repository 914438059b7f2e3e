"""The builds of a program for breakpoints and single steps, made beside the device.

It takes three times as long as the rest of the compilation, so it is made when a debugger first sets a breakpoint or
pauses the program, and only for the routines that have been called.  Others are made when they are first called.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig.loop.background import Bulk, Report
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.lower.names import names_of, rules_of
from fieldrig_devices.languages.instructions import Routine
from fieldrig_devices.languages.resumable import Code, Texts

SMALL: Final = 200
"""Instructions that the device prepares by itself, as that takes less time than a process for them."""


@dataclass(frozen=True, slots=True)
class Order:
    routines: Mapping[str, Routine]
    wanted: tuple[int, ...]
    """The numbers of the routines that are made."""
    constants: int
    natives: int

    @classmethod
    def of(cls, compiled: Compiled, code: Code) -> "Order":
        """Return the order for the routines that have been called, or have a breakpoint."""
        stopping = {number for number, stops in enumerate(code.stops) if any(stops)}
        lowered = compiled.code
        wanted = tuple(sorted(code.called | stopping))
        return cls(lowered.routines, wanted, len(lowered.constants), len(lowered.natives))

    @property
    def is_small(self) -> bool:
        routines = list(self.routines.values())
        return sum(len(routines[number].lines) for number in self.wanted) < SMALL


def make(order: Order, report: Report) -> Sequence[tuple[int, Bulk]]:
    """Return what the routines need, with their numbers."""
    names, rules = names_of(order.constants, order.natives), rules_of(order.constants)
    numbers = {name: number for number, name in enumerate(order.routines)}
    texts, builds = Texts(list(order.routines.values()), numbers, names, rules), list[tuple[int, Bulk]]()
    for done, number in enumerate(order.wanted):
        report("breakpoints", done, len(order.wanted))
        builds.append((number, Bulk(texts.for_debugging(number))))
    return builds
