"""Judges the assertions of one test while it runs: the host's side of the native functions.

The first assertion that fails ends its test, as a fault of the program does, so the line and the calls are known.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Protocol

from fieldrig_devices.iec.elementary import UNITS_NS, Elementary
from fieldrig_devices.iec.host import Library, NativeFunction, Pending, Results
from fieldrig_devices.iec.program import Operator
from fieldrig_devices.iec.testing import natives
from fieldrig_devices.iec.testing.assertions import Assertion
from fieldrig_devices.iec.testing.case import Failure
from fieldrig_devices.iec.testing.texts import both_texts, cells_text
from fieldrig_devices.iec.types import Value
from fieldrig_devices.languages.faults import RunError

ASSERT: Final = "assert"
"""The code of the fault that ends a test."""
_GOES_ON: Final[Results] = (True,)
_COMPARED: Final[Mapping[Operator, Callable[[Value, Value], bool]]] = {
    Operator.EQ: lambda actual, expected: actual == expected,
    Operator.NE: lambda actual, expected: actual != expected,
    Operator.GT: lambda actual, expected: actual > expected,  # type: ignore[operator]
    Operator.LT: lambda actual, expected: actual < expected,  # type: ignore[operator]
    Operator.GE: lambda actual, expected: actual >= expected,  # type: ignore[operator]
    Operator.LE: lambda actual, expected: actual <= expected,  # type: ignore[operator]
}
_WORDS: Final[Mapping[Operator, str]] = {
    Operator.EQ: "",
    Operator.NE: "not ",
    Operator.GT: "more than ",
    Operator.LT: "less than ",
    Operator.GE: "at least ",
    Operator.LE: "at most ",
}


class World(Protocol):
    """The surroundings of a test."""

    @property
    def now_ns(self) -> int: ...

    def fault(self, where: str, fault: str) -> None:
        """Add a fault.  ValueError, saying what was expected, if it is refused."""

    def clear_faults(self, where: str) -> None: ...


@dataclass(slots=True)
class Wish:
    """The time or the expectation that a test waits for."""

    answer: Pending
    until_ns: int
    is_watching: bool = False
    """True if the test looks at everything that happens until then."""
    is_settled: bool = False
    """True if it has seen enough, and goes on when this instant is over."""
    is_running: bool = False
    """True if the tasks of the program run meanwhile."""
    reads: frozenset[str] | None = None
    """The variables on which the expectation depends; None if it may be anything."""


class Judge:
    def __init__(self) -> None:
        self._assertions: Sequence[Assertion] = ()
        self._cells: Sequence[Value] = ()
        self._deadlines: dict[int, int] = {}
        self._noted: list[int] = []
        """The addresses of the operands of the condition that is judged next."""
        self.on_look: Callable[[Assertion], None] | None = None
        """Called at each statement of the test, for the signals around a failure."""
        self.asserts = 0
        self.failure: Failure | None = None
        self.output: list[str] = []
        self.wish: Wish | None = None
        self.calls: Callable[[int, int], bool] = lambda number, address: False
        """Answers a call of a mock by Python; false if the code of the program is to run."""

    @property
    def library(self) -> Library:
        rules: dict[str, Callable[..., Results | Pending]] = {
            natives.JUDGE: self._judge,
            natives.NOTE: self._note,
            natives.ACT: self._act,
            natives.BEGIN: self._begin,
            natives.AGAIN: self._again,
            natives.WAIT: self._wait,
            natives.MOCKED: self._mocked,
        }
        functions = {name: NativeFunction(rule, is_slow=name in natives.SLOW) for name, rule in rules.items()}
        return Library("tests of fieldrig", "", functions, {})

    def use(self, assertions: Sequence[Assertion], cells: Sequence[Value]) -> None:
        self._assertions, self._cells = assertions, cells

    def begin_part(self) -> None:
        """Begin the test itself, or its teardown."""
        self.failure = self.wish = None
        self._noted.clear()

    def begin_test(self, world: World) -> None:
        self._world = world
        self._deadlines.clear()
        self.asserts, self.failure, self.wish, self.output = 0, None, None, []

    # ---- what generated code calls

    def _note(self, number: int, *addresses: int) -> Results:
        self._noted += [address for address in addresses if address]
        return _GOES_ON

    def _judge(self, number: int, actual: int, expected: int, tolerance: int, message: int) -> Results:
        assertion = self._assertions[number]
        self.asserts += 1
        if self.on_look is not None:
            self.on_look(assertion)
        if not self._holds(assertion, actual, expected, tolerance):
            self._fail(assertion, *self._shown(assertion, actual, expected, tolerance), message)
        self._noted.clear()
        return _GOES_ON

    def _holds(self, assertion: Assertion, actual: int, expected: int, tolerance: int) -> bool:
        cells, operator = self._cells, assertion.kind.operator
        if operator is not None:
            if tolerance:
                off = abs(cells[actual] - cells[expected])  # type: ignore[operator]
                return bool(off <= cells[tolerance])
            size = assertion.type.size
            if isinstance(assertion.type, Elementary) or size <= 1:
                return _COMPARED[operator](cells[actual], cells[expected])
            are_equal = cells[actual : actual + size] == cells[expected : expected + size]
            if operator in (Operator.EQ, Operator.NE):
                return are_equal is (operator is Operator.EQ)
            return _COMPARED[operator](cells[actual], cells[expected])
        match assertion.word:
            case "ASSERT_FAIL":
                return False
            case "ASSERT_FALSE":
                return not cells[actual]
            case "MOCK_VERIFY_CALL_COUNT":
                return cells[actual] == cells[expected]
        return bool(cells[actual])

    def _shown(self, assertion: Assertion, actual: int, expected: int, tolerance: int) -> tuple[str, str]:
        """Return what was expected and what there was, as texts."""
        cells, kind = self._cells, assertion.shown or assertion.type
        match assertion.word:
            case "ASSERT_FAIL":
                return "", ""
            case "ASSERT_FALSE":
                return "FALSE", f"TRUE{self._operands(assertion)}"
            case "MOCK_VERIFY_CALLED":
                return "a call", "none"
            case "MOCK_VERIFY_CALL_COUNT":
                return f"{cells[expected]} calls", f"{cells[actual]}"
        if assertion.kind.operator is None:
            return "TRUE", f"FALSE{self._operands(assertion)}"
        shown, wanted, path = both_texts(kind, cells, actual, expected)
        wanted = f"{_WORDS[assertion.kind.operator]}{wanted}"
        if tolerance:
            wanted = f"{wanted} +- {cells_text(kind, cells, tolerance)}"
        where = f"{path[path[:1] == '.' :]} = " if path else ""
        return f"{where}{wanted}", f"{where}{shown}"

    def _operands(self, assertion: Assertion) -> str:
        """Return the values of what a condition is made of, each once, apart from constants."""
        pairs = zip(assertion.operands, self._noted, strict=False)
        shown = dict.fromkeys(f"{of} = {cells_text(kind, self._cells, at)}" for (of, kind), at in pairs if of)
        return f", where {' and '.join(shown)}" if shown else ""

    def _fail(self, assertion: Assertion, expected: str, actual: str, message: int) -> None:
        text = assertion.message or (str(self._cells[message]) if message else "")
        self.failure = Failure(
            assertion.word, expected, actual, text, Path(assertion.file), assertion.line, self._world.now_ns
        )
        raise RunError(ASSERT, f"{assertion.word} failed")

    def _act(self, number: int, first: int, second: int, third: int, message: int) -> Results:
        assertion, cells = self._assertions[number], self._cells
        match assertion.word:
            case "PRINT":
                self.output.append(str(cells[first]))
            case "FAULT":
                self._world.fault(str(cells[first]), str(cells[second]))
            case "CLEAR_FAULTS":
                self._world.clear_faults(str(cells[first]))
        return _GOES_ON

    def _mocked(self, number: int, address: int, *others: int) -> Results:
        return (self.calls(number, address),)

    # ---- time

    def _duration_ns(self, assertion: Assertion, address: int) -> int:
        unit_ns = UNITS_NS.get(assertion.type, 1) if isinstance(assertion.type, Elementary) else 1
        duration_ns = int(self._cells[address]) * unit_ns
        if duration_ns < 0:
            raise ValueError(f"{assertion.word} goes back in time: expected a time from 0 on")
        return duration_ns

    def _wait(self, number: int, duration: int, *others: int) -> Pending:
        assertion = self._assertions[number]
        if self.on_look is not None:
            self.on_look(assertion)
        until_ns = self._world.now_ns + self._duration_ns(assertion, duration)
        self.wish = Wish(Pending(), until_ns, is_running=assertion.word == "RUN_FOR")
        return self.wish.answer

    def _begin(self, number: int, duration: int, *others: int) -> Results:
        self._deadlines[number] = self._world.now_ns + self._duration_ns(self._assertions[number], duration)
        self.asserts += 1
        return _GOES_ON

    def _again(self, number: int, condition: int, end: int, unused: int, message: int) -> Results | Pending:
        assertion, deadline_ns = self._assertions[number], self._deadlines[number]
        if self.on_look is not None:
            self.on_look(assertion)
        is_true, is_over = bool(self._cells[condition]), self._world.now_ns >= deadline_ns
        match assertion.word:
            case "ASSERT_WITHIN" if is_true:
                is_over = True
            case "ASSERT_WITHIN" if is_over:
                self._fail(assertion, "TRUE in time", "FALSE all the time", message)
            case "ASSERT_NEVER" if is_true:
                self._fail(assertion, "FALSE all the time", "TRUE", message)
            case "ASSERT_STAYS" if not is_true:
                self._fail(assertion, "TRUE all the time", "FALSE", message)
            case "ASSERT_UNTIL" if self._cells[end]:
                is_over = True
            case "ASSERT_UNTIL" if not is_true:
                self._fail(assertion, "TRUE until its end", "FALSE", message)
            case "ASSERT_UNTIL" if is_over:
                self._fail(assertion, "an end in time", "none", message)
        reads = assertion.reads if self.on_look is None else None  # what is drawn is looked at each time
        self.wish = Wish(Pending(), deadline_ns, is_watching=True, is_settled=is_over, reads=reads)
        return self.wish.answer
