"""The messages between the centre and the processes of its drives."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.ring.sercos.cycle_wire import decode_spread, encode_spread
from fieldrig_bus.ring.sercos.message import Cycle
from fieldrig_bus.ring.transport.spread import Spread
from fieldrig_bus.ring.transport.wire import decode_back, encode_back

NUMBERS = st.integers(0, 0xFFFF_FFFF)
INSTANTS = st.integers(0, 2**62)
NAMES = st.lists(st.from_regex(r"[a-z][a-z0-9_-]{0,12}", fullmatch=True), unique=True, min_size=1, max_size=6)
AT = st.tuples(st.integers(0, 46), st.binary(min_size=1, max_size=40))


@given(NUMBERS, INSTANTS, NUMBERS, st.binary(max_size=2), st.binary(max_size=300), NAMES, st.binary(max_size=40))
def test_no_station_is_named_where_all_hear_the_same(
    sequence: int, instant_ns: int, number: int, mst: bytes, mdt: bytes, names: list[str], answers: bytes
) -> None:
    cycle = Cycle(number, mst, mdt)
    data = encode_spread(sequence, instant_ns, [(cycle, names)], answers, len(names))
    assert decode_spread(data) == Spread(sequence, instant_ns, [(cycle, ())], answers)


@given(NUMBERS, NAMES, st.data())
def test_the_stations_of_each_telegram_come_back(number: int, names: list[str], data: st.DataObject) -> None:
    groups: dict[Cycle, list[str]] = {}
    for name in names:
        mst, mdt = data.draw(st.sampled_from([b"", b"\xff\x04"])), data.draw(st.sampled_from([b"", b"\xff\x01\x02"]))
        groups.setdefault(Cycle(number, mst, mdt), []).append(name)
    heard = list(groups.items())
    spread = decode_spread(encode_spread(1, 2, heard, b"", len(names) + 1))
    assert spread.heard == heard


@given(NUMBERS, INSTANTS, st.lists(AT, max_size=8))
def test_what_comes_back_is_what_was_left(sequence: int, instant_ns: int, ats: list[tuple[int, bytes]]) -> None:
    assert decode_back(encode_back(sequence, instant_ns, ats)) == (sequence, instant_ns, ats)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=80))
def test_anything_else_is_refused_or_read(data: bytes) -> None:
    for decode in (decode_spread, decode_back):
        try:
            decode(data)
        except ValueError:
            continue


@pytest.mark.parametrize("cut", [1, 2, 3, 4, 5, 7, 8, 11])  # 6 is a whole AT
def test_what_is_cut_short_is_refused(cut: int) -> None:
    spread = encode_spread(1, 2, [(Cycle(3, b"\xff\x04", b"\xff\x01"), ["belt", "lift"])], b"", 3)
    back = encode_back(1, 2, [(0, b"\x03\x01\x02")])
    with pytest.raises(ValueError, match="cycle"):
        decode_spread(spread[:-cut])
    with pytest.raises(ValueError, match="cut short"):
        decode_back(back[:-cut])
