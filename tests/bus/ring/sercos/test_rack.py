"""The drives of one process: for any message they hear what `cycle_wire` decodes, and all answer together."""

from typing import Any, cast

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.bus import Attachment
from fieldrig_bus.ring.sercos.cycle_wire import CYCLE_HEAD, decode_spread, encode_spread
from fieldrig_bus.ring.sercos.message import Answers, Cycle, encode
from fieldrig_bus.ring.sercos.star_bus import DriveRack
from fieldrig_bus.ring.transport.wire import HEAD, decode_back

MST, MDT = b"\xff\x04", b"\xff\x0b\xc0"
ANSWERS = encode(Answers(7, (b"\x03\x08\xc0",), True))
NAMES = ("belt", "lift", "door")
BYTES = st.sampled_from([b"", MST, MDT])


class _At:
    def __init__(self, member: str) -> None:
        self.member = member
        self.heard: list[Any] = []

    def deliver(self, handler: Any, message: Any, instant_ns: int | None = None) -> None:
        handler(message)
        self.heard.append(message)


class _Process:
    """A belt and a lift, which leave an AT in every cycle, and an observer."""

    def __init__(self, drives: int = 2) -> None:
        self.rack = DriveRack("ring0", cast(Any, None))
        self.backs: list[bytes] = []
        self.at = {name: _At(name) for name in ("belt", "lift", "scope")}
        for address, name in enumerate(("belt", "lift")[:drives], 1):
            self.rack.listen(cast(Attachment, self.at[name]), self._reaction(name, address), [["drive", address]])
        self.rack.listen(cast(Attachment, self.at["scope"]), lambda _message: None, None)
        self.rack.connect(lambda _stations: None, self.backs.append)

    def _reaction(self, name: str, address: int) -> Any:
        return lambda _message: self.rack.leave(name, bytes((address, 8)))

    def heard(self) -> dict[str, list[Any]]:
        return {name: at.heard for name, at in self.at.items()}


def as_the_wire_says(data: bytes) -> dict[str, list[Any]]:
    try:
        spread = decode_spread(data)
    except ValueError:
        return {"belt": [], "lift": [], "scope": []}
    if len(spread.heard) == 1 and not spread.heard[0][1]:
        heard = {name: [spread.heard[0][0]] for name in ("belt", "lift")}
    else:
        heard = {name: [cycle for cycle, names in spread.heard if name in names][-1:] for name in ("belt", "lift")}
    cycles = list(dict.fromkeys(cycle for cycle, _ in spread.heard))
    return {**heard, "scope": [Answers(7, (b"\x03\x08\xc0",), True), *cycles] if spread.answers else []}


@given(st.lists(st.tuples(BYTES, BYTES), max_size=3), st.sampled_from([b"", ANSWERS]), st.data())
def test_each_hears_what_the_wire_says(cycles: list[tuple[bytes, bytes]], answers: bytes, data: st.DataObject) -> None:
    groups: dict[Cycle, list[str]] = {}
    for name, (mst, mdt) in zip(NAMES, cycles, strict=False):
        groups.setdefault(Cycle(5, mst, mdt), []).append(name)
    stations = data.draw(st.integers(len(cycles), 4))
    process = _Process()
    message = encode_spread(1, 2, list(groups.items()), answers, stations) if groups else b""
    process.rack.on_spread(message)
    assert process.heard() == as_the_wire_says(message)


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(st.integers(0, 60), st.integers(0, 2), st.binary(max_size=40))
def test_of_a_cycle_with_any_head_each_hears_what_the_wire_says(mst_end: int, is_more: int, rest: bytes) -> None:
    process = _Process()
    message = HEAD.pack(1, 2) + CYCLE_HEAD.pack(5, mst_end, is_more) + rest
    process.rack.on_spread(message)
    assert process.heard() == as_the_wire_says(message)


@given(st.binary(max_size=40))
def test_bytes_that_are_no_cycle_are_passed_over(data: bytes) -> None:
    process = _Process()
    process.rack.on_spread(data)
    assert process.heard() == as_the_wire_says(data)


def test_what_the_only_drive_has_left_before_goes_first() -> None:
    process = _Process(1)
    process.rack._is_coming_back = True  # in the next iteration of the event loop
    process.rack.leave("belt", b"\1before")
    for sequence in (9, 10):
        process.rack.on_spread(encode_spread(sequence, 2, [(Cycle(5, MST, MDT), ["belt"])], b"", 1))
    heard = [(sequence, ats) for sequence, _, ats in map(decode_back, process.backs)]
    assert heard == [(9, [(0, b"\1before"), (0, b"\1\x08")]), (10, [(0, b"\1\x08")])]
    process.rack.on_spread(encode_spread(8, 2, [(Cycle(5, MST, MDT), ["belt"])], b"", 1))
    assert len(process.backs) == 2, "it was overtaken"


def test_no_telegram_is_sent_while_there_is_no_centre() -> None:
    process = _Process(1)
    process.rack.disconnect()
    process.rack.on_spread(encode_spread(9, 2, [(Cycle(5, MST, MDT), ["belt"])], b"", 1))
    assert process.backs == []


def test_all_answers_of_a_cycle_go_back_in_one_message() -> None:
    process = _Process()
    process.rack.on_spread(encode_spread(9, 2, [(Cycle(5, MST, MDT), ["belt", "lift"])], b"", 2))
    (back,) = process.backs
    sequence, _, ats = decode_back(back)
    assert (sequence, ats) == (9, [(0, b"\x01\x08"), (1, b"\x02\x08")])
