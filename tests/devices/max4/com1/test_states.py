"""The states of COM1 and of the Modem object, row by row as in tables 7-3 and 7-4 of the PacDrive manual."""

import pytest
from com1_bench import CARRIER, CONNECT, ERROR, OFF, OK, READY, Com1Bench

from fieldrig_bus.serial.message import ControlLines
from fieldrig_devices.max4.com1.states import NEXT, Com1State, Event, ModemState, User

ROWS = {
    Com1State.INIT: 0,
    Com1State.EPAS_4: 1,
    Com1State.MODEM_EPAS_4: 2,
    Com1State.AUTO_SEARCH: 3,
    Com1State.MODEM_SEARCH: 4,
    Com1State.MODEM_TEST: 5,
    Com1State.MODEM_OFFLINE: 6,
    Com1State.MODEM_ONLINE: 7,
    Com1State.NONE: 8,
    Com1State.AUTO_TEST: 9,
    Com1State.AUTO_EPAS_4: 10,
    Com1State.AUTO_OFFLINE: 11,
    Com1State.AUTO_ONLINE: 12,
}


@pytest.mark.manual("PD-257")
@pytest.mark.parametrize(
    ("user", "search", "test", "offline", "online"), [(User.MODEM, 4, 5, 6, 7), (User.AUTO, 3, 9, 11, 12)]
)
def test_a_modem_is_found_initialised_and_called(user: User, search: int, test: int, offline: int, online: int) -> None:
    bench = Com1Bench(user)
    assert bench.states == (0, 0)
    bench.run(1)
    assert bench.states == (search, 0)
    bench.says(READY)
    assert bench.states == (test, 0)
    bench.says(OK)
    assert bench.states == (test, 4)
    bench.run(0.3).says(OK)
    assert bench.states == (test, 7)
    bench.run(0.3)
    assert bench.states == (offline, 2)
    bench.says(CARRIER, CONNECT)
    assert bench.states == (online, 3)
    bench.says(READY)
    assert bench.states == (offline, 2)


@pytest.mark.manual("PD-253")
@pytest.mark.parametrize(
    ("number", "state"), [(0, Com1State.EPAS_4), (1, Com1State.INIT), (2, Com1State.INIT), (3, Com1State.NONE)]
)
def test_a_boot_begins_with_the_user(number: int, state: Com1State) -> None:
    assert Com1Bench(User(number)).port.state == state


@pytest.mark.manual("PD-242")
@pytest.mark.parametrize(("user", "state"), [(User.MODEM, 2), (User.AUTO, 10)])
def test_without_a_modem_object_no_modem_is_looked_for(user: User, state: int) -> None:
    bench = Com1Bench(user, modem=False).says(READY).run(60)
    assert bench.port.state == state
    assert bench.sent() == b""


@pytest.mark.manual("PD-243")
@pytest.mark.parametrize(("user", "state"), [(User.MODEM, 2), (User.AUTO, 10)])
def test_a_port_without_a_modem_goes_to_epas(user: User, state: int) -> None:
    assert Com1Bench(user).run(2.5).states == (state, 1)


@pytest.mark.manual("PD-254")
def test_with_modem_the_port_is_searched_every_10_s() -> None:
    bench = Com1Bench(User.MODEM)
    searches, before = [], 0
    for tenth in range(350):
        now = bench.run(0.1).port.state
        if now == Com1State.MODEM_SEARCH and now != before:
            searches.append((tenth + 1) / 10)
        before = now
    assert searches == [1, 11, 21, 31]


@pytest.mark.manual("PD-254")
def test_with_auto_a_released_port_is_not_searched_until_something_is_plugged_in() -> None:
    bench = Com1Bench(User.AUTO).run(2.5)
    for _ in range(600):
        assert bench.run(0.1).port.state == Com1State.AUTO_EPAS_4
    assert bench.says(READY).port.state == Com1State.AUTO_TEST


@pytest.mark.parametrize("user", [User.MODEM, User.AUTO])
@pytest.mark.parametrize("stage", ["test", "accepted", "offline", "online"])
def test_a_modem_that_is_unplugged_is_noticed_and_found_again(user: User, stage: str) -> None:
    bench = Com1Bench(user).run(1).says(READY)
    match stage:
        case "accepted":
            bench.says(OK)
        case "offline":
            bench.offline()
        case "online":
            bench.online()
    bench.says(OFF)
    assert bench.states == (Com1State.MODEM_SEARCH if user is User.MODEM else Com1State.AUTO_SEARCH, 0)
    assert all(call.has_ended for call in bench.calls)
    bench.run(3)
    assert bench.states == (Com1State.MODEM_EPAS_4 if user is User.MODEM else Com1State.AUTO_EPAS_4, 1)
    bench.run(3).says(READY).says(OK).run(0.3).says(OK).run(0.3)
    assert bench.states == (Com1State.MODEM_OFFLINE if user is User.MODEM else Com1State.AUTO_OFFLINE, 2)


@pytest.mark.manual("PD-251")
@pytest.mark.parametrize(
    ("answers", "state"),
    [([ERROR], 5), ([b""], 6), ([OK, ERROR], 8), ([OK, b""], 9), ([b"4\r"], 5), ([b"0\r", b"4\r"], 8)],
)
@pytest.mark.parametrize("user", [User.MODEM, User.AUTO])
def test_a_modem_that_refuses_a_string_is_given_up(user: User, answers: list[bytes], state: int) -> None:
    bench = Com1Bench(user).run(1).says(READY)
    for answer in answers:
        bench.run(0.3).says(answer)
    bench.run(5)
    assert bench.states == (2 if user is User.MODEM else 10, state)


@pytest.mark.manual("PD-252")
@pytest.mark.parametrize("answers", [[ERROR], [b""], [OK, ERROR], [OK, b""]])
@pytest.mark.parametrize("user", [User.MODEM, User.AUTO])
@pytest.mark.parametrize("how", ["power cycle of the modem", "Com1User"])
def test_a_refused_string_stays_refused_until_a_power_cycle_or_a_new_com1_user(
    user: User, answers: list[bytes], how: str
) -> None:
    bench = Com1Bench(user).run(1).says(READY)
    for answer in answers:
        bench.run(0.3).says(answer)
    given_up = bench.run(5).states
    bench.sent()
    for _ in range(60):
        assert bench.run(1).states == given_up
    assert bench.sent() == b""
    if how == "Com1User":
        bench.choose(User.NONE).run(0.1).choose(user).run(1.1)
    else:
        bench.says(OFF).run(0.5).says(READY)
    assert bench.sent().startswith(b"AT&F")


@pytest.mark.manual("PD-255")
@pytest.mark.parametrize("user", [User.MODEM, User.AUTO])
def test_com1_user_acts_only_when_its_value_changes(user: User) -> None:
    bench = Com1Bench(user).online()
    online = bench.states
    bench.sent()
    bench.choose(user).run(30)
    assert bench.states == online
    assert not bench.calls[0].has_ended
    bench.choose(User.NONE)
    assert bench.states == (8, 0)
    bench.choose(user).run(1)
    assert bench.states[0] == (5 if user is User.MODEM else 9)


@pytest.mark.manual("PD-256")
@pytest.mark.parametrize("user", [User.EPAS_4, User.AUTO, User.NONE])
def test_a_change_of_com1_user_cuts_the_connection(user: User) -> None:
    bench = Com1Bench(User.MODEM).online()
    assert bench.dtr()
    bench.link.take()
    bench.choose(user)
    assert bench.calls[0].has_ended
    assert bench.link.sent[0] == ControlLines(dtr=False, rts=False)


@pytest.mark.parametrize("state", ModemState)
def test_numbers_of_the_modem_states_are_those_of_table_7_3(state: ModemState) -> None:
    names = "INIT NO_MODEM OFFLINE ONLINE INIT_STRING_OK INIT_STRING_ERROR INIT_STRING_TIMEOUT EXP_INIT_STRING_OK "
    names += "EXP_INIT_STRING_ERROR EXP_INIT_STRING_TIMEOUT"
    assert names.split()[state] == state.name


def test_every_state_has_its_number_and_every_searching_state_can_be_left() -> None:
    assert {state: int(state) for state in Com1State} == ROWS
    assert {state for state, _ in NEXT} == set(Com1State) - {Com1State.EPAS_4, Com1State.NONE}


def test_a_modem_that_disappears_is_looked_for_from_every_state_with_a_modem() -> None:
    gone = {state for state, event in NEXT if event is Event.GONE}
    assert gone == {
        Com1State.MODEM_TEST, Com1State.MODEM_OFFLINE, Com1State.MODEM_ONLINE,
        Com1State.AUTO_TEST, Com1State.AUTO_OFFLINE, Com1State.AUTO_ONLINE,
    }  # fmt: skip
