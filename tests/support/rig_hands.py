"""Hands on a rig in virtual time, as an operator's programs have them: a CANopen master and a Modbus client.

They are members of the rig's buses and send what a foreign master would; nothing here looks into a device.
"""

from typing import Any

from fieldrig.clock import MS
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse

STATES = ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27))
"""Control words on the way to Operation enabled, and the status word's bits that answer each (CiA 402)."""
STATE_MASK = 0x6F
PATIENCE_NS = 5_000 * MS
START_ALL = CanFrame(0x000, bytes.fromhex("01 00"))
SYNC = CanFrame(0x080)


class CanMaster:
    """Expedited SDO, NMT and SYNC on one CAN bus."""

    def __init__(self, rig: Rig, bus: str, member: str = "can_master") -> None:
        self._rig = rig
        self._link = rig.attach(member).link(bus)
        self._link.on_receive(self._on_frame, [(0x580, 0x780)])
        self._answers: dict[int, bytes] = {}
        """Data by identifier, since the last question."""

    def send(self, frame: CanFrame) -> None:
        self._link.send(frame)

    def start_all(self) -> None:
        """NMT: all nodes to operational."""
        self.send(START_ALL)

    def write(self, node: int, index: int, subindex: int, value: int, size: int) -> None:
        """AssertionError if the node refuses or doesn't answer."""
        data = value.to_bytes(size, "little", signed=value < 0)
        head = bytes((0x23 | 4 - size << 2,)) + index.to_bytes(2, "little") + bytes((subindex,))
        answer = self._ask(node, head + data.ljust(4, b"\0"))
        assert answer[0] == 0x60, f"node {node} refuses {index:04X}h: {answer.hex(' ')}"

    def read(self, node: int, index: int, subindex: int = 0) -> int:
        """AssertionError if the node refuses or doesn't answer."""
        answer = self._ask(node, b"\x40" + index.to_bytes(2, "little") + bytes((subindex, 0, 0, 0, 0)))
        assert answer[0] & 0xE2 == 0x42, f"node {node} refuses {index:04X}h: {answer.hex(' ')}"
        return int.from_bytes(answer[4 : 8 - (answer[0] >> 2 & 3)], "little")

    def reset(self, node: int, axis: int) -> None:
        """Send a fault reset to an axis of a CiA 402 node."""
        for word in (0x00, 0x80, 0x00):
            self.write(node, 0x6040 + 0x800 * axis, 0, word, 2)
            self._rig.run_until(self._rig.now_ns + 20 * MS)

    def run_at(self, node: int, axis: int, speed: int) -> None:
        """Enable an axis of a CiA 402 node in profile velocity mode, and let it run (increments/s)."""
        base = 0x800 * axis
        self.write(node, 0x6060 + base, 0, 3, 1)
        for word, state in STATES:
            self.write(node, 0x6040 + base, 0, word, 2)
            end_ns = self._rig.now_ns + PATIENCE_NS
            while self.read(node, 0x6041 + base) & STATE_MASK != state:
                assert self._rig.now_ns < end_ns, f"axis {axis} of node {node} does not reach {state:#x}"
                self._rig.run_until(self._rig.now_ns + 4 * MS)
        self.write(node, 0x60FF + base, 0, speed, 4)

    def _ask(self, node: int, data: bytes) -> bytes:
        self._answers.clear()
        self._link.send(CanFrame(0x600 + node, data))
        end_ns = self._rig.now_ns + PATIENCE_NS
        while 0x580 + node not in self._answers:
            assert self._rig.now_ns < end_ns, f"node {node} does not answer"
            self._rig.step()
        return self._answers[0x580 + node]

    def _on_frame(self, frame: CanFrame) -> None:
        self._answers[frame.identifier] = frame.data


class ModbusClient:
    """A client with one request at a time to one unit."""

    def __init__(self, rig: Rig, bus: str, unit: int = 1, member: str = "scada") -> None:
        self._rig, self._unit = rig, unit
        self._link = rig.attach(member).link(bus)
        self._link.on_receive(self._on_message)
        self._answers: list[bytes] = []
        self._exchange = 0
        """The exchange whose answer is awaited; 0 for exchanges whose answer is not."""

    def write(self, address: int, *words: int) -> None:
        """Registers, function 16.  AssertionError if the unit refuses or doesn't answer."""
        data = b"".join((word & 0xFFFF).to_bytes(2, "big") for word in words)
        head = b"\x10" + address.to_bytes(2, "big") + len(words).to_bytes(2, "big") + bytes((len(data),))
        self._ask(head + data)

    def read(self, address: int, count: int = 1) -> list[int]:
        """Holding registers, function 3."""
        answer = self._ask(b"\x03" + address.to_bytes(2, "big") + count.to_bytes(2, "big"))
        return [int.from_bytes(answer[place : place + 2], "big") for place in range(2, len(answer), 2)]

    def post(self, pdu: bytes) -> None:
        """A request whose answer is not awaited."""
        self._link.send(ModbusRequest(self._unit, pdu))

    def _ask(self, pdu: bytes) -> bytes:
        self._answers.clear()
        self._exchange += 1
        self._link.send(ModbusRequest(self._unit, pdu, self._exchange))
        end_ns = self._rig.now_ns + PATIENCE_NS
        while not self._answers:
            assert self._rig.now_ns < end_ns, f"unit {self._unit} does not answer"
            self._rig.step()
        (answer,) = self._answers
        assert answer[0] == pdu[0], f"unit {self._unit} refuses {pdu.hex(' ')}: {answer.hex(' ')}"
        return answer

    def _on_message(self, message: Any) -> None:
        if isinstance(message, ModbusResponse) and message.exchange == self._exchange:
            self._answers.append(message.pdu)
