"""The bytes that COM1 sends to its modem, the parameters of the Modem object, and calls (PacDrive manual 7.2)."""

import pytest
from com1_bench import CARRIER, CONNECT, OFF, OK, READY, Com1Bench
from hypothesis import given
from hypothesis import strategies as st
from max4_bench import Bench

from fieldrig_bus.serial.message import ControlLines, Format, SerialMessage
from fieldrig_devices.max4.com1.results import Result, ResultReader
from fieldrig_devices.max4.com1.states import Com1State, User


@pytest.mark.manual("PD-247")
@pytest.mark.manual("PD-249")
def test_the_second_string_follows_when_the_first_is_accepted() -> None:
    bench = Com1Bench().run(1)
    assert bench.sent() == b""
    assert bench.says(READY).sent() == b"AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2\r"
    assert bench.run(3).sent() == b""
    assert bench.says(OK).run(0.3).sent() == b"AT +MS=,0\r"
    assert bench.says(OK).run(10).sent() == b""


def test_an_echo_and_other_lines_are_no_answers() -> None:
    bench = Com1Bench().run(1).says(READY).says(b"AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2\r", b"\r\nRING\r\n")
    assert bench.states == (5, 0)
    assert bench.says(b"\r\nO").states == (5, 0)
    assert bench.says(b"K\r\n").states == (5, 4)


@pytest.mark.manual("PD-247")
@pytest.mark.parametrize("name", ["InitString", "ExpInitString"])
def test_a_string_has_at_most_40_characters(name: str) -> None:
    bench = Com1Bench()
    bench.tree.set(f"Modem.{name}", "AT" + "x" * 38)
    with pytest.raises(ValueError, match="40"):
        bench.tree.set(f"Modem.{name}", "AT" + "x" * 39)


@pytest.mark.manual("PD-249")
def test_the_second_string_begins_with_at() -> None:
    bench = Com1Bench()
    with pytest.raises(ValueError, match="expected AT"):
        bench.tree.set("Modem.ExpInitString", "+MS=,0")
    bench.tree.set("Modem.ExpInitString", "AT")
    bench.run(1).says(READY, OK).sent()
    assert bench.run(0.3).sent() == b"AT\r"


@pytest.mark.manual("PD-250")
def test_the_modem_object_has_seven_parameters_with_their_defaults() -> None:
    bench = Com1Bench()
    values = {parameter.name: parameter.value for parameter in bench.tree.object("Modem").parameters}
    assert values == {
        "RemoteIpAddress": "190.200.100.101",
        "LocalIpAddress": "190.200.100.100",
        "UserName": "",
        "Password": "",
        "InitString": "AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2",
        "ExpInitString": "AT +MS=,0",
        "State": 0,
    }
    with pytest.raises(ValueError, match="read-only"):
        bench.tree.set("Modem.LocalIpAddress", "10.0.0.1")
    with pytest.raises(ValueError, match="expected an address"):
        bench.tree.set("Modem.RemoteIpAddress", "190.200.100")


@pytest.mark.manual("PD-245")
def test_the_line_has_38400_baud_8n1() -> None:
    bench = Com1Bench(baud=38_400)
    assert bench.link.sent[0] == Format(38_400, 8, "N", 1)


def test_nothing_is_sent_while_cts_is_off() -> None:
    bench = Com1Bench().run(1).says(ControlLines(rts=False, dcd=False))
    assert bench.states == (5, 0)
    assert bench.sent() == b""
    bench.says(READY)
    assert bench.sent().startswith(b"AT&F")


@pytest.mark.manual("PD-258")
def test_a_call_gets_what_follows_connect() -> None:
    bench = Com1Bench().offline()
    bench.says(b"\r\nRING\r\n", CARRIER, b"\r\nRING\r\n\r\nCONNECT 38400\r\n\x7e\xff", b"\x03\x7e")
    assert bench.states == (7, 3)
    assert bench.calls[0].heard == b"\n\x7e\xff\x03\x7e"
    bench.sent()
    bench.calls[0].send(b"\x7e")
    assert bench.sent() == b"\x7e"


def test_dcd_without_connect_is_a_call_after_1_s() -> None:
    bench = Com1Bench().offline().says(CARRIER).run(0.9)
    assert bench.calls == []
    assert len(bench.run(0.2).calls) == 1


def test_dcd_that_drops_at_once_is_no_call() -> None:
    assert Com1Bench().offline().says(CARRIER).run(0.5).says(READY).run(5).calls == []


@pytest.mark.manual("PD-275")
@pytest.mark.parametrize("loss", [READY, OFF])
def test_a_dropped_line_ends_the_call_and_the_next_call_is_answered(loss: SerialMessage) -> None:
    bench = Com1Bench().online().says(loss)
    assert bench.calls[0].has_ended
    bench.sent()
    bench.calls[0].send(b"too late")
    assert bench.sent() == b""
    if loss == OFF:
        bench.run(12).offline()
    bench.says(CARRIER, CONNECT)
    assert bench.port.state == Com1State.MODEM_ONLINE
    assert len(bench.calls) == 2


def test_hanging_up_drops_dtr_for_1_s() -> None:
    bench = Com1Bench().online()
    bench.calls[0].hang_up()
    assert bench.dtr()
    assert not bench.run(0.3).dtr()
    bench.run(0.1).says(READY)
    assert bench.states == (6, 2)
    assert not bench.dtr()
    bench.run(1)
    assert bench.dtr()
    assert bench.says(CARRIER, CONNECT).states == (7, 3)


def test_the_last_frame_has_passed_the_line_before_dtr_drops() -> None:
    bench = Com1Bench(baud=38_400).online()
    bench.calls[0].send(b"\x7e" * 3840)  # 1 s
    bench.calls[0].hang_up()
    assert bench.run(1.2).dtr()
    assert not bench.run(0.2).dtr()
    assert bench.sent().endswith(b"\r" + b"\x7e" * 3840)


def test_a_modem_that_holds_the_line_gets_10_s_for_the_last_frame() -> None:
    bench = Com1Bench(baud=38_400).online().says(ControlLines(rts=False))  # CTS of the controller
    bench.calls[0].send(b"last frame")
    bench.calls[0].hang_up()
    assert bench.run(9.9).dtr()
    assert not bench.run(0.2).dtr()


def test_a_modem_that_ignores_dtr_gets_another_call() -> None:
    bench = Com1Bench().online()
    bench.calls[0].hang_up()
    bench.run(1.3)
    assert bench.calls[0].has_ended
    assert bench.states == (6, 2)
    assert len(bench.run(1).calls) == 2


def test_an_end_without_power_drops_the_line() -> None:
    bench = Com1Bench().online()
    bench.port.end()
    assert bench.calls[0].has_ended
    assert not bench.dtr()
    bench.says(OFF, READY, CARRIER, CONNECT).run(60)
    assert bench.states == (0, 0)


@given(st.lists(st.binary(max_size=40), max_size=10))
def test_no_bytes_raise_in_the_reader(pieces: list[bytes]) -> None:
    reader = ResultReader()
    for piece in pieces:
        rest = piece
        while rest:
            _, rest = reader.feed(rest)
    rest = b"\r\nCONNECT\r\n"
    found = []
    while rest:
        result, rest = reader.feed(rest)
        found.append(result)
    assert Result.CONNECT in found


@given(
    st.lists(
        st.sampled_from(
            [READY, CARRIER, OFF, OK, CONNECT, b"\r\nERROR\r\n", b"\r\nNO CARRIER\r\n", *User, 0.1, 1.0, 6.0]
        ),
        max_size=60,
    ),
    st.sampled_from(User),
)
def test_com1_user_state_fits_its_user_whatever_happens(steps: list[SerialMessage | User | float], user: User) -> None:
    bench = Com1Bench(user)
    for step in steps:
        if isinstance(step, User):
            bench.choose(step)
            user = step
        elif isinstance(step, float):
            bench.run(step)
        else:
            bench.says(step)
        name = bench.port.state.name
        assert bench.port.state is Com1State.INIT or name.startswith(user.name)
        assert sum(not call.has_ended for call in bench.calls) == name.endswith("ONLINE")


def test_a_controller_has_the_parameters_of_com1_and_hides_the_password() -> None:
    bench = Bench(
        simulated=("belt",),
        com1={"modem": "Phone"},
        parameters={"MAx-4.Com1User": 1, "Phone.UserName": "service", "Phone.Password": "s3cret"},
    ).boot()
    assert bench.run(1000).get("Com1UserState") == 4
    assert bench.get("Phone.UserName") == "service"
    assert bench.get("Phone.Password") == "********"
    assert bench.max4.firmware.tree.get("Phone.Password") == "s3cret"
    bench.set("Com1User", 0)
    assert bench.get("Com1UserState") == 1
    bench.do("system reset").boot()
    assert bench.get("Com1User") == 1
