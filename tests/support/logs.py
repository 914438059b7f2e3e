"""Logs that a test writes as text."""

from collections.abc import Iterable

from canopen_bench import parse

from fieldrig.clock import MS
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import codec as can_codec
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus import codec as modbus_codec
from fieldrig_bus.modbus.message import OnModbus


def can_entry(time_ns: int, frame: CanFrame, bus: str = "can0") -> TraceEntry:
    return TraceEntry(time_ns, bus, "can", "", can_codec.encode(frame))


def can_log(*frames: str, bus: str = "can0") -> list[TraceEntry]:
    """Return frames such as "605#40 00 10 00 00 00 00 00", one each millisecond."""
    return [can_entry(number * MS, parse(text), bus) for number, text in enumerate(frames)]


def modbus_log(messages: Iterable[tuple[str, OnModbus]], bus: str = "mb") -> list[TraceEntry]:
    """Return messages with their senders, one each millisecond."""
    return [
        TraceEntry(number * MS, bus, "modbus", sender, modbus_codec.encode(message))
        for number, (sender, message) in enumerate(messages)
    ]
