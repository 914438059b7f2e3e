"""Commands and answers of the Lawicel CAN232 manual 3.0, and the client of python-can."""

import asyncio
import threading
from pathlib import Path

import can
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from in_loop import in_loop
from patience import PATIENCE_S
from segments import segments

from fieldrig.clock import MS, VirtualClock
from fieldrig.hub.hub import LocalHub
from fieldrig.loop.real_clock import RealClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame
from fieldrig_bus.can.hub import CanHub, CanHubSettings
from fieldrig_bus.can.lawicel import MOST_WAITING, Adapter, LawicelPort, decode, encode
from fieldrig_bus.can.notices import BusState, CanControl, CanError, CanState, ErrorKind, Notice

FRAME = CanFrame(0x123, bytes.fromhex("11223344"))


class Bench:
    def __init__(self, commands: str = "") -> None:
        self.clock = VirtualClock()
        self.link = RecordedLink[CanFrame | Notice]()
        self.written: list[bytes] = []
        self.adapter = Adapter(self.clock, self.link, self.written.append)
        self.say(commands)

    def say(self, commands: str) -> str:
        self.adapter.receive(commands.encode("latin-1"))
        return self.take()

    def hear(self, frame: CanFrame) -> str:
        self.link.deliver(frame)
        return self.take()

    def take(self) -> str:
        text = b"".join(self.written).decode()
        self.written.clear()
        return text


@pytest.fixture
def opened() -> Bench:
    return Bench("S6\rO\r")


def test_session_of_the_manual() -> None:
    bench = Bench()
    assert bench.say("\r\r\r") == "\r\r\r"
    assert bench.say("V\r") == "V1325\r"
    assert bench.say("N\r") == "NF001\r"
    assert bench.say("S6\r") == "\r"
    assert bench.say("O\r") == "\r"
    assert bench.say("t10021133\r") == "z\r"
    assert bench.link.sent == [CanFrame(0x100, b"\x11\x33")]
    assert bench.say("C\r") == "\r"
    assert bench.link.interest == []


STATES = {"new": "", "with bit rate": "S6\r", "open": "S6\rO\r", "listening": "S6\rL\r", "closed": "S6\rO\rC\r"}

CLOSED = "new, with bit rate, closed"

# command: states in which it is active
ACTIVE = {
    "S0": CLOSED,
    "S8": CLOSED,
    "s031C": CLOSED,
    "O": CLOSED,
    "L": CLOSED,
    "C": "open, listening",
    "t1000": "open",
    "T000001000": "open",
    "r1000": "open",
    "R000001000": "open",
    "d1000": "open",
    "F": "open, listening",
    "X1": CLOSED,
    "W0": CLOSED,
    "M00000000": CLOSED,
    "mFFFFFFFF": CLOSED,
    "U1": CLOSED,
    "Z1": CLOSED,
    "V": "open, listening, " + CLOSED,
    "N": "open, listening, " + CLOSED,
}


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("command", ACTIVE)
def test_command_is_active_in_the_states_of_the_manual(command: str, state: str) -> None:
    answer = Bench(STATES[state]).say(command + "\r")
    assert (answer != "\a") == (state in ACTIVE[command].split(", "))


@pytest.mark.parametrize(
    "command",
    [
        "S",
        "S9",
        "S66",
        "s03",
        "s03xx",
        "X2",
        "X",
        "W2",
        "M0",
        "mFFFFFFFG",
        "Z",
        "Z2",
        "U7",
        "V1",
        "N ",
        "Q1",
        "?",
        "\n",
        "é",
    ],
)
def test_malformed_command_is_answered_by_bell(command: str) -> None:
    assert Bench("S6\r").say(command + "\r") == "\a"


@pytest.mark.parametrize(
    "command",
    [
        "t", "t10", "t100", "t1001", "t10011", "t1001112", "t100011", "t8000", "t1009112233445566778899", "tx000",
        "t100 0", "t1_00", "t0x10", "t+100", "T200000000", "T1000", "r1009", "r100111", "r1000 ", "rF000", "RFFFFFFFF0",
        "d100911", "d100G", "O1", "C1", "L", "F0", "t100111\n",
    ],
)  # fmt: skip
def test_malformed_frame_is_answered_by_bell_and_not_sent(opened: Bench, command: str) -> None:
    assert opened.say(command + "\r") == "\a"
    assert opened.link.sent == []


# On the line, and the frame: the first three of the manual, the others of Linux' slcan.c and of CANable.
FRAMES = [
    ("t10021133", CanFrame(0x100, b"\x11\x33")),
    ("T0000010021133", CanFrame(0x100, b"\x11\x33", is_extended=True)),
    ("r1002", CanFrame(0x100, is_remote=True, remote_length=2)),
    ("R000001002", CanFrame(0x100, is_extended=True, is_remote=True, remote_length=2)),
    ("t1230", CanFrame(0x123)),
    ("t4563112233", CanFrame(0x456, b"\x11\x22\x33")),
    ("T12ABCDEF2AA55", CanFrame(0x12ABCDEF, b"\xaa\x55", is_extended=True)),
    ("d1009000102030405060708090A0B", CanFrame(0x100, bytes(range(12)), is_fd=True)),
    ("D1ABCDEF01FF", CanFrame(0x1ABCDEF0, b"\xff", is_extended=True, is_fd=True)),
    ("b7FFF" + "00" * 64, CanFrame(0x7FF, bytes(64), is_fd=True, is_bit_rate_switched=True)),
    ("B000000000", CanFrame(0, is_extended=True, is_fd=True, is_bit_rate_switched=True)),
]


@pytest.mark.parametrize(("line", "frame"), FRAMES)
def test_frames_are_sent_and_confirmed(opened: Bench, line: str, frame: CanFrame) -> None:
    assert opened.say(line + "\r") == ("z\r" if line[0].islower() else "Z\r")
    assert opened.link.sent == [frame]


@pytest.mark.parametrize(("line", "frame"), FRAMES)
def test_frames_are_heard(opened: Bench, line: str, frame: CanFrame) -> None:
    assert opened.hear(frame) == line + "\r"


def test_channel_hears_everything_while_it_is_open_and_nothing_before() -> None:
    bench = Bench("S6\r")
    assert bench.hear(FRAME) == ""
    bench.say("L\r")
    assert bench.link.interest == [(0, 0), "errors", "state"]
    assert bench.hear(FRAME) == "t123411223344\r"
    bench.say("C\r")
    assert bench.link.interest == []


def test_without_auto_poll_frames_wait_to_be_polled() -> None:
    bench = Bench("X0\rS6\rO\r")
    assert bench.say("P\rA\r") == "\rA\r"
    assert bench.say("t1000\r") == "\r"
    assert [bench.hear(CanFrame(each)) for each in (1, 2, 3)] == ["", "", ""]
    assert bench.say("P\r") == "t0010\r"
    assert bench.say("A\r") == "t0020\rt0030\rA\r"


def test_with_auto_poll_polling_is_answered_by_bell(opened: Bench) -> None:
    assert opened.say("P\rA\r") == "\a\a"


def test_queue_that_is_full_is_a_status_flag_until_it_is_read() -> None:
    bench = Bench("X0\rS6\rO\r")
    for _ in range(MOST_WAITING):
        bench.hear(FRAME)
    assert bench.say("F\r") == "F00\r"
    bench.hear(FRAME)
    assert bench.say("F\rF\r") == "F09\rF00\r"
    assert bench.say("A\r") == "t123411223344\r" * MOST_WAITING + "A\r"


def test_timestamps_are_milliseconds_and_wrap_after_a_minute() -> None:
    bench = Bench("Z1\rS6\rO\r")
    assert bench.hear(CanFrame(0x100)) == "t10000000\r"
    bench.clock.instant_ns = 59_999 * MS
    assert bench.hear(CanFrame(0x100)) == "t1000EA5F\r"
    bench.clock.instant_ns = 60_001 * MS
    assert bench.hear(CanFrame(0x100)) == "t10000001\r"


def heard_through(commands: str, *frames: CanFrame) -> list[bool]:
    bench = Bench(f"S6\r{commands}O\r")
    return [bool(bench.hear(frame)) for frame in frames]


def test_dual_filter_lets_pass_what_either_half_accepts() -> None:
    # SJA1000 figure 11: identifier in the upper 11 bits of each half, RTR below; the rest don't care
    frames = CanFrame(0x300), CanFrame(0x70F), CanFrame(0x301), CanFrame(0x300, is_remote=True)
    assert heard_through("M6000E1E0\rm000F000F\r", *frames) == [True, True, False, False]
    assert heard_through("M6000E1E0\rm001F001F\r", *frames) == [True, True, False, True]


def test_dual_filter_looks_at_the_first_byte_with_its_first_half() -> None:
    # ACR1.3-0 and ACR3.3-0 are the nibbles of data byte 1; the second half accepts identifier 0x7FF only
    frames = CanFrame(0x300, b"\x5a"), CanFrame(0x300, b"\x5b"), CanFrame(0x300), CanFrame(0x7FF, b"\x00")
    assert heard_through("M6005FFEA\rm00000000\r", *frames) == [True, False, True, True]


def test_dual_filter_looks_at_the_upper_16_bits_of_an_extended_identifier() -> None:
    frames = CanFrame(0x12340000 >> 3, is_extended=True), CanFrame(0x12341FFF >> 3, is_extended=True)
    other = CanFrame(0x12350000 >> 3, is_extended=True)
    assert heard_through("M1234FFFF\rm00000000\r", *frames, other) == [True, True, False]


def test_single_filter_looks_at_identifier_and_two_bytes() -> None:
    frames = CanFrame(0x300, b"\x12\x34\x56"), CanFrame(0x300, b"\x12\x35"), CanFrame(0x300, b"\x12"), CanFrame(0x301)
    assert heard_through("W1\rM60001234\rm000F0000\r", *frames) == [True, False, True, False]
    extended = CanFrame(0x300, b"\x12", is_extended=True), CanFrame(0x301, is_extended=True)
    assert heard_through("W1\rM00001800\rm00000007\r", *extended) == [True, False]


def test_command_that_is_too_long_is_answered_once_when_it_ends(opened: Bench) -> None:
    assert opened.say("t100" + "0" * 1000) == ""
    assert opened.say("0" * 1000 + "\rt1000\r") == "\az\r"


@st.composite
def frames(draw: st.DrawFn) -> CanFrame:
    size = draw(st.sampled_from(FD_LENGTHS))
    is_fd = size > 8 or draw(st.booleans())
    is_extended = draw(st.booleans())
    return CanFrame(
        draw(st.integers(0, 0x1FFFFFFF if is_extended else 0x7FF)),
        draw(st.binary(min_size=size, max_size=size)),
        is_extended,
        is_fd=is_fd,
        is_bit_rate_switched=is_fd and draw(st.booleans()),
    )


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(frames())
def test_what_is_encoded_is_decoded(frame: CanFrame) -> None:
    assert decode(encode(frame)) == frame


lines = st.one_of(
    st.sampled_from([*ACTIVE, *(line for line, _ in FRAMES), "P", "A", "X0", ""]),
    st.text("0123456789ABCDEFSsOLCtTrRdDbBPAFXWMmVNZUY \n\a", max_size=20),
)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.lists(lines | st.text(max_size=20), max_size=20))
def test_no_input_raises_and_every_command_is_answered(texts: list[str]) -> None:
    bench = Bench("S6\rO\r")
    for text in texts:
        bench.adapter.receive(text.encode() + b"\r")
        assert bench.take()[-1] in "\r\a"
        bench.hear(FRAME)


@settings(max_examples=50, deadline=None)
@given(st.binary(max_size=300))
def test_random_bytes_never_raise(data: bytes) -> None:
    Bench("S6\rO\r").adapter.receive(data)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(lines, max_size=10), st.lists(st.integers(0, 400), max_size=8))
def test_segments_make_no_difference(texts: list[str], cuts: list[int]) -> None:
    stream = "".join(line + "\r" for line in ["S6", "O", *texts]).encode()
    whole, parts = Bench(), Bench()
    whole.adapter.receive(stream)
    for segment in segments(stream, cuts):
        parts.adapter.receive(segment)
    assert parts.take() == whole.take()
    assert parts.link.sent == whole.link.sent


@pytest.mark.system
@pytest.mark.parametrize("way", ["pty", "tcp"])
@in_loop
async def test_python_can_joins_sends_and_hears(way: str, tmp_path: Path) -> None:
    clock = RealClock(asyncio.get_running_loop())
    hub = LocalHub(CanHub("can0", CanHubSettings.model_validate({})), clock, tmp_path)
    port = LawicelPort("can0", "slcan0" if way == "pty" else None, "127.0.0.1:0" if way == "tcp" else None)
    await port.open(hub)
    channel = str(tmp_path / "slcan0") if way == "pty" else f"socket://127.0.0.1:{port.port}"
    node = hub.join("node")
    heard = asyncio.Queue[CanFrame]()
    node.on_receive(heard.put_nowait)

    def join() -> can.BusABC:
        bus = can.Bus(interface="slcan", channel=channel, bitrate=500_000, sleep_after_open=0)
        assert bus.get_version(10) == (13, 25)  # type: ignore[attr-defined]  # it is an slcanBus
        return bus

    bus = await asyncio.to_thread(join)
    bus.send(can.Message(arbitration_id=0x123, data=[1, 0xF1], is_extended_id=False))
    bus.send(can.Message(arbitration_id=0x123, is_remote_frame=True, dlc=3))
    async with asyncio.timeout(PATIENCE_S):
        assert await heard.get() == CanFrame(0x123, b"\x01\xf1")
        assert await heard.get() == CanFrame(0x123, is_extended=True, is_remote=True, remote_length=3)
    node.send(CanFrame(0x1, b"\xff\x00", is_extended=True))
    node.send(CanFrame(0x7FF))

    def receive() -> list[tuple[int, bool, bytes]]:
        messages: list[can.Message] = []
        is_over = threading.Event()
        patience = threading.Timer(10, is_over.set)
        patience.start()
        while len(messages) < 2 and not is_over.is_set():
            message = bus.recv(0.1)  # recv returns None for each confirmation too
            messages += [message] if message else []
        patience.cancel()
        bus.shutdown()
        return [(each.arbitration_id, each.is_extended_id, bytes(each.data)) for each in messages]

    assert await asyncio.to_thread(receive) == [(1, True, b"\xff\x00"), (0x7FF, False, b"")]
    await port.close()
    await hub.close()
    clock.close()
    assert list(tmp_path.iterdir()) == []


# Manual, F: bit 2 error warning, 5 error passive, 6 arbitration lost, 7 bus error.
FLAGS_OF = {
    BusState(CanState.WARNING, 96, 0): b"F04\r",
    BusState(CanState.PASSIVE, 128, 0): b"F20\r",
    CanError(ErrorKind.ARBITRATION_LOST, Place.UNSPECIFIED, 5, 0, True, True, 0, 0): b"F40\r",
    CanError(ErrorKind.ACK, Place.ACK, 41, 0, True, False, 8, 0): b"F80\r",
}


@pytest.mark.parametrize("notice", FLAGS_OF)
def test_errors_of_the_bus_stand_in_the_status_flags_until_they_are_read(notice: BusState | CanError) -> None:
    written: list[bytes] = []
    link = RecordedLink[CanFrame | Notice]()
    adapter = Adapter(VirtualClock(), link, written.append)
    adapter.receive(b"O\r")
    link.deliver(notice)
    adapter.receive(b"F\rF\r")
    assert written == [b"\r", FLAGS_OF[notice], b"F00\r"]


def test_a_channel_that_only_listens_does_not_acknowledge() -> None:
    link = RecordedLink[CanFrame | Notice]()
    adapter = Adapter(VirtualClock(), link, lambda _: None)
    adapter.receive(b"L\rC\rO\r")
    assert link.sent == [CanControl(is_listen_only=True), CanControl(is_listen_only=False)]
