"""State machines: those of the code's tables, and the enable chain of an MC-4 as a walk through it finds it."""

from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from typing import Final

from tests.pictures.enable_walk import steps
from tests.pictures.states import states

from fieldrig_devices.arp.card.states import NEXT_STATE, Event
from fieldrig_devices.arp.card_access import CardState
from fieldrig_devices.drive_profile.states import ENDS, TRANSITIONS, Command, State
from fieldrig_devices.max4.axes.axis import AxisState
from fieldrig_devices.mc4.enable import TASKS, Stage, Task

Transition = tuple[str, str, str]
ANY: Final = "any state"
ANY_STAGE: Final = "any stage"
WITH_TORQUE: Final = "stages with torque"
FOLLOWING: Final = {stage for stage, task in TASKS.items() if task in (Task.FOLLOW, Task.HOLD)}
"""Stages in which the motor has torque and does not yet stop."""
EVENTS: Final = {
    Event.OPENED: "Enable opens",
    Event.CLOSED: "Enable closes",
    Event.RESET: "reset",
    Event.STARTED: "run",
    Event.STOPPED: "stop",
    Event.ENDED: "END",
    Event.FAILED: "blocking error",
}
COMMANDS: Final = {
    Command.SHUTDOWN: "shutdown",
    Command.SWITCH_ON: "switch on",
    Command.ENABLE_OPERATION: "enable operation",
    Command.DISABLE_VOLTAGE: "disable voltage",
    Command.QUICK_STOP: "quick stop",
}


def named(state: Enum) -> str:
    return state.name.lower().replace("_", " ")


def arp_states() -> str:
    places: Mapping[str, tuple[float, float]] = {
        ANY: (0, 1),
        "reset_enable": (1.1, 0),
        "blocked": (1.1, 2),
        "init": (2.2, 0),
        "run": (2.2, 1),
        "reset_command": (2.2, 2),
        "stopped": (3.5, 1),
    }
    about = "Six states of the card; Enable opening and blocking errors lead out of every state, and run is the middle."
    return states(places, _card_transitions(), "States of the ARP card", about)


def _card_transitions() -> Iterator[Transition]:
    """The transitions of the card; one that leaves every other state comes from `any state`."""
    for (state, event), target in NEXT_STATE.items():
        others = [other for other in CardState if other is not target]
        is_common = all(NEXT_STATE.get((other, event)) is target for other in others)
        yield ANY if is_common else state.name.lower(), target.name.lower(), EVENTS[event]


def cia402_states() -> str:
    places: Mapping[str, tuple[float, float]] = {
        named(State.NOT_READY_TO_SWITCH_ON): (0, 0),
        named(State.SWITCH_ON_DISABLED): (1.5, 0),
        named(State.FAULT): (0, 1.3),
        named(State.FAULT_REACTION_ACTIVE): (0, 2.6),
        ANY: (0, 3.9),
        named(State.READY_TO_SWITCH_ON): (2.15, 2.0),
        named(State.SWITCHED_ON): (1.05, 3.9),
        named(State.OPERATION_ENABLED): (4.3, 3.9),
        named(State.QUICK_STOP_ACTIVE): (4.6, 1.5),
    }
    about = (
        "Eight states; numbers are those of the transitions in CiA 402-2, words those of the control word's commands."
    )
    return states(places, _power_transitions(), "Power drive state machine of CiA 402", about)


def _power_transitions() -> Iterator[Transition]:
    """The transitions that a command causes, and those that the drive makes by itself: 0, 1, 13, 14 and 15."""
    commands: dict[tuple[State, int], list[str]] = {}
    for (state, command), number in TRANSITIONS.items():
        commands.setdefault((state, number), []).append(COMMANDS[command])
    for (state, number), words in commands.items():
        yield named(state), named(ENDS[number]), f"{number} {' or '.join(words)}"
    yield named(State.NOT_READY_TO_SWITCH_ON), named(ENDS[1]), "1"
    yield ANY, named(ENDS[13]), "13 error"
    yield named(State.FAULT_REACTION_ACTIVE), named(ENDS[14]), "14"
    yield named(State.FAULT), named(ENDS[15]), "15 fault reset"


def enable_chain() -> str:
    places: Mapping[str, tuple[float, float]] = {
        named(Stage.NO_HARDWARE_ENABLE): (0, 0),
        named(Stage.WAITING): (1.6, 0),
        named(Stage.LIFTING): (3.0, 0),
        named(Stage.CONTROLLED): (4.3, 0),
        named(Stage.OVERLOAD_STOP): (3.2, 1.2),
        named(Stage.OVERLOAD_HELD): (4.6, 1.2),
        WITH_TORQUE: (4.6, 2.4),
        named(Stage.RAMPING): (3.3, 2.4),
        named(Stage.COUPLING): (2.0, 2.4),
        named(Stage.STOPPED): (0.7, 2.4),
        named(Stage.COASTING): (0.7, 3.6),
        ANY_STAGE: (2.0, 3.6),
    }
    about = "Inverter Enable and ControllerEnable lead from left to right; a missing enable and errors lead back."
    return states(places, _enable_transitions(named), "Enable chain of an MC-4", about)


def axis_states() -> str:
    places: Mapping[str, tuple[float, float]] = {
        _axis_state(Stage.NO_HARDWARE_ENABLE): (0, 0),
        _axis_state(Stage.WAITING): (1.6, 0),
        _axis_state(Stage.LIFTING): (3.0, 0),
        _axis_state(Stage.CONTROLLED): (4.6, 0),
        _axis_state(Stage.STOPPED): (1.0, 2.2),
        _axis_state(Stage.RAMPING): (3.1, 2.2),
        WITH_TORQUE: (4.6, 2.2),
        ANY_STAGE: (3.1, 3.3),
    }
    about = "AxisState 0 to 3 lead to an axis under control; errors and missing enables lead to stopping and error."
    return states(places, _enable_transitions(_axis_state), "AxisState of an axis", about)


def _axis_state(stage: Stage) -> str:
    state = AxisState(stage.value[0])
    return f"{state.value} {named(state)}"


def _enable_transitions(name_of: Callable[[Stage], str]) -> Iterator[Transition]:
    """The steps of the chain; what all stages, or all with torque, have in common is drawn once."""
    found = list(steps())
    for step in found:
        sources = {other.source for other in found if other[1:] == step[1:]}
        source = name_of(step.source)
        if sources >= set(Stage) - {step.target, Stage.STOPPED}:
            source = ANY_STAGE
        elif sources >= FOLLOWING:
            source = WITH_TORQUE
        if name_of(step.source) != name_of(step.target):
            yield source, name_of(step.target), step.stimulus


PICTURES: Final[Mapping[str, Callable[[], str]]] = {
    "arp-states": arp_states,
    "cia402-states": cia402_states,
    "max4-axis-states": axis_states,
    "mc4-enable": enable_chain,
}
