"""Serial messages as bytes, and as a line of text."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.serial.codec import decode, encode, show
from fieldrig_bus.serial.message import Break, ControlLines, Format, ModemInputs, SerialMessage, inputs_from

LINES = st.builds(ControlLines, st.booleans(), st.booleans(), st.booleans(), st.none() | st.booleans())
FORMATS = st.builds(
    Format,
    st.integers(1, 10_000_000),
    st.sampled_from([5, 6, 7, 8]),
    st.sampled_from(["N", "E", "O"]),
    st.sampled_from([1, 2]),
)
MESSAGES = st.binary() | LINES | FORMATS | st.builds(Break, st.integers(0, 1 << 31))

# One message of each kind, laid out by hand from the docstrings of codec.py.
EXAMPLES: list[tuple[SerialMessage, str]] = [
    (b"AT\r", "00 41 54 0d"),
    (ControlLines(), "01 03"),
    (ControlLines(dtr=False, rts=True, ri=True, dcd=True), "01 1e"),
    (ControlLines(dtr=True, rts=False, dcd=False), "01 09"),
    (Format(19200, 7, "E", 2), "02 00 4b 00 00 07 45 02"),
    (Break(250), "03 fa 00 00 00"),
]


@pytest.mark.parametrize(("message", "data"), EXAMPLES)
def test_message_has_its_bytes(message: SerialMessage, data: str) -> None:
    assert encode(message) == bytes.fromhex(data)
    assert decode(bytes.fromhex(data)) == message


@given(MESSAGES)
def test_every_message_comes_back(message: SerialMessage) -> None:
    assert decode(encode(message)) == message


@given(st.binary(max_size=12))
def test_any_decoded_message_encodes_to_the_same_bytes(data: bytes) -> None:
    try:
        message = decode(data)
    except ValueError:
        return
    assert encode(message) == data


@pytest.mark.parametrize(
    "data",
    ["", "04", "01", "01 40", "01 10", "02 00 4b", "02 00 00 00 00 08 4e 01", "02 80 25 00 00 09 4e 01", "03 01"],
)
def test_other_bytes_are_refused(data: str) -> None:
    with pytest.raises(ValueError, match="not a serial message"):
        decode(bytes.fromhex(data))


def test_message_is_shown_on_one_line() -> None:
    assert show(b"AT\r") == "41 54 0d  'AT\\r'"
    assert show(bytes(100)).endswith("100 bytes")
    assert show(ControlLines(rts=False, dcd=True)) == "DTR=on RTS=off RI=off DCD=on"
    assert show(Format(19200, 7, "E", 2)) == "19200 7E2"
    assert show(Break(250)) == "break 250 ms"


# A null-modem cable, TIA-232: DTR to DSR and DCD, RTS to CTS.
CROSSED = [
    (ControlLines(), ModemInputs(cts=True, dsr=True, dcd=True, ri=False)),
    (ControlLines(dtr=False), ModemInputs(cts=True, dsr=False, dcd=False, ri=False)),
    (ControlLines(rts=False), ModemInputs(cts=False, dsr=True, dcd=True, ri=False)),
    (ControlLines(dcd=False, ri=True), ModemInputs(cts=True, dsr=True, dcd=False, ri=True)),
    (ControlLines(dtr=False, dcd=True), ModemInputs(cts=True, dsr=False, dcd=True, ri=False)),
]


@pytest.mark.parametrize(("outputs", "inputs"), CROSSED)
def test_outputs_of_one_end_are_inputs_of_the_other(outputs: ControlLines, inputs: ModemInputs) -> None:
    assert inputs_from(outputs) == inputs
