"""The points of the devices and the signals of the buses of one process in real time, as faults wait for them."""

from collections.abc import Callable, Container, Mapping
from typing import Any, Protocol

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.faults.signals import value_of
from fieldrig.points.access import read_point
from fieldrig.points.names import split_point
from fieldrig.real.switched import Switched

OnChange = Callable[[Value], None]


def _nothing() -> None:
    """Do nothing."""


class Signals(Protocol):
    """A bus, as the faults see it that wait for one of its signals."""

    def signals(self) -> Mapping[str, Mapping[str, Any]]: ...


class ProcessPoints:
    """It implements `triggers.Points`.  `tell` reports every change, in order.

    Changes of signals are not reported: who waits for one looks at it again and again.
    """

    def __init__(
        self,
        process: str,
        devices: Mapping[str, Switched],
        buses: Mapping[str, Signals],
        driven_on: Callable[[str], Container[str]],
    ) -> None:
        """`driven_on` returns the wires of a bus that devices drive."""
        self._process, self._devices, self._buses, self._driven_on = process, devices, buses, driven_on
        self._calls: dict[str, dict[str, list[OnChange]]] = {}
        """The calls for changes of points, by device and key."""

    def has(self, device: str) -> bool:
        """Return whether a device or bus is one of this process."""
        return device in self._devices or device in self._buses

    def get(self, point: str, key: str | None = None) -> Value:
        """Return the present value.  ControlError for a point that this process does not have."""
        device, key = split_point(point, key)
        if device in self._buses:
            return value_of(device, key, self._buses[device].signals(), self._driven_on(device))
        return read_point(device, self._device(device).points(), key)

    def on_change(self, point: str, call: OnChange) -> Callable[[], None]:
        """Call `call(value)` for each change from now on.  Returns a function that ends the watch."""
        name, key = split_point(point)
        if name in self._buses:
            return _nothing
        device = self._device(name)
        calls = self._calls.setdefault(name, {}).setdefault(key, [])
        if not calls:
            device.watched.watch(key)
        calls.append(call)

        def end() -> None:
            calls.remove(call)
            if not calls:
                device.watched.unwatch(key)

        return end

    def tell(self) -> None:
        """Tell the changes since the last call."""
        for name, keys in self._calls.items():
            for change in self._devices[name].changes():
                for call in list(keys.get(change.key, ())):
                    call(change.value)

    def _device(self, name: str) -> Switched:
        if name not in self._devices:
            raise ControlError(f"{name} is no device of the process {self._process}")
        return self._devices[name]
