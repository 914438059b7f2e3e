"""Guarding 01 to 06: node guarding and life guarding.

Source: CiA 301 7.2.8.3.2.1, 7.5.2.11 (100Ch), 7.5.2.12 (100Dh).
"""

from fieldrig.clock import MS
from fieldrig_devices.conformance import guard, nmt
from fieldrig_devices.conformance.bench import ERROR_CONTROL, Bench, show
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.errors import COB_ID, HEARTBEAT, emcy_id
from fieldrig_devices.conformance.guard import LIFE_TIME_FACTOR
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import GUARD_TIME, State

CLAUSE = "CiA 301 7.2.8.3.2.1"
ERROR_BEHAVIOUR = 0x1029
NO_CHANGE, STOP = 1, 2
FACTOR = 3
"""Life time factor, large enough for late requests and answers."""


@case("7.1", "Guarding 01", "Guard time and life time factor can be read.", "CiA 301 7.5.2.11, 7.5.2.12")
def read_objects(bench: Bench) -> Steps[None]:
    guard.check_there(bench)
    for index, size in ((GUARD_TIME, 2), (LIFE_TIME_FACTOR, 1)):
        data = yield from bench.sdo.read(index)
        bench.check(len(data) == size, f"{size} bytes in {index:04X}h:00h", data.hex(" "))


@case("7.2", "Guarding 02", "A guarding request is answered with the state; the first toggle bit is 0.", CLAUSE)
def answer(bench: Bench) -> Steps[None]:
    yield from guard.prepare(bench)
    data = yield from guard.request(bench)
    bench.check(data == State.PRE_OPERATIONAL, "7Fh: toggle bit 0, pre-operational", f"{data:02X}h")


@case("7.3", "Guarding 03", "The toggle bit alternates from answer to answer.", CLAUSE)
def toggle(bench: Bench) -> Steps[None]:
    yield from guard.prepare(bench)
    came = ""
    for _ in range(6):
        came += str((yield from guard.request(bench)) >> 7)
    bench.check(came == "010101", "toggle bits 010101", came)


@case("7.4", "Guarding 04", "Guarding requests for other nodes are not answered.", CLAUSE)
def other_nodes(bench: Bench) -> Steps[None]:
    yield from guard.prepare(bench)
    first = len(bench.line.seen)
    for node_id in range(1, 128):
        if node_id != bench.node_id:
            bench.ask(ERROR_CONTROL + node_id, 1)
            yield from bench.wait(2)
    yield from bench.wait(max(bench.period_ms, bench.settle_ms))
    ours = bench.came(bench.boot_up_id, first)
    bench.check(not ours, "no answer to guarding requests for other nodes", lambda: show(ours[0].frame))


@case("7.5", "Guarding 05", "Guard time and life time factor can be written.", "CiA 301 7.5.2.11, 7.5.2.12")
def write_objects(bench: Bench) -> Steps[None]:
    guard.check_there(bench)
    for index, value in ((GUARD_TIME, 500), (LIFE_TIME_FACTOR, 3)):
        bench.entry(index, writable=True)
        yield from bench.change(index, 0, value)
        came = yield from bench.read(index)
        bench.check(came == value, f"{value} in {index:04X}h:00h", str(came))


@case(
    "7.6",
    "Guarding 06",
    "When guarding requests stop, the node sends EMCY 8130h or leaves 'operational' after its life time.",
    f"{CLAUSE}; CiA 301 7.5.2.32",
)
def life_guarding(bench: Bench) -> Steps[None]:
    yield from guard.prepare(bench)
    bench.is_upset = True
    emcy = (yield from emcy_id(bench)) if COB_ID in bench.eds else None
    yield from bench.change(GUARD_TIME, 0, bench.period_ms)
    yield from bench.change(LIFE_TIME_FACTOR, 0, FACTOR)
    yield from nmt.enter(bench, State.OPERATIONAL)
    first = len(bench.line.seen)
    for _ in range(4):
        due_ns = bench.line.clock.now_ns() + bench.period_ms * MS
        yield from guard.request(bench)
        yield from bench.wait(max(0, due_ns - bench.line.clock.now_ns()) / MS)
        early = [] if emcy is None else bench.came(emcy, first)
        bench.check(not early, "no error while guarding goes on", show(early[0].frame) if early else "")
    frame = None if emcy is None else (yield from bench.expect(emcy, FACTOR * bench.period_ms + bench.patience_ms))
    if frame is not None:
        code = int.from_bytes(frame.data[:2], "little")
        bench.check(code == HEARTBEAT, "EMCY 8130h after the life time", f"{code:04X}h")
    elif emcy is not None:
        bench.fail("EMCY 8130h after the life time", "none")
    if emcy is None:
        yield from bench.wait((FACTOR + 1) * bench.period_ms + bench.settle_ms)
    behaviour = (yield from bench.read(ERROR_BEHAVIOUR, 1)) if bench.eds.get(ERROR_BEHAVIOUR, 1) else 0
    if behaviour not in (NO_CHANGE, STOP):
        came = (yield from guard.request(bench)) & 0x7F
        bench.check(came == State.PRE_OPERATIONAL, "state 7Fh after a life guarding event (1029h)", f"{came:02X}h")
