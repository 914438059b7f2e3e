"""A whole ARP card on recorded links, under a virtual clock."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fieldrig.clock import MS, VirtualClock
from fieldrig.device import Value
from fieldrig.loop.background import VirtualBackground
from fieldrig.points.access import read_point, write_point
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.testing import RecordedLink
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_bus.wires import Signal
from fieldrig_devices.arp.card.card import ArpCard
from fieldrig_devices.arp.card.local_io import UNITS
from fieldrig_devices.arp.card.settings import ArpSettings
from fieldrig_devices.arp.card_access import CardState
from fieldrig_devices.arp.fixed import SCALE, to_raw
from fieldrig_devices.plants.servo import Servo
from fieldrig_devices.plants.servo_settings import ServoSettings

Groups = Mapping[str, Mapping[int, float]]
FAST: Groups = {"general": {1: 1, 16: 10}}
"""Time with a control loop each millisecond and a pass of the scheduler every ten."""


MOTOR: dict[str, Any] = {"rated_torque_nm": 2.0, "motor_inertia_kg_m2": 0.001, "encoder_lines": 10_000}
"""A motor with an encoder of 40000 counts per turn and 2000 rad/s2 at 10 V."""
SERVO_AXIS = {1: 40, 4: 2, 11: 0.314, 13: 0.006}
"""Parameters of an axis with this motor and 1000 units per turn: a bandwidth of 100 rad/s."""


class PlantWires(RecordedLink[Signal]):
    """The card's wires, with plants at their other ends."""

    def __init__(self) -> None:
        super().__init__()
        self.plants: list[_PlantEnd] = []

    def send(self, message: Signal) -> None:
        super().send(message)
        for plant in self.plants:
            if plant.interest is None or message.name in plant.interest:
                plant.deliver(message)


class _PlantEnd(RecordedLink[Signal]):
    def __init__(self, wires: PlantWires) -> None:
        super().__init__()
        self._wires = wires

    def send(self, message: Signal) -> None:
        self._wires.deliver(message)


class CardBench:
    """`card1` with Enable on, switched on at 0 ns.  It runs from the first pass of the scheduler on, at 10 ms.

    It has a CAN link only with `with_can`, because the CAN node takes longest to build.
    """

    def __init__(
        self,
        program: str = "",
        parameters: Groups | None = None,
        *,
        is_enabled: bool = True,
        store: Store | None = None,
        clock: VirtualClock | None = None,
        wires: RecordedLink[Signal] | None = None,
        with_can: bool = False,
        **settings: Any,
    ) -> None:
        """`program` is a whole program, or the instructions of a main program alone; empty means no program.

        `parameters` are by group, in engineering units, and override those of `FAST`.
        """
        self.clock = clock or VirtualClock()
        self.store = store if store is not None else MemoryStore()
        self.wires = wires if wires is not None else PlantWires()
        self.can, self.user = RecordedLink[Any](), RecordedLink[SerialMessage]()
        groups = dict(parameters or {})
        groups["general"] = {**FAST["general"], **groups.get("general", {})}
        data: dict[str, Any] = {"inputs": {"I108": is_enabled}, "parameters": groups, **settings}
        with tempfile.TemporaryDirectory() as folder:
            if program:
                file = Path(folder) / "program.I01"
                file.write_text(whole(program))
                data["program"] = file
            self.card = ArpCard(
                self.clock,
                "card1",
                ArpSettings.model_validate(data),
                self.store,
                VirtualBackground(self.clock),
                wires=self.wires,
                can=self.can if with_can else None,
                user=self.user,
            )
        self.access = self.card.access
        self.card.start()

    def add_servo(self, axis: int, **settings: Any) -> Servo:
        """Connect a servo axis between the analog output and the encoder of `axis`; `settings` override those of
        `MOTOR`."""
        assert isinstance(self.wires, PlantWires)
        link = _PlantEnd(self.wires)
        self.wires.plants.append(link)
        ends = {"reference_wire": f"card1.dac{axis}", "encoder_wire": f"card1.encoder{axis}"}
        servo = Servo(self.clock, f"servo{axis}", ServoSettings(**{**MOTOR, **ends, **settings}), link)
        servo.start()
        return servo

    def run_for(self, ms: float) -> "CardBench":
        self.clock.advance_to(self.clock.now_ns() + round(ms * MS))
        return self

    def load(self, data: bytes) -> "CardBench":
        """Load an object file, and wait for the outcome; raise the reason if it is refused."""
        outcomes: list[Exception | None] = []
        self.access.load(data, outcomes.append)
        while not outcomes:
            self.run_for(1)
        if (reason := outcomes[0]) is not None:
            raise reason
        return self

    def drive(self, terminal: str, value: bool | float) -> "CardBench":
        """Send a value on a wire, `I101` or `adc3`."""
        self.wires.deliver(Signal(f"card1.{terminal}", value, UNITS.get(terminal, "")))
        return self

    def last_sent(self, terminal: str) -> bool | float | None:
        """Value that the wire of an output last carried, or None."""
        return next((signal.value for signal in reversed(self.wires.sent) if signal.name == f"card1.{terminal}"), None)

    def get(self, key: str) -> Value:
        return read_point("card", self.card.points(), key)

    def set(self, key: str, value: Value) -> None:
        write_point("card", self.card.points(), key, value)

    def variable(self, number: int) -> float:
        return self.access.V[number] / SCALE

    def put_variable(self, number: int, value: float) -> None:
        assert self.access.set_variables(number, [to_raw(str(value))])

    def position(self, axis: int) -> float:
        return self.access.position(axis) / SCALE

    @property
    def state(self) -> CardState:
        return self.access.state

    @property
    def error(self) -> int:
        return self.access.errors.error

    @property
    def warning(self) -> int:
        return self.access.errors.warning

    @property
    def line(self) -> int:
        """Source line of the next instruction."""
        program = self.access.program
        assert program is not None
        return program.place.line


def whole(program: str) -> str:
    return program if "BEG" in program.upper().split() else f"BEG MAIN\n{program}\nEND"
