"""SDO transfers of a log, put together from their messages.

Source: CiA 301 version 4.2, 7.2.4.3.  Each channel of each bus has one transfer at a time (7.2.4.1), so transfers of
several clients and servers are distinguished by their identifiers.  A log may begin in the middle of a transfer and of
a block, and a node may be restarted at any time.
"""

import struct
from array import array
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.sdo.server import ABORTS
from fieldrig_devices.dialogues.dialogue import Dialogue, Stray
from fieldrig_devices.dialogues.sdo_channels import NODES, End, SdoChannels
from fieldrig_devices.dialogues.sdo_steps import ENDED, STRAY, WHOLE, Asked, Steps, asked, needed
from fieldrig_devices.dialogues.sdo_transfer import SdoTransfer

MOST_OPEN: Final = 1_024
"""Transfers that are open at the same time; a bus has 127 default channels."""
MOST_MESSAGES: Final = 1_000_000
"""Messages of one transfer: 7 MB in blocks."""
MOST_BUSES: Final = 256
LENGTH: Final = 8
ERROR_CONTROL: Final = 0x700
SEQUENCE: Final = 0x7F
_WORD: Final = struct.Struct("<I").unpack_from
_HEAD: Final = 5
"""Bytes of an entry before the data of the frame (see `fieldrig_bus.can.codec`)."""

Key = tuple[str, int]
"""A channel: the bus, and the identifier of its requests."""


class _Open:
    """A transfer that goes on."""

    def __init__(self, time_ns: int, end: End, request: bytes, steps: Asked) -> None:
        self.begin_ns, self.end, self.request = time_ns, end, request
        self.content = steps.content
        self.steps: Steps = steps
        self.entries = array("Q")

    @property
    def is_answered(self) -> bool:
        return not isinstance(self.steps, Asked)

    def ended(self, bus: str, end_ns: int | None, abort: int | None, by_client: bool, wrong: str) -> SdoTransfer:
        content = self.content
        content.note(wrong)
        if end_ns is not None and abort is None and content.size not in (None, len(content.data)):
            content.note(f"{len(content.data)} bytes came, {content.size} were announced")
        is_whole = (end_ns is not None and abort is None) or (content.is_download and content.form == "expedited")
        return SdoTransfer(
            self.begin_ns,
            end_ns,
            bus,
            tuple(self.entries),
            self.end.node_id,
            int.from_bytes(self.request[1:3], "little"),
            self.request[3],
            content.is_download,
            bytes(content.data) if is_whole and not content.is_spoiled else None,
            abort,
            content.form,
            by_client,
            content.size,
            content.wrong,
            self.end.request_key,
        )


class SdoDialogues:
    """The transfers of all buses of a log."""

    def __init__(self) -> None:
        self._open: OrderedDict[Key, _Open] = OrderedDict()
        self._channels: OrderedDict[str, SdoChannels] = OrderedDict()
        self._last: OrderedDict[Key, int] = OrderedDict()
        """The first byte of the client's last message, while no answer followed."""
        self.is_concerned = False
        """True if the last message was one of a channel, so that it belongs to a transfer or is a `Stray`."""
        self.went_on = False
        """True if it belongs to a transfer that had begun before."""
        self._is_short = False

    def channels(self, bus: str) -> SdoChannels:
        """Return the channels of a bus, so that what is known besides the log can be put there."""
        found = self._channels.get(bus)
        if found is None:
            found = self._channels[bus] = SdoChannels()
            if len(self._channels) > MOST_BUSES:
                self._channels.popitem(last=False)
        return found

    def describe(self, bus: str, dictionaries: Mapping[int, Dictionary]) -> None:
        """Take the channels that the EDS files of the nodes of a bus give them."""
        for node_id, dictionary in dictionaries.items():
            self.channels(bus).describe(node_id, dictionary)

    def take(self, number: int, entry: TraceEntry) -> Sequence[Dialogue]:
        """Take a message, and return the dialogues that it ends.

        A message of a channel that fits to no transfer comes back as a `Stray`.  Other messages end nothing, except
        the boot-up of a node, which ends its transfers.
        """
        self.is_concerned = self.went_on = self._is_short = False
        data = entry.data
        if entry.family != "can" or len(data) < _HEAD:
            return ()
        word: int = _WORD(data)[0]
        end = self.channels(entry.bus).ends.get(word)
        if end is None:
            is_boot_up = word - ERROR_CONTROL in NODES and data[4:] == b"\x01\x00"
            return self._restart(entry.bus, word - ERROR_CONTROL) if is_boot_up else ()
        self.is_concerned = True
        message = data[_HEAD:]
        if len(message) != LENGTH:
            if not self._is_enough(entry, end, message):
                return (_stray(number, entry, "expected eight bytes"),)
            message = message.ljust(LENGTH, b"\0")
            self._is_short = True
        return (self._client if end.is_client else self._server)(number, entry, end, message)

    def is_of_channel(self, entry: TraceEntry) -> bool:
        """Return whether a CAN message belongs to an SDO channel, or may end a transfer otherwise."""
        data = entry.data
        if len(data) < _HEAD:
            return True
        word: int = _WORD(data)[0]
        return word in self.channels(entry.bus).ends or word - ERROR_CONTROL in NODES

    def unfinished(self) -> Sequence[Dialogue]:
        """Return the transfers that are open, the oldest first, and forget them."""
        left = [open_.ended(bus, None, None, False, "the log ends before") for (bus, _), open_ in self._open.items()]
        self._open.clear()
        return left

    def _client(self, number: int, entry: TraceEntry, end: End, message: bytes) -> Sequence[Dialogue]:
        key = entry.bus, end.request_key
        open_ = self._open.get(key)
        if open_ is not None:
            if message[0] & open_.steps.client_abort == ABORTS:
                return self._aborted(key, open_, number, entry, message, by_client=True)
            verdict = open_.steps.client(message)
            if verdict is not STRAY:
                return self._went_on(key, open_, number, entry, verdict is ENDED)
        steps = asked(message)
        if self._is_within_block(key, open_, message):
            self._remember(key, message)
            return *self._mistaken(key, open_, entry), _stray(number, entry, "a segment of a block that began before")
        if steps is None:
            self._remember(key, message)
            return (_stray(number, entry, "a request without the beginning of its transfer"),)
        return self._begin(key, number, entry, end, message, steps)

    def _begin(
        self, key: Key, number: int, entry: TraceEntry, end: End, message: bytes, steps: Asked
    ) -> Sequence[Dialogue]:
        ended: list[Dialogue] = []
        before = self._open.pop(key, None)
        if before is not None:
            wrong = "asked again" if message == before.request else "another request came before the answer"
            ended.append(before.ended(entry.bus, None, None, False, wrong))
        opened = self._open[key] = _Open(entry.time_ns, end, message, steps)
        opened.entries.append(number)
        self._note_short(opened)
        self._last.pop(key, None)
        if len(self._open) > MOST_OPEN:
            (bus, _), oldest = self._open.popitem(last=False)
            ended.append(oldest.ended(bus, None, None, False, "no answer"))
        return ended

    def _server(self, number: int, entry: TraceEntry, end: End, message: bytes) -> Sequence[Dialogue]:
        key = entry.bus, end.request_key
        self._last.pop(key, None)
        open_ = self._open.get(key)
        if open_ is None:
            return (_stray(number, entry, "an answer without its request"),)
        if message[0] & open_.steps.server_abort == ABORTS:
            if message[1:4] not in (open_.request[1:4], b"\0\0\0"):
                return (_stray(number, entry, "an abort of another transfer"),)
            return self._aborted(key, open_, number, entry, message, by_client=False)
        step = open_.steps.server(message)
        if isinstance(step, Steps):
            open_.steps = step
        elif step is STRAY:
            return (_stray(number, entry, "an answer that does not fit the request"),)
        return self._went_on(key, open_, number, entry, step is ENDED)

    def _went_on(self, key: Key, open_: _Open, number: int, entry: TraceEntry, is_ended: bool) -> Sequence[Dialogue]:
        open_.entries.append(number)
        self._note_short(open_)
        self.went_on = True
        if is_ended:
            return (self._end(key, open_, entry.time_ns),)
        if len(open_.entries) >= MOST_MESSAGES:
            return (self._end(key, open_, None, f"more than {MOST_MESSAGES} messages"),)
        return ()

    def _aborted(
        self, key: Key, open_: _Open, number: int, entry: TraceEntry, message: bytes, *, by_client: bool
    ) -> Sequence[Dialogue]:
        open_.entries.append(number)
        del self._open[key]
        code = int.from_bytes(message[4:], "little")
        return (open_.ended(entry.bus, entry.time_ns, code, by_client, ""),)

    def _end(self, key: Key, open_: _Open, end_ns: int | None, wrong: str = "") -> SdoTransfer:
        del self._open[key]
        transfer = open_.ended(key[0], end_ns, None, False, wrong)
        if end_ns is not None:
            self.channels(key[0]).take(transfer)
        return transfer

    def _is_enough(self, entry: TraceEntry, end: End, message: bytes) -> bool:
        """Return whether a message that is too short has all that it needs, as some devices send it and accept it."""
        open_ = self._open.get((entry.bus, end.request_key))
        is_in_block = open_ is not None and WHOLE in (open_.steps.client_abort, open_.steps.server_abort)
        return 0 < len(message) < LENGTH and not is_in_block and len(message) >= needed(message, end.is_client)

    def _note_short(self, open_: _Open) -> None:
        if self._is_short:
            open_.content.note("a message has fewer than eight bytes")

    def _restart(self, bus: str, node_id: int) -> Sequence[Dialogue]:
        """End the transfers of a node that boots up: its server has forgotten them (CiA 301, 7.3.2.2)."""
        keys = [key for key, open_ in self._open.items() if key[0] == bus and open_.end.node_id == node_id]
        return [self._end(key, self._open[key], None, "the node was restarted") for key in keys]

    def _is_within_block(self, key: Key, open_: _Open | None, message: bytes) -> bool:
        """Return whether a client counts on: then what looked like requests are segments of a block.

        Their first bytes are numbers from 1 to 127, and a log may begin in the middle of a block.
        """
        if open_ is not None and (open_.is_answered or len(open_.entries) > 1):
            return False
        last = self._last.get(key) if open_ is None else open_.request[0]
        return last is not None and message[0] & SEQUENCE == (last & SEQUENCE) + 1

    def _mistaken(self, key: Key, open_: _Open | None, entry: TraceEntry) -> Sequence[Dialogue]:
        """Return the message that was taken for a request."""
        if open_ is None:
            return ()
        del self._open[key]
        why = "a segment of a block that began before"
        return (Stray(open_.begin_ns, open_.begin_ns, entry.bus, tuple(open_.entries), why),)

    def _remember(self, key: Key, message: bytes) -> None:
        self._last[key] = message[0]
        if len(self._last) > MOST_OPEN:
            self._last.popitem(last=False)


def _stray(number: int, entry: TraceEntry, why: str) -> Stray:
    return Stray(entry.time_ns, entry.time_ns, entry.bus, (number,), why)
