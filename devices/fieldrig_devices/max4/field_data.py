"""Data of field bus modules in the object tree, and the IO map update that exchanges them.

Source: PacDrive manual 3223 (digest PD-067, PD-307): the system updates the IO map cyclically, at the priority of IEC
task 4.  Between two updates, received data are not visible and written data are not sent; the values of one message
change together.  The period and the names of the data are our choice.
"""

import logging
from collections.abc import Sequence
from typing import Final, Protocol

from fieldrig.clock import MS
from fieldrig_devices.iec.tasks.system_work import IO_MAP_PRIORITY
from fieldrig_devices.max4.configuration.tree import Access, Group, Object, Parameter, Type
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.registers.packed import Element, Packed

log = logging.getLogger(__name__)


_TYPES: Final = {
    "bool": Type.BOOL,
    "u8": Type.UINT,
    "s8": Type.INT,
    "u16": Type.UINT,
    "s16": Type.INT,
    "u32": Type.UDINT,
    "s32": Type.DINT,
    "f32": Type.LREAL,
}
"""Types of parameters by the type in the message."""
_NARROW: Final = frozenset({"u8", "s8"})
"""Types whose parameters have a wider range."""


class Data(Packed):
    """The values of one message, as parameters of a group."""

    def __init__(self, group: Group, elements: Sequence[Element], *, is_output: bool) -> None:
        access = Access.INPUT if is_output else Access.OUTPUT
        super().__init__(elements, [group.add(_parameter(element, access)) for element in elements])


def _parameter(element: Element, access: Access) -> Parameter:
    form, type = element.form, _TYPES[element.type]
    if element.type in _NARROW:
        return Parameter(element.name, type, access, low=form.low or None, high=form.high)
    return Parameter(element.name, type, access)


class Part(Protocol):
    """The part of the IO map that belongs to one module."""

    def take(self) -> None:
        """Put received data into the tree."""

    def give(self) -> None:
        """Send data that have changed in the tree."""


class IoMap:
    """The cyclic update; the faces add their modules to `parts` at each boot."""

    def __init__(self, controller: Controller, every_ms: int, duration_us: int) -> None:
        """An update takes `duration_us` of processor time from a program."""
        self._controller, self._every_ns, self._duration_us = controller, every_ms * MS, duration_us
        self._passed_ns = 0
        self._is_due = False
        self.parts: list[Part] = []
        controller.on_boot(self._begin)
        controller.each_cycle(self._on_cycle)

    def _on_cycle(self) -> None:
        self._passed_ns += self._controller.cycle_ns
        if self._passed_ns < self._every_ns:
            return
        self._passed_ns = 0
        if self.parts and not self._is_due:
            self._is_due = True
            self._controller.at_priority(IO_MAP_PRIORITY, self._duration_us, self._update)

    def _begin(self) -> None:
        self.parts.clear()
        self._is_due = False

    def _update(self) -> None:
        self._is_due = False
        for part in self.parts:
            part.take()
        for part in self.parts:
            part.give()


def add_object(parent: Object, name: str, type_name: str, symbol: str) -> Object:
    """Add an object, without its symbolic name if an object of the configuration has taken that name."""
    try:
        return parent.add(name, type_name, symbol)
    except ValueError as taken:
        log.warning("%s", taken)
        return parent.add(name, type_name, "")
