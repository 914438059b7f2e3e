"""The instant of the rig at which a log begins."""

from collections.abc import Iterable, Iterator
from itertools import chain, islice
from typing import Final

from fieldrig.clock import S
from fieldrig.traces.trace import TraceEntry, is_time_of_day
from fieldrig_devices.canopen.names import ERROR_CONTROL, NODES

SETTLE_NS: Final = S
"""Time for a rig to boot before a log begins that was recorded of a machine that was on already."""
HEAD: Final = 500
BOOT_UP: Final = b"\x01\x00"
"""Length and data of a boot-up message (CiA 301, 7.2.8.3.2.1)."""


def begin_of(
    entries: Iterable[TraceEntry], now_ns: int, settle_ns: int | None
) -> tuple[Iterator[TraceEntry], int, int]:
    """Return the log, the instant of the rig at which it begins, and the instant of the log that this is.

    A trace of virtual time begins with its rig.  Elsewhere the rig boots first, except if the log shows that its nodes
    boot; `settle_ns` is how long.  UsageError is raised by the log itself.
    """
    rest = iter(entries)
    head = list(islice(rest, HEAD))
    log = chain(head, rest)
    first_ns = min((entry.time_ns for entry in head), default=0)
    if not is_time_of_day(first_ns) and now_ns == 0 and settle_ns is None:
        return log, 0, 0
    if settle_ns is None:
        settle_ns = 0 if now_ns or any(map(_is_boot_up, head)) else SETTLE_NS
    return log, now_ns + settle_ns, first_ns


def _is_boot_up(entry: TraceEntry) -> bool:
    word = int.from_bytes(entry.data[:4], "little")
    return entry.family == "can" and word - ERROR_CONTROL in NODES and entry.data[4:] == BOOT_UP
