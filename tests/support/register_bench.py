"""A `modbus.device` on two buses and wires, with a clock that a test moves by hand."""

from pathlib import Path
from typing import Any

from fieldrig.clock import VirtualClock
from fieldrig.storage.store import MemoryStore
from fieldrig.testing import RecordedLink
from fieldrig_bus.modbus.message import LineState, ModbusRequest, ModbusResponse
from fieldrig_bus.wires import Signal
from fieldrig_devices.modbus.device import ModbusDevice, ModbusDeviceSettings


class Bench:
    """A device with two buses, wires, and a clock moved by hand."""

    def __init__(
        self, folder: Path, table: str | Path | None, store: MemoryStore | None = None, **entries: Any
    ) -> None:
        if isinstance(table, str):
            (folder / "t.yaml").write_text(table)
            table = folder / "t.yaml"
        wanted = {"table": table, "turnaround_ms": 0.0, **entries}
        self.settings = ModbusDeviceSettings.model_validate(
            {key: value for key, value in wanted.items() if value is not None}, context={"folder": folder}
        )
        self.clock = VirtualClock()
        self.tcp: RecordedLink[ModbusRequest | ModbusResponse] = RecordedLink()
        self.rtu: RecordedLink[ModbusRequest | ModbusResponse] = RecordedLink()
        self.wires: RecordedLink[Signal] = RecordedLink()
        self.store = MemoryStore() if store is None else store
        self.device = ModbusDevice(self.clock, self.settings, [self.tcp, self.rtu], self.store, self.wires)
        self.device.start()

    def ask(self, request: str, unit: int = 1, line: LineState | None = None) -> str | None:
        link = self.tcp if line is None else self.rtu
        link.deliver(ModbusRequest(unit, bytes.fromhex(request), 5, line))
        answers = link.take()
        assert all(isinstance(answer, ModbusResponse) and answer.exchange == 5 for answer in answers)
        return " ".join(answer.pdu.hex() for answer in answers) or None

    def point(self, key: str) -> Any:
        return self.device.points()[key].read()

    def set(self, key: str, value: Any) -> None:
        write = self.device.points()[key].write
        assert write is not None
        write(value)
