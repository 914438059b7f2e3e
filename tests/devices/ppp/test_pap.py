"""PAP as RFC 1334 chapter 2 describes it, and the lines that pppd 2.4.9 sent with it."""

import pytest
from ppp_bench import CALLER_END, CONTROLLER_END, LOGIN, PAP_LOGIN, PppBench, spaced

from fieldrig_devices.ppp.link import LoginAttempt
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import Login, PppSettings

WRONG = "c023 01 02 000e 03 6c6162 05 66616c7363"  # lab, falsc
ACCEPTED = spaced("c023 02 01 0005 00")


def test_request_of_pppd_is_accepted() -> None:
    bench = PppBench().establish()
    # recorded: pppd with `user lab password geheim`
    assert bench.hear("c023 0101000f036c61620667656865696d")[0] == ACCEPTED
    assert bench.link.peer_name == b"lab"
    assert bench.attempts == [LoginAttempt(b"lab", is_accepted=True, failures=0)]
    assert bench.phases[-2:] == [Phase.AUTHENTICATE, Phase.NETWORK]


@pytest.mark.manual("PD-273")
@pytest.mark.parametrize(
    "attempt",
    [
        WRONG,
        "c023 01 02 000f 03 4c6162 06 67656865696d",  # another case
        "c023 01 02 000e 03 6c6162 05 6765686569",  # a part of the password
        "c023 01 02 0010 03 6c6162 07 67656865696d00",
        "c023 01 02 0009 03 6c6162 00",
        "c023 01 02 0006 00 00",
    ],
)
def test_wrong_login_is_refused_and_ends_the_call(attempt: str) -> None:
    bench = PppBench().establish()
    refusal, end = bench.hear(attempt)
    assert (refusal[:8], end[:6]) == ("c0230302", "c02105")
    assert (bench.link.ended_by, bench.link.peer_name) == (End.LOGIN_FAILED, None)
    assert bench.hear(PAP_LOGIN, "8021 01 01 000a 0306 bec86465", "0021 45") == []  # too late
    assert bench.packets == []


@pytest.mark.parametrize(
    "attempt",
    ["c023", "c023 01 02 0004", "c023 01 02 0005 00", "c023 01 02 0008 04 6c6162", "c023 01 02 0009 03 6c6162 06"],
)
def test_malformed_request_is_dropped(attempt: str) -> None:
    bench = PppBench().establish()
    assert (bench.hear(attempt), bench.attempts) == ([], [])
    assert bench.hear(PAP_LOGIN)[0] == ACCEPTED


def test_repeated_request_gets_the_same_answer_again() -> None:
    bench = PppBench().log_in()
    assert bench.hear(PAP_LOGIN) == [ACCEPTED]
    assert bench.hear(WRONG) == [spaced("c023 02 02 0005 00")]  # one attempt a call: nothing is tried out
    assert len(bench.attempts) == 1


def fail(bench: PppBench) -> None:
    bench.link.down(bench.now_ns)
    bench.take()
    bench.establish().hear(WRONG)


def test_answers_are_slow_after_three_failed_logins() -> None:
    bench = PppBench()
    for number in (1, 2, 3):
        fail(bench)
        assert bench.attempts[-1] == LoginAttempt(b"lab", is_accepted=False, failures=number)
        assert bench.attempts[-1].is_alarm == (number == 3)
    bench.link.down(bench.now_ns)
    bench.take()
    bench.establish()
    assert bench.hear(PAP_LOGIN) == []
    assert bench.wait_s(9.9) == []
    assert bench.hear("c023 01 05 000f 03 6c6162 06 67656865696d") == []  # repeated meanwhile
    assert bench.wait_s(0.1)[0] == spaced("c023 02 05 0005 00")
    assert bench.attempts[-1] == LoginAttempt(b"lab", is_accepted=True, failures=0)


def test_hanging_up_during_the_delay_tries_nothing() -> None:
    bench = PppBench()
    for _ in range(3):
        fail(bench)
    fail(bench)
    bench.link.down(bench.now_ns)
    assert (bench.wait_s(20), len(bench.attempts)) == ([], 3)


def test_delay_belongs_to_the_latest_request() -> None:
    bench = PppBench()
    for _ in range(3):
        fail(bench)
    bench.link.down(bench.now_ns)
    bench.take()
    bench.establish().hear(PAP_LOGIN, WRONG)
    assert bench.wait_s(10)[0][:6] == "c02303"


def test_silent_peer_is_dropped_after_the_limit() -> None:
    bench = PppBench().establish()
    bench.wait_s(59)
    assert bench.phase() is Phase.AUTHENTICATE
    bench.wait_s(1)
    assert bench.link.ended_by is End.LOGIN_TIMEOUT


# The end that logs in.


def caller() -> PppBench:
    bench = PppBench(CALLER_END).up()
    (request,) = bench.take()
    bench.line.clear()
    answers = bench.hear("c02102" + request[6:], "c021 01 07 000e 0304 c023 0506 aabbccdd")
    # recorded: pppd with `user lab password geheim` sends the same
    assert answers == [spaced("c021 02 07 000e 0304 c023 0506 aabbccdd"), spaced("c023 0101000f036c61620667656865696d")]
    return bench


def test_answer_of_pppd_is_taken() -> None:
    bench = caller()
    assert bench.hear("c023 0201000d084c6f67696e206f6b") == [spaced("8021 01 01 000a 0306 00000000")]
    assert bench.phase() is Phase.NETWORK


def test_refusal_ends_the_call() -> None:
    bench = caller()
    assert [frame[:6] for frame in bench.hear("c023 03 01 0005 00")] == ["c02105"]
    assert bench.link.ended_by is End.LOGIN_REFUSED


def test_request_is_repeated_with_a_new_identifier_every_3_s_and_10_times() -> None:
    bench = caller()
    assert [frame[4:8] for frame in bench.wait_s(29.9)] == [f"01{number:02x}" for number in range(2, 11)]
    bench.wait_s(0.1)
    assert bench.link.ended_by is End.NO_ANSWER


def test_both_ends_may_demand_a_login() -> None:
    bench = PppBench(PppSettings(demanded=LOGIN, own=Login.of("max4", "x"))).up()
    (request,) = bench.take()
    bench.hear("c02102" + request[6:], "c021 01 07 000e 0304 c023 0506 aabbccdd")
    assert bench.hear("c023 02 01 0005 00") == []
    assert bench.phase() is Phase.AUTHENTICATE  # the other login is still missing
    assert bench.hear(PAP_LOGIN)[0] == ACCEPTED
    assert bench.phase() is Phase.NETWORK


def test_login_in_logs_has_no_password() -> None:
    assert repr(LOGIN) == "Login(b'lab')"
    assert "geheim" not in repr(CONTROLLER_END)


def test_field_of_more_than_255_bytes_is_refused() -> None:
    with pytest.raises(ValueError, match="256 bytes, expected at most 255"):
        Login.of("a", "b" * 256)
