"""A controller with simulated axes on Modbus and CAN, and pymodbus as its client."""

from typing import Any, Self

from max4_rig import Max4Rig
from pymodbus.client.mixin import ModbusClientMixin
from pymodbus.pdu import DecodePDU, ExceptionResponse, ModbusPDU

from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.max4.configuration.tree import Parameter

Type = ModbusClientMixin.DATATYPE
DECODER = DecodePDU(is_server=False)


class FacesBench(Max4Rig):
    """Keywords are settings of the controller; `devices` and `buses` are added to the rig."""

    def __init__(
        self,
        *axes: str,
        devices: dict[str, Any] | None = None,
        buses: dict[str, Any] | None = None,
        modbus_buses: tuple[str, ...] = ("mb",),
        **settings: Any,
    ) -> None:
        drives = {name: {"ring_address": place, "simulated": True} for place, name in enumerate(axes or ("belt",), 1)}
        links: dict[str, Any] = {"wires": "wires", "modbus": list(modbus_buses), "can": "can0"}
        if "ring" in (buses or {}):
            links["ring"] = "ring"
        config = from_dict(
            {
                "time": "virtual",
                "seed": 7,
                "buses": {
                    "mb": {"kind": "modbus.virtual", "servers": [7]},
                    "can0": {"kind": "can.virtual", "bitrate": 500_000},
                    "wires": {"kind": "wires.virtual"},
                    **(buses or {}),
                },
                "devices": {"max4": {"kind": "max4", "links": links, "drives": drives, **settings}, **(devices or {})},
            }
        )
        self.frames: list[tuple[int, str]] = []
        """The frames on CAN, with their times in ns."""
        self.requests: list[tuple[int, int, str]] = []
        """The requests on Modbus: time, unit, PDU."""
        self.rig = Rig(config, self._on_delivery)
        self.outside = self.rig.attach("outside")
        self.answers: list[ModbusResponse] = []
        self.outside.link("mb").on_receive(self.answers.append, ())
        self.client = Client(self)

    def _on_delivery(self, bus: Any, delivery: Any) -> None:
        message = delivery.message
        if isinstance(message, CanFrame):
            data = "R" if message.is_remote else message.data.hex(" ")
            self.frames.append((delivery.time_ns, f"{message.identifier:03X}#{data}"))
        elif isinstance(message, ModbusRequest):
            self.requests.append((delivery.time_ns, message.unit, message.pdu.hex(" ")))

    def parameter(self, path: str) -> Parameter:
        return self.max4.firmware.tree.parameter(path)

    def boot(self, ms: float = 100) -> Self:
        self.run(ms)
        assert self.max4.firmware.is_booted
        return self

    def take_frames(self) -> list[str]:
        taken, self.frames = self.frames, []
        return [frame for _, frame in taken]

    # ---- Modbus, with bytes of ours

    def ask(self, pdu: str, unit: int = 1) -> str:
        """The PDU of the answer; "" for silence."""
        self.answers.clear()
        self.outside.link("mb").send(ModbusRequest(unit, bytes.fromhex(pdu), 7))
        for _ in range(20):
            if self.answers:
                return self.answers[0].pdu.hex(" ")
            self.run(1)
        return ""

    # ---- Modbus, with pymodbus

    def read(self, address: int, type: Type = Type.UINT16, words: int = 0) -> Any:
        count = words or type.value[1]
        answer = self.client.read_holding_registers(address, count=count)
        assert not answer.isError(), answer
        return self.client.convert_from_registers(answer.registers, type)

    def write(self, address: int, value: Any, type: Type = Type.UINT16) -> int:
        """The exception code; 0 if it went well."""
        answer = self.client.write_registers(address, self.client.convert_to_registers(value, type))
        return answer.exception_code if isinstance(answer, ExceptionResponse) else 0


class Client(ModbusClientMixin[ModbusPDU]):
    """pymodbus' client without its sockets: virtual time passes until the answer is there."""

    def __init__(self, bench: FacesBench) -> None:
        self._bench = bench

    def execute(self, no_response_expected: bool, request: ModbusPDU) -> ModbusPDU:
        pdu = bytes((request.function_code,)) + request.encode()
        answer = self._bench.ask(pdu.hex(), request.dev_id)
        assert answer, "no answer"
        decoded = DECODER.decode(bytes.fromhex(answer))
        assert decoded is not None
        return decoded
