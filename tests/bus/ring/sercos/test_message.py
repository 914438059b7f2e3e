import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst, RingMessage, decode, encode, show

ADDRESSED = st.binary(min_size=1, max_size=40)
MESSAGES = (
    st.builds(Cycle, st.integers(0, 0xFFFF_FFFF), st.binary(max_size=2), st.binary(max_size=300))
    | st.builds(
        Answers,
        st.integers(0, 0xFFFF_FFFF),
        st.lists(ADDRESSED, max_size=8).map(tuple),
        st.booleans(),
        st.integers(0, 60_000),
        st.integers(0, 60_000),
    )
    | st.builds(Mst, st.integers(0, 0xFFFF_FFFF), st.binary(max_size=4))
    | st.builds(Mdt, st.binary(max_size=300))
    | ADDRESSED
)


@given(MESSAGES)
def test_every_message_comes_back(message: RingMessage) -> None:
    assert decode(encode(message)) == message


@given(st.binary(max_size=40))
def test_anything_else_is_refused_or_read(data: bytes) -> None:
    try:
        decode(data)
    except ValueError:
        return


@pytest.mark.parametrize("data", ["", "03", "00 01", "00 01 00 00 00 02 01 00 FF", "01 00 00 00 00 01 00 00 05 00 01"])
def test_what_is_no_message_is_refused(data: str) -> None:
    with pytest.raises(ValueError, match=r"ring message|cycle|AT"):
        decode(bytes.fromhex(data))


def test_a_line_for_a_person() -> None:
    assert show(Cycle(7, bytes.fromhex("FF 04"), bytes.fromhex("FF 00 C0"))) == "7 MST ff 04 MDT ff 00 c0"
    assert show(Mst(7, bytes.fromhex("FF 04"))) == "7 MST ff 04"
    assert show(Mdt(b"")) == "MDT none"
    assert show(Cycle(8, b"", b"")) == "8 MST failed MDT none"
    assert show(Answers(9, (b"\x03\x00",), False, 1, 2)) == "9 ATs 03 00, ring open, 1 with a wrong FCS, 2 late"
