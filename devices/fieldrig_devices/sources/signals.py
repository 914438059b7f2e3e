"""`plant.signals`: wires whose values live by themselves, such as the weather, a door, or a reading."""

from collections.abc import Iterator, Mapping
from functools import partial

from pydantic import Field

from fieldrig import front
from fieldrig.clock import Clock
from fieldrig.device import Device, Point
from fieldrig.link import Link
from fieldrig.settings import Claim, Settings
from fieldrig_bus.wires import Signal
from fieldrig_devices.sources.living import Chance, Living, LivingValues, seed_from
from fieldrig_devices.sources.settings import SourceSettings
from fieldrig_devices.sources.shapes import Number, is_on


class WireSettings(Settings):
    """One wire and its value."""

    source: SourceSettings = Field(description="a value that lives by itself")
    unit: str = Field(default="", description="unit of the signal (SI or %)")
    digital: bool = Field(default=False, description="the wire is true or false: true from 0.5 on")
    about: str = Field(default="", description="description for people")


class SignalsSettings(Settings):
    """The wires of one device."""

    signals: dict[str, WireSettings] = Field(min_length=1, description="values by the names of their wires")

    def claims(self, device: str) -> Iterator[Claim]:
        for wire in self.signals:
            yield Claim("wires", "wire", wire, ("signals", wire))


class Signals(Device):
    """Each value is sent at the instant of its change."""

    about = "signals that live by themselves: sine, ramp, counter, recording and others (a plant, on wires)"
    no_faults = "its values are wires, and faults of their bus make them wrong"

    def __init__(self, clock: Clock, settings: SignalsSettings, wires: Link[Signal], random: Chance) -> None:
        seed = seed_from(random)
        self._settings, self._wires = settings, wires
        self._sent: dict[str, Number] = {}
        self._living = LivingValues(
            clock,
            [
                Living(wire.source.begin(seed + name), partial(self._put, name))
                for name, wire in settings.signals.items()
            ],
        )

    def start(self) -> None:
        self._sent.clear()
        self._living.start()
        self._living.follow()

    def front(self) -> front.Front:
        wires = self._settings.signals.items()
        parts = [(front.Led if wire.digital else front.Number)(name, name, wire.about) for name, wire in wires]
        return front.Front(front.Plate("", "signals"), [front.Group(parts, "wires")])

    def points(self) -> Mapping[str, Point]:
        return {
            name: Point(partial(self._present, name), None, wire.unit, wire.about)
            for name, wire in self._settings.signals.items()
        }

    def _present(self, name: str) -> Number:
        self._living.refresh()
        return self._sent[name]

    def _put(self, name: str, value: Number) -> None:
        wire = self._settings.signals[name]
        if wire.digital:
            value = is_on(value)
        if self._sent.get(name) != value:
            self._sent[name] = value
            self._wires.send(Signal(name, value, wire.unit))
