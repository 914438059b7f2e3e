"""Runs one TEST block: its statements, the time that they let pass, and its teardown."""

from collections.abc import Callable
from pathlib import Path
from typing import Final, Protocol

from fieldrig.errors import RigError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.testing.alone import TaskFaultError
from fieldrig_devices.iec.testing.case import FAULT, TIMEOUT, Case, Failure, Limits, Outcome, Verdict
from fieldrig_devices.iec.testing.compiled import Tested
from fieldrig_devices.iec.testing.extension import TEARDOWN, CaseBlock
from fieldrig_devices.iec.testing.judge import ASSERT, Judge
from fieldrig_devices.iec.testing.recorder import Recorder
from fieldrig_devices.iec.thread import Fault, Thread

SLICE_NS: Final = 1_000_000
"""Processor time of the test between two looks at the clock of the host."""


class TookTooLongError(Exception):
    """A test has taken longer than a limit allows."""


class Place(Protocol):
    """The place where a test runs: alone, or with a rig around it."""

    is_pressed: Callable[[], None]

    @property
    def now_ns(self) -> int: ...

    @property
    def runtime(self) -> Runtime: ...

    def begin(self, block: CaseBlock) -> None: ...

    def fault(self, where: str, fault: str) -> None: ...

    def clear_faults(self, where: str) -> None: ...

    def run_until(self, until_ns: int) -> None: ...

    def run_tasks(
        self, until_ns: int, look: Callable[[], bool] | None = None, reads: frozenset[str] | None = None
    ) -> None:
        """Let the tasks run, and call `look` when it may see something else than before, until it is false.

        It depends on the variables `reads` of the test; None if it may be anything.
        """


class BlockThread(Thread):
    """Runs the instance of a test, or its teardown."""

    def __init__(self, runtime: Runtime, block: CaseBlock, action: str = "") -> None:
        super().__init__(runtime, block.pou, 0)
        routine = f"{block.pou}.{action}" if action else block.pou
        self.enter(routine.lower(), runtime.compiled.program.globals[block.instance.lower()].offset)


class Runner:
    def __init__(self, tested: Tested, place: Place) -> None:
        self._tested, self._place = tested, place
        self._judge: Judge = tested.judge

    def run(self, case: Case, block: CaseBlock, limits: Limits, *, is_recorded: bool = False) -> Outcome:
        """Run a test from a fresh state."""
        place, judge, watch = self._place, self._judge, Stopwatch()

        def is_pressed() -> None:
            if watch.busy_seconds > limits.timeout_s:
                raise TookTooLongError(f"the test took more than {limits.timeout_s:g} s")

        place.is_pressed = is_pressed
        place.begin(block)
        begin_ns = place.now_ns
        judge.begin_test(place)
        recorder = Recorder(place.runtime, block, lambda: place.now_ns - begin_ns) if is_recorded else None
        judge.on_look = recorder.look if recorder is not None else None
        failures = self._played(BlockThread(place.runtime, block), is_pressed)
        if block.has_teardown:
            failures += self._played(BlockThread(place.runtime, block, TEARDOWN), is_pressed)
        failures = [one._replace(at_ns=one.at_ns - begin_ns) for one in failures]
        if recorder is not None and failures:
            drawn = (*failures[0].diagram, *recorder.diagram(failures[0]))
            failures[0] = failures[0]._replace(diagram=drawn)
        verdict = Verdict.PASSED
        if failures:
            are_errors = any(one.kind in (FAULT, TIMEOUT) for one in failures)
            verdict = Verdict.ERROR if are_errors else Verdict.FAILED
        duration_ns = place.now_ns - begin_ns
        output = tuple(judge.output)
        return Outcome(
            case, verdict, tuple(failures), judge.asserts, duration_ns, watch.seconds, output, busy_s=watch.busy_seconds
        )

    def _played(self, thread: Thread, is_pressed: Callable[[], None]) -> list[Failure]:
        """Run a thread to its end."""
        judge = self._judge
        judge.begin_part()
        thread.start()
        try:
            while True:
                self._go(thread, is_pressed)
                if thread.state is not WorkState.WAITING:
                    break
                self._wait(thread, is_pressed)
        except TookTooLongError as limit:
            return [self._here(TIMEOUT, thread, str(limit))]
        except RigError as wrong:
            return [self._here(FAULT, thread, f"{wrong.what}; {wrong.remedy}" if wrong.remedy else wrong.what)]
        except TaskFaultError as wrong:
            return [_failure(FAULT, wrong.fault, str(wrong), self._place.now_ns)]
        fault = thread.fault
        if fault is None:
            return []
        if fault.code == ASSERT and judge.failure is not None:
            return [judge.failure]
        return [_failure(FAULT, _outside(fault), fault.text, self._place.now_ns)]

    def _here(self, kind: str, thread: Thread, text: str) -> Failure:
        """Return a failure where a test is that has not ended."""
        where = thread.fault_here(kind, text)
        return _failure(kind, where if where is None else _outside(where), text, self._place.now_ns)

    def _go(self, thread: Thread, is_pressed: Callable[[], None]) -> None:
        while thread.state is WorkState.READY:
            thread.run(SLICE_NS)
            if thread.state is WorkState.READY:
                is_pressed()

    def _wait(self, thread: Thread, is_pressed: Callable[[], None]) -> None:
        """Let the time pass that the test waits for."""
        is_pressed()
        wish = self._judge.wish
        assert wish is not None, "a test waits for its judge only"
        if wish.is_settled:
            wish.answer.finish(False)
        elif wish.is_watching:
            self._place.run_tasks(wish.until_ns, lambda: self._looks(thread, is_pressed), wish.reads)
        else:
            pass_time = self._place.run_tasks if wish.is_running else self._place.run_until
            pass_time(wish.until_ns)
            wish.answer.finish(True)

    def _looks(self, thread: Thread, is_pressed: Callable[[], None]) -> bool:
        """Let the test look at its expectation; false if it has seen enough."""
        wish = self._judge.wish
        assert wish is not None, "the test has looked before"
        wish.answer.finish(True)
        self._go(thread, is_pressed)
        return thread.state is WorkState.WAITING and not self._settled

    @property
    def _settled(self) -> bool:
        return self._judge.wish is None or self._judge.wish.is_settled


def _outside(fault: Fault) -> Fault:
    """Return a fault where the test has it, if it was raised by a native function of the judge."""
    callers = [one for one in fault.calls if not one.file.startswith("tests of")]
    if fault.file.startswith("tests of") and callers:
        first, *others = callers
        return Fault(fault.code, fault.text, first.routine, first.file, first.line, tuple(others))
    return fault


def _failure(kind: str, fault: Fault | None, text: str, now_ns: int) -> Failure:
    file, line = (Path(fault.file), fault.line) if fault is not None else (Path(), 0)
    calls = () if fault is None else tuple(f"called from {call.file}:{call.line}" for call in fault.calls)
    return Failure(kind, "", text, "", file, line, now_ns, calls)
