"""The server of RFC 2217 as bytes in and bytes out.  Expected bytes are from the tables of the RFC."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.serial.com_port import MOST_HELD, ComPort
from fieldrig_bus.serial.end import LineEnd
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage

INVITATION = "ff fb 01 ff fb 03 ff fb 00 ff fd 03 ff fd 00 ff fd 2c"  # WILL echo, SGA, binary; DO SGA, binary, com port


class Bench:
    """The bytes of one client on one side, a line on the other."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.line = RecordedLink[SerialMessage]()
        self.end = LineEnd(self.line, self.clock, Format(), is_paced=False)
        self._written = b""
        self.port = ComPort(self.end, self.clock, self._write)

    def _write(self, data: bytes) -> None:
        self._written += data

    def start(self, lines: ControlLines | None = None) -> "Bench":
        """A session whose client has sent WILL COM-PORT-OPTION."""
        self.port.start(ControlLines() if lines is None else lines)
        self.port.from_client(bytes.fromhex("ff fb 2c"))
        self.written()
        return self

    def client(self, data: str) -> str:
        self.port.from_client(bytes.fromhex(data))
        return self.written()

    def com_port(self, body: str) -> str:
        """The body of the only answer to a subnegotiation of option 44."""
        answer = bytes.fromhex(self.client(f"ff fa 2c {body} ff f0"))
        assert answer[:3] == bytes.fromhex("ff fa 2c")
        assert answer[-2:] == bytes.fromhex("ff f0")
        return answer[3:-2].hex(" ")

    def written(self) -> str:
        written, self._written = self._written, b""
        return written.hex(" ")


@pytest.fixture
def bench() -> Bench:
    return Bench().start()


def test_client_is_invited_and_gets_the_modem_state_when_it_agrees() -> None:
    bench = Bench()
    bench.port.start(ControlLines(rts=False))
    assert bench.written() == INVITATION
    # NOTIFY-MODEMSTATE: DCD and DSR on, and both changed from the state before there was one
    assert bench.client("ff fb 2c") == "ff fa 2c 6b aa ff f0"


def test_client_that_knows_only_telnet_gets_no_notification() -> None:
    bench = Bench()
    bench.port.start(ControlLines())
    bench.client("ff fe 2c ff fc 2c")
    bench.port.from_line(ControlLines(dtr=False))
    assert bench.written() == ""


def test_data_passes_both_ways_with_iac_doubled(bench: Bench) -> None:
    assert bench.client("41 ff ff 42") == ""
    assert bench.line.take() == [b"A\xffB"]
    bench.port.from_line(b"\xff\x00")
    assert bench.written() == "ff ff 00"


# Chapter 2 and 3: request, answer, the end's format afterwards.  9600 is 00 00 25 80, 19200 is 00 00 4b 00.
SETTINGS = [
    ("01 00 00 4b 00", "65 00 00 4b 00", Format(19200)),
    ("01 00 00 00 00", "65 00 00 25 80", Format()),  # asks
    ("01 ff ff ff ff ff ff ff ff", "65 00 00 25 80", Format()),  # no such rate: the present one stays in force
    ("01", "65 00 00 25 80", Format()),
    ("02 07", "66 07", Format(data_bits=7)),
    ("02 00", "66 08", Format()),
    ("02 09", "66 08", Format()),
    ("03 01", "67 01", Format()),
    ("03 02", "67 02", Format(parity="O")),
    ("03 03", "67 03", Format(parity="E")),
    ("03 04", "67 01", Format()),  # mark, which this line does not have
    ("04 02", "68 02", Format(stop_bits=2)),
    ("04 03", "68 01", Format()),  # 1.5
    ("04 00", "68 01", Format()),
]


@pytest.mark.parametrize(("request_", "answer", "form"), SETTINGS)
def test_setting_is_answered_with_what_is_in_force(bench: Bench, request_: str, answer: str, form: Format) -> None:
    assert bench.com_port(request_) == answer
    assert bench.end.form == form
    assert bench.line.take() == ([form] if form != Format() else [])


# Chapter 3, SET-CONTROL: request and answer
CONTROL = [
    ("00", "01"),  # flow control: none
    ("01", "01"),
    ("02", "02"),  # XON/XOFF
    ("03", "03"),
    ("04", "06"),  # break: off
    ("07", "08"),  # DTR: on
    ("09", "09"),
    ("0a", "0b"),  # RTS: on
    ("0c", "0c"),
    ("0d", "0e"),  # inbound flow control: none
    ("0f", "0f"),  # XON/XOFF
    ("10", "0e"),  # hardware, which this line does not have
    ("11", "01"),
    ("12", "0e"),
    ("13", "01"),
]


@pytest.mark.parametrize(("value", "answer"), CONTROL)
def test_control_is_answered_with_what_is_in_force(bench: Bench, value: str, answer: str) -> None:
    assert bench.com_port(f"05 {value}") == f"69 {answer}"


def test_control_lines_reach_the_line(bench: Bench) -> None:
    bench.com_port("05 09")
    bench.com_port("05 0c")
    bench.com_port("05 08")
    assert bench.line.take() == [
        ControlLines(dtr=False),
        ControlLines(dtr=False, rts=False),
        ControlLines(dtr=True, rts=False),
    ]
    assert bench.com_port("05 0a") == "69 0c"


def test_break_lasts_from_on_to_off(bench: Bench) -> None:
    assert bench.com_port("05 05") == "69 05"
    bench.clock.advance_to(250 * MS)
    assert bench.com_port("05 04") == "69 05"
    assert bench.com_port("05 06") == "69 06"
    assert bench.line.take() == [Break(250)]


def test_break_ends_with_the_connection(bench: Bench) -> None:
    bench.com_port("05 05")
    bench.clock.advance_to(40 * MS)
    bench.port.stop()
    assert bench.line.take() == [Break(40)]


# Chapter 4, NOTIFY-MODEMSTATE: lines of the other end, from all on, and the notification
MODEM_STATES = [
    (ControlLines(rts=False), "a1"),  # DCD, DSR; delta CTS
    (ControlLines(dtr=False), "1a"),  # CTS; delta DCD, delta DSR
    (ControlLines(ri=True), "f0"),  # RI begins: no delta
]


@pytest.mark.parametrize(("lines", "state"), MODEM_STATES)
def test_change_of_the_other_end_is_notified(bench: Bench, lines: ControlLines, state: str) -> None:
    bench.port.from_line(lines)
    assert bench.written() == f"ff fa 2c 6b {state} ff f0"
    bench.port.from_line(lines)
    assert bench.written() == ""


def test_end_of_a_ring_is_marked(bench: Bench) -> None:
    bench.port.from_line(ControlLines(ri=True))
    bench.written()
    bench.port.from_line(ControlLines())
    assert bench.written() == "ff fa 2c 6b b4 ff f0"


def test_mask_holds_back_what_the_client_does_not_want(bench: Bench) -> None:
    assert bench.com_port("0b 11") == "6f 11"  # CTS and its delta
    bench.port.from_line(ControlLines(dtr=False))
    assert bench.written() == ""
    bench.port.from_line(ControlLines(rts=False))
    assert bench.written() == "ff fa 2c 6b 01 ff f0"


def test_modem_state_can_be_polled(bench: Bench) -> None:
    assert bench.com_port("07") == "6b b0"


def test_break_on_the_line_is_notified_if_asked_for(bench: Bench) -> None:
    bench.port.from_line(Break(100))
    assert bench.written() == ""
    assert bench.com_port("0a ff ff") == "6e ff ff"  # IAC doubled both ways
    bench.port.from_line(Break(100))
    assert bench.written() == "ff fa 2c 6a 10 ff f0"


def test_suspended_client_gets_nothing_until_it_resumes(bench: Bench) -> None:
    bench.client("ff fa 2c 08 ff f0")
    bench.port.from_line(b"ab")
    bench.port.from_line(b"\xff")
    assert bench.written() == ""
    assert bench.client("ff fa 2c 09 ff f0") == "61 62 ff ff"


def test_purge_forgets_what_waits(bench: Bench) -> None:
    bench.client("ff fa 2c 08 ff f0")
    bench.port.from_line(b"ab")
    assert bench.com_port("0c 01") == "70 01"
    assert bench.client("ff fa 2c 09 ff f0") == ""


def test_hardware_flow_control_holds_while_cts_is_off(bench: Bench) -> None:
    bench.com_port("05 03")
    bench.port.from_line(ControlLines(rts=False))
    bench.client("61 62")
    assert bench.line.take() == []
    bench.port.from_line(ControlLines())
    assert bench.line.take() == [b"ab"]


def test_purge_forgets_what_cts_holds(bench: Bench) -> None:
    bench.com_port("05 03")
    bench.port.from_line(ControlLines(rts=False))
    bench.client("61 62 ff fa 2c 0c 02 ff f0")
    bench.port.from_line(ControlLines())
    assert bench.line.take() == []


# ITU-T T.50: XON is 11, XOFF is 13
def test_xoff_of_the_device_holds_the_client_until_xon(bench: Bench) -> None:
    bench.com_port("05 02")
    bench.port.from_line(b"a\x13b")
    assert bench.written() == "61 62"  # the characters of the flow control are not data
    bench.client("63 64")
    assert bench.line.take() == []
    bench.port.from_line(b"\x11")
    assert bench.line.take() == [b"cd"]
    assert bench.written() == ""


def test_without_flow_control_xon_and_xoff_are_data(bench: Bench) -> None:
    bench.port.from_line(b"\x13\x11\x13")
    assert bench.written() == "13 11 13"
    bench.client("61")
    assert bench.line.take() == [b"a"]


def test_xoff_is_forgotten_when_the_client_wants_no_flow_control_any_more(bench: Bench) -> None:
    bench.com_port("05 02")
    bench.port.from_line(b"\x13")
    bench.client("61")
    assert bench.com_port("05 01") == "69 01"
    assert bench.line.take() == [b"a"]


def test_xon_xoff_outbound_holds_inbound_too_until_inbound_is_set(bench: Bench) -> None:
    bench.com_port("05 02")
    assert bench.com_port("05 0d") == "69 0f"
    assert bench.com_port("05 0e") == "69 0e"
    assert bench.com_port("05 00") == "69 02"


def test_device_is_stopped_while_a_suspended_clients_data_fill_the_buffer(bench: Bench) -> None:
    bench.com_port("05 0f")
    bench.client("ff fa 2c 08 ff f0")
    bench.port.from_line(bytes(MOST_HELD // 2))
    assert bench.line.take() == []
    bench.port.from_line(bytes(MOST_HELD // 4))
    bench.port.from_line(b"late")
    assert bench.line.take() == [b"\x13"]
    bench.client("ff fa 2c 09 ff f0")
    assert bench.line.take() == [b"\x11"]


def test_device_that_was_stopped_goes_on_when_the_client_leaves(bench: Bench) -> None:
    bench.com_port("05 0f")
    bench.client("ff fa 2c 08 ff f0")
    bench.port.from_line(bytes(MOST_HELD))
    bench.port.stop()
    assert bench.line.take() == [b"\x13", b"\x11"]


@given(
    st.lists(st.binary(max_size=8) | st.sampled_from([b"\x11", b"\x13"])), st.lists(st.binary(min_size=1, max_size=8))
)
def test_nothing_but_the_two_characters_is_lost_under_xon_xoff(device: list[bytes], client: list[bytes]) -> None:
    bench = Bench().start()
    bench.com_port("05 02")
    for data in device:
        bench.port.from_line(data)
    received = bytes.fromhex(bench.written()).replace(b"\xff\xff", b"\xff")
    assert received == b"".join(device).replace(b"\x11", b"").replace(b"\x13", b"")
    for data in client:
        bench.port.from_client(data.replace(b"\xff", b"\xff\xff"))
    bench.port.from_line(b"\x11")
    assert b"".join(piece for piece in bench.line.take() if isinstance(piece, bytes)) == b"".join(client)


def test_signature_is_sent_on_request(bench: Bench) -> None:
    assert bytes.fromhex(bench.com_port("00")) == b"\x64fieldrig"
    assert bench.client("ff fa 2c 00 70 79 ff f0") == ""


@pytest.mark.parametrize("body", ["63", "", "0c", "c8 01"])
def test_command_of_no_meaning_is_dropped(bench: Bench, body: str) -> None:
    assert bench.client(f"ff fa 2c {body} ff f0") == ""


def test_other_options_subnegotiations_are_dropped(bench: Bench) -> None:
    assert bench.client("ff fa 18 00 76 74 ff f0") == ""


@given(st.lists(st.binary(max_size=30) | st.binary(max_size=6).map(lambda body: b"\xff\xfa\x2c" + body + b"\xff\xf0")))
def test_no_bytes_of_a_client_raise(pieces: list[bytes]) -> None:
    bench = Bench().start()
    for piece in pieces:
        bench.port.from_client(piece)
