"""The caller of `fieldrig dial` in virtual time, opposite a modem and a controller by hand."""

import pytest
from dial_bench import LOGIN, Bench
from dial_peer import PAGE
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import S
from fieldrig_devices.dial.caller import Plan
from fieldrig_devices.dial.chat import DEFAULT_INIT, FAILURES, NO_CONNECTION, NO_MODEM
from fieldrig_devices.ip.tcp.connection import Ending
from fieldrig_devices.ppp.settings import Login


def test_a_call_from_the_first_command_to_the_last() -> None:
    bench = Bench()
    bench.run(20, lambda: bench.caller.is_up)
    connection = bench.caller.open(80)
    page, endings = bytearray(), list[Ending]()
    connection.on_data, connection.on_close = page.extend, endings.append
    connection.send(b"GET")
    connection.end()
    bench.run(100, lambda: bool(endings))
    assert (bytes(page), endings) == (PAGE, [Ending.COMPLETE])
    bench.caller.hang_up(bench.now_ns)
    bench.run(20)
    assert (bench.caller.is_over, bench.caller.failure) == (True, None)
    assert bench.far.commands == [b"AT", *(line.encode() for line in DEFAULT_INIT), b"ATDT4711", b"ATH"]
    assert bench.said == [
        "The modem answers.",
        "The modem dials 4711.",
        "The modem is connected (38400).",
        "The controller checks the login of service.",
        "The link is up: this end is 190.200.100.101, the controller is 190.200.100.100.",
    ]


@pytest.mark.parametrize("word", list(FAILURES))
def test_each_refusal_of_a_modem_is_a_sentence(word: str) -> None:
    bench = Bench(answers={b"ATDT4711": word.encode()})
    bench.run(20)
    assert bench.caller.is_over
    assert bench.failure() == FAILURES[word].what


def test_a_refused_initialisation_is_named() -> None:
    bench = Bench(Plan("4711", ("ATX9",), LOGIN), {b"ATX9": b"ERROR"})
    bench.run(20)
    assert bench.failure() == "The modem refuses ATX9."


def test_a_silent_modem_is_asked_three_times() -> None:
    bench = Bench()
    bench.far.is_silent = True
    bench.run(20)
    assert (bench.far.commands, bench.caller.failure) == ([b"AT"] * 3, NO_MODEM)


def test_a_modem_that_does_not_connect_is_stopped() -> None:
    bench = Bench(Plan("4711", login=LOGIN, dial_ns=30 * S), {b"ATDT4711": b"RINGING"})
    bench.run(40)
    assert (bench.far.commands[-1], bench.caller.failure) == (b"", NO_CONNECTION)


def test_a_wrong_password_is_a_sentence_and_hangs_up() -> None:
    bench = Bench(Plan("4711", login=Login.of("service", "wrong")))
    bench.run(60)
    assert bench.failure() == "The controller refuses the user name or the password."
    assert (bench.caller.is_over, bench.far.commands[-1]) == (True, b"ATH")


def test_a_call_without_a_login_says_what_is_missing() -> None:
    bench = Bench(Plan("4711"))
    bench.run(100)
    assert bench.caller.failure is not None
    assert "--user" in bench.caller.failure.remedy


def test_a_lost_carrier_ends_the_connections() -> None:
    bench = Bench()
    bench.run(20, lambda: bench.caller.is_up)
    endings: list[Ending] = []
    bench.caller.open(80).on_close = endings.append
    bench.run(0.001)
    bench.far.hang_up()
    bench.run(1)
    assert (endings, bench.failure()) == ([Ending.LINK_DOWN], "The connection was lost.")


def test_the_words_of_a_modem_within_a_page_are_data() -> None:
    bench = Bench()
    bench.run(20, lambda: bench.caller.is_up)
    connection = bench.caller.open(7)
    echo = bytearray()
    connection.on_data = echo.extend
    connection.send(b"\r\nNO CARRIER\r\n")
    bench.run(5)
    assert (bytes(echo), bench.caller.is_over) == (b"\r\nNO CARRIER\r\n", False)


def test_a_line_without_a_modem_begins_with_ppp() -> None:
    bench = Bench(Plan(None, login=LOGIN))
    bench.far.is_online = True
    bench.far.ppp.up(0)
    bench.run(20, lambda: bench.caller.is_up)
    bench.caller.hang_up(bench.now_ns)
    bench.run(5)
    assert (bench.caller.is_over, bench.far.commands) == (True, [])


def test_nothing_can_be_opened_before_the_link_is_up() -> None:
    with pytest.raises(ConnectionError):
        Bench().caller.open(80)


def test_hanging_up_while_dialling_stops_the_modem() -> None:
    bench = Bench(answers={b"ATDT4711": b"RINGING"})
    bench.run(5)
    bench.caller.hang_up(bench.now_ns)
    bench.run(1)
    assert (bench.caller.is_over, bench.far.commands[-1]) == (True, b"")


@settings(deadline=None)
@given(st.lists(st.binary(max_size=30) | st.sampled_from([b"\r\nOK\r\n", b"CONNECT\r\n", b"~\r\nNO CARRIER\r\n"])))
def test_arbitrary_bytes_do_not_raise(chunks: list[bytes]) -> None:
    bench = Bench()
    for chunk in chunks:
        bench.caller.receive(bench.now_ns, chunk)
        bench.run(1)
