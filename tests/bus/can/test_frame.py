import pytest

from fieldrig_bus.can.frame import CanFrame, check


@pytest.mark.parametrize(
    "frame",
    [
        CanFrame(0),
        CanFrame(0x7FF, bytes(8)),
        CanFrame(0x1FFF_FFFF, b"\x01", is_extended=True),
        CanFrame(0x123, is_remote=True, remote_length=8),
        CanFrame(0x123, bytes(64), is_fd=True, is_bit_rate_switched=True),
        CanFrame(0x123, bytes(20), is_fd=True),
    ],
)
def test_a_frame_that_the_standard_knows_passes(frame: CanFrame) -> None:
    assert check(frame) is frame


@pytest.mark.parametrize(
    ("frame", "complaint"),
    [
        (CanFrame(0x800), "at most 0x7ff"),
        (CanFrame(-1), "at most 0x7ff"),
        (CanFrame(0x2000_0000, is_extended=True), "at most 0x1fffffff"),
        (CanFrame(1, bytes(9)), "9 bytes"),
        (CanFrame(1, bytes(9), is_fd=True), "9 bytes"),
        (CanFrame(1, bytes(65), is_fd=True), "65 bytes"),
        (CanFrame(1, is_fd=True, is_remote=True), "CAN FD has no remote frames"),
        (CanFrame(1, is_bit_rate_switched=True), "only an FD frame"),
        (CanFrame(1, b"\x00", is_remote=True), "has no data"),
        (CanFrame(1, is_remote=True, remote_length=9), "0 to 8"),
        (CanFrame(1, remote_length=1), "and 0 in any other"),
    ],
)
def test_any_other_is_refused_with_the_reason(frame: CanFrame, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        check(frame)
