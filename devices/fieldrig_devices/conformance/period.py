"""Checks a period by the mean of several, so that single late frames don't matter.

A node on a busy host is occasionally late, and so is the suite; both result in one or two intervals that are too long
and others that are too short, although the period is right.
"""

from fieldrig.clock import MS
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.line import Seen, Steps

PERIODS, TRIES = 10, 3
TOLERANCE = 0.1


def check_period(bench: Bench, identifier: int, what: str, with_requests: bool = False) -> Steps[list[Seen]]:
    """Fail unless frames have the period `bench.period_ms`; return the frames.

    The mean of ten periods has a tolerance of a tenth plus the delay of the node's answers.  A measurement that a busy
    host has spoiled is repeated, while a wrong period fails all of them.  With requests, we send a remote frame after
    each frame, which the node must not answer.
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
            bench.fail(f"{what} each {bench.period_ms} ms", f"only {len(frames)} of them")
        if with_requests:
            bench.ask(identifier, 1)
    return bench.came(identifier, first)
