"""Command lines that access the registers of a Modbus device with mbpoll (Debian package mbpoll) and with pymodbus.

They read what the register table has, so each works with this device, on every bus that a master outside can join.
"""

import shlex
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from typing import Any, NamedTuple

from fieldrig.bus import Bus
from fieldrig.device import Tool, python_line
from fieldrig_bus.modbus.kind import ModbusBus
from fieldrig_devices.registers.entries import Bit, Register, words_of
from fieldrig_devices.registers.table import SPACES, Table, access_of

SPACE_OPTION = {"coils": "0", "discrete_inputs": "1", "input_registers": "3", "holding_registers": "4"}
FORMAT_OPTION = {"s32": ":int", "f32": ":float"}
METHOD = {
    "coils": "read_coils",
    "discrete_inputs": "read_discrete_inputs",
    "input_registers": "read_input_registers",
    "holding_registers": "read_holding_registers",
}
MOST_SHOWN = 100  # registers in a command line


class _Group(NamedTuple):
    """Adjacent values that a single command line can show."""

    space: str
    options: tuple[str, ...]
    address: int
    names: list[str]
    values: int
    end: int


def lines_for(table: Table, unit_id: int, buses: Iterable[Bus[Any]]) -> list[Tool]:
    """Command lines that read all values, and command lines that write the first coil."""
    return _on_each(buses, lambda bus: [*_by_mbpoll(table, unit_id, bus), *_by_pymodbus(table, unit_id, bus)])


def identification_lines(unit_id: int, buses: Iterable[Bus[Any]]) -> list[Tool]:
    """Command lines that read the identification of a unit (function 43/14), for devices without a table."""
    call = f"c.read_device_information(device_id={unit_id}).information"
    return _on_each(buses, lambda bus: [_pymodbus_line("what it is", bus, [call])])


def word_lines(unit_id: int, buses: Iterable[Bus[Any]]) -> list[Tool]:
    """Command lines that read the first eight holding registers of a unit whose registers are a memory."""
    call = f"c.read_holding_registers(0, count=8, device_id={unit_id})"
    return _on_each(buses, lambda bus: [_pymodbus_line("words 0 to 7", bus, [call])])


def _on_each(buses: Iterable[Bus[Any]], lines: Callable[[ModbusBus], list[Tool]]) -> list[Tool]:
    """Return the lines for each bus that a master outside can join; labels name the bus if there are several."""
    reachable = [bus for bus in buses if isinstance(bus, ModbusBus) and bus.pymodbus() is not None]
    return [
        Tool(f"{tool.label} by {bus.name}" if len(reachable) > 1 else tool.label, tool.line)
        for bus in reachable
        for tool in lines(bus)
    ]


def _pymodbus_line(label: str, bus: ModbusBus, calls: Iterable[str]) -> Tool:
    steps = [bus.pymodbus(), *(f"print({call})" for call in calls), "c.close()"]
    return Tool(label, python_line("; ".join(filter(None, steps))))


def _by_mbpoll(table: Table, unit_id: int, bus: ModbusBus) -> Iterator[Tool]:
    way = bus.mbpoll()
    if way is None:
        return
    options, target = way

    def line(*more: str) -> str:
        return f"{shlex.join(['mbpoll', *options, '-a', str(unit_id), *more])} {target}"

    for group in _groups(table):
        label = f"{group.space.replace('_', ' ')}: {', '.join(group.names)}"
        yield Tool(label, line(*group.options, "-0", "-r", str(group.address), "-c", str(group.values), "-1"))
    coil = _first_writable(table)
    if coil is not None:
        yield Tool(f"{coil.name} on", f"{line('-t', '0', '-0', '-r', str(coil.address))} 1")


def _by_pymodbus(table: Table, unit_id: int, bus: ModbusBus) -> Iterator[Tool]:
    unit = f"device_id={unit_id}"
    reads = [
        f"c.{METHOD[group.space]}({group.address}, count={min(group.end - group.address, MOST_SHOWN)}, {unit})"
        for group in _groups(table)
    ]
    if reads:
        yield _pymodbus_line("all registers with pymodbus", bus, reads)
    coil = _first_writable(table)
    if coil is not None:
        yield _pymodbus_line(f"{coil.name} on with pymodbus", bus, [f"c.write_coil({coil.address}, True, {unit})"])


def _first_writable(table: Table) -> Bit | None:
    return next((coil for coil in table.coils if access_of("coils", coil) != "ro"), None)


def _groups(table: Table) -> list[_Group]:
    return list(chain.from_iterable(_groups_of(space, table) for space in SPACES))


def _groups_of(space: str, table: Table) -> list[_Group]:
    groups: list[_Group] = []
    for entry in sorted(table.entries(space), key=lambda entry: entry.address):
        if access_of(space, entry) == "wo":
            continue
        options = _options(space, entry, table)
        size = entry.count * words_of(entry)
        values = size if options[1] == SPACE_OPTION[space] else entry.count
        last = groups[-1] if groups else None
        if last is not None and last.options == options and last.end == entry.address and last.end < MOST_SHOWN:
            last.names.append(entry.name)
            groups[-1] = last._replace(values=last.values + values, end=entry.address + size)
        else:
            groups.append(_Group(space, options, entry.address, [entry.name], values, entry.address + size))
    return [group._replace(values=min(group.values, MOST_SHOWN)) for group in groups]


def _options(space: str, entry: Bit | Register, table: Table) -> tuple[str, ...]:
    if not isinstance(entry, Register) or entry.type not in FORMAT_OPTION:
        return ("-t", SPACE_OPTION[space])
    if (entry.byte_order or table.byte_order) == "little":  # mbpoll knows no order of bytes, so it shows registers
        return ("-t", SPACE_OPTION[space])
    is_big = (entry.word_order or table.word_order) == "big"
    return ("-t", SPACE_OPTION[space] + FORMAT_OPTION[entry.type], *(("-B",) if is_big else ()))
