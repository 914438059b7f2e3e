"""A ring on a bench: a master and drives of the least sort, under virtual time."""

from collections.abc import Iterable
from typing import Any

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.idn import Attribute, Format, Length
from fieldrig_devices.sercos.master import SercosMaster
from fieldrig_devices.sercos.ring_drive import Drive, Event, RingEvent
from fieldrig_devices.sercos.slave import HEAD_VALUES, SercosSlave

SIGNED = Attribute(Length.FOUR, Format.SIGNED)


TEXT = Attribute(Length.LIST_OF_BYTES, Format.TEXT, protected=(2, 3, 4))


class PlainDrive:
    """An application whose position is the last command value."""

    def __init__(self, rig: Rig, name: str, address: int) -> None:
        self.node = rig.attach(name)
        self.table = IdnTable(
            [
                Datum(47, "position command value", SIGNED, unit="incr", minimum=-(2**31), maximum=2**31 - 1),
                Datum(51, "position feedback value 1", SIGNED, unit="incr"),
                Datum(104, "position loop Kv-factor", Attribute(Length.TWO, decimals=2), 100, minimum=1, maximum=6_000),
                Datum(30, "manufacturer version", TEXT, "V00.15"),
            ]
        )  # fmt: skip
        self.phases: list[int] = []
        self.failures = self.missed = 0
        self.commands: list[tuple[int, ...]] = []
        self.control = 0
        self.invalid: list[int] = []
        self.slave = SercosSlave(self.node.clock, self.node.link("ring0"), address, self.table, self)

    def on_cycle(self, values: tuple[int, ...]) -> tuple[int, bytes]:
        self.control, _, *commands = values
        self.commands.append(tuple(commands))
        return words.POWERED, _encoded(commands)

    def on_missed_cycle(self, values: tuple[int, ...]) -> tuple[int, bytes]:
        self.missed += 1
        return words.POWERED, _encoded(values[HEAD_VALUES:])

    def status(self) -> int:
        return words.READY_FOR_POWER

    def feedback(self) -> bytes:
        return _encoded((0,))

    def on_phase(self, phase: int) -> None:
        self.phases.append(phase)

    def on_ring_failure(self) -> None:
        self.failures += 1

    def check(self, phase: int) -> list[int]:
        return self.invalid if phase == 4 else []


def _encoded(positions: Iterable[int]) -> bytes:
    return b"".join(position.to_bytes(4, "little", signed=True) for position in positions)


class RingBench:
    def __init__(self, *addresses: int, cycle_ms: int = 4, **bus: Any) -> None:
        self.trace: list[tuple[int, str, Any]] = []
        config = from_dict({"time": "virtual", "seed": 7, "buses": {"ring0": {"kind": "ring.virtual", **bus}}})
        self.rig = Rig(
            config, lambda _bus, delivery: self.trace.append((delivery.time_ns, delivery.sender, delivery.message))
        )
        self.controller = self.rig.attach("max4")
        self.drives = {
            address: PlainDrive(self.rig, f"drive{place}", address) for place, address in enumerate(addresses)
        }
        self.events: list[RingEvent] = []
        self.cycles = 0
        self.master = SercosMaster(
            self.controller.clock,
            self.controller.link("ring0"),
            cycle_ms * MS,
            [Drive(address, (47,), (51,)) for address in dict.fromkeys(addresses)],
            on_event=self.events.append,
            on_cycle=self._on_cycle,
        )

    def _on_cycle(self) -> None:
        self.cycles += 1

    def run(self, ms: float) -> "RingBench":
        self.rig.run_until(self.rig.now_ns + round(ms * MS))
        return self

    def up(self, phase: int = 4, ms: float = 3_000) -> "RingBench":
        self.master.start()
        self.master.request_phase(phase)
        return self.run(ms)

    def seen(self, what: Event) -> list[RingEvent]:
        return [event for event in self.events if event.what is what]
