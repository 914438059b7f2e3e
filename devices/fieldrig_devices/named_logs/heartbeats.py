"""Heartbeats and answers to guarding that stay out on a bus: since when, and every how long they were expected.

Source: CiA 301 version 4.2, 7.2.8.2 (guarding and heartbeat) and 7.5.2.15 (1017h).  The period is what the log shows
to be in 1017h; without that, it is the period that the node kept.  A heartbeat is missing when twice its period has
passed, as a consumer's time is usually set.  A node that is guarded has no period: its answer is missing when the
master asks again.
"""

from collections import deque
from dataclasses import dataclass, field
from statistics import median
from typing import Final

from fieldrig.clock import MS, NEVER_NS
from fieldrig_devices.dialogues import SdoTransfer

PRODUCER_TIME: Final = 0x1017
PATIENCE: Final = 2
"""Periods after which a heartbeat is missing."""
FEWEST: Final = 4
"""Intervals from which a period is known."""
INTERVALS: Final = 9
BOOT_UP: Final = 0


@dataclass(slots=True)
class _Producer:
    last_ns: int = 0
    given_ns: int | None = None
    """The period of 1017h in the log; 0 is no heartbeat."""
    intervals: deque[int] = field(default_factory=lambda: deque(maxlen=INTERVALS))
    is_missing: bool = False
    is_guarded: bool = False
    asked_ns: int | None = None
    """The request of a master that has no answer yet."""
    has_begun: bool = False
    due_ns: int = NEVER_NS
    """The instant from which the heartbeat is missing."""

    @property
    def period_ns(self) -> int:
        if self.given_ns is not None:
            return self.given_ns
        return round(median(self.intervals)) if len(self.intervals) >= FEWEST else 0

    def look(self) -> None:
        """Find out when the heartbeat is missing, after anything has changed."""
        is_expected = self.has_begun and not self.is_missing and not self.is_guarded
        period_ns = self.period_ns if is_expected else 0
        self.due_ns = self.last_ns + PATIENCE * period_ns if period_ns else NEVER_NS


@dataclass(frozen=True, slots=True)
class Loss:
    """A heartbeat or answer to guarding that stayed out, or that has come back."""

    node_id: int
    time_ns: int
    """When it is missing for too long, or is back."""
    last_ns: int
    """The last heartbeat before, or the request without an answer."""
    period_ns: int
    is_back: bool
    is_guarding: bool = False


class Heartbeats:
    """The heartbeats of one bus."""

    def __init__(self) -> None:
        self._nodes: dict[int, _Producer] = {}
        self.next_ns = NEVER_NS
        """The instant from which some heartbeat is missing; `missing` need not be called before."""

    def heard(self, node_id: int, time_ns: int, state: int) -> Loss | None:
        """Take a heartbeat or boot-up; the end of a loss, if it is one."""
        node = self._nodes.setdefault(node_id, _Producer())
        back = None
        if node.is_missing:
            back = Loss(node_id, time_ns, node.last_ns, node.period_ns, True, node.is_guarded)
        if state == BOOT_UP:
            node.intervals.clear()  # it is another life of the node, which may have another period
            node.given_ns = None
        elif node.has_begun and not node.is_missing and time_ns > node.last_ns:
            node.intervals.append(time_ns - node.last_ns)
        node.has_begun = state != BOOT_UP
        node.last_ns, node.is_missing, node.asked_ns = time_ns, False, None
        self._look(node)
        return back

    def guarded(self, node_id: int, time_ns: int) -> Loss | None:
        """Take the request of a master that guards a node; a loss, if the one before has no answer."""
        node = self._nodes.setdefault(node_id, _Producer())
        asked_ns, node.asked_ns, node.is_guarded = node.asked_ns, time_ns, True
        is_new = asked_ns is not None and not node.is_missing
        node.is_missing |= is_new
        self._look(node)
        return Loss(node_id, time_ns, asked_ns, 0, False, True) if is_new and asked_ns is not None else None

    def take(self, transfer: SdoTransfer) -> None:
        """Learn from a transfer of 1017h; any other one says nothing of heartbeats."""
        if transfer.index == PRODUCER_TIME and not transfer.subindex and transfer.is_done and transfer.data:
            self.configured(transfer.node_id, int.from_bytes(transfer.data[:2], "little"), transfer.end_ns or 0)

    def configured(self, node_id: int, period_ms: int, time_ns: int) -> None:
        """Take the content of 1017h; from now on a heartbeat is expected, or no more."""
        node = self._nodes.setdefault(node_id, _Producer())
        if node.given_ns != period_ms * MS:
            node.given_ns, node.is_missing, node.has_begun = period_ms * MS, False, True
            node.last_ns = max(node.last_ns, time_ns)
            self._look(node)

    def missing(self, now_ns: int) -> list[Loss]:
        """Return the losses that have begun up to now, the earliest first."""
        found = []
        for node_id, node in self._nodes.items():
            if node.due_ns <= now_ns:
                found.append(Loss(node_id, node.due_ns, node.last_ns, node.period_ns, False))
                node.is_missing = True
                self._look(node)
        return sorted(found, key=lambda loss: loss.time_ns)

    def _look(self, node: _Producer) -> None:
        node.look()
        self.next_ns = min((node.due_ns for node in self._nodes.values()), default=NEVER_NS)
