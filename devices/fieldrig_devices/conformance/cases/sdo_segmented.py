"""SDO 13 to 18: segmented transfer.

Source: CiA 301 7.2.4.3.3 to 7.2.4.3.8.  The server chooses the protocol of an upload; where an object of four bytes is
to be read in segments, an expedited answer is right, too, as long as no transfer is left open.
"""

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import GUARD_TIME, HEARTBEAT_TIME
from fieldrig_devices.conformance.sdo import expedited_data
from fieldrig_devices.conformance.strings import long_object

DEVICE_TYPE = 0x1000
TOGGLE, UNKNOWN_COMMAND = 0x0503_0000, 0x0504_0001


@case(
    "2.13",
    "SDO 13",
    "The device type is read in segments if the server chooses so; after an expedited answer there is no segment.",
    "CiA 301 7.2.4.3.6, 7.2.4.3.7",
)
def read_device_type(bench: Bench) -> Steps[None]:
    what = "reading 1000h:00h"
    initiated = yield from bench.sdo.initiate_upload(DEVICE_TYPE, 0)
    if initiated[0] & 0x02:
        data = expedited_data(initiated, what)
        yield from bench.refuses(
            bench.sdo.ask(b"\x60", "a segment that doesn't exist"), UNKNOWN_COMMAND, what="a segment that doesn't exist"
        )
    else:
        data = yield from bench.sdo.upload_segments(initiated, what)
    bench.check(len(data) == 4, "4 bytes of device type", data.hex(" "))


@case("2.14", "SDO 14", "The guard time can be written in a segment.", "CiA 301 7.2.4.3.4, 7.5.2.11")
def write_guard_time(bench: Bench) -> Steps[None]:
    yield from _write_in_segments(bench, GUARD_TIME)


@case("2.15", "SDO 15", "The heartbeat time can be written in a segment.", "CiA 301 7.2.4.3.4, 7.5.2.20")
def write_heartbeat_time(bench: Bench) -> Steps[None]:
    yield from _write_in_segments(bench, HEARTBEAT_TIME)


@case("2.16", "SDO 16", "An object of more than four bytes is announced with its size.", "CiA 301 7.2.4.3.6")
def announce(bench: Bench) -> Steps[None]:
    entry = yield from long_object(bench)
    initiated = yield from bench.sdo.initiate_upload(entry.index, entry.sub)
    bench.check(initiated[0] == 0x41, f"command 41h for {entry.key}: not expedited, with size", f"{initiated[0]:02X}h")
    size = int.from_bytes(initiated[4:], "little")
    bench.check(size > 4, f"a size above 4 for {entry.key}", str(size))
    data = yield from bench.sdo.upload_segments(initiated, f"reading {entry.key}")
    bench.check(len(data) == size, f"{size} bytes of {entry.key}", str(len(data)))


@case("2.17", "SDO 17", "A request for a segment whose toggle bit doesn't alternate is refused.", "CiA 301 7.2.4.3.7")
def wrong_toggle(bench: Bench) -> Steps[None]:
    entry = yield from long_object(bench)
    yield from bench.sdo.initiate_upload(entry.index, entry.sub)
    attempt = bench.sdo.ask(b"\x70", "the first segment with toggle bit 1")
    yield from bench.refuses(attempt, TOGGLE, what="the first segment with toggle bit 1")


@case("2.18", "SDO 18", "A segmented upload returns the whole object.", "CiA 301 7.2.4.3.5 to 7.2.4.3.7")
def read_whole(bench: Bench) -> Steps[None]:
    entry = yield from long_object(bench)
    data = yield from bench.sdo.read(entry.index, entry.sub)
    if entry.default is not None and not entry.is_writable:
        bench.check(data == entry.default, f"{entry.default!r} in {entry.key}, as in the EDS", repr(data))
    again = yield from bench.sdo.read(entry.index, entry.sub)
    bench.check(again == data, f"the same {len(data)} bytes of {entry.key} at a second reading", f"{len(again)} bytes")


def _write_in_segments(bench: Bench, index: int) -> Steps[None]:
    bench.entry(index, writable=True)
    before = yield from bench.sdo.read(index)
    wanted = (1000).to_bytes(2, "little")
    bench.check_allowed(index, 0, wanted)
    bench.undo.append((index, 0, before))
    yield from bench.sdo.write_segments(index, 0, wanted)
    after = yield from bench.sdo.read(index)
    bench.check(after == wanted, f"1000 ms in {index:04X}h:00h", after.hex(" "))
