"""Every kind of SERCOS ring keeps the same promises, and carries the same bytes for the same inputs."""

from collections.abc import Iterator
from typing import Any

import pytest
from any_ring import ADDRESSES, run_through, throw_garbage
from ring_kinds import KINDS, MDT, MST, STARS, Master, Ring, StarRing, hearing, virtual

from fieldrig.errors import BusError
from fieldrig_bus.ring.sercos.message import Answers, Cycle, encode

pytestmark = pytest.mark.system

ALL_WELL = dict.fromkeys(ADDRESSES, (True, True))


@pytest.fixture(params=KINDS, ids=str)
def ring(request: pytest.FixtureRequest) -> Iterator[Ring]:
    with KINDS[request.param](bypassed=["knife"]) as ring:
        for name, address in ADDRESSES.items():
            ring.join(name, address)
        ring.cycle()
        yield ring


@pytest.fixture(params=STARS, ids=str)
def star(request: pytest.FixtureRequest) -> Iterator[StarRing]:
    with STARS[request.param]() as ring:
        for name, address in ADDRESSES.items():
            ring.join(name, address)
        ring.cycle()
        yield ring


def addresses(answers: Answers) -> list[int]:
    return [at[0] for at in answers.ats]


def test_the_master_hears_all_in_the_order_of_the_ring_and_they_hear_it(ring: Ring) -> None:
    assert ring.cycle() == Answers(1, (b"\x03\x01", b"\x01\x01", b"\x02\x01", b"\x04\x01"), True)
    assert all(drive.heard == [Cycle(0, MST, MDT), Cycle(1, MST, MDT)] for drive in ring.stations.values())


@pytest.mark.parametrize("kind", KINDS)
def test_the_order_of_the_ring_may_be_another_than_that_of_the_file(kind: str) -> None:
    with KINDS[kind](order=["door", "knife", "lift", "belt"]) as ring:
        for name, address in ADDRESSES.items():
            ring.join(name, address)
        ring.cycle()
        assert addresses(ring.cycle()) == [4, 2, 1, 3]


@pytest.mark.manual("PD-140")
def test_behind_a_break_nothing_is_heard_and_healing_brings_all_back(ring: Ring) -> None:
    number = ring.fault(what="break", after="lift")
    behind = {"knife": (False, False), "door": (False, False)}
    assert hearing(ring) == ALL_WELL | behind
    assert ring.cycle() == Answers(2, (), False)
    assert ring.statistics()["ring_closed"] == 0
    ring.clear(number)
    assert hearing(ring) == ALL_WELL
    assert addresses(ring.cycle()) == [3, 1, 2, 4]


@pytest.mark.manual("PD-140")
def test_a_station_without_power_hears_nothing_and_opens_the_ring(ring: Ring) -> None:
    ring.fault(what="off", station="lift")
    assert hearing(ring) == {"belt": (True, True), "knife": (False, False), "door": (False, False)}
    assert not ring.cycle().ring_closed


def test_a_bypassed_station_does_not_open_the_ring(ring: Ring) -> None:
    ring.fault(what="off", station="knife")
    ring.cycle()
    assert ring.cycle() == Answers(2, (b"\x03\x02", b"\x01\x02", b"\x04\x02"), True)


def test_distortion_spoils_what_one_station_hears(ring: Ring) -> None:
    ring.fault(what="distort", station="knife", telegram="mdt", count=1)
    assert hearing(ring) == ALL_WELL | {"knife": (True, False)}
    assert hearing(ring) == ALL_WELL


def test_distortion_spoils_what_passes_a_segment(ring: Ring) -> None:
    ring.fault(what="distort", after="belt", telegram="mst", count=1)
    lost = dict.fromkeys(("lift", "knife", "door"), (False, True))
    assert hearing(ring) == ALL_WELL | lost


def test_a_distorted_at_is_not_heard_but_counted(ring: Ring) -> None:
    ring.fault(what="distort", station="lift", telegram="at", count=1)
    answers = ring.cycle()
    assert (addresses(answers), answers.errors) == ([3, 2, 4], 1)
    assert ring.statistics()["wrong_fcs"] == 1
    assert addresses(ring.cycle()) == [3, 1, 2, 4]


def test_a_late_at_misses_its_slot_and_is_counted(ring: Ring) -> None:
    ring.fault(what="late", station="belt", count=2)
    heard = [ring.cycle() for _ in range(3)]
    assert [(addresses(answers), answers.late) for answers in heard] == [
        ([1, 2, 4], 1),
        ([1, 2, 4], 1),
        ([3, 1, 2, 4], 0),
    ]
    assert ring.statistics()["late"] == 2


@pytest.mark.parametrize("kind", KINDS)
def test_two_stations_of_one_address_destroy_each_others_at(kind: str) -> None:
    with KINDS[kind]() as ring:
        for name in ADDRESSES:
            ring.join(name, {"lift": 3}.get(name, ADDRESSES[name]))
        ring.cycle()
        answers = ring.cycle()
        assert (addresses(answers), answers.errors) == ([2, 4], 2)


def test_an_observer_hears_answers_and_cycles_without_being_a_station(ring: Ring) -> None:
    heard = ring.observe("scope")
    answers = ring.cycle()
    assert heard == [answers, Cycle(1, MST, MDT)]
    ring.fault(what="break", after="lift")
    answers = ring.cycle()
    assert heard[2:] == [answers, Cycle(2, MST, MDT), Cycle(2, b"", b"")]
    assert ring.statistics()["stations"] == 4


def test_only_the_master_begins_cycles_and_a_station_answers_for_itself(ring: Ring) -> None:
    before = len(ring.trace)
    belt, lift = ring.stations["belt"], ring.stations["lift"]
    belt.link.send(encode(Cycle(0, MST, MDT)))  # a telegram of another address
    lift.address = 7
    ring.cycle()
    assert addresses(ring.cycle()) == [3, 2, 4]
    assert len(ring.trace) == before + 4


def script(ring: Ring) -> list[tuple[str, bytes]]:
    """A sequence with every event that can happen to a ring."""
    for name, address in ADDRESSES.items():
        ring.join(name, address)
    for _ in range(3):
        ring.cycle()
    faults: tuple[dict[str, Any], ...] = (
        {"what": "break", "after": "lift"},
        {"what": "off", "station": "knife"},
        {"what": "distort", "station": "belt", "telegram": "mdt"},
        {"what": "distort", "after": "belt", "probability": 0.5},
        {"what": "distort", "after": "master", "telegram": "mst"},
        {"what": "distort", "station": "door", "telegram": "at", "probability": 0.5},
        {"what": "late", "station": "lift", "probability": 0.5},
    )
    run_through(ring, faults)
    return ring.trace


@pytest.mark.parametrize("kind", STARS)
def test_the_same_inputs_give_the_same_bytes_as_in_virtual_time(kind: str) -> None:
    with virtual() as ring:
        expected = script(ring)
    assert len(expected) > 100
    with STARS[kind]() as ring:
        assert script(ring) == expected


# -- events that only happen in real time


def test_a_process_that_is_not_done_in_time_is_late_and_counted_for_each_station(star: StarRing) -> None:
    star.clock.handle(star.master.begin)
    star.clock.handle(star.master.begin)  # no drive had the time to react
    assert star.master.heard[-1] == Answers(2, (), True, late=4)
    star.settle()
    assert addresses(star.cycle()) == [3, 1, 2, 4]
    counted = {name: count for name, count in star.statistics().items() if name.startswith("late.")}
    assert counted == {"late.belt": 1, "late.lift": 1, "late.knife": 1, "late.door": 1}
    assert star.statistics()["most_cycles_late"] == 1


def test_an_at_that_came_late_is_sent_in_the_next_cycle(star: StarRing) -> None:
    star.clock.handle(star.master.begin)
    star.clock.handle(star.master.begin)
    star.settle()
    assert star.cycle().ats == (b"\x03\x03", b"\x01\x03", b"\x02\x03", b"\x04\x03")


@pytest.mark.parametrize("kind", STARS)
def test_a_patient_ring_repeats_the_last_at_of_a_late_station_and_counts_it(kind: str) -> None:
    with STARS[kind](patience_ms=10_000) as star:
        for name, address in ADDRESSES.items():
            star.join(name, address)
        star.cycle()
        star.clock.handle(star.master.begin)
        star.clock.handle(star.master.begin)
        assert star.master.heard[-1] == Answers(2, (b"\x03\x01", b"\x01\x01", b"\x02\x01", b"\x04\x01"), True, late=4)
        star.settle()
        assert star.cycle().ats == (b"\x03\x03", b"\x01\x03", b"\x02\x03", b"\x04\x03")
        star.kill("rack")
        star.until_there(2)
        star.cycle()
        assert star.cycle() == Answers(5, (), False), "the telegrams of a process that is gone are not repeated"


@pytest.mark.manual("PD-140")
def test_a_process_that_dies_opens_the_ring_and_closes_it_when_it_comes_back(star: StarRing) -> None:
    star.kill("rack")
    star.until_there(2)
    assert hearing(star) == {"belt": (True, True), "door": (False, False)}
    assert star.cycle() == Answers(2, (), False)
    star.join("knife", 2)
    assert not star.cycle().ring_closed
    star.join("lift", 1)
    star.cycle()
    assert star.cycle() == Answers(5, (b"\x03\x05", b"\x01\x01", b"\x02\x02", b"\x04\x05"), True)


def test_a_process_that_stands_still_is_sent_nothing_until_it_has_caught_up(star: StarRing) -> None:
    """The whole bench has one event loop: while it is not pumped, all processes stand still."""
    for _ in range(40):
        star.clock.handle(star.master.begin)
    assert star.master.heard[-1].late == 4
    star.settle()
    star.clock.handle(star.master.begin)  # here the centre notices that they are back
    star.settle()
    star.cycle()
    assert addresses(star.cycle()) == [3, 1, 2, 4]
    assert star.statistics()["most_cycles_late"] == 39


def test_a_master_that_comes_back_finds_its_drives(star: StarRing) -> None:
    star.kill("max4")
    heard = {name: len(drive.heard) for name, drive in star.stations.items()}
    star.begin()
    star.until_there(3)
    assert not star.cycle().ring_closed  # the door was in the master's process
    star.join("door", 4)
    star.cycle()
    assert addresses(star.cycle()) == [3, 1, 2, 4]
    assert all(len(drive.heard) == heard.get(name, -1) + 3 for name, drive in star.stations.items() if name != "door")


def test_a_second_master_is_refused(star: StarRing) -> None:
    with pytest.raises(BusError, match="master"):
        Master(star.open("other", "other"))
    assert addresses(star.cycle()) == [3, 1, 2, 4]


def test_garbage_from_outside_has_no_effect(star: StarRing) -> None:
    throw_garbage(star)
    assert hearing(star) == ALL_WELL
