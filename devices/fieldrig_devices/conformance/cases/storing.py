"""Testing other 01 to 10: storing, restoring, the configuration date, and restricted CAN-IDs.

Source: CiA 301 7.5.2.13 (1010h), 7.5.2.14 (1011h), 7.5.2.23 (1020h), table 41 (restricted CAN-IDs).  Reading: in the
log, `wron` means a wrong signature and `daol` means "load"; its cases 01, 02, 05, 06 are the same with "save".
"""

from functools import partial

from fieldrig_devices.conformance import nmt, store
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.description import Entry
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import Command
from fieldrig_devices.conformance.objects import RPDO, TPDO
from fieldrig_devices.conformance.pdo import INVALID
from fieldrig_devices.conformance.store import ALL, COMMUNICATION, RESTORE, STORE
from fieldrig_devices.conformance.verdict import NotApplicable

CONFIGURATION_DATE, SYNC_ID, EMCY_ID = 0x1020, 0x1005, 0x1014
CANNOT_STORE = tuple(range(0x0800_0020, 0x0800_0023))
INVALID_VALUE, TOO_HIGH, TOO_LOW = 0x0609_0030, 0x0609_0031, 0x0609_0032
SAVE_CLAUSE, LOAD_CLAUSE = "CiA 301 7.5.2.13", "CiA 301 7.5.2.14"
RESTRICTED = (0x000, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701, 0x77F, 0x780, 0x7FF)
"""The limits of the ranges in table 41."""

# Parameters that are easy to read back and harmless to change, with two values each, the most common first.
TRIALS = ((0x1017, 0, 1234, 2345), (0x100C, 0, 1234, 2345), (0x1016, 1, 0x7D04D2, 0x7D0929), (0x1029, 1, 1, 0))


@case("8.2", "Testing other 02", 'After "save" in 1010h:01h, all parameters survive a reset of the node.', SAVE_CLAUSE)
def save_all(bench: Bench) -> Steps[None]:
    yield from _saved(bench, ALL)


@case("8.4", "Testing other 04", 'After "load" in 1011h:01h, the next reset restores all defaults.', LOAD_CLAUSE)
def restore_all(bench: Bench) -> Steps[None]:
    yield from _restored(bench, ALL, Command.RESET_NODE)


@case(
    "8.6", "Testing other 06", 'After "save" in 1010h:02h, the communication parameters survive a reset.', SAVE_CLAUSE
)
def save_communication(bench: Bench) -> Steps[None]:
    yield from _saved(bench, COMMUNICATION)


@case(
    "8.8",
    "Testing other 08",
    'After "load" in 1011h:02h, the next reset restores the communication defaults.',
    LOAD_CLAUSE,
)
def restore_communication(bench: Bench) -> Steps[None]:
    """Accept the defaults after a reset of communication (CiA 301) or of the node (the log of CiA's tool)."""
    yield from _restored(bench, COMMUNICATION, Command.RESET_COMMUNICATION, Command.RESET_NODE)


@case(
    "8.9",
    "Testing other 09",
    "The configuration date is stored with the configuration; a later change of a parameter sets it to 0.",
    "CiA 301 7.5.2.23",
)
def configuration_date(bench: Bench) -> Steps[None]:
    bench.entry(CONFIGURATION_DATE, 1, writable=True)
    bench.entry(CONFIGURATION_DATE, 2, writable=True)
    yield from store.check_can_save(bench, ALL)
    entry, first, _ = _trial(bench)
    for sub, value in ((1, 12345), (2, 67890)):
        yield from bench.change(CONFIGURATION_DATE, sub, value)
    yield from store.save(bench, ALL)
    yield from nmt.restart(bench, Command.RESET_NODE)
    for sub, value in ((1, 12345), (2, 67890)):
        came = yield from bench.read(CONFIGURATION_DATE, sub)
        bench.check(came == value, f"{value} in 1020h:{sub:02X}h after saving and a reset", str(came))
    yield from bench.change(entry.index, entry.sub, first)
    for sub in (1, 2):
        came = yield from bench.read(CONFIGURATION_DATE, sub)
        bench.check(came == 0, f"0 in 1020h:{sub:02X}h after {entry.key} was changed", str(came))


@case(
    "8.10", "Testing other 10", "CAN-IDs that are reserved for other services are refused.", "CiA 301 7.3.5, table 41"
)
def restricted_ids(bench: Bench) -> Steps[None]:
    entries = bench.entries(lambda entry: _is_cob_id(entry) and entry.is_writable, "COB-ID that can be written")
    for entry in entries:
        before = yield from bench.read(entry.index, entry.sub)
        if entry.index != SYNC_ID and not before & INVALID:
            yield from bench.change(entry.index, entry.sub, before | INVALID)
        for identifier in RESTRICTED:
            attempt = bench.change(entry.index, entry.sub, identifier)
            what = f"CAN-ID {identifier:03X}h for {entry.key}"
            yield from bench.refuses(attempt, INVALID_VALUE, TOO_HIGH, TOO_LOW, what=what)


def _wrong_signature(bench: Bench, index: int, sub: int) -> Steps[None]:
    yield from (store.check_can_save if index == STORE else store.check_can_restore)(bench, sub)
    attempt = bench.sdo.write(index, sub, store.WRONG)
    yield from bench.refuses(attempt, *CANNOT_STORE, what=f"a wrong signature for {index:04X}h:{sub:02X}h")


def _saved(bench: Bench, sub: int) -> Steps[None]:
    yield from store.check_can_save(bench, sub)
    entry, first, second = _trial(bench)
    yield from bench.change(entry.index, entry.sub, first)
    yield from store.save(bench, sub)
    yield from bench.change(entry.index, entry.sub, second)
    yield from nmt.restart(bench, Command.RESET_NODE)
    came = yield from bench.read(entry.index, entry.sub)
    bench.check(came == first, f"{first} in {entry.key}, as it was saved, after a reset", str(came))


def _restored(bench: Bench, sub: int, *resets: Command) -> Steps[None]:
    """Check that the defaults are restored after the first reset or, with a warning, after a later one."""
    yield from store.check_can_restore(bench, sub)
    entry, first, _ = _trial(bench)
    yield from bench.change(entry.index, entry.sub, first)
    if bench.eds.get(STORE, sub) is not None:
        yield from store.check_can_save(bench, sub)
        yield from store.save(bench, sub)
    yield from store.restore(bench, sub)
    came = yield from bench.read(entry.index, entry.sub)
    bench.check(came == first, f"{first} in {entry.key} until the reset", str(came))
    default = int.from_bytes(entry.default or b"", "little")
    for number, reset in enumerate(resets):
        yield from nmt.restart(bench, reset)
        came = yield from bench.read(entry.index, entry.sub)
        if came == default:
            if number > 0:
                bench.warn("the defaults are restored by a reset of the node, but not by a reset of communication")
            break
    bench.check(came == default, f"{default} in {entry.key}, its default, after the reset", str(came))


def _trial(bench: Bench) -> tuple[Entry, int, int]:
    """Return a parameter and two values for it.  Not applicable if the EDS has none of `TRIALS`."""
    for index, sub, first, second in TRIALS:
        entry = bench.eds.get(index, sub)
        if entry is not None and entry.is_writable:
            return entry, first, second
    raise NotApplicable("the EDS has no writable heartbeat time, guard time, consumer time or error behaviour")


def _is_cob_id(entry: Entry) -> bool:
    if (entry.index in RPDO or entry.index in TPDO) and entry.sub == 1:
        return True
    return entry.index in (SYNC_ID, EMCY_ID) and entry.sub == 0


WRONG_SIGNATURES = (
    (1, STORE, ALL, "stores", SAVE_CLAUSE),
    (3, RESTORE, ALL, "restores", LOAD_CLAUSE),
    (5, STORE, COMMUNICATION, "stores", SAVE_CLAUSE),
    (7, RESTORE, COMMUNICATION, "restores", LOAD_CLAUSE),
)
"""Testing other 01, 03, 05 and 07: number, object, sub-index, what the node must not do, and the clause."""

for number, index, sub, verb, clause in WRONG_SIGNATURES:
    requirement = f"A wrong signature in {index:04X}h:{sub:02X}h {verb} nothing and is refused."
    case(f"8.{number}", f"Testing other {number:02d}", requirement, clause)(
        partial(_wrong_signature, index=index, sub=sub)
    )
