"""The specific behaviour of a ring over Zenoh."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from any_ring import ADDRESSES, StarAt
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from ring_kinds import StarRing, hearing, zenoh

from fieldrig.control import endpoint
from fieldrig.errors import BusError
from fieldrig.outside.shared_token import TOKEN_VARIABLE
from fieldrig.testing import free_port
from fieldrig_bus.ring.sercos.cycle_wire import encode_spread
from fieldrig_bus.ring.sercos.message import Cycle
from fieldrig_bus.ring.sercos.zenoh import RingZenoh, RingZenohSettings
from fieldrig_bus.ring.transport.zenoh import ZenohSpokes, _stations_of, _token_of

pytestmark = pytest.mark.system

ALL_WELL = dict.fromkeys(ADDRESSES, (True, True))
STATIONS = st.lists(
    st.tuples(
        st.from_regex(r"[a-z][a-z0-9_-]{0,12}", fullmatch=True), st.none() | st.lists(st.integers(1, 254), max_size=3)
    ),
    min_size=1,
    max_size=5,
)


@pytest.fixture
def ring() -> Iterator[StarRing]:
    with zenoh() as ring:
        for name, address in ADDRESSES.items():
            ring.join(name, address)
        ring.cycle()
        yield ring


@given(STATIONS)
def test_a_token_says_which_stations_a_process_has(stations: list[tuple[str, list[int] | None]]) -> None:
    assert _stations_of(_token_of(stations)) == stations


@given(st.text(max_size=40))
def test_any_other_token_is_read_as_far_as_it_goes(token: str) -> None:
    _stations_of(token)


def test_malformed_messages_from_outside_are_harmless(ring: StarRing) -> None:
    place = f"unixsock-stream/{ring.at['max4'].path('ring0.zenoh')}"
    session = endpoint.open_session({"mode": "peer", "listen/endpoints": [], "connect/endpoints": [place]})
    try:
        tokens: list[Any] = [
            session.liveliness().declare_token(f"here/{token}") for token in ("x", "x/y/z/a=1", "x/1/1/a=b")
        ]
        for key, data in (
            ("back/belt", b"\xff"),
            ("back/nobody", b"\0" * 12),
            ("all", b"nonsense"),
            ("out/belt", b"nonsense"),
        ):
            session.put(key, data)
        assert hearing(ring) == ALL_WELL
        for token in tokens:
            token.undeclare()
        assert hearing(ring) == ALL_WELL
    finally:
        endpoint.close(session)


def test_a_process_whose_token_was_lost_is_found_by_what_it_sends(ring: StarRing) -> None:
    """The end of an old connection may be heard after the next one has declared the same token."""
    stations, spokes = ring.star.statistics()["stations"], ring.star._spokes
    assert isinstance(spokes, ZenohSpokes)
    ((born, turn),) = spokes._here["rack"]
    spokes._on_here(f"here/rack/{born}/{turn}/lift=1;knife=2", False)
    assert ring.star.statistics()["stations"] == stations - 2

    def is_found() -> bool:
        ring.clock.handle(ring.master.begin)
        return ring.star.statistics()["stations"] == stations

    ring.pump(is_found)
    assert hearing(ring) == ALL_WELL


def test_a_process_that_stands_still_is_sent_nothing_while_others_hear_all(ring: StarRing) -> None:
    spokes = ring.star._spokes
    assert spokes is not None
    heard = {name: len(drive.heard) for name, drive in ring.stations.items()}
    ring.star._hung["rack"] = ring.star._sequence + 20
    ring.clock.handle(ring.master.begin)
    ring.pump(lambda: len(ring.stations["belt"].heard) > heard["belt"])
    assert len(ring.stations["lift"].heard) == heard["lift"]


def test_a_cycle_that_another_has_overtaken_is_not_heard_any_more(ring: StarRing) -> None:
    belt, rack = ring.stations["belt"], ring.buses["belt"].rack(ring.at["belt"])
    before = len(belt.heard)
    for number in (100, 99, 101, 1):  # 1: another master
        rack.on_spread(encode_spread(number, 0, [(Cycle(number, b"\xff\x04", b""), ["belt"])], b"", 1))
    assert [cycle.number for cycle in belt.heard[before:] if isinstance(cycle, Cycle)] == [100, 101, 1]


def test_an_address_that_others_can_reach_asks_for_a_token(ring: StarRing, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(TOKEN_VARIABLE, raising=False)
    open_to_all = RingZenoh("ring1", RingZenohSettings(endpoint=f"tcp/0.0.0.0:{free_port()}"))
    with pytest.raises(BusError, match="other machines"):
        open_to_all.carrier.hold(ring.at["max4"], ring.star)


def test_a_folder_with_too_long_a_path_is_an_error_with_a_remedy(ring: StarRing, tmp_path: Path) -> None:
    at = StarAt("max4", ring.clock, "max4", tmp_path / ("x" * 120))
    with pytest.raises(BusError, match="too long") as refused:
        ring.buses["max4"].carrier.hold(at, ring.star)
    assert "endpoint" in refused.value.remedy


def test_an_endpoint_that_is_none_is_refused() -> None:
    with pytest.raises(ValidationError, match="endpoint"):
        RingZenohSettings(endpoint="127.0.0.1:7450")
