"""Lines of which no device says what they carry: commands and results of V.250, and PPP of pppd 2.4.9."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.line_names.characters import LONGEST, readable, text_or_hex
from fieldrig_devices.line_names.text_line import LONGEST_LINE, MOST_ENDS, TextLine

PPP = bytes.fromhex(
    "7eff7d23c0217d217d217d207d387d227d267d207d207d207d207d237d24c0237d257d267d21713f747d277d227d287d2244f67e"
)
"""A Configure-Request of pppd at a pty."""


def test_control_characters_have_their_names() -> None:
    assert readable(b"AT\r\n\x1b[2J\x7f\xe4") == "AT<CR><LF><ESC>[2J<DEL><E4h>"
    assert readable(b"x" * 100) == "x" * LONGEST + " … 100 bytes"
    assert text_or_hex(bytes((0, 1, 2, 65))) == "00 01 02 41"


def test_a_dialogue_with_a_modem() -> None:
    line = TextLine()
    assert line("pc", b"ATE1\r") == [("AT command", "ATE1")]
    assert line("modem", b"ATE1\r\r\nOK\r\n") == [("AT echo", "ATE1"), ("AT result", "OK")]
    assert line("pc", b"ATD20") == [("text", "ATD20")]
    assert line("pc", b"0\r") == [("AT command", "ATD200")]
    assert line("modem", b"\r\nCONNECT 33600\r\n") == [("AT result", "CONNECT 33600")]
    assert line("pc", b"+++") == [("escape", "+++")]
    assert line("modem", b"3\r") == [("AT result", "3 NO CARRIER")]


@pytest.mark.parametrize(
    "result",
    [
        "OK", "RING", "NO CARRIER", "ERROR", "NO DIALTONE", "BUSY", "NO ANSWER", "CARRIER 9600", "PROTOCOL: LAP-M",
        "+ER: LAPM",
    ],
)  # fmt: skip
def test_results_have_a_kind_of_their_own(result: str) -> None:
    line = TextLine()
    line("pc", b"at\r")
    assert line("modem", f"\r\n{result}\r\n".encode()) == [("AT result", result)]


def test_ok_is_text_on_a_line_without_a_modem() -> None:
    assert TextLine()("plc", b"OK\r\n") == [("text", "OK<CR><LF>")]


@pytest.mark.parametrize("cut", [1, 10, len(PPP) - 1])
def test_ppp_is_named_when_its_frame_is_whole(cut: int) -> None:
    line = TextLine()
    line("modem", PPP[:cut])
    ((kind, text),) = line("modem", PPP[cut:])
    assert kind == "PPP LCP"
    assert text.startswith("Configure-Request 1: ACCM 00000000h, authentication protocol C023h, magic number 01713F74h")
    assert line("modem", PPP[:12]) == [("PPP", "part of a frame, 12 bytes")]


def test_after_ppp_the_modem_speaks_again() -> None:
    line = TextLine()
    line("pc", b"ATD200\r")
    line("pc", PPP)
    assert line("pc", b"+++") == [("escape", "+++")]
    assert line("modem", PPP[:12]) == [("text", "~<FFh>}#<C0h>!}!}!} ")]
    line("modem", PPP)
    assert line("modem", b"\r\nNO CARRIER\r\n") == [("AT result", "NO CARRIER")]


def test_lines_within_a_frame_are_no_words_of_a_modem() -> None:
    """Ends that have agreed on ACCM 0 send CR as it is (RFC 1662, 7.1)."""
    line = TextLine()
    line("pc", b"ATD200\r")
    line("pc", PPP)
    line("pc", b"\x7e\x21GET / HTTP/1.1")
    assert line("pc", b"\r\nHost: plc\r\n") == [("PPP", "part of a frame, 13 bytes")]
    assert line("modem", b"\x7e\x21E") == [("PPP", "part of a frame, 3 bytes")]
    assert line("modem", b"\r\nNO CARRIER\r\n") == [("AT result", "NO CARRIER")]


@given(st.lists(st.tuples(st.sampled_from(["a", "b"]), st.binary(max_size=40)), max_size=8))
def test_any_bytes_have_some_name(sent: list[tuple[str, bytes]]) -> None:
    line = TextLine()
    for sender, data in sent:
        assert all(isinstance(kind, str) and isinstance(text, str) for kind, text in line(sender, data))


@pytest.mark.parametrize("first", [b"", PPP])
def test_memory_stays_the_same_however_much_comes(first: bytes) -> None:
    line = TextLine()
    line("pc", first)
    for number in range(100):
        line(f"client {number}", b"x" * 1000)
    for table in (line._open, line._in_frame, line._ppp._open):
        assert len(table) <= MOST_ENDS + 1
    assert all(len(rest) <= LONGEST_LINE for rest in line._open.values())
