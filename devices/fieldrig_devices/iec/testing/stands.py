"""Rigs that are booted once for all changes of a program: where a change has no effect yet, the program is exchanged.

A stand has a rig at a few instants of its boot, each in a process of its own (`virtual.branch`).  A change whose
statement has not run before one of them is made there, and the boot goes on with it.  So the part of the boot before it
is left out, and tests that never run the statement are left out too.
"""

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from fieldrig.coverage import collecting
from fieldrig.coverage.places import Kind, Marked
from fieldrig.errors import RigError
from fieldrig_devices.iec.controller.exchange import Plc, are_quiet, exchange, plcs_of
from fieldrig_devices.iec.mutation import switch
from fieldrig_devices.iec.mutation.changes import Change
from fieldrig_devices.iec.testing.case import Case, Limits, Outcome
from fieldrig_devices.iec.tree import Position
from fieldrig_devices.languages.mistakes import CompileError

if TYPE_CHECKING:
    from fieldrig.virtual.branch import Branch
    from fieldrig.virtual.rig import Rig

MOST_POINTS: Final = 12
"""Instants of a boot at which a rig is kept; each is a process."""

Statement = tuple[str, Position]
"""The file and the position of a statement."""
RunsTest = Callable[["Rig", Case, Limits], Outcome]
Makes = Callable[[], "Rig"]
"""Makes the rig, which has not run yet."""


class Begin(NamedTuple):
    """A boot in time: when its statements run for the first time, and what each test runs of them."""

    statements: frozenset[Statement]
    first_ns: Mapping[Statement, int]
    quiet_ns: Mapping[int, int]
    """The last instant before each of these before it at which no task was within a cycle."""
    end_ns: int
    """The last such instant of the boot."""
    reached: Mapping[str, frozenset[Statement]]
    """The statements that each test runs, by its name."""


class Tried(NamedTuple):
    """The tests of one change up to the first one that failed."""

    outcomes: Sequence[Outcome | RigError]
    is_refused: bool = False
    """True if the changed program did not compile."""


class Stand:
    """A rig for the tests of one file."""

    def __init__(self, cases: Sequence[Case], limits: Limits, after_ns: int, run: RunsTest, make: Makes) -> None:
        """RigError if the rig cannot be branched."""
        self._after_ns, self._number = after_ns, len(_runs)
        _runs.append(run)
        self._begin = _begin_of(cases, limits, after_ns, run, make)
        self._points: dict[int, Branch] = {}
        self._stack = ExitStack()
        wanted = sorted({self._begin.end_ns, *self._begin.quiet_ns.values()})
        from fieldrig.virtual.branches import outliving

        with make() as rig:
            for at_ns in [*wanted[: MOST_POINTS - 1], *wanted[-1:]]:
                if _come_to(rig, at_ns, after_ns) and rig.now_ns not in self._points:
                    self._points[rig.now_ns] = self._stack.enter_context(outliving(rig))

    def close(self) -> None:
        self._stack.close()

    def tried(self, change: Change, cases: Sequence[Case], limits: Limits) -> Tried | None:
        """Return the outcomes of these tests with a change; None if it acts from the begin of the boot on."""
        statement = Path(change.file).name, change.statement
        if statement not in self._begin.statements:  # such as a declaration, or a transition of a chart
            return None
        first_ns = self._begin.first_ns.get(statement, self._after_ns + 1)
        at_ns = max((one for one in self._points if one < first_ns), default=None)
        if at_ns is None:
            return None
        if first_ns > self._after_ns:
            cases = [case for case in cases if statement in self._begin.reached.get(case.name, (statement,))]
        if not cases:
            return Tried(())
        with self._points[at_ns].branch() as branch:
            return branch.call(_try, self._number, self._after_ns, change, cases, limits)


_runs: list[RunsTest] = []
"""How the tests of each stand of this process run; a branch has the same list."""


class Stands:
    """The stands of this process, by their test files and rigs."""

    def __init__(self) -> None:
        self._known: dict[Hashable, Stand | None] = {}

    def of(self, key: Hashable, make: Callable[[], Stand]) -> Stand | None:
        """Return a stand; None for a rig that cannot be branched."""
        if key not in self._known:
            try:
                self._known[key] = make()
            except RigError:  # the tests say what is wrong with it
                self._known[key] = None
        return self._known[key]

    def close(self) -> None:
        for stand in self._known.values():
            if stand is not None:
                stand.close()


_kept: list[Stands] = []


@contextmanager
def kept() -> Iterator[None]:
    """Keep booted rigs meanwhile, for the tests of programs that are changed."""
    _kept.append(Stands())
    try:
        yield
    finally:
        _kept.pop().close()


def present() -> Stands | None:
    """Return the stands that are kept now, where rigs can be branched."""
    from fieldrig.virtual.may_branch import HAS_FORK

    return _kept[-1] if _kept and HAS_FORK else None


def plcs_in(rig: "Rig") -> list[Plc]:
    """Return the controllers with programs in a rig."""
    from fieldrig.virtual.rig import devices_of

    return list(plcs_of(devices_of(rig)))


# ---- the boot, in a rig whose programs have marks


def _begin_of(cases: Sequence[Case], limits: Limits, after_ns: int, run: RunsTest, make: Makes) -> Begin:
    from fieldrig.virtual.branches import one_by_one, warm

    first_ns: dict[Statement, int] = {}
    quiet_ns: dict[int, int] = {}
    before_ns, last_ns, reached = -1, -1, dict[str, frozenset[Statement]]()
    with collecting.collecting(is_written=False), make() as rig:
        plcs = plcs_in(rig)
        seen = 0
        while (next_ns := rig.next_ns()) is not None and next_ns <= after_ns:
            rig.step()
            if last_ns != rig.now_ns:
                before_ns = last_ns
            programs = collecting.programs()
            hits = sum(sum(one.hits) for one in programs)
            if hits != seen:
                seen = hits
                first_ns |= {one: rig.now_ns for one in _hit(programs) if one not in first_ns}
                quiet_ns[rig.now_ns] = before_ns
            # an instant may have several steps: the end of a cycle, and the begin of one that has waited for it
            last_ns = rig.now_ns if are_quiet(plcs) else before_ns
        rig.run_until(after_ns)
        warm(rig)
        ran = one_by_one(rig, [partial(_reach, case=case, limits=limits, run=run) for case in cases])
        for case, found in zip(cases, ran, strict=True):
            if not isinstance(found, RigError):
                reached[case.name] = found
        statements = frozenset(one for one, _ in _statements(collecting.programs()))
    return Begin(statements, first_ns, {at: last for at, last in quiet_ns.items() if last >= 0}, last_ns, reached)


def _come_to(rig: "Rig", at_ns: int, end_ns: int) -> bool:
    """Let a rig come to an instant, and to the end of the cycle that it is in; false if that is behind the end.

    With marks a cycle is cut into other slices, and each slice is rounded, so without them it may end some ns later.
    """
    plcs = plcs_in(rig)
    if at_ns > rig.now_ns:
        rig.run_until(at_ns)
    while not are_quiet(plcs):
        next_ns = rig.next_ns()
        if next_ns is None or next_ns > end_ns:
            return False
        rig.step()
    return True


def _statements(programs: Sequence[Marked]) -> Iterator[tuple[Statement, bool]]:
    """Yield the statements of programs, and whether they have run."""
    for one in programs:
        for mark, place in one.places:
            if place.kind is Kind.STATEMENT:
                yield (Path(place.file).name, Position(place.line, place.column)), bool(one.hits[mark])


def _hit(programs: Sequence[Marked]) -> Iterator[Statement]:
    yield from (statement for statement, has_run in _statements(programs) if has_run)


def _reach(rig: "Rig", case: Case, limits: Limits, run: RunsTest) -> frozenset[Statement]:
    """Run a test in a branch, and return the statements that it runs."""
    for one in collecting.programs():
        one.hits[:] = [0] * len(one.hits)
    run(rig, case, limits)
    return frozenset(_hit(collecting.programs()))


# ---- in a branch


def _try(rig: "Rig", number: int, after_ns: int, change: Change, cases: Sequence[Case], limits: Limits) -> Tried:
    """Exchange the program, end the boot, and run the tests until one fails."""
    from fieldrig.virtual.branches import one_by_one, warm

    outcomes: list[Outcome | RigError] = []
    with switch.applied(change):
        try:
            exchange(plcs_in(rig), change.file)
        except CompileError:
            return Tried((), is_refused=True)
        try:
            rig.run_until(after_ns)
            warm(rig)
        except RigError as wrong:
            return Tried((wrong,))
        for outcome in one_by_one(rig, [partial(_once, case=case, limits=limits, run=_runs[number]) for case in cases]):
            outcomes.append(outcome)
            if isinstance(outcome, RigError) or outcome.failures:
                break
    return Tried(outcomes)


def _once(rig: "Rig", case: Case, limits: Limits, run: RunsTest) -> Outcome:
    return run(rig, case, limits)
