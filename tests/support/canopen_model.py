"""The expected dictionary of the I/O module, from nothing but its EDS and the frames that went in and out.

Written from CiA 301, 305 and 306 beside the node, sharing no code with it, as the oracle of the fuzz tests.  It knows
where the node has a choice from what the node said: a write counts when the server confirmed it.

Left out: 1001h and 1003h, which tell of errors, not of what was written.
"""

from collections.abc import Callable, Iterator
from configparser import RawConfigParser
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

Key = tuple[int, int]
MS = 1_000_000
SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 1, 6: 2, 7: 4, 8: 4, 0x10: 3, 0x11: 8, 0x15: 8, 0x16: 3, 0x1B: 8}
STOPPED, OPERATIONAL, PRE_OPERATIONAL = 4, 5, 127
NOT_COMPARED = {0x1001, 0x1003}


class Frame(NamedTuple):
    time_ns: int
    key: int
    """Identifier, 29-bit ones with bit 31."""
    data: bytes
    is_remote: bool = False


@dataclass(frozen=True)
class Described:
    """One variable of the file."""

    data_type: int
    access: str
    is_mappable: bool
    default: str

    def start(self, node_id: int) -> bytes:
        if self.data_type == 9:
            return self.default.encode()
        if self.data_type == 0xF:
            return b""
        total = sum(node_id if part == "$NODEID" else int(part, 0) for part in (self.default or "0").split("+"))
        return (total & (1 << SIZES[self.data_type] * 8) - 1).to_bytes(SIZES[self.data_type], "little")

    @property
    def is_writable(self) -> bool:
        return self.access in ("rw", "rwr", "rww", "wo")

    @property
    def is_output(self) -> bool:
        return self.is_mappable and self.access in ("rww", "wo")


def read(path: Path) -> dict[Key, Described]:
    file = RawConfigParser()
    file.read(path)
    found = {}
    for name in file.sections():
        index, _, sub = name.partition("sub")
        if len(index) != 4 or file[name].get("ObjectType", "7") in ("0x8", "0x9"):
            continue
        section = file[name]
        found[int(index, 16), int(sub or "0", 16)] = Described(
            int(section["DataType"], 0),
            section["AccessType"],
            section["PDOMapping"] == "1",
            section.get("DefaultValue", ""),
        )
    return found


@dataclass
class Server:
    """The state of one SDO server, as its client sees it."""

    index: int
    key: bytes = b""
    data: bytearray = field(default_factory=bytearray)
    phase: str = ""
    sequence: int = 0
    block: int = 0

    def saw(self, request: bytes, answers: list[bytes], write: Callable[[bytes, bytes], None]) -> None:
        """Take one request and all answers to it; `write` is called with a value that the server has accepted."""
        if self.phase == "upload":
            is_over = answers[0][0] == 0x80 if answers else request[0] & 0xE0 == 0x80 or request[0] & 0xE3 == 0xA1
            if is_over:
                self.phase = ""
            return
        if self.phase == "block":
            self._on_segment(request)
        for answer in answers:
            self._on_answer(request, answer, write)
        is_abort = request[0] == 0x80 if self.phase == "block" else request[0] & 0xE0 == 0x80
        if is_abort:
            self.phase = ""

    def _on_segment(self, request: bytes) -> None:
        if request[0] & 0x7F == self.sequence + 1 <= self.block:
            self.sequence += 1
            self.data += request[1:]
            if request[0] & 0x80:
                self.phase = "ending"

    def _on_answer(self, request: bytes, answer: bytes, write: Callable[[bytes, bytes], None]) -> None:
        command, kind = request[0], answer[0] & 0xE0
        if kind == 0x80:
            self.phase = ""
        elif kind == 0x60 and command & 0x02:
            size = 4 - (command >> 2 & 3) if command & 0x01 else 4
            write(request[1:4], request[4 : 4 + size])
        elif kind == 0x60:
            self._begin(request, "segments")
        elif kind == 0x20 and self.phase == "segments":
            self.data += request[1 : 8 - (command >> 1 & 7)]
            if command & 0x01:
                self.phase = ""
                write(self.key, bytes(self.data))
        elif kind == 0xC0:
            self.phase = "upload"  # the blocks that follow look like anything
        elif kind == 0xA0 and answer[0] & 0x03 == 0x00:
            self._begin(request, "block")
            self.block = answer[4]
        elif kind == 0xA0 and answer[0] & 0x03 == 0x02:
            self.sequence, self.block = 0, answer[2]
        elif kind == 0xA0 and answer[0] & 0x03 == 0x01:
            self.phase = ""
            write(self.key, bytes(self.data[: len(self.data) - (command >> 2 & 7)]))

    def _begin(self, request: bytes, phase: str) -> None:
        self.key, self.phase, self.sequence = request[1:4], phase, 0
        self.data.clear()


class DictionaryModel:
    def __init__(self, path: Path, node_id: int, settings: dict[Key, int]) -> None:
        self._described = read(path)
        self._settings = settings
        self.node_id = self._persistent = self._pending = node_id
        self._stored: dict[Key, bytes] = {}
        self.data: dict[Key, bytes] = {}
        self._servers = [Server(0x1200), Server(0x1201)]
        self._buffers: dict[int, bytes] = {}
        self._last_sync_ns: int | None = None
        self.state = PRE_OPERATIONAL
        self._reset(range(0x1000, 0x10000))

    def number(self, index: int, sub: int = 0) -> int:
        return int.from_bytes(self.data[index, sub], "little")

    def expected(self) -> Iterator[tuple[Key, bytes]]:
        for key, data in self.data.items():
            if key[0] not in NOT_COMPARED:
                # An input without a signal reads 0, and 6002h inverts it.
                yield key, self.data[0x6002, key[1]] if key[0] == 0x6000 and key[1] else data

    def went(self, sent: Frame, came: list[Frame]) -> None:
        """A frame to the node, and all that it sent at that instant; with key -1 only time went by."""
        if len(sent.data) == 2 and sent.key == 0 and sent.data[1] in (0, self.node_id):
            self._on_command(sent.data[0])
        if sent.key == 0x7E5 and len(sent.data) == 8:
            self._on_lss(sent.data, [item.data for item in came if item.key == 0x7E4])
        if self.state != STOPPED:
            for server in self._servers:
                self._on_sdo(server, sent, came)
        if self.state == OPERATIONAL and not sent.is_remote:
            self._on_rpdo(sent)
        if not sent.is_remote:
            self._on_sync(sent)
        for item in came:
            if self.number(0x1005) & 1 << 30:  # the node hears its own SYNC
                self._on_sync(item)

    # NMT and LSS

    def _on_command(self, command: int) -> None:
        states = {1: OPERATIONAL, 2: STOPPED, 128: PRE_OPERATIONAL}
        if command in states:
            self._enter(states[command])
        elif command in (129, 130):
            if command == 129:
                self._pending = self._persistent
            self.node_id = self._pending
            self._reset(range(0x1000, 0x10000 if command == 129 else 0x2000))
            self._enter(PRE_OPERATIONAL)
            if not self.number(0x1F80) & 0x04:
                self.state = OPERATIONAL

    def _enter(self, state: int) -> None:
        if state != self.state:
            self._buffers.clear()
        self.state = state
        if state == STOPPED:
            self._end_transfers()

    def _reset(self, indices: range) -> None:
        self._end_transfers()
        self._buffers.clear()
        self._last_sync_ns = None
        for key, described in self._described.items():
            if key[0] in indices:
                setting = self._settings.get(key)
                start = described.start(self.node_id)
                factory = start if setting is None else setting.to_bytes(len(start), "little")
                self.data[key] = self._stored.get(key, factory)

    def _end_transfers(self) -> None:
        for server in self._servers:
            server.phase = ""

    def _on_lss(self, request: bytes, answers: list[bytes]) -> None:
        if answers and answers[0][1] == 0:
            if request[0] == 0x11:
                self._pending = request[1]
            elif request[0] == 0x17:
                self._persistent = self._pending

    # SDO

    def _on_sdo(self, server: Server, sent: Frame, came: list[Frame]) -> None:
        request_id, response_id = self.number(server.index, 1), self.number(server.index, 2)
        if (request_id | response_id) & 1 << 31:
            return
        answers = [item.data for item in came if item.key == _key(response_id) and len(item.data) == 8]
        if sent.key == _key(request_id) and len(sent.data) == 8 and not sent.is_remote:
            server.saw(sent.data, answers, lambda key, data: self._write(key, data))
        else:
            for answer in answers:  # a time-out, or where a lost block has come to
                if answer[0] == 0x80:
                    server.phase = ""
                elif answer[0] == 0xA2:
                    server.sequence = 0

    def _write(self, key: bytes, data: bytes) -> None:
        where = int.from_bytes(key[:2], "little"), key[2]
        described = self._described[where]
        if where[0] in (0x1010, 0x1011):
            self._store(where[0], where[1])
        elif where[0] not in NOT_COMPARED:
            size = SIZES.get(described.data_type, len(data))
            self._put(where, data[:size])

    def _put(self, where: Key, data: bytes) -> None:
        if data == self.data[where]:
            return
        self.data[where] = data
        for number in list(self._buffers):
            is_off = self.number(0x1400 + number, 1) & 1 << 31 or self.number(0x1400 + number, 2) > 240
            if is_off:  # what waited for a SYNC is not for another mapping
                del self._buffers[number]
        if where[0] != 0x1020 and not self._described[where].is_mappable and self._is_kept(where):
            self.data[0x1020, 1] = self.data[0x1020, 2] = bytes(4)

    def _is_kept(self, where: Key) -> bool:
        described = self._described[where]
        is_special = where[0] in (0x1010, 0x1011, 0x1003) or described.data_type == 0xF
        return described.is_writable and not described.is_output and not is_special

    def _store(self, index: int, sub: int) -> None:
        groups = {1: (0x1000, 0xFFFF), 2: (0x1000, 0x1FFF), 3: (0x6000, 0x9FFF), 4: (0x2000, 0x5FFF)}
        first, last = groups[sub]
        for where, described in self._described.items():
            if first <= where[0] <= last and self._is_kept(where):
                self._stored.pop(where, None)
                is_factory = self.data[where] == described.start(self.node_id)  # follows the node-ID
                if index == 0x1010 and not is_factory:
                    self._stored[where] = self.data[where]

    # PDO and SYNC

    def _on_rpdo(self, sent: Frame) -> None:
        for number in range(2):
            cob_id, mapping = self.number(0x1400 + number, 1), self._mapping(0x1600 + number)
            size = (sum(bits for _, bits in mapping) + 7) // 8
            if cob_id & 1 << 31 or sent.key != _key(cob_id) or not mapping or len(sent.data) < size:
                continue
            if self.number(0x1400 + number, 2) > 240:
                self._unpack(mapping, sent.data)
            elif self._is_window_open(sent.time_ns):
                self._buffers[number] = sent.data

    def _is_window_open(self, now_ns: int) -> bool:
        window_us = self.number(0x1007)
        return not window_us or self._last_sync_ns is None or now_ns < self._last_sync_ns + window_us * 1000

    def _on_sync(self, frame: Frame) -> None:
        cob_id = self.number(0x1005)
        if self.state == STOPPED or frame.key != _key(cob_id):
            return
        if len(frame.data) != (1 if self.number(0x1019) else 0):
            return
        self._last_sync_ns = frame.time_ns
        for number in sorted(self._buffers):
            if not self.number(0x1400 + number, 1) & 1 << 31 and self.number(0x1400 + number, 2) <= 240:
                self._unpack(self._mapping(0x1600 + number), self._buffers.pop(number))

    def _mapping(self, index: int) -> list[tuple[Key | None, int]]:
        parts: list[tuple[Key | None, int]] = []
        for sub in range(1, self.number(index, 0) + 1):
            entry = self.number(index, sub)
            where = entry >> 16, entry >> 8 & 0xFF
            parts.append((where if where in self._described else None, entry & 0xFF))
        return parts

    def _unpack(self, mapping: list[tuple[Key | None, int]], data: bytes) -> None:
        for where, bits in mapping:
            if where is not None:
                self._put(where, data[: bits // 8])
            data = data[bits // 8 :]


def _key(cob_id: int) -> int:
    return cob_id & 0x1FFF_FFFF | 1 << 31 if cob_id & 1 << 29 else cob_id & 0x7FF
