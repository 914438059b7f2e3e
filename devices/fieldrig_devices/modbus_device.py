"""`modbus.device`: a device made of register tables, reachable on any number of Modbus buses at once.

Source: Modbus application protocol V1.1b3; the answers are those of fieldrig_bus.modbus.server.  A request takes effect
when it arrives, its response leaves `turnaround_ms` later.  Each bus has its own communication counters and its own
listen only mode, as each port of a real device has.  What is marked `retained` in a table is in the non-volatile
memory before the response to the write leaves.
"""

import json
import logging
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from fieldrig.bus import Bus
from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Tool
from fieldrig.errors import ConfigError
from fieldrig.link import Link
from fieldrig.settings import Claim, ConfigFile, Settings
from fieldrig.store import Store
from fieldrig_bus.modbus.identification import Identification, ServerId
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_bus.wires import Signal
from fieldrig_devices.modbus_port import ModbusPort
from fieldrig_devices.modbus_tools import lines_for
from fieldrig_devices.modbus_unit import ModbusUnit
from fieldrig_devices.register_table import driven_wires, load_table
from fieldrig_devices.register_value import OutOfRange

log = logging.getLogger(__name__)

UnitId = Annotated[int, Field(ge=1, le=247, description="unit id (slave address)")]
Status = Annotated[int, Field(ge=0, le=0xFF)] | Annotated[list[str], Field(max_length=8)]


class UnitSettings(Settings):
    """One unit of several; what is left out here is as in the device."""

    table: ConfigFile
    identification: Identification | None = None
    server_id: ServerId | None = None
    exception_status: Status | None = None


class ModbusDeviceSettings(Settings):
    unit_id: UnitId = 1
    table: ConfigFile | None = None
    units: dict[UnitId, UnitSettings] | None = Field(
        default=None, min_length=1, description="several units, by their ids, in place of unit_id and table"
    )
    turnaround_ms: float = Field(default=2.0, ge=0, le=60_000, description="from a request to its response; 0: at once")
    out_of_range: OutOfRange = Field(
        default="server_failure",
        description="a write beyond min or max: exception 04, as the specification has it, or 03 (illegal_value), as "
        "many devices do, or the nearest value that is right (limit)",
    )
    identification: Identification = Field(default_factory=Identification, description="function 43/14")
    server_id: ServerId = Field(default_factory=ServerId, description="function 17")
    exception_status: Status = Field(
        default=0, description="function 7: a number, or the names of up to 8 bits, lowest first"
    )
    serial_functions_on_tcp: bool = Field(
        default=True, description="functions 7, 8 and 17, which belong to serial lines, are answered on TCP too"
    )

    @model_validator(mode="after")
    def _check_one_form(self) -> Self:
        if (self.table is None) == (self.units is None):
            raise ValueError("give either table (and unit_id) for one unit, or units for several")
        return self

    def claims(self, device: str) -> Iterator[Claim]:
        for unit_id, unit in self.by_unit().items():
            is_one = self.units is None
            yield Claim("modbus", "unit", unit_id, ("unit_id",) if is_one else ("units", unit_id))
            try:
                wires = driven_wires(load_table(unit.table))
            except ConfigError:
                continue  # told when the device is built, at its own lines
            for wire in wires:
                yield Claim("wires", "wire", wire, ("table",) if is_one else ("units", unit_id, "table"))

    def by_unit(self) -> dict[int, UnitSettings]:
        if self.units is not None:
            return dict(self.units)
        return {self.unit_id: UnitSettings.model_construct(table=self.table)}


class ModbusDevice(Device):
    about: ClassVar[str] = "a Modbus device made of register tables"

    def __init__(
        self,
        clock: Clock,
        settings: ModbusDeviceSettings,
        modbus: list[Link[ModbusRequest | ModbusResponse]],
        store: Store,
        wires: Link[Signal] | None = None,
    ) -> None:
        """ConfigError for a register table that is wrong, RigError for an exception status that it doesn't have."""
        turnaround_ns = round(settings.turnaround_ms * MS)
        self._store, self._wires = store, wires
        self.is_unsaved = False
        """Something that is retained has changed."""
        self._warned: set[str] = set()
        by_unit = settings.by_unit()
        self._units = {
            unit_id: ModbusUnit(
                load_table(unit.table),
                settings.out_of_range,
                settings.exception_status if unit.exception_status is None else unit.exception_status,
                self._drive,
                self._note_unsaved,
            )
            for unit_id, unit in by_unit.items()
        }
        self._restore()
        for link in modbus:
            servers = {
                unit_id: ModbusServer(
                    self._units[unit_id],
                    unit.identification or settings.identification,
                    unit.server_id or settings.server_id,
                    settings.serial_functions_on_tcp,
                )
                for unit_id, unit in by_unit.items()
            }
            port = ModbusPort(clock, link, servers, turnaround_ns, self.save)
            link.on_receive(port.on_message, list(servers))
        self._listen_to_wires()

    def start(self) -> None:
        for unit in self._units.values():
            unit.drive_all()

    def points(self) -> Mapping[str, Point]:
        if len(self._units) == 1:
            (unit,) = self._units.values()
            return self._saving(unit.points())
        by_unit = {unit_id: unit.points() for unit_id, unit in self._units.items()}
        return self._saving(
            {f"{unit_id}/{key}": point for unit_id in by_unit for key, point in by_unit[unit_id].items()}
        )

    @classmethod
    def tools(cls, name: str, settings: Any, links: Mapping[str, Any]) -> list[Tool]:
        buses: list[Bus[Any]] = []
        for joined in links.values():  # one bus, or the several of `modbus`
            buses += joined if isinstance(joined, list | tuple) else [joined]
        by_unit: dict[int, UnitSettings] = settings.by_unit()
        return [tool for unit_id, unit in by_unit.items() for tool in lines_for(load_table(unit.table), unit_id, buses)]

    def save(self) -> None:
        """Put what is retained into the store, if anything of it has changed."""
        if self.is_unsaved:
            kept = {str(unit_id): unit.retained() for unit_id, unit in self._units.items()}
            self._store.save(json.dumps(kept).encode())
            self.is_unsaved = False

    def _restore(self) -> None:
        data = self._store.load()
        if data is None:
            return
        try:
            for unit_id, kept in json.loads(data).items():
                unit = self._units.get(int(unit_id))
                if unit is not None:
                    unit.restore(kept)
        except (ValueError, AttributeError, TypeError) as fault:
            log.warning("the non-volatile memory can't be read, registers start anew: %s", fault)

    def _note_unsaved(self) -> None:
        self.is_unsaved = True

    def _saving(self, points: Mapping[str, Point]) -> dict[str, Point]:
        return {key: self._saving_point(point) for key, point in points.items()}

    def _saving_point(self, point: Point) -> Point:
        inner = point.write
        if inner is None:
            return point

        def write(value: bool | int | float | str) -> None:
            inner(value)
            self.save()

        return Point(point.read, write, point.unit, point.about)

    def _drive(self, signal: Signal) -> None:
        """A register may read back what another one drives: a bus does not tell a driver its own signal."""
        self._on_signal(signal)
        if self._wires is not None:
            self._wires.send(signal)

    def _listen_to_wires(self) -> None:
        self._listeners: dict[str, list[Any]] = {}
        for unit in self._units.values():
            for wire, hear in unit.listeners():
                self._listeners.setdefault(wire, []).append(hear)
        if self._wires is not None and self._listeners:
            self._wires.on_receive(self._on_signal, sorted(self._listeners))

    def _on_signal(self, signal: Signal) -> None:
        for hear in self._listeners.get(signal.name, ()):
            try:
                hear(signal)
            except ValueError as fault:
                if signal.name not in self._warned:
                    self._warned.add(signal.name)
                    log.warning("%s: not taken over: %s", signal.name, fault)
