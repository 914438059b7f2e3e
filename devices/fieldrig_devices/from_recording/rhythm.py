"""The transmission of a PDO, found by statistics: by SYNC, by a timer, by events, or on request.

Source: CiA 301, 7.5.2.37, for the transmission types, the inhibit time and the event timer.
"""

from bisect import bisect
from collections.abc import Sequence
from itertools import pairwise
from statistics import median
from typing import Final, NamedTuple

from fieldrig.clock import MS, US
from fieldrig.points.values import counted
from fieldrig_devices.canopen.pdo.tpdo import INHIBIT_UNIT_NS
from fieldrig_devices.from_recording.identifiers import MOST_SYNCS, Identifier

FEWEST: Final = 4
"""Frames that show a rhythm."""
ACYCLIC, ON_REQUEST, EVENT_DRIVEN = 0, 253, 255
SHARE: Final = 0.9
"""Share of the frames that a rhythm has to explain: the beginning and the end of a recording are not regular."""
WINDOW: Final = 0.25
"""Part of the SYNC period within which the frames of a synchronous PDO are; others drift through all of it."""
LATEST_NS: Final = 2 * MS
"""Time in which a node sends its synchronous PDOs, at least: a full bus delays them."""
JITTER: Final = 0.1
"""Part of a period by which a frame of a timer may be early or late."""
MOST_INHIBIT_NS: Final = 100 * MS
"""Longest inhibit time that is taken for one; a node whose values change more slowly is not held back."""
LEAST_JITTER_NS: Final = 500 * US


class Rhythm(NamedTuple):
    """How a PDO is sent."""

    type: int
    """Transmission type: 0 to 240, or 255."""
    event_ms: int = 0
    inhibit_100us: int = 0
    words: str = ""
    """The same for people."""
    is_cyclic: bool = False
    """True if it is sent in each period, and never between."""

    @property
    def is_synchronous(self) -> bool:
        return self.type <= MOST_SYNCS


def rhythm_of(log: Identifier, sync_period_ns: int, breaks: Sequence[int] = ()) -> Rhythm:
    """Return the rhythm; `sync_period_ns` is that of SYNC, and 0 without one.

    `breaks` are the instants, in order, at which the node was off or sent no PDOs: a time with one in it says nothing.
    """
    if log.count < FEWEST:
        return Rhythm(EVENT_DRIVEN, words=f"sent {counted(log.count, 'time')}, too seldom to find a rhythm")
    if log.on_request >= SHARE * log.count:
        return Rhythm(ON_REQUEST, words="sent when a remote frame asks for it")
    if sync_period_ns and (found := _synchronous(log, sync_period_ns)) is not None:
        return found
    return _asynchronous(log, breaks)


def period_of(instants: Sequence[int]) -> int:
    """Return the usual time from one instant to the next, in nanoseconds; 0 for less than two."""
    return round(median(_distances(instants))) if len(instants) > 1 else 0


def _synchronous(log: Identifier, sync_period_ns: int) -> Rhythm | None:
    """A synchronous PDO comes at once after a SYNC, each time about as late."""
    offsets = sorted(log.offsets)
    if len(offsets) < FEWEST or len(offsets) < SHARE * len(log.instants):
        return None
    edge = len(offsets) // 20
    spread_ns = offsets[-1 - edge] - offsets[edge]
    latest_ns = max(JITTER * sync_period_ns, LATEST_NS)
    if spread_ns > WINDOW * sync_period_ns or offsets[len(offsets) // 2] > latest_ns:
        return None
    total = sum(log.syncs.values())
    every, count = log.syncs.most_common(1)[0]
    if 0 < every <= MOST_SYNCS and count >= SHARE * total:
        after = "each SYNC" if every == 1 else f"every {every} SYNCs"
        return Rhythm(every, words=f"sent after {after}")
    changes = sum(log.changed[1:])
    if changes >= SHARE * (len(log.changed) - 1) and not log.syncs[0]:
        return Rhythm(ACYCLIC, words="sent after a SYNC when its data changed")
    return None


def _asynchronous(log: Identifier, breaks: Sequence[int]) -> Rhythm:
    """A PDO that repeats its data has a timer, and one that always waits for it is cyclic: no event makes it earlier.

    The emulated node waits because its inhibit time is the period too.
    """
    steps = list(zip(log.instants, _distances(log.instants), log.changed[1:], strict=False))
    whole = [step for step in steps if bisect(breaks, step[0]) == bisect(breaks, step[0] + step[1])]
    if len(whole) >= FEWEST - 1:
        steps = whole
    distances = [distance for _, distance, _ in steps]
    usual_ns = round(median(distances))
    is_regular = _share(distances, usual_ns) >= SHARE and usual_ns >= MS // 2
    repeats = [distance for _, distance, is_new in steps if not is_new]
    news = [distance for _, distance, is_new in steps if is_new]
    period_ns = round(median(repeats)) if len(repeats) >= FEWEST - 1 else 0
    is_timed = bool(repeats) and _share(repeats, usual_ns) >= SHARE  # no event sends the same data again
    if is_regular and is_timed and (not news or _share(news, usual_ns) >= SHARE):
        words = f"sent every {_ms(usual_ns)} ms"
        return Rhythm(EVENT_DRIVEN, max(usual_ns // MS, 1), round(usual_ns / INHIBIT_UNIT_NS), words, is_cyclic=True)
    if is_regular and not repeats:
        return Rhythm(EVENT_DRIVEN, words=f"sent every {_ms(usual_ns)} ms, always with new data")
    if period_ns < MS // 2 or _share(repeats, period_ns) < SHARE:
        period_ns = 0
    inhibit_ns = _inhibit(distances)
    words = f"sent on events, and every {_ms(period_ns)} ms without one" if period_ns else "sent on events"
    words += f", never within {_ms(inhibit_ns)} ms" if inhibit_ns else ""
    return Rhythm(EVENT_DRIVEN, round(period_ns / MS), round(inhibit_ns / INHIBIT_UNIT_NS), words)


def _distances(instants: Sequence[int]) -> list[int]:
    return [later - earlier for earlier, later in pairwise(instants)]


def _share(distances: Sequence[int], period_ns: int) -> float:
    """Return the share of the distances that are about a period."""
    near = sum(abs(distance - period_ns) <= _tolerance(period_ns) for distance in distances)
    return near / len(distances)


def _tolerance(period_ns: int) -> float:
    return max(JITTER * period_ns, LEAST_JITTER_NS)


def _inhibit(distances: Sequence[int]) -> int:
    """Return the inhibit time: the smallest distance, if several are the same and others are longer; 0 without one."""
    shortest = min(distances)
    same = sum(distance <= shortest * 1.02 for distance in distances)
    is_limit = MS <= shortest <= MOST_INHIBIT_NS and FEWEST <= same < SHARE * len(distances)
    return shortest if is_limit and not _is_grid(distances, shortest) else 0


def _is_grid(distances: Sequence[int], step_ns: int) -> bool:
    """True if the distances are multiples of one: the node looks at its inputs in this time, and is not held back."""
    multiples = [distance / step_ns for distance in distances]
    return sum(abs(multiple - round(multiple)) < 0.05 for multiple in multiples) >= SHARE * len(multiples)


def _ms(time_ns: int) -> str:
    return f"{time_ns / MS:.3g}" if time_ns < 100 * MS else f"{time_ns / MS:.0f}"
