"""A TEST block with a rig around it: variables at points and wires, faults, and time that passes in the rig.

Each test has a branch of a rig that was booted once, where branches are possible, and otherwise a rig of its own.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from fieldrig.clock import MS
from fieldrig.errors import ControlError, RigError, UsageError
from fieldrig.faults.words import fault_of_words
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.texts import a
from fieldrig_devices.iec.elementary import UNITS_NS, Elementary
from fieldrig_devices.iec.layout import storage
from fieldrig_devices.iec.memory import limited
from fieldrig_devices.iec.mutation import switch
from fieldrig_devices.iec.mutation.changes import Change
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.testing import stands
from fieldrig_devices.iec.testing.beginning import begin_program
from fieldrig_devices.iec.testing.case import MISTAKE, TIMEOUT, Case, Failure, Limits, Outcome, Verdict
from fieldrig_devices.iec.testing.compiled import Tested
from fieldrig_devices.iec.testing.extension import CaseBlock
from fieldrig_devices.iec.testing.runner import Runner
from fieldrig_devices.iec.types import StringType, Value
from fieldrig_devices.scenarios.places import place_of

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

LOOK_NS: Final = 1 * MS
"""The longest time between two looks at an expectation: values such as a level change without an event."""
PRESSED_NS: Final = 10 * MS
"""Virtual time between two looks at the clock of the host."""

RigTest = tuple[Case, CaseBlock]


class Rigs:
    """The booted rigs of the tests of one file."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._stack = folder, ExitStack()
        self._booted: dict[tuple[str, int], Rig] = {}

    def run(self, use: tree.RigUse, tests: Sequence[RigTest], tested: Tested, limits: Limits) -> Iterator[Outcome]:
        """Run tests that have the same rig, and yield their outcomes in order."""
        tried = self._tried(use, tests, tested, limits)
        if tried is not None:
            switch.note((), is_refused=tried.is_refused)
            for test, outcome in zip(tests, tried.outcomes, strict=False):
                yield _not_run(test, use, outcome) if isinstance(outcome, RigError) else outcome
            return
        try:
            program = Prepared(tested)  # before the branches, which then share its memory
            calls = [partial(_run, case=case, block=block, program=program, limits=limits) for case, block in tests]
            for test, call, outcome in zip(tests, calls, self._outcomes(use, calls), strict=True):
                if isinstance(outcome, RigError):
                    yield _not_run(test, use, outcome)
                else:
                    yield self._with_diagram(use, call, outcome) if limits.has_diagrams else outcome
        except RigError as wrong:
            for test in tests:
                yield _not_run(test, use, wrong)

    def _outcomes(self, use: tree.RigUse, calls: "Sequence[Callable[[Rig], Outcome]]") -> Iterator[Outcome | RigError]:
        from fieldrig.virtual.branches import one_by_one
        from fieldrig.virtual.may_branch import HAS_FORK

        return one_by_one(self._of(use), calls) if HAS_FORK else (self._alone(use, call) for call in calls)

    def _with_diagram(self, use: tree.RigUse, call: "partial[Outcome]", outcome: Outcome) -> Outcome:
        """Return the outcome of a test that failed with its signals: it does the same again with a record of them."""
        if not outcome.failures or outcome.failures[0].kind == TIMEOUT:
            return outcome
        again = next(self._outcomes(use, [partial(call, is_recorded=True)]))
        if not isinstance(again, Outcome) or again.verdict is not outcome.verdict:
            return outcome
        return again._replace(wall_s=outcome.wall_s, busy_s=outcome.busy_s)

    def _tried(self, use: tree.RigUse, tests: Sequence[RigTest], tested: Tested, limits: Limits) -> stands.Tried | None:
        """Run the tests of a changed program from where the change begins to act; None if that cannot be."""
        change, present = switch.present(), stands.present()
        if change is None or present is None or is_in(change, tested):
            return None
        blocks = {block.test.name: block for block in tested.blocks}
        cases = [case for case, _ in tests]

        def make() -> stands.Stand:
            with switch.applied(None):
                program = Prepared(tested)

                def run(rig: "Rig", case: Case, limits: Limits) -> Outcome:
                    return _run(rig, case, blocks[case.name], program, limits)

                return stands.Stand(cases, limits, after_ns(use), run, partial(self._rig, use))

        stand = present.of((self._folder, tested.blocks[0].file, use.file, after_ns(use)), make)
        return None if stand is None else stand.tried(change, cases, limits)

    def _alone(self, use: tree.RigUse, call: "Callable[[Rig], Outcome]") -> Outcome | RigError:
        """Run a test in a rig of its own, where a rig cannot be branched."""
        try:
            with self._made(use) as rig:
                return call(rig)
        except RigError as wrong:
            return wrong

    def close(self) -> None:
        self._stack.close()

    def _of(self, use: tree.RigUse) -> "Rig":
        key = use.file, after_ns(use)
        if key not in self._booted:
            from fieldrig.virtual.branches import warm

            self._booted[key] = self._stack.enter_context(self._made(use))
            warm(self._booted[key])
        return self._booted[key]

    def _made(self, use: tree.RigUse) -> "Rig":
        rig = self._rig(use)
        try:
            rig.run_until(after_ns(use))
        except BaseException:
            rig.close()
            raise
        return rig

    def _rig(self, use: tree.RigUse) -> "Rig":
        from fieldrig.config.rig_file import load
        from fieldrig.virtual.rig import Rig

        return Rig(load(rig_file(self._folder, use), ("time=virtual",)))


def rig_file(folder: Path, use: tree.RigUse) -> Path:
    """Return the rig file of a test.  UsageError if there is none."""
    file = folder / use.file
    if not file.is_file():
        raise UsageError(f"there is no {use.file}", f"expected a rig file in {folder}")
    return file


def after_ns(use: tree.RigUse) -> int:
    """Return the time for which a rig runs before its tests.  UsageError for what is no constant time."""
    match use.delay:
        case None:
            return 0
        case tree.Literal(kind=tree.LiteralKind.TIME, value=int(value)):
            return value * UNITS_NS[Elementary.TIME]
        case tree.Literal(kind=tree.LiteralKind.LTIME, value=int(value)):
            return value
    raise UsageError(f"the time behind AFTER in line {use.position.line} is no time", "expected one such as T#10s")


def is_in(change: Change, tested: Tested) -> bool:
    """Return whether a change is in the tests themselves, or in a file that is compiled with them."""
    return any(Path(file.name).name == Path(change.file).name for file in tested.compiled.files)


def _not_run(test: RigTest, use: tree.RigUse, wrong: RigError) -> Outcome:
    case, block = test
    failure = Failure(MISTAKE, "", wrong.what, wrong.remedy, Path(block.file), use.position.line, 0)
    return Outcome(case, Verdict.ERROR, (failure,))


class Prepared:
    """The program of the tests, loaded and started once."""

    def __init__(self, tested: Tested) -> None:
        """RigError if its variables cannot be started."""
        self.tested = tested
        self.runtime = Runtime(tested.compiled, tested.host)
        begin_program(self.runtime)
        self.fresh = self.runtime.fresh()


def _run(
    rig: "Rig", case: Case, block: CaseBlock, program: Prepared, limits: Limits, *, is_recorded: bool = False
) -> Outcome:
    return Runner(program.tested, InRig(rig, block, program)).run(case, block, limits, is_recorded=is_recorded)


class Linked:
    """A variable of the test at a point or a wire of the rig."""

    def __init__(self, rig: "Rig", name: str, symbol: Symbol, place: str) -> None:
        """RigError for a place that the rig does not have, and for a type that its value does not fit."""
        self.symbol, self._shown, self._stored = symbol, name, storage(symbol.type)
        self.name = name.casefold()
        if self._stored is None:
            raise UsageError(f"{name} is {a(symbol.type)}", "expected a variable with one value at a place")
        self._place = place_of(rig, place)
        self.seen: Value = self.of_rig(self._place.read())

    def of_rig(self, value: Value) -> Value:
        """Return a value of the rig as one of the variable."""
        stored = self._stored
        assert stored is not None
        if isinstance(value, str) is not isinstance(stored, StringType):
            shown = "a text" if isinstance(value, str) else repr(value)
            expected = "STRING" if isinstance(value, str) else "BOOL, a number or another type with such a value"
            raise UsageError(f"{self._place.name} has {shown}, and {self._shown} is a {stored}", expected)
        return limited(value, stored)

    def read(self) -> Value:
        """Return the present value; the last one while the device has no power, or not this program."""
        try:
            return self.of_rig(self._place.read())
        except ControlError:
            return self.seen

    def write(self, value: Value) -> None:
        self._place.write(value)

    def listen(self, call: Callable[[Value], None]) -> Callable[[], None]:
        return self._place.listen(call)


class InRig:
    """The world of a test with a rig (`runner.Place`)."""

    def __init__(self, rig: "Rig", block: CaseBlock, program: Prepared) -> None:
        """RigError for a variable at a place that the rig does not have."""
        tested = program.tested
        self._rig, self._tested, self._program = rig, tested, program
        self.runtime = program.runtime
        self.is_pressed: Callable[[], None] = lambda: None
        tested.judge.use(tested.assertions, self.runtime.memory)
        root = tested.compiled.program.globals[block.instance.lower()]
        self._linked: list[Linked] = []
        for name, place in block.places.items():
            symbol = self.runtime.symbols.within(root, f".{name}")
            assert symbol is not None, "the test declares it"
            self._linked.append(Linked(rig, name, symbol, place))

    @property
    def now_ns(self) -> int:
        return self._rig.now_ns

    def begin(self, block: CaseBlock) -> None:
        if not self._rig.is_branch:  # a branch is fresh by itself
            self._program.fresh()
        self._take(self._linked)

    def fault(self, where: str, fault: str) -> None:
        try:
            self._give()
            self._rig.add_fault(where, fault_of_words(fault.split()))
        except RigError as wrong:
            raise _refused(wrong) from wrong

    def clear_faults(self, where: str) -> None:
        try:
            self._give()
            for number in list(self._rig.faults(where)):
                self._rig.clear_fault(where, number)
        except RigError as wrong:
            raise _refused(wrong) from wrong

    # ---- time

    def run_until(self, until_ns: int) -> None:
        self._give()
        while self.now_ns < until_ns:
            self._rig.run_until(min(until_ns, self.now_ns + PRESSED_NS))
            self.is_pressed()
        self._take(self._linked)

    def run_tasks(
        self, until_ns: int, look: Callable[[], bool] | None = None, reads: frozenset[str] | None = None
    ) -> None:
        """Let the rig run; call `look` after each instant at which what it reads has changed, and at the end.

        Without `reads` it is called after each instant at which something happens, and at least once in a ms.
        """
        if look is None:
            self.run_until(until_ns)
            return
        self._give()
        watched = self._linked if reads is None else [one for one in self._linked if one.name in reads]
        passed: list[tuple[Linked, Value]] = []
        with ExitStack() as ends:
            for one in watched:
                with suppress(ControlError):  # its device has no power now
                    ends.callback(one.listen(partial(_note, passed, one)))
            while True:
                next_ns, last_ns = self._rig.next_ns(), min(until_ns, self.now_ns + LOOK_NS)
                if next_ns is not None and next_ns <= last_ns:
                    self._rig.step()
                else:
                    self._rig.run_until(last_ns)
                self.is_pressed()
                is_over = self.now_ns >= until_ns
                if not self._looks(passed, look, watched, is_needed=is_over or reads is None) or is_over:
                    break
        self._take(self._linked)

    def _looks(
        self,
        passed: list[tuple[Linked, Value]],
        look: Callable[[], bool],
        watched: Sequence[Linked],
        *,
        is_needed: bool,
    ) -> bool:
        """Look at each change of this instant, in order, so that the shortest pulse is seen; then at what there is.

        False if the test has seen enough.  Where nothing has changed it looks only if that is needed.
        """
        changes = passed[:]
        passed.clear()
        for place, (one, value) in enumerate(changes):
            if any(later is one for later, _ in changes[place + 1 :]):
                self._put(one, one.of_rig(value))
                is_needed = True
                if not look():
                    return False
        return not (self._take(watched) or is_needed) or look()

    # ---- variables

    def _take(self, watched: Sequence[Linked]) -> bool:
        """Take the values of the rig, and return whether one is new."""
        self._tested.clock.instant_ns = self.now_ns
        is_new = False
        for one in watched:
            before = one.seen
            self._put(one, one.read())
            is_new = is_new or before != one.seen
        return is_new

    def _put(self, one: Linked, value: Value) -> None:
        one.seen = value
        self.runtime.memory[one.symbol.steps[0]] = value

    def _give(self) -> None:
        """Write the variables that the test has changed."""
        for one in self._linked:
            value = self.runtime.memory[one.symbol.steps[0]]
            if value != one.seen:
                one.write(value)
                one.seen = value


def _note(passed: list[tuple[Linked, Value]], one: Linked, value: Value) -> None:
    passed.append((one, value))


def _refused(wrong: RigError) -> ValueError:
    """Return what a rig refuses as a fault of the test."""
    return ValueError(f"{wrong.what}; {wrong.remedy}" if wrong.remedy else wrong.what)
