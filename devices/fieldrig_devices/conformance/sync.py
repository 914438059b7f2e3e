"""SYNC messages of the suite, and the node's SYNC parameters.

Source: CiA 301 7.2.5, 7.5.2.5 (1005h), 7.5.2.6 (1006h), 7.5.2.22 (1019h).
"""

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.pdo import identifier
from fieldrig_devices.conformance.verdict import Aborted

COB_ID, PERIOD, OVERFLOW = 0x1005, 0x1006, 0x1019
PRODUCES = 1 << 30
INVALID_VALUE = 0x0609_0030
GAP_MS = 20
"""Time between two of our SYNC messages, for the reactions of the node."""


def consume(bench: Bench) -> Steps[int]:
    """Make the node a SYNC consumer, and return the CAN identifier of SYNC.  Not applicable without 1005h."""
    bench.entry(COB_ID)
    cob_id = yield from bench.read(COB_ID)
    if cob_id & PRODUCES:
        yield from bench.change(COB_ID, 0, cob_id & ~PRODUCES)
    return identifier(cob_id)


def produce(bench: Bench, period_ms: int) -> Steps[int]:
    """Make the node produce SYNC, and return its CAN identifier.  Not applicable if the node cannot."""
    bench.entry(COB_ID, writable=True)
    bench.entry(PERIOD, writable=True)
    yield from bench.change(PERIOD, 0, period_ms * 1000)
    cob_id = yield from bench.read(COB_ID)
    try:
        yield from bench.change(COB_ID, 0, cob_id | PRODUCES)
    except Aborted as abort:
        if abort.code == INVALID_VALUE:
            bench.skip("the node cannot produce SYNC: it refuses bit 30 of 1005h with 0609 0030h")
        raise
    return identifier(cob_id)


def without_period(bench: Bench) -> Steps[None]:
    """Set 1006h to 0, which a change of 1019h requires."""
    entry = bench.eds.get(PERIOD)
    if entry is not None and entry.is_writable:
        yield from bench.change(PERIOD, 0, 0)


def give(bench: Bench, sync_id: int, count: int, overflow: int = 0) -> Steps[None]:
    """Send `count` SYNC messages, with a counter from 1 on if there is an overflow value."""
    for number in range(count):
        bench.send(sync_id, bytes((number % overflow + 1,)) if overflow else b"")
        yield from bench.wait(GAP_MS)


def overflow(bench: Bench) -> Steps[int]:
    """Return the node's overflow value; 0 if SYNC has no counter."""
    if bench.eds.get(OVERFLOW) is None:
        return 0
    return (yield from bench.read(OVERFLOW))
