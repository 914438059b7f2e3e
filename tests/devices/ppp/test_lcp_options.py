"""The options of LCP as RFC 1661 chapter 6 and RFC 1662 chapter 7 describe them; bytes by hand from their formats."""

import pytest
from ppp_bench import CALLER_END, LCP_REQUEST, PppBench, asked, content_of, spaced

from fieldrig_devices.ppp.link import PppLink
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import PppSettings

MAGIC = "0506 22222222"


@pytest.fixture
def bench() -> PppBench:
    """The controller's end, whose first request is out."""
    bench = PppBench().up()
    assert bench.take() == [spaced("c021 01 01 0018" + LCP_REQUEST)]
    return bench


def code_and_options(frames: list[str]) -> tuple[int, str]:
    (frame,) = frames
    return int(frame[4:6], 16), frame[12:]


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


def test_request_whose_answer_would_be_too_long_is_dropped(bench: PppBench) -> None:
    (answer,) = bench.hear(asked("0202" * 249))
    assert answer == spaced("c021 03 07 05da" + "0206 00000000" * 249)
    assert bench.hear(asked("0202" * 250)) == []


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
        "c021 02 02 0018" + LCP_REQUEST,  # another identifier
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
    assert bench.wait_s(0.1) == [spaced("c021 01 01 0018" + LCP_REQUEST)]


def test_mru_other_than_1500_is_asked_for() -> None:
    bench = PppBench(PppSettings(mru=576)).up()
    assert bench.take() == [spaced("c021 01 01 0018 0104 0240 0206 00000000" + MAGIC + "0702 0802")]
    assert bench.hear("c021 03 01 0008 0104 0200") == [
        spaced("c021 01 02 0018 0104 0200 0206 00000000" + MAGIC + "0702 0802")
    ]
    assert bench.hear("c021 03 02 0008 0104 0001") == [spaced("c021 01 03 0014 0206 00000000" + MAGIC + "0702 0802")]


def test_magic_number_is_never_zero() -> None:
    frames: list[bytes] = []
    PppLink(PppSettings(), lambda: 0, frames.append, lambda packet: None).up(0)
    assert spaced("0506 00000001") in content_of(frames[0]).hex()


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
    requests = [spaced("c021 01 01 0018" + LCP_REQUEST)]
    for number in range(1, 6):
        requests += bench.hear(f"c021 03 {number:02x} 0009 0305 c223 05")
    assert [request[12:] for request in requests] == [spaced(LCP_REQUEST)] * 6  # always PAP
    bench.hear("c021 03 06 0009 0305 c223 05")
    assert bench.link.ended_by is End.NO_AUTHENTICATION
