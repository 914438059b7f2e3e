"""A Smart-IO node on a virtual clock, with its links recorded and a PAM that is written down call by call."""

from itertools import count
from typing import Any

from fieldrig.clock import MS, VirtualClock
from fieldrig.device import Value
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusEvent, ModbusRequest, ModbusResponse
from fieldrig_bus.wires import Signal
from fieldrig_devices.pamring.frames import (
    Configuration,
    CounterItem,
    InputChanged,
    InputItem,
    Motor,
    MotorItem,
    MotorOrder,
    MotorReport,
    Order,
    OutputItem,
    Report,
    Trouble,
)
from fieldrig_devices.smart_io.device import SmartIo
from fieldrig_devices.smart_io.settings import SmartIoSettings

INC, DEC, ZERO, COUNTER, MOTOR = 1, 2, 3, 4, 5
"""Items of the motor of the manual's sample: outputs 201 and 202, inputs 102 and 101 (lines 1958 to 2003)."""
TERMINALS = {
    "in101": "motor.pulse", "in102": "motor.zero", "in103": "button", "in208": "limit",
    "out201": "motor.inc", "out202": "motor.dec", "out105": "valve",
    "led6": "lamp", "analog1": "speed", "key12": "start",
}  # fmt: skip


class RecordedPort:
    """The node's end of the ring, which keeps what the PAM would get."""

    def __init__(self) -> None:
        self.sent: list[Report] = []

    def send(self, report: Report) -> None:
        self.sent.append(report)

    def take(self) -> list[Report]:
        sent, self.sent = self.sent, []
        return sent


class SmartIoBench:
    """The node is on.  `configure` does what a PAM does."""

    def __init__(self, store: Store | None = None, **settings: Any) -> None:
        data: dict[str, Any] = {
            "modules": {1: {}, 2: {}},
            "terminals": TERMINALS,
            "modbus": {"turnaround_ms": 0},
        } | settings
        self.clock = VirtualClock()
        self.wires, self.can = RecordedLink[Signal](), RecordedLink[CanFrame]()
        self.modbus = RecordedLink[ModbusEvent]()
        self.device = SmartIo(
            self.clock,
            "io",
            SmartIoSettings.model_validate(data),
            store or MemoryStore(),
            self.wires,
            [self.modbus],
            self.can,
        )
        self.port = RecordedPort()
        self.program = self.device.program
        self._exchanges = count(1)
        self.device.start()

    def configure(self, *items: Configuration) -> None:
        self.program.attach(self.port)
        self.program.forget()
        for item in items:
            assert self.program.accept(item), item
        self.program.run()
        self.port.take()

    def configure_motor(self, *, timeout_ms: int = 500, braking: int = 2) -> None:
        """Configure the motor of the manual's sample."""
        self.configure(
            OutputItem(INC, 201, 1, True),
            OutputItem(DEC, 202, 1, True),
            InputItem(ZERO, 102, 1, True, 1, 1),
            CounterItem(COUNTER, 101, True, 1, 1),
            MotorItem(MOTOR, INC, DEC, ZERO, COUNTER, timeout_ms, braking),
        )

    def order(self, *orders: Order) -> None:
        for order in orders:
            self.program.order(order)

    def move(self, order: Motor, *values: int) -> None:
        self.program.order(MotorOrder(MOTOR, order, values))

    def run(self, time_ms: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(time_ms * MS))

    def wire(self, name: str, value: bool | float) -> None:
        self.wires.deliver(Signal(name, value))

    def pulse(self, times: int = 1, every_ms: int = 10) -> None:
        """Send pulses of the motor."""
        for _ in range(times):
            self.wire("motor.pulse", True)
            self.run(every_ms / 2)
            self.wire("motor.pulse", False)
            self.run(every_ms / 2)

    def last(self, wire: str) -> Any:
        """The present value of a wire that the node drives."""
        return next(signal.value for signal in reversed(self.wires.sent) if signal.name == wire)

    def inputs(self) -> list[tuple[int, int]]:
        """Item and value of the changes that the PAM got since the last call."""
        return [(one.item, one.value) for one in self.port.take() if isinstance(one, InputChanged)]

    def troubles(self) -> list[Trouble]:
        return [report for report in self.port.take() if isinstance(report, Trouble)]

    def motor(self) -> MotorReport:
        """The last report of the motor."""
        return next(one for one in reversed(self.port.sent) if isinstance(one, MotorReport))

    def get(self, key: str) -> Value:
        return self.device.points()[key].read()

    def set(self, key: str, value: Value) -> None:
        write = self.device.points()[key].write
        assert write is not None, key
        write(value)

    def request(self, pdu: str, unit: int = 1) -> str:
        """The response of the Modbus server to a request, both in hex."""
        self.modbus.take()
        self.modbus.deliver(ModbusRequest(unit, bytes.fromhex(pdu), next(self._exchanges)))
        (response,) = self.modbus.take()
        assert isinstance(response, ModbusResponse)
        return response.pdu.hex(" ")

    def sdo(self, request: str, node_id: int = 5) -> str:
        """The response of the SDO server, at once."""
        self.can.take()
        self.can.deliver(CanFrame(0x600 + node_id, bytes.fromhex(request)))
        (frame,) = [frame for frame in self.can.take() if frame.identifier == 0x580 + node_id]
        return frame.data.hex(" ")
