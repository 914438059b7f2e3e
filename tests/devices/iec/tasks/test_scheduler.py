"""The scheduler shares one processor: priorities, slices, the grid, supervision, and what waits."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, US, VirtualClock
from fieldrig_devices.iec.host import Pending
from fieldrig_devices.iec.program import TaskKind
from fieldrig_devices.iec.tasks.scheduler import SHORTEST_NS, Scheduler
from fieldrig_devices.iec.tasks.system_work import IO_MAP_PRIORITY, SystemWork
from fieldrig_devices.iec.tasks.task import Task, TaskState, WorkState

ENDLESS = 1 << 60


class BusyHost(VirtualClock):
    """The clock of a host that takes time for what it does."""

    __slots__ = ("_free_ns",)

    def __init__(self) -> None:
        super().__init__()
        self._free_ns = 0

    def work(self, duration_ns: int) -> None:
        self._free_ns = max(self._free_ns, self.now_ns()) + duration_ns

    def late_ns(self) -> int:
        return max(self._free_ns - self.now_ns(), 0)


@dataclass
class Chunk:
    name: str
    begin_us: int
    used_us: int


class Burn:
    """Work that takes this processor time in each cycle; a `Pending` in the list is waited for."""

    def __init__(
        self, name: str, clock: VirtualClock, log: list[Chunk], *steps_us: int | Callable[[], Pending]
    ) -> None:
        self.name, self._clock, self._log, self._steps = name, clock, log, steps_us
        self.state = WorkState.ENDED
        self.wake: Pending | None = None
        self._rest: list[int | Callable[[], Pending]] = []
        self.on_run: Callable[[], None] = lambda: None
        self.ends_in = WorkState.ENDED

    def begin(self) -> None:
        self._rest = [step * US if isinstance(step, int) else step for step in self._steps]
        self.state, self.wake = WorkState.READY, None

    def run(self, budget_ns: int) -> int:
        self.on_run()
        left_ns = budget_ns
        self.state, self.wake = WorkState.READY, None
        while self._rest and left_ns > 0:
            step = self._rest[0]
            if not isinstance(step, int):
                self._rest.pop(0)
                self.state, self.wake = WorkState.WAITING, step()
                break
            spent = min(step, left_ns)
            left_ns -= spent
            self._rest[0] = step - spent
            if step == spent:
                self._rest.pop(0)
        if not self._rest and self.state is WorkState.READY:
            self.state = self.ends_in
        self._log.append(Chunk(self.name, self._clock.now_ns() // US, (budget_ns - left_ns) // US))
        return left_ns


class LongInstruction(Burn):
    """Work whose steps are instructions, which have their effects as a whole however long they take."""

    def run(self, budget_ns: int) -> int:
        step = self._rest.pop(0)
        assert isinstance(step, int)
        self.state = self.ends_in if not self._rest else WorkState.READY
        self._log.append(Chunk(self.name, self._clock.now_ns() // US, step // US))
        return budget_ns - step


@dataclass
class Bench:
    """A scheduler with its log of chunks."""

    clock: VirtualClock = field(default_factory=VirtualClock)
    log: list[Chunk] = field(default_factory=list)
    tasks: list[Task] = field(default_factory=list)
    told: list[tuple[str, str, int]] = field(default_factory=list)
    quiet: list[tuple[str, bool]] = field(default_factory=list)

    def task(
        self,
        name: str,
        *steps_us: int | Callable[[], Pending],
        ms: float = 10,
        priority: int = 16,
        kind: TaskKind = TaskKind.CYCLIC,
        event: Callable[[], bool] | None = None,
    ) -> Task:
        work = Burn(name, self.clock, self.log, *steps_us)
        found = Task(name, work, priority=priority, kind=kind, interval_ns=round(ms * MS), event=event)
        self.tasks.append(found)
        return found

    def start(self) -> Scheduler:
        self.scheduler = Scheduler(self.clock, self, self.tasks)
        self.scheduler.start()
        return self.scheduler

    def run_to(self, ms: float) -> "Bench":
        self.clock.advance_to(round(ms * MS))
        return self

    def begins(self, name: str) -> list[int]:
        return [chunk.begin_us for chunk in self.log if chunk.name == name]

    def state(self, task: Task) -> TaskState:
        return task.state(is_started=self.scheduler.is_started, is_running=self.scheduler.is_running)

    # ---- the owner

    def on_cycle_end(self, task: Task, *, is_quiet: bool) -> None:
        self.quiet.append((task.name, is_quiet))

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        self.told.append((task.name, "serious" if is_serious else "minor", elapsed_ns // US))

    def on_fault(self, task: Task) -> None:
        self.told.append((task.name, "fault", 0))

    def on_halt(self, task: Task) -> None:
        self.told.append((task.name, "halt", 0))


@pytest.fixture
def bench() -> Bench:
    return Bench()


class StallingClock(VirtualClock):
    """A clock whose host can stand still, so that timers are called late."""

    def stall_to(self, ms: float) -> None:
        self.instant_ns = round(ms * MS)
        while (timer := self._timers.pop_due(self.instant_ns)) is not None:
            action, timer.action = timer.action, None
            assert action is not None
            action()


@pytest.mark.manual("PD-072")
@pytest.mark.parametrize("stalls_at_ms", [0.1, 0.6], ids=["in the first chunk", "in the last chunk"])
def test_time_in_which_the_host_stands_still_is_no_load_of_the_program(stalls_at_ms: float) -> None:
    clock = StallingClock()
    bench = Bench(clock=clock)
    task = bench.task("late", 650, ms=10)
    bench.start()
    bench.run_to(stalls_at_ms)
    clock.stall_to(45)
    bench.run_to(48)
    assert (task.cycles, task.load_ns, bench.told) == (2, 650 * US, [])


@pytest.mark.manual("PD-061", "PD-060")
def test_higher_priority_interrupts_the_lower_one_at_its_instant_and_the_lower_one_resumes(bench: Bench) -> None:
    bench.task("low", 1_100, ms=10, priority=31)
    bench.task("high", 100, ms=1, priority=0)
    bench.start()
    bench.run_to(3)
    assert bench.begins("high") == [0, 1_000, 2_000, 3_000]
    assert bench.begins("low") == [100, 350, 600, 850, 1_100, 1_200]  # cut off at 1000; its slice lasts until 1200
    assert bench.quiet == [("high", True), ("high", False), ("low", True), ("high", True), ("high", True)]


@pytest.mark.manual("PD-061", "PD-074")
def test_a_long_instruction_is_interrupted_and_supervised_like_short_ones(bench: Bench) -> None:
    high = bench.task("high", 100, ms=1, priority=0)
    long = bench.task("long", ms=10, priority=31)
    long.work = LongInstruction("long", bench.clock, bench.log, 30_000, 90_000, 50)
    bench.start()
    bench.run_to(99)
    assert bench.begins("high")[:35] == list(range(0, 35_000, 1_000))
    assert bench.begins("long")[:2] == [100, 33_400]  # 30 ms of 0.9 ms in each ms, from 0.1 ms on
    assert [(name, kind) for name, kind, _ in bench.told] == [("long", "minor")]
    assert 10_250 < bench.told[0][2] <= 10_750
    bench.run_to(102)
    assert (long.cycles, bench.told[1][1], bench.state(long)) == (0, "serious", TaskState.ERROR)
    assert high.load_ns == 100 * US
    assert long.cpu_ns / US == pytest.approx(0.9 * bench.told[1][2], abs=300)  # what it had by then


@pytest.mark.manual("PD-062")
def test_equal_priorities_alternate_every_250_us(bench: Bench) -> None:
    bench.task("a", 600, priority=7)
    bench.task("b", 600, priority=7)
    bench.start()
    bench.run_to(5)
    assert [(chunk.name, chunk.begin_us) for chunk in bench.log] == [
        ("a", 0), ("b", 250), ("a", 500), ("b", 750), ("a", 1_000), ("b", 1_100)
    ]  # fmt: skip


@pytest.mark.manual("PD-062")
def test_an_interruption_does_not_cost_the_place_in_the_row(bench: Bench) -> None:
    bench.task("a", 500, priority=7)
    bench.task("b", 500, priority=7)
    bench.task("high", 50, ms=0.3, priority=1)
    bench.start()
    bench.run_to(0.7)
    names = [(chunk.name, chunk.begin_us, chunk.used_us) for chunk in bench.log]
    assert names == [
        ("high", 0, 50), ("a", 50, 250), ("high", 300, 50), ("b", 350, 250), ("high", 600, 50), ("a", 650, 250),
    ]  # fmt: skip


@pytest.mark.manual("PD-069")
def test_a_late_start_shortens_the_interval_to_return_to_the_grid(bench: Bench) -> None:
    late = bench.task("late", 100, ms=10, priority=20)
    other = bench.task("other", 3_000, ms=20, priority=1)
    other.work.begin()
    bench.start()
    bench.run_to(9)
    assert bench.begins("late") == [3_000]
    bench.run_to(10.5)
    assert (bench.begins("late"), late.cycle_ns) == ([3_000, 10_000], 7 * MS)
    bench.run_to(30)
    assert late.cycle_ns == 7 * MS
    assert bench.begins("late")[:4] == [3_000, 10_000, 23_000, 30_000]
    assert late.load_ns == 100 * US


@pytest.mark.manual("PD-069")
def test_a_cycle_that_ends_behind_the_next_point_of_the_grid_is_followed_by_a_shorter_one(bench: Bench) -> None:
    late = bench.task("late", 1_000, ms=10, priority=20)
    bench.task("other", 12_000, ms=100, priority=1)
    bench.start()
    bench.run_to(45)
    assert bench.begins("late")[::4] == [12_000, 13_000, 20_000, 30_000, 40_000]  # a cycle has four chunks
    assert late.cycle_ns == 10 * MS


@pytest.mark.manual("PD-073")
@pytest.mark.parametrize(("used_us", "told"), [(10_250, []), (10_251, [("t", "minor", 10_251)])])
def test_transgression_is_more_than_250_us_over_the_cycle_time(bench: Bench, used_us: int, told: object) -> None:
    bench.task("t", used_us, ms=10)
    bench.start()
    bench.run_to(10.4)
    assert bench.told == told


@pytest.mark.manual("PD-074", "PD-075", "PD-071")
def test_an_endless_loop_is_reported_and_then_suspended_at_ten_cycle_times(bench: Bench) -> None:
    task = bench.task("t", ENDLESS, ms=10)
    other = bench.task("other", 10, ms=10, priority=31)
    bench.start()
    bench.run_to(200)
    (minor, serious) = bench.told
    assert minor[:2] == ("t", "minor")
    assert 10_250 < minor[2] <= 10_750
    assert serious[:2] == ("t", "serious")
    assert 100_000 < serious[2] <= 100_500
    assert bench.state(task) is TaskState.ERROR
    assert bench.state(other) is TaskState.CRUNNING
    assert other.cycles >= 10
    bench.scheduler.stop()
    bench.scheduler.start()
    bench.run_to(220)
    assert bench.state(task) is TaskState.ERROR  # only a reset ends it
    bench.scheduler.reset()
    assert bench.state(task) is TaskState.READY
    bench.scheduler.start()
    assert bench.state(task) is TaskState.CRUNNING


def test_a_task_that_waits_is_supervised_although_the_processor_is_idle(bench: Bench) -> None:
    bench.task("t", 10, Pending, ms=1)
    bench.start()
    bench.run_to(20)
    assert [(name, what) for name, what, _ in bench.told] == [("t", "minor"), ("t", "serious")]
    assert bench.log[-1].begin_us == 0


@pytest.mark.manual("PD-077")
def test_check_time_replaces_the_cycle_time_in_the_supervision(bench: Bench) -> None:
    task = bench.task("t", 30_000, ms=10)
    scheduler = bench.start()
    scheduler.set_check_time(task, 40 * MS)
    bench.run_to(35)
    assert bench.told == []
    scheduler.set_check_time(task, 0)
    bench.run_to(50)
    assert [(name, what) for name, what, _ in bench.told] == [("t", "minor")]


@pytest.mark.manual("PD-028", "PD-078")
def test_a_slow_answer_holds_its_task_and_leaves_the_processor_to_others(bench: Bench) -> None:
    answers: list[Pending] = []

    def ask() -> Pending:
        answers.append(Pending())
        return answers[-1]

    bench.task("slow", 100, ask, 100, ms=100, priority=5)
    bench.task("low", 100, ms=1, priority=31)
    bench.start()
    bench.run_to(7.05)
    assert bench.begins("slow") == [0]
    assert len(bench.begins("low")) == 8
    answers[0].finish(1)  # the chunk of the other task ends first
    bench.run_to(9)
    assert bench.begins("slow") == [0, 7_100]
    assert bench.tasks[0].load_ns == 7_200 * US


def test_an_answer_after_a_reset_wakes_nothing(bench: Bench) -> None:
    answer = Pending()
    bench.task("t", 100, lambda: answer, 100, ms=10)
    scheduler = bench.start()
    bench.run_to(5)
    scheduler.reset()
    answer.finish()
    bench.run_to(50)
    assert bench.begins("t") == [0]


@pytest.mark.manual("PD-071")
def test_stopped_tasks_go_on_where_they_were_and_the_pause_does_not_count(bench: Bench) -> None:
    task = bench.task("t", 5_000, ms=10)
    scheduler = bench.start()
    bench.run_to(1)
    scheduler.stop()
    assert bench.state(task) is TaskState.STOPPED
    bench.run_to(501)
    assert bench.begins("t")[-1] <= 1_000
    scheduler.start()
    bench.run_to(512)
    assert task.cycles == 1
    assert task.load_ns == 5_000 * US
    assert bench.told == []
    assert 509_750 in bench.begins("t")  # the grid has moved by the pause, from the end of the chunk at 1.25 ms


@pytest.mark.manual("PD-060", "PD-071")
def test_an_event_task_starts_at_a_rising_edge_only(bench: Bench) -> None:
    level = [True]
    task = bench.task("event", 100, kind=TaskKind.EVENT, event=lambda: level[0])
    scheduler = bench.start()
    bench.run_to(5)
    assert bench.log == []
    assert bench.state(task) is TaskState.READY
    level[0] = False
    scheduler.look()
    level[0] = True
    scheduler.look()
    assert bench.state(task) is TaskState.RUNNING
    scheduler.look()
    bench.run_to(6)
    assert bench.begins("event") == [5_000]
    assert bench.state(task) is TaskState.FINISHED


def test_an_edge_that_another_task_makes_starts_the_event_task_after_its_chunk(bench: Bench) -> None:
    level = [False]
    setter = bench.task("setter", 600, ms=100, priority=31)
    assert isinstance(setter.work, Burn)
    setter.work.on_run = lambda: level.__setitem__(0, True)
    bench.task("event", 100, priority=1, kind=TaskKind.EVENT, event=lambda: level[0])
    bench.start()
    bench.run_to(2)
    assert bench.begins("event") == [250]


def test_a_free_running_task_begins_again_at_the_next_tick(bench: Bench) -> None:
    task = bench.task("free", 300, kind=TaskKind.FREE)
    bench.start()
    bench.run_to(1.6)
    assert bench.begins("free") == [0, 250, 500, 750, 1_000, 1_250, 1_500]
    assert task.cycles == 3
    assert bench.told == []


@pytest.mark.manual("PD-084")
def test_the_real_time_process_lengthens_the_chunk_that_it_interrupts(bench: Bench) -> None:
    task = bench.task("t", 200, ms=10)
    scheduler = bench.start()
    bench.clock.call_at(100 * US, lambda: scheduler.take(300 * US))
    bench.clock.call_at(10 * MS, lambda: scheduler.take(300 * US))
    bench.run_to(9)
    assert task.load_ns == 500 * US
    bench.run_to(11)
    assert bench.begins("t") == [0, 10_300] or bench.begins("t") == [0, 10_000]
    assert task.cpu_ns == 400 * US
    assert scheduler.busy_ns == 1_000 * US


@pytest.mark.manual("PD-065")
def test_work_of_the_system_ends_while_the_program_is_stopped(bench: Bench) -> None:
    bench.task("urgent", 100, ms=2, priority=3)
    scheduler = bench.start()
    system, done = SystemWork(), list[int]()
    tcp = Task("TCP/IP", system, priority=5, is_system=True)
    bench.run_to(1)
    scheduler.stop()
    bench.run_to(10)  # the next cycles of `urgent` are due, and do not begin
    for _ in range(2):
        system.add(300 * US, lambda: done.append(bench.clock.now_ns()))
    scheduler.release(tcp)
    bench.run_to(11)
    assert (done, system.is_busy) == ([10 * MS, 10 * MS + 300 * US], False)


def test_work_of_the_system_takes_its_place_among_the_priorities(bench: Bench) -> None:
    bench.task("above", 400, ms=10, priority=3)
    below = bench.task("below", 400, ms=10, priority=6)
    scheduler = bench.start()
    system = SystemWork()
    io_map = Task("IO map", system, priority=IO_MAP_PRIORITY, is_system=True)
    done: list[int] = []
    system.add(500 * US, lambda: done.append(bench.clock.now_ns()))
    scheduler.release(io_map)
    bench.run_to(5)
    assert done == [400 * US]
    assert bench.begins("below") == [900, 1_150]
    assert below.load_ns == 400 * US
    scheduler.stop()
    system.add(500 * US, lambda: done.append(bench.clock.now_ns()))
    scheduler.release(io_map)
    bench.run_to(6)
    assert done == [400 * US, 5 * MS]  # also while the program is stopped


def test_a_job_that_arrives_during_the_last_chunk_is_done_next(bench: Bench) -> None:
    scheduler = bench.start()
    system = SystemWork()
    tcp = Task("TCP/IP", system, priority=5, is_system=True)
    done: list[int] = []

    def ask() -> None:
        system.add(100 * US, lambda: done.append(bench.clock.now_ns() // US))
        scheduler.release(tcp)

    for at_us in (1_000, 1_050, 1_500):
        bench.clock.call_at(at_us * US, ask)
    bench.run_to(3)
    assert done == [1_000, 1_100, 1_500]


def test_other_events_have_their_turn_between_two_jobs(bench: Bench) -> None:
    scheduler = bench.start()
    system = SystemWork()
    tcp = Task("TCP/IP", system, priority=5, is_system=True)
    done: list[str] = []
    for number in range(3):
        system.add(100 * US, partial(done.append, f"job {number}"))
    bench.clock.call_at(150 * US, lambda: done.append("cycle"))
    scheduler.release(tcp)
    bench.run_to(3)
    assert done == ["job 0", "job 1", "cycle", "job 2"]


def test_a_job_that_takes_the_host_longer_comes_after_a_cycle_that_is_due() -> None:
    """In real time an event has the instant at which it was due, and `late_ns` grows while the host works on it."""
    host = BusyHost()
    bench = Bench(clock=host)
    scheduler = bench.start()
    system = SystemWork()
    tcp = Task("TCP/IP", system, priority=5, is_system=True)
    done: list[str] = []

    def job(number: int) -> None:
        done.append(f"job {number}")
        host.work(2 * MS)

    for number in range(3):
        system.add(100 * US, partial(job, number))
    bench.clock.call_at(1500 * US, lambda: done.append("cycle"))
    scheduler.release(tcp)
    bench.run_to(10)
    assert done == ["job 0", "cycle", "job 1", "job 2"]


def test_a_breakpoint_holds_the_task_and_the_time_there_does_not_count(bench: Bench) -> None:
    task = bench.task("t", 100, ms=10)
    assert isinstance(task.work, Burn)
    task.work.ends_in = WorkState.STOPPED
    scheduler = bench.start()
    bench.run_to(500)
    assert bench.state(task) is TaskState.BP
    assert bench.told == [("t", "halt", 0)]
    task.work.ends_in = WorkState.ENDED
    scheduler.resume(task)
    bench.run_to(510)
    assert bench.told == [("t", "halt", 0)]
    assert task.cycles == 2
    assert bench.state(task) is TaskState.CRUNNING


def test_a_fault_suspends_its_task_only(bench: Bench) -> None:
    task = bench.task("t", 100, ms=10)
    other = bench.task("other", 100, ms=10)
    assert isinstance(task.work, Burn)
    task.work.ends_in = WorkState.FAULTED
    bench.start()
    bench.run_to(55)
    assert bench.told == [("t", "fault", 0)]
    assert bench.state(task) is TaskState.ERROR
    assert other.cycles == 6


@pytest.mark.manual("PD-085")
def test_share_is_the_measured_part_of_the_processor(bench: Bench) -> None:
    bench.task("t", 2_500, ms=10)
    scheduler = bench.start()
    bench.run_to(990)
    assert scheduler.share == pytest.approx(0.25, abs=0.03)
    scheduler.stop()
    bench.run_to(5_000)
    assert scheduler.share < 0.03


def test_quiet_is_when_no_task_is_within_a_cycle(bench: Bench) -> None:
    bench.task("long", 3_000, ms=10, priority=31)
    bench.task("short", 100, ms=1, priority=1)
    scheduler = bench.start()
    bench.run_to(1.5)
    at: list[int] = []
    scheduler.when_quiet(lambda: at.append(bench.clock.now_ns() // US))
    bench.run_to(9)
    assert at == [3_400]  # 3000 us of its own, and four cycles of the other task


@st.composite
def task_sets(draw: st.DrawFn) -> list[tuple[float, int, int, int]]:
    """Interval in ms, priority, and two parts of the work in us."""
    return draw(
        st.lists(
            st.tuples(
                st.sampled_from([0.5, 1, 2, 3, 7, 10]),
                st.integers(0, 31),
                st.integers(1, 900),
                st.integers(1, 900),
            ),
            min_size=1,
            max_size=6,
        )
    )


@pytest.mark.long
@given(tasks=task_sets(), process_us=st.integers(0, 900))
def test_the_sum_of_time_is_conserved_and_overload_repeats_exactly(
    tasks: list[tuple[float, int, int, int]], process_us: int
) -> None:
    def play() -> Bench:
        bench = Bench()
        for number, (ms, priority, first, second) in enumerate(tasks):
            bench.task(str(number), first, second, ms=ms, priority=priority)
        scheduler = bench.start()

        def process() -> None:
            scheduler.take(process_us * US)
            bench.clock.call_at(bench.clock.now_ns() + 4 * MS, process)

        process()
        bench.run_to(40)
        return bench

    bench = play()
    scheduler = bench.scheduler
    used_us = sum(chunk.used_us for chunk in bench.log)
    assert sum(task.cpu_ns for task in bench.tasks) == used_us * US
    assert scheduler.busy_ns == (used_us + 11 * process_us) * US
    for before, after in pairwise(bench.log):
        assert before.used_us <= 250 or before.used_us * US < SHORTEST_NS
        assert after.begin_us >= before.begin_us + before.used_us
    again = play()
    assert again.log == bench.log
    assert again.told == bench.told


@given(tasks=task_sets())
def test_a_higher_priority_never_waits_for_more_than_a_chunk_of_a_lower_one(
    tasks: list[tuple[float, int, int, int]],
) -> None:
    bench = Bench()
    for number, (ms, _, first, second) in enumerate(tasks):
        bench.task(str(number), first, second, ms=ms, priority=number + 1)
    top = Pending()
    bench.task("top", lambda: top, 10, ms=100, priority=0)
    bench.start()
    bench.run_to(20.1)
    top.finish()
    bench.run_to(30)
    woken_us = bench.begins("top")[1]
    assert woken_us <= 20_100 + 250
    highest = bench.begins("0")
    interval_us = round(tasks[0][0] * 1000)
    if sum(tasks[0][2:]) <= interval_us:
        begun = {at // interval_us * interval_us for at in highest}
        assert all(any(at - grid <= 260 for at in highest if at >= grid) for grid in begun)


OPERATIONS = ("run", "stop", "start", "reset", "take", "system", "look", "answer", "resume", "fault", "halt")


@given(operations=st.lists(st.tuples(st.sampled_from(OPERATIONS), st.integers(1, 3_000)), max_size=60))
def test_no_sequence_of_events_loses_a_task_or_runs_two_at_a_time(operations: list[tuple[str, int]]) -> None:
    bench, answers, level, system = Bench(), list[Pending](), [False], SystemWork()

    def ask() -> Pending:
        answers.append(Pending())
        return answers[-1]

    bench.task("waits", 100, ask, 400, ms=2, priority=3)
    victim = bench.task("victim", 700, ms=3, priority=9)
    bench.task("free", 100, priority=9, kind=TaskKind.FREE)
    bench.task("event", 50, priority=1, kind=TaskKind.EVENT, event=lambda: level[0])
    scheduler = bench.start()
    tcp = Task("TCP/IP", system, priority=5, is_system=True)
    assert isinstance(victim.work, Burn)
    for what, number in operations:
        match what:
            case "run":
                bench.run_to(bench.clock.now_ns() / MS + number / 1_000)
            case "stop":
                scheduler.stop()
            case "start":
                scheduler.start()
            case "reset":
                scheduler.reset()
            case "take":
                scheduler.take(number * US)
            case "system":
                system.add(number * US, lambda: None)
                scheduler.release(tcp)
            case "look":
                level[0] = bool(number % 2)
                scheduler.look()
            case "answer" if answers:
                answers[number % len(answers)].finish()
            case "resume":
                scheduler.resume(victim)
            case "fault" | "halt":
                victim.work.ends_in = WorkState.FAULTED if what == "fault" else WorkState.STOPPED
    scheduler.reset()
    victim.work.ends_in = WorkState.ENDED
    bench.run_to(bench.clock.now_ns() / MS + 2_000)  # what the system still has to do is done
    assert not system.is_busy
    before = {task.name: task.cpu_ns for task in bench.tasks}
    scheduler.start()
    bench.run_to(bench.clock.now_ns() / MS + 20)
    ran = {task.name for task in bench.tasks if task.cpu_ns > before[task.name]}
    assert ran == {"waits", "victim", "free"}
    for earlier, later in pairwise(bench.log):
        assert later.begin_us >= earlier.begin_us + earlier.used_us
