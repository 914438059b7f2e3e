"""Telegrams of the RS422 line in words; the bytes follow the table in docs/devices/pam/pam-rs422.md."""

from binascii import crc_hqx

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.pam.language.ports import PortVariable
from fieldrig_devices.pam.ports.rs422.names import MOST_KEYS, Rs422Reader

PRESSURE = PortVariable("RWI_Pressure", "WORD_VAR", True)
LEVEL = PortVariable("RRO_Level", "REAL_VAR", False)


@pytest.fixture
def reader() -> Rs422Reader:
    return Rs422Reader("pam", [PRESSURE, LEVEL])


def frame(content: str) -> bytes:
    """Return content with its CRC-16/CCITT-FALSE between 02h and 03h, escaped."""
    data = bytes.fromhex(content)
    data += crc_hqx(data, 0xFFFF).to_bytes(2, "big")
    line = b"".join(bytes((0x10, byte ^ 0x20)) if byte in (2, 3, 0x10) else bytes((byte,)) for byte in data)
    return b"\x02" + line + b"\x03"


def crc(name: str) -> str:
    """Return the CRC of a variable: that of its name in capitals (docs/devices/pam/pam-ports.md)."""
    return f"{crc_hqx(name.upper().encode(), 0xFFFF):04x}"


@pytest.mark.manual("PAMS-097", "PAMS-101")
def test_a_session_has_the_names_of_the_variables(reader: Rs422Reader) -> None:
    dialogue = [
        ("plc", "01", "REQUEST", ""),
        ("pam", "20 01 01 0000 0000", "ACK", "REQUEST: OK"),
        ("plc", "02", "ASK DEF IN", ""),
        ("pam", f"21 {crc('RWI_Pressure')} 00000001 0002 0001 0014", "DEF IN",
         "RWI_Pressure, key 1, WORD_VAR, 1 items, every 20 ms"),
        ("plc", f"03 {crc('RRO_Level')} 00000309", "DEF OUT", "RRO_Level, key 777"),
        ("pam", "20 03 01 0004 0001", "ACK", "DEF OUT: OK, REAL_VAR, 1 items"),
        ("plc", "12 00000001 0000 fffd", "XNG WORD", "RWI_Pressure = -3"),
        ("pam", "14 00000309 0002 3fe0000000000000", "XNG REAL", "RRO_Level item 2 = 0.5"),
        ("pam", "14 00000309 ffff 3fe0000000000000", "XNG REAL", "RRO_Level of all items = 0.5"),
        ("plc", "11 00000009 0000 01", "XNG FLAG", "key 9 = 1"),
        ("plc", "08", "ALIVE", ""),
        ("plc", "7f", "unknown command", ""),
    ]  # fmt: skip
    for sender, content, kind, text in dialogue:
        assert reader(sender, frame(content)) == [(kind, text)]


def test_a_damaged_frame_says_what_is_wrong(reader: Rs422Reader) -> None:
    assert reader("plc", b"\x02\x01\x00\x00\x03") == [("line fault", "crc")]
    assert reader("plc", b"xyz") == [("line fault", "start character")]


def test_keys_without_end_take_no_more_memory(reader: Rs422Reader) -> None:
    for key in range(MOST_KEYS + 10):
        reader("plc", frame(f"03 1234 {key:08x}"))
    assert len(reader._keys) <= MOST_KEYS


@given(st.lists(st.tuples(st.sampled_from(["pam", "plc"]), st.binary(max_size=40)), max_size=6))
def test_any_bytes_have_some_words(sent: list[tuple[str, bytes]]) -> None:
    reader = Rs422Reader("pam", [PRESSURE])
    for sender, data in sent:
        assert all(isinstance(text, str) for part in reader(sender, data) for text in part)
        reader(sender, frame(data.hex()))
