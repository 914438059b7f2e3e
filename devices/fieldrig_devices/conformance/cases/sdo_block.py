"""SDO 19 to 27: block transfer.

Source: CiA 301 7.2.4.3.9 to 7.2.4.3.16.  It is optional: a server without it answers the first request with abort
0504 0001h.
"""

from fieldrig_devices.conformance import sdo_block
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import GUARD_TIME, HEARTBEAT_TIME
from fieldrig_devices.conformance.sdo import multiplexer
from fieldrig_devices.conformance.strings import long_object
from fieldrig_devices.conformance.verdict import Aborted

DEVICE_TYPE = 0x1000
UNKNOWN_COMMAND, BLOCK_SIZE, SEQUENCE = 0x0504_0001, 0x0504_0002, 0x0504_0003
UPLOAD = "CiA 301 7.2.4.3.13 to 7.2.4.3.15"
DOWNLOAD = "CiA 301 7.2.4.3.9 to 7.2.4.3.12"


@case("2.19", "SDO 19", "The device type is read by block transfer without CRC.", UPLOAD)
def read_device_type(bench: Bench) -> Steps[None]:
    yield from _read(bench, DEVICE_TYPE, 0, with_crc=False)


@case("2.20", "SDO 20", "The guard time is written by block transfer without CRC.", DOWNLOAD)
def write_guard_time(bench: Bench) -> Steps[None]:
    yield from _write(bench, GUARD_TIME, with_crc=False)


@case("2.21", "SDO 21", "The heartbeat time is written by block transfer without CRC.", DOWNLOAD)
def write_heartbeat_time(bench: Bench) -> Steps[None]:
    yield from _write(bench, HEARTBEAT_TIME, with_crc=False)


@case("2.22", "SDO 22", "An object of more than four bytes is read by block transfer.", UPLOAD)
def read_long(bench: Bench) -> Steps[None]:
    entry = yield from long_object(bench)
    yield from _read(bench, entry.index, entry.sub, with_crc=False)


@case("2.23", "SDO 23", "An object is read by block transfer with CRC, and the CRC is right.", f"{UPLOAD}, 7.2.4.3.16")
def read_with_crc(bench: Bench) -> Steps[None]:
    entry = yield from long_object(bench)
    yield from _read(bench, entry.index, entry.sub, with_crc=True)


@case("2.24", "SDO 24", "The guard time is written by block transfer with CRC.", f"{DOWNLOAD}, 7.2.4.3.16")
def write_guard_time_with_crc(bench: Bench) -> Steps[None]:
    yield from _write(bench, GUARD_TIME, with_crc=True)


@case("2.25", "SDO 25", "The heartbeat time is written by block transfer with CRC.", f"{DOWNLOAD}, 7.2.4.3.16")
def write_heartbeat_time_with_crc(bench: Bench) -> Steps[None]:
    yield from _write(bench, HEARTBEAT_TIME, with_crc=True)


@case("2.26", "SDO 26", "A block size of 128 segments, beyond the sequence numbers, is refused.", UPLOAD)
def block_too_large(bench: Bench) -> Steps[None]:
    yield from _has_block_upload(bench)
    for size in (128, 0):
        request = b"\xa0" + multiplexer(DEVICE_TYPE, 0) + bytes((size, 0, 0, 0))
        attempt = bench.sdo.ask(request, f"a block size of {size}")
        yield from bench.refuses(attempt, BLOCK_SIZE, what=f"a block size of {size}")


@case("2.27", "SDO 27", "An acknowledgement of segment 128, which was never sent, is refused.", UPLOAD)
def wrong_sequence(bench: Bench) -> Steps[None]:
    yield from _has_block_upload(bench)
    yield from sdo_block.initiate_upload(bench.sdo, DEVICE_TYPE, 0, with_crc=False)
    bench.sdo.send(b"\xa3")
    yield from sdo_block.upload_block(bench.sdo, "the block upload of 1000h:00h", sdo_block.LARGEST_BLOCK)
    attempt = bench.sdo.ask(bytes((0xA2, 128, sdo_block.LARGEST_BLOCK)), "an acknowledgement of segment 128")
    yield from bench.refuses(attempt, SEQUENCE, what="an acknowledgement of segment 128")


def _read(bench: Bench, index: int, sub: int, with_crc: bool) -> Steps[None]:
    yield from _has_block_upload(bench)
    came = yield from sdo_block.read(bench.sdo, index, sub, with_crc)
    if with_crc and not came.has_crc:
        bench.skip("the server doesn't support the CRC, according to its answer")
    right = yield from bench.sdo.read(index, sub)
    bench.check(came.data == right, f"the same {len(right)} bytes as in segments", f"{len(came.data)} bytes")


def _write(bench: Bench, index: int, with_crc: bool) -> Steps[None]:
    bench.entry(index, writable=True)
    before = yield from bench.sdo.read(index)
    wanted = (1000).to_bytes(2, "little")
    bench.check_allowed(index, 0, wanted)
    bench.undo.append((index, 0, before))
    try:
        had_crc = yield from sdo_block.write(bench.sdo, index, 0, wanted, with_crc)
    except Aborted as abort:
        if abort.code == UNKNOWN_COMMAND:
            bench.skip("the server doesn't support block download: it refuses it with 0504 0001h")
        raise
    after = yield from bench.sdo.read(index)
    bench.check(after == wanted, f"1000 ms in {index:04X}h:00h", after.hex(" "))
    if with_crc and not had_crc:
        bench.skip("the server doesn't support the CRC, according to its answer")


def _has_block_upload(bench: Bench) -> Steps[None]:
    try:
        yield from sdo_block.initiate_upload(bench.sdo, DEVICE_TYPE, 0, with_crc=False)
    except Aborted as abort:
        if abort.code == UNKNOWN_COMMAND:
            bench.skip("the server doesn't support block upload: it refuses it with 0504 0001h")
        raise
    bench.sdo.abort(DEVICE_TYPE, 0)
