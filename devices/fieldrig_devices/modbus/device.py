"""`modbus.device`: a device made of register tables, reachable on any number of Modbus buses at once.

Source: Modbus application protocol V1.1b3; the answers are those of fieldrig_bus.modbus.server.  A request takes effect
when it arrives; its response leaves `turnaround_ms` later, or after the next time of the file `answer_times`.  Each bus
has its own communication counters and its own listen-only mode, as each port of a real device has.  A value that is
marked `retained` in a table is stored before its write takes effect; a write that cannot be stored is answered with
exception 04 and changes nothing.
"""

import json
import logging
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import AfterValidator, Field, field_validator, model_validator

from fieldrig.bus import Bus
from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Tool
from fieldrig.errors import ConfigError
from fieldrig.faults.faults import Fault, Faults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.outside.untrusted import field, read_json, typed
from fieldrig.settings import Claim, ConfigFile, Settings
from fieldrig.storage import store_format
from fieldrig.storage.store import Store, restore
from fieldrig_bus.modbus.identification import Identification, ServerId
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_bus.wires import Signal
from fieldrig_devices.modbus.answer_times import AnswerTimes, read_answer_times
from fieldrig_devices.modbus.faults import MODELS, ModbusDeviceFaults, Refusing, Slow
from fieldrig_devices.modbus.front import front_of
from fieldrig_devices.modbus.port import ModbusPort, Turnaround, TurnaroundSettings, UnitId
from fieldrig_devices.modbus.tools import lines_for
from fieldrig_devices.modbus.unit import ModbusUnit
from fieldrig_devices.registers.described import DescribedUnit
from fieldrig_devices.registers.table import driven_wires, load_table
from fieldrig_devices.registers.value import OutOfRange
from fieldrig_devices.sources.living import LivingValues, seed_from

log = logging.getLogger(__name__)

Hear = Callable[[Signal], None]

Status = Annotated[int, Field(ge=0, le=0xFF)] | Annotated[list[str], Field(max_length=8)]


def _unit_range(text: str) -> str:
    first, last = map(int, text.split("-"))
    if not 1 <= first < last <= 247:
        raise ValueError(f"expected a range of unit ids from 1 to 247 that rises, such as 10-25, got {text}")
    return text


UnitRange = Annotated[str, Field(pattern=r"^[0-9]{1,3}-[0-9]{1,3}$", examples=["10-25"]), AfterValidator(_unit_range)]
"""Several units that have one table, each with values of its own."""


class UnitSettings(Settings):
    """One of several units; settings that are omitted are those of the device."""

    table: ConfigFile
    identification: Identification | None = None
    server_id: ServerId | None = None
    exception_status: Status | None = None


class ModbusDeviceSettings(TurnaroundSettings):
    answer_times: ConfigFile | None = Field(
        default=None,
        description="CSV file with the times of single answers, which the device takes in turn; default: turnaround_ms",
    )
    unit_id: UnitId | UnitRange = 1
    table: ConfigFile | None = None
    units: dict[UnitId | UnitRange, UnitSettings] | None = Field(
        default=None, min_length=1, description="several units by their ids or ranges, instead of unit_id and table"
    )
    out_of_range: OutOfRange = Field(
        default="server_failure",
        description="response to a write beyond min or max: exception 04 as in the specification, 03 (illegal_value) "
        "as in many devices, or the nearest value within them (limit)",
    )
    identification: Identification = Field(default_factory=Identification, description="function 43/14")
    server_id: ServerId = Field(default_factory=ServerId, description="function 17")
    exception_status: Status = Field(
        default=0, description="function 7: a number, or the names of up to 8 bits, lowest first"
    )
    serial_functions_on_tcp: bool = Field(
        default=True, description="whether functions 7, 8 and 17, which belong to serial lines, are answered on TCP too"
    )

    @field_validator("answer_times")
    @classmethod
    def _can_be_read(cls, file: Path | None) -> Path | None:
        if file is None:
            return None
        try:
            read_answer_times(file)
        except ValueError as cause:
            raise ValueError(f"{file.name}: {cause}") from cause
        return file

    @model_validator(mode="after")
    def _check_one_form(self) -> Self:
        if (self.table is None) == (self.units is None):
            raise ValueError("expected either table (and unit_id) for one unit, or units for several units")
        seen: dict[int, UnitId | UnitRange] = {}
        for key in self.units or {}:
            for unit_id in ids_in(key):
                if seen.setdefault(unit_id, key) != key:
                    raise ValueError(f"units: unit {unit_id} is in {seen[unit_id]} and in {key}; expected it once")
        return self

    def claims(self, device: str) -> Iterator[Claim]:
        if self.units is None:
            yield from _claims(self.unit_id, UnitSettings.model_construct(table=self.table), ("unit_id",), ("table",))
            return
        for key, unit in self.units.items():
            yield from _claims(key, unit, ("units", key), ("units", key, "table"))

    def register_tables(self) -> Iterator[DescribedUnit]:
        for unit_id, unit in self.by_unit().items():
            yield DescribedUnit(unit_id, unit.table)

    def by_unit(self) -> dict[int, UnitSettings]:
        if self.units is None:
            unit = UnitSettings.model_construct(table=self.table)
            return dict.fromkeys(ids_in(self.unit_id), unit)
        return {unit_id: unit for key, unit in self.units.items() for unit_id in ids_in(key)}


def _answer_times(settings: ModbusDeviceSettings) -> Turnaround:
    usual_ns = settings.turnaround_ns
    return (
        usual_ns
        if settings.answer_times is None
        else AnswerTimes(read_answer_times(settings.answer_times), usual_ns).next
    )


def ids_in(key: UnitId | UnitRange) -> Iterable[int]:
    """The unit ids of a range such as `10-25`, or the single one."""
    if isinstance(key, int):
        return (key,)
    first, last = map(int, key.split("-"))
    return range(first, last + 1)


def _claims(
    key: UnitId | UnitRange, unit: UnitSettings, path: tuple[str | int, ...], table: tuple[str | int, ...]
) -> Iterator[Claim]:
    for unit_id in ids_in(key):
        yield Claim("modbus", "unit", unit_id, path)
        try:
            wires = driven_wires(load_table(unit.table))
        except ConfigError:
            return  # building the device reports the mistakes with their lines
        for wire in wires:
            yield Claim("wires", "wire", wire, table)


class ModbusDevice(Device):
    about: ClassVar[str] = "a Modbus device made of register tables"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        settings: ModbusDeviceSettings,
        modbus: list[Link[ModbusRequest | ModbusResponse]],
        store: Store,
        wires: Link[Signal] | None = None,
        random: Any = None,
    ) -> None:
        """ConfigError for a register table with mistakes, RigError for an exception status that names unknown bits."""
        self._clock, self._store, self._wires = clock, store, wires
        self._identification = settings.identification
        self.faults_of_requests = ModbusDeviceFaults(clock, MODELS, Faults(Fault, random))
        self.injected = self.faults_of_requests
        self._moving: dict[str, Signal] = {}
        """Moving signals by wire; the registers that show them are updated before each read."""
        self._warned: set[str] = set()
        by_unit = settings.by_unit()
        self._units = {
            unit_id: ModbusUnit(
                load_table(unit.table),
                settings.out_of_range,
                settings.exception_status if unit.exception_status is None else unit.exception_status,
                self._drive,
                self._keep,
            )
            for unit_id, unit in by_unit.items()
        }
        seed = seed_from(random)
        self._living = LivingValues(
            clock, [living for unit_id, unit in self._units.items() for living in unit.living(f"{seed}{unit_id}/")]
        )
        self._rescaled = [unit for unit in self._units.values() if unit.is_rescaled]
        """The units with living values whose scale is the value of another register: most have none."""
        self._restore()
        takes = _answer_times(settings)
        for link in modbus:
            servers = {
                unit_id: ModbusServer(
                    self._units[unit_id],
                    unit.identification or settings.identification,
                    unit.server_id or settings.server_id,
                    settings.serial_functions_on_tcp,
                    self._units[unit_id].files,
                )
                for unit_id, unit in by_unit.items()
            }
            port = ModbusPort(clock, link, servers, takes)
            link.on_receive(partial(self._on_request, port), list(servers))
        self._listen_to_wires()

    def start(self) -> None:
        self._living.start()
        for unit in self._units.values():
            unit.drive_all()

    def front(self) -> Front:
        return front_of(self.points(), self._identification, list(self._units))

    def points(self) -> Mapping[str, Point]:
        return self._points

    @cached_property
    def _points(self) -> Mapping[str, Point]:
        """They are the same as long as the device has power, and a search reads them each millisecond."""
        if len(self._units) == 1:
            (unit,) = self._units.values()
            return self._present(unit.points())
        by_unit = {unit_id: unit.points() for unit_id, unit in self._units.items()}
        return self._present(
            {f"{unit_id}/{key}": point for unit_id in by_unit for key, point in by_unit[unit_id].items()}
        )

    @classmethod
    def tools(cls, name: str, settings: Any, links: Mapping[str, Any]) -> list[Tool]:
        buses: list[Bus[Any]] = []
        for joined in links.values():  # a bus, or the list of `modbus`
            buses += joined if isinstance(joined, list | tuple) else [joined]
        firsts: dict[Any, int] = {}  # units with one table are read by the same lines
        for unit_id, unit in settings.by_unit().items():
            firsts.setdefault(unit.table, unit_id)
        tools = {unit_id: lines_for(load_table(table), unit_id, buses) for table, unit_id in firsts.items()}
        if len(tools) == 1:
            return [tool for lines in tools.values() for tool in lines]
        return [Tool(f"{tool.label}, unit {unit_id}", tool.line) for unit_id, lines in tools.items() for tool in lines]

    def _keep(self) -> None:
        """Store the retained values.  StoreError if that fails."""
        kept = {
            str(unit_id): {name: raw.hex() for name, raw in unit.retained.items()}
            for unit_id, unit in self._units.items()
        }
        self._store.save(json.dumps(kept).encode())

    def _restore(self) -> None:
        content = restore(self._store, self._decode).content
        for unit_id, kept in (content or {}).items():
            self._units[unit_id].restore(kept)

    def _decode(self, data: bytes) -> dict[int, dict[str, bytes]]:
        """Raw values by unit and name.  ValueError for values beyond limits, or data not of `_keep`."""
        kept = typed(read_json(data, store_format.LONGEST), dict)
        return {
            unit_id: unit.usable(
                {name: bytes.fromhex(typed(raw, str, name)) for name, raw in field(kept, str(unit_id), dict).items()}
            )
            for unit_id, unit in self._units.items()
            if str(unit_id) in kept
        }

    def _present(self, points: Mapping[str, Point]) -> dict[str, Point]:
        return {key: self._present_point(point) for key, point in points.items()}

    def _present_point(self, point: Point) -> Point:
        """A point that shows the value at the instant of reading."""

        def read() -> bool | int | float | str:
            self._follow()
            return point.read()

        return replace(point, read=read)

    def _on_request(self, port: ModbusPort, message: ModbusRequest | ModbusResponse) -> None:
        if not isinstance(message, ModbusRequest) or not self._is_faulty:
            self._do(port, message)
            return
        match self.faults_of_requests.of(message):
            case None:
                self._do(port, message)
            case Slow(delay_ms=delay_ms):
                self._clock.call_at(self._clock.now_ns() + round(delay_ms * MS), partial(self._do, port, message))
            case Refusing(code=code):
                pdu = bytes((message.pdu[0] | 0x80, code))
                port.respond(message, lambda request: pdu)

    @property
    def _is_faulty(self) -> bool:
        return self.faults_of_requests.given > 0

    def _do(self, port: ModbusPort, message: ModbusRequest | ModbusResponse) -> None:
        self._follow()
        port.on_message(message)

    def _follow(self) -> None:
        """Update the registers that show moving signals, and those that live by themselves."""
        self._living.refresh()
        if self._moving:
            now_ns = self._clock.now_ns()
            for wire, signal in self._moving.items():
                self._hear(self._listeners[wire], Signal(wire, signal.at(now_ns), signal.unit))
        for unit in self._rescaled:
            unit.rescale()

    def _drive(self, signal: Signal) -> None:
        """Send a signal, also to the registers of this device, because a bus does not return a signal to its sender."""
        self._on_signal(signal)
        if self._wires is not None:
            self._wires.send(signal)

    def _listen_to_wires(self) -> None:
        self._listeners: defaultdict[str, list[Hear]] = defaultdict(list)
        self._collectors: defaultdict[str, list[Hear]] = defaultdict(list)
        for unit in self._units.values():
            for wire, hear in unit.listeners():
                self._listeners[wire].append(hear)
            for wire, hear in unit.collectors():
                self._collectors[wire].append(hear)
        wires = {*self._listeners, *self._collectors}
        if self._wires is not None and wires:
            self._wires.on_receive(self._on_signal, sorted(wires))

    def _on_signal(self, signal: Signal) -> None:
        name, value = signal.name, signal.at(self._clock.now_ns())
        self._moving.pop(name, None)
        if signal.is_moving and name in self._listeners:
            self._moving[name] = signal
        self._hear((*self._listeners.get(name, ()), *self._collectors.get(name, ())), Signal(name, value, signal.unit))

    def _hear(self, hearers: Iterable[Hear], signal: Signal) -> None:
        for hear in hearers:
            try:
                hear(signal)
            except ValueError as fault:
                if signal.name not in self._warned:
                    self._warned.add(signal.name)
                    log.warning("%s: the signal is ignored: %s", signal.name, fault)
