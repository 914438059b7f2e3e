"""A CANopen node from an EDS or DCF file.

Source: CiA 301 version 4.2, CiA 306-1, and CiA 401 for devices that have it.  Left out: block transfer, LSS, node
guarding, storing of parameters, multiplexed PDOs, TIME.

This file puts the services together; each has a file of its own and knows only its parameters and the port.
"""

import os.path
import shlex
from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from fieldrig.bus import Bus
from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Tool, Value
from fieldrig.errors import RigError
from fieldrig.link import Link
from fieldrig.settings import ConfigFile, Settings
from fieldrig.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen import cia401, eds, rpdo, sdo_server, tpdo
from fieldrig_devices.canopen.cia401 import Cia401
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.emcy import Emcy
from fieldrig_devices.canopen.error_behaviour import ErrorBehaviour
from fieldrig_devices.canopen.heartbeat import HeartbeatConsumer, HeartbeatProducer
from fieldrig_devices.canopen.nmt import NmtSlave
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.rpdo import Rpdo
from fieldrig_devices.canopen.sdo_server import SdoServer
from fieldrig_devices.canopen.service import Reset, Service, State
from fieldrig_devices.canopen.sync import Sync
from fieldrig_devices.canopen.ties import Bound, Tie, Ties, bind
from fieldrig_devices.canopen.tpdo import Tpdo
from fieldrig_devices.canopen.variable import Variable

DEVICE_TYPE, DEVICE_NAME = 0x1000, 0x1008
SERIAL_NUMBER = "1018:04"
LAST_OF_COMMUNICATION, LAST = 0x1FFF, 0xFFFF


class CanopenSettings(Settings):
    node_id: Annotated[int, Field(ge=1, le=127)]
    eds: Annotated[ConfigFile, Field(description="EDS or DCF file, relative to the folder of the configuration")]
    ties: Annotated[
        dict[str, str | Tie],
        Field(
            default_factory=dict,
            description="wires at objects: '6200:01' or '6200:01.3' (bit 3) to the name of a wire, or more of it",
        ),
    ]
    objects: Annotated[
        dict[str, bool | int | float | str],
        Field(default_factory=dict, description="power-on values other than the EDS's, such as '1017:00': 500"),
    ]
    serial_number: Annotated[
        int | None, Field(ge=0, le=0xFFFF_FFFF, description="in place of the EDS's in 1018h sub-index 4")
    ] = None
    sdo_timeout_ms: Annotated[int, Field(gt=0, description="how long the SDO server waits for the next segment")] = 1000
    sdo_block_size: Annotated[
        int, Field(ge=1, le=127, description="segments that a client may send in one block of a block download")
    ] = 127

    @model_validator(mode="after")
    def _fits_the_eds(self) -> Self:
        bind(self.dictionary(), self.ties)
        return self

    def dictionary(self) -> Dictionary:
        """As these settings describe it.  ValueError, with what would be right, if they don't fit the EDS."""
        dictionary = eds.load(self.eds, self.node_id)
        start_values = dict(self.objects)
        if self.serial_number is not None:
            start_values[SERIAL_NUMBER] = self.serial_number
        for key, value in start_values.items():
            variable = dictionary.by_key(key)
            try:
                variable.put(value)
            except ValueError as wrong:
                raise ValueError(f"objects: {key}: {wrong}") from wrong
            variable.start = variable.data
        return dictionary


class CanopenNode(Device):
    about = "a CANopen node (CiA 301) made from an EDS or DCF file"

    def __init__(
        self,
        clock: Clock,
        name: str,
        can: Link[CanFrame],
        settings: CanopenSettings,
        store: Store,
        wires: Link[Signal] | None = None,
    ) -> None:
        self.name = name
        self.dictionary = settings.dictionary()
        self._port = Port(can, settings.node_id)
        self._profile = Cia401(self.dictionary) if _profile(self.dictionary) == cia401.PROFILE else None
        self._ties = self._tied(wires, bind(self.dictionary, settings.ties))
        self.nmt = NmtSlave(self._port, self._restart, self._enter)
        self.emcy = Emcy(clock, self._port, self.dictionary)
        self._services = self._make_services(clock, settings)
        self._points = _points(self.dictionary) | self._own_points()

    def start(self) -> None:
        if self._ties is not None:
            self._ties.start()
        self.nmt.boot(Reset.NODE)

    def points(self) -> Mapping[str, Point]:
        return self._points

    def _tied(self, wires: Link[Signal] | None, bounds: list[Bound]) -> Ties | None:
        if wires is None:
            if bounds:
                raise RigError(f"{self.name} has ties but no wires", "name a bus of wires under its links")
            return None
        return Ties(wires, bounds, {} if self._profile is None else self._profile.terminals)

    def _make_services(self, clock: Clock, settings: CanopenSettings) -> list[Service]:
        """In the order in which they are reset and enter a state."""
        port, dictionary = self._port, self.dictionary
        sync = Sync(clock, port, dictionary, self.emcy)
        behaviour = ErrorBehaviour(dictionary, self.emcy, self.nmt, self._on_communication_error)
        services: list[Service] = [self.nmt, self.emcy]
        services += [one for one in (self._profile, self._ties) if one is not None]
        services += [
            SdoServer(clock, port, dictionary, index, settings.sdo_timeout_ms * MS, settings.sdo_block_size)
            for index in sorted(
                {sdo_server.FIRST_SERVER, *dictionary.indices(sdo_server.FIRST_SERVER, sdo_server.LAST_SERVER)}
            )
        ]
        services += [
            HeartbeatProducer(clock, port, dictionary),
            HeartbeatConsumer(clock, port, dictionary, behaviour.on_heartbeat_lost),
            sync,
        ]
        services += [
            Rpdo(port, dictionary, sync, self.emcy, number) for number in _numbers(dictionary, rpdo.COMMUNICATION)
        ]
        services += [Tpdo(clock, port, dictionary, sync, number) for number in _numbers(dictionary, tpdo.COMMUNICATION)]
        return services

    def _restart(self, scope: Reset) -> None:
        self.dictionary.restore(DEVICE_TYPE, LAST if scope is Reset.NODE else LAST_OF_COMMUNICATION)
        with self._port.batch():
            for service in self._services:
                service.reset(scope)

    def _enter(self, state: State) -> None:
        self._port.enter(state)
        for service in self._services:
            service.enter(state)

    def _on_communication_error(self, is_lost: bool) -> None:
        if self._profile is not None:
            self._profile.on_communication_error(is_lost)

    def _own_points(self) -> dict[str, Point]:
        return {
            "nmt.state": Point(lambda: self.nmt.state.name.lower(), about="state of the node"),
            "error_register": Point(lambda: self.emcy.register, about="1001h"),
            "emcy.code": Point(
                lambda: self.emcy.last_code,
                self._set_error,
                about="last error code; write one to raise it, 0 to clear all",
            ),
        }

    def _set_error(self, value: Value) -> None:
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 0xFFFF:
            raise ValueError(f"{value!r} is no error code: a number from 0 to 0xFFFF would be right")
        if value == 0:
            self.emcy.clear_all()
        else:
            self.emcy.raise_error(value)

    @classmethod
    def tools(cls, name: str, settings: CanopenSettings, links: Mapping[str, Bus[Any]]) -> list[Tool]:
        reach = getattr(links.get("can"), "python_can", None)
        bus = None if reach is None else reach()
        if bus is None:
            return []
        index = DEVICE_NAME if DEVICE_NAME in settings.dictionary() else DEVICE_TYPE
        read = f"print(node.sdo[{index:#06x}].raw)"
        start = "node.nmt.state = 'OPERATIONAL'"
        return [
            Tool("what it is", _python_line(settings, bus, read)),
            Tool("start it", _python_line(settings, bus, start)),
        ]


def _python_line(settings: CanopenSettings, bus: Mapping[str, Any], action: str) -> str:
    """A shell line that does `action` on the node with python canopen."""
    reach = ", ".join(f"{key}={value!r}" for key, value in bus.items())
    steps = [
        "import canopen",
        "n = canopen.Network()",
        f"n.connect({reach})",
        f"node = n.add_node({settings.node_id}, {os.path.relpath(settings.eds)!r})",
        action,
        "n.disconnect()",
    ]
    return f"python -c {_quoted('; '.join(steps))}"


def _quoted(text: str) -> str:
    """For a shell; readable where it can be, as the text has single quotes of its own."""
    return shlex.quote(text) if set(text) & set('"$`\\!') else f'"{text}"'


def _profile(dictionary: Dictionary) -> int:
    return dictionary.number(DEVICE_TYPE, 0) & 0xFFFF


def _numbers(dictionary: Dictionary, first: int) -> list[int]:
    """The PDOs that have communication parameters from `first` on."""
    return [index - first for index in dictionary.indices(first, first + 511)]


def _points(dictionary: Dictionary) -> dict[str, Point]:
    return {variable.key: _point(variable) for variable in dictionary}


def _point(variable: Variable) -> Point:
    return Point(lambda: variable.value, variable.put, about=variable.name)
