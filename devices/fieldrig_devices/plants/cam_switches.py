"""Switches that a shaft or a slide actuates, such as the zero switch of a knife; they follow its position on a wire.

While that wire is a motion, every edge falls at the nanosecond at which the position reaches it.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from math import inf, isfinite
from typing import Self

from pydantic import Field, model_validator

from fieldrig.clock import Alarm, Clock
from fieldrig.device import Device, Point
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.settings import Claim
from fieldrig_bus.wires import Signal
from fieldrig_devices.plants import front
from fieldrig_devices.plants.driven import next_instant
from fieldrig_devices.plants.settings import PlantSettings
from fieldrig_devices.plants.switches import Switch


class CamSettings(PlantSettings):
    """The part of the way on which a switch is closed."""

    low: float = Field(description="position from which the switch is closed, in the unit of the wire")
    high: float = Field(description="position at which it opens")
    every: float | None = Field(default=None, gt=0, description="period of the cam, such as a turn; default: none")
    wire: str | None = Field(default=None, description="output: digital; default: NAME.SWITCH")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if not self.low < self.high < self.low + (self.every or inf):
            raise ValueError("high: expected more than low, and less than a period behind it")
        return self


class CamSwitchesSettings(PlantSettings):
    """The switches along one position."""

    position_wire: str = Field(description="input: position of the shaft or slide")
    switches: dict[str, CamSettings] = Field(min_length=1, description="switches by name")

    def wire_of(self, device: str, switch: str) -> str:
        return self.switches[switch].wire or f"{device}.{switch}"

    def claims(self, device: str) -> Iterator[Claim]:
        for name in self.switches:
            yield Claim("wires", "wire", self.wire_of(device, name), ("switches", name))


class CamSwitches(Device):
    """The switches as a device of a rig."""

    about = "switches that a shaft or a slide actuates (a plant, on wires)"
    no_faults = "its switches are wires, which are stuck, bounce and drop out by faults of their bus"

    def __init__(self, clock: Clock, name: str, settings: CamSwitchesSettings, wires: Link[Signal]) -> None:
        self._clock, self._wires = clock, wires
        self._switches = {
            switch: Switch(settings.wire_of(name, switch), cam.low, cam.high, cam.every or inf)
            for switch, cam in settings.switches.items()
        }
        self._drive = Signal(settings.position_wire, 0.0)
        self._closed: dict[str, bool] = {}
        self._timer = Alarm(self._clock)
        wires.on_receive(self._on_signal, (settings.position_wire,))

    def start(self) -> None:
        self._look()

    def front(self) -> Front:
        return front.cam_switches(self._switches)

    def points(self) -> Mapping[str, Point]:
        return {name: Point(partial(self._is_closed, switch)) for name, switch in self._switches.items()} | {
            "position": Point(self._position, about="position of the shaft or slide, in the unit of its wire")
        }

    def _position(self) -> float:
        return float(self._drive.at(self._clock.now_ns()))

    def _is_closed(self, switch: Switch) -> bool:
        return switch.is_closed(self._position())

    def _on_signal(self, signal: Signal) -> None:
        if isfinite(signal.value):
            self._drive = signal
            self._look()

    def _look(self) -> None:
        """Publish the switches that have changed, and wait for the next one."""
        for switch in self._switches.values():
            is_closed = self._is_closed(switch)
            if self._closed.get(switch.wire) is not is_closed:
                self._closed[switch.wire] = is_closed
                self._wires.send(Signal(switch.wire, is_closed))
        self._timer.stop()
        when_ns = next_instant(self._drive, self._clock.now_ns(), self._way) if self._drive.is_moving else None
        self._timer.at(when_ns, self._look)

    def _way(self, side: int) -> float:
        """Return the way to the next edge in this direction."""
        position = self._position()
        return min(abs(switch.next_change(position, side) - position) for switch in self._switches.values())
