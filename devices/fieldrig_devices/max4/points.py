"""What `fieldrig get`, `set` and `watch` see of a controller: every parameter of its tree, and what has no parameter.

Parameters of the controller itself go by their names, those of other objects behind the symbolic name of the object:
`DiagCode`, `belt.Position`.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

from fieldrig.device import Point, Value
from fieldrig.point_values import truth_in
from fieldrig_devices.max4.configuration.tree import Parameter
from fieldrig_devices.max4.ring.real_time_bus import State
from fieldrig_devices.max4.storage.buffered_ram import NVRAM_BYTES as SHOWN

if TYPE_CHECKING:
    from fieldrig_devices.max4.controller import Max4


def points(one: "Max4") -> dict[str, Point]:
    """Of the present configuration."""
    return {**dict(_parameters(one)), **dict(_inputs(one)), **dict(_states(one))}


def _parameters(one: "Max4") -> Iterator[tuple[str, Point]]:
    root = one.tree.root
    for owner in one.tree.objects():
        for parameter in owner.parameters:
            key = parameter.name if owner is root else f"{owner.symbol or owner.name}.{parameter.name}"
            write = parameter.set if parameter.is_writable else None
            yield key, Point(partial(_value, parameter), write, parameter.unit, parameter.about)


def _value(parameter: Parameter) -> Value:
    return parameter.value


def _inputs(one: "Max4") -> Iterator[tuple[str, Point]]:
    """Can be written while no wire drives them."""
    settings, terminals = one.settings, one.system.terminals
    for wires, table in ((settings.inputs, terminals.inputs), (settings.measuring_inputs, terminals.measuring)):
        for symbol, terminal in table.items():
            if not wires.get(symbol):
                yield f"{symbol}.Value", Point(partial(getattr, terminal, "value"), partial(_put, terminal.put))


def _put(put: Callable[[bool], None], value: Value) -> None:
    put(truth_in(value))


def _states(one: "Max4") -> Iterator[tuple[str, Point]]:
    def command(words: Value) -> None:
        one.operations.do(str(words))

    def write_nvram(value: Value) -> None:
        offset, _, digits = str(value).partition(":")
        try:
            at, data = int(offset, 0), bytes.fromhex(digits)
        except ValueError:
            raise ValueError(f"expected an offset and hex digits such as 0x10:01 02, got {value!r}") from None
        size = len(one.ram.nvram)
        if not 0 <= at <= size - len(data):
            raise ValueError(f"expected an offset and data within {size} bytes, got {len(data)} bytes at {at}")
        one.ram.nvram[at : at + len(data)] = data

    yield "command", Point(lambda: one.operations.last, command, "", "what an operator does, in words")
    yield "log", Point(lambda: "\n".join(one.logger.lines()), about="the message logger, newest first")
    yield "log.last", Point(lambda: next(iter(one.logger.lines()), ""), about="its newest entry")
    yield "files", Point(lambda: " ".join(one.disk.names), about="on the flash disk")
    yield "nvram", Point(lambda: one.ram.nvram[:SHOWN].hex(), write_nvram, "", "its first 1024 bytes; write OFFSET:HEX")
    yield "power", Point(lambda: one.is_on)
    yield "booted", Point(lambda: one.is_booted)
    yield "reset_needed", Point(lambda: one.is_reset_needed, about="the configuration has been changed")
    yield "program", Point(lambda: "running" if one.is_program_running else "stopped")
    yield "led.power", Point(lambda: "on" if one.is_on else "off")
    yield "led.err", Point(lambda: "flashing" if one.diagnosis.code else "off")
    yield "led.run", Point(lambda: "on" if one.is_program_running else "off")
    yield "led.bus", Point(partial(_bus_led, one))
    yield "ring.state", Point(lambda: one.bus.state.name.lower() if one.bus is not None else "off")
    yield "ring.phase", Point(lambda: one.bus.phase if one.bus is not None else 0)
    yield "ring.open", Point(lambda: one.bus is not None and one.bus.is_open)
    yield "cycles", Point(lambda: one.system.process.cycles, about="of the real-time process since the boot")
    yield "missed_cycles", Point(lambda: one.bus.missed_cycles if one.bus is not None else 0)


def _bus_led(one: "Max4") -> Value:
    if one.bus is None or one.bus.state in (State.OFF, State.DOWN):
        return "off"
    return "on" if one.bus.state is State.UP else "flashing"
