"""The command `fieldrig iec test`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli import covering
from fieldrig.cli.common import AsJson, JsonRows, echo_json, writing
from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands.choosing import Keywords, Paths, Timeout, Workers, chosen_work
from fieldrig_devices.iec.commands.sources import DialectOption, dialect_named

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.iec.dialect import Dialect
    from fieldrig_devices.iec.testing.case import Limits, Outcome
    from fieldrig_devices.iec.testing.parallel import Work


def run_tests(
    paths: Paths,
    patterns: Keywords = None,
    dialect: DialectOption = "epas-4",
    timeout: Timeout = 30.0,
    workers: Workers = 1,
    junit: Annotated[
        Path | None,
        typer.Option("--junit", metavar="FILE", help="Write a report for CI in JUnit's form.", show_default=False),
    ] = None,
    is_covered: covering.Shown = False,
    is_detailed: covering.Detail = False,
    data: covering.Data = None,
    lcov: covering.Lcov = None,
    cobertura: covering.Cobertura = None,
    folder: covering.Page = None,
    least: covering.Least = None,
    is_list: Annotated[bool, typer.Option("--list", help="List the tests, and run none.")] = False,
    is_watching: Annotated[
        bool, typer.Option("--watch", help="Run the tests that a change touches, until Ctrl-C.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Run the tests of programs, on this machine, without a controller.

    \b
        fieldrig iec test project/
        fieldrig iec test pid_test.st -k "holds*" --timeout 2
        fieldrig iec test project/ -j 2 --junit report.xml
        fieldrig iec test project/ --coverage --fail-under 90

    A test is a block TEST 'name' ... END_TEST in a source file. The exit code is 0 if all tests pass, 1 if some do not
    or coverage is too low, and 2 if a file has mistakes or there are no tests.
    """
    from fieldrig_devices.iec.testing.case import Limits

    rules = dialect_named(dialect)
    run = _Run(paths, patterns or [], rules, Limits(timeout), workers, as_json=as_json)
    if is_list:
        run.show()
        return
    with covering.Covering(is_covered, is_detailed, data, lcov, cobertura, folder, least) as covered:
        outcomes = run.all()
        is_enough = covered.report(is_quiet=as_json)
    if junit is not None:
        run.write(junit, outcomes)
    if is_watching:
        run.watch(junit)
    code = run.code(outcomes)
    if code is Exit.OK and not is_enough:
        code = Exit.TESTS_FAILED
    if code is not Exit.OK:
        raise typer.Exit(code)


class _Run:
    """The tests that were asked for, and how they are shown."""

    def __init__(
        self,
        paths: "Sequence[str]",
        patterns: "Sequence[str]",
        dialect: "Dialect",
        limits: "Limits",
        workers: int,
        *,
        as_json: bool,
    ) -> None:
        self._paths, self._patterns = paths, patterns
        self._dialect, self._limits, self._workers, self._as_json = dialect, limits, workers, as_json

    def _work(self) -> "list[Work]":
        return chosen_work(self._paths, self._patterns, self._dialect)

    def show(self) -> None:
        """List the tests."""
        from fieldrig_devices.iec.testing.reports.as_json import case_json

        cases = [case for _, chosen in self._work() for case in chosen]
        if self._as_json:
            echo_json([case_json(case) for case in cases])
            return
        for case in cases:
            typer.echo(f"{case.file}:{case.line}: {case.name}")

    def all(self) -> "list[Outcome]":
        return self._run(self._work())

    def _run(self, work: "Sequence[Work]") -> "list[Outcome]":
        """Run tests, and show them."""
        from fieldrig.system.stopwatch import Stopwatch
        from fieldrig_devices.iec.testing.parallel import run as run_work
        from fieldrig_devices.iec.testing.reports import people
        from fieldrig_devices.iec.testing.reports.as_json import outcome_json

        watch, outcomes, suite = Stopwatch(), list["Outcome"](), ""
        rows = JsonRows() if self._as_json else None
        for outcome in run_work(work, self._limits, self._workers):
            outcomes.append(outcome)
            if rows is not None:
                rows.add(outcome_json(outcome))
                continue
            if outcome.case.suite != suite:
                suite = outcome.case.suite
                typer.echo(suite)
            typer.echo(people.line_of(outcome))
        if rows is not None:
            rows.end()
            return outcomes
        for line in people.details(outcomes):
            typer.echo(line)
        typer.echo(f"\n{people.summary(outcomes, watch.seconds)}")
        return outcomes

    def write(self, file: Path, outcomes: "Sequence[Outcome]") -> None:
        from fieldrig.system.whole_file import replace_file
        from fieldrig_devices.iec.testing.reports.junit import junit

        with writing(file):
            replace_file(file, junit(outcomes))

    def watch(self, junit: Path | None) -> None:
        """Run what a change touches, until Ctrl-C."""
        from fieldrig_devices.iec.testing.watching import changes

        typer.echo("waiting for changes; Ctrl-C ends it")
        try:
            for work in changes(self._work):
                outcomes = self._run(work)
                if junit is not None:
                    self.write(junit, outcomes)
        except KeyboardInterrupt:
            typer.echo()

    @staticmethod
    def code(outcomes: "Sequence[Outcome]") -> Exit:
        from fieldrig_devices.iec.testing.case import MISTAKE, Verdict

        if any(failure.kind == MISTAKE for outcome in outcomes for failure in outcome.failures):
            return Exit.WRONG
        is_bad = any(outcome.verdict in (Verdict.FAILED, Verdict.ERROR) for outcome in outcomes)
        return Exit.TESTS_FAILED if is_bad else Exit.OK
