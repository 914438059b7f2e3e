"""Devices of tests: a scale at a serial line, a client and a server of Modbus."""

from collections.abc import Mapping
from functools import partial

from fieldrig import MS, Clock, Device, Link, Point
from fieldrig_bus.modbus.message import ModbusMessage, ModbusRequest, ModbusResponse


class Scale(Device):
    """A scale: `W?` is answered with the weight, anything else with an error, both after a while."""

    def __init__(self, clock: Clock, line: Link[bytes]) -> None:
        self._clock, self._line = clock, line
        self._heard = b""
        line.on_receive(self._on_bytes)

    def _on_bytes(self, data: bytes) -> None:
        self._heard += data
        while b"\r" in self._heard:
            line, _, self._heard = self._heard.partition(b"\r")
            answer = b"12.5 kg\r" if line == b"W?" else b"ERR\r"
            self._clock.call_at(self._clock.now_ns() + 30 * MS, partial(self._line.send, answer))


class Poller(Device):
    """A Modbus client that reads a register of unit 7 ten times a second, and keeps the answer."""

    def __init__(self, clock: Clock, modbus: Link[ModbusMessage]) -> None:
        self._clock, self._modbus = clock, modbus
        self._answer = ""
        modbus.on_receive(self._on_answer, [])

    def start(self) -> None:
        self._modbus.send(ModbusRequest(7, bytes.fromhex("03 0000 0001")))
        self._clock.call_at(self._clock.now_ns() + 100 * MS, self.start)

    def points(self) -> Mapping[str, Point]:
        return {"answer": Point(lambda: self._answer)}

    def _on_answer(self, message: ModbusMessage) -> None:
        self._answer = message.pdu.hex()


class Server(Device):
    """Unit 7."""

    def __init__(self, modbus: Link[ModbusMessage]) -> None:
        self._modbus = modbus
        modbus.on_receive(self._on_request, [7])

    def _on_request(self, message: ModbusMessage) -> None:
        self._modbus.send(ModbusResponse(7, bytes.fromhex("03 02 00 2a"), message.exchange))
