"""The messages of the buses of a rig in real time, as they are published, and what a scenario wants to know of them."""

from collections.abc import Iterator, Sequence
from typing import Any

from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Value
from fieldrig.faults.note import FaultNote
from fieldrig.real.bus_inbox import Batch
from fieldrig_bus.wires import Signal
from fieldrig_devices.scenarios.calls import Call, is_of_an_arrival
from fieldrig_devices.scenarios.messages import Messages

Change = tuple[int, str, Value]
"""An instant of the monotonic clock, a place, and its value."""


class Traffic:
    """Makes changes of places from messages."""

    def __init__(self, config: RigConfig, calls: Sequence[Call], signals: Sequence[tuple[str, str]]) -> None:
        """`calls` are of messages, `signals` are those of buses with their keys.  ControlError for a wrong one."""
        self._buses = {name: entry.bus for name, entry in config.buses.items()}
        in_order = sorted(calls, key=lambda call: is_of_an_arrival(str(call)))
        self._calls = [(call, Messages(config, call.target, call.words)) for call in in_order]
        self._signals = set(signals)
        self._counts = dict.fromkeys((str(call) for call, _ in self._calls), 0)

    @property
    def buses(self) -> list[str]:
        """The buses that have to be listened to."""
        return list(dict.fromkeys([*(call.target for call, _ in self._calls), *(bus for bus, _ in self._signals)]))

    def first(self) -> dict[str, Value]:
        """Return the values of the places of messages before the first one."""
        return {name: _first(name) for name in self._counts}

    def changes(self, batch: Batch) -> Iterator[Change]:
        """Yield the changes that the messages of a batch make, in their order."""
        bus = self._buses[batch.bus]
        for at_ns, sender, data in batch.content["entries"]:
            try:
                message = bus.decode(bytes.fromhex(data))
            except ValueError:
                continue  # bytes of another version of the rig
            if isinstance(message, Signal) and (batch.bus, message.name) in self._signals:
                yield at_ns, f"{batch.bus}/{message.name}", message.at(at_ns)
            if not isinstance(message, FaultNote):
                yield from self._of_calls(at_ns, batch.bus, sender, message)

    def _of_calls(self, at_ns: int, bus: str, sender: str, message: Any) -> Iterator[Change]:
        for call, messages in self._calls:
            if call.target != bus or not messages.has(sender, message):
                continue
            name = str(call)
            self._counts[name] += 1
            match call.kind:
                case "message":
                    yield at_ns, name, True
                    yield at_ns, name, False
                case "count":
                    yield at_ns, name, self._counts[name]
                case _:
                    yield at_ns, name, 0.0


def _first(name: str) -> Value:
    return False if name.startswith("message") else 0 if name.startswith("count") else 0.0
