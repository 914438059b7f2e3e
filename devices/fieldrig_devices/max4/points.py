"""The points of a controller for `fieldrig get`, `set` and `watch`: all parameters, and values without a parameter.

The name of a point is that of the parameter; for objects other than the controller, the symbolic name of the object
precedes it: `DiagCode`, `belt.Position`.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Protocol

from fieldrig.device import Point, Value
from fieldrig.points.checks import truth_in
from fieldrig_devices.max4.configuration.tree import Parameter
from fieldrig_devices.max4.ring.real_time_bus import State
from fieldrig_devices.max4.storage.buffered_ram import NVRAM_BYTES as SHOWN

if TYPE_CHECKING:
    from fieldrig_devices.max4.controller import Max4


def points(max4: "Max4") -> dict[str, Point]:
    """The points of the present configuration.  A variable of the program has its path, unless a parameter has it."""
    own = {**dict(_parameters(max4)), **dict(_inputs(max4)), **dict(_states(max4)), **dict(max4.plc.points())}
    return own | {path: point for path, point in max4.plc.variables() if path not in own}


def _parameters(max4: "Max4") -> Iterator[tuple[str, Point]]:
    root = max4.tree.root
    for owner in max4.tree.objects():
        for parameter in owner.parameters:
            key = parameter.name if owner is root else f"{owner.symbol or owner.name}.{parameter.name}"
            write = parameter.set if parameter.is_writable else None
            yield key, Point(partial(_value, parameter), write, parameter.unit, parameter.about)


def _value(parameter: Parameter) -> Value:
    return parameter.shown


def _inputs(max4: "Max4") -> Iterator[tuple[str, Point]]:
    """The inputs, which can be written as long as no wire drives them."""
    settings, terminals = max4.settings, max4.system.terminals
    kinds: tuple[tuple[Mapping[str, str], Mapping[str, _Input]], ...] = (
        (settings.inputs, terminals.inputs),
        (settings.measuring_inputs, terminals.measuring),
    )
    for wires, table in kinds:
        for symbol, terminal in table.items():
            if not wires.get(symbol):
                yield f"{symbol}.Value", Point(partial(_level, terminal), partial(_put, terminal))


class _Input(Protocol):
    """A digital input or a measuring input."""

    value: bool

    def put(self, is_on: bool) -> None:
        """Set the level."""


def _level(terminal: _Input) -> Value:
    return terminal.value


def _put(terminal: _Input, value: Value) -> None:
    terminal.put(truth_in(value))


def _states(max4: "Max4") -> Iterator[tuple[str, Point]]:
    def command(words: Value) -> None:
        max4.operations.do(str(words))

    def write_nvram(value: Value) -> None:
        offset, _, digits = str(value).partition(":")
        try:
            at, data = int(offset, 0), bytes.fromhex(digits)
        except ValueError:
            raise ValueError(f"expected an offset and hex digits such as 0x10:01 02, got {value!r}") from None
        size = len(max4.ram.nvram)
        if not 0 <= at <= size - len(data):
            raise ValueError(f"expected an offset and data within {size} bytes, got {len(data)} bytes at {at}")
        max4.ram.nvram[at : at + len(data)] = data

    yield "command", Point(lambda: max4.operations.last, command, "", "command of an operator, in words")
    yield "log", Point(lambda: "\n".join(max4.logger.lines()), about="the message logger, newest first")
    yield "log.last", Point(lambda: next(iter(max4.logger.lines()), ""), about="newest entry of the message logger")
    yield "files", Point(lambda: " ".join(max4.disk.names), about="names of the files on the flash disk")
    yield "files.cycles", Point(lambda: max4.disk.most_cycles, about="write cycles of the most written file")
    yield (
        "nvram",
        Point(lambda: max4.ram.nvram[:SHOWN].hex(), write_nvram, "", "first 1024 bytes of the NVRAM; write OFFSET:HEX"),
    )
    yield "power", Point(lambda: max4.is_on)
    yield "booted", Point(lambda: max4.is_booted)
    yield "reset_needed", Point(lambda: max4.is_reset_needed, about="true if the stored configuration has changed")
    yield "program", Point(lambda: "running" if max4.is_program_running else "stopped")
    yield "led.power", Point(lambda: "on" if max4.is_on else "off")
    yield "led.err", Point(lambda: "flashing" if max4.diagnosis.code else "off")
    yield "led.run", Point(lambda: "on" if max4.is_program_running else "off")
    yield "led.bus", Point(partial(_bus_led, max4))
    yield "ring.state", Point(lambda: max4.bus.state.name.lower() if max4.bus is not None else "off")
    yield "ring.phase", Point(lambda: max4.bus.phase if max4.bus is not None else 0)
    yield "ring.open", Point(lambda: max4.bus is not None and max4.bus.is_open)
    yield "cycles", Point(lambda: max4.system.process.cycles, about="cycles of the real-time process since the boot")
    yield "missed_cycles", Point(lambda: max4.bus.missed_cycles if max4.bus is not None else 0)


def _bus_led(max4: "Max4") -> Value:
    if max4.bus is None or max4.bus.state in (State.OFF, State.DOWN):
        return "off"
    return "on" if max4.bus.state is State.UP else "flashing"
