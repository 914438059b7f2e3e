"""Places of a rig by name: points of devices, wires and other signals of buses, messages and diagnoses."""

from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Protocol

from fieldrig.clock import S
from fieldrig.device import Value
from fieldrig.errors import ControlError, refusals
from fieldrig.points.names import split_point
from fieldrig.text.nearest import closest
from fieldrig_bus.wires import Signal
from fieldrig_devices.scenarios.calls import Call, call_of
from fieldrig_devices.scenarios.diagnoses import diagnosis_keys, shows

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

MEMBER = "test"
"""The name of the test, or scenario, among the members of a bus."""

End = Callable[[], None]


class RigPlace(Protocol):
    name: str

    def read(self) -> Value: ...

    def write(self, value: Value) -> None:
        """RigError for a value that is refused."""

    def listen(self, call: Callable[[Value], None]) -> End:
        """Call `call` at each change; returns a function that ends it."""


def place_of(rig: "Rig", name: str) -> RigPlace:
    """Return a place, such as `tank/level` or `message(can0, id=0x181)`.  RigError if the rig does not have it."""
    with refusals(name):
        call = call_of(name)
    if call is not None:
        return Diagnosis(rig, call) if call.kind == "diagnosis" else Traffic(rig, call)
    part, key = split_point(name)
    return BusSignal(rig, part, key) if part in rig.buses else DevicePoint(rig, name)


def has_power(rig: "Rig", part: str) -> bool:
    """Return whether it is a bus, or a device with power."""
    if part not in rig.config.devices:
        return True
    try:
        rig.values(part, ())
    except ControlError:
        return False
    return True


class DevicePoint:
    """A point of a device."""

    def __init__(self, rig: "Rig", name: str) -> None:
        self._rig, self.name = rig, name
        self._device, self._key = split_point(name)

    def read(self) -> Value:
        return self._rig.get(self._device, self._key)

    def write(self, value: Value) -> None:
        self._rig.set(self.name, value)

    def listen(self, call: Callable[[Value], None]) -> End:
        return self._rig.on_change(self.name, call)


class BusSignal:
    """A signal of a bus, such as a wire; before its first message a wire is False."""

    def __init__(self, rig: "Rig", bus: str, key: str) -> None:
        self._rig, self._bus, self._key, self.name = rig, bus, key, f"{bus}/{key}"
        self._send: Callable[[Signal], None] | None = None

    def read(self) -> Value:
        facts = self._rig.signals(self._bus, (self._key,)).get(self._key)
        if facts is not None:
            value: Value = facts["value"]
            return value
        heard = {name for names in self._rig.interests(self._bus).values() for name in names or ()}
        if self._key in heard:
            return False  # a device listens to it, and nothing has been on it yet
        raise ControlError(
            f"{self._bus} has no signal {self._key!r}",
            closest(self._key, [*dict.fromkeys([*self._rig.signals(self._bus), *map(str, heard)])]),
        )

    def write(self, value: Value) -> None:
        if isinstance(value, str):
            raise ControlError(f"{self.name} cannot be a text", "expected a level or a number")
        if self._send is None:
            self._send = self._rig.attach(f"{MEMBER}:{self.name}").link(self._bus).send
        self._send(Signal(self._key, value))

    def listen(self, call: Callable[[Value], None]) -> End:
        rig = self._rig

        def heard(bus: object, delivery: object) -> None:
            message = getattr(delivery, "message", None)
            if bus is rig.buses[self._bus] and isinstance(message, Signal) and message.name == self._key:
                call(message.at(rig.now_ns))

        return rig.on_delivery(heard)


class ReadOnly:
    """A place that nothing writes."""

    name: str

    def write(self, value: Value) -> None:
        raise ControlError(f"{self.name} cannot be written", "expected a point of a device, or a signal of a bus")


class Traffic(ReadOnly):
    """Messages of a bus that are meant, from when it is made: whether one arrives now, their number, or their age."""

    def __init__(self, rig: "Rig", call: Call) -> None:
        from fieldrig_devices.scenarios.messages import Messages  # only those who ask for messages need their names

        self.name, self._rig, self._kind = str(call), rig, call.kind
        self._messages = Messages(rig.config, call.target, call.words)
        self._bus, self._count, self._last_ns = rig.buses[call.target], 0, rig.now_ns

    def read(self) -> Value:
        match self._kind:
            case "message":
                return False
            case "count":
                return self._count
        return (self._rig.now_ns - self._last_ns) / S

    def listen(self, call: Callable[[Value], None]) -> End:
        def heard(bus: object, delivery: Any) -> None:
            if bus is self._bus and self._messages.has(delivery.sender, delivery.message):
                self._count, self._last_ns = self._count + 1, self._rig.now_ns
                if self._kind == "message":
                    call(True)
                call(self.read())

        return self._rig.on_delivery(heard)


class Diagnosis(ReadOnly):
    """True while a device shows a diagnosis."""

    def __init__(self, rig: "Rig", call: Call) -> None:
        self.name, self._rig, self._device = str(call), rig, call.target
        known = rig.keys(call.target) if call.target in rig.config.devices else ()
        self._keys, self._shows = diagnosis_keys(rig.config, call.target, known), shows(call.number)

    def read(self) -> Value:
        return any(map(self._shows, self._rig.values(self._device, self._keys).values()))

    def listen(self, call: Callable[[Value], None]) -> End:
        """Call it with what the device shows: at a change of one point, the others are as they are."""

        def changed(value: Value) -> None:
            with suppress(ControlError):  # it has no power now
                call(self._shows(value) or self.read())

        ends = [self._rig.on_change(f"{self._device}/{key}", changed) for key in self._keys]

        def end() -> None:
            for each in ends:
                each()

        return end
