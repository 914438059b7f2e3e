"""The picture of a rig: each part has one place, nothing overlaps, and a ring is read in its order."""

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FrameType

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.config.rig_file import load
from fieldrig_page.graph import BusPart, DevicePart, Graph, Shape, Wire, graph_of
from fieldrig_page.layout import Cell, Layout, columns_for, groups_of, layout, partners_of, strip_members

CONFIGS = Path(__file__).parents[2] / "configs"
SCREEN_PX = 1200
"""Width of the picture on a screen of 1280 pixels."""
TELEPHONE_PX = 358


def graph(buses: dict[str, tuple[Shape, Sequence[str]]], devices: Sequence[str], wires: Sequence[Wire] = ()) -> Graph:
    on = {name: tuple(bus for bus, (_, members) in buses.items() if name in members) for name in devices}
    return Graph(
        rig="rig",
        time="virtual",
        devices={name: DevicePart(name, "kind", name, "", on[name]) for name in devices},
        buses={bus: BusPart(bus, "kind", "can", "", shape, tuple(of)) for bus, (shape, of) in buses.items()},
        wires=tuple(wires),
    )


@st.composite
def graphs(draw: st.DrawFn) -> Graph:
    names = [f"d{number}" for number in range(draw(st.integers(0, 14)))]
    buses: dict[str, tuple[Shape, Sequence[str]]] = {}
    for number in range(draw(st.integers(0, 6))):
        members = draw(st.lists(st.sampled_from(names), unique=True, max_size=9)) if names else []
        shape = Shape.CABLE if len(members) < 3 else draw(st.sampled_from([Shape.RING, Shape.BAR, Shape.WIRES]))
        buses[f"b{number}"] = shape, members
    ends = st.tuples(st.sampled_from(names), st.sampled_from(names)) if names else st.nothing()
    pairs = draw(st.lists(ends, max_size=8)) if names else []
    wires = [Wire("b0", f"w{at}", one, (other,)) for at, (one, other) in enumerate(pairs) if one != other]
    return graph(buses, names, wires)


def reading_order(placed: Layout) -> list[str]:
    return sorted(placed.cards, key=lambda name: (placed.cards[name].row, placed.cards[name].column))


@settings(max_examples=60)
@given(graphs(), st.integers(2, 9))
def test_each_part_has_one_place_and_nothing_overlaps(rig: Graph, columns: int) -> None:
    placed = layout(rig, columns)
    assert placed.cards.keys() == rig.devices.keys()
    assert len(set(placed.cards.values())) == len(rig.devices)
    assert all(0 <= cell.column < columns for cell in placed.cards.values())
    assert list(placed.cards) == reading_order(placed)
    places = Counter(
        (strip.row, strip.level, at) for strip in placed.strips for at in range(strip.first, strip.last + 1)
    )
    assert set(places.values()) <= {1}
    assert all(strip.level < placed.levels[strip.row] for strip in placed.strips)
    assert len(placed.levels) == len({cell.row for cell in placed.cards.values()})
    assert layout(rig, columns) == placed
    assert Counter(name for group in groups_of(rig) for name in group) == Counter(dict.fromkeys(rig.devices, 1))


@settings(max_examples=60)
@given(graphs(), st.integers(2, 9))
def test_the_strips_of_a_bus_cover_its_members_of_one_group_and_no_other_card(rig: Graph, columns: int) -> None:
    placed, groups = layout(rig, columns), groups_of(rig)
    for bus in rig.buses.values():
        strips = [strip for strip in placed.strips if strip.bus == bus.name]
        covered = {Cell(strip.row, at) for strip in strips for at in range(strip.first, strip.last + 1)}
        if bus.shape in (Shape.RING, Shape.BAR):
            members = {placed.cards[name] for name in strip_members(rig, groups, bus.name)}
            assert covered == members or (bus.shape is Shape.RING and covered < members)
            assert [strip.is_again for strip in strips].count(False) == 1
        else:
            assert not strips


@settings(max_examples=60)
@given(graphs(), st.integers(2, 9))
def test_a_ring_is_read_in_its_order(rig: Graph, columns: int) -> None:
    placed = layout(rig, columns)
    for group in groups_of(rig):
        homes = [bus for bus in rig.buses.values() if bus.shape is Shape.RING and set(bus.members) <= set(group)]
        for ring in homes[:1]:
            if all(rig.devices[name].buses.count(ring.name) == len(_rings_of(rig, name)) for name in ring.members):
                assert [name for name in reading_order(placed) if name in ring.members] == list(ring.members)


def _rings_of(rig: Graph, name: str) -> list[str]:
    return [bus for bus in rig.devices[name].buses if rig.buses[bus].shape is Shape.RING]


def test_devices_with_a_cable_stand_with_the_bar_of_their_partner() -> None:
    rig = graph({"can": (Shape.BAR, "abc"), "line": (Shape.CABLE, "bm"), "phone": (Shape.CABLE, "mn")}, "abcxmn")
    assert groups_of(rig) == [["a", "b", "c", "m", "n"], ["x"]]


def test_a_cable_binds_closer_than_wires() -> None:
    wires = [Wire("w", f"w{number}", "a", ("p",)) for number in range(9)]
    rig = graph({"can": (Shape.BAR, "abc"), "line": (Shape.CABLE, "pq")}, "abcpq", wires)
    assert groups_of(rig) == [["a", "b", "c"], ["p", "q"]]
    assert partners_of(rig, "p") == ["q", "a"]


def test_a_small_rig_has_large_cards_and_a_telephone_two_columns() -> None:
    assert [columns_for(count, SCREEN_PX) for count in (1, 4, 16, 24, 38)] == [2, 4, 6, 8, 9]
    assert [columns_for(count, TELEPHONE_PX) for count in (1, 4, 16, 24, 38)] == [2, 2, 2, 2, 2]


def test_the_wires_of_the_lab_have_both_ends() -> None:
    rig = graph_of(load(CONFIGS / "lab.yaml"))
    ends = {wire.name: (wire.publisher, wire.readers) for wire in rig.wires}
    assert ends["tank.level"] == ("tank", ("io", "sensor"))
    assert ends["tank.outlet"] == ("io", ("tank",))


@pytest.mark.long
def test_the_whole_machine_is_five_rows_of_one_screen() -> None:
    rig = graph_of(load(CONFIGS / "machine.yaml"))
    placed = layout(rig, columns_for(len(rig.devices), SCREEN_PX))
    assert len(placed.cards) == 38
    assert len(placed.levels) == 5
    assert {strip.bus for strip in placed.strips} == {"can1", "ring", "pamring"}
    assert rig.buses["ring"].members == ("max4", "infeed", "film", "jaw", "outfeed")
    assert rig.buses["pamring"].members[0] == "pam"


def test_a_device_that_keeps_messages_says_in_which_values() -> None:
    devices = graph_of(load(CONFIGS / "conveyor.yaml")).devices
    assert devices["max4"].logs == ("log",)
    assert {device.logs for device in devices.values()} == {("log",), ()}


def calls(work: Callable[[], object]) -> int:
    """Return how many functions are called."""
    count = 0

    def on_event(_frame: FrameType, event: str, _argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(on_event)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count


def test_a_large_rig_does_not_look_at_each_pair_once_for_every_device() -> None:
    """The page of a rig of 500 devices took half a minute of processor time to begin."""
    names = [f"d{number}" for number in range(60)]
    rig = graph({"can": (Shape.BAR, names)}, names)
    assert calls(lambda: [partners_of(rig, name) for name in names]) < 60 * 60 * 10
