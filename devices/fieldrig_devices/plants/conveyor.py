"""A conveyor: a belt that a drive moves, products that a feeder puts on it, light barriers, and a discharge.

The belt follows the wire with the position of its driven roller without slip.  While that wire is a motion, every edge
of a light barrier falls at the nanosecond at which the product reaches it.  Left out: the stretch of the belt, and
products that push each other; one that slips lets the others pass.
"""

from collections.abc import Mapping
from functools import partial
from math import isfinite
from typing import Any, ClassVar, Final

from fieldrig.clock import Alarm, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.points.checks import truth_in
from fieldrig_bus.wires import Signal
from fieldrig_devices.plants import front
from fieldrig_devices.plants.conveyor_model import Belt
from fieldrig_devices.plants.conveyor_settings import MODELS, ConveyorSettings, Dirty, Slip
from fieldrig_devices.plants.driven import next_instant

LONGEST_WAY_M: Final = 1e6
"""Limit for the way of the belt, which stops there."""


class Conveyor(Device):
    """A conveyor as a device of a rig."""

    about = "a conveyor: belt, products, feeder and light barriers (a plant, on wires)"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, name: str, settings: ConveyorSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        places = [sensor.at_m for sensor in settings.sensors.values()]
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults, check=self._check
        )
        self._belt = Belt(settings.length_m, settings.product_m, places, settings.pitch_m, self._grip)
        self._sensor_wires = {sensor: settings.wire_of(name, sensor) for sensor in settings.sensors}
        self._discharge_wire = settings.wire_for(name, "discharge")
        self._feed_wire = settings.wire_for(name, "feed")
        self._drive: Signal | None = None
        self._origin_m = 0.0
        """Position of the roller's wire at which the belt began."""
        self._is_feeding = False
        self._published: dict[str, bool | int] = {}
        self._timer = Alarm(self._clock)
        wires.on_receive(self._on_signal, (settings.drive_wire, self._feed_wire))

    def start(self) -> None:
        self._publish()

    def front(self) -> Front:
        settings = self._settings
        places = {name: sensor.at_m for name, sensor in settings.sensors.items()}
        return front.conveyor(settings.length_m, settings.product_m, places)

    def points(self) -> Mapping[str, Point]:
        belt = self._belt
        sensors = {
            name: Point(partial(self._shows, name), None, "", "light barrier; true while a product covers it")
            for name in self._settings.sensors
        }
        return sensors | {
            "position": Point(self._place, None, "m", "way of the belt since the start"),
            "speed": Point(self._speed, None, "m/s", "of the belt"),
            "products": Point(lambda: len(belt.products), None, "", "number of products on the belt"),
            "fronts": Point(self._fronts, None, "m", "positions of the products' fronts, the first product first"),
            "fed": Point(lambda: belt.fed, None, "", "number of products that were put on the belt"),
            "refused": Point(lambda: belt.refused, None, "", "number of products for which there was no room"),
            "discharged": Point(lambda: belt.discharged, None, "", "number of products that left at the end"),
            "lost": Point(lambda: belt.lost, None, "", "number of products that fell off at the feed end"),
            "feed": Point(lambda: self._is_feeding, self._write_feed, "", "write true to put a product on the belt"),
        }

    # ---- the belt's motion

    def _place(self) -> float:
        """The way of the belt at this instant."""
        drive = self._drive
        if drive is None:
            return 0.0
        way_m = float(drive.at(self._clock.now_ns())) * self._settings.roller_radius_m
        return min(max(way_m, -LONGEST_WAY_M), LONGEST_WAY_M) - self._origin_m

    def _speed(self) -> float:
        return (
            0.0 if self._drive is None else self._drive.speed_at(self._clock.now_ns()) * self._settings.roller_radius_m
        )

    def _fronts(self) -> str:
        belt, way_m = self._belt, self._place() - self._belt.place_m
        fronts = (product.rear_m + belt.product_m + way_m * product.grip for product in belt.products)
        return ", ".join(f"{front:.4f}" for front in fronts)

    def _on_signal(self, signal: Signal) -> None:
        if not isfinite(signal.value):
            return
        if signal.name == self._feed_wire:
            is_feeding, before = bool(signal.value), self._is_feeding
            self._is_feeding = is_feeding
            if is_feeding and not before:
                self._feed()
            return
        if self._drive is None:
            self._drive = signal
            self._origin_m = self._place()
        self._belt.move_to(self._place())
        self._drive = signal
        self._look()

    def _on_timer(self) -> None:
        self._look()

    def _look(self) -> None:
        """Bring the belt to the present, and wait for the next change."""
        self._belt.move_to(self._place())
        self._publish()
        self._wait()

    def _wait(self) -> None:
        self._timer.stop()
        drive, now_ns, radius_m = self._drive, self._clock.now_ns(), self._settings.roller_radius_m
        if drive is None or not drive.is_moving or abs(drive.at(now_ns)) * radius_m >= LONGEST_WAY_M:
            return
        when_ns = next_instant(drive, now_ns, self._belt.way_to_change, radius_m)
        if when_ns is not None:
            self._timer.at(when_ns, self._on_timer)

    # ---- products, sensors, faults

    def _feed(self) -> None:
        self._belt.move_to(self._place())
        self._belt.feed()
        self._look()

    def _write_feed(self, value: Value) -> None:
        if truth_in(value):
            if not self._belt_has_room():
                raise ValueError("expected room for a product at the feed end, but another one is there")
            self._feed()

    def _belt_has_room(self) -> bool:
        self._belt.move_to(self._place())
        return self._belt.has_room()

    def _shows(self, sensor: str) -> bool:
        for fault in self._faults.active(Dirty):
            if fault.sensor == sensor:
                return fault.shows
        return self._belt.is_covered(self._settings.sensors[sensor].at_m)

    def _grip(self, number: int) -> float:
        slips = (fault.percent for fault in self._faults.active(Slip) if fault.product in (None, number))
        return 1 - max(slips, default=0.0) / 100

    def _check(self, fault: Any) -> None:
        if isinstance(fault, Dirty) and fault.sensor not in self._settings.sensors:
            known = ", ".join(self._settings.sensors) or "none"
            raise ValueError(f"there is no sensor {fault.sensor}\nexpected one of: {known}")

    def _on_faults(self) -> None:
        self._belt.move_to(self._place())
        self._belt.grip_again()
        self._look()

    def _publish(self) -> None:
        for sensor, wire in self._sensor_wires.items():
            self._drive_wire(wire, self._shows(sensor))
        self._drive_wire(self._discharge_wire, self._belt.discharged)

    def _drive_wire(self, wire: str, value: bool | int) -> None:
        if self._published.get(wire) != value:
            self._published[wire] = value
            self._wires.send(Signal(wire, value))
