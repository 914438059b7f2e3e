"""The Smart-IO node of a PAM: I/O cards, keyboard, display, analog output and DC motors.

Source: Socapel, PAM Reference Manual 2.5 (digest PAML-080 to PAML-130, PAMS-041 to PAMS-053, PAMS-105 to PAMS-112).
Without a PAM, the node is a CiA 401 module and a Modbus device, whose objects and registers are ours.  Left out: the
battery that keeps the configuration over power-off, and the checksum of the firmware.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar, Final

from fieldrig.bus import Bus
from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Tool, Value
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusEvent
from fieldrig_bus.ring.pam.message import RingMessage
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen.point_slave import PointSlave
from fieldrig_devices.modbus.point_server import PointServer
from fieldrig_devices.modbus.tools import lines_for
from fieldrig_devices.pamring.frames import NodeType, Severity, Trouble
from fieldrig_devices.pamring.node import RingNode
from fieldrig_devices.pamring.points import ring_points, ring_troubles
from fieldrig_devices.registers.table import load_table
from fieldrig_devices.smart_io.alone import Alone
from fieldrig_devices.smart_io.board import Board
from fieldrig_devices.smart_io.faces.objects import EDS, points_by_object
from fieldrig_devices.smart_io.faces.registers import table
from fieldrig_devices.smart_io.faults import MODELS, LowBattery, ShortCircuit
from fieldrig_devices.smart_io.front import front_of
from fieldrig_devices.smart_io.program import SmartIoProgram
from fieldrig_devices.smart_io.settings import SmartIoSettings
from fieldrig_devices.smart_io.terminals import Terminals
from fieldrig_devices.smart_io.troubles import NODE, FaultCode, Troubles

FIRMWARE: Final = 0x0250
"""The version that the node reports: 2.50, as the manual."""
_EMERGENCIES: Final[Mapping[int, tuple[int, int]]] = {
    FaultCode.SHORT_CIRCUIT: (0x2320, 0x02),
    FaultCode.HEAT_SINK: (0x4200, 0x08),
    FaultCode.AMBIENT: (0x4100, 0x08),
}
"""Error codes of CiA 401 with their bits of the error register."""
_OTHERS: Final = (0xFF00, 0x80)
"""All others are FF00h plus the code of the fault."""


class SmartIo(Device):
    about: ClassVar[str] = "a Smart-IO node of a PAM: inputs, outputs, keyboard, display, DC motors"
    trouble_keys: ClassVar[Collection[str]] = ("error_word",)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: SmartIoSettings,
        store: Store,
        wires: Link[Signal] | None = None,
        modbus: list[Link[ModbusEvent]] | None = None,
        can: Link[CanFrame] | None = None,
        ring: Link[RingMessage] | None = None,
    ) -> None:
        """ConfigError for a register table with mistakes, ValueError for a bus without its key, or a key without it."""
        self._settings = settings
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults, check=self._check
        )
        troubles = Troubles(clock, self._on_trouble)
        self._board = Board(clock, settings, Terminals(clock, wires, settings.terminals), troubles, self._faults)
        self._alone = Alone(clock, settings, self._board, self._on_change)
        self.program = SmartIoProgram(clock, self._board, settings, self._alone.give_up)
        self._is_battery_low = False
        self._points = dict(self._own_points())
        self._can: PointSlave | None = None
        if settings.can_slave is not None:
            if can is None:
                raise ValueError("can_slave: expected links.can beside it")
            self._can = PointSlave(clock, name, can, settings.can_slave, store, self.find, EDS, points_by_object())
            self._points |= dict(self._can.points())
        self._ring = None if ring is None else self._make_end(clock, ring)
        if self._ring is not None:
            self._points |= ring_points(self._ring)
        PointServer(clock, modbus or [], settings.modbus, self.find, _ignore, partial(table, settings))

    def _make_end(self, clock: Clock, ring: Link[RingMessage]) -> RingNode:
        address = self._settings.ring_address
        if address is None:
            raise ValueError("ring_address: expected the address of the node, 1 to 255, beside links.ring")
        inactive_ns = self._settings.ring_inactive_ms * MS
        end = RingNode(clock, ring, address, NodeType.SMART_IO, FIRMWARE, self.program, inactive_ns)
        self.program.attach(end)
        return end

    def start(self) -> None:
        self._board.terminals.start()
        self._alone.start()
        if self._can is not None:
            self._can.start()
        if self._ring is not None:
            self._ring.start()

    def front(self) -> Front:
        return front_of(self._settings, self._ring is not None, self._board.has_display)

    def points(self) -> Mapping[str, Point]:
        return self._points

    def troubles(self) -> Mapping[str, Value]:
        return {**super().troubles(), **({} if self._ring is None else ring_troubles(self._ring))}

    def find(self, name: str) -> Point | None:
        """Return the point that a face calls `name`."""
        return self._points.get(name)

    def _own_points(self) -> Iterator[tuple[str, Point]]:
        yield from self._alone.points()
        yield "error_word", Point(lambda: self._board.troubles.word, about="error word of the node")
        yield (
            "owner",
            Point(
                lambda: "pam" if self._alone.is_owned else "alone",
                about="pam or alone: the side that controls the outputs",
            ),
        )

    def _on_change(self, name: str) -> None:
        if self._can is not None:
            self._can.wires.show(name)

    # ---- faults

    def _on_trouble(self, trouble: Trouble) -> None:
        self.program.tell(trouble)
        if self._can is None:
            return
        self._can.wires.show("error_word")
        number, source = trouble.details if trouble.code == NODE else reversed(trouble.details)
        code, register = _EMERGENCIES.get(number, (_OTHERS[0] + number, _OTHERS[1]))
        if trouble.severity is Severity.WARNING:
            self._can.emcy.raise_error(code, register, source.to_bytes(4, "little"), source)
        else:
            self._can.emcy.clear_error(code, source)

    def _check(self, fault: Any) -> None:
        """Refuse a fault of a terminal or a module that is not there."""
        address = getattr(fault, "address", None)
        direction = "out" if isinstance(fault, ShortCircuit) else "in"
        if address is not None and not self._settings.has(f"{direction}{address}"):
            fitted = ", ".join(map(str, sorted(self._board.modules)))
            raise ValueError(f"there is no {direction}{address}\nexpected an address of the modules {fitted}")

    def _on_faults(self) -> None:
        self._board.apply_faults()
        was_low, self._is_battery_low = self._is_battery_low, self._faults.first(LowBattery) is not None
        if self._is_battery_low and not was_low:
            self.program.lose()
            self._alone.take_back()

    # ---- tools

    @classmethod
    def tools(cls, name: str, settings: SmartIoSettings, links: Mapping[str, Any]) -> list[Tool]:
        """Return lines for the registers."""
        buses: Sequence[Bus[Any]] = links.get("modbus", ())
        own = settings.modbus.table
        return lines_for(table(settings) if own is None else load_table(own), settings.modbus.unit_id, buses)


def _ignore(_message: ModbusEvent) -> None:
    """Answers are for clients, and the node is none."""
