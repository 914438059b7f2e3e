"""The telegrams that each station of a ring of three hears, and their instants."""

from collections.abc import Mapping
from random import Random
from typing import Any

import pytest

from fieldrig.clock import MS
from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst, RingMessage
from fieldrig_bus.ring.sercos.timing import answers_ns, cycle_ns, telegram_ns
from fieldrig_bus.ring.sercos.virtual import RingModel

MST, MDT = bytes.fromhex("FF 04"), bytes.fromhex("FF 00 C0 00 00")
STATIONS = {"belt": 3, "lift": 1, "knife": 2}


class Bench:
    def __init__(self, addresses: Mapping[str, int] = STATIONS, **settings: Any) -> None:
        self.model = RingModel(**{"order": (), "mbaud": 4, **settings})
        self.model.begin(0, Random(1))
        self.addresses = dict(addresses)
        for member in ("max4", *addresses):
            self.model.join(member)
        self.model.listen(0, "max4", ["master"])
        for member, address in addresses.items():
            self.model.listen(0, member, [["drive", address]])
        self.number = 0
        self.times: dict[str, int] = {}

    def cycle(self) -> dict[str, RingMessage]:
        """Every drive leaves an AT, then the master begins a cycle.  Returns what each member hears of it."""
        now_ns = self.number * 4 * MS
        for member, address in self.addresses.items():
            self.model.submit(now_ns, member, bytes((address, 0x80)))
        self.model.submit(now_ns, "max4", Mst(self.number, MST))
        self.number += 1
        heard: dict[str, RingMessage] = {}
        while (next_ns := self.model.next_ns()) is not None:
            for delivery in self.model.collect(next_ns):
                for member in delivery.receivers:
                    heard[member] = delivery.message
                    self.times[member] = delivery.time_ns - now_ns
                if isinstance(delivery.message, Answers):
                    self.model.submit(next_ns, "max4", Mdt(MDT))
        return heard

    def answers(self) -> Answers:
        heard = self.cycle()["max4"]
        assert isinstance(heard, Answers)
        return heard

    def hearing(self) -> dict[str, tuple[bool, bool]]:
        """The members that hear MST and MDT."""
        return {
            member: (bool(heard.mst), bool(heard.mdt))
            for member, heard in self.cycle().items()
            if isinstance(heard, Cycle)
        }

    def fault(self, **fault: Any) -> int:
        return self.model.add_fault(self.number * 4 * MS, fault)


ALL_WELL = dict.fromkeys(STATIONS, (True, True))


@pytest.mark.manual("PD-130")
def test_everybody_hears_the_master_and_it_hears_them_in_the_order_of_the_ring() -> None:
    bench = Bench()
    heard = bench.cycle()
    assert heard["belt"] == Cycle(0, MST, MDT)
    assert heard["max4"] == Answers(0, (b"\x03\x80", b"\x01\x80", b"\x02\x80"), True)


def test_the_order_of_the_ring_may_be_another_than_that_of_the_file() -> None:
    bench = Bench(order=("knife", "belt", "lift"))
    assert [at[0] for at in bench.answers().ats] == [2, 3, 1]


def test_telegrams_take_their_time_on_the_fibre() -> None:
    # MST: 2 bytes and FCS, 32 bits, 6 stuffed, 16 of delimiters: 54 bits of 250 ns
    assert telegram_ns(2, 4) == 13_500
    assert telegram_ns(2, 16) == 3_375
    bench = Bench()
    bench.cycle()
    assert bench.times["max4"] == answers_ns([2, 2, 2], 4) == 4 * 13_500 + 3 * 10_000
    # MDT: 5 bytes and FCS, 56 bits, 11 stuffed, 16 of delimiters: 83 bits
    assert bench.times["belt"] == cycle_ns([2, 2, 2], 5, 4) == 84_000 + 10_000 + 83 * 250


def test_an_at_is_sent_once() -> None:
    bench = Bench()
    bench.cycle()
    bench.addresses = {}
    assert bench.answers().ats == ()


@pytest.mark.manual("PD-130", "PD-140")
@pytest.mark.parametrize(
    ("after", "hearing"),
    [("master", []), ("belt", ["belt"]), ("lift", ["belt", "lift"]), ("knife", ["belt", "lift", "knife"])],
)
def test_behind_a_break_nothing_is_heard_and_the_master_hears_nothing(after: str, hearing: list[str]) -> None:
    bench = Bench()
    number = bench.fault(what="break", after=after)
    assert bench.hearing() == {name: (name in hearing, name in hearing) for name in STATIONS}
    assert bench.answers() == Answers(1, (), False)
    bench.model.clear_fault(0, number)
    assert bench.hearing() == ALL_WELL
    assert len(bench.answers().ats) == 3


@pytest.mark.manual("PD-140")
def test_a_station_without_power_opens_the_ring() -> None:
    bench = Bench()
    bench.fault(what="off", station="lift", duration_ms=4)
    assert bench.hearing() == {"belt": (True, True), "knife": (False, False)}
    assert bench.hearing() == ALL_WELL  # it is over


def test_a_bypassed_station_does_not_open_the_ring() -> None:
    bench = Bench(bypassed=("lift",))
    bench.fault(what="off", station="lift")
    assert [at[0] for at in bench.answers().ats] == [3, 2]


def test_a_station_that_should_be_there_opens_the_ring_until_it_comes() -> None:
    bench = Bench({"belt": 3, "knife": 2}, order=("belt", "lift", "knife"))
    assert bench.hearing() == {"belt": (True, True), "knife": (False, False)}
    bench.model.join("lift")
    bench.model.listen(0, "lift", [["drive", 1]])
    bench.addresses["lift"] = 1
    assert bench.hearing() == ALL_WELL
    bench.model.leave("lift")
    del bench.addresses["lift"]
    assert not bench.answers().ring_closed


def test_a_ring_that_opens_is_reported_with_the_stations_that_are_lost() -> None:
    bench = Bench()
    bench.cycle()
    assert bench.model.conditions(0) == {}
    bench.fault(what="break", after="belt", duration_ms=4)
    bench.cycle()
    assert bench.model.conditions(0) == {"ring": "the ring is open, without lift, knife"}
    bench.cycle()
    bench.cycle()
    assert bench.model.conditions(0) == {}


def test_a_ring_whose_stations_still_start_is_no_news() -> None:
    bench = Bench({"belt": 3, "knife": 2}, order=("belt", "lift", "knife"))
    bench.cycle()
    assert bench.model.conditions(0) == {}


def test_two_stations_of_one_address_destroy_each_others_at() -> None:
    bench = Bench({"belt": 3, "lift": 3, "knife": 2})
    assert bench.answers() == Answers(0, (b"\x02\x80",), True, 2)


@pytest.mark.parametrize(
    ("fault", "lost"),
    [
        ({"station": "lift", "telegram": "mst"}, {"lift": (False, True)}),
        ({"station": "lift", "telegram": "mdt"}, {"lift": (True, False)}),
        ({"after": "belt", "telegram": "mdt"}, {"lift": (True, False), "knife": (True, False)}),
        ({"after": "lift"}, {"knife": (False, False)}),
        ({"after": "master", "telegram": "mst"}, dict.fromkeys(STATIONS, (False, True))),
    ],
)
def test_distortion_spoils_what_passes(fault: dict[str, str], lost: dict[str, tuple[bool, bool]]) -> None:
    bench = Bench()
    bench.fault(what="distort", duration_ms=4, **fault)
    assert bench.hearing() == ALL_WELL | lost
    assert bench.hearing() == ALL_WELL


@pytest.mark.parametrize(
    ("where", "left"), [({"station": "lift"}, [3, 2]), ({"after": "lift"}, [2]), ({"after": "master"}, [3, 1, 2])]
)
def test_a_distorted_at_is_not_heard_but_counted(where: dict[str, str], left: list[int]) -> None:
    bench = Bench()
    bench.fault(what="distort", telegram="at", duration_ms=4, **where)
    answers = bench.answers()
    assert ([at[0] for at in answers.ats], answers.errors) == (left, 3 - len(left))
    assert bench.answers().errors == 0


def test_a_late_at_misses_its_slot() -> None:
    bench = Bench()
    number = bench.fault(what="late", station="knife", count=2)
    heard = [bench.answers() for _ in range(4)]
    assert [(len(answers.ats), answers.late) for answers in heard] == [(2, 1), (2, 1), (3, 0), (3, 0)]
    assert bench.model.statistics(0)["late"] == 2.0
    assert bench.model.all_faults(0)[number]["applied"] == 2


def test_chance_is_the_same_for_the_same_seed() -> None:
    runs = []
    for _ in range(2):
        bench = Bench()
        bench.fault(what="distort", station="belt", telegram="at", probability=0.3)
        runs.append([len(bench.answers().ats) for _ in range(200)])
    assert runs[0] == runs[1]
    assert 30 < runs[0].count(2) < 90


@pytest.mark.parametrize(
    ("fault", "wrong"),
    [
        ({"what": "break", "after": "door"}, "no station 'door'\nthere are: master, belt, lift, knife"),
        ({"what": "break", "after": "lfit"}, "no station 'lfit'\ndid you mean lift"),
        ({"what": "break", "after": ""}, "no station ''\nthere are: master"),
        ({"what": "off", "station": "door"}, "no station 'door'\nthere are: belt, lift, knife"),
        ({"what": "off", "station": "max4"}, "no station 'max4'\nthere are: belt, lift, knife"),
        ({"what": "late", "station": "master"}, "no station 'master'\nthere are: belt, lift, knife"),
        ({"what": "distort", "station": "max4"}, "no station 'max4'\nthere are: belt, lift, knife"),
        ({"what": "melt"}, "no fault 'melt'"),
        ({"what": "distort"}, "expected either after .a segment. or station"),
        ({"what": "break"}, "after"),
    ],
)
def test_a_fault_that_can_not_be_is_refused(fault: dict[str, str], wrong: str) -> None:
    with pytest.raises(ValueError, match=wrong):
        Bench().model.add_fault(0, fault)


def test_only_the_master_begins_cycles_and_a_station_answers_for_itself() -> None:
    bench = Bench()
    bench.model.submit(0, "belt", Mst(0, MST))
    bench.model.submit(0, "belt", Mdt(MDT))
    bench.model.submit(0, "belt", b"\x01\x80")
    bench.model.submit(0, "belt", b"")
    assert bench.model.next_ns() is None
    assert len(bench.answers().ats) == 3


def test_a_master_that_leaves_its_mdt_out_is_heard_so() -> None:
    bench = Bench()
    bench.model.submit(0, "max4", Mst(0, MST))
    bench.model.submit(4 * MS, "max4", Mst(1, MST))
    heard = [delivery.message for delivery in bench.model.collect(8 * MS)]
    assert heard == [Answers(0, (), True), Cycle(0, MST, b""), Answers(1, (), True)]


def test_an_observer_hears_everything() -> None:
    bench = Bench()
    bench.model.join("scope")
    bench.model.listen(0, "scope", None)
    assert "scope" in bench.cycle()
    assert bench.model.statistics(0)["stations"] == 3.0


def test_statistics_say_whether_the_ring_is_closed() -> None:
    bench = Bench()
    bench.cycle()
    assert bench.model.statistics(0) == {
        "cycles": 1.0,
        "stations": 3.0,
        "ring_closed": 1.0,
        "wrong_fcs": 0.0,
        "late": 0.0,
        "overruns": 0.0,
    }
    bench.fault(what="break", after="belt")
    assert bench.model.statistics(4 * MS)["ring_closed"] == 0.0


def test_master_that_begins_anew_does_not_overtake_its_last_cycle() -> None:
    """A master that is reset in the middle of a cycle has short cycles after that."""
    bench = Bench()
    model = bench.model
    for name, address in bench.addresses.items():
        model.submit(0, name, bytes((address, *bytes(100))))
    model.submit(0, "max4", Mst(7, MST))
    model.submit(0, "max4", Mst(1, bytes.fromhex("FF 00")))
    model.submit(0, "max4", Mdt(b""))
    heard: list[int] = []
    while (next_ns := model.next_ns()) is not None:
        heard += [delivery.message.number for delivery in model.collect(next_ns) if isinstance(delivery.message, Cycle)]
    assert heard == [7, 1]
