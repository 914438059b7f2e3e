"""An HMISCU on a virtual clock, with its links recorded."""

from itertools import count
from pathlib import Path
from typing import Any, TypeVar

from fieldrig.clock import MS, VirtualClock
from fieldrig.device import Value
from fieldrig.loop.background import VirtualBackground
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusEvent, ModbusRequest, ModbusResponse
from fieldrig_bus.wires import Signal
from fieldrig_devices.hmiscu.device import Hmiscu
from fieldrig_devices.hmiscu.settings import HmiscuSettings

WIRES = {"FQ0": "pulse", "FQ1": "direction", "DI2": "drive.ready", "DQ0": "lamp"}
PTO: dict[str, Any] = {"mode": "pto", "hand_over_ms": 0}
M = TypeVar("M", bound=Signal)


class DeviceBench:
    """The controller is in RUN.  Without `source` it has no program."""

    def __init__(
        self, folder: Path | None = None, source: str = "", store: Store | None = None, **settings: Any
    ) -> None:
        data: dict[str, Any] = {"terminals": WIRES, "modbus": {"turnaround_ms": 0}} | settings
        if source:
            assert folder is not None
            path = folder / "program.st"
            path.write_text(source, encoding="ascii")
            data["program"] = str(path)
        self.clock = VirtualClock()
        self.wires, self.modbus, self.can = (
            RecordedLink[Signal](),
            RecordedLink[ModbusEvent](),
            RecordedLink[CanFrame](),
        )
        self.device = Hmiscu(
            self.clock,
            "scu",
            HmiscuSettings.model_validate(data),
            store or MemoryStore(),
            VirtualBackground(self.clock),
            self.wires,
            [self.modbus],
            self.can,
        )
        self._exchanges = count(1)
        self.device.start()

    def run(self, time_ms: int) -> None:
        self.clock.advance_to(self.clock.now_ns() + time_ms * MS)

    def get(self, key: str) -> Value:
        point = self.device.find(key)
        assert point is not None, key
        return point.read()

    def set(self, key: str, value: Value) -> None:
        point = self.device.find(key)
        assert point is not None, key
        assert point.write is not None, key
        point.write(value)

    def wire(self, name: str, value: bool | float, unit: str = "") -> None:
        self.wires.deliver(Signal(name, value, unit))

    def driven(self, name: str) -> list[Signal]:
        """The signals on a wire since the start."""
        return [signal for signal in self.wires.sent if signal.name == name]

    def level(self, name: str) -> object:
        return self.driven(name)[-1].value

    def ask(self, pdu: str) -> str:
        """The response of unit 1 to a Modbus request."""
        self.modbus.deliver(ModbusRequest(1, bytes.fromhex(pdu), next(self._exchanges)))
        answer = self.modbus.sent[-1]
        assert isinstance(answer, ModbusResponse)
        return answer.pdu.hex()
