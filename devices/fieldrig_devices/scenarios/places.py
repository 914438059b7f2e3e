"""Places of a rig by name: points of devices, and wires and other signals of buses."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.points.names import split_point
from fieldrig.text.nearest import closest
from fieldrig_bus.wires import Signal

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

MEMBER = "test"
"""The name of the test, or scenario, among the members of a bus."""


class RigPlace(Protocol):
    name: str

    def read(self) -> Value: ...

    def write(self, value: Value) -> None:
        """RigError for a value that is refused."""

    def listen(self, call: Callable[[Value], None]) -> Callable[[], None]:
        """Call `call` at each change; returns a function that ends it."""


def place_of(rig: "Rig", name: str) -> RigPlace:
    """Return a place, such as `tank/level`.  RigError if the rig does not have it."""
    part, key = split_point(name)
    return BusSignal(rig, part, key) if part in rig.buses else DevicePoint(rig, name)


class DevicePoint:
    """A point of a device."""

    def __init__(self, rig: "Rig", name: str) -> None:
        self._rig, self.name = rig, name

    def read(self) -> Value:
        return self._rig.get(self.name)

    def write(self, value: Value) -> None:
        self._rig.set(self.name, value)

    def listen(self, call: Callable[[Value], None]) -> Callable[[], None]:
        return self._rig.on_change(self.name, call)


class BusSignal:
    """A signal of a bus, such as a wire; before its first message a wire is False."""

    def __init__(self, rig: "Rig", bus: str, key: str) -> None:
        self._rig, self._bus, self._key, self.name = rig, bus, key, f"{bus}/{key}"
        self._send: Callable[[Signal], None] | None = None

    def read(self) -> Value:
        known = self._rig.signals(self._bus)
        if self._key in known:
            value: Value = known[self._key]["value"]
            return value
        heard = {name for names in self._rig.interests(self._bus).values() for name in names or ()}
        if self._key in heard:
            return False  # a device listens to it, and nothing has been on it yet
        raise ControlError(f"{self._bus} has no signal {self._key!r}", closest(self._key, [*known, *map(str, heard)]))

    def write(self, value: Value) -> None:
        if isinstance(value, str):
            raise ControlError(f"{self.name} cannot be a text", "expected a level or a number")
        if self._send is None:
            self._send = self._rig.attach(f"{MEMBER}:{self.name}").link(self._bus).send
        self._send(Signal(self._key, value))

    def listen(self, call: Callable[[Value], None]) -> Callable[[], None]:
        rig = self._rig

        def heard(bus: object, delivery: object) -> None:
            message = getattr(delivery, "message", None)
            if bus is rig.buses[self._bus] and isinstance(message, Signal) and message.name == self._key:
                call(message.at(rig.now_ns))

        return rig.on_delivery(heard)
