"""Heartbeat versus guarding 01 to 07: a node uses one of them at a time, and heartbeat takes precedence.

Source: CiA 301 7.2.8.3.2, 7.5.2.11, 7.5.2.20.
"""

from fieldrig_devices.conformance import guard, nmt
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.guard import LIFE_TIME_FACTOR
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import GUARD_TIME, HEARTBEAT_TIME, State
from fieldrig_devices.conformance.period import check_period

CLAUSE = "CiA 301 7.2.8.3.2"


@case(
    "7.201", "Heartbeat versus guarding 01", "The node has heartbeat or guarding, and its objects can be read.", CLAUSE
)
def has_one(bench: Bench) -> Steps[None]:
    there = [index for index in (HEARTBEAT_TIME, GUARD_TIME, LIFE_TIME_FACTOR) if index in bench.eds]
    bench.check(bool(there), "1017h, or 100Ch and 100Dh, in the EDS", "none of them")
    bench.check((GUARD_TIME in there) == (LIFE_TIME_FACTOR in there), "100Ch and 100Dh together", "one of them")
    for index in there:
        yield from bench.sdo.read(index)


@case(
    "7.202",
    "Heartbeat versus guarding 02",
    "A heartbeat that is switched off stops, and nothing is sent without a request.",
    CLAUSE,
)
def heartbeat_off(bench: Bench) -> Steps[None]:
    yield from _with_both(bench, heartbeat=True, guarding=False)
    yield from bench.change(HEARTBEAT_TIME, 0, 0)
    yield from bench.settle()
    yield from bench.silence(bench.boot_up_id, "heartbeat time 0", 4 * bench.period_ms)


@case("7.203", "Heartbeat versus guarding 03", "Without heartbeat, the node answers guarding requests.", CLAUSE)
def guarding_alone(bench: Bench) -> Steps[None]:
    yield from _with_both(bench, heartbeat=False, guarding=True)
    first = yield from guard.request(bench)
    second = yield from guard.request(bench)
    is_right = first & 0x7F == State.PRE_OPERATIONAL and first ^ second == 0x80
    bench.check(is_right, "7Fh and FFh, in either order", f"{first:02X}h and {second:02X}h")


@case("7.204", "Heartbeat versus guarding 04", "Without guarding, the heartbeat has its period.", CLAUSE)
def heartbeat_alone(bench: Bench) -> Steps[None]:
    yield from _with_both(bench, heartbeat=True, guarding=False)
    yield from _check_beats(bench)


@case(
    "7.205",
    "Heartbeat versus guarding 05",
    "With heartbeat and no guarding, guarding requests are not answered.",
    CLAUSE,
)
def requests_without_guarding(bench: Bench) -> Steps[None]:
    yield from _with_both(bench, heartbeat=True, guarding=False)
    yield from _check_beats(bench, with_requests=True)


@case("7.206", "Heartbeat versus guarding 06", "With both enabled, the heartbeat has its period.", CLAUSE)
def both(bench: Bench) -> Steps[None]:
    yield from _with_both(bench, heartbeat=True, guarding=True)
    yield from _check_beats(bench)


@case("7.207", "Heartbeat versus guarding 07", "With both enabled, guarding requests are not answered.", CLAUSE)
def requests_with_both(bench: Bench) -> Steps[None]:
    yield from _with_both(bench, heartbeat=True, guarding=True)
    yield from _check_beats(bench, with_requests=True)


def _with_both(bench: Bench, heartbeat: bool, guarding: bool) -> Steps[None]:
    """Enable or disable heartbeat and guarding.  Not applicable unless the EDS has both."""
    guard.check_there(bench)
    bench.entry(HEARTBEAT_TIME, writable=True)
    yield from nmt.restart(bench)
    yield from bench.change(HEARTBEAT_TIME, 0, 0)
    yield from bench.change(GUARD_TIME, 0, 1000 if guarding else 0)
    yield from bench.change(LIFE_TIME_FACTOR, 0, 10 if guarding else 0)
    if heartbeat:
        yield from bench.change(HEARTBEAT_TIME, 0, bench.period_ms)
    yield from bench.settle()


def _check_beats(bench: Bench, with_requests: bool = False) -> Steps[None]:
    """Check the period of the heartbeat, that its toggle bit is 0, and that our requests aren't answered."""
    frames = yield from check_period(bench, bench.boot_up_id, "a heartbeat, and nothing else,", with_requests)
    states = {seen.frame.data for seen in frames}
    right = bytes((State.PRE_OPERATIONAL,))
    bench.check(
        states == {right}, "7Fh in each, without toggle bit", ", ".join(sorted(state.hex() for state in states))
    )
