"""Whether the node keeps a period: judged by the mean of several, so that frames that come late decide nothing.

A node that runs on a busy host is late now and then, and so is the suite; both show as one or two intervals that are
too long and others that are too short, which is no fault of the period.
"""

from fieldrig.clock import MS
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.line import Seen, Steps

PERIODS, TRIES = 10, 3
TOLERANCE = 0.1


def check_period(bench: Bench, identifier: int, what: str, with_requests: bool = False) -> Steps[list[Seen]]:
    """Fail unless frames come in `bench.period_ms`; those that came.

    The mean of ten periods is right within a tenth, and the time by which the node's answers come late.  What a busy
    host does to one measurement is excused by the next; a wrong period fails all of them.  With requests, each frame
    is followed by a remote frame of ours, which shouldn't be answered.
    """
    start, mean_ms = len(bench.line.seen), 0.0
    for _ in range(TRIES):
        frames = yield from _measure(bench, identifier, what, with_requests)
        mean_ms = (frames[PERIODS].time_ns - frames[0].time_ns) / PERIODS / MS
        if abs(mean_ms - bench.period_ms) <= TOLERANCE * bench.period_ms + bench.sdo.slowest_ms / PERIODS:
            return bench.came(identifier, start)
    bench.fail(f"{what} each {bench.period_ms} ms", f"each {mean_ms:.0f} ms, as the mean of {PERIODS} periods")


def _measure(bench: Bench, identifier: int, what: str, with_requests: bool) -> Steps[list[Seen]]:
    first = len(bench.line.seen)
    for count in range(1, PERIODS + 2):
        frames = yield from bench.gather(identifier, first, count, bench.period_ms)
        if len(frames) < count:
            bench.fail(f"{what} each {bench.period_ms} ms", f"{len(frames)} of them, and then none")
        if with_requests:
            bench.ask(identifier, 1)
    return bench.came(identifier, first)
