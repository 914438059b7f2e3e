"""Benches for the MC-4: its enable chain on a motor whose speed the test says, and whole drives on a ring."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_bus.wires import Signal
from fieldrig_devices.mc4.diagnosis import LIMITS, Diagnosis
from fieldrig_devices.mc4.enable import EnableChain, Limit, Seen, Stage, Times
from fieldrig_devices.sercos.idn import Element, ServiceError
from fieldrig_devices.sercos.master import SercosMaster
from fieldrig_devices.sercos.ring_drive import Drive, RingEvent

N_MIN_RPM = 10.0
Speed = Callable[[int], float]
"""A speed in rpm, by ms."""


@dataclass(frozen=True)
class Line:
    """The state of a drive at one instant, as seen from outside."""

    at_ms: int
    brake_closed: bool
    torque: bool
    ready: bool
    axis_state: int
    mc4_state: int
    code: int


@dataclass
class ChainBench:
    """Time goes on by a millisecond; what changes is traced."""

    times: Times = field(default_factory=Times)
    speed: Speed = lambda _: 0.0
    hardware: bool = True
    controller: bool = True
    can_start: bool = True
    is_at_overload_position: bool = False

    def __post_init__(self) -> None:
        self.chain = EnableChain(self.times, self._on_limit)
        self.diagnosis = Diagnosis(lambda reaction: self.chain.react(self.ms * MS, reaction))
        self.ms = 0
        self.trace: list[Line] = []
        self._look()

    def _on_limit(self, limit: Limit) -> None:
        self.diagnosis.raise_(LIMITS[limit])

    def _look(self) -> None:
        is_slow = abs(self.speed(self.ms)) < N_MIN_RPM
        seen = Seen(self.hardware, self.controller, self.can_start, is_slow, self.is_at_overload_position)
        self.chain.update(self.ms * MS, seen)
        chain = self.chain
        line = Line(
            self.ms,
            chain.is_brake_lifted,
            chain.has_torque,
            chain.is_ready,
            chain.axis_state,
            chain.mc4_state,
            self.diagnosis.code,
        )
        if not self.trace or self._seen(line) != self._seen(self.trace[-1]):
            self.trace.append(line)

    @staticmethod
    def _seen(line: Line) -> tuple[object, ...]:
        return (line.brake_closed, line.torque, line.ready, line.axis_state, line.mc4_state, line.code)

    def stage(self) -> Stage:
        return self.chain.stage

    def look(self) -> None:
        """Now, at once."""
        self._look()

    def run(self, ms: int) -> None:
        for _ in range(ms):
            self.ms += 1
            self._look()

    def quit(self) -> bool:
        if not self.chain.can_quit or not self.diagnosis.quit():
            return False
        self.chain.quit(self.ms * MS)
        self._look()
        return True

    def start(self) -> None:
        """Run until the drive is in control; the trace begins again, at 0 ms."""
        self.run(self.times.brake_disconnection_ns // MS + 1)
        assert self.chain.stage is Stage.CONTROLLED
        self.ms = 0
        self.trace.clear()
        self._look()


PLATES = Path(__file__).parents[2] / "configs" / "plates"
BRAKE_PLATE = str(PLATES / "sm-140-30-200-brake.yaml")
PLAIN_PLATE = str(PLATES / "sm-100-30-080.yaml")
SMALL_PLATE = str(PLATES / "sm-070-60-010.yaml")
ENABLED = 0xE000
"""Drive on, drive enable, no halt."""
FEEDBACK = (51, 182, 390)
"""Position; AxisState and MC4State; DiagCode."""


class DriveBench:
    """Drives of the ring addresses 1, 2, ... with wires, and a master that lets them follow `path`."""

    def __init__(self, *drives: dict[str, Any], cycle_ms: int = 4, **more: Any) -> None:
        buses = {"ring": {"kind": "ring.virtual"}, "wires": {"kind": "wires.virtual"}}
        devices = {
            f"d{place}": {
                "kind": "fieldrig_devices.mc4.drive:Mc4",
                "ring_address": place,
                "motor": {"name_plate": PLAIN_PLATE},
                "links": {"ring": "ring", "wires": "wires"},
                **drive,
            }
            for place, drive in enumerate(drives, 1)
        }
        for name, value in more.items():
            (buses if name == "line" else devices)[name] = value
        self.signals: list[tuple[int, Signal]] = []
        self.rig = Rig(from_dict({"time": "virtual", "seed": 7, "buses": buses, "devices": devices}), self._on_delivery)
        self.node = self.rig.attach("max4")
        self.wires = self.node.link("wires")
        self.events: list[RingEvent] = []
        self.control = 0
        self.value: Callable[[int], int] | None = None
        """The command value by cycles since it was given, or None to hold the present position."""
        self.idn = 47
        self.raw: tuple[int, ...] | None = None
        """Control word and command values to send unchanged, instead of the settings above."""
        self._base: dict[int, int] = {}
        self._cycle = 0
        addresses = range(1, len(drives) + 1)
        self.master = SercosMaster(
            self.node.clock,
            self.node.link("ring"),
            cycle_ms * MS,
            [Drive(address, (47, 36, 80), FEEDBACK) for address in addresses],
            on_event=self.events.append,
            on_cycle=self._on_cycle,
        )

    def _on_delivery(self, _bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if isinstance(delivery.message, Signal):
            self.signals.append((delivery.time_ns // MS, delivery.message))

    def _on_cycle(self) -> None:
        for address, drive in self.master.drives.items():
            if self.raw is not None:
                self.master.set_commands(address, *self.raw)
                continue
            if not drive.status & 8 or address not in self._base:
                self._base[address] = drive.feedback[0]
            values = {47: self._base[address], 36: 0, 80: 0}
            if self.value is not None:
                values[self.idn] = self.value(self._cycle) + (self._base[address] if self.idn == 47 else 0)
            self.master.set_commands(address, self.control, *values.values())
        self._cycle += 1

    def run(self, ms: float) -> "DriveBench":
        self.rig.run_until(self.rig.now_ns + round(ms * MS))
        return self

    @property
    def ms(self) -> int:
        return self.rig.now_ns // MS

    def up(self, ms: float = 3_000) -> "DriveBench":
        self.master.start()
        self.master.request_phase(4)
        self.run(ms)
        assert self.master.phase == 4, self.events
        return self

    def enable(self, ms: float = 200) -> "DriveBench":
        self.control = ENABLED
        return self.run(ms)

    def follow(self, value: Callable[[int], int] | None, idn: int = 47) -> None:
        self.value, self.idn, self._cycle = value, idn, 0

    def get(self, key: str, device: str = "d1") -> Any:
        return self.rig.get(device, key)

    def feedback(self, address: int = 1) -> tuple[int, ...]:
        return self.master.drives[address].feedback

    def states(self, address: int = 1) -> tuple[int, int]:
        """AxisState and MC4State, over the ring."""
        return divmod(self.feedback(address)[1], 256)

    def code(self, address: int = 1) -> int:
        """DiagCode, over the ring."""
        return self.feedback(address)[2]

    def read(self, idn: int, element: Element = Element.DATA, address: int = 1) -> bytes | ServiceError:
        answers: list[bytes | ServiceError] = []
        self.master.read(address, idn, element, answers.append)
        self._wait(answers)
        return answers[0]

    def number(self, idn: int, address: int = 1) -> int:
        data = self.read(idn, address=address)
        assert isinstance(data, bytes), data
        return int.from_bytes(data, "little", signed=False)

    def text(self, idn: int, address: int = 1) -> str:
        data = self.read(idn, address=address)
        assert isinstance(data, bytes), data
        return data.decode("latin-1")

    def write(self, idn: int, data: bytes, address: int = 1) -> bytes | ServiceError:
        answers: list[bytes | ServiceError] = []
        self.master.write(address, idn, data, answers.append)
        self._wait(answers)
        return answers[0]

    def command(self, idn: int, address: int = 1) -> bool:
        answers: list[bool] = []
        self.master.command(address, idn, answers.append)
        self._wait(answers)
        return answers[0]

    def _wait(self, answers: list[Any]) -> None:
        for _ in range(2_000):
            if answers:
                return
            self.run(4)
        raise AssertionError("the service channel doesn't answer")

    def trace(self, ms: int, *keys: str) -> list[tuple[Any, ...]]:
        """Return each change of these points from now on, starting with the time in ms."""
        seen: list[tuple[Any, ...]] = []
        begin = self.ms
        for _ in range(ms // 4):
            now = tuple(self.get(key) for key in keys)
            if not seen or seen[-1][1:] != now:
                seen.append((self.ms - begin, *now))
            self.run(4)
        return seen
