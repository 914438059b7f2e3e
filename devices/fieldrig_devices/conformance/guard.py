"""Node guarding from the master's side.

Source: CiA 301 7.2.8.3.2.1.
"""

from fieldrig_devices.conformance import nmt
from fieldrig_devices.conformance.bench import Bench, show
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import GUARD_TIME, HEARTBEAT_TIME

LIFE_TIME_FACTOR = 0x100D


def check_there(bench: Bench) -> None:
    """Make the case not applicable if the EDS has no guarding."""
    bench.entry(GUARD_TIME)
    bench.entry(LIFE_TIME_FACTOR)


def prepare(bench: Bench) -> Steps[None]:
    """Reset the node and switch off its heartbeat, which would take precedence over guarding."""
    check_there(bench)
    yield from nmt.restart(bench)
    if HEARTBEAT_TIME in bench.eds:
        yield from bench.change(HEARTBEAT_TIME, 0, 0)


def request(bench: Bench) -> Steps[int]:
    """Send a request, and return the byte of the answer.  Fails without an answer."""
    bench.ask(bench.boot_up_id, 1)
    frame = yield from bench.expect(bench.boot_up_id)
    if frame is None:
        bench.fail("an answer to a guarding request", "none")
    bench.check(len(frame.data) == 1, "one byte in the answer to a guarding request", show(frame))
    return frame.data[0]
