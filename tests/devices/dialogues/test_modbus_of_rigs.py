"""Modbus exchanges in a trace of a rig: the client's unit and transaction are not those that its server sees."""

import pytest

from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import encode
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.model import ModbusModel
from fieldrig_bus.traces.modbus_packet import PacketMaker, messages_in
from fieldrig_devices.dialogues import ModbusExchange, dialogues
from fieldrig_devices.modbus.names import ModbusNames

READ, VALUES = bytes.fromhex("03 00 6B 00 03"), bytes.fromhex("03 06 02 2B 00 00 00 64")  # V1.1b3, 6.3
OTHER = bytes.fromhex("03 06 00 01 00 02 00 03")


class Bus:
    """A bus with a server of unit 1, and its trace."""

    def __init__(self, *clients: str) -> None:
        self.model, self.trace = ModbusModel(), list[TraceEntry]()
        for member in ("meter", *clients):
            self.model.join(member)
        self.model.listen(0, "meter", [1])

    def send(self, member: str, message: ModbusRequest | ModbusResponse) -> ModbusRequest | ModbusResponse:
        """Return the message as it is delivered."""
        self.model.submit(0, member, message)
        (delivery,) = self.model.collect(0)
        assert isinstance(delivery.message, ModbusRequest | ModbusResponse)
        self.trace.append(TraceEntry(0, "mb", "modbus", delivery.sender, encode(delivery.message)))
        return delivery.message

    def exchanges(self) -> list[tuple[str, int, bytes | None, tuple[int, ...]]]:
        found = [one for one in dialogues(self.trace) if isinstance(one, ModbusExchange)]
        return [(one.client, one.unit, one.response, one.entries) for one in found]


@pytest.mark.parametrize("unit", [0, 255])
def test_a_client_that_asks_for_no_unit_gets_its_answer(unit: int) -> None:
    """Modbus on TCP, 4.2.1.8: unit 255, or 0, for a server that its address identifies."""
    bus = Bus("plc")
    asked = bus.send("plc", ModbusRequest(unit, READ, 9))
    answer = bus.send("meter", ModbusResponse(asked.unit, VALUES, asked.exchange))
    assert (answer.unit, answer.exchange) == (unit, 9)
    assert bus.exchanges() == [("plc", 1, VALUES, (0, 1))]


def test_answers_in_another_order_are_those_of_their_requests() -> None:
    bus = Bus("plc", "panel")
    asked = [bus.send(client, ModbusRequest(1, READ, 5)) for client in ("plc", "panel", "plc")]
    for number, data in ((2, OTHER), (0, VALUES), (1, OTHER)):
        bus.send("meter", ModbusResponse(1, data, asked[number].exchange))
    assert bus.exchanges() == [
        ("plc", 1, OTHER, (2, 3)), ("plc", 1, VALUES, (0, 4)), ("panel", 1, OTHER, (1, 5)),
    ]  # fmt: skip


def test_the_names_of_an_answer_are_those_of_its_request() -> None:
    bus, names = Bus("plc"), ModbusNames({})
    asked = bus.send("plc", ModbusRequest(255, READ, 9))
    names(asked)
    named = names(bus.send("meter", ModbusResponse(asked.unit, VALUES, asked.exchange)))
    assert (named.node, named.text) == ("unit 1", "107 022Bh, 108 0000h, 109 0064h")


def test_packets_have_the_transaction_and_unit_of_the_request() -> None:
    bus, maker = Bus("plc"), PacketMaker(0)
    asked = [bus.send("plc", ModbusRequest(255, READ, number)) for number in (70, 71)]
    answers = [bus.send("meter", ModbusResponse(1, data, asked[n].exchange)) for n, data in ((1, OTHER), (0, VALUES))]
    shown = [one for message in (*asked, *answers) for _, one in messages_in(maker.make("x", message))]
    assert [(one.unit, one.exchange) for one in shown] == [(1, 1), (1, 2), (1, 2), (1, 1)]


def test_an_unknown_unit_is_answered_by_the_gateway_in_one_exchange() -> None:
    bus = Bus("plc")
    bus.model = ModbusModel(answers_for_unknown_units=True)
    bus.model.join("plc")
    bus.model.submit(0, "plc", ModbusRequest(7, READ, 3))
    bus.trace = [TraceEntry(0, "mb", "modbus", one.sender, encode(one.message)) for one in bus.model.collect(0)]
    assert bus.exchanges() == [("plc", 7, b"\x83\x0b", (0, 1))]
