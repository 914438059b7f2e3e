"""A serial line as a function of time: bytes take the time of the sender's format.

There are two ends, each with a transmitter of its own (full duplex).  With more members it is a party line: each member
receives all others, and members that send at the same time do not collide, as if each had a pair of wires of its own.

Bytes arrive in chunks of at most `chunk_ns`, each at the instant at which its last character has arrived; a gap
between characters that is shorter than a chunk is invisible.  A format applies to what its sender sends after it.
Control lines and formats arrive at once, and a member that listens later gets the present ones; until a member has set
its lines they are `ControlLines()`, DTR and RTS on.
Left out: handshaking; an end that honours CTS waits itself.
"""

import heapq
import logging
from collections.abc import Sequence
from typing import Any

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import MS, S
from fieldrig_bus.serial.garble import garbled
from fieldrig_bus.serial.message import KINDS, Break, ControlLines, Format, SerialMessage, check_interest

log = logging.getLogger(__name__)

LONGEST_BACKLOG_NS = 3600 * S
"""Transmission time that one end may have asked for ahead of its line, which bounds the memory that it takes."""
BYTES_ONLY = frozenset({"data"})


class _End:
    __slots__ = ("form", "free_ns", "interest", "is_gone", "said")

    def __init__(self, form: Format) -> None:
        self.form = form
        self.free_ns = 0  # the instant at which its transmitter has sent everything
        self.interest: frozenset[str] = frozenset()
        self.said: dict[str, SerialMessage] = {}  # present lines and format, if it has ever set them
        self.is_gone = False


class SerialModel(BusModel[SerialMessage]):
    """Bytes arrive at once unless `is_paced`.  If `is_garbling`, an end in another format receives garbage."""

    def __init__(self, form: Format, chunk_ns: int = 2 * MS, is_paced: bool = True, is_garbling: bool = False) -> None:
        self._form, self._chunk_ns, self._is_paced, self._is_garbling = form, chunk_ns, is_paced, is_garbling
        self._ends: dict[str, _End] = {}
        # instant, order of asking, sender, the message, the only receiver ("": all), the format in which it was sent
        self._under_way: list[tuple[int, int, str, SerialMessage, str, Format]] = []
        self._arrived: list[Delivery[SerialMessage]] = []
        """Deliveries that a late host has not collected before an end changed its format."""
        self._asked = 0
        self._collected_ns = 0
        self._receivers: dict[tuple[str, str], tuple[str, ...]] = {}  # by sender and kind of message
        self._characters = self._breaks = 0

    @property
    def members(self) -> tuple[str, ...]:
        """The ends, in the order of joining."""
        return tuple(self._ends)

    def format_of(self, member: str) -> Format:
        """Return the format in which an end sends."""
        return self._ends[member].form if member in self._ends else self._form

    def given_format(self, member: str) -> SerialMessage | None:
        """Return the format that an end has set; None if it has set none."""
        return self._ends[member].said.get(KINDS[Format])

    def lines_of(self, member: str) -> ControlLines:
        """Return the control lines as an end has set them."""
        lines = self._ends[member].said.get(KINDS[ControlLines], ControlLines())
        assert isinstance(lines, ControlLines)
        return lines

    def join(self, member: str) -> None:
        self._ends[member] = _End(self._form)
        self._receivers.clear()

    def leave(self, member: str) -> None:
        del self._ends[member]
        self._receivers.clear()
        self._under_way = [entry for entry in self._under_way if entry[2] != member and entry[4] != member]
        heapq.heapify(self._under_way)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        check_interest(interest)
        words = BYTES_ONLY if interest is None else frozenset(interest)
        self._ends[member].interest = words
        self._receivers.clear()
        for other, end in self._ends.items():
            for kind, message in end.said.items():
                if other != member and kind in words:
                    self._add(now_ns, other, message, member)

    def submit(self, now_ns: int, member: str, message: SerialMessage) -> None:
        end = self._ends[member]
        if end.free_ns - now_ns > LONGEST_BACKLOG_NS:
            log.debug("%s has more than an hour of data to send; dropped %r", member, message)
        elif type(message) is bytes:
            self._characters += len(message)
            self._send_bytes(now_ns, member, end, message)
        elif type(message) is Break:
            self._breaks += 1
            end.free_ns = max(now_ns, end.free_ns) + (message.duration_ms * MS if self._is_paced else 0)
            self._add(end.free_ns, member, message)
        else:
            if type(message) is Format:
                self._go_on_to(now_ns - 1)
                end.form = message
            end.said[KINDS[type(message)]] = message
            self._add(now_ns, member, message)

    def next_ns(self) -> int | None:
        if self._arrived:
            return self._arrived[0].time_ns
        return self._under_way[0][0] if self._under_way else None

    def collect(self, now_ns: int) -> list[Delivery[SerialMessage]]:
        self._go_on_to(now_ns)
        arrived, self._arrived = self._arrived, []
        return arrived

    def _go_on_to(self, now_ns: int) -> None:
        under_way, arrived = self._under_way, self._arrived
        while under_way and under_way[0][0] <= now_ns:
            time_ns, _, sender, message, only, form = heapq.heappop(under_way)
            receivers = (only,) if only else self.receivers_of(sender, KINDS[type(message)])
            if self._is_garbling and type(message) is bytes:
                arrived += self._garbled(time_ns, sender, message, form, receivers)
            else:
                arrived.append(Delivery(time_ns, sender, message, receivers))
            self._collected_ns = time_ns

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {"characters": float(self._characters), "breaks": float(self._breaks)}

    def _send_bytes(self, now_ns: int, member: str, end: _End, data: bytes) -> None:
        begin_ns = max(now_ns, end.free_ns)
        if not self._is_paced:
            if data:
                self._add(begin_ns, member, data)
            return
        bit_time, baud = end.form.bits_per_character * S, end.form.baud
        size = max(1, self._chunk_ns * baud // bit_time)
        for start in range(0, len(data), size):
            chunk = data[start : start + size]
            self._add(begin_ns + (start + len(chunk)) * bit_time // baud, member, chunk)
        end.free_ns = begin_ns + len(data) * bit_time // baud

    def _add(self, when_ns: int, sender: str, message: SerialMessage, only: str = "") -> None:
        self._asked += 1
        when_ns = max(when_ns, self._collected_ns)
        form = self._ends[sender].form
        heapq.heappush(self._under_way, (when_ns, self._asked, sender, message, only, form))

    def receivers_of(self, sender: str, kind: str) -> tuple[str, ...]:
        """Return the ends that hear messages of this kind from the sender."""
        receivers = self._receivers.get((sender, kind))
        if receivers is None:
            receivers = tuple(name for name, end in self._ends.items() if name != sender and kind in end.interest)
            self._receivers[sender, kind] = receivers
        return receivers

    def _garbled(
        self, time_ns: int, sender: str, data: bytes, sent_as: Format, receivers: tuple[str, ...]
    ) -> list[Delivery[SerialMessage]]:
        """The characters that each receiver reads in its own format; one delivery for receivers that read the same."""
        heard: dict[bytes, list[str]] = {} if receivers else {data: []}
        for receiver in receivers:
            form = self._ends[receiver].form
            heard.setdefault(data if form == sent_as else garbled(data, sent_as, form), []).append(receiver)
        return [Delivery(time_ns, sender, message, tuple(names)) for message, names in heard.items() if message]
