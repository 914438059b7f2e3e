"""A CANopen node from an EDS or DCF file.

Source: CiA 301 version 4.2, CiA 305 (LSS), CiA 306-1, and CiA 401 for devices of that profile.  Left out: the functions
of a master and the SDO client.

This file assembles the services; each has a file of its own and knows only its parameters and the port.
"""

from collections.abc import Callable, Collection, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import Any, ClassVar

from fieldrig.bus import Bus
from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Tool, Value
from fieldrig.errors import RigError
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen.bit_timing import BIT_RATES
from fieldrig_devices.canopen.bus_errors import BusErrors
from fieldrig_devices.canopen.cia401 import Cia401
from fieldrig_devices.canopen.datatypes import DOMAIN
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds.source import EdsSource
from fieldrig_devices.canopen.eds.writer import write_dcf
from fieldrig_devices.canopen.emcy import Emcy
from fieldrig_devices.canopen.emcy_consumer import EmcyConsumer
from fieldrig_devices.canopen.emergencies import Emergencies
from fieldrig_devices.canopen.error_behaviour import ErrorBehaviour
from fieldrig_devices.canopen.front import front_of
from fieldrig_devices.canopen.guarding import NodeGuarding
from fieldrig_devices.canopen.heartbeat import HeartbeatConsumer, HeartbeatProducer
from fieldrig_devices.canopen.io_names import PROFILE as IO_MODULES
from fieldrig_devices.canopen.living import LivingObjects
from fieldrig_devices.canopen.lss import LssSlave
from fieldrig_devices.canopen.nmt import NmtSlave
from fieldrig_devices.canopen.node_faults import MODELS, FaultyEnd, NodeFaults
from fieldrig_devices.canopen.node_settings import CanopenSettings
from fieldrig_devices.canopen.node_tools import lines
from fieldrig_devices.canopen.nonvolatile import NonVolatile
from fieldrig_devices.canopen.parameters import Parameters
from fieldrig_devices.canopen.pdo import rpdo, tpdo
from fieldrig_devices.canopen.pdo.rpdo import Rpdo
from fieldrig_devices.canopen.pdo.tpdo import Tpdo
from fieldrig_devices.canopen.port import UNCONFIGURED, Port
from fieldrig_devices.canopen.sdo import server as sdo_server
from fieldrig_devices.canopen.sdo.server import SdoServer
from fieldrig_devices.canopen.service import Reset, Service, State
from fieldrig_devices.canopen.signals import Binding, WireSignals, bind
from fieldrig_devices.canopen.standard import STORED_EDS
from fieldrig_devices.canopen.sync import Sync
from fieldrig_devices.canopen.time_of_day import TimeOfDay
from fieldrig_devices.canopen.variable import Variable

__all__ = ["CanopenNode", "CanopenSettings"]

DEVICE_TYPE = 0x1000
LAST_OF_COMMUNICATION, LAST = 0x1FFF, 0xFFFF


class CanopenNode(Device):
    about = "a CANopen node (CiA 301) made from an EDS or DCF file"
    trouble_keys: ClassVar[Collection[str]] = ("emcy.code", "emcy.heard")
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        name: str,
        can: Link[CanFrame],
        settings: CanopenSettings,
        store: Store,
        wires: Link[Signal] | None = None,
        random: Any = None,
    ) -> None:
        self.name = name
        self._settings = settings
        self.dictionary = settings.dictionary()
        kept = NonVolatile(store, settings.node_id)
        self._parameters = Parameters(self.dictionary, kept)
        _offer_eds(self.dictionary, settings.eds)
        self._port = Port(can, settings.node_id or UNCONFIGURED)
        self._profile = Cia401(self.dictionary) if _profile(self.dictionary) == IO_MODULES else None
        bindings = bind(self.dictionary, settings.signals)
        self._driven = {
            (one.variable.index, one.variable.subindex, one.bit): one.settings.wire
            for one in bindings
            if not one.is_output
        }
        self._signals = self._make_signals(clock, wires, bindings)
        self._living = LivingObjects(
            clock, self.dictionary, settings.sources, {} if self._profile is None else self._profile.terminals, random
        )
        self.nmt = NmtSlave(clock, self._port, self.dictionary, self._restart, self._enter, settings.boot_up_ns)
        self.emcy = Emcy(clock, self._port, self.dictionary)
        self._time = TimeOfDay(clock, self._port, self.dictionary, settings.time_period_ms * MS)
        self._heard = EmcyConsumer(self._port, self.dictionary)
        self._lss = LssSlave(
            clock,
            self._port,
            self.dictionary,
            kept,
            settings.node_id or UNCONFIGURED,
            lambda: self.nmt.boot(Reset.COMMUNICATION),
        )
        self._tpdos: list[Tpdo] = []
        self._watched: list[tuple[Variable, Callable[[], bytes]]] | None = None
        """Cache of `watched`; None after a change."""
        self._services = self._make_services(clock, settings)
        self._clock = clock
        self.injected = InjectedFaults[Fault[Any]](clock, MODELS, Faults(Fault, random))
        self.take_faults(self.injected)

    def start(self) -> None:
        if self._signals is not None:
            self._signals.start()
        self.nmt.boot(Reset.NODE)

    def power_off(self) -> None:
        """Neither send nor receive until the next `start`."""
        self._living.stop()
        self.nmt.power_off()

    def front(self) -> Front:
        return front_of(self.dictionary, _profile(self.dictionary), self._driven)

    def points(self) -> Mapping[str, Point]:
        return self._points

    @cached_property
    def _points(self) -> Mapping[str, Point]:
        """Made when they are asked for: a controller's node has 2,300 of them."""
        return _points(self.dictionary) | self._own_points()

    def _make_signals(self, clock: Clock, wires: Link[Signal] | None, bindings: list[Binding]) -> WireSignals | None:
        if wires is None:
            if bindings:
                raise RigError(f"{self.name} has signals but no wires", "name a bus of wires under its links")
            return None
        return WireSignals(clock, wires, bindings, {} if self._profile is None else self._profile.terminals)

    def _make_services(self, clock: Clock, settings: CanopenSettings) -> list[Service]:
        """Create the services in the order in which they are reset and enter a state."""
        port, dictionary = self._port, self.dictionary
        sync = Sync(clock, port, dictionary, self.emcy)
        behaviour = ErrorBehaviour(dictionary, self.emcy, self.nmt, self._on_communication_error)
        self.bus_errors = BusErrors(port, self.emcy, behaviour.on_bus_off)
        services: list[Service] = [self.nmt, self.emcy, behaviour]
        services.append(self.bus_errors)
        services += [self._lss] if dictionary.features.has_lss else []
        services += [service for service in (self._profile, self._signals) if service is not None]
        services += [
            SdoServer(clock, port, dictionary, index, settings.sdo_timeout_ms * MS, settings.sdo_block_size)
            for index in sorted(
                {sdo_server.FIRST_SERVER, *dictionary.indices(sdo_server.FIRST_SERVER, sdo_server.LAST_SERVER)}
            )
        ]
        services += [
            HeartbeatProducer(clock, port, dictionary),
            HeartbeatConsumer(clock, port, dictionary, partial(behaviour.on_lost, "heartbeat")),
            NodeGuarding(clock, port, dictionary, partial(behaviour.on_lost, "guarding")),
            self._heard,
            self._time,
            sync,
        ]
        numbers = _numbers(dictionary, rpdo.COMMUNICATION)
        services += [Rpdo(clock, port, dictionary, sync, self.emcy, number) for number in numbers]
        numbers = _numbers(dictionary, tpdo.COMMUNICATION)
        self._tpdos = [Tpdo(clock, port, dictionary, sync, number) for number in numbers]
        for pdo in self._tpdos:
            pdo.on_change = self._on_pdo_change
        return [*services, *self._tpdos, self._living]

    def _restart(self, scope: Reset) -> None:
        node_id = self._lss.node_id_after(scope)
        if node_id != self._port.node_id:
            self._port.node_id = node_id
            self._parameters.refit(self._settings.dictionary(node_id))
        self.dictionary.restore(DEVICE_TYPE, LAST if scope is Reset.NODE else LAST_OF_COMMUNICATION)
        with self._port.batch():
            for service in self._services:
                service.reset(scope)

    def _enter(self, state: State) -> None:
        self._port.enter(state)
        for service in self._services:
            service.enter(state)

    def _on_communication_error(self, is_lost: bool) -> None:
        for service in self._services:
            service.on_communication_error(is_lost)

    def _own_points(self) -> dict[str, Point]:
        return {
            "nmt.state": Point(
                lambda: self.nmt.state.name.lower(), about="state of the node", states=[of.name.lower() for of in State]
            ),
            "error_register": Point(lambda: self.emcy.register, about="1001h"),
            "emcy.code": Point(
                lambda: self.emcy.last_code,
                self._set_error,
                about="last error code; write a code to raise it, 0 to clear all",
            ),
            "emcy.heard": Point(lambda: self._heard.last, about="last error of another node (1028h)"),
            "node_id": Point(lambda: self._port.node_id, about="255 while the node is unconfigured"),
            "lss.state": Point(lambda: self._lss.state.name.lower(), about="state of the LSS slave"),
            "lss.bit_rate": Point(self._bit_rate, unit="bit/s", about="rate activated by LSS; 0 for that of the bus"),
            "time": Point(self._time.read, self._time.write, about="the node's clock, which TIME sets"),
        }

    def _bit_rate(self) -> int:
        timing = self._lss.bit_timing
        return 0 if timing is None else BIT_RATES[timing]

    def attach(self, application: Service) -> None:
        """Add the application, which is reset and enters states after the services.  Call this before `start`."""
        self._services.append(application)

    def take_faults(self, faults: NodeFaults) -> None:
        """Have those of these faults that a node can have; its owner may have further ones among them."""
        end = FaultyEnd(self._clock, self._port.link, self._port, self.dictionary, faults)
        faults.also(end.use)
        faults.also(Emergencies(self._clock, self.emcy, faults).follow)

    def dcf(self) -> str:
        """Return the present configuration of the node as a device configuration file (CiA 306)."""
        return write_dcf(EdsSource(self._settings.eds), self.dictionary, self._port.node_id, self.name)

    @property
    def watched(self) -> list[tuple[Variable, Callable[[], bytes]]]:
        """Variables that the application has to keep up to date with `set`, each with its reader.

        These are the variables with readers that TPDOs carry; after `read_when_sent`, only those of event-driven TPDOs.
        """
        if self._watched is None:
            found = dict.fromkeys(variable for tpdo in self._tpdos for variable in tpdo.watched)
            self._watched = [(variable, variable.reader) for variable in found if variable.reader is not None]
        return self._watched

    def read_when_sent(self) -> None:
        """Call the readers from now on whenever a TPDO is sent at a SYNC or on request."""
        for pdo in self._tpdos:
            pdo.reads_when_sent = True

    def _on_pdo_change(self) -> None:
        self._watched = None

    def send_to(self, number: int, node_id: int, index: int, subindex: int) -> None:
        """Send the variable of TPDO `number`, from 1, to an object of another node (destination address mode)."""
        self._tpdos[number - 1].send_to(node_id, index, subindex)

    def _set_error(self, value: Value) -> None:
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 0xFFFF:
            raise ValueError(f"{value!r} is not an error code: expected a number from 0 to 0xFFFF")
        if value == 0:
            self.emcy.clear_all()
        else:
            self.emcy.raise_error(value)

    @classmethod
    def tools(cls, name: str, settings: CanopenSettings, links: Mapping[str, Bus[Any]]) -> list[Tool]:
        return lines(settings, links)


def _profile(dictionary: Dictionary) -> int:
    return dictionary.number(DEVICE_TYPE, 0) & 0xFFFF


def _offer_eds(dictionary: Dictionary, path: Path) -> None:
    """Offer the file in 1021h unchanged, with its comments, if that object is a DOMAIN."""
    variable = dictionary.get(STORED_EDS)
    if variable is not None and variable.type is DOMAIN:
        data = path.read_bytes()
        variable.reader = lambda: data


def _numbers(dictionary: Dictionary, first: int) -> list[int]:
    """Return the numbers, from 0, of the PDOs whose communication parameters start at `first`."""
    return [index - first for index in dictionary.indices(first, first + 511)]


def _points(dictionary: Dictionary) -> dict[str, Point]:
    return {variable.key: _point(variable) for variable in dictionary}


def _point(variable: Variable) -> Point:
    low = variable.type.low if variable.low is None else variable.low
    high = variable.type.high if variable.high is None else variable.high
    return Point(
        lambda: variable.present,
        variable.order,
        about=variable.name,
        type=variable.type.name,
        low=low,
        high=high,
    )
