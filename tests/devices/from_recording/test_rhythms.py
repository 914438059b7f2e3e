"""The transmission of a PDO by the instants and the data of its frames."""

from collections.abc import Iterable

import pytest

from fieldrig.clock import MS
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.from_recording.identifiers import Identifier
from fieldrig_devices.from_recording.rhythm import Rhythm, rhythm_of
from fieldrig_devices.from_recording.series import Room

EVENTS_MS = (37, 151, 160, 421)
"""Changes of an input after the beginning of a run."""


def sent(frames: Iterable[tuple[int, int]]) -> Identifier:
    """Return the log of frames, each with its instant in ms and its first byte."""
    log = Identifier(Room())
    for time_ms, value in frames:
        log.take(time_ms * MS, CanFrame(0x185, bytes((value,))), None)
    return log


def run(start_ms: int, timer_ms: int, length_ms: int = 1_000) -> list[tuple[int, int]]:
    """Return what a node sends: its start, each change of an input, and the same again at the event timer (CiA 301)."""
    frames, value, now_ms = [(start_ms, 0)], 0, 0
    changes = list(EVENTS_MS)
    while now_ms < length_ms:
        due_ms = now_ms + timer_ms
        if changes and changes[0] <= due_ms:
            now_ms = changes.pop(0)
            value = 1 - value
        else:
            now_ms = due_ms
        frames.append((start_ms + now_ms, value))
    return frames


def shown(rhythm: Rhythm) -> tuple[int, int]:
    return rhythm.type, rhythm.event_ms


@pytest.mark.parametrize("timer_ms", [50, 100])
def test_a_pdo_of_changes_that_is_repeated_has_an_event_timer(timer_ms: int) -> None:
    assert shown(rhythm_of(sent(run(0, timer_ms)), 0)) == (255, timer_ms)


def test_a_time_in_which_the_node_was_reset_says_nothing_of_the_timer() -> None:
    starts_ms = (0, 9_000, 15_300, 22_100)
    log = sent(frame for start_ms in starts_ms for frame in run(start_ms, 300, 600))
    resets = [(start_ms - 2_000) * MS for start_ms in starts_ms[1:]]
    assert shown(rhythm_of(log, 0, resets)) == (255, 300)
    assert shown(rhythm_of(log, 0)) == (255, 0), "without the resets the pauses speak against a timer"


def test_a_cyclic_pdo_stays_cyclic_over_resets() -> None:
    starts_ms = (0, 7_300, 15_500)
    log = sent((start_ms + 1_000 * count, 7) for start_ms in starts_ms for count in range(3))
    found = rhythm_of(log, 0, [(start_ms - 10) * MS for start_ms in starts_ms[1:]])
    assert (found.event_ms, found.is_cyclic) == (1_000, True)


def test_resets_between_all_frames_leave_what_there_is() -> None:
    log = sent((1_000 * count, 7) for count in range(6))
    assert rhythm_of(log, 0, [(1_000 * count - 5) * MS for count in range(1, 6)]).event_ms == 1_000
