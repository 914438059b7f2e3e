"""SDO 01 to 12: expedited access and refusals.

Source: CiA 301 7.2.4.3 (protocols), table 22 (abort codes), 7.5.2.33 (1200h).
"""

from collections.abc import Iterator

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.description import LAST_OF_COMMUNICATION, Entry
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.objects import is_guarded, is_plain
from fieldrig_devices.conformance.sdo import expedited_data, multiplexer
from fieldrig_devices.conformance.verdict import ABORT_TEXTS

DEVICE_TYPE = 0x1000
UNKNOWN_COMMAND = 0x0504_0001
WRITE_ONLY, READ_ONLY = 0x0601_0001, 0x0601_0002
NO_OBJECT, NO_SUB = 0x0602_0000, 0x0609_0011
LENGTH_MISMATCH, TOO_LONG, TOO_SHORT = 0x0607_0010, 0x0607_0012, 0x0607_0013
INVALID_VALUE, TOO_HIGH, TOO_LOW = 0x0609_0030, 0x0609_0031, 0x0609_0032
ABORTS = "CiA 301 7.2.4.3.17, table 22"


@case("2.1", "SDO 01", "The device type is read in one expedited transfer of four bytes.", "CiA 301 7.2.4.3.6, 7.5.2.1")
def read_expedited(bench: Bench) -> Steps[None]:
    answer = yield from bench.sdo.initiate_upload(DEVICE_TYPE, 0)
    bench.check(answer[0] == 0x43, "command 43h: expedited, 4 bytes", f"{answer[0]:02X}h")
    entry = bench.eds.get(DEVICE_TYPE)
    if entry is not None and entry.default is not None:
        data = expedited_data(answer, "reading 1000h:00h")
        bench.check(data == entry.default, f"{entry.default.hex(' ')}, as in the EDS", data.hex(" "))


@case("2.2", "SDO 02", "Read-write objects keep the value that is written.", "CiA 301 7.2.4.3.4, 7.4")
def read_and_write(bench: Bench) -> Steps[None]:
    entries = bench.entries(
        lambda entry: is_plain(entry) and entry.is_writable and entry.index <= LAST_OF_COMMUNICATION,
        "plain parameter from 1000h to 1FFFh that can be read and written",
    )
    for entry in entries:
        before = yield from bench.sdo.read(entry.index, entry.sub)
        yield from bench.sdo.write(entry.index, entry.sub, before)
        after = yield from bench.sdo.read(entry.index, entry.sub)
        bench.check(after == before, f"{entry.key} to hold {before.hex(' ')}", after.hex(" "))


@case("2.3", "SDO 03", "Writing the device type, which is read-only, is refused.", ABORTS)
def write_read_only(bench: Bench) -> Steps[None]:
    yield from bench.refuses(bench.attempt(DEVICE_TYPE, 0, bytes(4)), READ_ONLY, what="writing 1000h:00h")


@case("2.4", "SDO 04", "Reading a write-only object is refused.", ABORTS)
def read_write_only(bench: Bench) -> Steps[None]:
    entries = bench.entries(lambda entry: entry.access == "wo", "write-only object")
    yield from bench.refuses(
        bench.sdo.read(entries[0].index, entries[0].sub), WRITE_ONLY, what=f"reading {entries[0].key}"
    )


@case("2.5", "SDO 05", "Reading a sub-index that doesn't exist is refused.", ABORTS)
def read_missing_sub(bench: Bench) -> Steps[None]:
    yield from bench.refuses(bench.sdo.read(DEVICE_TYPE, 1), NO_SUB, what="reading 1000h:01h")


@case("2.6", "SDO 06", "Reading an object that doesn't exist (1004h is reserved) is refused.", ABORTS)
def read_missing_object(bench: Bench) -> Steps[None]:
    yield from bench.refuses(bench.sdo.read(0x1004), NO_OBJECT, what="reading 1004h:00h")


@case("2.7", "SDO 07", "A request with an undefined command specifier is refused.", ABORTS)
def wrong_command(bench: Bench) -> Steps[None]:
    request = bench.sdo.ask(b"\xe0" + multiplexer(DEVICE_TYPE, 0), "command specifier 7")
    yield from bench.refuses(request, UNKNOWN_COMMAND, what="command specifier 7")


@case("2.8", "SDO 08", "Writing four bytes to an object of one or two is refused and changes nothing.", ABORTS)
def too_long(bench: Bench) -> Steps[None]:
    yield from _wrong_length(bench, [entry for entry in _unsigned(bench) if entry.size in (1, 2)], 4, TOO_LONG)


@case("2.9", "SDO 09", "Writing one byte to an object of two or four is refused and changes nothing.", ABORTS)
def too_short(bench: Bench) -> Steps[None]:
    yield from _wrong_length(bench, [entry for entry in _unsigned(bench) if entry.size in (2, 4)], 1, TOO_SHORT)


@case("2.10", "SDO 10", "A value above the HighLimit of the EDS is refused.", f"{ABORTS}; CiA 306-1 4.6.3")
def too_high(bench: Bench) -> Steps[None]:
    entries = [entry for entry in _limited(bench) if entry.high is not None and entry.high < entry.range[1]]
    if not entries:
        bench.skip("the EDS has no HighLimit below what the type can hold")
    for entry in entries:
        assert entry.high is not None
        attempt = bench.attempt(entry.index, entry.sub, entry.encode(entry.high + 1))
        yield from bench.refuses(attempt, TOO_HIGH, INVALID_VALUE, what=f"{entry.high + 1} for {entry.key}")


@case("2.11", "SDO 11", "A value below the LowLimit of the EDS is refused.", f"{ABORTS}; CiA 306-1 4.6.3")
def too_low(bench: Bench) -> Steps[None]:
    entries = [entry for entry in _limited(bench) if entry.low is not None and entry.low > entry.range[0]]
    if not entries:
        bench.skip("the EDS has no LowLimit above what the type can hold")
    for entry in entries:
        assert entry.low is not None
        attempt = bench.attempt(entry.index, entry.sub, entry.encode(entry.low - 1))
        yield from bench.refuses(attempt, TOO_LOW, INVALID_VALUE, what=f"{entry.low - 1} for {entry.key}")


@case("2.12", "SDO 12", "The first SDO channel is at 600h and 580h plus the node-ID.", "CiA 301 7.3.3, 7.5.2.33")
def default_channel(bench: Bench) -> Steps[None]:
    bench.entry(0x1200, 1)
    for sub, right in ((1, bench.sdo.request_id), (2, bench.sdo.response_id)):
        came = yield from bench.read(0x1200, sub)
        bench.check(came == right, f"{right:08X}h in 1200h:{sub:02X}h", f"{came:08X}h")


def _wrong_length(bench: Bench, entries: list[Entry], size: int, code: int) -> Steps[None]:
    if not entries:
        bench.skip("the EDS has no such object that can be written")
    entry = entries[0]
    before = yield from bench.sdo.read(entry.index, entry.sub)
    attempt = bench.attempt(entry.index, entry.sub, before[:1].ljust(size, b"\x00"))
    what = f"{size} bytes for {entry.key} ({ABORT_TEXTS[code]})"
    yield from bench.refuses(attempt, code, LENGTH_MISMATCH, what=what)
    after = yield from bench.sdo.read(entry.index, entry.sub)
    bench.check(after == before, f"{entry.key} to keep {before.hex(' ')}", after.hex(" "))


def _unsigned(bench: Bench) -> Iterator[Entry]:
    return (entry for entry in bench.eds if is_plain(entry) and entry.is_writable and entry.is_integer)


def _limited(bench: Bench) -> list[Entry]:
    """Return objects whose limits can be tested; those that need a procedure have cases of their own."""
    entries = (entry for entry in bench.eds if entry.is_writable and not is_guarded(entry))
    return [entry for entry in entries if entry.is_integer and entry.size in (1, 2, 4)]
