"""Synchronization 01 to 10: consuming and producing SYNC, its counter, and its stored parameters.

Source: CiA 301 7.2.5, 7.5.2.5 (1005h), 7.5.2.6 (1006h), 7.5.2.22 (1019h).
"""

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance import nmt, store, sync
from fieldrig_devices.conformance.bench import Bench, show
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import Command, State
from fieldrig_devices.conformance.pdo import configure, usable_tpdos
from fieldrig_devices.conformance.period import check_period
from fieldrig_devices.conformance.sync import COB_ID, OVERFLOW, PERIOD, PRODUCES
from fieldrig_devices.conformance.verdict import NotApplicable

DEFAULT_ID = 0x80
INVALID_VALUE, TOO_HIGH, TOO_LOW = 0x0609_0030, 0x0609_0031, 0x0609_0032
DEVICE_STATE, GENERAL = 0x0800_0022, 0x0800_0000
INVALID_OVERFLOWS = (1, 241, 255)
COUNTED = 10


@case("6.1", "Synchronization 01", "The COB-ID of SYNC is 80h, or the default of the EDS.", "CiA 301 7.5.2.5, 7.3.3")
def default_id(bench: Bench) -> Steps[None]:
    entry = bench.entry(COB_ID)
    right = DEFAULT_ID if entry.default is None else int.from_bytes(entry.default, "little")
    came = yield from bench.read(COB_ID)
    bench.check(came == right, f"{right:08X}h in 1005h:00h", f"{came:08X}h")


@case("6.2", "Synchronization 02", "A SYNC producer sends SYNC in the period of 1006h.", "CiA 301 7.2.5, 7.5.2.6")
def count_syncs(bench: Bench) -> Steps[None]:
    sync_id = yield from sync.produce(bench, bench.period_ms)
    yield from check_period(bench, sync_id, "SYNC")


@case(
    "6.3",
    "Synchronization 03",
    "A TPDO of type 1 is sent once for each SYNC, regardless of its producer.",
    "CiA 301 7.2.2.2",
)
def count_pdos(bench: Bench) -> Steps[None]:
    pdo = (yield from usable_tpdos(bench))[0]
    identifier = yield from configure(bench, pdo, 1)
    yield from nmt.enter(bench, State.OPERATIONAL)
    try:
        sync_id = yield from sync.produce(bench, bench.period_ms)
        first = len(bench.line.seen)
        yield from bench.gather(sync_id, first, COUNTED, bench.period_ms)
    except NotApplicable:
        sync_id = yield from sync.consume(bench)
        overflow = yield from sync.overflow(bench)
        first = len(bench.line.seen)
        yield from sync.give(bench, sync_id, COUNTED, overflow)
        yield from bench.gather(identifier, first, COUNTED)
    yield from bench.barrier()
    seen = [entry.frame.identifier for entry in bench.line.seen[first:]]
    bench.check(sync_id in seen, "SYNC on the bus", "none")
    seen = seen[seen.index(sync_id) :]
    syncs, pdos = seen.count(sync_id), seen.count(identifier)
    bench.check(abs(pdos - syncs) <= (1 if syncs > pdos else 0), f"{syncs} {pdo.name}, one for each SYNC", str(pdos))


@case("6.4", "Synchronization 04", "As a consumer with 1006h at 0, the node sends no SYNC.", "CiA 301 7.5.2.6")
def consumer(bench: Bench) -> Steps[None]:
    bench.entry(PERIOD, writable=True)
    try:
        yield from sync.produce(bench, bench.period_ms)
        yield from bench.wait(2 * bench.period_ms)
    except NotApplicable:
        pass  # the node cannot produce SYNC at all
    sync_id = yield from sync.consume(bench)
    yield from bench.change(PERIOD, 0, 0)
    yield from bench.silence(sync_id, "SYNC of a consumer", 3 * bench.period_ms)


@case("6.5", "Synchronization 05", "Overflow values of 1 and above 240 are refused.", "CiA 301 7.5.2.22")
def invalid_overflow(bench: Bench) -> Steps[None]:
    bench.entry(OVERFLOW, writable=True)
    yield from sync.without_period(bench)
    for value in INVALID_OVERFLOWS:
        attempt = bench.attempt(OVERFLOW, 0, bytes((value,)))
        yield from bench.refuses(attempt, INVALID_VALUE, TOO_HIGH, TOO_LOW, what=f"{value} for 1019h:00h")


@case("6.6", "Synchronization 06", "With an overflow value of 0, SYNC has no data.", "CiA 301 7.2.5, 7.5.2.22")
def no_counter(bench: Bench) -> Steps[None]:
    frames = yield from _produced(bench, overflow=0)
    for frame in frames:
        bench.check(frame.data == b"", "SYNC without data", show(frame))


@case(
    "6.7", "Synchronization 07", "The counter of SYNC runs from 1 to its overflow value, repeatedly.", "CiA 301 7.2.5.2"
)
def counter(bench: Bench) -> Steps[None]:
    frames = yield from _produced(bench, overflow=4)
    came = [int.from_bytes(frame.data, "little") for frame in frames]
    right = [number % 4 + 1 for number in range(len(came))]
    bench.check(came == right, f"counters {right}", str(came))


@case(
    "6.8", "Synchronization 08", "A stored overflow value survives a reset of the node.", "CiA 301 7.5.2.13, 7.5.2.22"
)
def stored_overflow(bench: Bench) -> Steps[None]:
    bench.entry(OVERFLOW, writable=True)
    yield from store.check_can_save(bench, store.ALL)
    yield from sync.without_period(bench)
    yield from bench.change(OVERFLOW, 0, 20)
    yield from store.save(bench, store.ALL)
    yield from nmt.restart(bench, Command.RESET_NODE)
    came = yield from bench.read(OVERFLOW)
    bench.check(came == 20, "20 in 1019h:00h after saving and a reset", str(came))


@case("6.9", "Synchronization 09", "While 1006h is not 0, the overflow value cannot be changed.", "CiA 301 7.5.2.22")
def overflow_in_use(bench: Bench) -> Steps[None]:
    bench.entry(OVERFLOW, writable=True)
    bench.entry(PERIOD, writable=True)
    before = yield from bench.read(OVERFLOW)
    yield from bench.change(PERIOD, 0, bench.period_ms * 1000)
    attempt = bench.attempt(OVERFLOW, 0, bytes((10 if before != 10 else 11,)))
    yield from bench.refuses(attempt, DEVICE_STATE, GENERAL, what="a change of 1019h:00h while 1006h:00h is not 0")


@case(
    "6.10",
    "Synchronization 10",
    "Stored SYNC parameters are in effect after a reset of the node.",
    "CiA 301 7.5.2.13, 7.2.5",
)
def stored_producer(bench: Bench) -> Steps[None]:
    bench.entry(OVERFLOW, writable=True)
    yield from store.check_can_save(bench, store.ALL)
    yield from sync.without_period(bench)
    yield from bench.change(OVERFLOW, 0, 5)
    sync_id = yield from sync.produce(bench, bench.period_ms)
    right: dict[int, int] = {}
    for index in (COB_ID, PERIOD, OVERFLOW):
        right[index] = yield from bench.read(index)
    yield from store.save(bench, store.ALL)
    yield from nmt.restart(bench, Command.RESET_NODE)
    for index, value in right.items():
        came = yield from bench.read(index)
        bench.check(came == value, f"{value:08X}h in {index:04X}h:00h after saving and a reset", f"{came:08X}h")
    frame = yield from bench.expect(sync_id, bench.period_ms + bench.patience_ms)
    bench.check(frame is not None and len(frame.data) == 1, "SYNC with a counter after the reset", _shown(frame))


def _produced(bench: Bench, overflow: int) -> Steps[list[CanFrame]]:
    """Make the node produce SYNC with this overflow value, and return its messages."""
    bench.entry(OVERFLOW, writable=True)
    bench.entry(COB_ID, writable=True)
    yield from sync.without_period(bench)
    yield from _stop_producing(bench)
    yield from bench.change(OVERFLOW, 0, overflow)
    first = len(bench.line.seen)
    sync_id = yield from sync.produce(bench, bench.period_ms)
    yield from check_period(bench, sync_id, "SYNC")
    return [seen.frame for seen in bench.came(sync_id, first)]


def _stop_producing(bench: Bench) -> Steps[None]:
    cob_id = yield from bench.read(COB_ID)
    if cob_id & PRODUCES:
        yield from bench.change(COB_ID, 0, cob_id & ~PRODUCES)


def _shown(frame: CanFrame | None) -> str:
    return "none" if frame is None else show(frame)
