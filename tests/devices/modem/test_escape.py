"""The escape sequence: which bytes at which instants are one, and which are not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig_devices.modem.reader import Escape

GUARD_MS = 1000
PLUS = 43


def is_escape(chunks: list[tuple[int, bytes]], guard_ms: int = GUARD_MS) -> bool:
    """Return whether the last of the chunks, each with its instant in ms, ends in a sequence that silence completes."""
    escape = Escape()
    escape.restart(0)
    found = False
    for when_ms, data in chunks:
        found = escape.hear(when_ms * MS, data, PLUS, guard_ms * MS)
    return found


ROWS = [
    ([(1000, b"+++")], True),
    ([(1000, b"+"), (1300, b"+"), (1600, b"+")], True),
    ([(1000, b"++"), (1999, b"+")], True),
    ([(999, b"+++")], False),
    ([(1000, b"x"), (1999, b"+++")], False),
    ([(1000, b"x"), (2000, b"+++")], True),
    ([(1000, b"x+++")], False),
    ([(1000, b"+++x")], False),
    ([(1000, b"++++")], False),
    ([(1000, b"+++"), (1001, b"+")], False),
    ([(1000, b"++"), (2000, b"+")], False),  # the silence begins again
    ([(1000, b"+"), (2000, b"+++")], True),
    ([(1000, b"++x+")], False),
    ([(1000, b"+++"), (1500, b"x"), (2500, b"+++")], True),
]


@pytest.mark.parametrize(("chunks", "expected"), ROWS)
def test_three_characters_with_silence_before_them(chunks: list[tuple[int, bytes]], expected: bool) -> None:
    assert is_escape(chunks) is expected


@pytest.mark.parametrize(("data", "expected"), [(b"x+++", True), (b"+++x", False), (b"++", False), (b"a+++", True)])
def test_without_guard_time_only_the_characters_count(data: bytes, expected: bool) -> None:
    assert is_escape([(1, data)], 0) is expected


def test_a_character_above_127_turns_it_off() -> None:
    assert not Escape().hear(10_000 * MS, b"\x80\x80\x80", 128, 0)


chunks = st.lists(
    st.tuples(st.integers(1, 1500), st.sampled_from([b"+", b"++", b"+++", b"x", b"+x", b"x+"])), max_size=9
)


@given(chunks)
def test_it_is_the_same_as_the_rule(pauses: list[tuple[int, bytes]]) -> None:
    """Exactly three characters since a silence of the guard time, and no longer pause among them."""
    now_ms, timed = 0, []
    for pause_ms, data in pauses:
        now_ms += pause_ms
        timed.append((now_ms, data))
    since: bytes | None = None  # what came since the last silence
    last_ms = 0
    for when_ms, data in timed:
        since = data if when_ms - last_ms >= GUARD_MS else None if since is None else since + data
        last_ms = when_ms
    assert is_escape(timed) is (since == b"+++")
