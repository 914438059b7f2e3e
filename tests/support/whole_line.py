"""The line of machine.yaml in tests of faults: the wrapper, whose program joins it to film and glue.

Labels, labeller, modems and the glue are the devices and programs of their own rigs, where their faults are tried.
"""

from typing import ClassVar

from fault_choices import Injected
from faulted_machine import Effect, stops
from max4_machines import CONTROLLER, DRIVES, Max4Machine, diagnosis
from rig_hands import ModbusClient

FILM_RUNS, RUNNING = 3, 3
AUTOMATIC, STATE, PACKS = 32768, 32769, 32770


class WholeLine(Max4Machine):
    """docs/machine.md: a lost axis or an overload ends automatic operation; the client takes its bit back, sets it."""

    file = "machine-virtual.yaml"
    wheres = ("max4", "infeed", "film", "jaw", "outfeed", "ring")
    can_nodes: ClassVar = {"can2": 1}
    axes: ClassVar = ("infeed", "film", "jaw", "outfeed")
    table: ClassVar = {**DRIVES, **CONTROLLER, "max4 overrun": stops(diagnosis(6507))}
    overrides = tuple(
        f"devices.{name}=null"
        for name in (
            *("pam", "plc", "belt", "cutter", "paper", "stacker", "keys", "guide", "lane", "marks", "cams", "rail"),
            *("feeder", "sealer", "stepper", "web", "heater", "io", "sensor", "drive"),
        )
    )
    safe_within_s = 6.0

    def begin(self) -> None:
        self.client = ModbusClient(self.rig, "modbus")
        self.boot()
        self.set("line", "F33", True)
        self.until(lambda: self.get("line", "V20") == FILM_RUNS, 20, what="the film")
        self.wait(1)
        self.start()

    def start(self) -> None:
        self.client.write(AUTOMATIC, 1)
        self.until(lambda: self.client.read(STATE) == [RUNNING], 10, what="automatic operation")
        self.wait(2)

    def works(self) -> bool:
        before = self.client.read(PACKS)
        self.wait(1.5)
        return self.client.read(STATE) == [RUNNING] and self.client.read(PACKS) > before

    def is_safe(self, where: str) -> bool:
        return all(abs(float(self.get(axis, "speed"))) < 1 for axis in self.axes)

    def come_back(self, injected: Injected, effect: Effect) -> None:
        if effect is Effect.GOES_ON:
            self.acknowledge()
            return
        self.client.write(AUTOMATIC, 0)
        self.wait(0.5)
        self.acknowledge()
        self.start()
