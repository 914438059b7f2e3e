"""Stations of a process hear the same, whether the cycle takes the short way or each name is looked at."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.bus import Attachment
from fieldrig.testing import plain_forms
from fieldrig_bus.ring.pam import cycle_wire as pam_wire
from fieldrig_bus.ring.pam import message as pam
from fieldrig_bus.ring.pam.star_bus import NodeRack
from fieldrig_bus.ring.sercos import cycle_wire as sercos_wire
from fieldrig_bus.ring.sercos import message as sercos
from fieldrig_bus.ring.sercos.star_bus import DriveRack
from fieldrig_bus.ring.transport.spread import ALIKE
from fieldrig_bus.ring.transport.wire import decode_back

ALL = ("a", "b", "c")
"""The stations of the ring; the process has the first two of them, and an observer."""
FRAMES = st.lists(st.tuples(st.integers(0, 255), st.binary(min_size=1, max_size=6)), max_size=3).map(tuple)
OBSERVED = (b"", pam.encode(pam.Reports(7, ((1, b"\x05"),), (1, 2))))
ANSWERS = (b"", sercos.encode(sercos.Answers(7, (b"\x03\x08\xc0",), True)))


def pam_cycles() -> st.SearchStrategy[bytes]:
    good = st.builds(pam.Cycle, st.just(5), FRAMES)
    bad = st.sampled_from(list(pam.Reception)[1:]).map(lambda reception: pam.Cycle(5, (), reception))
    return spreads(pam_wire.encode_spread, good, bad, OBSERVED)


def sercos_cycles() -> st.SearchStrategy[bytes]:
    good = st.builds(sercos.Cycle, st.just(5), st.just(b"\xff\x04"), st.binary(max_size=6))
    bad = st.sampled_from([sercos.Cycle(5, b"", b""), sercos.Cycle(5, b"\xff\x04", b"")])
    return spreads(sercos_wire.encode_spread, good, bad, ANSWERS)


def spreads(
    encode: Callable[..., bytes], good: st.SearchStrategy[Any], bad: st.SearchStrategy[Any], answers: Sequence[bytes]
) -> st.SearchStrategy[bytes]:
    """Cycles that all stations hear alike, some of them another one, and some of them nothing."""

    def encoded(first: Any, hearing: int, other: Any, behind: int, answer: bytes) -> bytes:
        heard = [(first, ALL[:hearing]), (other, ALL[hearing : hearing + behind])]
        return encode(1, 2, [row for row in heard if row[1]] or heard[:1], answer, len(ALL))

    whole = good.flatmap(
        lambda cycle: st.sampled_from(answers).map(lambda answer: encode(1, 2, [(cycle, ALL)], answer, len(ALL)))
    )
    split = st.builds(encoded, good, st.integers(0, 3), bad, st.integers(0, 2), st.sampled_from(answers))
    cut = st.builds(lambda data, end: data[:end], whole, st.integers(0, 30))
    odd = st.builds(
        lambda data, at, byte: data[:at] + bytes([byte]) + data[at + 1 :], whole, st.integers(12, 20), BYTES
    )
    return st.one_of(whole, split, cut, odd)


BYTES = st.integers(0, 255)


class _At:
    def __init__(self, member: str, said: list[Any]) -> None:
        self.member, self._said = member, said

    def deliver(self, handler: Callable[[Any], None], message: Any, instant_ns: int | None = None) -> None:
        self._said.append((self.member, message, instant_ns))
        handler(message)


def said(kind: type[NodeRack] | type[DriveRack], messages: Iterable[bytes]) -> list[Any]:
    """Return all that the stations hear, and all that goes back to the centre, in its order."""
    found: list[Any] = []
    rack = kind("ring0", cast(Any, None))
    for address, member in enumerate((*ALL[:2], "scope"), 1):
        at = cast(Attachment, _At(member, found))
        interest = None if member == "scope" else [["drive", address]]
        rack.listen(at, lambda _message, member=member: rack.leave(member, member.encode()), interest)  # type: ignore[misc]
    rack.connect(lambda _stations: None, lambda back: found.append(decode_back(back)[2]))
    for message in messages:
        rack.on_spread(message)
    return found


@pytest.mark.parametrize(("kind", "cycles"), [(NodeRack, pam_cycles()), (DriveRack, sercos_cycles())])
@given(data=st.data())
def test_stations_hear_the_same_by_the_short_way(
    kind: type[NodeRack] | type[DriveRack], cycles: st.SearchStrategy[bytes], data: st.DataObject
) -> None:
    messages = data.draw(st.lists(cycles, min_size=1, max_size=4))
    with plain_forms(ALIKE.name):
        plain = said(kind, messages)
    assert said(kind, messages) == plain
