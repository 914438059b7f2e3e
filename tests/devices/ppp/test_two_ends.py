"""Two ends of a link in virtual time, over good and bad lines."""

from dataclasses import replace
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ppp_bench import CALLER, CALLER_END, CONTROLLER, CONTROLLER_END, LOGIN, Line

from fieldrig.clock import S
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import Login, PppSettings

RUNNING = [Phase.RUNNING] * 2
DEAD = [Phase.DEAD] * 2


def careful(settings: PppSettings) -> PppSettings:
    return replace(settings, echo_period_ns=5 * S)


def test_caller_logs_in_and_gets_its_address() -> None:
    line = Line(CONTROLLER_END, CALLER_END)
    line.up()
    line.pass_s(1)
    assert line.phases == RUNNING
    controller, caller = line.ends
    assert (controller.local_address, controller.peer_address) == (CONTROLLER, CALLER)
    assert (caller.local_address, caller.peer_address) == (CALLER, CONTROLLER)
    assert controller.peer_name == b"lab"


def test_ip_packets_of_every_byte_arrive() -> None:
    line = Line(CONTROLLER_END, CALLER_END)
    line.up()
    line.pass_s(1)
    packets = [bytes(range(256)) * 5, b"\x7e" * 1500, b"\x7d\x5e" * 3]
    for packet in packets:
        assert line.ends[0].send_ip(line.now_ns, packet)
        assert line.ends[1].send_ip(line.now_ns, packet[::-1])
    line.pass_s(1)
    assert line.packets == {0: [packet[::-1] for packet in packets], 1: packets}


def test_both_ends_know_why_it_ended() -> None:
    line = Line(CONTROLLER_END, CALLER_END)
    line.up()
    line.pass_s(1)
    line.ends[1].close(line.now_ns)
    line.pass_s(4)
    assert line.phases == DEAD
    assert [end.ended_by for end in line.ends] == [End.PEER_CLOSED, End.CLOSED]


@pytest.mark.manual("PD-273")
def test_wrong_password_ends_the_call_at_both_ends() -> None:
    line = Line(CONTROLLER_END, replace(CALLER_END, own=Login.of("lab", "falsch")))
    line.up()
    line.pass_s(10)
    assert line.phases == DEAD
    assert [end.ended_by for end in line.ends] == [End.LOGIN_FAILED, End.LOGIN_REFUSED]


def test_caller_without_a_login_is_not_let_in() -> None:
    line = Line(CONTROLLER_END, PppSettings())
    line.up()
    line.pass_s(40)  # the caller asks ten times
    assert line.phases == DEAD
    assert line.ends[0].ended_by is End.NO_AUTHENTICATION


def test_end_that_comes_later_is_heard() -> None:
    line = Line(CONTROLLER_END, CALLER_END)
    line.ends[0].up(0)
    line.pass_s(20)
    line.ends[1].up(line.now_ns)
    line.pass_s(5)
    assert line.phases == RUNNING


@pytest.mark.long
@given(st.integers(0, 2**32), st.sampled_from([0.0, 0.02, 0.1, 0.3]))
@settings(max_examples=60, deadline=None)
def test_bad_line_leads_to_a_link_or_to_an_end(seed: int, loss: float) -> None:
    """Frames are lost, cut and changed.  When the line is good again, both ends run, or both have ended."""
    chance = Random(seed)
    line = Line(careful(CONTROLLER_END), careful(CALLER_END), lambda frame: spoil(frame))

    def spoil(frame: bytes) -> bytes:
        fate = chance.random() / loss if loss else 1.0
        if fate < 0.4:
            return b""
        if fate < 0.7:
            at = chance.randrange(len(frame))
            return frame[:at] + bytes((frame[at] ^ 1 << chance.randrange(8),)) + frame[at + 1 :]
        return frame[: chance.randrange(len(frame))] if fate < 1 else frame

    line.up()
    for _ in range(40):
        line.pass_s(2)
        for number, end in enumerate(line.ends):
            assert end.phase is not Phase.RUNNING or end.local_address == (CONTROLLER, CALLER)[number]
            end.send_ip(line.now_ns, bytes(20))
    loss = 0.0
    line.pass_s(120)
    assert line.phases in (RUNNING, DEAD)
    assert set(line.packets[0] + line.packets[1]) <= {bytes(20)}


@pytest.mark.parametrize("mru", [128, 296, 576])
def test_packets_are_as_long_as_the_other_end_takes(mru: int) -> None:
    line = Line(replace(CONTROLLER_END, mru=mru), CALLER_END)
    line.up()
    line.pass_s(1)
    assert [end.mtu for end in line.ends] == [1500, mru]


def test_no_login_is_needed_if_none_is_demanded() -> None:
    line = Line(replace(CONTROLLER_END, demanded=None), replace(CALLER_END, own=LOGIN))
    line.up()
    line.pass_s(1)
    assert line.phases == RUNNING
    assert line.ends[0].peer_name is None
