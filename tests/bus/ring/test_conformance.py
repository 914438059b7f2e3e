"""Every kind of ring, of both families, keeps the same promises, and carries the same bytes for the same inputs."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest
from any_ring import ADDRESSES, all_joined, last_heard, run_through, throw_garbage
from ring_families import FAMILIES, Family

from fieldrig.errors import BusError
from fieldrig.faults import note
from fieldrig.faults.note import FaultNote

pytestmark = pytest.mark.system

IN_ORDER = [3, 1, 2, 4]
KINDS = [(family, kind) for family in FAMILIES for kind in FAMILIES[family].kinds]
STARS = [(family, kind) for family in FAMILIES for kind in FAMILIES[family].stars]


class Bench(NamedTuple):
    """A ring, with what the suite has to know of its family."""

    family: Family
    ring: Any

    def hear(self) -> list[int]:
        """Run a cycle, and return the addresses of which the master hears."""
        return self.family.addresses(self.ring.cycle())

    def is_closed(self) -> bool:
        """Run a cycle, and return whether the ring was closed."""
        return self.family.is_closed(self.ring.cycle())

    def served(self) -> set[str]:
        """Run a cycle, and return the stations that hear all of it."""
        return {name for name, heard in last_heard(self.ring).items() if self.family.is_whole(heard)}


@pytest.fixture(params=KINDS, ids=lambda param: " ".join(param))
def bench(request: pytest.FixtureRequest) -> Iterator[Bench]:
    family, kind = request.param
    with FAMILIES[family].kinds[kind](bypassed=["knife"]) as ring:
        yield Bench(FAMILIES[family], all_joined(ring))


@pytest.fixture(params=STARS, ids=lambda param: " ".join(param))
def star(request: pytest.FixtureRequest) -> Iterator[Bench]:
    family, kind = request.param
    with FAMILIES[family].stars[kind]() as ring:
        yield Bench(FAMILIES[family], all_joined(ring))


@pytest.mark.parametrize(("family", "kind"), KINDS)
def test_the_order_of_the_ring_may_be_another_than_that_of_the_file(family: str, kind: str) -> None:
    with FAMILIES[family].kinds[kind](order=["door", "knife", "lift", "belt"]) as ring:
        assert FAMILIES[family].addresses(all_joined(ring).cycle()) == [4, 2, 1, 3]


@pytest.mark.manual("PD-140")
@pytest.mark.manual("PAMS-108")
def test_behind_a_break_nothing_is_heard_and_healing_brings_all_back(bench: Bench) -> None:
    number = bench.ring.fault(what="break", after="lift")
    assert bench.served() == {"belt", "lift"}
    assert bench.hear() == []
    assert not bench.is_closed()
    assert bench.ring.statistics()["ring_closed"] == 0
    bench.ring.clear(number)
    assert bench.served() == ADDRESSES.keys()
    assert bench.hear() == IN_ORDER


@pytest.mark.manual("PD-140")
def test_a_station_without_power_opens_the_ring_unless_it_has_a_bypass(bench: Bench) -> None:
    number = bench.ring.fault(what="off", station="knife")
    assert bench.served() == ADDRESSES.keys() - {"knife"}
    assert bench.hear() == [3, 1, 4]
    assert bench.is_closed()
    bench.ring.clear(number)
    bench.ring.fault(what="off", station="lift")
    assert bench.served() == {"belt"}
    assert not bench.is_closed()


def test_an_observer_hears_what_master_and_stations_hear_without_being_a_station(bench: Bench) -> None:
    heard, stations = bench.ring.observe("scope"), bench.ring.stations
    answers = bench.ring.cycle()
    assert heard == [answers, stations["belt"].heard[-1]]
    bench.ring.fault(what="break", after="lift")
    answers = bench.ring.cycle()
    assert heard[2:] == [answers, stations["belt"].heard[-1], stations["knife"].heard[-1]]
    assert bench.ring.statistics()["stations"] == 4


def test_the_trace_shows_what_a_fault_does_and_a_state_counts_once(bench: Bench) -> None:
    for fault in ({"what": "break", "after": "lift"}, {"what": "off", "station": "belt", "start_ms": 1_000_000}):
        bench.ring.fault(**fault)
    bench.ring.fault(what="distort", after="belt", count=1)
    for _ in range(3):
        bench.ring.cycle()
    seen = [note.decode(data) for _, data in bench.ring.trace if data.startswith(note.LEAD)]
    assert seen == [FaultNote(1, "break after lift"), FaultNote(3, "distort after belt")]
    assert [about["applied"] for about in bench.ring.faults().values()] == [1, 0, 1]


def script(family: Family, ring: Any) -> list[tuple[str, bytes]]:
    """A sequence with every event that can happen to a ring."""
    all_joined(ring)
    run_through(ring, family.faults)
    return ring.trace  # type: ignore[no-any-return]


@pytest.mark.parametrize(("family", "kind"), STARS)
def test_the_same_inputs_give_the_same_bytes_as_in_virtual_time(family: str, kind: str) -> None:
    which = FAMILIES[family]
    with which.kinds["virtual"]() as ring:
        expected = script(which, ring)
    assert len(expected) > 80
    with which.stars[kind]() as ring:
        assert script(which, ring) == expected


# -- events that only happen in real time


def test_a_process_that_is_not_done_in_time_is_late_and_counted_for_each_station(star: Bench) -> None:
    ring = star.ring
    ring.clock.handle(ring.master.begin)
    ring.clock.handle(ring.master.begin)  # no station had the time to react
    last = ring.master.heard[-1]
    assert (star.family.addresses(last), star.family.is_closed(last), last.late) == ([], True, 4)
    ring.settle()
    assert star.hear() == IN_ORDER
    counted = {name: count for name, count in ring.statistics().items() if name.startswith("late.")}
    assert counted == {"late.belt": 1, "late.lift": 1, "late.knife": 1, "late.door": 1}
    assert ring.at["max4"].late_ns > 0  # its log says so beside what the ring does then


@pytest.mark.manual("PD-140")
def test_a_process_that_dies_opens_the_ring_and_closes_it_when_it_comes_back(star: Bench) -> None:
    star.ring.kill("rack")
    star.ring.until_there(2)
    assert star.served() == {"belt"}
    assert not star.is_closed()
    star.ring.join("knife", 2)
    assert not star.is_closed()
    star.ring.join("lift", 1)
    star.ring.cycle()
    assert star.hear() == IN_ORDER
    assert star.is_closed()


def test_a_master_that_comes_back_finds_its_stations(star: Bench) -> None:
    star.ring.kill("max4")
    heard = {name: len(station.heard) for name, station in star.ring.stations.items()}
    star.ring.begin()
    star.ring.until_there(3)
    assert not star.is_closed(), "the door was in the process of the master"
    star.ring.join("door", 4)
    star.ring.cycle()
    assert star.hear() == IN_ORDER
    assert all(len(star.ring.stations[name].heard) == before + 3 for name, before in heard.items())


def test_a_second_master_is_refused(star: Bench) -> None:
    with pytest.raises(BusError, match="master"):
        star.family.master(star.ring.open("other", "other"))
    assert star.hear() == IN_ORDER


def test_garbage_from_outside_has_no_effect(star: Bench) -> None:
    throw_garbage(star.ring)
    assert star.served() == ADDRESSES.keys()
