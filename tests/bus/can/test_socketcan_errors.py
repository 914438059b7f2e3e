import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.notices import BusState, CanError, CanState, ErrorKind
from fieldrig_bus.can.socketcan_errors import error_frame, notice_of

# Class and data by hand from linux/can/error.h.
FRAMES: dict[tuple[int, str], CanError | BusState] = {
    (0x2A0, "00 00 80 19 00 00 80 00"): CanError(ErrorKind.ACK, Place.ACK, 0, 0, True, False, 128, 0),
    (0x288, "00 00 81 0a 00 00 08 00"): CanError(ErrorKind.BIT, Place.DATA, 0, 0, True, False, 8, 0),
    (0x288, "00 00 04 0b 00 00 00 01"): CanError(ErrorKind.STUFF, Place.DLC, 0, 0, False, False, 0, 1),
    (0x288, "00 00 02 18 00 00 00 01"): CanError(ErrorKind.FORM, Place.CRC_DELIMITER, 0, 0, False, False, 0, 1),
    (0x288, "00 00 00 1b 00 00 00 01"): CanError(ErrorKind.CRC, Place.ACK_DELIMITER, 0, 0, False, False, 0, 1),
    (0x202, "05 00 00 00 00 00 00 00"): CanError(
        ErrorKind.ARBITRATION_LOST, Place.UNSPECIFIED, 5, 0, True, False, 0, 0
    ),
    (0x204, "00 08 00 00 00 00 60 00"): BusState(CanState.WARNING, 96, 0),
    (0x204, "00 04 00 00 00 00 00 60"): BusState(CanState.WARNING, 0, 96),
    (0x204, "00 20 00 00 00 00 80 00"): BusState(CanState.PASSIVE, 128, 0),
    (0x204, "00 10 00 00 00 00 00 80"): BusState(CanState.PASSIVE, 0, 128),
    (0x204, "00 40 00 00 00 00 05 00"): BusState(CanState.ACTIVE, 5, 0),
    (0x240, "00 00 00 00 00 00 ff 00"): BusState(CanState.BUS_OFF, 256, 0),
}


@pytest.mark.parametrize("frame", FRAMES)
def test_a_notice_is_an_error_frame(frame: tuple[int, str]) -> None:
    word, data = frame
    assert error_frame(FRAMES[frame]) == (word, bytes.fromhex(data))
    assert notice_of(word, bytes.fromhex(data)) == FRAMES[frame]


def test_a_restarted_controller_is_active() -> None:
    assert notice_of(0x100, bytes(8)) == BusState(CanState.ACTIVE, 0, 0)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.integers(0, 0x1FFF_FFFF), st.binary(max_size=8))
def test_any_error_frame_is_a_notice_or_none(word: int, data: bytes) -> None:
    notice = notice_of(word, data)
    assert notice is None or error_frame(notice)
