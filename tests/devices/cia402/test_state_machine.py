"""The tables of CiA 402-2 / IEC 61800-7-201, walked over."""

from collections.abc import Callable
from dataclasses import dataclass, field

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.cia402.behaviour import Behaviour
from fieldrig_devices.cia402.options import Options, Ramp
from fieldrig_devices.cia402.state_machine import StateMachine
from fieldrig_devices.drive_profile.states import Command, State, command_of

NOT_READY, DISABLED, READY, ON = (
    State.NOT_READY_TO_SWITCH_ON,
    State.SWITCH_ON_DISABLED,
    State.READY_TO_SWITCH_ON,
    State.SWITCHED_ON,
)
ENABLED, QUICK_STOP, REACTION, FAULT = (
    State.OPERATION_ENABLED,
    State.QUICK_STOP_ACTIVE,
    State.FAULT_REACTION_ACTIVE,
    State.FAULT,
)
SHUTDOWN, SWITCH_ON, ENABLE, NO_VOLTAGE, STOP, RESET = 0x06, 0x07, 0x0F, 0x00, 0x02, 0x80
WAYS = {
    DISABLED: (),
    READY: (SHUTDOWN,),
    ON: (SHUTDOWN, SWITCH_ON),
    ENABLED: (SHUTDOWN, SWITCH_ON, ENABLE),
    QUICK_STOP: (SHUTDOWN, SWITCH_ON, ENABLE, STOP),
}


@dataclass
class FakeDrive:
    """A drive that follows commands immediately, and is at rest when `is_at_rest` is set."""

    is_there: bool = True
    is_ready: bool = True
    is_following: bool = False
    is_moving_by_itself: bool = False
    is_at_rest: bool = False
    errors: tuple[int, ...] = ()
    options: Options = field(default_factory=lambda: Options(quick_stop=6))
    lifts_at_once: bool = True
    done: list[object] = field(default_factory=list)

    def enable(self) -> None:
        self.done.append("enable")
        self.is_following = self.lifts_at_once

    def disable(self) -> None:
        self.done.append("disable")
        self.is_following = False

    def brake(self, ramp: Ramp) -> None:
        self.done.append(ramp)
        self.is_at_rest = False

    def go_on(self) -> None:
        self.done.append("go on")

    def reset_fault(self, done: Callable[[], None]) -> None:
        self.done.append("reset")
        done()


def machine_in(state: State, drive: FakeDrive) -> StateMachine:
    machine = StateMachine(drive)
    machine.start()
    machine.step()
    for word in WAYS[state]:
        machine.control(word)
    assert machine.state is state
    drive.done.clear()
    return machine


@pytest.mark.parametrize(
    ("state", "bits", "mask"),
    [
        (NOT_READY, 0x00, 0x4F),
        (DISABLED, 0x40, 0x4F),
        (READY, 0x21, 0x6F),
        (ON, 0x23, 0x6F),
        (ENABLED, 0x27, 0x6F),
        (QUICK_STOP, 0x07, 0x6F),
        (REACTION, 0x0F, 0x4F),
        (FAULT, 0x08, 0x4F),
    ],
)
def test_each_state_has_the_status_word_of_the_table(state: State, bits: int, mask: int) -> None:
    assert state.value & mask == bits


# Table 'command coding'.
@pytest.mark.parametrize(
    ("words", "command"),
    [
        ((0x0006, 0x000E, 0xFF5E), Command.SHUTDOWN),
        ((0x0007, 0x0037), Command.SWITCH_ON),
        ((0x000F, 0x001F, 0x017F), Command.ENABLE_OPERATION),
        ((0x0000, 0x0001, 0x000D, 0x000C, 0x0005), Command.DISABLE_VOLTAGE),
        ((0x0002, 0x0003, 0x000A, 0x000B), Command.QUICK_STOP),
        ((0x0080, 0x0087, 0x008F), None),
    ],
)
def test_the_bits_of_the_control_word_name_a_command(words: tuple[int, ...], command: Command | None) -> None:
    assert {command_of(word) for word in words} == {command}


# Table 'transitions': state, control word, number, next state.
@pytest.mark.parametrize(
    ("state", "word", "number", "next_state"),
    [
        (DISABLED, SHUTDOWN, 2, READY),
        (READY, SWITCH_ON, 3, ON),
        (READY, ENABLE, 4, ENABLED),
        (ON, ENABLE, 4, ENABLED),
        (ON, SHUTDOWN, 6, READY),
        (READY, NO_VOLTAGE, 7, DISABLED),
        (READY, STOP, 7, DISABLED),
        (ENABLED, SHUTDOWN, 8, READY),
        (ENABLED, NO_VOLTAGE, 9, DISABLED),
        (ON, NO_VOLTAGE, 10, DISABLED),
        (ON, STOP, 10, DISABLED),
        (ENABLED, STOP, 11, QUICK_STOP),
        (QUICK_STOP, NO_VOLTAGE, 12, DISABLED),
        (QUICK_STOP, ENABLE, 16, ENABLED),
    ],
)
def test_commands_lead_where_the_table_says(state: State, word: int, number: int, next_state: State) -> None:
    machine = machine_in(state, FakeDrive())
    machine.control(word)
    assert (machine.transition, machine.state) == (number, next_state)


@pytest.mark.parametrize(
    ("state", "words"),
    [
        (DISABLED, (SWITCH_ON, ENABLE, NO_VOLTAGE, STOP)),
        (READY, (SHUTDOWN,)),
        (ON, (SWITCH_ON,)),
        (ENABLED, (ENABLE,)),
        (QUICK_STOP, (STOP, SHUTDOWN, SWITCH_ON)),
    ],
)
def test_other_commands_change_nothing(state: State, words: tuple[int, ...]) -> None:
    machine = machine_in(state, FakeDrive())
    for word in words:
        machine.control(word)
        machine.step()
        assert machine.state is state


def test_power_on_leads_to_switch_on_disabled_when_the_drive_is_there() -> None:
    drive = FakeDrive(is_there=False)
    machine = StateMachine(drive)
    machine.start()
    machine.step()
    assert (machine.state, machine.transition) == (NOT_READY, 0)
    drive.is_there = True
    machine.step()
    assert (machine.state, machine.transition) == (DISABLED, 1)


def test_switch_on_waits_for_power() -> None:
    drive = FakeDrive()
    machine = machine_in(READY, drive)
    drive.is_ready = False
    machine.control(SWITCH_ON)
    assert machine.state is READY
    drive.is_ready = True
    machine.step()
    assert machine.state is ON


def test_operation_is_enabled_when_the_drive_follows() -> None:
    drive = FakeDrive(lifts_at_once=False)
    machine = machine_in(ON, drive)
    machine.control(ENABLE)
    machine.step()
    assert (machine.state, drive.done) == (ON, ["enable"])
    drive.is_following = True
    machine.step()
    assert (machine.state, drive.done) == (ENABLED, ["enable", "go on"])


def test_enabling_that_is_taken_back_is_none() -> None:
    drive = FakeDrive(lifts_at_once=False)
    machine = machine_in(ON, drive)
    machine.control(ENABLE)
    machine.control(SWITCH_ON)
    assert (machine.state, drive.done) == (ON, ["enable", "disable"])


@pytest.mark.parametrize(("word", "number", "next_state"), [(SWITCH_ON, 5, ON), (SHUTDOWN, 8, READY)])
def test_a_slow_down_ramp_is_driven_before_the_drive_function_is_disabled(
    word: int, number: int, next_state: State
) -> None:
    drive = FakeDrive(options=Options(shutdown=1, disable=1))
    machine = machine_in(ENABLED, drive)
    machine.control(word)
    machine.step()
    assert (machine.state, drive.done) == (ENABLED, [Ramp.SLOW_DOWN])
    drive.is_at_rest = True
    machine.step()
    assert (machine.transition, machine.state, drive.done[-1]) == (number, next_state, "disable")


@pytest.mark.parametrize(("word", "next_state"), [(SWITCH_ON, ON), (SHUTDOWN, READY)])
def test_option_0_disables_the_drive_function_at_once(word: int, next_state: State) -> None:
    drive = FakeDrive(options=Options(shutdown=0, disable=0))
    machine = machine_in(ENABLED, drive)
    machine.control(word)
    assert (machine.state, drive.done) == (next_state, ["disable"])


def test_a_ramp_of_disable_operation_can_be_called_off() -> None:
    drive = FakeDrive()
    machine = machine_in(ENABLED, drive)
    machine.control(SWITCH_ON)
    machine.control(ENABLE)
    drive.is_at_rest = True
    machine.step()
    assert (machine.state, drive.done) == (ENABLED, [Ramp.SLOW_DOWN, "go on"])


# 605Ah: what is done, and where it ends.
@pytest.mark.parametrize(
    ("option", "done", "end"),
    [
        (0, ["disable"], DISABLED),
        (1, [Ramp.SLOW_DOWN, "disable"], DISABLED),
        (2, [Ramp.QUICK_STOP, "disable"], DISABLED),
        (3, [Ramp.LIMIT, "disable"], DISABLED),
        (4, [Ramp.LIMIT, "disable"], DISABLED),
        (5, [Ramp.SLOW_DOWN], QUICK_STOP),
        (6, [Ramp.QUICK_STOP], QUICK_STOP),
        (7, [Ramp.LIMIT], QUICK_STOP),
        (8, [Ramp.LIMIT], QUICK_STOP),
    ],
)
def test_quick_stop_ends_as_its_option_says(option: int, done: list[object], end: State) -> None:
    drive = FakeDrive(options=Options(quick_stop=option))
    machine = machine_in(ENABLED, drive)
    machine.control(STOP)
    assert machine.state is (DISABLED if option == 0 else QUICK_STOP)
    drive.is_at_rest = True
    machine.step()
    assert (machine.state, drive.done) == (end, done)
    if end is DISABLED:
        assert machine.transition == 12


@pytest.mark.parametrize("option", [1, 2, 3, 4])
def test_a_quick_stop_that_ends_disabled_can_not_be_left_to_operation(option: int) -> None:
    machine = machine_in(ENABLED, FakeDrive(options=Options(quick_stop=option)))
    machine.control(STOP)
    machine.control(ENABLE)
    assert machine.state is QUICK_STOP


@pytest.mark.parametrize("state", [DISABLED, READY, ON])
def test_a_fault_of_an_axis_without_power_is_there_at_once(state: State) -> None:
    drive = FakeDrive()
    machine = machine_in(state, drive)
    drive.errors = (0x7305,)
    machine.step()
    assert (machine.state, machine.transition) == (FAULT, 14)


# 605Eh.
@pytest.mark.parametrize(
    ("option", "ramp"),
    [(0, None), (1, Ramp.SLOW_DOWN), (2, Ramp.QUICK_STOP), (3, Ramp.LIMIT), (4, Ramp.LIMIT)],
)
def test_the_fault_reaction_is_what_its_option_says(option: int, ramp: Ramp | None) -> None:
    drive = FakeDrive(options=Options(fault=option))
    machine = machine_in(ENABLED, drive)
    drive.errors = (0x8611,)
    machine.step()
    if ramp is not None:
        assert (machine.state, machine.transition, drive.done) == (REACTION, 13, [ramp])
        drive.is_at_rest = True
        machine.step()
    assert (machine.state, machine.transition, drive.done[-1]) == (FAULT, 14, "disable")


def test_a_drive_with_a_reaction_of_its_own_is_waited_for() -> None:
    drive = FakeDrive()
    machine = machine_in(ENABLED, drive)
    drive.errors, drive.is_following, drive.is_moving_by_itself = (0x4310,), False, True
    machine.step()
    machine.step()
    assert (machine.state, drive.done) == (REACTION, [])
    drive.is_moving_by_itself = False
    machine.step()
    assert machine.state is FAULT


def test_a_fault_is_reset_by_the_rising_bit_alone() -> None:
    drive = FakeDrive()
    machine = machine_in(DISABLED, drive)
    machine.control(RESET)
    drive.errors = (0x7305,)
    machine.step()
    drive.errors = ()
    machine.control(RESET)
    assert machine.state is FAULT
    machine.control(0)
    machine.control(RESET)
    assert (machine.state, machine.transition) == (DISABLED, 15)


def test_a_fault_whose_cause_stays_is_not_reset() -> None:
    drive = FakeDrive(errors=(0x7305,))
    machine = StateMachine(drive)
    machine.start()
    machine.step()
    machine.step()
    machine.control(RESET)
    assert machine.state is FAULT


def test_lost_power_disables() -> None:
    drive = FakeDrive()
    machine = machine_in(ENABLED, drive)
    drive.is_following = False
    machine.step()
    assert (machine.state, machine.transition) == (DISABLED, 9)
    machine = machine_in(ON, drive)
    drive.is_ready = False
    machine.step()
    assert (machine.state, machine.transition) == (DISABLED, 10)


@pytest.mark.long
@settings(deadline=None, max_examples=200)
@given(st.lists(st.tuples(st.integers(0, 0xFFFF), st.integers(0, 3)), max_size=40))
def test_whatever_comes_power_is_on_in_two_states_only(course: list[tuple[int, int]]) -> None:
    drive = FakeDrive(lifts_at_once=True)
    machine = StateMachine(drive)
    machine.start()
    for word, happens in course:
        machine.control(word)
        drive.is_at_rest = happens == 1
        drive.errors = (0x7305,) if happens == 2 else ()
        machine.step()
        if drive.is_following:
            assert machine.state in (ENABLED, QUICK_STOP, REACTION)


def test_a_drive_may_count_enable_operation_as_switch_on() -> None:
    drive = FakeDrive()
    machine = StateMachine(drive, Behaviour(passes_switched_on=False))
    machine.start()
    machine.step()
    machine.control(SHUTDOWN)
    machine.control(ENABLE)
    machine.step()
    assert machine.state is ON
    machine.control(ENABLE)
    assert machine.state is ENABLED
