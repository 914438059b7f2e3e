"""Functions 11 and 12 on a serial line: the event counter and the log, after V1.1b3, 6.9 and 6.10."""

from fieldrig_bus.modbus.errors import SERVER_DEVICE_FAILURE, ModbusError
from fieldrig_bus.modbus.message import LineState, ModbusRequest
from fieldrig_bus.modbus.server import ModbusServer

RESTART_AND_CLEAR, RESTART, LISTEN_ONLY, CLEAR = "08 0001 ff00", "08 0001 0000", "08 0004 0000", "08 000a 0000"


class Memory:
    """Sixteen coils and registers; the last one is broken."""

    def read(self, address: int, quantity: int) -> bytes:
        if address + quantity > 15:
            raise ModbusError(SERVER_DEVICE_FAILURE)
        return bytes(2 * quantity)

    def write(self, *_: object) -> None:
        pass


class Data:
    coils = discrete_inputs = holding_registers = input_registers = Memory()

    def fifo(self, address: int) -> list[int]:
        return []

    def exception_status(self) -> int:
        return 0


class Line:
    """A server at a serial line whose frames may have been damaged before."""

    def __init__(self) -> None:
        self.server, self.errors = ModbusServer(Data()), 0

    def ask(self, pdu: str, unit: int = 1) -> str | None:
        answer = self.server.answer(ModbusRequest(unit, bytes.fromhex(pdu), line=LineState(9, self.errors)))
        return None if answer is None else answer.hex()

    def count(self) -> str | None:
        return self.ask("0b")

    def events(self) -> str:
        """The log without the message that reads it."""
        log = self.ask("0c")
        assert log is not None
        data = bytes.fromhex(log)
        assert data[1] == len(data) - 2
        assert data[8] == 0x80 | (data[8] & 0x20)
        return data[9:].hex(" ")


def test_what_is_executed_is_counted_and_neither_fetches_nor_exceptions_are() -> None:
    line = Line()
    for pdu in ("03 0000 0001", "06 0001 1234", "05 0002 ff00"):
        line.ask(pdu)
    assert line.count() == "0b00000003"
    line.ask("03 ffff 0001")
    line.ask("0c")
    line.ask("41")
    assert line.count() == "0b00000003"
    line.ask("06 0001 1234", unit=0)
    assert line.count() == "0b00000004"


def test_a_restart_or_a_clear_clears_the_counter() -> None:
    line = Line()
    for pdu in (RESTART, CLEAR):
        line.ask("03 0000 0001")
        line.ask(pdu)
        assert line.count() == ("0b00000000" if pdu == RESTART else "0b00000001")  # the clear itself is completed


def test_the_log_has_the_latest_event_first() -> None:
    line = Line()
    line.ask("03 0000 0001")  # received, sent
    line.ask("03 0000 0000")  # received, exception 3 sent
    line.ask("03 000f 0001")  # received, exception 4 sent
    line.errors = 2
    line.ask("06 0000 0001", unit=0)  # a broadcast after damaged frames
    assert line.events() == "40 c2 42 80 41 80 40 80"


def test_listen_only_mode_and_restart_are_events_of_their_own() -> None:
    line = Line()
    assert line.ask(LISTEN_ONLY) is None
    line.ask("03 0000 0001")
    line.ask(RESTART)
    assert line.events() == "00 a0 a0 04 80"
    line.ask(RESTART_AND_CLEAR)
    assert line.events() == "00"


def test_the_log_has_the_number_of_messages_and_at_most_64_events() -> None:
    line = Line()
    for _ in range(40):
        line.ask("03 0000 0001")
    log = line.ask("0c")
    assert log is not None
    assert log[:16] == "0c46" + "0000" + "0028" + "0029"  # 70 bytes: 6 and 64 events; 40 completed, 41 messages
    assert len(log) == 2 * (2 + 70)


def test_there_is_no_log_without_a_serial_line_and_a_wrong_length_is_a_wrong_value() -> None:
    server = ModbusServer(Data())
    for function in (0x0B, 0x0C):
        answer = server.answer(ModbusRequest(1, bytes((function,))))
        assert answer == bytes((function | 0x80, 0x01))
    assert Line().ask("0b 00") == "8b03"
    assert Line().ask("0c 0000") == "8c03"
