from typing import Any

import pytest

from fieldrig_bus.can.acceptance import EXTENDED, REMOTE, filters_of, passes, received, wants_own
from fieldrig_bus.can.frame import CanFrame

STANDARD = CanFrame(0x181)
EXTENDED_FRAME = CanFrame(0x181, is_extended=True)
REMOTE_FRAME = CanFrame(0x181, is_remote=True)


@pytest.mark.parametrize(
    ("interest", "heard"),
    [
        (None, [STANDARD, EXTENDED_FRAME, REMOTE_FRAME]),
        ([], []),
        ([[0, 0]], [STANDARD, EXTENDED_FRAME, REMOTE_FRAME]),
        ([[0x181, 0x7FF]], [STANDARD, EXTENDED_FRAME, REMOTE_FRAME]),
        ([[0x181, 0x7FF | EXTENDED]], [STANDARD, REMOTE_FRAME]),
        ([[0x181, 0x7FF | EXTENDED | REMOTE]], [STANDARD]),
        ([[0x181 | EXTENDED, 0x1FFF_FFFF | EXTENDED]], [EXTENDED_FRAME]),
        ([[0x180, 0x780]], [STANDARD, EXTENDED_FRAME, REMOTE_FRAME]),
        ([[0x1FF, 0x780]], [STANDARD, EXTENDED_FRAME, REMOTE_FRAME]),  # bits outside the mask are ignored
        ([[0x182, 0x7FF]], []),
        ([[0x182, 0x7FF], [0x181, 0x7FF]], [STANDARD, EXTENDED_FRAME, REMOTE_FRAME]),
        (["own"], []),
    ],
)
def test_filters_are_those_of_socketcan(interest: list[Any] | None, heard: list[CanFrame]) -> None:
    filters = filters_of(interest)
    assert [each for each in (STANDARD, EXTENDED_FRAME, REMOTE_FRAME) if passes(received(each), filters)] == heard


def test_own_frames_come_back_only_when_asked_for() -> None:
    assert wants_own(["own", [0x181, 0x7FF]])
    assert not wants_own([[0x181, 0x7FF]])
    assert not wants_own(None)


@pytest.mark.parametrize("interest", [[5], ["mine"], [[1]], [[1, 2, 3]], [[-1, 0]], [[0, 1 << 32]], [["1", 2]], [None]])
def test_what_is_no_filter_is_refused(interest: list[Any]) -> None:
    with pytest.raises(ValueError, match="not an acceptance filter"):
        filters_of(interest)
