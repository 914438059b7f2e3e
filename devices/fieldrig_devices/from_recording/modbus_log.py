"""One Modbus bus of a recording: units, their registers, what they refuse, and how long they take.

Source: Modbus application protocol V1.1b3, chapter 6.
"""

import struct
from collections import Counter
from collections.abc import Sequence
from heapq import heappop, heappush
from typing import Final

from fieldrig.clock import S
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import REQUEST_ON_ASCII, REQUEST_ON_RTU
from fieldrig_bus.modbus.identification import INDIVIDUAL_TOO
from fieldrig_devices.dialogues import Dialogue, ModbusDialogues, ModbusExchange
from fieldrig_devices.from_recording.answer_log import AnswerLog
from fieldrig_devices.from_recording.line_rate import LineRate
from fieldrig_devices.from_recording.register_log import (
    HOLDING_REGISTERS,
    MASK_WRITE,
    READERS,
    WRITE_COIL,
    WRITE_COILS,
    WRITE_REGISTER,
    WRITE_REGISTERS,
    Group,
    GroupLog,
    RegisterLog,
    group_of,
    values_read,
    values_written,
)
from fieldrig_devices.from_recording.series import Room
from fieldrig_devices.from_recording.silences import Silences
from fieldrig_devices.modbus.answer_times import Answer, Kind, kind_of
from fieldrig_devices.registers.table import SPACES

STATUS, SERVER_ID, INTERFACE, READ_DEVICE_ID = 7, 17, 43, 14
EXCEPTION: Final = 0x80
ON_ASCII: Final = bytes((REQUEST_ON_ASCII,))
ON_LINE: Final = (bytes((REQUEST_ON_RTU,)), ON_ASCII)
"""The first byte of the requests of a serial line."""
MOST_INSTANTS: Final = 4_096
MOST_SERVERS: Final = 64
PATIENCE_NS: Final = 10 * S
"""How long an exchange waits for those that began before it."""
MOST_WAITING: Final = 10_000
MOST_TIMES, LEAST_TIMES, MANY_KINDS = 4_096, 512, 16
"""Requests of a kind whose times are kept; those of the further kinds of a unit are fewer."""
MOST_CLIENTS: Final = 10_000
MOST_GROUPS: Final = 2_000


class UnitLog:
    """One unit."""

    def __init__(self, room: Room) -> None:
        self._room = room
        self.spaces: dict[str, dict[int, RegisterLog]] = {space: {} for space in SPACES}
        self.groups: dict[Group, GroupLog] = {}
        self.identification: dict[int, bytes] = {}
        self.identified_as = 0
        """The level of the identification: 1 basic, 2 regular, 3 extended; 0 if it was not read."""
        self.server_id: bytes | None = None
        self.status: int | None = None
        self.answers_of: dict[Kind, AnswerLog] = {}
        """The times of the answers to each kind of requests."""
        self.longest_answer_ns = 0
        self.functions: Counter[int] = Counter()
        """Functions of which nothing is taken."""
        self.refused_functions: dict[bytes, int] = {}
        """Exception codes of functions without an address, by the requests."""
        self.done_functions: set[int] = set()
        """Functions without an address that were carried out."""
        self.silences = Silences()
        self.unanswered = self.answers = self.left_out = 0

    def take(self, exchange: ModbusExchange) -> None:
        request, response = exchange.request, exchange.response
        self.silences.take(exchange.begin_ns, request[0], bool(response))
        if response is None or exchange.end_ns is None or not response:
            self.unanswered += 1
            self._time(request, exchange.begin_ns, Answer(None))
            return
        self.answers += 1
        time_ns = max(exchange.end_ns - exchange.begin_ns, 0)  # the time of a log may jump back
        self.longest_answer_ns = max(self.longest_answer_ns, time_ns)
        self._time(request, exchange.begin_ns, Answer(time_ns, exchange.exception or 0), len(response))
        group = group_of(request)
        log = None if group is None else self._group(group)
        if log is not None:
            log.count += 1
            if len(log.instants) < MOST_INSTANTS:
                log.instants.append(exchange.begin_ns)
        if response[0] & EXCEPTION:
            code = response[1] if len(response) > 1 else 0
            if log is not None:
                log.refused[code] += 1
                log.refused_request = request
            else:
                self.refused_functions.setdefault(request, code)
            return
        if log is None:
            self.done_functions.add(request[0])
        else:
            log.sample = log.sample or (request, response)
        self._carry_out(exchange.begin_ns, request, response)

    def _time(self, request: bytes, begin_ns: int, answer: Answer, size: int = 0) -> None:
        kind = kind_of(None, request)
        log = self.answers_of.get(kind)
        if log is None and len(self.answers_of) < MOST_GROUPS:
            log = self.answers_of[kind] = AnswerLog(MOST_TIMES if len(self.answers_of) < MANY_KINDS else LEAST_TIMES)
        if log is not None:
            log.take(begin_ns, answer, size)

    def _group(self, group: Group) -> GroupLog | None:
        log = self.groups.get(group)
        if log is None and len(self.groups) < MOST_GROUPS:
            log = self.groups[group] = GroupLog()
        self.left_out += log is None
        return log

    def _carry_out(self, time_ns: int, request: bytes, response: bytes) -> None:
        function = request[0]
        for space, address, value in values_written(request):
            self._register(space, address).write(time_ns, value)
        if function in READERS:
            for space, address, value in values_read(request, response):
                self._register(space, address).read(time_ns, value)
        elif function == MASK_WRITE and len(request) == 7:
            self._mask(time_ns, request)
        elif function == STATUS and len(response) == 2:
            self.status = response[1]
        elif function == SERVER_ID and len(response) > 2:
            self.server_id = response[2:]
        elif function == INTERFACE and request[1:2] == bytes((READ_DEVICE_ID,)):
            self._identify(response)
        elif function not in (WRITE_COIL, WRITE_REGISTER, WRITE_COILS, WRITE_REGISTERS):
            self.functions[function] += 1

    def _mask(self, time_ns: int, request: bytes) -> None:
        address, and_mask, or_mask = struct.unpack(">HHH", request[1:])
        register = self._register(HOLDING_REGISTERS, address)
        register.write(time_ns, (register.last or 0) & and_mask | or_mask & ~and_mask & 0xFFFF)

    def _register(self, space: str, address: int) -> RegisterLog:
        registers = self.spaces[space]
        register = registers.get(address)
        if register is None:
            register = registers[address] = RegisterLog(self._room)
        return register

    def _identify(self, response: bytes) -> None:
        """Take the objects of an answer of function 43/14: a head of 7 bytes, then id, length and text of each."""
        at = 7
        if len(response) > at:
            self.identified_as = response[3] & ~INDIVIDUAL_TOO
        while at + 2 <= len(response):
            number, size = response[at], response[at + 1]
            text = response[at + 2 : at + 2 + size]
            if len(text) == size:
                self.identification[number] = text
            at += 2 + size


class ModbusLog:
    """One bus, or one server of a network."""

    def __init__(self) -> None:
        self.units: dict[int, UnitLog] = {}
        self.servers: dict[str, ModbusLog] = {}
        """The servers of a capture of a network by their addresses, as each has units of its own."""
        self.start_ns = self.end_ns = 0
        self.broadcasts = 0
        self.is_line = self.is_ascii = False
        self.rate: LineRate | None = None
        """The signs of the rate of a line that was captured as bytes; messages of a bus do not have its times."""
        self._server_of: dict[str, str] = {}
        """The servers of clients, which are connections in a capture of a network."""
        self._dialogues = ModbusDialogues()
        self._room = Room()
        self._waiting: list[tuple[int, int, ModbusExchange]] = []
        """Exchanges by the instants of their requests."""
        self._number = 0

    def take(self, number: int, entry: TraceEntry) -> None:
        """Take a message; `number` is its place in the recording, from 0."""
        self.is_line |= entry.data[:1] in ON_LINE
        self.is_ascii |= entry.data[:1] == ON_ASCII
        self._order(self._dialogues.take(number, entry))
        while self._waiting and (
            self._waiting[0][0] < entry.time_ns - PATIENCE_NS or len(self._waiting) > MOST_WAITING
        ):
            self._take_exchange(heappop(self._waiting)[2])

    def take_bytes(self, entry: TraceEntry) -> None:
        """Take bytes of a line, in front of the messages that they complete."""
        if self.rate is None:
            self.rate = LineRate()
        self.rate.take(entry)

    def end(self, start_ns: int, end_ns: int) -> None:
        """Take what the recording, which is from `start_ns` to `end_ns`, has left open."""
        self.start_ns, self.end_ns = start_ns, end_ns
        self._order(self._dialogues.unfinished())
        while self._waiting:
            self._take_exchange(heappop(self._waiting)[2])
        self._settle()

    def _order(self, ended: Sequence[Dialogue]) -> None:
        """Let exchanges wait for those that began earlier and end later: a value is that of its request."""
        for exchange in ended:
            if isinstance(exchange, ModbusExchange):
                self._number += 1
                heappush(self._waiting, (exchange.begin_ns, self._number, exchange))

    def _take_exchange(self, exchange: ModbusExchange) -> None:
        if exchange.is_broadcast:
            self.broadcasts += 1
            return
        log = self._server(self._sender(exchange))
        if exchange.unit not in log.units:
            log.units[exchange.unit] = UnitLog(self._room)
        log.units[exchange.unit].take(exchange)
        if self.rate is not None and exchange.response and exchange.end_ns is not None:
            self.rate.take_exchange(len(exchange.request), len(exchange.response), exchange.end_ns - exchange.begin_ns)

    def _sender(self, exchange: ModbusExchange) -> str:
        """Return the server of an exchange; that of a request without an answer is the last one that its client had."""
        if exchange.server and (len(self._server_of) < MOST_CLIENTS or exchange.client in self._server_of):
            self._server_of[exchange.client] = exchange.server
        return exchange.server or self._server_of.get(exchange.client, "")

    def _server(self, sender: str) -> "ModbusLog":
        """Return the log for the messages of a server; one that is no address of a network is the bus."""
        host, _, port = sender.rpartition(":")
        if not port.isdigit() or not ("." in host or ":" in host):
            return self
        if sender not in self.servers and len(self.servers) >= MOST_SERVERS:
            return self
        return self.servers.setdefault(sender, ModbusLog())

    def _settle(self) -> None:
        """Give a single server what belongs to no server, such as requests without an answer."""
        for log in self.servers.values():
            log.start_ns, log.end_ns = self.start_ns, self.end_ns
            log.is_line, log.is_ascii = self.is_line, self.is_ascii
        if len(self.servers) == 1:
            (only,) = self.servers.values()
            self.servers = {}
            for unit_id, unit in self.units.items():
                known = only.units.setdefault(unit_id, unit)
                if known is not unit:
                    known.unanswered += unit.unanswered
                    known.silences.add(unit.silences)
                    for kind, answers in unit.answers_of.items():
                        known.answers_of.setdefault(kind, AnswerLog(MOST_TIMES)).add(answers)
            self.units = only.units
