"""Errors that the suite can cause from outside, and the EMCY messages that report them.

Source: CiA 301 7.2.7, 7.2.2.5 (an RPDO that is too short), 7.2.8.3.2.2 (a missing heartbeat).
"""

from typing import NamedTuple

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance import nmt
from fieldrig_devices.conformance.bench import ERROR_CONTROL, Bench, show
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import State
from fieldrig_devices.conformance.pdo import INVALID, Pdo, identifier, pdos, read_mapping, size

CONSUMER_TIME, COB_ID = 0x1016, 0x1014
PDO_LENGTH, HEARTBEAT = 0x8210, 0x8130
EMCY_SIZE = 8
OPERATIONAL_STATE = b"\x05"


class Forced(NamedTuple):
    frame: CanFrame | None
    """The EMCY message; None if the node sent none."""
    code: int
    """The expected error code."""
    how: str


def emcy_id(bench: Bench) -> Steps[int]:
    bench.entry(COB_ID)
    cob_id = yield from bench.read(COB_ID)
    if cob_id & INVALID:
        bench.skip("EMCY is switched off by bit 31 of 1014h")
    return identifier(cob_id)


def force(bench: Bench) -> Steps[Forced]:
    """Cause an error in 'operational'.  Not applicable if the node of this EDS gives no means to do so."""
    emcy = yield from emcy_id(bench)
    bench.is_upset = True
    for pdo in pdos(bench, is_transmit=False):
        forced = yield from _by_short_pdo(bench, emcy, pdo)
        if forced is not None:
            return forced
    entry = bench.eds.get(CONSUMER_TIME, 1)
    if entry is not None and entry.is_writable:
        return (yield from _by_missing_heartbeat(bench, emcy))
    bench.skip("no error can be caused from outside: the EDS has neither an RPDO nor a heartbeat consumer")


def latest(bench: Bench) -> Steps[CanFrame]:
    """Return the last EMCY message of this case.  Fails without one of eight bytes with the identifier of 1014h."""
    emcy = yield from emcy_id(bench)
    frames = [seen.frame for seen in bench.line.seen if not seen.is_ours and seen.frame.identifier == emcy]
    if not frames:
        bench.fail(f"an EMCY message with the identifier {emcy:X}h of 1014h", "none")
    bench.check(len(frames[-1].data) == EMCY_SIZE, "8 bytes of EMCY", show(frames[-1]))
    return frames[-1]


def producer_id(bench: Bench) -> int:
    """Return the node-ID that the suite uses for its own heartbeat."""
    return 127 if bench.node_id != 127 else 126


def watch_us(bench: Bench, consumer_ms: int, producer: int) -> Steps[None]:
    """Let the node supervise our heartbeat, with the first entry of 1016h; other entries stay as they are."""
    yield from bench.change(CONSUMER_TIME, 1, producer << 16 | consumer_ms)


def beat(bench: Bench, producer: int, count: int, gap_ms: float) -> Steps[None]:
    for _ in range(count):
        bench.send(ERROR_CONTROL + producer, OPERATIONAL_STATE)
        yield from bench.wait(gap_ms)


def _by_short_pdo(bench: Bench, emcy: int, pdo: Pdo) -> Steps[Forced | None]:
    """Send an RPDO without data; None if this RPDO isn't suitable."""
    cob_id = yield from bench.read(pdo.communication, 1)
    mapped = yield from read_mapping(bench, pdo)
    kind = yield from bench.read(pdo.communication, 2)
    if cob_id & INVALID or size(mapped) == 0 or kind < 254:
        return None
    yield from nmt.enter(bench, State.OPERATIONAL)
    bench.send(identifier(cob_id))
    frame = yield from bench.expect(emcy)
    return Forced(frame, PDO_LENGTH, f"{pdo.name} without data")


def _by_missing_heartbeat(bench: Bench, emcy: int) -> Steps[Forced]:
    producer = producer_id(bench)
    yield from watch_us(bench, 2 * bench.period_ms, producer)
    yield from nmt.enter(bench, State.OPERATIONAL)
    bench.send(ERROR_CONTROL + producer, OPERATIONAL_STATE)
    frame = yield from bench.expect(emcy, 2 * bench.period_ms + bench.patience_ms)
    return Forced(frame, HEARTBEAT, "a heartbeat that stopped")
