"""The messages of one Modbus bus as rows: a request with its answer, and the time between them, in one line."""

from collections.abc import Sequence
from functools import partial
from typing import Any, Final

from fieldrig.traces.instants import span
from fieldrig.traces.parts import Part
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import EXCEPTIONS, FUNCTIONS, decode
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.dialogues import ModbusExchange
from fieldrig_devices.modbus.function_words import request_of, response_of, words
from fieldrig_devices.modbus.names import EMPTY, ModbusNames, request_words, response_words
from fieldrig_devices.modbus.parts import request_parts, response_parts
from fieldrig_devices.named_logs.row import Row, row_of
from fieldrig_devices.named_logs.servers import Servers

READS: Final = frozenset({1, 2, 3, 4, 7, 11, 12, 17, 20, 23, 24, 43})
WRITES: Final = frozenset({5, 6, 15, 16, 21, 22, 23})
SPACES: Final = {
    1: "coils", 2: "discrete_inputs", 3: "holding_registers", 4: "input_registers", 5: "coils",
    6: "holding_registers", 15: "coils", 16: "holding_registers", 22: "holding_registers", 24: "holding_registers",
}  # fmt: skip
SINGLE: Final = frozenset({5, 6, 22, 24})
"""Functions with one address and no number."""
READ_WRITE: Final = 23
EXCEPTION: Final = 0x80
ON: Final = b"\xff\x00"
ANNOUNCED: Final = frozenset({1, 2, 3, 4})
"""Functions whose response has the values."""


class ModbusRows:
    """Makes the rows of one bus."""

    def __init__(self, names: ModbusNames) -> None:
        self.names = names
        self._servers = Servers()

    def row(self, number: int, entry: TraceEntry) -> Row:
        """Return the row of a single message."""
        try:
            message = decode(entry.data)
        except ValueError:
            return row_of(number, entry, ("other",), "", "", entry.data.hex(" "))
        named = self.names(message, entry.sender)
        row = row_of(number, entry, ("modbus",), named.kind, named.node, named.text)
        if isinstance(message, ModbusRequest | ModbusResponse):
            row.unit = message.unit
            row.services = ("modbus", *services_of(message.pdu))
        if isinstance(message, ModbusRequest):
            row.registers = registers_of(message.pdu)
        return row

    def exchange(self, exchange: ModbusExchange, first: TraceEntry) -> Row:
        """Return the row of an exchange; `first` is its request."""
        unit = self.names.unit(exchange.unit)
        function = exchange.request[0]
        is_exception = exchange.exception is not None
        services = ("modbus", *services_of(exchange.request), *(("exception",) if is_exception else ()))
        if exchange.response is None:
            services += ("broadcast",) if exchange.is_broadcast else ("unanswered",)
        return Row(
            exchange.begin_ns,
            exchange.bus,
            first.family,
            exchange.client,
            services,
            FUNCTIONS.get(function, f"function {function}"),
            self._servers.unit_words(exchange, unit.name),
            self._text(exchange),
            exchange.entries,
            exchange.end_ns,
            exchange.response or exchange.request,
            unit=exchange.unit,
            registers=registers_of(exchange.request),
            details=partial(self._details, exchange),
        )

    def _text(self, exchange: ModbusExchange) -> str:
        registers, request, response = self.names.unit(exchange.unit).registers, exchange.request, exchange.response
        is_named = registers is not EMPTY
        asked = request_words(registers, request) if is_named else plain_request(request)
        if response is None:
            wrong = f" ({exchange.wrong})" if exchange.wrong not in ("", "no answer") else ""
            return f"{asked}, to all units" if exchange.is_broadcast else f"{asked}: no answer{wrong}"
        if exchange.exception is not None:
            code = exchange.exception
            asked += f": exception {code:02X}h {EXCEPTIONS.get(code, '')}".rstrip()
        elif request[0] in ANNOUNCED:
            asked = response_words(registers, response, request) if is_named else f"{asked} = {_values(response)}"
        elif request[0] == READ_WRITE:
            asked += f": {response_words(registers, response, request) if is_named else _values(response)}"
        elif request[0] not in WRITES:
            asked = f"{asked}: {response_of(response)}".removeprefix(": ")
        return f"{asked}, in {span((exchange.end_ns or exchange.begin_ns) - exchange.begin_ns)}"

    def _details(self, exchange: ModbusExchange) -> dict[str, Any]:
        registers, request, response = self.names.unit(exchange.unit).registers, exchange.request, exchange.response
        is_read = response is not None and exchange.exception is None and request[0] in (*ANNOUNCED, READ_WRITE)
        parts: Sequence[Part] = response_parts(registers, response or b"", request) if is_read else ()
        if request[0] in WRITES and request[0] != READ_WRITE:
            parts = request_parts(registers, request)[1:]
        return {
            "function": request[0],
            "registers": [
                {"space": space, "address": address, "count": count} for space, address, count in registers_of(request)
            ],
            "values": [{"name": part.key, "value": part.value, "text": part.text} for part in parts],
            "exception": exchange.exception,
            "server": exchange.server,
            "is_done": response is not None,
            "wrong": exchange.wrong,
        }


def plain_request(request: bytes) -> str:
    """Return the addresses of a request to a unit without names, such as `0-3`, with the values that it writes."""
    found, function = registers_of(request), request[0]
    if not found:
        return request_of(request)
    *read, (_, address, count) = found
    place = f"{address}-{address + count - 1}" if count > 1 else f"{address}"
    before = "".join(f"{first}-{first + number - 1}, write " for _, first, number in read)
    match function:
        case 5:
            return f"{place} = {'on' if request[3:5] == ON else 'off'}"
        case 6:
            return f"{place} = {words(request[3:5])}"
        case 15:
            return f"{place} = {request[6:].hex(' ').upper()}"
        case 16:
            return f"{place} = {words(request[6:])}"
        case 22:
            return f"{place} and {words(request[3:5])} or {words(request[5:7])}"
        case 23:
            return f"{before}{place} = {words(request[10:])}"
    return place


def _values(response: bytes) -> str:
    """Return the values of a response that has them: bits as bytes, registers as words."""
    return response[2:].hex(" ").upper() if response[0] in (1, 2) else words(response[2:])


def services_of(pdu: bytes) -> tuple[str, ...]:
    """Return the words for `--service` that choose a message."""
    function = pdu[0] & ~EXCEPTION
    words = [word for word, functions in (("read", READS), ("write", WRITES)) if function in functions]
    return *words, *(("exception",) if pdu[0] & EXCEPTION else ())


def registers_of(request: bytes) -> tuple[tuple[str, int, int], ...]:
    """Return space, first address and number of what a request reads or writes."""
    function = request[0]
    if function == READ_WRITE and len(request) >= 9:
        read, write = request[1:5], request[5:9]
        return tuple(("holding_registers", *_range(part)) for part in (read, write))
    if function not in SPACES or len(request) < 3:
        return ()
    address = int.from_bytes(request[1:3], "big")
    count = 1 if function in SINGLE else int.from_bytes(request[3:5], "big")
    return ((SPACES[function], address, count),)


def _range(part: bytes) -> tuple[int, int]:
    return int.from_bytes(part[:2], "big"), int.from_bytes(part[2:], "big")
