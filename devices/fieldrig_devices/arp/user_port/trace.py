"""The trace: selected values of the card in every n-th control loop, kept until the line can carry them."""

import struct
from collections import deque
from collections.abc import Callable
from typing import Final

from fieldrig_devices.arp.card_access import CardAccess
from fieldrig_devices.arp.user_port import quantities
from fieldrig_devices.arp.user_port.handlers import Handlers, bare
from fieldrig_devices.arp.user_port.messages import (
    LARGEST_DATA,
    LOST,
    MOST_TRACED,
    QUANTITY,
    TRACE,
    Command,
    Quantity,
    RequestError,
    Status,
)

MOST_WAITING: Final = 64
"""Maximum number of waiting samples; further samples are lost and counted."""


class Trace:
    def __init__(self, card: CardAccess) -> None:
        self._card = card
        self._readers: list[Callable[[], int]] = []
        self._every = 1
        self._until_next = 0
        self._sample = struct.Struct("")
        self._waiting: deque[tuple[int, bytes]] = deque()  # samples, each with the number of samples lost before it
        self._lost = 0
        self.handlers: Handlers = {
            Command.TRACE_START: self._start,
            Command.TRACE_STOP: bare(self._stop),
        }

    @property
    def is_on(self) -> bool:
        return bool(self._readers)

    def stop(self) -> None:
        self._readers = []
        self._waiting.clear()

    def tick(self, loop: int) -> None:
        """Take a sample if one is due; call it last in control loop number `loop`."""
        self._until_next -= 1
        if self._until_next > 0:
            return
        self._until_next = self._every
        if len(self._waiting) < MOST_WAITING:
            self._waiting.append((self._lost, self._sample.pack(loop, *[read() for read in self._readers])))
        else:
            self._lost += 1

    def take(self) -> bytes:
        """Data of the next SAMPLES message, with as many samples as fit; empty if none are waiting."""
        if not self._waiting:
            return b""
        count = min(len(self._waiting), (LARGEST_DATA - LOST.size) // self._sample.size)
        taken = [self._waiting.popleft() for _ in range(count)]
        return LOST.pack(taken[-1][0] & 0xFFFF_FFFF) + b"".join(sample for _, sample in taken)

    def _start(self, data: bytes) -> bytes:
        (every,) = TRACE.unpack_from(data)
        wanted = [Quantity(*fields) for fields in QUANTITY.iter_unpack(data[TRACE.size :])]
        if not 1 <= len(wanted) <= MOST_TRACED:
            raise RequestError(Status.LENGTH, f"expected 1 to {MOST_TRACED} quantities")
        if every == 0:
            raise RequestError(Status.RANGE, "expected a period of 1 to 65535 control loops")
        readers = [quantities.reader(self._card, quantity) for quantity in wanted]
        self.stop()
        self._readers, self._every, self._until_next, self._lost = readers, every, 0, 0
        self._sample = struct.Struct(f"<I{len(readers)}i")
        return b""

    def _stop(self) -> bytes:
        self.stop()
        return b""
