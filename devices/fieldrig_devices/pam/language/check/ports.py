"""Ports to a PLC: their variables, and the memory map of a Simatic DualPort (sections 11.8, 12.5 and 13.1)."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from fieldrig_devices.pam.language.check.declarations import check_declaration, check_parameters
from fieldrig_devices.pam.language.check.symbols import Names, listed
from fieldrig_devices.pam.language.items import Declaration, Program
from fieldrig_devices.pam.language.objects import KINDS
from fieldrig_devices.pam.language.ports import PERIODS, PortPlan, PortVariable, numbers_of, ports_of
from fieldrig_devices.pam.language.tree import Place

MEMORY: Final = 4096
"""Bytes of a DualPort."""
PANEL: Final = 14
"""Bytes of the fatal error panel in front of WATCH_DOG (PAMS-057)."""
LARGEST_FIFO: Final = 256
"""Bytes of a FIFO of addresses, without HEAD and TAIL (PAMS-089)."""
_FIFOS: Final = ("FIFO_IN", "FIFO_OUT")
_READY: Final = ("PAM_READY", "DUALPORT_READY", "HOST_READY")


def check_port(port: Declaration, names: Names) -> None:
    """Check a port and declare its variables."""
    check_parameters(port.kind, KINDS[port.kind], port.parameters, port.place, names)
    for name in ("PERIOD", "DEFAULT_PERIOD"):
        for period in numbers_of(port, name):
            if period not in PERIODS:
                expected = f"{listed([str(known) for known in PERIODS])} basic cycles"
                names.wrong(_place(port, name), f"{name} is {period}", expected)
    for variable in port.parts:
        check_declaration(variable, names)


def check_ports(program: Program, names: Names) -> None:
    """Check what the ports of an application and all their variables mean for each other."""
    ports = ports_of(program)
    declared: dict[str, Declaration] = {}
    for port in ports:
        here = port.declaration
        earlier = declared.setdefault(here.name, here)
        if earlier is not here:
            what = f"{here.name} is declared already in line {earlier.place.line}"
            names.wrong(here.place, what, "one DualPort and one RS422 port at most")
    places = {item.name: item.place for item in _declarations(program)}
    for port in ports:
        if port.kind == "DUAL_PORT":
            _Map(port, places, names).check()
        else:
            _check_crcs(port, places, names)
    if not any(port.kind == "DUAL_PORT" for port in ports):
        for item in _declarations(program):
            if item.kind.startswith(("DUALPORT_IN", "DUALPORT_OUT")):
                names.wrong(item.place, f"{item.name} is in no DualPort", "a declaration of DUAL_PORT")


def _declarations(program: Program) -> Iterator[Declaration]:
    for item in program.items:
        if isinstance(item, Declaration):
            yield item
            yield from item.parts


def _check_crcs(port: PortPlan, places: Mapping[str, Place], names: Names) -> None:
    """Report names with the same CRC, which the manual believes to be impossible (manual line 9460)."""
    known: dict[int, str] = {}
    for variable in port.variables:
        other = known.setdefault(variable.crc, variable.name)
        if other != variable.name:
            what = f"{variable.name} has the same CRC #{variable.crc:04X} as {other}"
            names.wrong(places[variable.name], what, "another name")


def _place(declaration: Declaration, name: str) -> Place:
    return next((parameter.place for parameter in declaration.parameters if parameter.name == name), declaration.place)


class _Map:
    """The bits of a Simatic DualPort, with what each of them belongs to."""

    def __init__(self, port: PortPlan, places: Mapping[str, Place], names: Names) -> None:
        self._port, self._places, self._names = port, places, names
        self._owners: dict[int, str] = {}
        self._multiple_cells: dict[int, bool] = {}
        """True for a cell with input flags of a multiple variable, False for one with single flags."""

    def check(self) -> None:
        item = self._port.declaration
        for name, value in (("START_ADDRESS", 0), ("LENGTH", MEMORY)):
            if list(self._port.numbers(name)) != [value]:
                self._names.note(_place(item, name), f"{name} is not {value}", "The PAM uses the whole DualPort.")
        for name in _FIFOS:
            self._fifo(name)
        for watch_dog in self._port.numbers("WATCH_DOG"):
            if self._is_cell("WATCH_DOG", watch_dog, _place(item, "WATCH_DOG")):
                self._take("WATCH_DOG", watch_dog * 8, 16, _place(item, "WATCH_DOG"))
                self._take("the fatal error panel", (watch_dog - PANEL) * 8, PANEL * 8, _place(item, "WATCH_DOG"))
        for name in _READY:
            self._flag(name, (*self._port.numbers(name), 0, 0)[:2], 1, _place(item, name))
        for variable in self._port.variables:
            self._variable(variable)

    def _fifo(self, name: str) -> None:
        item = self._port.declaration
        addresses = [
            address
            for part in (f"{name}_START", f"{name}_HEAD", f"{name}_TAIL")
            for address in self._port.numbers(part)
            if self._is_cell(part, address, _place(item, part))
        ]
        if len(addresses) < 3:
            return
        start, head, tail = addresses
        if not 4 <= head - start <= LARGEST_FIFO:
            expected = f"4 to {LARGEST_FIFO} bytes behind {name}_START"
            self._names.wrong(_place(item, f"{name}_HEAD"), f"{name}_HEAD is at #{head:X}", expected)
            return
        self._take(name, start * 8, (head - start) * 8, _place(item, f"{name}_START"))
        self._take(f"{name}_HEAD", head * 8, 16, _place(item, f"{name}_HEAD"))
        self._take(f"{name}_TAIL", tail * 8, 16, _place(item, f"{name}_TAIL"))

    def _variable(self, variable: PortVariable) -> None:
        place = self._places[variable.name]
        if variable.reserved < variable.number:
            what = f"RESERVED of {variable.name} is {variable.reserved}"
            self._names.wrong(place, what, f"at least {variable.number}, the number of its items")
        size = max(variable.reserved, variable.number)
        if variable.kind == "WORD_VAR":
            if self._is_cell(variable.name, variable.address, place):
                self._take(variable.name, variable.address * 8, 16 * size, place)
            return
        if variable.is_multiple and (variable.bit or variable.address % 2):
            self._names.wrong(place, f"{variable.name} has several items", "bit 0 of an even address")
            return
        self._flag(variable.name, (variable.address, variable.bit), size, place)
        if variable.is_input:
            self._unmixed(variable, size, place)

    def _unmixed(self, variable: PortVariable, size: int, place: Place) -> None:
        """Report single and multiple input flags in one cell (PAMS-095)."""
        first = variable.address // 2
        for cell in range(first, first + (size + 15) // 16):
            if self._multiple_cells.setdefault(cell, variable.is_multiple) != variable.is_multiple:
                what = f"{variable.name} shares cell #{2 * cell:X} with flags of the other sort"
                self._names.wrong(place, what, "single flags, or one multiple flag, in a cell of inputs")

    def _flag(self, name: str, at: Sequence[int], size: int, place: Place) -> None:
        address, bit = at
        if not 0 <= bit <= 7:
            self._names.wrong(place, f"{name} is bit {bit}", "a bit from 0 to 7")
            return
        self._take(name, address * 8 + bit, size, place)

    def _is_cell(self, name: str, address: int, place: Place) -> bool:
        if address % 2:
            self._names.wrong(place, f"{name} is at #{address:X}", "an even address")
        return address % 2 == 0

    def _take(self, name: str, first: int, size: int, place: Place) -> None:
        if first < 0 or first + size > MEMORY * 8:
            self._names.wrong(place, f"{name} is at #{max(first, 0) // 8:X}", f"a place below #{MEMORY:X}")
            return
        for bit in range(first, first + size):
            other = self._owners.setdefault(bit, name)
            if other != name:
                what = f"{name} overlaps {other} at #{bit // 8:X} bit {bit % 8}"
                self._names.wrong(place, what, "a place of its own")
                return
