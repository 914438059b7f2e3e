"""The places of a rig in virtual time that a scenario reads and writes, by their names."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.link import Link
from fieldrig.points.names import split_point
from fieldrig_devices.scenarios.calls import is_of_an_arrival
from fieldrig_devices.scenarios.places import MEMBER, DevicePoint, End, RigPlace, place_of
from fieldrig_devices.scenarios.sending import message_of

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig


class Followed:
    """Reads, writes and listens, and sends messages as a member of the buses."""

    def __init__(self, rig: "Rig", on_change: Callable[[str, Value], None], keep: Callable[[End], object]) -> None:
        """`on_change` is called with each change of a place, and `keep` with what ends the listening."""
        self._rig, self._on_change, self._keep = rig, on_change, keep
        self._places: dict[str, RigPlace] = {}
        self._read: dict[str, None] = {}
        self._groups: dict[str, dict[str, str]] = {}
        self._grouped = 0
        """The number of places that are read which the groups have."""
        self._links: dict[str, Link[Any]] = {}

    def add(self, name: str, *, is_read: bool) -> Value | None:
        """Follow a place, and return its value; None if it is followed.  RigError if the rig does not have it.

        With `is_read` it is one of those that are read at the end of each instant.
        """
        if is_read:
            self._read[name] = None
        if name in self._places:
            return None
        place = place_of(self._rig, name)
        value = place.read()
        self._places[name] = place
        with suppress(ControlError):  # its device has no power now
            self._keep(place.listen(lambda changed: self._on_change(name, changed)))
        return value

    def add_all(self, names: Iterable[str]) -> dict[str, Value]:
        """Follow places that are read at the end of each instant, and return their values."""
        in_order = sorted(dict.fromkeys(names), key=is_of_an_arrival)
        added = {name: self.add(name, is_read=True) for name in in_order}
        return {name: value for name, value in added.items() if value is not None}

    def read(self, name: str) -> Value:
        return self._places[name].read()

    def write(self, name: str, value: Value) -> None:
        self._places[name].write(value)

    def read_all(self) -> Mapping[str, Value]:
        """Return the present values; a device without power has none."""
        values: dict[str, Value] = {}
        for device, names in self._of_devices().items():
            values |= self._values_of(device, names)
        for name in self._read:
            if name not in values and not isinstance(self._places[name], DevicePoint):
                try:  # a block of `suppress` takes as long as the reading, several thousand times a second
                    values[name] = self._places[name].read()
                except ControlError:
                    continue
        return values

    def _of_devices(self) -> Mapping[str, Mapping[str, str]]:
        """Return the points to be read, with the names of their places, by device."""
        if len(self._read) != self._grouped:
            self._grouped, self._groups = len(self._read), {}
            for name in self._read:
                if isinstance(self._places[name], DevicePoint):
                    device, key = split_point(name)
                    self._groups.setdefault(device, {})[key] = name
        return self._groups

    def _values_of(self, device: str, names: Mapping[str, str]) -> Mapping[str, Value]:
        """Return values of a device by the names of their places.  One question is much faster than one for each."""
        try:
            found = self._rig.values(device, names)
        except ControlError:  # it has no power, or a point of its program is not there at present
            found = {}
            for key, name in names.items():
                with suppress(ControlError):
                    found[key] = self._places[name].read()
        return {names[key]: value for key, value in found.items()}

    def send(self, bus: str, text: str) -> None:
        """Send a message.  ControlError for an unknown bus, and for a text that is none."""
        self._rig.statistics(bus)  # which names the buses that there are, if this is none
        message = message_of(self._rig.buses[bus], text)
        if bus not in self._links:
            self._links[bus] = self._rig.attach(f"{MEMBER}:{bus}").link(bus)
        self._links[bus].send(message)
