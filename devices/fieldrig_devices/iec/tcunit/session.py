"""One run of test suites: which of them run, the tests that they declare, and the asserts of these.

Source: TcUnit 1.3.2.  A suite is known by its address, as a program knows it.  `RUN` is called once in each cycle; it
asks for one suite after the other with `following`, and calls their bodies in between.
"""

from collections import Counter
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from fieldrig_devices.iec.tcunit import forms

DISABLED: Final = "disabled_"
"""The begin of the names of tests that are skipped, in any case of letters."""
SEQUENCE_DELAY: Final = 3
"""Cycles from the one in which a suite finishes to the one in which the next of a sequence starts, without a pause."""


class Failed(NamedTuple):
    """A failed assert."""

    kind: str
    """The type, as TcUnit names it: `BYTE`, `Array_BOOL`, `Array2D_REAL`, `ANY`."""
    expected: str
    actual: str
    message: str
    line: str
    """The line of the report."""
    at_ns: int
    file: str
    source_line: int
    operands: str = ""
    """The variables of a condition with their values, as a continuation of what there was."""


@dataclass(slots=True, eq=False)
class Test:
    name: str
    is_skipped: bool = False
    is_finished: bool = False
    order: int = 0
    """The place among the ordered tests of the suite, from 1; 0 for a test without one."""
    asserts: int = 0
    failures: list[Failed] = field(default_factory=list)
    is_beyond: bool = False
    """True for a test for which the suite has no room; it counts as failed."""
    started_ns: int | None = None
    ended_ns: int | None = None
    fault: str = ""
    """Why the test has not come to its end; empty if it has."""

    @property
    def is_done(self) -> bool:
        return self.is_finished or self.is_skipped

    @property
    def has_failed(self) -> bool:
        return bool(self.failures) or self.is_beyond or bool(self.fault)

    @property
    def shown(self) -> str:
        """The name in the report, without the mark of a skipped test."""
        return self.name[len(DISABLED) :] if self.is_skipped else self.name

    @property
    def duration_ns(self) -> int:
        is_whole = self.started_ns is not None and self.ended_ns is not None
        return (self.ended_ns or 0) - (self.started_ns or 0) if is_whole else 0


class Repeats:
    """Which asserts are new: the body of a suite runs in each cycle, and makes the same ones again and again."""

    def __init__(self) -> None:
        self._cycle = -1
        self._before: Counter[Hashable] = Counter()
        self._now: Counter[Hashable] = Counter()
        self.count = 0
        self.has_overflown = False

    def is_new(self, key: Hashable, cycle: int) -> bool:
        """True for an assert beyond as many equal ones as the previous cycle with asserts had."""
        if cycle != self._cycle:
            self._cycle, self._before, self._now = cycle, self._now, Counter()
        self._now[key] += 1
        return self._now[key] > self._before[key]


@dataclass(slots=True, eq=False)
class Suite:
    address: int
    path: str
    number: int
    tests: dict[str, Test] = field(default_factory=dict)
    current: Test | None = None
    """The test that asserts belong to; None if they are ignored."""
    last_named: Test | None = None
    """The test that TEST_FINISHED ends."""
    is_finished: bool = False
    turn: int = 1
    """The number of the ordered test whose turn it is."""
    ordered: int = 0
    declared: set[str] = field(default_factory=set)
    """The names that were declared in this cycle."""
    doubled: set[str] = field(default_factory=set)
    """The names that were reported because they occur twice in a cycle."""
    scalars: Repeats = field(default_factory=Repeats)
    arrays: Repeats = field(default_factory=Repeats)
    started_ns: int | None = None
    ended_ns: int | None = None
    fault: str = ""
    """The run-time fault that ended the suite; empty if there was none."""
    busy_s: float = 0.0
    """The time for which the suite has had a processor, up to its last call that has ended."""

    @property
    def are_all_done(self) -> bool:
        return all(test.is_done for test in self.tests.values())

    @property
    def duration_ns(self) -> int:
        return max(0, (self.ended_ns or 0) - (self.started_ns or 0))


@dataclass(frozen=True, slots=True)
class Parameters:
    """The parameters of TcUnit that matter here; the defaults are those of the library."""

    tests_of_suite: int = 100
    asserts_of_suite: int = 1_000
    is_extended: bool = True
    pause_ns: int = 0


class Session:
    """`now_ns` is the clock of the program, and `path_of` gives the path of the instance at an address."""

    def __init__(
        self,
        now_ns: Callable[[], int],
        path_of: Callable[[int], str],
        place: Callable[[], tuple[str, int, str]] = lambda: ("", 0, ""),
        on_line: Callable[[str], None] = lambda line: None,
        busy_s: Callable[[], float] = lambda: 0.0,
    ) -> None:
        """`busy_s` is the time for which the process has had a processor."""
        self._busy_s, self._called_s = busy_s, 0.0
        self._now_ns, self._path_of, self._place, self._on_line = now_ns, path_of, place, on_line
        self.parameters = Parameters()
        self.suites: dict[int, Suite] = {}
        self.lines: list[str] = []
        """The report, line by line."""
        self.is_aborted = False
        self._cycle = 0
        self._open: Iterator[Suite] = iter(())
        self._called: Suite | None = None
        self._named = ""
        """The test that ran when a suite was left; without another TEST, it goes on in the next cycle."""
        self._next_cycle = 0
        """The first cycle of the next suite of a sequence."""
        self._next_ns = 0
        self.has_run = False
        """True once the program has called RUN or RUN_IN_SEQUENCE."""

    # ---- suites

    def register(self, address: int) -> None:
        """Note an instance of a suite, in the order of initialisation."""
        if address not in self.suites:
            self.suites[address] = Suite(address, self._path_of(address), len(self.suites))

    def begin_cycle(self, is_sequence: bool) -> None:
        """Begin the work of RUN or RUN_IN_SEQUENCE in a cycle."""
        self._cycle += 1
        self.has_run = True
        unfinished = [suite for suite in self.suites.values() if not suite.is_finished]
        if is_sequence:
            is_time = self._cycle >= self._next_cycle and self._now_ns() >= self._next_ns
            unfinished = unfinished[:1] if is_time else []
        self._open = iter(unfinished)

    def following(self) -> int:
        """Return the address of the next suite whose body is to run in this cycle; 0 if there is none."""
        self._leave()
        suite = next(self._open, None)
        if suite is None or self.is_aborted:
            return 0
        self._called, self._called_s = suite, self._busy_s()
        suite.declared.clear()
        named = suite.tests.get(self._named)
        suite.current = suite.last_named = named if named is not None and not named.is_done else None
        if suite.started_ns is None:
            suite.started_ns = self._now_ns()
        return suite.address

    def _leave(self) -> None:
        """End the call of a suite: it is finished when all its tests are done, or if it has none."""
        suite, self._called = self._called, None
        if suite is None:
            return
        suite.busy_s += self._busy_s() - self._called_s
        if suite.declared or suite.current is not None:
            self._named = suite.current.name if suite.current is not None else ""
        if suite.are_all_done:
            self._finish(suite)

    def _finish(self, suite: Suite) -> None:
        suite.is_finished, suite.ended_ns = True, self._now_ns()
        pause_ns = self.parameters.pause_ns
        self._next_cycle = self._cycle + (SEQUENCE_DELAY if not pause_ns else 1)
        self._next_ns = self._now_ns() + pause_ns

    @property
    def are_all_finished(self) -> bool:
        return all(suite.is_finished for suite in self.suites.values())

    @property
    def is_over(self) -> bool:
        return self.is_aborted or (self.has_run and self._called is None and self.are_all_finished)

    def give_up(self, fault: str) -> None:
        """End the suite that is running, because of a fault at run time or of a limit."""
        suite, self._called = self._called, None
        if suite is None:
            return
        suite.fault = fault
        test = suite.last_named
        if test is not None and not test.is_done:
            test.fault, test.ended_ns = fault, self._now_ns()
        self._finish(suite)

    @property
    def parts(self) -> int:
        """The number of tests that are known, and of suites without one."""
        return sum(max(1, len(suite.tests)) for suite in self.suites.values())

    def is_stuck(self, limit_s: float) -> bool:
        """True if the suite that is running has had a processor for longer than its tests may, each for this time."""
        suite = self._called
        if suite is None:
            return False
        return suite.busy_s + self._busy_s() - self._called_s > limit_s * max(1, len(suite.tests))

    def end_slow(self, limit_s: float) -> None:
        """End the suites between two cycles that have had a processor for longer than that."""
        for suite in self.suites.values():
            if not suite.is_finished and suite.busy_s > limit_s * max(1, len(suite.tests)):
                self._called = suite
                self.give_up(f"its tests take a processor for more than {limit_s:g} s each")

    @property
    def running(self) -> Suite | None:
        """The suite whose body is running."""
        return self._called

    # ---- tests

    def test(self, name: str) -> None:
        suite = self._called
        if suite is None:
            return
        test = self._declared(suite, name)
        suite.current = test if test is not None and not test.is_done else None
        suite.last_named = suite.tests.get(name.strip(" "))
        if suite.current is not None:
            self._start(suite.current)

    def test_ordered(self, name: str) -> bool:
        """Declare a test that waits for its turn; return whether it is."""
        suite = self._called
        if suite is None:
            return False
        suite.current = suite.last_named = None
        test = self._declared(suite, name)
        if test is None:
            return False
        if not test.order:
            suite.ordered += 1
            test.order = suite.ordered
        if test.order != suite.turn:
            return False
        if test.is_done:
            suite.turn += 1
            return False
        suite.current = suite.last_named = test
        self._start(test)
        return True

    def _declared(self, suite: Suite, name: str) -> Test | None:
        """Return the test with a name, a new one if need be; None for the second one with this name in a cycle."""
        name = name.strip(" ")
        if name in suite.declared:
            if name not in suite.doubled:
                suite.doubled.add(name)
                self._say(f"Test with name '{name}' already exists in test suite '{suite.path}'")
            return None
        suite.declared.add(name)
        if name not in suite.tests:
            test = suite.tests[name] = Test(name, is_skipped=name.casefold().startswith(DISABLED))
            test.is_beyond = len(suite.tests) > self.parameters.tests_of_suite
        return suite.tests[name]

    def _start(self, test: Test) -> None:
        if test.started_ns is None:
            test.started_ns = self._now_ns()

    def finished(self) -> bool:
        """End the current test; return whether there is one."""
        suite = self._called
        test = suite.last_named if suite is not None else None
        if suite is None or test is None:
            return False
        suite.current = None
        self._end(test)
        return True

    def finished_named(self, name: str) -> None:
        """End the test with a name; the run is aborted if the suite has none."""
        suite, name = self._called, name.strip(" ")
        if suite is None:
            return
        test = suite.tests.get(name)
        if test is None:
            self.is_aborted = True
            self._say(f"Failed to find test '{name}'")
            return
        self._end(test)
        if suite.current is test:
            suite.current = None

    def _end(self, test: Test) -> None:
        if not test.is_done:
            test.is_finished, test.ended_ns = True, self._now_ns()

    def is_finished(self, name: str) -> bool:
        """True if the test with a name has come to its end."""
        test = self._called.tests.get(name.strip(" ")) if self._called is not None else None
        return test is not None and test.is_finished

    def are_tests_finished(self, address: int) -> bool:
        suite = self.suites.get(address)
        return suite is not None and suite.are_all_done

    # ---- asserts

    def is_asserting(self, address: int) -> bool:
        """True if an assert of a suite counts; it does not behind the end of its test."""
        suite = self.suites.get(address)
        return suite is not None and suite.current is not None

    def check(
        self,
        address: int,
        kind: str,
        key: Hashable,
        texts: Callable[[], tuple[str, str]] | None,
        message: str,
        note: str = "",
        shown: tuple[str, str] | None = None,
    ) -> None:
        """Count an assert, and report it if it has failed.

        `texts` gives what was expected and what was there; None if they are equal.  `note` follows the message in the
        line of the report.  `shown` are the values for people, if TcUnit's line has no values.
        """
        suite = self.suites.get(address)
        test = suite.current if suite is not None else None
        if suite is None or test is None:
            return
        repeats = suite.arrays if kind.startswith("Array") else suite.scalars
        if not repeats.is_new((key, message, test.name), self._cycle):
            return
        repeats.count += 1
        if repeats.count <= self.parameters.asserts_of_suite:
            test.asserts += 1
        elif not repeats.has_overflown:
            repeats.has_overflown = True
            limit = "Max number of assertions exceeded. Check parameter MaxNumberOfAssertsForEachTestSuite."
            self._say(f"{suite.path}. {limit}")
        if texts is not None:
            expected, actual = texts()
            line = forms.failed(f"{suite.path}@{test.name}", expected, actual, message + note)
            expected, actual = shown or (expected, actual)
            failed = Failed(kind, expected, actual, message, line, self._now_ns(), *self._place())
            test.failures.append(failed)
            self._say(line)

    def say(self, line: str) -> None:
        """Write a line of the program into the report."""
        self._say(line)

    def _say(self, line: str) -> None:
        self.lines.append(line)
        self._on_line(line)
