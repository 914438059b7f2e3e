"""The signals of a bus as a recording reads them, such as wires: standing messages, and deliveries for the changes."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

from fieldrig.bus import Bus, Delivery
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.recording.signals import NAN, Described, End, OnCycle
from fieldrig.text.nearest import closest

OnDelivery = Callable[[Delivery[Any]], None]


class BusSignals:
    """A bus with a model in this process (`RecordedPart`)."""

    is_bus: ClassVar[bool] = True

    def __init__(
        self,
        bus: Bus[Any],
        standing: Callable[[], Mapping[str, Any]],
        listen: Callable[[OnDelivery], End],
        now_ns: Callable[[], int],
    ) -> None:
        """`standing` returns the last message of each signal, by its name."""
        self._bus, self._standing, self._listen, self._now_ns = bus, standing, listen, now_ns
        self._heard: dict[str, Any] = {}
        """The last messages as receivers got them, which may differ from those that were sent, by a fault."""
        self._end: End | None = None

    def describe(self, keys: Sequence[str]) -> list[Described]:
        standing, now_ns = self._standing(), self._now_ns()
        described = []
        for key in keys:
            reading = self._bus.reading(standing[key], now_ns) if key in standing else None
            if reading is None:
                raise ControlError(f"nothing drives {key!r} on {self._bus.name}", closest(key, list(standing)))
            described.append(Described(reading.value, reading.unit))
        return described

    def reader(self, keys: Sequence[str]) -> Callable[[], Sequence[Value]]:
        heard, standing, now_ns, reading = self._heard, self._standing, self._now_ns, self._bus.reading
        if self._end is None:
            self._end = self._listen(self._hear)

        def read() -> list[Value]:
            present, at_ns = standing(), now_ns()
            messages = [heard.get(key, present.get(key)) for key in keys]
            readings = [None if message is None else reading(message, at_ns) for message in messages]
            return [NAN if found is None else found.value for found in readings]

        return read

    def _hear(self, delivery: Delivery[Any]) -> None:
        found = self._bus.reading(delivery.message, delivery.time_ns)
        if found is not None:
            self._heard[found.name] = delivery.message

    def close(self) -> None:
        if self._end is not None:
            self._end()
            self._end = None

    def on_cycle(self, action: OnCycle) -> None:
        return None

    def on_change(self, keys: Sequence[str], action: Callable[[int, int, Value], None]) -> End:
        places = {key: place for place, key in enumerate(keys)}

        def on_delivery(delivery: Delivery[Any]) -> None:
            reading = self._bus.reading(delivery.message, delivery.time_ns)
            if reading is not None and reading.name in places:
                action(delivery.time_ns, places[reading.name], reading.value)

        return self._listen(on_delivery)
