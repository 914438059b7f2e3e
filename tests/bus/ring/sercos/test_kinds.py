"""The promises of a SERCOS ring alone, on every kind of it; `test_conformance` has those that a PAM's gives as well."""

from collections.abc import Iterator

import pytest
from any_ring import ADDRESSES, all_joined
from ring_kinds import KINDS, MDT, MST, STARS, Ring, StarRing, hearing

from fieldrig_bus.ring.sercos.message import Answers, Cycle, encode

pytestmark = pytest.mark.system

ALL_WELL = dict.fromkeys(ADDRESSES, (True, True))


@pytest.fixture(params=KINDS, ids=str)
def ring(request: pytest.FixtureRequest) -> Iterator[Ring]:
    with KINDS[request.param](bypassed=["knife"]) as ring:
        yield all_joined(ring)


@pytest.fixture(params=STARS, ids=str)
def star(request: pytest.FixtureRequest) -> Iterator[StarRing]:
    with STARS[request.param]() as ring:
        yield all_joined(ring)


def addresses(answers: Answers) -> list[int]:
    return [at[0] for at in answers.ats]


def test_the_master_hears_all_in_the_order_of_the_ring_and_they_hear_it(ring: Ring) -> None:
    assert ring.cycle() == Answers(1, (b"\x03\x01", b"\x01\x01", b"\x02\x01", b"\x04\x01"), True)
    assert all(drive.heard == [Cycle(0, MST, MDT), Cycle(1, MST, MDT)] for drive in ring.stations.values())


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


def test_only_the_master_begins_cycles_and_a_station_answers_for_itself(ring: Ring) -> None:
    before = len(ring.trace)
    belt, lift = ring.stations["belt"], ring.stations["lift"]
    belt.link.send(encode(Cycle(0, MST, MDT)))  # a telegram of another address
    lift.address = 7
    ring.cycle()
    assert addresses(ring.cycle()) == [3, 2, 4]
    assert len(ring.trace) == before + 4


# -- events that only happen in real time


def test_an_at_that_came_late_is_sent_in_the_next_cycle(star: StarRing) -> None:
    star.clock.handle(star.master.begin)
    star.clock.handle(star.master.begin)
    star.settle()
    assert star.cycle().ats == (b"\x03\x03", b"\x01\x03", b"\x02\x03", b"\x04\x03")


@pytest.mark.parametrize("kind", STARS)
def test_a_patient_ring_repeats_the_last_at_of_a_late_station_and_counts_it(kind: str) -> None:
    with STARS[kind](patience_ms=10_000) as star:
        all_joined(star)
        star.clock.handle(star.master.begin)
        star.clock.handle(star.master.begin)
        assert star.master.heard[-1] == Answers(2, (b"\x03\x01", b"\x01\x01", b"\x02\x01", b"\x04\x01"), True, late=4)
        star.settle()
        assert star.cycle().ats == (b"\x03\x03", b"\x01\x03", b"\x02\x03", b"\x04\x03")
        star.kill("rack")
        star.until_there(2)
        star.cycle()
        assert star.cycle() == Answers(5, (), False), "the telegrams of a process that is gone are not repeated"


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
