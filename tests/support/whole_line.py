"""The line of machine.yaml in tests of faults: the wrapper, whose program joins it to film and glue.

The rest of the line is the devices and programs of its own rigs, where their faults are tried: labels, labeller,
modems, the glue, and the cell.  What the wrapper hears of the cell, a film that runs and its encoder, is sent here in
its place, because the two cards take five times as long as the wrapper; `configs/test_machine.py` has both together.
"""

from typing import ClassVar, Final

from fault_choices import Injected
from faulted_machine import Effect, stops
from max4_machines import CONTROLLER, DRIVES, Max4Machine, diagnosis
from rig_hands import ModbusClient

from fieldrig_bus.signals.signal import Motion, Signal

RUNNING = 3
FILM_COUNTS_PER_S = 2400.0
"""The encoder of the nip at half speed, 300 mm/s, as 0.125 mm are a count."""
AUTOMATIC, STATE, PACKS = 32768, 32769, 32770
ELSEWHERE: Final = (
    *("pam", "plc", "belt", "cutter", "paper", "stacker", "keys", "guide", "lane", "marks", "cams", "rail"),
    *("feeder", "sealer", "stepper", "web", "heater", "io", "sensor", "drive", "tank"),
    *("nip", "knife", "roll", "line", "unwinder", "io1", "io2", "terminal", "machine_modem", "caller_modem"),
)
"""Devices of the other rigs."""


class WholeLine(Max4Machine):
    """machine.md: a lost axis or an overload ends automatic operation; the client takes its bit back, sets it."""

    file = "machine.yaml"
    wheres = ("max4", "infeed", "film", "jaw", "outfeed", "ring")
    can_nodes: ClassVar = {"can2": 1}
    axes: ClassVar = ("infeed", "film", "jaw", "outfeed")
    table: ClassVar = {**DRIVES, **CONTROLLER, "max4 overrun": stops(diagnosis(6507))}
    overrides = ("buses.telephone=null", *(f"devices.{name}=null" for name in ELSEWHERE))
    safe_within_s = 6.0

    def begin(self) -> None:
        self.client = ModbusClient(self.rig, "modbus")
        self.boot()
        cell = self.rig.attach("cell").link("wires")
        cell.send(Motion("nip.encoder", 0.0, "count", time_ns=self.rig.now_ns, speed=FILM_COUNTS_PER_S))
        cell.send(Signal("tower.green", True))
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
