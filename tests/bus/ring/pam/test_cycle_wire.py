"""The messages between the centre and the processes of the nodes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.ring.pam.cycle_wire import decode_alike, decode_spread, encode_spread
from fieldrig_bus.ring.pam.message import Cycle, Reception
from fieldrig_bus.ring.transport.spread import Spread

NAMES = st.lists(st.text("abcdefgh", min_size=1, max_size=5), min_size=1, max_size=4, unique=True)
FRAMES = st.lists(st.tuples(st.integers(0, 255), st.binary(min_size=1, max_size=20)), max_size=5).map(tuple)


@given(st.integers(0, 2**32 - 1), FRAMES)
def test_a_cycle_that_all_hear_comes_back(number: int, frames: tuple[tuple[int, bytes], ...]) -> None:
    cycle = Cycle(number, frames)
    assert decode_alike(encode_spread(5, 6, [(cycle, ("a", "b"))], b"", 2)) == cycle


@given(FRAMES, NAMES, st.binary(max_size=10))
def test_what_each_node_hears_comes_back(
    frames: tuple[tuple[int, bytes], ...], names: list[str], reports: bytes
) -> None:
    heard = [(Cycle(3, frames), names), (Cycle(3, (), Reception.NO_CARRIER), ["z"])]
    data = encode_spread(5, 6, heard, reports, 9)
    assert decode_alike(data) is None
    assert decode_spread(data) == Spread(5, 6, heard, reports)


def test_an_observed_cycle_that_all_hear_names_nobody() -> None:
    cycle = Cycle(3, ((1, b"a"),))
    data = encode_spread(5, 6, [(cycle, ("a",))], b"reports", 1)
    assert decode_spread(data) == Spread(5, 6, [(cycle, ())], b"reports")


@given(st.binary(max_size=60))
def test_anything_else_is_refused_or_read(data: bytes) -> None:
    for decode in (decode_alike, decode_spread):
        try:
            decode(data)
        except ValueError:
            continue


def test_a_cycle_of_another_version_is_refused() -> None:
    data = bytearray(encode_spread(5, 6, [(Cycle(3, ()), ())], b"", 0))
    data[12] = 2
    with pytest.raises(ValueError, match="version 2: expected 1"):
        decode_alike(bytes(data))
