"""State 01 to 04: the behaviour of the node in each NMT state.

Source: CiA 301 7.2.8.3, 7.3.2 (states, and the services that they allow).
"""

from fieldrig_devices.conformance import nmt, sync
from fieldrig_devices.conformance.bench import Bench, show
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import HEARTBEAT_TIME, State
from fieldrig_devices.conformance.pdo import configure, usable_tpdos
from fieldrig_devices.conformance.verdict import NotApplicable

ALLOWED = "CiA 301 7.3.2.2"


@case(
    "9.1",
    "State 01",
    "A reset of communication sets parameters to their power-on values and ends with one boot-up message.",
    "CiA 301 7.2.8.3.3, 7.3.2.2",
)
def initialisation(bench: Bench) -> Steps[None]:
    power_on: int | None = None
    entry = bench.eds.get(HEARTBEAT_TIME)
    yield from nmt.restart(bench)
    if entry is not None and entry.is_writable:
        power_on = yield from bench.read(HEARTBEAT_TIME)
        yield from bench.change(HEARTBEAT_TIME, 0, power_on + 5000)
    first = len(bench.line.seen)
    yield from nmt.reset(bench)
    yield from bench.wait(max(bench.period_ms, bench.settle_ms))
    is_boot_up = nmt.is_boot_up(bench)
    count = sum(1 for seen in bench.line.seen[first:] if not seen.is_ours and is_boot_up(seen.frame))
    bench.check(count == 1, "one boot-up message", str(count))
    if power_on is not None:
        came = yield from bench.read(HEARTBEAT_TIME)
        bench.check(came == power_on, f"{power_on} in 1017h:00h, as at power-on", str(came))


@case("9.2", "State 02", "After the boot-up the node is 'pre-operational': SDO works, PDOs don't.", ALLOWED)
def pre_operational(bench: Bench) -> Steps[None]:
    yield from nmt.reset(bench)
    yield from _check_services(bench, State.PRE_OPERATIONAL, sdo=True, pdo=False)


@case("9.3", "State 03", "In 'operational' SDO and PDOs work.", ALLOWED)
def operational(bench: Bench) -> Steps[None]:
    yield from _check_services(bench, State.OPERATIONAL, sdo=True, pdo=True)


@case("9.4", "State 04", "In 'stopped' neither SDO nor PDOs work, but error control and NMT do.", ALLOWED)
def stopped(bench: Bench) -> Steps[None]:
    yield from _check_services(bench, State.STOPPED, sdo=False, pdo=False)
    yield from nmt.enter(bench, State.PRE_OPERATIONAL)
    is_back = yield from nmt.answers_sdo(bench)
    bench.check(is_back, "SDO to work again in 'pre-operational'", "no answer")


def _check_services(bench: Bench, state: State, sdo: bool, pdo: bool) -> Steps[None]:
    name = state.name.lower().replace("_", "-")
    identifier = yield from _sync_driven_tpdo(bench)
    yield from nmt.watch(bench)
    yield from nmt.enter(bench, state)
    yield from nmt.check_state(bench, state, f"the command for {name}")
    if identifier is not None:
        came = yield from _answers_sync(bench, identifier, is_expected=pdo)
        bench.check(came == pdo, f"{'a' if pdo else 'no'} TPDO at SYNC in '{name}'", "one" if came else "none")
    answers = yield from _answers_sdo_at_all(bench)
    bench.check(answers == sdo, f"{'an' if sdo else 'no'} SDO answer in '{name}'", "one" if answers else "none")


def _sync_driven_tpdo(bench: Bench) -> Steps[int | None]:
    """Configure a TPDO of type 1, and return its identifier; None if the node doesn't support it."""
    try:
        pdo = (yield from usable_tpdos(bench))[0]
        yield from sync.consume(bench)
        return (yield from configure(bench, pdo, 1))
    except NotApplicable:
        return None


def _answers_sync(bench: Bench, identifier: int, is_expected: bool) -> Steps[bool]:
    cob_id = bench.eds.get(sync.COB_ID)
    default = 0x80 if cob_id is None or cob_id.default is None else int.from_bytes(cob_id.default, "little")
    bench.send(default & 0x7FF)
    within_ms = None if is_expected else max(3 * sync.GAP_MS, bench.settle_ms)
    return (yield from bench.expect(identifier, within_ms)) is not None


def _answers_sdo_at_all(bench: Bench) -> Steps[bool]:
    """Return True if there is any SDO answer, even an abort."""
    bench.sdo.send(b"\x40\x00\x10\x00")
    frame = yield from bench.expect(bench.sdo.response_id)
    if frame is not None:
        bench.check(len(frame.data) == 8, "8 bytes of SDO", show(frame))
    return frame is not None
