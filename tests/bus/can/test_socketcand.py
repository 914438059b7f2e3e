"""Commands and answers from the examples of socketcand's doc/protocol.md, and the client of python-can."""

import asyncio
from pathlib import Path
from typing import Any

import can
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from in_loop import in_loop
from patience import PATIENCE_S
from segments import segments

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.hub.hub import LocalHub
from fieldrig.loop.real_clock import RealClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.hub import CanHub, CanHubSettings
from fieldrig_bus.can.notices import BusState, CanError, CanState, ErrorKind, Notice
from fieldrig_bus.can.socketcand import LONGEST_COMMAND, Session, SocketcandPort

FRAME = CanFrame(0x123, bytes.fromhex("11223344"))


class Bench:
    """A session on bus can0, the text that it wrote, and a clock that begins at 23.424242 s."""

    def __init__(self, *commands: str) -> None:
        self.clock = VirtualClock()
        self.link = RecordedLink[Any]()
        self.written: list[bytes] = []
        self.is_closed = False
        self.session = Session(self.clock, self.link, "can0", self.written.append, self.close, 23_424_242_000)
        for command in commands:
            self.say(command)
        self.take()

    def close(self) -> None:
        self.is_closed = True

    def say(self, command: str) -> str:
        self.session.receive(command.encode("latin-1"))
        return self.take()

    def take(self) -> str:
        text = b"".join(self.written).decode()
        self.written.clear()
        return text

    def hear(self, frame: CanFrame | Notice) -> str:
        self.link.deliver(frame)
        return self.take()

    def after(self, until_ns: int) -> str:
        self.clock.advance_to(until_ns)
        return self.take()


@pytest.fixture
def raw() -> Bench:
    return Bench("< open can0 >", "< rawmode >", "< echo >")


@pytest.fixture
def bcm() -> Bench:
    return Bench("< open can0 >")


def test_greeting_and_the_way_into_raw_mode() -> None:
    bench = Bench()
    bench.session = Session(bench.clock, bench.link, "can0", bench.written.append, bench.close)
    assert bench.take() == "< hi >"
    assert bench.say("<open can0>") == "< ok >"
    assert bench.say("< rawmode >") == "< ok >"
    assert bench.say("< bcmmode >") == "< ok >"
    assert bench.say("< controlmode >") == "< ok >"


def test_wrong_bus_ends_the_connection() -> None:
    bench = Bench()
    assert bench.say("< open can1 >< open can0 >") == "< error could not open bus >"
    assert bench.is_closed


@pytest.mark.parametrize("command", ["< can0 B 250000 0.875 0 0 0 0 0 0 >", "< can0 C 1 0 0 >"])
def test_bus_can_not_be_configured_from_outside(command: str) -> None:
    bench = Bench()
    assert bench.say(command) == "< error configuring interface can0 >"
    assert bench.is_closed


@pytest.mark.parametrize("command", ["< isotpmode >", "< >", "<>", "< nonsense 1 2 >", "< open can0 >", "< \xff\x00 >"])
def test_unknown_command_is_named_so_and_the_connection_stays(raw: Bench, command: str) -> None:
    assert raw.say(command) == "< error unknown command >"
    assert raw.say("< echo >") == "< echo >"


@pytest.mark.parametrize(
    "between", ["POST / HTTP/1.1\r\n", "post / http/1.1\r\n", "QUERY / HTTP/1.1\r\n", "x", "\xff", ">"]
)
def test_what_is_no_command_ends_the_connection_before_any_other_command(raw: Bench, between: str) -> None:
    raw.say(f"{between}< echo >")
    assert raw.is_closed
    assert raw.take() == ""


SENT = [
    ("< send 123 0 >", CanFrame(0x123)),
    ("< send 1AAAAAAA 2 1 F1 >", CanFrame(0x1AAAAAAA, b"\x01\xf1", is_extended=True)),
    ("< send 00000123 1 aB >", CanFrame(0x123, b"\xab", is_extended=True)),
    ("<send 7FF 8 11 22 33 44 55 66 77 88>", CanFrame(0x7FF, bytes.fromhex("1122334455667788"))),
    ("< sendrtr 123 0 >", CanFrame(0x123, is_remote=True)),
    ("< sendrtr 1AAAAAAA 2 >", CanFrame(0x1AAAAAAA, is_extended=True, is_remote=True, remote_length=2)),
]


@pytest.mark.parametrize(("command", "frame"), SENT)
@pytest.mark.parametrize("mode", ["raw", "bcm"])
def test_send(mode: str, command: str, frame: CanFrame, request: pytest.FixtureRequest) -> None:
    bench: Bench = request.getfixturevalue(mode)
    assert bench.say(command) == ""
    assert bench.link.sent == [frame]


def test_send_fd_pads_to_a_length_that_a_dlc_can_say(raw: Bench) -> None:
    raw.say("< fdsend 123 1 9 1 2 3 4 5 6 7 8 9 >< fdsend 1AAAAAAA 0 1 FF >")
    assert raw.link.sent == [
        CanFrame(0x123, bytes.fromhex("010203040506070809000000"), is_fd=True, is_bit_rate_switched=True),
        CanFrame(0x1AAAAAAA, b"\xff", is_extended=True, is_fd=True),
    ]


@pytest.mark.parametrize(
    "command",
    [
        "< send >",
        "< send 123 >",
        "< send 123 9 1 2 3 4 5 6 7 8 9 >",
        "< send 123 2 1 >",
        "< send 123 1 1 2 >",
        "< send 123 1 100 >",
        "< send 123 1 -1 >",
        "< send 800 0 >",
        "< send 20000000 0 >",
        "< send 1_2 0 >",
        "< send xyz 0 >",
        "< send 123 1 1_0 >",
        "< sendrtr 123 9 >",
        "< fdsend 123 0 65 " + "0 " * 65 + ">",
    ],
)
def test_wrong_parameters_are_dropped_without_a_word(raw: Bench, command: str) -> None:
    assert raw.say(command) == ""
    assert raw.link.sent == []
    assert not raw.is_closed


HEARD = [
    (FRAME, "< frame 123 23.424242 11223344 >"),
    (CanFrame(0x123), "< frame 123 23.424242  >"),
    (CanFrame(0x1, b"\x0a", is_extended=True), "< frame 00000001 23.424242 0A >"),
    (CanFrame(0x123, is_remote=True, remote_length=4), "< rtr 123 23.424242 4 >"),
    (CanFrame(0x123, b"\x01", is_fd=True), "< fdframe 123 00 23.424242 01 >"),
    (CanFrame(0x123, b"", True, False, 0, True, True), "< fdframe 00000123 01 23.424242  >"),
]


@pytest.mark.parametrize(("frame", "text"), HEARD)
def test_raw_mode_tells_every_frame(raw: Bench, frame: CanFrame, text: str) -> None:
    assert raw.link.interest == [(0, 0), "errors", "state"]
    assert raw.hear(frame) == text


def test_raw_mode_tells_errors_by_their_class(raw: Bench) -> None:
    """linux/can/error.h: ACK 020, BUSERROR 080 and CNT 200; BUSOFF 040 and CNT 200."""
    error = CanError(ErrorKind.ACK, Place.ACK, 41, 0, True, False, 8, 0)
    assert raw.hear(error) == "< error 2A0 23.424242 >"
    assert raw.hear(BusState(CanState.BUS_OFF, 256, 0)) == "< error 240 23.424242 >"


def test_frames_are_held_until_the_client_has_read_the_ok() -> None:
    bench = Bench("< open can0 >")
    assert bench.say("< rawmode >") == "< ok >"
    assert bench.hear(FRAME) == ""
    assert bench.after(20 * MS) == "< frame 123 23.424242 11223344 >"
    bench.say("< bcmmode >< rawmode >")
    assert bench.hear(FRAME) == ""
    assert bench.say("< echo >") == "< frame 123 23.444242 11223344 >< echo >"
    assert bench.hear(FRAME) == "< frame 123 23.444242 11223344 >"


def test_cyclic_job_starts_at_once_and_keeps_its_beat_when_updated(bcm: Bench) -> None:
    bcm.say("< add 0 20000 123 4 42 42 42 42 >")
    assert bcm.link.take() == [CanFrame(0x123, b"\x42\x42\x42\x42")]
    bcm.clock.advance_to(30 * MS)
    assert len(bcm.link.take()) == 1
    bcm.say("< update 123 3 11 22 33 >")
    bcm.clock.advance_to(40 * MS - 1)
    assert bcm.link.take() == []
    bcm.clock.advance_to(60 * MS)
    assert bcm.link.take() == 2 * [CanFrame(0x123, b"\x11\x22\x33")]
    bcm.say("< delete 123 >")
    bcm.clock.advance_to(S)
    assert bcm.link.take() == []


def test_adding_a_job_again_replaces_it_and_interval_0_sends_once(bcm: Bench) -> None:
    bcm.say("< add 1 0 123 0 >< add 1 0 00000123 0 >< add 0 0 123 1 1 >")
    assert [frame.data for frame in bcm.link.take()] == [b"", b"", b"\x01"]
    bcm.clock.advance_to(S)
    assert bcm.link.take() == [CanFrame(0x123, is_extended=True)]


def test_update_and_delete_of_what_is_not_there_do_nothing(bcm: Bench) -> None:
    assert bcm.say("< update 123 1 1 >< delete 123 >< unsubscribe 123 >") == ""
    assert bcm.link.sent == []


@pytest.mark.parametrize("end", ["< rawmode >", "< controlmode >", "the client leaves"])
def test_jobs_and_subscriptions_end_with_the_mode(bcm: Bench, end: str) -> None:
    bcm.say("< add 0 1000 123 0 >< subscribe 0 5000 123 >")
    bcm.hear(FRAME)
    bcm.hear(FRAME)
    bcm.link.take()
    if end.startswith("<"):
        assert bcm.say(end) == "< ok >"
    else:
        bcm.session.end()
    assert bcm.after(S) == ""
    assert bcm.link.sent == []


def test_subscription_tells_every_frame_of_its_identifier(bcm: Bench) -> None:
    bcm.say("< subscribe 0 0 123 >")
    assert bcm.link.interest == [(0x123, 0xDFFFFFFF)]
    assert bcm.hear(FRAME) == bcm.hear(FRAME) == "< frame 123 23.424242 11 22 33 44 >"
    others = (
        CanFrame(0x124),
        CanFrame(0x123, is_extended=True),
        CanFrame(0x123, is_remote=True),
        CanFrame(0x123, is_fd=True),
    )
    assert [bcm.hear(frame) for frame in others] == ["", "", "", ""]
    bcm.say("< unsubscribe 123 >")
    assert bcm.link.interest == []
    assert bcm.hear(FRAME) == ""


def test_subscription_is_throttled_to_its_interval_with_the_latest_frame(bcm: Bench) -> None:
    bcm.say("< subscribe 0 100000 123 >")
    assert bcm.hear(CanFrame(0x123, b"\x01")) == "< frame 123 23.424242 01 >"
    bcm.clock.advance_to(10 * MS)
    assert bcm.hear(CanFrame(0x123, b"\x02")) == ""
    assert bcm.hear(CanFrame(0x123, b"\x03")) == ""
    assert bcm.after(100 * MS) == "< frame 123 23.524242 03 >"
    assert bcm.after(150 * MS) == ""
    assert bcm.hear(CanFrame(0x123, b"\x04")) == ""
    assert bcm.after(200 * MS) == "< frame 123 23.624242 04 >"
    assert bcm.after(500 * MS) == ""
    assert bcm.hear(CanFrame(0x123, b"\x05")) == "< frame 123 23.924242 05 >"


def test_filter_tells_changes_in_its_mask_only(bcm: Bench) -> None:
    bcm.say("< filter 0 0 123 8 FF 00 F8 00 00 00 00 00 >")
    assert bcm.hear(CanFrame(0x123, bytes.fromhex("010203")))
    assert not bcm.hear(CanFrame(0x123, bytes.fromhex("01ff04")))
    assert bcm.hear(CanFrame(0x123, bytes.fromhex("01ff08")))
    assert bcm.hear(CanFrame(0x123, bytes.fromhex("02ff08")))
    assert not bcm.hear(CanFrame(0x123))


def test_muxfilter_tells_changes_by_page(bcm: Bench) -> None:
    bcm.say("< muxfilter 0 0 123 3 FF 00 00 00 00 00 00 00 33 FF 00 00 00 00 00 00 44 00 FF 00 00 00 00 00 >")
    assert bcm.hear(CanFrame(0x123, bytes.fromhex("330100")))
    assert bcm.hear(CanFrame(0x123, bytes.fromhex("440001")))
    assert not bcm.hear(CanFrame(0x123, bytes.fromhex("330101")))
    assert not bcm.hear(CanFrame(0x123, bytes.fromhex("440101")))
    assert not bcm.hear(CanFrame(0x123, bytes.fromhex("55ffff")))
    assert bcm.hear(CanFrame(0x123, bytes.fromhex("330200")))


@pytest.mark.parametrize(
    "command",
    [
        "< subscribe 0 0 >",
        "< filter 0 >",
        "< filter 0 0 123 1 >",
        "< muxfilter 0 0 123 1 1 >",
        "< add 1 0 >",
        "< add >",
    ],
)
def test_wrong_parameters_of_the_broadcast_manager_are_dropped(bcm: Bench, command: str) -> None:
    assert bcm.say(command) == ""
    assert bcm.link.interest == []


def test_statistics_come_at_their_interval_until_switched_off() -> None:
    bench = Bench("< open can0 >", "< send 123 2 1 2 >", "< controlmode >")
    assert bench.link.interest is None
    assert bench.say("< statistics 1000 >") == ""
    bench.hear(FRAME)
    assert bench.after(S) == "< stat 4 1 2 1 >"
    assert bench.after(3 * S) == 2 * "< stat 4 1 2 1 >"
    bench.say("< statistics 0 >")
    assert bench.after(9 * S) == ""


def test_command_without_end_ends_the_connection(raw: Bench) -> None:
    assert raw.say("< send " + "0" * LONGEST_COMMAND) == ""
    assert raw.is_closed


WORDS = ["open", "can0", "send", "add", "delete", "filter", "muxfilter", "subscribe", "statistics", "0", "1", "123"]
words = st.one_of(
    st.sampled_from([*WORDS, "rawmode", "bcmmode", "controlmode", "fdsend", "sendrtr", "1AAAAAAA", "FF", "8"]),
    st.text("0123456789abcxF_-+ é", max_size=4),
)
commands = st.lists(words, max_size=8).map(lambda each: "< " + " ".join(each) + " >")


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.lists(commands | st.text(max_size=20), max_size=20))
def test_no_input_raises(texts: list[str]) -> None:
    bench = Bench("< open can0 >")
    for text in texts:
        bench.session.receive(text.encode())
        bench.hear(FRAME)
    bench.clock.advance_to(S // 100)
    bench.session.end()
    bench.clock.advance_to(S // 50)


@settings(max_examples=50, deadline=None)
@given(st.binary(max_size=300))
def test_random_bytes_never_raise(data: bytes) -> None:
    bench = Bench("< open can0 >", "< rawmode >")
    bench.session.receive(data)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(commands, max_size=6), st.lists(st.integers(0, 200), max_size=8))
def test_segments_make_no_difference(texts: list[str], cuts: list[int]) -> None:
    stream = "".join(["< open can0 >", *texts, *(command for command, _ in SENT)]).encode()
    whole, parts = Bench(), Bench()
    whole.session.receive(stream)
    for segment in segments(stream, cuts):
        parts.session.receive(segment)
    assert parts.take() == whole.take()
    assert parts.link.sent == whole.link.sent


@pytest.mark.system
@in_loop
async def test_python_can_joins_sends_and_hears(tmp_path: Path) -> None:
    clock = RealClock(asyncio.get_running_loop())
    hub = LocalHub(CanHub("can0", CanHubSettings.model_validate({})), clock, tmp_path)
    port = SocketcandPort("127.0.0.1:0", "can0")
    await port.open(hub)
    node = hub.join("node")
    heard = asyncio.Queue[CanFrame]()
    node.on_receive(heard.put_nowait)

    def join() -> can.BusABC:
        return can.Bus(interface="socketcand", host="127.0.0.1", port=port.port, channel="can0")

    first, second = await asyncio.to_thread(join), await asyncio.to_thread(join)
    first.send(can.Message(arbitration_id=0x123, data=[1, 0xF1], is_extended_id=False))
    first.send(can.Message(arbitration_id=0x123, is_extended_id=True))
    async with asyncio.timeout(PATIENCE_S):
        assert await heard.get() == CanFrame(0x123, b"\x01\xf1")
        assert await heard.get() == CanFrame(0x123, is_extended=True)
    node.send(CanFrame(0x1, b"\xff\x00", is_extended=True))
    node.send(CanFrame(0x7FF))

    def receive(bus: can.BusABC, count: int) -> list[tuple[int, bool, bytes]]:
        messages = [bus.recv(10) for _ in range(count)]
        return [(each.arbitration_id, each.is_extended_id, bytes(each.data)) for each in messages if each]

    from_node = [(1, True, b"\xff\x00"), (0x7FF, False, b"")]
    from_first = [(0x123, False, b"\x01\xf1"), (0x123, True, b"")]
    assert await asyncio.to_thread(receive, first, 2) == from_node
    assert await asyncio.to_thread(receive, second, 4) == from_first + from_node
    with pytest.raises(ValueError, match="socketcand:2"):
        hub.join("socketcand:2")
    first.shutdown()
    second.shutdown()
    await port.close()
    hub.join("socketcand:1")  # both names are free again
    hub.join("socketcand:2")
    await hub.close()
    clock.close()
