"""Two sequences of one stream: which messages are the same, late, missing."""

import pytest
from recorded_logs import MS, frame

from fieldrig_devices.replay.align import MOST_WAITING, Aligner, Pair
from fieldrig_devices.replay.streams import Item

S = 1000 * MS
Times = list[tuple[float, str]]


def items(messages: Times) -> list[Item]:
    return [Item(round(ms * MS), data.encode(), number, frame(ms, 1)) for number, (ms, data) in enumerate(messages)]


def aligned(left: Times, right: Times) -> list[Pair]:
    aligner = Aligner(5 * MS, S)
    pairs = [aligner.add_left(item) for item in items(left)]
    pairs += [aligner.add_right(item) for item in items(right)]
    return [*filter(None, pairs), *aligner.settle(0, is_end=True)]


def shown(pairs: list[Pair]) -> list[str]:
    """Each difference: `-a` is only on the left, `+b` only on the right, `a/b` other data, `a@7` 7 ms later."""
    words = []
    for left, right, late_ns in pairs:
        if left is None or right is None:
            words += [f"-{left.content.decode()}"] if left else [f"+{right.content.decode()}"] if right else []
        elif left.content != right.content:
            words.append(f"{left.content.decode()}/{right.content.decode()}")
        elif abs(late_ns) > 5 * MS:
            words.append(f"{left.content.decode()}@{late_ns // MS}")
    return words


ROW = [(10.0 * number, "abcdefghijkl"[number]) for number in range(12)]
ALIKE = [(10.0 * number, "x") for number in range(12)]


def but(messages: Times, place: int, *instead: tuple[float, str]) -> Times:
    return [*messages[:place], *instead, *messages[place + 1 :]]


@pytest.mark.parametrize("place", range(12))
@pytest.mark.parametrize("messages", [ROW, ALIKE])
def test_one_missing_message_is_one_difference_wherever_it_is(messages: Times, place: int) -> None:
    lost = f"{messages[place][1]}"
    assert shown(aligned(messages, but(messages, place))) == [f"-{lost}"]
    assert shown(aligned(but(messages, place), messages)) == [f"+{lost}"]


@pytest.mark.parametrize("place", range(12))
def test_one_changed_message_is_other_data(place: int) -> None:
    at, data = ROW[place]
    assert shown(aligned(ROW, but(ROW, place, (at, "!")))) == [f"{data}/!"]


def test_a_message_that_comes_after_its_successor_is_late_and_nothing_is_missing() -> None:
    assert shown(aligned(ROW, [*ROW[:4], ROW[5], (52.0, "e"), *ROW[6:]])) == ["e@12"]


def test_jitter_within_the_tolerance_is_nothing() -> None:
    assert shown(aligned(ALIKE, [(at + jitter, "x") for (at, _), jitter in zip(ALIKE, [4, -4] * 6, strict=True)])) == []


def test_a_master_that_polls_more_slowly_loses_no_message() -> None:
    """Ten percent slower: after a second a message is as late as ten of them are apart."""
    left = [(10.0 * number, "x") for number in range(100)]
    pairs = aligned(left, [(11.0 * number, "x") for number in range(100)])
    assert [pair for pair in pairs if pair.left is None or pair.right is None] == []


def test_messages_further_apart_than_the_window_are_different_ones() -> None:
    assert shown(aligned([(0, "a")], [(1500, "a")])) == ["-a", "+a"]


def test_a_side_without_the_other_is_not_kept_without_end() -> None:
    aligner = Aligner(5 * MS, S)
    waiting = 0
    for item in items([(0.01 * number, "x") for number in range(2_000)]):
        aligner.add_left(item)
        if aligner.is_full:
            waiting = max(waiting, len([*aligner.settle(item.time_ns)]))
    rest = [*aligner.settle(0, is_end=True)]
    assert len(rest) <= 2 * MOST_WAITING
