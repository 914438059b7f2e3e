"""The frames that each node of a PAM's ring hears, the reports that come back, and their instants."""

from collections.abc import Mapping
from random import Random
from typing import Any

import pytest

from fieldrig.clock import MS
from fieldrig_bus.ring.pam.medium import MOST_WAITING
from fieldrig_bus.ring.pam.message import Cycle, Frame, Frames, Reception, Reports, RingMessage
from fieldrig_bus.ring.pam.virtual import PamRingModel

NODES = {"feeder": 17, "lift": 18, "panel": 33}
FRAME = (17, b"\x02")


class Bench:
    def __init__(self, addresses: Mapping[str, int] = NODES, **settings: Any) -> None:
        self.model = PamRingModel(**{"order": (), **settings})
        self.model.begin(0, Random(1))
        for member in ("pam", *addresses):
            self.model.join(member)
        self.model.listen(0, "pam", ["master"])
        for member, address in addresses.items():
            self.model.listen(0, member, [["node", address]])
        self.addresses = addresses
        self.number = 0
        self.times: dict[str, int] = {}

    def cycle(self, *frames: Frame) -> dict[str, RingMessage]:
        """Every node leaves a report, then the PAM begins a cycle.  Returns what each member hears."""
        now_ns = self.number * MS
        for member, address in self.addresses.items():
            self.model.submit(now_ns, member, bytes((1, address)))
        self.model.submit(now_ns, "pam", Frames(self.number, frames or (FRAME,)))
        self.number += 1
        heard: dict[str, RingMessage] = {}
        while (next_ns := self.model.next_ns()) is not None:
            for delivery in self.model.collect(next_ns):
                for member in delivery.receivers:
                    heard[member] = delivery.message
                    self.times[member] = delivery.time_ns - now_ns
        return heard

    def reports(self) -> Reports:
        heard = self.cycle()["pam"]
        assert isinstance(heard, Reports)
        return heard

    def hearing(self) -> dict[str, Reception]:
        return {member: heard.reception for member, heard in self.cycle().items() if isinstance(heard, Cycle)}

    def fault(self, **fault: Any) -> int:
        return self.model.add_fault(self.number * MS, fault)


ALL_WELL = dict.fromkeys(NODES, Reception.GOOD)


def test_all_nodes_hear_the_frames_and_the_pam_hears_them_in_the_order_of_the_ring() -> None:
    heard = Bench(order=["panel"]).cycle()
    assert heard["lift"] == Cycle(0, (FRAME,))
    assert heard["pam"] == Reports(0, ((33, b"\x01\x21"), (17, b"\x01\x11"), (18, b"\x01\x12")), (33, 17, 18))


@pytest.mark.manual("PAML-162")
def test_all_nodes_hear_a_cycle_at_the_same_instant_however_short_it_is() -> None:
    bench = Bench()
    bench.cycle()
    assert set(bench.times.values()) == {200_000}


def test_a_long_cycle_is_heard_when_its_frames_and_reports_are_over() -> None:
    bench = Bench()
    bench.cycle(*((17, bytes(240)),) * 2)
    # 10 Mbit/s: a frame of 240 bytes with target, length and CRC; 3 reports of 2 bytes with the same; 3 addresses
    assert set(bench.times.values()) == {(2 * (240 + 5) + 3 * (2 + 5) + 3) * 800}


def test_a_report_is_sent_once_and_those_of_one_cycle_go_together() -> None:
    bench = Bench()
    bench.model.submit(0, "lift", b"\x01\x00")
    assert bench.reports().reports[1] == (18, b"\x01\x00\x01\x12")
    bench.addresses = {}
    assert bench.reports().reports == ()


def test_a_chip_whose_buffer_is_not_fetched_loses_the_oldest_reports() -> None:
    bench = Bench()
    for number in range(MOST_WAITING + 2):
        bench.model.submit(0, "lift", bytes((1, number)))
    assert bench.model.statistics(0)["lost_reports"] == 2
    assert bench.reports().reports[1][1][:2] == bytes((1, 3)), "one more is lost for that of the cycle"


@pytest.mark.manual("PAMS-108")
@pytest.mark.parametrize(
    ("after", "hearing", "place"),
    [
        ("master", {"feeder": Reception.NO_CARRIER}, 17),
        ("feeder", {"feeder": Reception.GOOD, "lift": Reception.NO_CARRIER}, 18),
        ("lift", {"feeder": Reception.GOOD, "lift": Reception.GOOD, "panel": Reception.NO_CARRIER}, 33),
        ("panel", ALL_WELL, 0),
    ],
)
def test_the_first_node_behind_a_break_sees_no_carrier_and_the_others_hear_nothing(
    after: str, hearing: dict[str, Reception], place: int
) -> None:
    bench = Bench()
    number = bench.fault(what="break", after=after)
    assert bench.hearing() == hearing
    reports = bench.reports()
    assert (reports.reports, reports.reception, reports.place) == ((), Reception.NO_CARRIER, place)
    bench.model.clear_fault(0, number)
    assert bench.hearing() == ALL_WELL
    assert len(bench.reports().reports) == 3


def test_of_two_breaks_the_pam_hears_from_the_node_behind_the_second_one() -> None:
    bench = Bench()
    bench.fault(what="break", after="master")
    bench.fault(what="break", after="lift")
    assert bench.hearing() == {"feeder": Reception.NO_CARRIER, "panel": Reception.NO_CARRIER}
    assert bench.reports().place == 33


@pytest.mark.manual("PAMS-108")
def test_a_node_without_power_opens_the_ring_unless_it_has_a_bypass() -> None:
    bench = Bench()
    bench.fault(what="off", station="lift")
    assert bench.hearing() == {"feeder": Reception.GOOD, "panel": Reception.NO_CARRIER}
    bench = Bench(bypassed=["lift"])
    bench.fault(what="off", station="lift")
    assert bench.reports() == Reports(0, ((17, b"\x01\x11"), (33, b"\x01\x21")), (17, 33))


@pytest.mark.manual("PAMS-108")
def test_a_place_that_damages_frames_is_seen_by_the_first_node_behind_it() -> None:
    bench = Bench()
    bench.fault(what="distort", after="feeder", count=2)
    assert bench.hearing() == {"feeder": Reception.GOOD, "lift": Reception.CRC_ERROR}
    reports = bench.reports()
    assert (reports.reception, reports.place) == (Reception.CRC_ERROR, 18)
    assert [address for address, _ in reports.reports] == [18, 33], "those that passed the place are lost"
    assert bench.reports().reports == ((17, b"\x01\x11"), (18, b"\x01\x12"), (33, b"\x01\x21"))
    assert bench.hearing() == ALL_WELL
    assert bench.model.statistics(0)["damaged"] == 2


def test_of_two_places_that_damage_frames_the_first_one_is_seen() -> None:
    bench = Bench()
    bench.fault(what="distort", after="lift")
    bench.fault(what="distort", after="feeder")
    assert bench.hearing() == {"feeder": Reception.GOOD, "lift": Reception.CRC_ERROR}


def test_a_node_that_stands_still_shows_no_wrong_crc_but_its_optics_name_it() -> None:
    bench = Bench()
    bench.fault(what="distort", after="feeder")
    bench.fault(what="halt", station="lift")
    assert bench.hearing() == {"feeder": Reception.GOOD}
    assert bench.reports().place == 18


def test_a_buffer_that_is_too_large_for_one_cycle_goes_with_several() -> None:
    bench = Bench({"lift": 18})
    for number in range(10):
        bench.model.submit(0, "lift", bytes([number]) * 100)
    bench.addresses = {}
    assert [reports[0][1][::100] for _ in range(2) if (reports := bench.reports().reports)] == [
        bytes(range(5)), bytes(range(5, 10)),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("after", "place", "reporting"), [("master", 17, [17, 18, 33]), ("panel", 0, []), ("pam", 17, [17, 18, 33])]
)
def test_the_segments_of_the_pam_may_damage_frames_too(after: str, place: int, reporting: list[int]) -> None:
    bench = Bench()
    bench.fault(what="distort", after=after)
    reports = bench.reports()
    assert (reports.place, [address for address, _ in reports.reports]) == (place, reporting)


def test_a_node_that_stands_still_passes_the_frames_on() -> None:
    bench = Bench()
    bench.fault(what="halt", station="lift")
    assert bench.hearing() == {"feeder": Reception.GOOD, "panel": Reception.GOOD}
    reports = bench.reports()
    assert [address for address, _ in reports.reports] == [17, 33]
    assert (reports.addresses, reports.reception) == ((17, 18, 33), Reception.GOOD)


def test_two_nodes_of_one_address_are_both_heard() -> None:
    bench = Bench({"feeder": 17, "lift": 17})
    assert bench.reports().addresses == (17, 17)


def test_only_the_pam_begins_cycles() -> None:
    bench = Bench()
    bench.model.submit(0, "lift", Frames(0, ()))
    assert bench.model.next_ns() is None


def test_a_cycle_that_begins_too_early_waits_for_the_end_of_the_last_one() -> None:
    bench = Bench()
    long = Frames(0, tuple((17, bytes(200)) for _ in range(10)))
    bench.model.submit(0, "pam", long)
    bench.model.submit(MS, "pam", Frames(1, ()))
    numbers = [delivery.message.number for delivery in bench.model.collect(10 * MS) if delivery.receivers == ("pam",)]  # type: ignore[union-attr]  # the PAM hears reports
    assert numbers == [0, 1]
    assert bench.model.statistics(0)["overruns"] == 1
