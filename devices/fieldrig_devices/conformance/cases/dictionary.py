"""OD 01 to 09: the object dictionary matches the EDS.

Source: CiA 301 7.4, CiA 306-1 4.6.3.  Reading: the log has three of the cases twice; the first time they are tested in
'pre-operational', the second time in 'operational'.
"""

from collections.abc import Iterator

from fieldrig_devices.conformance import nmt
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.description import Entry
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import State
from fieldrig_devices.conformance.objects import (
    SERIAL_NUMBER,
    is_command,
    is_guarded,
    is_identifier,
    is_live,
    is_plain,
)
from fieldrig_devices.conformance.verdict import Aborted, SdoFault

WRITE_ONLY, READ_ONLY, NO_SUB, NO_DATA = 0x0601_0001, 0x0601_0002, 0x0609_0011, 0x0800_0024
GENERAL, INVALID_VALUE, TOO_HIGH, TOO_LOW = 0x0800_0000, 0x0609_0030, 0x0609_0031, 0x0609_0032
BY_ITSELF = (0x0800_0021, 0x0800_0022)
"""Abort codes for a value that the device sets itself at present, such as by its program (CiA 301 table 22)."""
STRUCTURE, HISTORY = 0xFF, 0x1003
SHOWN = 5
"""Number of deviations that a verdict lists."""
ACCESS = "CiA 301 7.4; CiA 306-1 4.6.3"


@case(
    "4.1",
    "OD 01",
    "In 'pre-operational', all readable objects of the EDS can be read and have the size of their type.",
    ACCESS,
)
def readable(bench: Bench) -> Steps[None]:
    yield from _read_all(bench)


@case(
    "4.2",
    "OD 02",
    "After a reset, values are the defaults of the EDS, except those that change by themselves.",
    "CiA 306-1 4.6.3",
)
def defaults(bench: Bench) -> Steps[None]:
    yield from nmt.restart(bench, nmt.Command.RESET_NODE)
    yield from _compare_all(bench)


@case("4.3", "OD 03", "Read-only objects of the EDS cannot be written.", f"{ACCESS}; CiA 301 table 22")
def read_only(bench: Bench) -> Steps[None]:
    entries = bench.entries(
        lambda entry: entry.access in ("ro", "const") and entry.size in (1, 2, 4), "read-only object"
    )
    faults = _Faults(bench, "abort 0601 0002h for writing read-only objects")
    for entry in entries:
        try:
            yield from bench.attempt(entry.index, entry.sub, bytes(entry.size or 1))
        except Aborted as abort:
            if abort.code not in bench.accepted(READ_ONLY):
                faults.add(entry, str(abort))
        else:
            faults.add(entry, "accepted")
    faults.check()


@case("4.4", "OD 04", "Write-only objects of the EDS cannot be read.", f"{ACCESS}; CiA 301 table 22")
def write_only(bench: Bench) -> Steps[None]:
    entries = bench.entries(lambda entry: entry.access == "wo", "write-only object")
    for entry in entries:
        yield from bench.refuses(bench.sdo.read(entry.index, entry.sub), WRITE_ONLY, what=f"reading {entry.key}")


@case("4.5", "OD 05", "Sub-index FFh, where it exists, gives the object code and data type.", "CiA 301 7.4.7")
def structure(bench: Bench) -> Steps[None]:
    is_anywhere = False
    for index in bench.eds.indices(0x1000, 0xFFFF):
        try:
            data = yield from bench.sdo.read(index, STRUCTURE)
        except Aborted as abort:
            bench.check(abort.code == NO_SUB, f"abort 0609 0011h where {index:04X}h:FFh doesn't exist", str(abort))
            continue
        is_anywhere = True
        bench.check(len(data) == 4, f"4 bytes in {index:04X}h:FFh", data.hex(" "))
        member = bench.eds.get(index, 1) or bench.eds.get(index, 0)
        if member is not None and data[0] in (7, 8):  # a record has its own data type
            came = int.from_bytes(data[1:3], "little")
            bench.check(came == member.type, f"data type {member.type:04X}h in {index:04X}h:FFh", f"{came:04X}h")
    if not is_anywhere:
        bench.skip("no object of the node has sub-index FFh")


@case(
    "4.6",
    "OD 06",
    "Values beyond the limits of the EDS are refused; the limits themselves are accepted.",
    "CiA 306-1 4.6.3",
)
def limits(bench: Bench) -> Steps[None]:
    entries = bench.entries(
        lambda entry: entry.access in ("rw", "rwr", "rww") and is_free(entry) and any(_beyond(entry)),
        "limits beyond which the type can hold a value",
    )
    for entry in entries:
        for value in _beyond(entry):
            attempt = bench.attempt(entry.index, entry.sub, entry.encode(value))
            yield from bench.refuses(attempt, TOO_HIGH, TOO_LOW, INVALID_VALUE, what=f"{value} for {entry.key}")
        if is_plain(entry) and not entry.is_mappable:
            for value in (limit for limit in (entry.low, entry.high) if limit is not None):
                yield from bench.change(entry.index, entry.sub, entry.encode(value))


@case(
    "4.7",
    "OD 07",
    "In 'operational', all readable objects of the EDS can be read and have the size of their type.",
    ACCESS,
)
def readable_in_operational(bench: Bench) -> Steps[None]:
    yield from nmt.enter(bench, State.OPERATIONAL)
    yield from _read_all(bench)


@case(
    "4.8",
    "OD 08",
    "In 'operational', too, values that have not been written are the defaults of the EDS.",
    "CiA 306-1 4.6.3",
)
def defaults_in_operational(bench: Bench) -> Steps[None]:
    yield from nmt.restart(bench, nmt.Command.RESET_NODE)
    yield from nmt.enter(bench, State.OPERATIONAL)
    yield from _compare_all(bench)


@case("4.9", "OD 09", "In 'operational', read-write objects accept the value that was read from them.", ACCESS)
def write_back(bench: Bench) -> Steps[None]:
    yield from nmt.enter(bench, State.OPERATIONAL)
    entries = bench.entries(
        lambda entry: is_plain(entry) and entry.is_writable, "object that can be read and written at any time"
    )
    faults = _Faults(bench, "all objects to accept the values that were read")
    for entry in entries:
        try:
            value = yield from bench.sdo.read(entry.index, entry.sub)
            yield from bench.sdo.write(entry.index, entry.sub, value)
        except SdoFault as fault:
            if not (isinstance(fault, Aborted) and fault.code in BY_ITSELF):
                faults.add(entry, str(fault))
    faults.check()


class _Faults:
    """Collects deviations of several objects for one verdict."""

    def __init__(self, bench: Bench, expected: str) -> None:
        self._bench, self._expected = bench, expected
        self._texts: list[str] = []

    def add(self, entry: Entry, came: str) -> None:
        self._texts.append(f"{entry.key}: {came}")

    def check(self) -> None:
        more = f"; and {len(self._texts) - SHOWN} more" if len(self._texts) > SHOWN else ""
        self._bench.check(not self._texts, self._expected, "; ".join(self._texts[:SHOWN]) + more)


def _read_all(bench: Bench) -> Steps[None]:
    faults = _Faults(bench, "every readable object to be read with the size of its type")
    for entry in bench.eds:
        if not entry.is_readable:
            continue
        try:
            data = yield from bench.sdo.read(entry.index, entry.sub)
        except Aborted as abort:
            is_empty = entry.index == HISTORY and abort.code in (NO_DATA, GENERAL)
            if not is_empty:
                faults.add(entry, str(abort))
        else:
            if entry.size not in (None, len(data)):
                faults.add(entry, f"{len(data)} bytes for {entry.size}")
    faults.check()


def _compare_all(bench: Bench) -> Steps[None]:
    entries = bench.entries(
        lambda entry: entry.is_readable and entry.default is not None and not is_live(entry), "defaults"
    )
    faults = _Faults(bench, "the defaults of the EDS (1011h restores them if parameters are stored)")
    for entry in entries:
        data = yield from bench.sdo.read(entry.index, entry.sub)
        assert entry.default is not None
        if data != entry.default and not (yield from _is_set_by_itself(bench, entry, data)):
            faults.add(entry, f"{data.hex(' ')} for {entry.default.hex(' ')}")
    faults.check()


def _is_set_by_itself(bench: Bench, entry: Entry, present: bytes) -> Steps[bool]:
    """Return whether the device refuses a write of the present value because it sets the value itself."""
    if not entry.is_writable or not is_plain(entry):
        return False
    try:
        yield from bench.sdo.write(entry.index, entry.sub, present)
    except Aborted as abort:
        return abort.code in BY_ITSELF
    except SdoFault:
        return False
    return False


def is_free(entry: Entry) -> bool:
    """True if a value may be written by itself, whatever the node does at present."""
    return not is_guarded(entry) and not is_identifier(entry)


def _beyond(entry: Entry) -> Iterator[int]:
    """Yield the nearest values beyond the limits, as far as the data type can hold them."""
    if not entry.is_integer or is_command(entry) or (entry.index, entry.sub) == SERIAL_NUMBER:
        return
    lowest, highest = entry.range
    if entry.low is not None and entry.low > lowest:
        yield entry.low - 1
    if entry.high is not None and entry.high < highest:
        yield entry.high + 1
