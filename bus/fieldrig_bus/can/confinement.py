"""Error signalling and fault confinement on a CAN bus, bit by bit from the first wrong bit on.

Source: ISO 11898-1:2015, 10.9 (errors and how they are signalled), 10.4.4 (error frame) and 12.1.4 (fault
confinement; Bosch CAN 2.0, chapter 8, has the same rules).  Each node drives a level, all nodes see the lower one, and
each reacts.  So the length of superposed flags, the error that each node sees, and the counters are as on a wire.

Left out on purpose: overload frames, bits that nodes sample differently (all nodes see a disturbance), the exception
of TEC for a stuff bit in the arbitration field (there a dominant bit instead of a recessive one is lost arbitration),
and new frames that begin in the delimiter of a passive node that is behind the others.
"""

from collections.abc import Sequence
from enum import IntEnum, auto
from functools import lru_cache
from typing import Final, NamedTuple

from fieldrig_bus.can.bits import DOMINANT, RECESSIVE, Stream
from fieldrig_bus.can.error_counters import BUS_OFF, HIGHEST_REC, PASSIVE, STEP
from fieldrig_bus.can.notices import ErrorKind

FLAG_BITS: Final = 6
DELIMITER_BITS: Final = 8
SUSPEND_BITS: Final = 8


class Role(IntEnum):
    """The present activity of a node."""

    SENDING = auto()
    RECEIVING = auto()
    ACTIVE_FLAG = auto()
    PASSIVE_FLAG = auto()
    WAITING = auto()
    """The node has sent its own error flag; other nodes may still be sending theirs."""
    DELIMITING = auto()
    DONE = auto()


class Disturbance(NamedTuple):
    """A disturbance of the wire from outside, by number of bit."""

    flipped: int | None = None
    dominant: range = range(0)
    recessive: range = range(0)

    def first(self) -> int | None:
        """The first bit that is disturbed; None without any."""
        starts = [held.start for held in (self.dominant, self.recessive) if held]
        if self.flipped is not None:
            starts.append(self.flipped)
        return min(starts, default=None)

    def apply(self, bit: int, level: int) -> int:
        """The level of the bus at this bit, where nodes drive `level`."""
        if bit in self.dominant:
            return DOMINANT
        if bit in self.recessive:
            return RECESSIVE
        return level ^ 1 if bit == self.flipped else level


class Node:
    """The part of one controller in one frame on the wire."""

    __slots__ = (
        "_count", "_dominants", "_is_corrupt", "_is_excused", "_last", "_row", "_wire",
        "at", "done", "fails", "is_sent", "is_transmitter", "kind", "rec", "role", "stream", "tec",
    )  # fmt: skip

    def __init__(self, tec: int, rec: int, stream: Stream | None = None) -> None:
        """The node sends `stream`, or receives without one."""
        self.tec, self.rec, self.stream = tec, rec, stream
        self.is_transmitter = stream is not None
        self.role = Role.SENDING if stream is not None else Role.RECEIVING
        self.kind: ErrorKind | None = None
        """The first error it saw, at bit `at`."""
        self.at = self.done = 0
        self.is_sent = False
        self.fails: tuple[int, ErrorKind] | None = None
        """The bit at which this node alone sees an error, and which one."""
        self._count = self._dominants = 0
        self._is_excused = False

    @property
    def setup(self) -> "Setup":
        """The state of the node before the frame."""
        return self.tec, self.rec, self.stream, self.fails

    @property
    def is_passive(self) -> bool:
        """True if it is error passive."""
        return self.tec >= PASSIVE or self.rec >= PASSIVE

    @property
    def is_settled(self) -> bool:
        """True if nothing changes for it while the bus stays dominant."""
        return self.role is Role.DONE or (
            self.role is Role.WAITING and not self.is_transmitter and self.rec == HIGHEST_REC
        )

    def begin(self, wire: Stream, start: int, *, is_garbled: bool) -> None:
        """Begin at bit `start` of `wire`; no bit before it is wrong.  `is_garbled`: receivers cannot decode it."""
        self._wire, self._is_corrupt = wire, is_garbled or self.fails is not None
        self._last, self._row = RECESSIVE, 1
        for bit in wire.bits[max(0, start - 6) : start]:
            self._see(bit)

    def level(self, bit: int) -> int:
        """The level that it drives."""
        role = self.role
        if role is Role.SENDING and self.stream is not None:
            return self.stream.bits[bit]
        if role is Role.ACTIVE_FLAG:
            return DOMINANT
        if role is Role.RECEIVING and bit == self._wire.acknowledge and not self._is_corrupt:
            return DOMINANT
        return RECESSIVE

    def sample(self, bit: int, level: int) -> None:
        """React to the level of the bus."""
        match self.role:
            case Role.SENDING:
                self._sample_sending(bit, level)
            case Role.RECEIVING:
                self._sample_receiving(bit, level)
            case Role.ACTIVE_FLAG:
                self._sample_active_flag(level)
            case Role.PASSIVE_FLAG:
                self._sample_passive_flag(level)
            case Role.WAITING:
                self._sample_waiting(level)
            case Role.DELIMITING:
                self._sample_delimiting(bit, level)

    def _sample_sending(self, bit: int, level: int) -> None:
        stream = self.stream
        assert stream is not None
        self._see(level)
        if bit == stream.acknowledge:
            if level == RECESSIVE:
                self._fail(bit, ErrorKind.ACK)
        elif stream.bits[bit] != level:
            if bit < stream.arbitration and level == DOMINANT:
                self.is_transmitter, self.stream, self.role = False, None, Role.RECEIVING
                self._is_corrupt = True  # lost arbitration looks the same as a disturbance
            else:
                self._fail(bit, ErrorKind.BIT)
        elif bit == len(stream.bits) - 1:
            self.is_sent, self.role, self.done = True, Role.DONE, bit + 1

    def _sample_receiving(self, bit: int, level: int) -> None:
        wire, before = self._wire, self._last
        self._see(level)
        if self.fails is not None and bit == self.fails[0]:
            self._fail(bit, self.fails[1])
        elif bit < wire.stuffed:
            if self._row > 5:
                self._fail(bit, ErrorKind.STUFF)
        elif bit in wire.fixed and level == before:
            self._fail(bit, ErrorKind.STUFF)
        elif bit >= wire.delimiter:
            self._sample_tail(bit, level)
        if bit < wire.delimiter and level != wire.bits[bit]:
            self._is_corrupt = True

    def _sample_tail(self, bit: int, level: int) -> None:
        last = len(self._wire.bits) - 1
        if bit == last:  # dominant, it would be an overload condition
            self.role, self.done = Role.DONE, bit + 1
        elif level == DOMINANT and bit != self._wire.acknowledge:
            self._fail(bit, ErrorKind.FORM)
        elif bit == self._wire.acknowledge + 1 and self._is_corrupt:
            self._fail(bit, ErrorKind.CRC)

    def _sample_active_flag(self, level: int) -> None:
        self._count += 1
        if level == RECESSIVE:  # it drives the bus dominant without effect
            self._raise()
        if self._count == FLAG_BITS and self.role is not Role.DONE:
            self._wait()

    def _sample_passive_flag(self, level: int) -> None:
        self._count = self._count + 1 if self._count and level == self._last else 1
        self._last = level
        if level == DOMINANT and self._is_excused:
            self._is_excused = False
            self._raise()
        if self._count == FLAG_BITS and self.role is not Role.DONE:
            self._wait()

    def _wait(self) -> None:
        self.role, self._dominants = Role.WAITING, 0

    def _sample_waiting(self, level: int) -> None:
        if level == RECESSIVE:
            self.role, self._count = Role.DELIMITING, 1
            return
        self._dominants += 1
        if self._dominants == 1 and not self.is_transmitter:
            self._raise()
        if self._dominants % STEP == 0:
            self._raise()

    def _sample_delimiting(self, bit: int, level: int) -> None:
        if level == DOMINANT:
            self._fail(bit, ErrorKind.FORM)
            return
        self._count += 1
        if self._count == DELIMITER_BITS:
            self.role, self.done = Role.DONE, bit + 1

    def _see(self, level: int) -> None:
        self._row = self._row + 1 if level == self._last else 1
        self._last = level

    def _fail(self, bit: int, error: ErrorKind) -> None:
        if self.kind is None:
            self.kind, self.at = error, bit
        self.role = Role.PASSIVE_FLAG if self.is_passive else Role.ACTIVE_FLAG
        self._count = 0
        if not self.is_transmitter:
            self.rec = min(self.rec + 1, HIGHEST_REC)
        elif error is ErrorKind.ACK and self.is_passive:
            # A lone node stays on the bus: this error counts only if there is a dominant bit during its flag.
            self._is_excused = True
        else:
            self._raise()

    def _raise(self) -> None:
        if not self.is_transmitter:
            self.rec = min(self.rec + STEP, HIGHEST_REC)
            return
        self.tec += STEP
        if self.tec >= BUS_OFF:
            self.role = Role.DONE


Setup = tuple[int, int, Stream | None, tuple[int, ErrorKind] | None]


@lru_cache(maxsize=256)
def played(
    setups: tuple[Setup, ...], wire: Stream, disturbance: Disturbance, is_garbled: bool
) -> tuple[int, tuple[Node, ...]]:
    """`play` with new nodes, which are shared and stay as they are.

    A wrong bit rate or a short circuit causes the same outcome again and again: on a line that is held recessive,
    51,000 attempts within ten seconds had 168 outcomes.
    """
    nodes = []
    for tec, rec, own, fails in setups:
        node = Node(tec, rec, own)
        node.fails = fails
        nodes.append(node)
    return play(nodes, wire, disturbance, is_garbled=is_garbled), tuple(nodes)


def play(nodes: Sequence[Node], wire: Stream, disturbance: Disturbance, *, is_garbled: bool = False) -> int:
    """Let the nodes act from the first bit on that may be wrong.  Returns the bit at which the last one is done.

    `wire` is what is on the bus while nothing is wrong.  A disturbance without end is played until nothing changes any
    more.
    """
    start = 0 if is_garbled else _first_wrong(nodes, wire, disturbance)
    for node in nodes:
        node.begin(wire, start, is_garbled=is_garbled)
    bit, busy = start, list(nodes)
    while busy and not (bit in disturbance.dominant and all(node.is_settled for node in busy)):
        level = disturbance.apply(bit, min(node.level(bit) for node in busy))
        for node in busy:
            node.sample(bit, level)
        busy = [node for node in busy if node.role is not Role.DONE]
        bit += 1
    return bit


def _first_wrong(nodes: Sequence[Node], wire: Stream, disturbance: Disturbance) -> int:
    start = wire.acknowledge  # which may stay recessive
    first = disturbance.first()
    if first is not None:
        start = min(start, first)
    for node in nodes:
        if node.fails is not None:
            start = min(start, node.fails[0])
        if node.stream is not None and node.stream is not wire:
            pairs = zip(node.stream.bits, wire.bits, strict=False)
            start = min(start, next((bit for bit, (ours, theirs) in enumerate(pairs) if ours != theirs), start))
    return start
