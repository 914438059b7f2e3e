"""Devices for the ring benchmarks: a master that moves all axes, an empty drive that echoes, and a full one.

Times of each cycle are not kept here: the ring's own statistics have them.  The drives know their timing from their
settings, so that the start takes a second instead of ten; the cycle is the same.
"""

import struct
from math import sin, tau
from typing import Final

from fieldrig.clock import MS, US, Clock, S
from fieldrig.device import Device, Point
from fieldrig.link import Link
from fieldrig.settings import ConfigFile, Settings
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_devices.mc4.drive import Mc4
from fieldrig_devices.mc4.settings import Mc4Settings, MotorSettings
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.idn import Attribute, Format, Length
from fieldrig_devices.sercos.master import SercosMaster
from fieldrig_devices.sercos.preparation import Script, transition
from fieldrig_devices.sercos.ring_drive import Drive, Event, RingEvent
from fieldrig_devices.sercos.slave import HEAD_VALUES, SercosSlave

SIGNED: Final = Attribute(Length.FOUR, Format.SIGNED)
ENABLED: Final = words.DRIVE_ON | words.ENABLE | words.RUN
FOLLOWS: Final = 0x0008
POSITION: Final = 4
"""Telegram type of S-0-0015: position command values, position feedback values."""
SWING: Final = 200_000
"""Increments to either side: a fifth of a turn."""
SETTLING_NS: Final = 50 * US
"""Less than a real master leaves: at 1 ms the telegrams of 40 drives fill the fibre."""
AGAIN_NS: Final = 100 * MS
MBAUD: Final = 16


class Prepared(SercosMaster):
    """A master whose drives already have the parameters of CP2."""

    def prepare(self, drive: Drive) -> Script:
        return transition(127)

    def timing(self, address: int) -> dict[int, int]:
        return self.plan.timing(self.drives[address], {3: 20, 5: 100})  # what our drives need


class RingSettings(Settings):
    cycle_us: int
    drives: int
    """All of the ring, with addresses from 1 on."""
    early_us: int = 1_000
    """Cycle in CP0 to CP2."""


class Master(Device):
    """Brings the ring up, enables the drives, and lets each swing about where it stood."""

    def __init__(self, clock: Clock, settings: RingSettings, ring: Link[RingMessage]) -> None:
        self._clock = clock
        self._falls = self._cycles = 0
        self._base: dict[int, int] = {}
        self._swinging: list[tuple[int, int]] = []
        """The offset of each drive's set position in the MDT, and the middle of its swing."""
        self.ring = Prepared(
            clock,
            ring,
            settings.cycle_us * US,
            [Drive(address, (47,), (51,)) for address in range(1, settings.drives + 1)],
            mbaud=MBAUD,
            early_cycle_ns=settings.early_us * US,
            settling_ns=SETTLING_NS,
            on_event=self._on_event,
            on_cycle=self._on_cycle,
        )

    def start(self) -> None:
        self.ring.start()
        self.ring.request_phase(4)

    def stop(self) -> None:
        self.ring.stop()

    def points(self) -> dict[str, Point]:
        ring = self.ring
        return {
            "phase": Point(lambda: ring.phase),
            "cycles": Point(lambda: self._cycles),
            "missed": Point(lambda: ring.missed_cycles),
            "lost": Point(lambda: sum(drive.lost for drive in ring.drives.values())),
            "falls": Point(lambda: self._falls),
            "moving": Point(lambda: len(self._base)),
        }

    def _on_event(self, event: RingEvent) -> None:
        if event.what is Event.PHASE and event.code == 0:
            self._falls += 1
            self._base.clear()
            self._swinging.clear()
            self._clock.call_at(self._clock.now_ns() + AGAIN_NS, lambda: self.ring.request_phase(4))

    def _on_cycle(self) -> None:
        self._cycles += 1
        swing = round(SWING * sin(self._cycles * 0.002))
        base, set_commands = self._base, self.ring.set_commands
        values = self.ring.command_values
        for place, middle in self._swinging:
            values[place] = middle + swing
        for address, drive in self.ring.drives.items() if len(base) < len(self.ring.drives) else ():
            if address in base:
                continue
            set_commands(address, ENABLED, drive.feedback[0])
            if drive.status & FOLLOWS and abs(swing) < 500:
                base[address] = drive.feedback[0] - swing
                self._swinging.append((drive.place + HEAD_VALUES, base[address]))


class RunnerSettings(Settings):
    mdt: list[int]
    at: list[int]
    """IDNs of command and feedback values; the position is the first of both."""
    addresses: list[int]
    cycle_us: int
    speed: int
    """Increments per second."""
    ramp_s: float = 0.5
    cam: int = 0
    """Increments of one cam, an inclined sine line from dwell to dwell; 0 for a motion at one speed."""


class Runner(Device):
    """Brings a ring up as any master does, enables its drives, and sends each a set position.

    It runs at one speed, or through one cam after another at this mean speed.
    """

    def __init__(self, clock: Clock, settings: RunnerSettings, ring: Link[RingMessage]) -> None:
        self._way = settings.speed * settings.cycle_us / S * US
        """Increments in a cycle."""
        self._ramp_cycles = round(settings.ramp_s * S / (settings.cycle_us * US))
        self._cam = settings.cam
        self._running: dict[int, list[float]] = {}
        """Position, cycles since the start, and first position, by the offset of the set position in the MDT."""
        self.ring = SercosMaster(
            clock,
            ring,
            settings.cycle_us * US,
            [Drive(address, settings.mdt, settings.at) for address in settings.addresses],
            on_event=lambda _event: None,
            on_cycle=self._on_cycle,
        )

    def start(self) -> None:
        self.ring.start()
        self.ring.request_phase(4)

    def points(self) -> dict[str, Point]:
        return {"moving": Point(lambda: len(self._running))}

    def _on_cycle(self) -> None:
        ring, running = self.ring, self._running
        if len(running) < len(ring.drives):
            self._enable()
        values, way, ramp_cycles, cam = ring.command_values, self._way, self._ramp_cycles, self._cam
        for place, state in running.items():
            state[1] += 1
            state[0] += way * min(state[1] / ramp_cycles, 1.0)
            at = state[0] if not cam else state[0] - cam / tau * sin((state[0] - state[2]) * tau / cam)
            values[place] = (round(at) + 0x8000_0000 & 0xFFFF_FFFF) - 0x8000_0000

    def _enable(self) -> None:
        for address, drive in self.ring.drives.items():
            place = drive.place + HEAD_VALUES
            if place not in self._running:
                self.ring.set_commands(address, ENABLED, drive.feedback[0])
                if drive.status & FOLLOWS:
                    self._running[place] = [drive.feedback[0], 0, drive.feedback[0]]


def prepare(table: IdnTable, settings: RingSettings, address: int) -> None:
    """Write the parameters that a master sends to a drive in CP2."""
    from fieldrig.clock import VirtualClock
    from fieldrig.testing import RecordedLink

    master = Master(VirtualClock(), settings, RecordedLink[RingMessage]())
    for idn, value in {**master.ring.timing(address), 15: POSITION}.items():
        table[idn].set(value)


class EchoSettings(RingSettings):
    ring_address: int


class Echo(Device):
    """A complete slave of the ring whose position is the last command value."""

    def __init__(self, clock: Clock, settings: EchoSettings, ring: Link[RingMessage]) -> None:
        table = IdnTable(
            [
                Datum(47, "position command value", SIGNED, minimum=-(2**31), maximum=2**31 - 1),
                Datum(51, "position feedback value 1", SIGNED),
            ]
        )
        SercosSlave(clock, ring, settings.ring_address, table, self)
        prepare(table, settings, settings.ring_address)

    def on_cycle(self, values: tuple[int, ...]) -> tuple[int, bytes]:
        return words.IN_OPERATION | FOLLOWS, struct.pack("<i", *values[HEAD_VALUES:])

    on_missed_cycle = on_cycle

    def status(self) -> int:
        return words.POWERED

    def feedback(self) -> bytes:
        return bytes(4)

    def on_phase(self, phase: int) -> None:
        """Nothing here depends on it."""

    def on_ring_failure(self) -> None:
        """Nothing moves."""

    def check(self, phase: int) -> list[int]:
        return []


class FullSettings(EchoSettings):
    name_plate: ConfigFile


class Full(Mc4):
    """An MC-4 with its motor and plate."""

    def __init__(self, clock: Clock, name: str, settings: FullSettings, ring: Link[RingMessage]) -> None:
        motor = MotorSettings(name_plate=settings.name_plate)
        super().__init__(clock, name, Mc4Settings(ring_address=settings.ring_address, motor=motor), ring)
        assert self._side is not None
        prepare(self._side.slave.table, settings, settings.ring_address)
