"""The promises of a PAM's ring alone, on every kind of it; `test_conformance` has those that SERCOS gives as well."""

from collections.abc import Iterator

import pytest
from any_ring import ADDRESSES, all_joined
from pam_ring_kinds import FRAMES, KINDS, STARS, PamRing, PamStarRing, hearing

from fieldrig_bus.ring.pam.message import Cycle, Frames, Reception, Reports

pytestmark = pytest.mark.system

WELL = dict.fromkeys(ADDRESSES, Reception.GOOD)
IN_ORDER = (3, 1, 2, 4)


def of(reports: Reports) -> list[tuple[int, list[int]]]:
    """Addresses, and the numbers that each node has reported in this cycle."""
    return [(address, list(buffer[1::2])) for address, buffer in reports.reports]


@pytest.fixture(params=KINDS, ids=str)
def ring(request: pytest.FixtureRequest) -> Iterator[PamRing]:
    with KINDS[request.param](bypassed=["knife"]) as ring:
        yield all_joined(ring)


@pytest.fixture(params=STARS, ids=str)
def star(request: pytest.FixtureRequest) -> Iterator[PamStarRing]:
    with STARS[request.param]() as ring:
        yield all_joined(ring)


def test_the_pam_hears_all_reports_in_the_order_of_the_ring_and_they_hear_the_frames(ring: PamRing) -> None:
    assert ring.cycle() == Reports(1, ((3, b"\1\1"), (1, b"\1\1"), (2, b"\1\1"), (4, b"\1\1")), IN_ORDER)
    assert all(node.heard == [Cycle(0, FRAMES), Cycle(1, FRAMES)] for node in ring.stations.values())


@pytest.mark.manual("PAMS-108")
def test_only_the_first_node_behind_a_break_and_the_pam_see_no_carrier(ring: PamRing) -> None:
    ring.fault(what="break", after="belt")
    assert hearing(ring) == {"belt": Reception.GOOD, "lift": Reception.NO_CARRIER}
    assert ring.cycle() == Reports(2, (), (3,), Reception.NO_CARRIER, 1)


@pytest.mark.manual("PAMS-108")
def test_a_segment_that_damages_frames_is_seen_by_the_node_behind_it_and_by_the_pam(ring: PamRing) -> None:
    ring.fault(what="distort", after="lift", count=1)
    assert hearing(ring) == {"belt": Reception.GOOD, "lift": Reception.GOOD, "knife": Reception.CRC_ERROR}
    heard = ring.master.heard[-1]
    assert (heard.reception, heard.place) == (Reception.CRC_ERROR, 2)
    assert of(heard) == [(2, [1]), (4, [1])]
    assert hearing(ring) == WELL
    assert ring.statistics()["damaged"] == 1


def test_a_node_that_stands_still_is_on_the_ring_but_hears_and_reports_nothing(ring: PamRing) -> None:
    ring.fault(what="halt", station="belt")
    assert hearing(ring).keys() == ADDRESSES.keys() - {"belt"}
    heard = ring.cycle()
    assert (heard.addresses, [address for address, _ in of(heard)]) == (IN_ORDER, [1, 2, 4])


@pytest.mark.parametrize("kind", KINDS)
def test_two_nodes_of_one_address_are_both_heard(kind: str) -> None:
    with KINDS[kind]() as ring:
        for name in ADDRESSES:
            ring.join(name, {"lift": 3}.get(name, ADDRESSES[name]))
        ring.cycle()
        assert of(ring.cycle()) == [(3, [1]), (3, [1]), (2, [1]), (4, [1])]


def test_only_the_pam_begins_cycles(ring: PamRing) -> None:
    before = len(ring.trace)
    ring.stations["belt"].link.send(Frames(0, ()))
    ring.cycle()
    assert len(ring.trace) == before + 2


# -- events that only happen in real time


def test_a_report_that_came_late_is_not_lost(star: PamStarRing) -> None:
    star.clock.handle(star.master.begin)
    star.clock.handle(star.master.begin)  # no node had the time to react
    star.settle()
    assert of(star.cycle()) == [(address, [2, 3]) for address in IN_ORDER]


@pytest.mark.parametrize("kind", STARS)
def test_reports_are_not_repeated_however_patient_the_ring_is(kind: str) -> None:
    with STARS[kind](patience_ms=10_000) as star:
        all_joined(star)
        star.clock.handle(star.master.begin)
        star.clock.handle(star.master.begin)
        assert star.master.heard[-1] == Reports(2, (), IN_ORDER, late=4)


@pytest.mark.parametrize("kind", STARS)
def test_processes_that_stand_still_for_a_while_miss_no_order_and_lose_no_report(kind: str) -> None:
    """The whole bench has one event loop: while it is not pumped, all processes stand still."""
    with STARS[kind]() as star:
        all_joined(star)
        for _ in range(40):
            star.clock.handle(star.master.begin)
        star.settle()
        assert [cycle.number for cycle in star.stations["belt"].heard] == list(range(41))
        assert of(star.cycle()) == [(address, list(range(2, 42))) for address in IN_ORDER]


def test_a_process_that_would_miss_orders_is_as_if_it_had_no_power(star: PamStarRing) -> None:
    most_behind = star.buses["max4"].carrier.most_behind
    for _ in range(most_behind + 2):
        star.clock.handle(star.master.begin)
    assert star.master.heard[-1].reception is Reception.NO_CARRIER
    star.settle()
