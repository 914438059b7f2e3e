"""Command lines that access the registers of a Modbus device with mbpoll (Debian package mbpoll).

A device does not know the rig's run folder, so they cover TCP buses only; a serial bus shows command lines of its own.
"""

from collections.abc import Iterable
from itertools import chain
from typing import Any, NamedTuple

from fieldrig.bus import Bus
from fieldrig.device import Tool
from fieldrig_bus.modbus.tcp import ModbusTcp
from fieldrig_devices.registers.table import SPACES, Bit, Register, Table, access_of, words_of

SPACE_OPTION = {"coils": "0", "discrete_inputs": "1", "input_registers": "3", "holding_registers": "4"}
FORMAT_OPTION = {"s32": ":int", "f32": ":float"}
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
    """Command lines that read all values, and a command line that writes the first coil."""
    tools: list[Tool] = []
    for bus in buses:
        if not isinstance(bus, ModbusTcp):
            continue
        for group in _groups(table):
            label = f"{group.space.replace('_', ' ')}: {', '.join(group.names)}"
            place = ["-a", str(unit_id), *group.options, "-0", "-r", str(group.address), "-c", str(group.values)]
            tools.append(bus.mbpoll_line(label, [*place, "-1"]))
        for coil in table.coils:
            if access_of("coils", coil) != "ro":
                place = ["-a", str(unit_id), "-t", "0", "-0", "-r", str(coil.address)]
                tools.append(bus.mbpoll_line(f"{coil.name} on", place, "1"))
                break
    return tools


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
    is_big = (entry.word_order or table.word_order) == "big"
    return ("-t", SPACE_OPTION[space] + FORMAT_OPTION[entry.type], *(("-B",) if is_big else ()))
