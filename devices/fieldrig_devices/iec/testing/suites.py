"""The suites of a project as tests for `fieldrig iec test`.

All suites of a project run together, as TcUnit does it, so a run of some tests runs the others too.  The names of the
tests are those that a suite gives to TEST and TEST_ORDERED as texts; tests with other names are found when they run.
"""

from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from fieldrig.errors import UsageError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig.text.source_text import decoded
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.plcproj import SOURCES, SUFFIX
from fieldrig_devices.iec.tcunit.bench import Bench
from fieldrig_devices.iec.tcunit.natives import LEFT_OUT
from fieldrig_devices.iec.tcunit.program import LeftOut, NothingToRunError, origins
from fieldrig_devices.iec.tcunit.project import opened, projects_in
from fieldrig_devices.iec.tcunit.reach import Item
from fieldrig_devices.iec.tcunit.session import Failed, Suite, Test
from fieldrig_devices.iec.testing.case import MISTAKE, Case, Failure, Limits, Outcome, Verdict
from fieldrig_devices.iec.testing.operands import Operands
from fieldrig_devices.languages.mistakes import CompileError, Mistake

COMPILES: Final = "the suite compiles"
"""The case of a suite that does not."""
PART_COMPILES: Final = "compiles"
"""The case of a body or a type that does not, and that the suites may do without."""
NO_TEXT: Final = "''"
"""An empty text, as the report shows it."""
_MARK: Final = "fb_testsuite"
_NAMING: Final = frozenset({"test", "test_ordered"})


def sources_in(path: Path) -> list["SuiteSource"]:
    """Return a source for each project at a path that has suites.  UsageError if a project cannot be read."""
    return [SuiteSource(project) for project in projects_in(path) if _has_suites(project)]


def _has_suites(project: Path) -> bool:
    if project.suffix.casefold() == SUFFIX:
        return any(_MARK in file.text.casefold() for file in opened(project).files)
    files = [project] if project.is_file() else [file for file in sorted(project.rglob("*")) if file.is_file()]
    return any(_names_suite(file) for file in files if file.suffix.casefold() in SOURCES)


def _names_suite(file: Path) -> bool:
    try:
        return _MARK in decoded(file.read_bytes()).casefold()
    except (OSError, ValueError):
        return False


class SuiteSource:
    """Implements `case.Source` for a project."""

    def __init__(self, project: Path) -> None:
        self._project = project
        self._bench: Bench | None = None
        """A program that has not run yet."""

    def __getstate__(self) -> dict[str, Any]:
        return {"_project": self._project, "_bench": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._project, self._bench = state["_project"], None

    @property
    def path(self) -> Path:
        return self._project

    def files(self) -> Collection[Path]:
        """Return the files on which the tests depend: a change of one of them may change an outcome."""
        given = opened(self._project)
        own = {self._project} if self._project.is_file() else set()
        return own | {Path(file.name) for file in (*given.files, *given.library_files)}

    def cases(self) -> Sequence[Case]:
        try:
            bench = self._bench = self._loaded()
        except (CompileError, NothingToRunError):
            return [Case(COMPILES, str(self._project), self._project, 1)]
        return [*_cases(bench), *(_left_out_case(one) for one in bench.program.left_out if _is_shown(one))]

    def run(self, chosen: Sequence[Case], limits: Limits) -> Iterator[Outcome]:
        try:
            bench, self._bench = self._bench or self._loaded(), None
        except CompileError as wrong:
            case = Case(COMPILES, str(self._project), self._project, 1)
            yield _not_compiled(case, [one for one in wrong.mistakes if not one.is_note])
            return
        except NothingToRunError as wrong:
            raise UsageError(f"{self._project} has no suites", str(wrong)) from wrong
        watch = Stopwatch()
        listed = {(case.suite, case.name): case for case in _cases(bench)}
        bench.run(limits.longest_ns, limits.timeout_s)
        busy_s = watch.busy_seconds / max(1, len(listed))
        yield from (one._replace(busy_s=busy_s) for one in _outcomes(bench, listed, chosen, watch.seconds))
        for one in bench.program.left_out:
            case = _left_out_case(one)
            if one.is_suite and case in chosen:
                yield _not_compiled(case, origins(one, bench.program.left_out))
            elif one.is_part and case in chosen:
                yield Outcome(case, Verdict.SKIPPED, reason=f"{one.reason.what}, and no suite has needed it")

    def _loaded(self) -> Bench:
        bench = Bench(opened(self._project))
        bench.operands = Operands(bench.runtime, bench.program.items).text
        return bench


# ---- the tests of a program, from its text


def _cases(bench: Bench) -> list[Case]:
    items = {item.name: item for item in bench.program.items if isinstance(item.declaration, tree.Pou)}
    return [case for path, block in bench.instances.values() for case in _of_suite(path, block, items)]


def _of_suite(path: str, block: str, items: dict[str, Item]) -> Iterator[Case]:
    """Yield the tests that the text of a suite names, and those of the suites that it extends."""
    seen: set[str] = set()
    item = items.get(block.casefold())
    names: set[str] = set()
    while item is not None and item.name not in seen:
        seen.add(item.name)
        for name, line in sorted(set(_named(item.declaration)), key=lambda one: one[1]):
            if name not in names:
                names.add(name)
                yield Case(name, path, Path(item.file), line)
        above = getattr(item.declaration, "extends", "").rpartition(".")[2]
        item = items.get(above.casefold())


def _named(declaration: tree.Declaration) -> Iterator[tuple[str, int]]:
    """Yield the names that a declaration gives to TEST and TEST_ORDERED as texts or __POUNAME(), with their lines."""
    if not isinstance(declaration, tree.Pou):
        return
    yield from _named_in(declaration.body, declaration.name)
    parts: list[tree.Action | tree.Method] = [*declaration.actions, *declaration.methods]
    for part in parts:
        yield from _named_in(part.body, f"{declaration.name}.{part.name}")


def _named_in(body: tree.Body, unit: str) -> Iterator[tuple[str, int]]:
    for node in tree.walk(body):
        if isinstance(node, tree.Call) and node.arguments:
            name = getattr(node.called, "text", "") or getattr(node.called, "name", "")
            value = node.arguments[0].value
            line = node.called.position.line or node.position.line
            if name.casefold() not in _NAMING:
                continue
            if isinstance(value, tree.Literal) and isinstance(value.value, str):
                yield value.value.strip(" "), line
            elif isinstance(value, tree.Call) and getattr(value.called, "text", "").upper() == "__POUNAME":
                yield unit, line


# ---- outcomes


def _outcomes(
    bench: Bench, listed: dict[tuple[str, str], Case], chosen: Sequence[Case], wall_s: float
) -> Iterator[Outcome]:
    """Yield the outcomes of the chosen tests, and of those that only the run has named if its suite is chosen."""
    wanted, suites = set(chosen), {case.suite for case in chosen}
    seconds = wall_s / max(1, len(listed))
    output = tuple(line for line in bench.session.lines if not line.startswith("FAILED TEST"))
    beside = tuple(f"beside the suites: {fault}" for fault in dict.fromkeys(bench.faults))
    yield from (_not_begun(case, bench) for case in chosen if _has_not_begun(case, bench))
    output += beside
    for suite in bench.session.suites.values():
        if suite.started_ns is None and not bench.session.has_run:
            continue
        for name in (*suite.tests, *(name for path, name in listed if path == suite.path and name not in suite.tests)):
            case = listed.get((suite.path, name), Case(name, suite.path, bench.file_of(suite.path), 0))
            is_new = (suite.path, name) not in listed and suite.path in suites
            if case in wanted or is_new:
                yield _outcome(case, suite, suite.tests.get(name), seconds, output)
                output = ()


def _has_not_begun(case: Case, bench: Bench) -> bool:
    """True for a test of a suite that no call of RUN has reached, because of a fault in front of it."""
    if not any(path == case.suite for path, _ in bench.instances.values()):
        return False
    suite = next((one for one in bench.session.suites.values() if one.path == case.suite), None)
    return suite is None or (suite.started_ns is None and not bench.session.has_run)


def _not_begun(case: Case, bench: Bench) -> Outcome:
    why = bench.faults[0] if bench.faults else "no program has called RUN"
    failure = Failure("fault", "", f"the suite has not begun: {why}", "", case.file, case.line, 0)
    return Outcome(case, Verdict.ERROR, (failure,))


def _outcome(case: Case, suite: Suite, test: Test | None, wall_s: float, output: tuple[str, ...]) -> Outcome:
    if test is None:
        reason = f"the suite has ended with a fault: {suite.fault}" if suite.fault else "the suite has not declared it"
        return Outcome(case, Verdict.SKIPPED, reason=reason)
    failures = tuple(_failure(one, case) for one in test.failures)
    if test.is_skipped:
        return Outcome(case, Verdict.SKIPPED, reason="its name begins with disabled_", output=output)
    verdict = Verdict.FAILED if failures else Verdict.PASSED
    fault = test.fault or (suite.fault if not test.is_done else "")
    if fault:
        kind = MISTAKE if fault.startswith(LEFT_OUT) else "fault"
        failures = (*failures, Failure(kind, "", fault, "", case.file, case.line, test.duration_ns))
        verdict = Verdict.ERROR
    elif test.is_beyond:
        more = Failure(MISTAKE, "at most MaxNumberOfTestsForEachTestSuite", "one more", "", case.file, case.line, 0)
        failures, verdict = (*failures, more), Verdict.FAILED
    elif not test.is_done:
        failures = (*failures, Failure("timeout", "", "the test has not finished", "", case.file, case.line, 0))
        verdict = Verdict.ERROR
    return Outcome(case, verdict, failures, test.asserts, test.duration_ns, wall_s, output)


def _failure(failed: Failed, case: Case) -> Failure:
    file = Path(failed.file) if failed.file else case.file
    actual = f"{failed.actual or NO_TEXT}{failed.operands}"
    expected = failed.expected or NO_TEXT
    return Failure(failed.kind, expected, actual, failed.message, file, failed.source_line, failed.at_ns)


def _is_shown(one: LeftOut) -> bool:
    return one.is_suite or one.is_part


def _left_out_case(one: LeftOut) -> Case:
    return Case(PART_COMPILES if one.is_part else COMPILES, one.name, Path(one.file), one.line)


def _not_compiled(case: Case, mistakes: Sequence[Mistake]) -> Outcome:
    failures = [Failure(MISTAKE, one.expected, one.what, one.hint, Path(one.file), one.line, 0) for one in mistakes]
    return Outcome(case, Verdict.ERROR, tuple(failures))
