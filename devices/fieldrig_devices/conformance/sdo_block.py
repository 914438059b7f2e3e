"""SDO block transfer, client side.

Source: CiA 301 7.2.4.3.9 to 7.2.4.3.16.  The CRC is CCITT's with the polynomial 1021h, starting at 0.
"""

from binascii import crc_hqx
from typing import NamedTuple

from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.sdo import LARGEST, Sdo, key, multiplexer
from fieldrig_devices.conformance.verdict import Violation

LARGEST_BLOCK = 127
SEGMENT = 7
MOST_TRIES = 3
"""Blocks in a row of which no segment is acknowledged, after which a download ends."""


class BlockRead(NamedTuple):
    data: bytes
    has_crc: bool
    """True if the server sent a CRC, which was right."""


def initiate_upload(sdo: Sdo, index: int, sub: int, with_crc: bool, size: int = LARGEST_BLOCK) -> Steps[bytes]:
    what = f"the block upload of {key(index, sub)}"
    answer = yield from sdo.ask(bytes((0xA0 | with_crc << 2,)) + multiplexer(index, sub) + bytes((size, 0, 0, 0)), what)
    if answer[0] & 0xF9 != 0xC0 or answer[1:4] != multiplexer(index, sub):
        raise Violation(f"{answer.hex(' ')} in the answer to {what}, expected C0h to C6h and the same index")
    return answer


def upload_block(sdo: Sdo, what: str, size: int) -> Steps[tuple[list[bytes], bool]]:
    """Return the segments of a block, and True if it contains the last one.  The block isn't acknowledged yet."""
    parts: list[bytes] = []
    while len(parts) < size:
        segment = yield from sdo.answer(f"segment {len(parts) + 1} of {what}")
        if segment[0] & 0x7F != len(parts) + 1:
            raise Violation(f"sequence number {segment[0] & 0x7F} in {what}, expected {len(parts) + 1}")
        parts.append(segment[1:])
        if segment[0] & 0x80:
            return parts, True
    return parts, False


def read(sdo: Sdo, index: int, sub: int, with_crc: bool, size: int = LARGEST_BLOCK) -> Steps[BlockRead]:
    what = f"the block upload of {key(index, sub)}"
    initiated = yield from initiate_upload(sdo, index, sub, with_crc, size)
    sdo.send(b"\xa3")
    data, is_last = b"", False
    while not is_last:
        parts, is_last = yield from upload_block(sdo, what, size)
        data += b"".join(parts)
        if len(data) > LARGEST:
            raise Violation(f"{len(data)} bytes in {what} without the last segment")
        sdo.send(bytes((0xA2, len(parts), size)))
    ended = yield from sdo.answer(f"the end of {what}")
    if ended[0] & 0xE3 != 0xC1:
        raise Violation(f"command {ended[0]:02X}h at the end of {what}, expected C1h to DDh")
    data = data[: len(data) - (ended[0] >> 2 & 7)]
    sdo.send(b"\xa1")
    has_crc = with_crc and bool(initiated[0] & 0x04)
    crc = int.from_bytes(ended[1:3], "little")
    if has_crc and crc != crc_hqx(data, 0):
        raise Violation(f"CRC {crc:04X}h at the end of {what}, expected {crc_hqx(data, 0):04X}h")
    announced = int.from_bytes(initiated[4:], "little")
    if initiated[0] & 0x02 and announced != len(data):
        raise Violation(f"{len(data)} bytes in {what}, but {announced} were announced")
    return BlockRead(data, has_crc)


def write(sdo: Sdo, index: int, sub: int, data: bytes, with_crc: bool) -> Steps[bool]:
    """Write an object; True if the server checked the CRC."""
    what = f"the block download to {key(index, sub)}"
    request = bytes((0xC2 | with_crc << 2,)) + multiplexer(index, sub) + len(data).to_bytes(4, "little")
    answer = yield from sdo.ask(request, what)
    if answer[0] & 0xFB != 0xA0 or answer[1:4] != multiplexer(index, sub):
        raise Violation(f"{answer.hex(' ')} in the answer to {what}, expected A0h or A4h and the same index")
    has_crc, size, sent = with_crc and bool(answer[0] & 0x04), answer[4], 0
    if not 1 <= size <= LARGEST_BLOCK:
        raise Violation(f"block size {size} in the answer to {what}, expected 1 to 127")
    tries = 0
    while sent < len(data):
        before = sent
        sent, size = yield from _download_block(sdo, what, data, sent, size)
        tries = tries + 1 if sent == before else 0
        if tries == MOST_TRIES:
            raise Violation(f"no segment acknowledged of {tries} blocks of {what}, all of which were sent")
    unused = -len(data) % SEGMENT
    end = bytes((0xC1 | unused << 2,)) + (crc_hqx(data, 0) if has_crc else 0).to_bytes(2, "little")
    answer = yield from sdo.ask(end, f"the end of {what}")
    if answer[0] != 0xA1:
        raise Violation(f"command {answer[0]:02X}h at the end of {what}, expected A1h")
    return has_crc


def _download_block(sdo: Sdo, what: str, data: bytes, sent: int, size: int) -> Steps[tuple[int, int]]:
    """Send a block; return the number of bytes that have arrived in total, and the size of the next block."""
    starts = range(sent, min(len(data), sent + size * SEGMENT), SEGMENT)
    for number, start in enumerate(starts, 1):
        is_last = start + SEGMENT >= len(data)
        sdo.send(bytes((number | is_last << 7,)) + data[start : start + SEGMENT])
    answer = yield from sdo.answer(f"a block of {what}")
    if answer[0] != 0xA2 or answer[1] > len(starts):
        raise Violation(f"{answer.hex(' ')} in the answer to a block of {what}, expected A2h and {len(starts)}")
    return min(len(data), sent + answer[1] * SEGMENT), answer[2]
