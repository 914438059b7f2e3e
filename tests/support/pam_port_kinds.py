"""A PAM of which only the ports are there, for tests of running rigs; it runs no application."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from pydantic import Field

from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.link import Link, words_behind
from fieldrig.settings import Claim
from fieldrig_bus.dualport.message import Words
from fieldrig_bus.modbus.message import ModbusMessage
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_bus.tcp.message import TcpMessage
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.ports import Ports, byte_order_of
from fieldrig_devices.pam.ports.access.faces import AccessSettings, MemoryFaces
from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.runtime.item import Item, RoutineRef


class HostSettings(AccessSettings):
    program: str = Field(description="text of the application")
    ports: PortOptions = PortOptions()
    has_power: bool = Field(default=True, description="whether the ports do anything")

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("modbus", "unit", self.unit_id, ("unit_id",))


class PortHost(Device):
    """Calls the ports every millisecond.  The points are the variables, with the item behind a dot, and the state."""

    about = "the ports of a PAM for tests"
    thirds = 3

    def __init__(
        self,
        clock: Clock,
        settings: HostSettings,
        modbus: list[Link[ModbusMessage]] | None = None,
        tcp: Link[TcpMessage] | None = None,
        line: Link[SerialMessage] | None = None,
        dualport: Link[Words] | None = None,
    ) -> None:
        program, mistakes = checked(settings.program, "program")
        assert not mistakes, mistakes
        memory = Memory(words_behind(dualport))
        self._clock, self.cycle_number, self._has_power = clock, 0, settings.has_power
        self.reports: list[str] = []
        self._ports = Ports(program, memory, self, settings.ports, send=line.send if line is not None else _drop)
        if line is not None:
            line.on_receive(self._on_line)
        self._faces = MemoryFaces(clock, memory, byte_order_of(program, settings.ports), settings, modbus or (), tcp)

    def start(self) -> None:
        self._faces.open()
        if self._has_power:
            self._ports.begin(self._clock.now_ns())
            self._cycle()

    def stop(self) -> None:
        self._faces.close()

    def _on_line(self, data: SerialMessage) -> None:
        if isinstance(data, bytes):
            self._ports.receive(data)

    def _cycle(self) -> None:
        now_ns = self._clock.now_ns()
        self._ports.poll(now_ns)
        if self._ports.may_run:
            self._ports.take()
            self._ports.give()
        self.cycle_number += 1
        self._clock.call_at(now_ns + MS, self._cycle)

    # ---- the Kernel

    def touched(self, name: str) -> None:
        """Do nothing: no application waits."""

    def start_routine(self, routine: RoutineRef) -> None:
        raise AssertionError(routine)

    def report(self, code: str, details: Sequence[int] = ()) -> None:
        self.reports.append(code)

    def points(self) -> Mapping[str, Point]:
        found = {"state": Point(lambda: " ".join(self._ports.states.values()))}
        found["reports"] = Point(lambda: " ".join(self.reports))
        for name, items in self._ports.items.items():
            if name not in ("DUALPORT", "RS422PORT"):
                for index, item in enumerate(items):
                    found[f"{name}.{index}"] = _point(item)
        return found


def _point(item: Item) -> Point:
    def read() -> Value:
        found = item.value()
        assert isinstance(found, bool | int | float)
        return found

    def write(value: Value) -> None:
        assert isinstance(value, bool | int | float)
        item.set_value(value)

    return Point(read, write)


def _drop(_data: bytes) -> None:
    """Send nothing."""


KINDS = Path(__file__)
