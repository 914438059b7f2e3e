"""PPP frames in traced bytes: RFC 1662.  The frame is a Configure-Request of pppd 2.4.9 at a pty."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.traces.ppp_frames import PppFinder

ON_LINE = bytes.fromhex(
    "7eff7d23c0217d217d217d207d387d227d267d207d207d207d207d237d24c0237d257d267d21713f747d277d227d287d2244f67e"
)
FRAME = bytes.fromhex("ff03c021 01010018 020600000000 0304c023 050601713f74 0702 0802")


def test_a_frame_is_found_without_escapes_and_check_sequence() -> None:
    assert PppFinder().feed("modem", ON_LINE) == [FRAME]


@pytest.mark.parametrize("cut", range(1, len(ON_LINE)))
def test_a_frame_may_come_in_parts_with_the_other_end_between_them(cut: int) -> None:
    finder = PppFinder()
    found = finder.feed("modem", ON_LINE[:cut]) + finder.feed("max4", b"AT\r") + finder.feed("modem", ON_LINE[cut:])
    assert found == [FRAME]


@pytest.mark.parametrize(
    "data",
    [
        b"\r\nCONNECT 38400\r\n",
        ON_LINE.replace(b"\x71", b"\x72"),  # a wrong check sequence
        ON_LINE[:-1] + b"\x7d\x7e",  # an abort
        b"~" + bytes.fromhex("0000d37e"),
        b"~~~~",
    ],
)
def test_other_bytes_are_skipped(data: bytes) -> None:
    finder = PppFinder()
    assert finder.feed("modem", data) == []
    assert finder.feed("modem", ON_LINE) == [FRAME]


def test_frames_count_from_the_first_one_of_lcp_on() -> None:
    """Other protocols have the same flags and check sequence, such as the USER port of an ARP card."""
    finder = PppFinder()
    ip = bytes.fromhex("7e ff03 0021 4500 5076 7e")
    assert finder.feed("pc", ip) == []
    assert finder.feed("modem", ON_LINE) == [FRAME]
    assert finder.feed("pc", ip) == [bytes.fromhex("ff03 0021 4500")]


@settings(deadline=None)
@given(st.lists(st.binary(max_size=30)))
def test_arbitrary_bytes_do_not_raise(pieces: list[bytes]) -> None:
    finder = PppFinder()
    for piece in pieces:
        finder.feed("a", piece)
