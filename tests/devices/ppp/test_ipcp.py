"""IPCP as RFC 1332 chapter 3 describes it, and the lines that pppd 2.4.9 sent with it."""

from ipaddress import IPv4Address

import pytest
from ppp_bench import CALLER, CONTROLLER, PppBench, spaced

from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import PppSettings

OURS = "8021 02 01 000a 0306 bec86464"  # the peer acknowledges 190.200.100.100
PPPD_REQUEST = "8021 0101001c0206002d0f01030600000000810600000000830600000000"
PING = "4500001c00000000400100000a0000010a0000020800000000000000"


@pytest.mark.manual("PD-250", "PD-260")
def test_caller_is_given_its_address_and_a_compression_is_rejected() -> None:
    bench = PppBench().log_in()
    # recorded: pppd with `usepeerdns noipdefault` asks for VJ compression, an address and two name servers
    assert bench.hear(OURS, PPPD_REQUEST) == [spaced("8021 04 01 0016 0206002d0f01 810600000000 830600000000")]
    assert bench.hear("8021 01 02 000a 0306 00000000") == [spaced("8021 03 02 000a 0306 bec86465")]
    assert bench.hear("8021 01 03 000a 0306 bec86465") == [spaced("8021 02 03 000a 0306 bec86465")]
    assert bench.phase() is Phase.RUNNING
    assert (bench.link.local_address, bench.link.peer_address) == (CONTROLLER, CALLER)


# Options of the caller to the controller: code of the answer, and the options in it.
ANSWERS = [
    ("0306 0a000001", 3, "0306 bec86465"),
    ("0304 0a00", 3, "0306 bec86465"),
    ("0306 bec86464", 3, "0306 bec86465"),
    ("", 3, "0306 bec86465"),
    ("010a 0a000001 0a000002 0306 bec86465", 4, "010a 0a000001 0a000002"),
    ("0206 002d0f01 0306 bec86465", 4, "0206 002d0f01"),
    ("0306 bec86465 8206 00000000 8406 00000000", 4, "8206 00000000 8406 00000000"),
    ("0406 0a000001 0306 bec86465", 4, "0406 0a000001"),
]


@pytest.mark.parametrize(("options", "code", "answer"), ANSWERS)
def test_option_of_the_caller_is_answered(options: str, code: int, answer: str) -> None:
    bench = PppBench().log_in()
    asked = f"8021 01 05 {4 + len(bytes.fromhex(options)):04x}" + options
    assert bench.hear(asked) == [spaced(f"8021{code:02x}05{4 + len(bytes.fromhex(answer)):04x}" + answer)]


def test_caller_that_insists_on_another_address_is_rejected() -> None:
    bench = PppBench().log_in()
    codes = [bench.hear("8021 01 05 000a 0306 0a000001")[0][4:6] for _ in range(6)]
    assert codes == ["03"] * 5 + ["04"]


def test_caller_that_wants_no_address_gets_in_after_five_proposals() -> None:
    bench = PppBench().log_in()
    bench.hear(OURS)
    codes = [bench.hear("8021 01 05 0004")[0][4:6] for _ in range(6)]
    assert codes == ["03"] * 5 + ["02"]
    assert bench.link.peer_address == CALLER


@pytest.mark.manual("PD-250", "PD-273")
def test_address_of_the_controller_cannot_be_changed() -> None:
    bench = PppBench().log_in()
    sent = [bench.hear(f"8021 03 {number:02x} 000a 0306 0a000001")[0] for number in range(1, 5)]
    assert [frame[12:] for frame in sent] == [spaced("0306 bec86464")] * 4
    bench.hear("8021 03 05 000a 0306 0a000001")
    assert bench.link.ended_by is End.NO_ADDRESSES


def test_refusal_of_an_option_that_was_not_asked_for_changes_nothing() -> None:
    bench = PppBench().log_in()
    assert bench.hear("8021 03 01 000e 0206002d0f01 0304 0a00") == [spaced("8021 01 02 000a 0306 bec86464")]


def test_peer_that_does_not_want_to_know_our_address_is_served() -> None:
    bench = PppBench().log_in()
    assert bench.hear("8021 04 01 000a 0306 bec86464") == [spaced("8021 01 02 0004")]
    bench.hear("8021 02 02 0004", "8021 01 05 000a 0306 bec86465")
    assert (bench.phase(), bench.link.local_address) == (Phase.RUNNING, CONTROLLER)


def without_login(settings: PppSettings) -> PppBench:
    bench = PppBench(settings).up()
    (request,) = bench.take()
    bench.hear("c02102" + request[6:], "c021 01 07 0004")
    assert bench.phase() is Phase.NETWORK
    return bench


def test_end_without_an_address_takes_the_one_that_it_is_given() -> None:
    bench = without_login(PppSettings())
    # recorded: the request and the answers of pppd as a server, without its VJ compression
    assert bench.hear("8021 03 01 000a 0306 bec86465") == [spaced("8021 01 02 000a 0306 bec86465")]
    bench.hear("8021 0101000a0306bec86464", "8021 02 02 000a 0306 bec86465")
    assert (bench.link.local_address, bench.link.peer_address) == (CALLER, CONTROLLER)


@pytest.mark.parametrize("option", ["8106 0a000001", "0304 0a00"])
def test_proposal_of_anything_but_an_address_is_not_taken_for_one(option: str) -> None:
    bench = without_login(PppSettings())
    length = 4 + len(bytes.fromhex(option))
    assert bench.hear(f"8021 03 01 {length:04x}" + option) == [spaced("8021 01 02 000a 0306 00000000")]


@pytest.mark.parametrize("answer", ["8021 02 01 000a 0306 00000000", "8021 04 01 000a 0306 00000000"])
def test_end_that_is_given_no_address_gives_up(answer: str) -> None:
    bench = without_login(PppSettings())
    bench.hear("8021 01 05 000a 0306 bec86464", answer)
    assert bench.link.ended_by is End.NO_ADDRESSES


def test_address_of_a_peer_without_one_is_rejected_if_there_is_none_to_give() -> None:
    bench = without_login(PppSettings())
    assert bench.hear("8021 01 05 000a 0306 00000000") == [spaced("8021 04 05 000a 0306 00000000")]


def test_ip_packets_pass_in_both_directions() -> None:
    bench = PppBench().run()
    assert bench.hear("0021" + PING) == []
    assert bench.packets == [bytes.fromhex(PING)]
    assert bench.link.send_ip(bench.now_ns, bytes.fromhex(PING))
    assert bench.take() == ["0021" + PING]


def test_packet_longer_than_the_mru_of_the_peer_is_not_sent() -> None:
    bench = PppBench(PppSettings(local_address=CONTROLLER)).up()
    (request,) = bench.take()
    bench.hear("c02102" + request[6:], "c021 01 07 0008 0104 0240", "8021 02 01 000a 0306 bec86464", "8021 01 01 0004")
    assert (bench.link.mtu, bench.phase()) == (576, Phase.RUNNING)
    assert (bench.link.send_ip(0, bytes(577)), bench.take()) == (False, [])
    assert bench.link.send_ip(0, bytes(576))


def test_negotiated_format_is_used_for_what_is_not_lcp() -> None:
    bench = PppBench(PppSettings(local_address=CONTROLLER)).up()
    (request,) = bench.take()
    bench.hear("c02102" + request[6:], "c021 01 07 000e 0206 00000000 0702 0802")
    assert [frame.hex() for frame in bench.line] == []
    bench.hear("8021 02 01 000a 0306 bec86464", "8021 01 01 0004")
    bench.link.send_ip(0, b"\x01\x7e")
    (frame,) = bench.line
    assert frame[:-3] == bytes.fromhex("7e 21 01 7d5e")  # two bytes of the check sequence are left, and the flag


@pytest.mark.parametrize(
    ("end", "reason"), [("8021 05 07 0004", End.PEER_CLOSED), ("8021 07 02 0008 0101 0004", End.PROTOCOL_REJECTED)]
)
def test_end_of_ip_is_the_end_of_the_link(end: str, reason: End) -> None:
    bench = PppBench().run()
    bench.hear(end)
    assert bench.link.ended_by is reason


def test_new_negotiation_of_the_addresses_stops_ip() -> None:
    bench = PppBench().run()
    sent = bench.hear("8021 01 09 000a 0306 bec86465")
    assert [frame[4:6] for frame in sent] == ["01", "02"]
    assert (bench.phase(), bench.link.local_address) == (Phase.NETWORK, IPv4Address(0))
    assert bench.hear("0021" + PING) == []
    assert bench.packets == []
    bench.hear("8021 02" + sent[0][6:])
    assert bench.phase() is Phase.RUNNING
