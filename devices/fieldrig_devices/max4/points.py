"""The points of a controller for `fieldrig get`, `set` and `watch`: all parameters, and values without a parameter.

The name of a point is that of the parameter; for objects other than the controller, the symbolic name of the object
precedes it: `DiagCode`, `belt.Position`.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Protocol

from fieldrig.device import Point, Value
from fieldrig.points.checks import truth_in
from fieldrig_devices.max4.configuration.tree import ObjectTree, Parameter, Type
from fieldrig_devices.max4.firmware import Firmware
from fieldrig_devices.max4.messages.logger import Logger
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.storage.buffered_ram import NVRAM_BYTES as SHOWN
from fieldrig_devices.max4.storage.buffered_ram import BufferedRam
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.terminals import Terminals


def parameter_points(tree: ObjectTree) -> Iterator[tuple[str, Point]]:
    """Yield all parameters of a tree."""
    for owner in tree.objects():
        for parameter in owner.parameters:
            key = parameter.name if owner is tree.root else f"{owner.symbol or owner.name}.{parameter.name}"
            write = parameter.set if parameter.is_writable else None
            is_number = parameter.type not in (Type.BOOL, Type.STRING) and parameter.low < parameter.high
            yield (
                key,
                Point(
                    partial(_value, parameter),
                    write,
                    parameter.unit,
                    parameter.about,
                    type=parameter.type.name,
                    low=parameter.low if is_number else None,
                    high=parameter.high if is_number else None,
                ),
            )


def _value(parameter: Parameter) -> Value:
    return parameter.shown


class _Input(Protocol):
    """A digital input or a measuring input."""

    value: bool

    def put(self, is_on: bool) -> None:
        """Set the level."""


def input_points(settings: Max4Settings, terminals: Terminals) -> Iterator[tuple[str, Point]]:
    """Yield the inputs that no wire drives, which can be written."""
    tables: tuple[tuple[Mapping[str, str], Mapping[str, _Input]], ...] = (
        (settings.inputs, terminals.inputs),
        (settings.measuring_inputs, terminals.measuring),
    )
    for wires, table in tables:
        for symbol, terminal in table.items():
            if not wires.get(symbol):
                yield f"{symbol}.Value", Point(partial(_level, terminal), partial(_put, terminal))


def _level(terminal: _Input) -> Value:
    return terminal.value


def _put(terminal: _Input, value: Value) -> None:
    terminal.put(truth_in(value))


def memory_points(logger: Logger, disk: FlashDisk, ram: BufferedRam) -> Iterator[tuple[str, Point]]:
    """Yield the content of the memories, as texts."""

    def write_nvram(value: Value) -> None:
        offset, _, digits = str(value).partition(":")
        try:
            at, data = int(offset, 0), bytes.fromhex(digits)
        except ValueError:
            raise ValueError(f"expected an offset and hex digits such as 0x10:01 02, got {value!r}") from None
        size = len(ram.nvram)
        if not 0 <= at <= size - len(data):
            raise ValueError(f"expected an offset and data within {size} bytes, got {len(data)} bytes at {at}")
        ram.nvram[at : at + len(data)] = data

    yield "log", Point(lambda: "\n".join(logger.lines()), about="the message logger, newest first")
    yield "log.last", Point(lambda: next(iter(logger.lines()), ""), about="newest entry of the message logger")
    yield "files", Point(lambda: " ".join(disk.names), about="names of the files on the flash disk")
    yield "files.cycles", Point(lambda: disk.most_cycles, about="write cycles of the most written file")
    yield (
        "nvram",
        Point(lambda: ram.nvram[:SHOWN].hex(), write_nvram, "", "first 1024 bytes of the NVRAM; write OFFSET:HEX"),
    )


def state_points(firmware: Firmware) -> Iterator[tuple[str, Point]]:
    """Yield power, boot, program and LEDs."""
    plc = firmware.plc
    yield "power", Point(lambda: firmware.is_on)
    yield "booted", Point(lambda: firmware.is_booted)
    yield "reset_needed", Point(lambda: firmware.is_reset_needed, about="true if the stored configuration has changed")
    yield "program", Point(lambda: "running" if plc.is_running else "stopped")
    yield "led.power", Point(lambda: "on" if firmware.is_on else "off")
    yield "led.err", Point(lambda: "flashing" if firmware.diagnosis.code else "off")
    yield "led.run", Point(lambda: "on" if plc.is_running else "off")
