"""Heartbeat 01 to 07: the node's own heartbeat, and its supervision of ours.

Source: CiA 301 7.2.8.3.2.2, 7.5.2.19 (1016h), 7.5.2.20 (1017h).
"""

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance import errors, nmt
from fieldrig_devices.conformance.bench import Bench, show
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.errors import CONSUMER_TIME, HEARTBEAT
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import HEARTBEAT_TIME, Command, State
from fieldrig_devices.conformance.period import check_period

PRODUCER, CONSUMER = "CiA 301 7.2.8.3.2.2, 7.5.2.20", "CiA 301 7.2.8.3.2.2, 7.5.2.19"
INCOMPATIBLE = 0x0604_0043
CONSUMER_PERIODS = (3, 4, 5)
"""Consumer times to test, in periods of our heartbeat."""


@case("7.101", "Heartbeat 01", "The heartbeat time can be written.", "CiA 301 7.5.2.20")
def write_time(bench: Bench) -> Steps[None]:
    bench.entry(HEARTBEAT_TIME, writable=True)
    yield from bench.change(HEARTBEAT_TIME, 0, 2 * bench.period_ms)
    came = yield from bench.read(HEARTBEAT_TIME)
    bench.check(came == 2 * bench.period_ms, f"{2 * bench.period_ms} in 1017h:00h", str(came))


@case("7.102", "Heartbeat 02", "The heartbeat has the period of 1017h and carries the state of the node.", PRODUCER)
def count_beats(bench: Bench) -> Steps[None]:
    bench.entry(HEARTBEAT_TIME, writable=True)
    yield from bench.change(HEARTBEAT_TIME, 0, bench.period_ms)
    for seen in (yield from check_period(bench, bench.boot_up_id, "a heartbeat")):
        is_right = seen.frame.data == bytes((State.PRE_OPERATIONAL,))
        bench.check(is_right, "one byte 7Fh (pre-operational)", show(seen.frame))


@case("7.103", "Heartbeat 03", "With a heartbeat time of 0 there is no heartbeat.", PRODUCER)
def disable(bench: Bench) -> Steps[None]:
    bench.entry(HEARTBEAT_TIME, writable=True)
    yield from bench.change(HEARTBEAT_TIME, 0, bench.period_ms)
    yield from bench.wait(2 * bench.period_ms)
    yield from bench.change(HEARTBEAT_TIME, 0, 0)
    yield from bench.settle()
    yield from bench.silence(bench.boot_up_id, "heartbeat time 0", 4 * bench.period_ms)


@case("7.104", "Heartbeat 04", "Two entries of 1016h cannot supervise the same node.", "CiA 301 7.5.2.19")
def same_node_twice(bench: Bench) -> Steps[None]:
    bench.entry(CONSUMER_TIME, 1, writable=True)
    bench.entry(CONSUMER_TIME, 2, writable=True)
    value = errors.producer_id(bench) << 16 | 1000
    yield from bench.change(CONSUMER_TIME, 1, value)
    attempt = bench.change(CONSUMER_TIME, 2, value)
    yield from bench.refuses(attempt, INCOMPATIBLE, what="the node of 1016h:01h in 1016h:02h")


@case("7.105", "Heartbeat 05", "While heartbeats arrive in time, the node reports no error.", CONSUMER)
def in_time(bench: Bench) -> Steps[None]:
    """Try up to three consumer times, so that the delays of a busy host don't fail the case."""
    frames: list[CanFrame] = []
    for periods in CONSUMER_PERIODS:
        producer = yield from _watched(bench, periods)
        frames = yield from _errors_while_beating(bench, producer, 10, bench.period_ms)
        if not frames:
            break
        bench.is_upset = True
    bench.check(not frames, "no EMCY while heartbeats arrive in time", lambda: show(frames[0]))
    yield from nmt.check_state(bench, State.OPERATIONAL, "heartbeats in time")


@case(
    "7.106",
    "Heartbeat 06",
    "When a heartbeat exceeds the consumer time, the node sends EMCY 8130h or leaves 'operational'.",
    f"{CONSUMER}, 7.5.2.32",
)
def too_late(bench: Bench) -> Steps[None]:
    producer = yield from _watched(bench)
    bench.is_upset = True
    emcy = (yield from errors.emcy_id(bench)) if errors.COB_ID in bench.eds else None
    frames = yield from _errors_while_beating(bench, producer, 1, 6 * bench.period_ms)
    late = (yield from bench.expect(emcy)) if emcy is not None and not frames else None
    frames += [] if late is None else [late]
    codes = [int.from_bytes(frame.data[:2], "little") for frame in frames]
    if errors.COB_ID in bench.eds:
        bench.check(HEARTBEAT in codes, "EMCY 8130h after the consumer time", f"{codes[0]:04X}h" if codes else "none")
    else:
        yield from nmt.check_state(bench, State.PRE_OPERATIONAL, "a heartbeat that stopped")


@case("7.107", "Heartbeat 07", "After a reset, supervision starts with the first heartbeat, not before.", CONSUMER)
def after_reset(bench: Bench) -> Steps[None]:
    producer = yield from _watched(bench)
    yield from errors.beat(bench, producer, 2, bench.period_ms)
    yield from nmt.restart(bench, Command.RESET_NODE)
    yield from nmt.watch(bench)
    yield from errors.watch_us(bench, 3 * bench.period_ms, producer)
    yield from nmt.enter(bench, State.OPERATIONAL)
    frames = yield from _errors_while_beating(bench, producer, 0, 6 * bench.period_ms)
    bench.check(not frames, "no EMCY before the first heartbeat", lambda: show(frames[0]))
    yield from nmt.check_state(bench, State.OPERATIONAL, "no heartbeat of the producer at all")


def _watched(bench: Bench, periods: int = CONSUMER_PERIODS[0]) -> Steps[int]:
    """Make the node operational, supervising us with a consumer time of `periods`; return the node-ID that we use."""
    bench.entry(CONSUMER_TIME, 1, writable=True)
    producer = errors.producer_id(bench)
    yield from nmt.watch(bench)
    yield from errors.watch_us(bench, periods * bench.period_ms, producer)
    yield from nmt.enter(bench, State.OPERATIONAL)
    return producer


def _errors_while_beating(bench: Bench, producer: int, count: int, gap_ms: float) -> Steps[list[CanFrame]]:
    """Return the EMCY messages while we send `count` heartbeats, or are silent for `gap_ms` if `count` is 0."""
    emcy = (yield from errors.emcy_id(bench)) if errors.COB_ID in bench.eds else None
    first = len(bench.line.seen)
    yield from errors.beat(bench, producer, count, gap_ms)
    if count == 0:
        yield from bench.wait(gap_ms)
    return [seen.frame for seen in bench.line.seen[first:] if not seen.is_ours and seen.frame.identifier == emcy]
