"""Messages of the telephone network as bytes and text."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.telephone import codec
from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Offer, Ready, Ring, TelephoneMessage, Tone
from fieldrig_bus.telephone.modulation import FASTEST_BPS, RATES, Modulation

rates = st.integers(0, FASTEST_BPS)
digits = st.text("0123456789ABCD*#", min_size=1, max_size=64)
modulations = st.builds(Modulation, st.sampled_from(sorted(RATES)), rates, rates)
messages = st.one_of(
    st.binary(max_size=300),
    st.builds(Hook, st.booleans()),
    st.builds(Dial, digits),
    st.builds(Ring, st.booleans(), digits | st.just("")),
    st.builds(Heard, st.sampled_from(Tone)),
    st.builds(Offer, st.lists(modulations, max_size=len(RATES)).map(tuple), st.integers(0, 2), rates),
    st.builds(Carrier, rates, st.booleans(), st.booleans()),
    st.builds(Ready, st.booleans()),
)


@given(messages)
def test_a_message_is_the_same_after_its_way_as_bytes(message: TelephoneMessage) -> None:
    assert codec.decode(codec.encode(message)) == message


@given(st.binary(max_size=60))
def test_any_bytes_are_a_message_or_a_value_error(data: bytes) -> None:
    try:
        message = codec.decode(data)
    except ValueError:
        return
    assert codec.decode(codec.encode(message)) == message


# Laid out by hand after the docstring of the codec.
WIRE: list[tuple[TelephoneMessage, str, str]] = [
    (b"AT", "00 41 54", "41 54  'AT'"),
    (Hook(True), "01 01", "off hook"),
    (Dial("0*1"), "02 30 2a 31", "dials 0*1"),
    (Ring(True, "42"), "03 01 34 32", "ring on, from 42"),
    (Heard(Tone.BUSY), "04 03", "tone: busy"),
    (Offer((Modulation("V34", 2400, 33600),), 1),
     "05 01 40 83 00 00 00 60 09 00 00 40 83 00 00", "offers V34 2400-33600"),
    (Carrier(9600, True), "06 80 25 00 00 01 01", "carrier 9600 bit/s, error correction"),
    (Carrier(0), "06 00 00 00 00 00 01", "no carrier"),
    (Ready(False), "07 00", "not ready"),
]  # fmt: skip


@pytest.mark.parametrize(("message", "wire", "shown"), WIRE)
def test_messages_are_laid_out_as_described(message: TelephoneMessage, wire: str, shown: str) -> None:
    assert codec.encode(message) == bytes.fromhex(wire)
    assert codec.show(message) == shown
