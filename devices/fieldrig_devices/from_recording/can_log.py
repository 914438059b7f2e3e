"""One CAN bus of a recording: its identifiers, its nodes with their objects, and its bit rate."""

from collections import Counter
from collections.abc import Sequence
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.emcy_words import LENGTH as EMCY_LENGTH
from fieldrig_devices.canopen.nmt import COMMANDS, ERROR_CONTROL_ID, NMT_ID, RESETS, Command
from fieldrig_devices.canopen.sdo.server import REQUEST_ID, RESPONSE_ID
from fieldrig_devices.canopen.service import State
from fieldrig_devices.dialogues import Dialogue, SdoDialogues, SdoTransfer
from fieldrig_devices.from_recording.bit_rate import BitRate
from fieldrig_devices.from_recording.identifiers import MOST_SYNCS, Identifier
from fieldrig_devices.from_recording.life import Life
from fieldrig_devices.from_recording.objects import ObjectLogs
from fieldrig_devices.from_recording.rhythm import period_of
from fieldrig_devices.from_recording.series import Room

LEAST_OVERFLOW: Final = 2
"""Lowest overflow value of the counter of SYNC (CiA 301, 7.5.2.21)."""
SYNC_ID, TIME_ID, EMCY_ID = 0x080, 0x100, 0x080
NODES: Final = range(1, 128)
SDO_LENGTH: Final = 8
MOST_EXTENDED: Final = 64
"""Identifiers of 29 bits that are counted one by one."""
_STATES: Final = frozenset(int(state) for state in State)


FEWEST: Final = 3
"""Messages in each direction that show a transfer without its beginning."""


class NodeLog:
    """One node-ID."""

    def __init__(self, room: Room) -> None:
        self.life = Life()
        self.objects = ObjectLogs(room)
        self.requests = self.answers = 0
        """SDO messages in both directions, also those of a transfer that began before the recording."""

    @property
    def is_seen(self) -> bool:
        """True if the node has sent something that tells a CANopen node."""
        return self.life.is_seen or self.answers_sdo

    @property
    def answers_sdo(self) -> bool:
        """True if it has answered requests, or a transfer goes on that began before the recording.

        Other protocols have identifiers of SDO too, with 8 bytes that fit no request.
        """
        return bool(self.objects.by_key) or min(self.requests, self.answers) >= FEWEST


class CanLog:
    """One bus."""

    def __init__(self) -> None:
        self.identifiers: dict[int, Identifier] = {}
        self.nodes: dict[int, NodeLog] = {}
        self.extended: Counter[int] = Counter()
        self.other_extended = self.notices = self.unreadable = self.fd = 0
        self.start_ns = self.end_ns = 0
        self.nmt: Counter[int] = Counter()
        """NMT commands that are none of the standard."""
        self.is_commanded = False
        self.bit_rate = BitRate()
        self._dialogues = SdoDialogues()
        self._room = Room()
        self._sync: tuple[int, int] | None = None
        self._highest_counter = 0

    def take(self, number: int, entry: TraceEntry) -> None:
        """Take a message; `number` is its place in the recording, from 0."""
        time_ns = entry.time_ns
        try:
            frame = decode(entry.data)
        except ValueError:
            self.unreadable += 1
            return
        if not isinstance(frame, CanFrame):
            self.notices += 1
            return
        self.bit_rate.take(time_ns, frame)
        if frame.is_extended:
            self._take_extended(frame)
            return
        if frame.is_fd:
            self.fd += 1
            return
        log = self.identifiers.get(frame.identifier)
        if log is None:
            log = self.identifiers[frame.identifier] = Identifier(self._room)
        log.take(time_ns, frame, self._sync)
        self._interpret(entry, frame)
        if ended := self._dialogues.take(number, entry):
            self._take_transfers(ended)

    def end(self, start_ns: int, end_ns: int) -> None:
        """Take what the recording, which is from `start_ns` to `end_ns`, has left open."""
        self.start_ns, self.end_ns = start_ns, end_ns
        self._take_transfers(self._dialogues.unfinished())

    @property
    def sync_ns(self) -> int:
        """The usual time between two SYNCs; 0 without SYNC."""
        log = self.identifiers.get(SYNC_ID)
        return period_of(log.instants) if log is not None else 0

    @property
    def sync_overflow(self) -> int:
        """The highest counter of SYNC, after which it begins with 1 again; 0 if SYNC has no counter."""
        log = self.identifiers.get(SYNC_ID)
        if log is None or log.length != 1:
            return 0
        has_come_round = log.count > self._highest_counter >= LEAST_OVERFLOW
        return self._highest_counter if has_come_round else MOST_SYNCS

    def node(self, node_id: int) -> NodeLog:
        found = self.nodes.get(node_id)
        if found is None:
            found = self.nodes[node_id] = NodeLog(self._room)
        return found

    @property
    def is_canopen(self) -> bool:
        """True if anything tells that CANopen is spoken here."""
        return self.is_commanded or any(node.is_seen for node in self.nodes.values())

    def _take_extended(self, frame: CanFrame) -> None:
        if frame.identifier in self.extended or len(self.extended) < MOST_EXTENDED:
            self.extended[frame.identifier] += 1
        else:
            self.other_extended += 1

    def _interpret(self, entry: TraceEntry, frame: CanFrame) -> None:
        identifier, data, time_ns = frame.identifier, frame.data, entry.time_ns
        if identifier == SYNC_ID and len(data) <= 1:
            self._highest_counter = max(self._highest_counter, *data, 0)
            self._sync = (0 if self._sync is None else self._sync[0] + 1, time_ns)
            return
        if identifier == NMT_ID:
            self._command(time_ns, data)
            return
        base, node_id = identifier & 0x780, identifier & 0x7F
        if node_id not in NODES:
            return
        if base in (REQUEST_ID, RESPONSE_ID) and len(data) == SDO_LENGTH:
            node = self.node(node_id)
            node.requests += base == REQUEST_ID
            node.answers += base == RESPONSE_ID
        elif base == ERROR_CONTROL_ID:
            self._error_control(time_ns, node_id, frame)
        elif base == EMCY_ID and len(data) == EMCY_LENGTH:
            self.node(node_id).life.emergency(time_ns, data)

    def _command(self, time_ns: int, data: bytes) -> None:
        command = COMMANDS.get(data[0]) if len(data) == 2 else None
        if command is None:
            self.nmt[data[0] if data else -1] += 1
            return
        self.is_commanded = True
        for node_id in (data[1],) if data[1] else NODES:
            if node_id in NODES:
                self._tell(time_ns, node_id, command)

    def _tell(self, time_ns: int, node_id: int, command: Command) -> None:
        node = self.node(node_id)
        node.life.command(time_ns, command, is_on=node.is_seen)
        if command in RESETS:
            node.objects.forget()

    def _error_control(self, time_ns: int, node_id: int, frame: CanFrame) -> None:
        if frame.is_remote:
            self.node(node_id).life.guard(time_ns)
        elif len(frame.data) == 1 and frame.data[0] & 0x7F in _STATES:
            node = self.node(node_id)
            if node.life.error_control(time_ns, frame.data):
                node.objects.boot()

    def _take_transfers(self, ended: Sequence[Dialogue]) -> None:
        for transfer in ended:
            if isinstance(transfer, SdoTransfer) and transfer.node_id in NODES:
                self.node(transfer.node_id).objects.take(transfer)
