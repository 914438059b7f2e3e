"""LCP as RFC 1661 chapter 5 describes it, and a call from the carrier to its end; bytes by hand from its formats."""

from dataclasses import replace

import pytest
from ppp_bench import CONTROLLER_END, LCP_REQUEST, PAP_LOGIN, PppBench, asked, check_sequence, framed, spaced

from fieldrig.clock import S
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import Login, PppSettings


@pytest.fixture
def bench() -> PppBench:
    """The controller's end, whose first request is out."""
    bench = PppBench().up()
    assert bench.take() == [spaced("c021 01 01 0018" + LCP_REQUEST)]
    return bench


# Time.


def test_request_is_repeated_every_3_s_and_10_times(bench: PppBench) -> None:
    assert bench.wait_s(29) == [spaced("c021 01 01 0018" + LCP_REQUEST)] * 9
    assert bench.wait_s(1) == []
    assert (bench.phase(), bench.link.ended_by) == (Phase.DEAD, End.NO_ANSWER)
    assert bench.link.next_ns() is None


def test_peer_that_negotiates_without_end_is_dropped_after_the_limit(bench: PppBench) -> None:
    for _ in range(59):
        bench.hear(asked("6302"))
        bench.hear("c021 03" + f"{_sent_identifier(bench):02x}" + "000a 0506 12345678")
        bench.wait_s(1)
    assert bench.phase() is Phase.ESTABLISH
    bench.wait_s(1)
    assert (bench.phase(), bench.link.ended_by) == (Phase.TERMINATE, End.NO_AGREEMENT)


def _sent_identifier(bench: PppBench) -> int:
    return bench.link._call._lcp._negotiation._asked_identifier


# An open link.


def test_terminate_request_is_confirmed_and_the_line_is_hung_up_after_3_s() -> None:
    bench = PppBench().run()
    assert bench.hear("c021 05 09 0010 5573657220726571756573 74") == [spaced("c021 06 09 0004")]
    assert (bench.phase(), bench.link.ended_by) == (Phase.TERMINATE, End.PEER_CLOSED)
    bench.wait_s(3)
    assert bench.phases[-2:] == [Phase.TERMINATE, Phase.DEAD]


def test_close_asks_twice_and_ends_without_an_answer() -> None:
    bench = PppBench().run()
    bench.link.close(bench.now_ns)
    assert [frame[:6] for frame in bench.take()] == ["c02105"]
    assert bench.phase() is Phase.TERMINATE
    assert [frame[:6] for frame in bench.wait_s(6)] == ["c02105"]
    assert (bench.phase(), bench.link.ended_by) == (Phase.DEAD, End.CLOSED)


def test_echo_is_answered_with_our_magic_number() -> None:
    bench = PppBench().run()
    assert bench.hear("c021 09 55 000b aabbccdd 414243") == [spaced("c021 0a 55 000b 22222222 414243")]
    assert bench.hear("c021 09 55 0007 aabbcc") == []
    assert bench.hear("c021 0b 56 000b aabbccdd 414243") == []  # Discard-Request
    assert bench.phase() is Phase.RUNNING


def test_echo_is_not_answered_before_the_link_is_open(bench: PppBench) -> None:
    assert bench.hear("c021 09 55 0008 aabbccdd") == []


def test_echo_reply_fits_into_the_mru_of_the_peer() -> None:
    bench = PppBench(PppSettings()).up()
    (request,) = bench.take()
    bench.hear("c02102" + request[6:], asked("0104 0080"))
    (reply,) = bench.hear("c021 09 55 00c8" + "00" * 196)
    assert reply == spaced("c021 0a 55 0080 22222222" + "00" * 120)


def test_unknown_code_is_rejected() -> None:
    bench = PppBench().run()
    (reject,) = bench.hear("c021 0c 08 000a aabbccdd 4d53")  # Identification, RFC 1570
    assert (reject[:6], reject[8:]) == ("c02107", spaced("000e 0c08000aaabbccdd4d53"))


def test_reject_of_a_code_that_the_link_needs_ends_it() -> None:
    bench = PppBench().run()
    bench.hear("c021 07 01 0008 0a01 0004")  # Echo-Reply: not needed
    assert bench.phase() is Phase.RUNNING
    bench.hear("c021 07 01 0004")
    assert bench.phase() is Phase.RUNNING
    bench.hear("c021 07 02 0008 0101 0004")
    assert (bench.phase(), bench.link.ended_by) == (Phase.TERMINATE, End.PROTOCOL_REJECTED)


# The first packets of pppd 2.4.9 for these protocols, and a packet with a compressed TCP header (RFC 1144).
UNKNOWN = {
    "IPv6CP": "8057 0101000e010a7c10679724314506",
    "CCP": "80fd 0101000f1a0478001804780015032f",
    "compressed TCP": "002d 10 02 00aa 01",
    "uncompressed TCP": "002f 45 00",
    "IPv6": "0057 60",
    "CHAP": "c223 01 01 0004",
    "Bridging": "0031 00",
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_unknown_protocol_is_rejected_once_the_login_is_done(name: str) -> None:
    bench = PppBench().run()
    packet = spaced(UNKNOWN[name])
    (reject,) = bench.hear(packet)
    assert (reject[:6], reject[12:]) == ("c02108", packet)
    assert int(reject[8:12], 16) == 4 + len(packet) // 2


@pytest.mark.parametrize("name", UNKNOWN)
def test_unknown_protocol_is_dropped_before_the_login(name: str) -> None:
    bench = PppBench().establish()
    assert bench.hear(UNKNOWN[name]) == []
    assert bench.phase() is Phase.AUTHENTICATE


@pytest.mark.parametrize(
    ("protocol", "reason"),
    [("c021", End.PROTOCOL_REJECTED), ("8021", End.PROTOCOL_REJECTED), ("0021", End.PROTOCOL_REJECTED), ("80fd", None)],
)
def test_reject_of_a_protocol_that_the_link_needs_ends_it(protocol: str, reason: End | None) -> None:
    bench = PppBench().run()
    bench.hear("c021 08 01 0008" + protocol + "0101")
    assert bench.link.ended_by is reason
    assert bench.phase() is (Phase.RUNNING if reason is None else Phase.TERMINATE)


def test_reject_of_a_protocol_before_the_link_is_open_is_dropped(bench: PppBench) -> None:
    assert bench.hear("c021 08 01 0008 c021 0101", "c021 08 02 0005 c0") == []
    assert bench.link.ended_by is None


def test_reject_of_ipcp_that_is_no_longer_running_has_no_effect() -> None:
    bench = PppBench().establish()
    assert bench.hear("c021 08 01 0008 8021 0101") == []
    assert bench.phase() is Phase.AUTHENTICATE


def test_frame_for_another_address_or_without_a_protocol_is_dropped() -> None:
    bench = PppBench().run()
    good = bench.link.counts.good
    for text in ("ff 13 c0 21 09 01 00 08 aa bb cc dd", "ff 03", "ff 03 c0"):
        content = bytes.fromhex(text)
        bench.link.receive(bench.now_ns, b"\x7e" + content + check_sequence(content) + b"\x7e")
    assert bench.take() == []
    assert bench.link.counts.good > good


def test_reject_of_pap_ends_the_login() -> None:
    bench = PppBench().establish()
    bench.hear("c021 08 01 0008 c023 0101")
    assert bench.link.ended_by is End.NO_AUTHENTICATION


def test_new_negotiation_of_an_open_link_needs_a_new_login() -> None:
    bench = PppBench().run()
    request, ack = bench.hear("c021 01 08 000a 0506 aabbccdd")
    assert (request[:6], ack) == ("c02101", spaced("c021 02 08 000a 0506 aabbccdd"))
    assert bench.phase() is Phase.ESTABLISH
    bench.hear("c02102" + request[6:])
    assert bench.phase() is Phase.AUTHENTICATE
    assert not bench.link.send_ip(0, b"\x45")
    assert bench.hear("0021 45", "8021 01 02 000a 0306 bec86465") == []
    assert [frame[:6] for frame in bench.hear(PAP_LOGIN)] == ["c02302", "802101"]


def test_looped_back_line_is_recognised() -> None:
    bench = PppBench(PppSettings()).up()
    for _ in range(20):
        for frame in bench.take():
            bench.link.receive(0, framed(frame))
    assert bench.link.ended_by is End.LOOPED_BACK


def test_lost_peer_is_noticed_by_its_echo() -> None:
    bench = PppBench(replace(CONTROLLER_END, echo_period_ns=10 * S)).run()
    assert bench.wait_s(10) == [spaced("c021 09 02 0008 22222222")]
    bench.hear("c021 0a 02 0008 aabbccdd")
    assert [frame[4:6] for frame in bench.wait_s(40)] == ["09"] * 4
    bench.hear("c021 0a 06 0008 22222222")  # our own number: the line returns what we send
    assert [frame[4:6] for frame in bench.wait_s(10)] == ["05"]
    assert bench.link.ended_by is End.NO_ECHO


def test_lost_carrier_ends_the_call_at_once_and_the_next_begins_afresh() -> None:
    bench = PppBench().run()
    bench.link.down(bench.now_ns)
    assert (bench.phase(), bench.link.ended_by, bench.take()) == (Phase.DEAD, End.LINE_LOST, [])
    assert bench.hear("c021 09 55 0008 aabbccdd") == []
    bench.link.settings = PppSettings(demanded=Login.of("b", "c"))
    bench.up()
    assert bench.link.ended_by is None
    assert [frame[:8] for frame in bench.take()] == ["c0210101"]


def test_calls_without_effect_in_the_wrong_phase() -> None:
    bench = PppBench()
    bench.link.close(0)
    bench.link.down(0)
    bench.link.advance(10)
    assert (bench.hear("c021 01 07 0004"), bench.phases, bench.link.next_ns()) == ([], [], None)
    assert len(bench.up().up().take()) == 1
