"""Frame lengths against hand-counted bits, published sums, and a reference that produces every bit."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame
from fieldrig_bus.can.length import classical_bits, fd_bits


def crc15(bits: str) -> str:
    """The CRC of ISO 11898-1, by the shift register of the standard."""
    register = [0] * 15
    for bit in bits:
        feedback = int(bit) ^ register[0]
        register = [*register[1:], 0]
        if feedback:
            register = [a ^ b for a, b in zip(register, (1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1), strict=True)]
    return "".join(map(str, register))


def stuffed(bits: str) -> str:
    wire = ""
    for bit in bits:
        wire += bit
        if wire.endswith("00000"):
            wire += "1"
        elif wire.endswith("11111"):
            wire += "0"
    return wire


def payload(data: bytes) -> str:
    return "".join(f"{byte:08b}" for byte in data)


def classical_wire(frame: CanFrame) -> str:
    rtr, dlc = ("1", frame.remote_length) if frame.is_remote else ("0", len(frame.data))
    if frame.is_extended:
        base, extension = frame.identifier >> 18, frame.identifier % (1 << 18)
        header = f"0{base:011b}11{extension:018b}{rtr}00{dlc:04b}"
    else:
        header = f"0{frame.identifier:011b}{rtr}00{dlc:04b}"
    covered = header + payload(frame.data)
    return stuffed(covered + crc15(covered)) + "1" + "0" + "1" + "1" * 7 + "1" * 3


def fd_wire(frame: CanFrame) -> tuple[str, str, str]:
    """Bits up to BRS; from ESI to the CRC delimiter, with dots for CRC and stuff count; and the rest."""
    brs = "1" if frame.is_bit_rate_switched else "0"
    if frame.is_extended:
        base, extension = frame.identifier >> 18, frame.identifier % (1 << 18)
        arbitration = f"0{base:011b}11{extension:018b}010{brs}"
    else:
        arbitration = f"0{frame.identifier:011b}0010{brs}"
    dynamic = arbitration + f"0{FD_LENGTHS.index(len(frame.data)):04b}" + payload(frame.data)
    # The last bit goes in without a stuff bit behind it: what follows is the first fixed stuff bit.
    wire = stuffed(dynamic[:-1]) + dynamic[-1]
    up_to_brs = len(stuffed(arbitration))
    crc = "." * (4 + (17 if len(frame.data) <= 16 else 21))
    fixed = "".join("|" + crc[at : at + 4] for at in range(0, len(crc), 4))
    return wire[:up_to_brs], wire[up_to_brs:] + fixed + "1", "0" + "1" + "1" * 7 + "1" * 3


def test_the_reference_has_the_crc_of_the_catalogue() -> None:
    assert int(crc15(payload(b"123456789")), 2) == 0x059E  # CRC-15/CAN


@pytest.mark.parametrize(
    ("frame", "bits"),
    [
        # 34 zeros from start of frame to CRC: a stuff bit after every 5, which makes 6; tail 13
        (CanFrame(0), 34 + 6 + 13),
        # SOF, 11 and 2 zeros, FDF | 2 + BRS, ESI, DLC: 7 zeros; stuff bits after 5, 10 | 5
        (CanFrame(0, is_fd=True), 22 + 3 + 27 + 13),
    ],
)
def test_frames_counted_by_hand(frame: CanFrame, bits: int) -> None:
    assert (sum(fd_bits(frame)) if frame.is_fd else classical_bits(frame)) == bits


def test_a_stuff_bit_that_is_due_before_the_crc_of_fd_is_the_fixed_one() -> None:
    # Nominal: 14 zeros with 2 stuff bits, FDF, res, BRS; ACK, its delimiter, EOF, intermission.
    # Switched: ESI and DLC are 5 zeros and nothing more; then 27 of stuff count and CRC, and the delimiter.
    assert fd_bits(CanFrame(0, is_fd=True, is_bit_rate_switched=True)) == (17 + 2 + 12, 5 + 27 + 1)


# Sums of the fields, as Linux' include/linux/can/length.h lists them, without dynamic stuff bits.
UNSTUFFED = {
    False: {"classical": 47, "short fd": 62, "long fd": 67},
    True: {"classical": 67, "short fd": 81, "long fd": 86},
}
identifiers = st.tuples(st.booleans(), st.integers(0, 0x1FFF_FFFF)).map(
    lambda drawn: (drawn[1] if drawn[0] else drawn[1] & 0x7FF, drawn[0])
)
# Data with long runs, and random data.
bytes_of_data = st.sampled_from([0x00, 0xFF, 0x0F, 0xF0, 0x1F, 0x07, 0xE0, 0x78, 0x87]) | st.integers(0, 255)


@pytest.mark.long
@settings(max_examples=500, deadline=None)
@given(identifiers, st.lists(bytes_of_data, max_size=8))
def test_classical_data_frames_bit_by_bit(identifier: tuple[int, bool], data: list[int]) -> None:
    number, is_extended = identifier
    frame = CanFrame(number, bytes(data), is_extended)
    bits = classical_bits(frame)
    assert bits == len(classical_wire(frame))
    shortest = UNSTUFFED[is_extended]["classical"] + 8 * len(data)
    assert shortest <= bits <= shortest + (shortest - 13 - 1) // 4  # published worst case: 8n + 47 + (34 + 8n - 1) / 4


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(identifiers, st.integers(0, 8))
def test_remote_frames_bit_by_bit(identifier: tuple[int, bool], length: int) -> None:
    frame = CanFrame(identifier[0], b"", identifier[1], is_remote=True, remote_length=length)
    assert classical_bits(frame) == len(classical_wire(frame))


@pytest.mark.long
@settings(max_examples=500, deadline=None)
@given(identifiers, st.sampled_from(FD_LENGTHS), st.booleans(), st.data())
def test_fd_frames_bit_by_bit(
    identifier: tuple[int, bool], length: int, is_switched: bool, chance: st.DataObject
) -> None:
    octets = bytes(chance.draw(st.lists(bytes_of_data, min_size=length, max_size=length)))
    frame = CanFrame(identifier[0], octets, identifier[1], is_fd=True, is_bit_rate_switched=is_switched)
    before, switched, after = map(len, fd_wire(frame))
    expected = (before + after, switched) if is_switched else (before + switched + after, 0)
    assert fd_bits(frame) == expected
    shortest = UNSTUFFED[identifier[1]]["short fd" if length <= 16 else "long fd"] + 8 * length
    assert sum(expected) >= shortest


def test_eight_bytes_without_a_stuff_bit_take_111_bits() -> None:
    frame = CanFrame(0x555, bytes.fromhex("55 55 55 55 55 55 55 09"))
    assert classical_bits(frame) == 111
    assert "00000" not in classical_wire(frame)
