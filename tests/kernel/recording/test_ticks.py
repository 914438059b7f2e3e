"""Rows of a process in real time whose host is late: the host's time and the CPU's are moved by hand."""

import asyncio
import time
from types import SimpleNamespace
from typing import Any, cast

import pytest

from fieldrig.clock import MS, S
from fieldrig.loop import timerfd
from fieldrig.loop.real_clock import RealClock
from fieldrig.real import ticks as ticks_module
from fieldrig.real.recorded import ProcessSource
from fieldrig.recording.batch import decode
from fieldrig.recording.record_set import RecordSet
from fieldrig.recording.signals import Described

BEGIN_NS = 100 * S


class Loop:
    """A loop whose timers the test calls, as a host does that comes back to the process."""

    def __init__(self) -> None:
        self.due: Any = None
        self.soon: list[Any] = []

    def call_later(self, delay_s: float, action: Any) -> Any:
        self.due = action
        return SimpleNamespace(cancel=lambda: None)

    def call_soon(self, action: Any) -> None:
        self.soon.append(action)


class Host:
    """A process with one device, which counts cycles and messages, and the rows that a sampler took of it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_ns, self.cpu_ns, self.row_cpu_ns = BEGIN_NS, 1, 0
        monkeypatch.setattr(timerfd, "is_available", lambda: False)
        monkeypatch.setattr(time, "monotonic_ns", lambda: self.now_ns)
        monkeypatch.setattr(ticks_module, "time", SimpleNamespace(thread_time_ns=lambda: self.cpu_ns))
        self.loop = Loop()
        monkeypatch.setattr(asyncio, "get_running_loop", lambda: self.loop)
        self.clock = RealClock(cast(Any, self.loop))
        self.source = ProcessSource(cast(Any, SimpleNamespace(clock=self.clock)))
        self.count = 0
        self.rows: list[tuple[int, int, int]] = []
        """The instant in milliseconds, what was counted until then, and the ticks that were missed before."""
        self.flushes = 0

    def sample(self, period_ns: int = MS) -> Any:
        self.source.on_rows = self._on_rows
        return self.source.every(period_ns, self._take)

    def cycle(self, period_ns: int) -> None:
        self.clock.call_at(self.clock.now_ns() + period_ns, lambda: self._on_cycle(period_ns))

    def wake_at(self, at_ms: float) -> None:
        """The host comes back to the process, and handles its timers."""
        self.now_ns = BEGIN_NS + round(at_ms * MS)
        self.loop.due()

    def message_at(self, at_ms: float, happened_ms: float) -> None:
        """The host comes back to the process, and handles a message before its timers."""
        self.now_ns = BEGIN_NS + round(at_ms * MS)
        self.clock.handle_at(BEGIN_NS + round(happened_ms * MS), self._count)

    def taken(self) -> list[tuple[int, int, int]]:
        rows, self.rows = self.rows, []
        return rows

    def _on_cycle(self, period_ns: int) -> None:
        self._count()
        self.cycle(period_ns)

    def _count(self) -> None:
        self.count += 1

    def _take(self, now_ns: int, missed: int) -> None:
        assert now_ns == self.clock.now_ns(), "it is read at the instant of its tick"
        self.rows.append(((now_ns - BEGIN_NS) // MS, self.count, missed))
        self.cpu_ns += self.row_cpu_ns

    def _on_rows(self) -> None:
        self.flushes += 1


@pytest.fixture
def host(monkeypatch: pytest.MonkeyPatch) -> Host:
    return Host(monkeypatch)


def test_no_tick_is_lost_when_the_process_is_late_and_each_row_is_of_its_instant(host: Host) -> None:
    host.cycle(2 * MS)
    host.sample()
    host.wake_at(1)
    assert host.taken() == [(1, 0, 0)]
    host.wake_at(7.5)
    assert host.taken() == [(2, 1, 0), (3, 1, 0), (4, 2, 0), (5, 2, 0), (6, 3, 0), (7, 3, 0)]
    assert host.flushes


def test_rows_until_a_message_are_taken_before_it_is_handled(host: Host) -> None:
    host.sample()
    host.wake_at(1)
    host.message_at(4.9, happened_ms=3.2)
    assert host.taken() == [(1, 0, 0), (2, 0, 0), (3, 0, 0)]
    host.wake_at(5)
    assert host.taken() == [(4, 1, 0), (5, 1, 0)]


def test_while_the_device_stood_still_its_rows_have_what_it_had(host: Host) -> None:
    """After a stall a device goes on at the present, so until then nothing has happened to it."""
    host.cycle(10 * MS)
    host.sample(5 * MS)
    host.wake_at(10)
    host.taken()
    host.wake_at(61)
    assert host.taken() == [(at, 1, 0) for at in range(15, 61, 5)]
    host.wake_at(71)
    assert host.taken() == [(65, 2, 0), (70, 2, 0)], "its cycle of 20 ms was at 61"


def test_what_is_long_over_is_left_out_and_counted(host: Host) -> None:
    host.sample(10 * MS)
    host.wake_at(10)
    host.taken()
    host.wake_at(1_015)
    rows = host.taken()
    assert rows[0] == (770, 0, 75), "the first of the last 250 ms"
    assert rows[1:] == [(at, 0, 0) for at in range(780, 1_015, 10)]


def test_rows_that_take_longer_than_their_period_do_not_take_the_whole_host(host: Host) -> None:
    host.sample()
    host.wake_at(1)
    host.taken()
    host.row_cpu_ns = 3 * MS
    host.wake_at(101)
    rows = host.taken()
    assert [missed for *_, missed in rows[:-1]] == [0] * (len(rows) - 1)
    assert 15 <= len(rows) <= 19, "half of 100 ms"
    assert rows[-1] == (101, 0, 100 - len(rows)), "the present one is taken, and says what was left out"


def test_nothing_is_complete_before_its_overdue_ticks_are_taken(host: Host) -> None:
    host.sample()
    host.wake_at(1)
    host.now_ns = BEGIN_NS + 5 * MS
    assert host.source.now_ns() == BEGIN_NS + 2 * MS - 1
    host.loop.due()
    assert host.source.now_ns() == BEGIN_NS + 5 * MS


def test_ticks_end_and_the_clock_is_left_alone_then(host: Host) -> None:
    end = host.sample()
    host.wake_at(1)
    end()
    end()
    host.message_at(5, happened_ms=5)
    assert host.taken() == [(1, 0, 0)]
    assert host.clock.before_event is None


def test_rows_by_cycles_of_messages_that_are_handled_together_are_all_there(host: Host) -> None:
    rows: list[tuple[int, int, int]] = []

    def take(now_ns: int, missed: int) -> None:
        rows.append(((now_ns - BEGIN_NS) // MS, host.count, missed))

    def cycle() -> None:
        host.count += 1
        host.source.after_cycle(take)

    host.now_ns = BEGIN_NS + 10 * MS
    for at in (1, 5, 9):
        host.clock.handle_at(BEGIN_NS + at * MS, cycle)
    assert rows == [(1, 1, 0), (5, 2, 0)], "the last one is read when its answer has left"
    for action in host.loop.soon:
        action()
    assert rows[2:] == [(9, 3, 0)]


def test_a_recording_says_up_to_where_it_is_complete(host: Host) -> None:
    part = SimpleNamespace(
        is_bus=False,
        describe=lambda keys: [Described(0.0)],
        reader=lambda keys: lambda: [float(host.clock.now_ns() - BEGIN_NS)],
        close=lambda: None,
    )
    cast(Any, host.source).part = lambda name: part
    batches: list[bytes] = []
    record_set = RecordSet(host.source, ["one/value"], MS, batches.append, is_lossless=False)
    host.source.on_rows = record_set.flush
    for at_ms in (1, 5.5, 31, 31.5):
        host.wake_at(at_ms)
    until_ns = BEGIN_NS
    for batch in map(decode, batches):
        (rows,) = batch.parts
        assert list(rows.times_ns) == list(range(until_ns + MS, batch.until_ns + 1, MS))
        assert list(rows.values[0]) == [at - BEGIN_NS for at in rows.times_ns]
        until_ns = batch.until_ns
    assert until_ns == BEGIN_NS + 31 * MS
