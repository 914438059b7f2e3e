"""The rigs with a MAx-4 in tests of faults: the conveyor, the ring of drives, teleservice, and the packaging line."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, Final

from fault_choices import Injected
from faulted_machine import CAN_STAYS_ASIDE, Effect, Machine, Sign, Table, goes_on, stops

UP: Final = ("up", 0)
STILL_RPM: Final = 10
"""Below it a drive says that it stands; without torque the small one hardly brakes itself."""


def diagnosis(code: int) -> Sign:
    return Sign("max4", "DiagCode", code)


DRIVES: Final[Table] = {
    "mc4 enable_lost": stops(Sign("{where}", "inverter_enable", False)),
    "mc4 overtemperature motor": stops(diagnosis(3117)),
    "mc4 overtemperature amplifier": stops(diagnosis(3193)),
    "mc4 overload": stops(diagnosis(3125)),
    "mc4 dc_bus communication": stops(diagnosis(2106)),
    "mc4 dc_bus undervoltage": stops(diagnosis(2194)),
    "mc4 dc_bus overvoltage": stops(diagnosis(1108)),
    "mc4 dc_bus phase": stops(diagnosis(2195)),
    "mc4 encoder_memory": stops(diagnosis(1117)),
    "mc4 encoder_signal": stops(diagnosis(1105)),
    "mc4 wrong_motor": stops(diagnosis(1117)),
    "mc4 stuck_brake": goes_on(),
    "mc4 supply_24v": goes_on(diagnosis(7134)),
}
RING: Final[Table] = {
    "ring break": stops(diagnosis(2560)),
    "ring off": stops(diagnosis(2560)),
    "ring distort": stops(diagnosis(2561)),
    "ring late": stops(diagnosis(2561)),
}
CONTROLLER: Final[Table] = {
    "max4 power_off": stops(Sign("max4", "power", False)),
    "max4 memory_lost": goes_on(diagnosis(7567)),
    **RING,
}


class Max4Machine(Machine):
    """A machine with a MAx-4."""

    can_nodes: ClassVar = {"can0": 1}

    def boot(self) -> None:
        self.until(lambda: self.get("max4", "booted"), self.back_within_s, 0.5)
        self.wait(0.5)

    def wait_for_power(self) -> None:
        self.boot()
        self.wait(1)

    def acknowledge(self) -> None:
        """Acknowledge until the ring is up and nothing is pending, as docs/devices/pacdrive/ring-lab.md does."""
        for _ in range(20):
            self.set("max4", "command", "quit")
            self.wait(1)
            if (self.get("max4", "ring.state"), self.get("max4", "DiagCode")) == UP:
                return
        raise AssertionError(f"{self.get('max4', 'DiagMsg')} remains")


class Conveyor(Max4Machine):
    """docs/devices/pacdrive/conveyor.md: any lost axis stops all; S1 off, `DiagQuit`, S1 on."""

    file = "conveyor.yaml"
    table: ClassVar = {
        **DRIVES,
        **CONTROLLER,
        **CAN_STAYS_ASIDE,
        "max4 overrun": stops(diagnosis(6507)),
        "plant.conveyor slip": goes_on(),
        "plant.conveyor dirty": goes_on(),
    }
    axes: ClassVar = {"belt": 250.0, "infeed": 250.0, "cutter": 250.0, "outfeed": 300.0}
    """The drives with the speed of their rollers in mm/s while the machine works: the outfeed is 1.2 times as fast."""

    def begin(self) -> None:
        self.boot()
        self.start()

    def start(self) -> None:
        self.set("panel", "6200:01", 3)
        self.until(self._runs, 5)

    def works(self) -> bool:
        fed = self.get("line", "fed")
        self.wait(1)
        return self._runs() and self.get("line", "fed") != fed

    def is_safe(self, where: str) -> bool:
        return all(abs(speed) < 1 for speed in self._speeds().values())

    def come_back(self, injected: Injected, effect: Effect) -> None:
        self.set("panel", "6200:01", 1)
        self.until(lambda: self.is_safe("line"), 10)
        self.acknowledge()
        assert self.is_safe("line")
        self.start()

    def _speeds(self) -> dict[str, float]:
        return {axis: float(self.get(axis, "speed")) * 31.41592653589793 / 60 for axis in self.axes}

    def _runs(self) -> bool:
        return all(abs(speed - self.axes[axis]) < 2 for axis, speed in self._speeds().items())


class RingLab(Max4Machine):
    """ring-lab.md: there is no program; a CANopen master runs the axes, and each axis stops for itself."""

    file = "ring.yaml"
    axes: ClassVar[Mapping[str, float]] = {"infeed": 300.0, "film": 300.0, "jaw": 150.0, "outfeed": 600.0}
    """Speeds in 1/min."""
    places: ClassVar[Sequence[tuple[int, int]]] = ((1, 0), (1, 1), (1, 2), (1, 3))
    """Node and axis on CAN of each of them."""
    table: ClassVar[Table] = {
        **DRIVES,
        **CONTROLLER,
        **CAN_STAYS_ASIDE,
        # the controller is bus-off, and stops its axes by 6007h
        "can corrupt": stops(),
        "can error_frame": stops(),
        "can short recessive": stops(),
        "max4 overrun": goes_on(diagnosis(6507)),
        "sm.encoder silent": goes_on(),
        "sm.encoder memory": goes_on(),
        "sm.encoder checksum": goes_on(),
        "sm.encoder wrong_plate": goes_on(),
    }

    def begin(self) -> None:
        self.boot()
        self.wait(1.5)
        self.master = self.masters["can0"]
        self.start()

    def start(self) -> None:
        self.master.write(1, 0x1017, 0, 100, 2)  # a heartbeat, so that the bus has traffic
        for (name, rpm), (node, axis) in zip(self.axes.items(), self.places, strict=True):
            if not self._runs(name):
                self.master.reset(node, axis)
                self.master.run_at(node, axis, round(rpm * 1_000_000 / 60))
        self.until(lambda: all(map(self._runs, self.axes)), 5)

    def works(self) -> bool:
        self.wait(0.2)
        return all(map(self._runs, self.axes))

    def is_safe(self, where: str) -> bool:
        """Return whether the axes concerned stand, and the others go on."""
        stopped = (where,) if where in self.axes else self.axes
        return all(self._stands(axis) if axis in stopped else self._runs(axis) for axis in self.axes)

    def come_back(self, injected: Injected, effect: Effect) -> None:
        self.acknowledge()
        self.start()

    def _runs(self, axis: str) -> bool:
        return abs(float(self.get(axis, "speed")) - self.axes[axis]) < STILL_RPM

    def _stands(self, axis: str) -> bool:
        return abs(float(self.get(axis, "speed"))) < STILL_RPM


class PackagingLine(RingLab):
    """ring-lab.md: forty drives on one ring, in racks that the panel enables; a drive of each rack runs."""

    file = "packaging-line.yaml"
    axes: ClassVar = {"in1": 300.0, "jaw2": 150.0, "press": 300.0, "stretch": 600.0}
    places = ((1, 0), (3, 1), (4, 5), (5, 7))
    wheres = (*axes, "ring")
    """The faults of controller and CAN are tried in the ring lab, which has the same, and no program either."""
    table: ClassVar = {**DRIVES, **RING}
