"""The lab and the press in tests of faults: their work is on CAN."""

from typing import ClassVar, Final

from fault_choices import Injected
from faulted_machine import Effect, Machine, Table, goes_on, may_stop, waits
from rig_hands import START_ALL

from fieldrig_bus.can.frame import CanFrame

SILENT: Final[Table] = {
    "can drop": waits(),
    "can delay": goes_on(),
    "can duplicate": goes_on(),
    "can replace": waits(),
    "can corrupt": waits(),
    "can error_frame": waits(),
    "can short": waits(),
    "can wrong_bit_rate": may_stop(),  # its error flags add to what other errors left in the TEC
    "can babble": waits(),
}
"""A master hears nothing that is right while the fault lasts, and hears it again afterwards without a further step."""


class Lab(Machine):
    """docs/begin/lab.md: the pump fills the tank, and the sensor sends the level; without CAN the pump goes on."""

    file = "lab.yaml"
    can_nodes: ClassVar = {"can0": 6}
    table: ClassVar[Table] = {
        **SILENT,
        "plant.tank leak": goes_on(),
        "plant.tank blocked_outlet": goes_on(),
        "plant.tank stuck_sensor": waits(),
        "plant.tank stuck_switch": goes_on(),
    }
    looks = 0

    def begin(self) -> None:
        self.levels: list[CanFrame] = []
        self.rig.attach("listener").link("can0").on_receive(self.levels.append, [(0x186, 0x7FF)])
        self.set("drive", "speed_set", 100)
        self.set("drive", "run", True)
        self.wait(0.1)
        self.masters["can0"].send(START_ALL)
        self.wait(1)

    def works(self) -> bool:
        return self._fills() and self._is_right()

    def is_safe(self, where: str) -> bool:
        return self._fills() and not self._is_right()

    def come_back(self, injected: Injected, effect: Effect) -> None:
        """Wait; the level has to stay below the top of the tank."""
        self.wait(1)
        self.masters["can0"].send(START_ALL)
        self.wait(1)

    def _fills(self) -> bool:
        return float(self.get("tank", "inflow")) == 0.001

    def _is_right(self) -> bool:
        """Return whether the sensor sends the level in mm that the tank has."""
        self.levels.clear()
        self.wait(1)
        mm = [int.from_bytes(frame.data[:4], "little") for frame in self.levels]
        return bool(mm) and abs(mm[-1] - 1000 * float(self.get("tank", "level"))) < 3


class Press(Machine):
    """The comments of own-device.yaml and press.py: it closes and opens on command, and reports what it does.

    A command that does not arrive changes nothing, so without CAN the ram stays where it is.
    """

    file = "own-device.yaml"
    overrides = ("time=virtual", "buses.can0={kind: can.virtual, bitrate: 500000}", "buses.wires={kind: wires.virtual}")
    table: ClassVar[Table] = {**SILENT, "can wrong_bit_rate": waits()}
    looks = 0

    def begin(self) -> None:
        self.reports: list[bytes] = []
        self.host = self.rig.attach("host").link("can0")
        self.host.on_receive(lambda frame: self.reports.append(frame.data), [(0x181, 0x7FF)])
        self.is_closed = False

    def works(self) -> bool:
        """Move the ram, and return whether it has arrived and says so."""
        self.is_closed = not self.is_closed
        self.host.send(CanFrame(0x201, bytes((self.is_closed,))))
        self.wait(2.5)
        self.reports.clear()
        self.wait(0.5)
        said = bytes.fromhex("02 b0 04" if self.is_closed else "00 00 00")  # 120.0 mm; open
        return self.get("press", "state") == ("CLOSED" if self.is_closed else "OPEN") and said in self.reports

    def is_safe(self, where: str) -> bool:
        """Return whether the ram stays, and no report says that it has moved."""
        place = self.get("press", "position")
        return not self.works() and self.get("press", "position") == place

    def come_back(self, injected: Injected, effect: Effect) -> None:
        """Wait until the bus is quiet again; the next command moves the ram."""
        self.wait(1)
        self.is_closed = self.get("press", "state") == "CLOSED"
