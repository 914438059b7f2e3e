"""LCP as RFC 1661 chapters 5 and 6 describe it; bytes by hand from its formats."""

from dataclasses import replace

import pytest
from ppp_bench import CALLER_END, CONTROLLER_END, PAP_LOGIN, PppBench, framed, spaced

from fieldrig.clock import S
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import Login, PppSettings

MAGIC = "0506 22222222"
REQUEST = "0206 00000000 0304 c023" + MAGIC + "0702 0802"  # asyncmap 0, PAP, magic number, both compressions


@pytest.fixture
def bench() -> PppBench:
    """The controller's end, whose first request is out."""
    bench = PppBench().up()
    assert bench.take() == [spaced("c021 01 01 0018" + REQUEST)]
    return bench


def code_and_options(frames: list[str]) -> tuple[int, str]:
    (frame,) = frames
    return int(frame[4:6], 16), frame[12:]


def asked(options: str, identifier: int = 7) -> str:
    length = 4 + len(bytes.fromhex(options))
    return f"c02101{identifier:02x}{length:04x}" + options


# Options of the peer: code of the answer, and the options in it.
ANSWERS = [
    ("", 2, ""),
    ("0104 05dc", 2, "0104 05dc"),
    ("0104 0080", 2, "0104 0080"),
    ("0104 ffff", 2, "0104 ffff"),
    ("0104 007f", 3, "0104 05dc"),
    ("0103 05", 3, "0104 05dc"),
    ("0206 000a0000", 2, "0206 000a0000"),
    ("0204 000a", 3, "0206 00000000"),
    ("0304 c023", 4, "0304 c023"),  # the controller has no login of its own
    ("0408 c025 00000000", 4, "0408 c025 00000000"),
    ("0506 d9892489", 2, "0506 d9892489"),
    ("0506 00000000", 3, "0506 33333333"),
    ("0504 1234", 3, "0506 33333333"),
    ("0702 0802", 2, "0702 0802"),
    ("0703 01", 3, "0702"),
    ("0903 01", 4, "0903 01"),  # FCS alternatives, RFC 1570
    ("0d03 06", 4, "0d03 06"),  # callback, as Windows asks for it
    ("1104 05dc 1202 130901 000102030405", 4, "1104 05dc 1202 130901 000102030405"),  # multilink, RFC 1990
    ("0104 0001 6303 aa 0702", 4, "6303 aa"),  # a reject comes before every other opinion
    ("0702 0104 0001 0204 0000 0802", 3, "0104 05dc 0206 00000000"),
]


@pytest.mark.parametrize(("options", "code", "answer"), ANSWERS)
def test_option_of_the_peer_is_answered(bench: PppBench, options: str, code: int, answer: str) -> None:
    (frame,) = bench.hear(asked(options))
    assert frame == spaced(f"c021{code:02x}07{4 + len(bytes.fromhex(answer)):04x}" + answer)


@pytest.mark.parametrize("options", ["01", "0100", "0101", "0105 05dc", "0702 08"])
def test_request_with_an_impossible_option_is_dropped(bench: PppBench, options: str) -> None:
    assert bench.hear(asked(options)) == []


@pytest.mark.parametrize("text", ["c021", "c021 01", "c021 01 01 00", "c021 01 01 0003", "c021 01 01 0005"])
def test_packet_with_an_impossible_length_is_dropped(bench: PppBench, text: str) -> None:
    assert bench.hear(text) == []


def test_padding_after_a_packet_is_ignored(bench: PppBench) -> None:
    assert bench.hear("c021 01 07 0004 00 00 00") == [spaced("c021 02 07 0004")]


@pytest.mark.manual("PD-259")
@pytest.mark.parametrize(
    "demand", ["0305 c223 05", "0305 c223 80", "0305 c223 81", "0304 c227", "0302", "0306 c023 0000"]
)
def test_demand_of_an_encrypted_password_is_answered_with_pap(demand: str) -> None:
    bench = PppBench(CALLER_END).up()
    bench.take()
    assert code_and_options(bench.hear(asked(demand))) == (3, spaced("0304 c023"))


def test_refused_proposal_is_rejected_after_five_times() -> None:
    bench = PppBench(CALLER_END).up()
    bench.take()
    answers = [code_and_options(bench.hear(asked("0305 c223 05 0104 0001")))[0] for _ in range(6)]
    assert answers == [3] * 5 + [4]
    assert code_and_options(bench.hear(asked("0305 c223 05 0104 0001"))) == (4, spaced("0305 c223 05 0104 0001"))


# Answers of the peer to our request.


def test_refused_options_are_changed_or_left_out(bench: PppBench) -> None:
    (again,) = bench.hear("c021 03 01 0010 0206 000a0000 0506 12345678")
    assert again == spaced("c021 01 02 0018 0206 000a0000 0304 c023 0506 33333333 0702 0802")
    (again,) = bench.hear("c021 04 02 0010 0506 33333333 0702 0206 000a0000".replace("0010", "0012"))
    assert again == spaced("c021 01 03 000a 0304 c023 0802")


@pytest.mark.parametrize(
    "answer",
    [
        "c021 02 02 0018" + REQUEST,  # another identifier
        "c021 02 01 0016 0206 00000000 0304 c023" + MAGIC + "0702",  # not all options
        "c021 02 01 0018 0206 00000000 0304 c023" + MAGIC + "0802 0702",  # another order
        "c021 04 01 0008 0104 05dc",  # an option that was not asked for
        "c021 04 01 0004",  # none
        "c021 04 01 0006 0703",  # an impossible option
        "c021 03 02 000a 0506 12345678",
    ],
)
def test_answer_to_another_request_is_dropped(bench: PppBench, answer: str) -> None:
    assert bench.hear(answer) == []
    assert bench.wait_s(2.9) == []
    assert bench.wait_s(0.1) == [spaced("c021 01 01 0018" + REQUEST)]


def test_mru_other_than_1500_is_asked_for() -> None:
    bench = PppBench(PppSettings(mru=576)).up()
    assert bench.take() == [spaced("c021 01 01 0018 0104 0240 0206 00000000" + MAGIC + "0702 0802")]
    assert bench.hear("c021 03 01 0008 0104 0200") == [
        spaced("c021 01 02 0018 0104 0200 0206 00000000" + MAGIC + "0702 0802")
    ]
    assert bench.hear("c021 03 02 0008 0104 0001") == [spaced("c021 01 03 0014 0206 00000000" + MAGIC + "0702 0802")]


@pytest.mark.parametrize("mru", [0, 127, 1501])
def test_impossible_mru_is_refused(mru: int) -> None:
    with pytest.raises(ValueError, match="expected 128 to 1500"):
        PppSettings(mru=mru)


def test_peer_that_rejects_the_login_is_not_let_in(bench: PppBench) -> None:
    bench.hear(asked("0506 aabbccdd"))
    sent = bench.hear("c021 04 01 0008 0304 c023")
    assert spaced("c021 05 03 0004") in sent
    assert bench.phase() is Phase.TERMINATE
    bench.hear("c021 06 03 0004")
    assert (bench.phase(), bench.link.ended_by) == (Phase.DEAD, End.NO_AUTHENTICATION)


@pytest.mark.manual("PD-259")
def test_peer_that_insists_on_chap_is_not_let_in(bench: PppBench) -> None:
    requests = [spaced("c021 01 01 0018" + REQUEST)]
    for number in range(1, 6):
        requests += bench.hear(f"c021 03 {number:02x} 0009 0305 c223 05")
    assert [request[12:] for request in requests] == [spaced(REQUEST)] * 6  # always PAP
    bench.hear("c021 03 06 0009 0305 c223 05")
    assert bench.link.ended_by is End.NO_AUTHENTICATION


# Time.


def test_request_is_repeated_every_3_s_and_10_times(bench: PppBench) -> None:
    assert bench.wait_s(29) == [spaced("c021 01 01 0018" + REQUEST)] * 9
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
