"""A master on a computer: drives that are slow when a phase begins, and cycles that it could not keep itself."""

from collections.abc import Callable

import pytest
from ring_bench import RingBench

from fieldrig.clock import MS, Timer, Watchdog
from fieldrig.testing import RecordedLink
from fieldrig_bus.ring.sercos.message import Mst, RingMessage
from fieldrig_devices.sercos.master import MOST_SETTLING, SercosMaster
from fieldrig_devices.sercos.ring_drive import Drive, Event


class StallingClock:
    """A clock that, like `RealClock`, handles events at the present after a long stall, and not late."""

    def __init__(self) -> None:
        self.now, self.late = 0, 0
        self.timers: list[Timer] = []

    def now_ns(self) -> int:
        return self.now

    def late_ns(self) -> int:
        return self.late

    def call_at(self, when_ns: int, action: Callable[[], None]) -> Timer:
        self.timers.append(Timer(when_ns, action))
        return self.timers[-1]

    def watch(self, action: Callable[[], None]) -> Watchdog:
        return Watchdog(action)

    def fire(self, now_ns: int, late_ns: int = 0) -> None:
        self.now, self.late = now_ns, late_ns
        action = self.timers.pop().action
        assert action is not None
        action()


def test_a_master_that_stood_still_does_not_replay_its_cycles() -> None:
    clock, link = StallingClock(), RecordedLink[RingMessage]()
    master = SercosMaster(clock, link, 4 * MS, [Drive(1, (47,), (51,))], on_event=lambda _: None, on_cycle=lambda: None)
    master.start()
    clock.fire(1 * MS)
    assert (master.missed_cycles, clock.timers[-1].when_ns) == (0, 2 * MS)
    clock.fire(2 * MS, late_ns=3 * MS)  # handled at 5 ms, but counts as of 2 ms
    assert (master.missed_cycles, clock.timers[-1].when_ns) == (3, 6 * MS)
    clock.fire(106 * MS)  # so late that it counts as of now
    assert (master.missed_cycles, clock.timers[-1].when_ns) == (103, 107 * MS)
    assert [message.number for message in link.sent if isinstance(message, Mst)] == [1, 2, 3, 4]


@pytest.mark.long
def test_drives_may_be_slow_when_a_phase_begins() -> None:
    bench = RingBench(1, 2)
    bench.master.start()
    bench.master.request_phase(4)
    while bench.master.phase < 3:
        bench.run(0.5)
    bench.rig.add_fault("ring0", {"what": "late", "station": "drive1", "count": MOST_SETTLING - 5})
    bench.run(3_000)
    assert bench.master.phase == 4
    assert (bench.master.drives[2].lost, bench.seen(Event.AT_FAILED)) == (0, [])


def test_a_drive_that_never_comes_into_a_phase_brings_the_ring_down() -> None:
    bench = RingBench(1, 2)
    bench.master.start()
    bench.master.request_phase(4)
    while bench.master.phase < 3:
        bench.run(0.5)
    bench.rig.add_fault("ring0", {"what": "late", "station": "drive1"})
    bench.run(4 * (MOST_SETTLING + 4))
    assert bench.master.phase == 0
    assert [(event.address, event.code) for event in bench.seen(Event.AT_FAILED)] == [(2, 1), (2, 2)]
