"""Transition 01 to 04: each NMT command from each state.

Source: CiA 301 7.2.8.2.1, 7.3.2.1 (figure: NMT state diagram); CiA 302-2 for a node that starts itself.
"""

from collections.abc import Iterator

from fieldrig_devices.conformance import nmt
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import COMMAND_FOR, Command, State

CLAUSE = "CiA 301 7.2.8.2.1, 7.3.2.1"
ALL_NODES = 0


@case(
    "10.1",
    "Transition 01",
    "'Reset node' and 'reset communication' lead from each state to 'pre-operational', with a boot-up message.",
    CLAUSE,
)
def resets(bench: Bench) -> Steps[None]:
    for address in _addresses(bench):
        for command in (Command.RESET_NODE, Command.RESET_COMMUNICATION):
            for state in State:
                yield from nmt.enter(bench, state)
                yield from nmt.reset(bench, command, address)
                states = yield from nmt.states_after_boot(bench)
                yield from nmt.watch(bench)
                yield from nmt.check_state(bench, states, _name(command))


@case("10.2", "Transition 02", "'Enter pre-operational' leads from each state to 'pre-operational'.", CLAUSE)
def to_pre_operational(bench: Bench) -> Steps[None]:
    yield from _from_each_state(bench, State.PRE_OPERATIONAL)


@case("10.3", "Transition 03", "'Start remote node' leads from each state to 'operational'.", CLAUSE)
def to_operational(bench: Bench) -> Steps[None]:
    yield from _from_each_state(bench, State.OPERATIONAL)


@case("10.4", "Transition 04", "'Stop remote node' leads from each state to 'stopped'.", CLAUSE)
def to_stopped(bench: Bench) -> Steps[None]:
    yield from _from_each_state(bench, State.STOPPED)


def _from_each_state(bench: Bench, wanted: State) -> Steps[None]:
    """Check the command from each state, and that a command for another node has no effect."""
    command = COMMAND_FOR[wanted]
    yield from nmt.watch(bench)
    for address in _addresses(bench):
        for state in State:
            yield from nmt.enter(bench, state)
            yield from nmt.command(bench, Command.STOP if state is not State.STOPPED else Command.START, _other(bench))
            yield from nmt.check_state(bench, state, "a command for another node")
            yield from nmt.command(bench, command, address)
            yield from nmt.check_state(bench, wanted, f"{_name(command)} in {state.name.lower()}")


def _addresses(bench: Bench) -> Iterator[int]:
    """Yield the address of the node and, if it is alone on the bus, that of all nodes."""
    yield bench.node_id
    if bench.options.is_alone:
        yield ALL_NODES


def _other(bench: Bench) -> int:
    """Return a node-ID that is most likely unused."""
    return 126 if bench.node_id != 126 else 125


def _name(command: Command) -> str:
    return command.name.lower().replace("_", " ")
