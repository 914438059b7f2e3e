"""NMT commands, resets, and reading the node's state.

Source: CiA 301 7.2.8, 7.3.2; CiA 302-2 for a node that starts itself (1F80h).  The state comes from the heartbeat of
the node, or else from its answer to a guarding request.
"""

from enum import IntEnum

from fieldrig.clock import MS
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance.bench import Bench, show
from fieldrig_devices.conformance.line import Matcher, Steps
from fieldrig_devices.conformance.verdict import Failed, NotApplicable, SdoFault

HEARTBEAT_TIME, GUARD_TIME = 0x1017, 0x100C
STARTUP, IS_STARTED_BY_OTHERS = 0x1F80, 0x04
NMT_ID = 0x000
BOOT_UP = b"\x00"


class Command(IntEnum):
    START = 1
    STOP = 2
    ENTER_PRE_OPERATIONAL = 128
    RESET_NODE = 129
    RESET_COMMUNICATION = 130


class State(IntEnum):
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127


COMMAND_FOR = {
    State.OPERATIONAL: Command.START,
    State.STOPPED: Command.STOP,
    State.PRE_OPERATIONAL: Command.ENTER_PRE_OPERATIONAL,
}


def command(bench: Bench, wanted: Command, node_id: int | None = None) -> Steps[None]:
    """Send a command to the node or another address, and wait until the node has acted on it."""
    bench.is_moved = True
    bench.send(NMT_ID, bytes((wanted, bench.node_id if node_id is None else node_id)))
    if wanted in COMMAND_FOR.values():
        yield from bench.settle()


def enter(bench: Bench, state: State) -> Steps[None]:
    yield from command(bench, COMMAND_FOR[state])


def reset(bench: Bench, wanted: Command = Command.RESET_COMMUNICATION, node_id: int | None = None) -> Steps[None]:
    """Reset the node and wait for the boot-up message.  Fails without one."""
    is_there = yield from _reset(bench, wanted, node_id, bench.options.boot_ms)
    name = wanted.name.lower().replace("_", " ")
    bench.check(is_there, f"the boot-up message {bench.boot_up_id:03X}h with one byte 00h after {name}", "none")


def restart(bench: Bench, wanted: Command = Command.RESET_COMMUNICATION) -> Steps[None]:
    """Reset the node as a preparation, after which it is 'pre-operational'.

    A node without a boot-up message, which only the cases that test it report, and a node that was found to start
    itself are taken there by command.  Every other node is left in the state that it has after its boot-up, because a
    command would hide what is wrong with it.
    """
    boot_ms = bench.options.boot_ms if bench.has_boot_up else bench.patience_ms
    bench.has_boot_up = yield from _reset(bench, wanted, None, boot_ms)
    if not bench.has_boot_up or (yield from _has_started_itself(bench)):
        yield from enter(bench, State.PRE_OPERATIONAL)


def _has_started_itself(bench: Bench) -> Steps[bool]:
    """Return True if the node was 'operational' after its boot-up without a command, which 1F80h allows.

    The state that the node reports decides, and 1F80h only for a node that reports none.  It is asked for once for each
    value of 1F80h that the cases leave in the node.
    """
    if STARTUP not in bench.eds:
        return False
    try:
        startup = yield from bench.read(STARTUP)
        if startup not in bench.starts_itself:
            reported = yield from _reported_state(bench)
            may_start = not startup & IS_STARTED_BY_OTHERS
            bench.starts_itself[startup] = may_start if reported is None else reported == State.OPERATIONAL
    except SdoFault:
        return False
    return bench.starts_itself[startup]


def _reported_state(bench: Bench) -> Steps[int | None]:
    """Return the state that the node reports, and leave its parameters as they were; None without a report."""
    try:
        yield from watch(bench)
        reported: int | None = yield from state(bench)
    except (Failed, NotApplicable):
        reported = None
    while bench.undo:
        index, sub, before = bench.undo.pop()
        yield from bench.sdo.write(index, sub, before)
    yield from bench.settle()
    return reported


def _reset(bench: Bench, wanted: Command, node_id: int | None, boot_ms: float) -> Steps[bool]:
    """Reset the node; True if there was a boot-up message.  Its parameters have their power-on values then."""
    yield from command(bench, wanted, node_id)
    bench.undo.clear()
    frame = yield from bench.expect(is_boot_up(bench), boot_ms)
    yield from bench.settle()
    return frame is not None


def is_boot_up(bench: Bench) -> Matcher:
    return lambda frame: frame.identifier == bench.boot_up_id and frame.data == BOOT_UP


def watch(bench: Bench) -> Steps[None]:
    """Make the node report its state, by heartbeat if it has one.  Not applicable if it has no error control."""
    entry = bench.eds.get(HEARTBEAT_TIME)
    if entry is not None and entry.is_writable:
        yield from bench.change(HEARTBEAT_TIME, 0, bench.period_ms)
    elif GUARD_TIME not in bench.eds:
        bench.skip("the node has neither heartbeat nor guarding to report its state")


def state(bench: Bench) -> Steps[int]:
    """Return the state that the node reports; call `watch` before.  Fails without a report."""
    frame: CanFrame | None = None
    if HEARTBEAT_TIME in bench.eds:
        frame = yield from bench.expect(bench.boot_up_id, bench.period_ms + bench.patience_ms)
    if frame is None and GUARD_TIME in bench.eds:
        bench.ask(bench.boot_up_id, 1)
        frame = yield from bench.expect(bench.boot_up_id)
    if frame is None:
        bench.fail("the node's state by heartbeat or guarding", "nothing")
    bench.check(len(frame.data) == 1, "one byte of state", show(frame))
    return frame.data[0] & 0x7F


def states_after_boot(bench: Bench) -> Steps[tuple[State, ...]]:
    """Return the states that the node may report after its boot-up: with bit 2 of 1F80h clear, it may start itself."""
    if STARTUP not in bench.eds:
        return (State.PRE_OPERATIONAL,)
    startup = yield from bench.read(STARTUP)
    is_started_by_others = startup & IS_STARTED_BY_OTHERS
    return (State.PRE_OPERATIONAL,) if is_started_by_others else (State.PRE_OPERATIONAL, State.OPERATIONAL)


def check_state(bench: Bench, wanted: State | tuple[State, ...], after: str) -> Steps[None]:
    """Fail unless the node soon reports this state, or one of these; earlier heartbeats may still be in transit."""
    states = wanted if isinstance(wanted, tuple) else (wanted,)
    until_ns = bench.line.clock.now_ns() + round((2 * bench.period_ms + bench.settle_ms) * MS)
    came = yield from state(bench)
    while came not in states and bench.line.clock.now_ns() < until_ns:
        came = yield from state(bench)
    names = " or ".join(f"{each.name.lower()} ({each:02X}h)" for each in states)
    bench.check(came in states, f"state {names} after {after}", f"{came:02X}h")


def answers_sdo(bench: Bench) -> Steps[bool]:
    try:
        yield from bench.sdo.read(0x1000)
    except SdoFault:
        return False
    return True
