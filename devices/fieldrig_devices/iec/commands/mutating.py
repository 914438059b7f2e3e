"""The command `fieldrig iec mutate`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import AsJson, echo_json
from fieldrig.errors import UsageError
from fieldrig.points.values import counted
from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands.choosing import Keywords, Paths, Timeout, Workers, chosen_work
from fieldrig_devices.iec.commands.sources import DialectOption, dialect_named

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.iec.mutation.changes import Change
    from fieldrig_devices.iec.testing.case import Outcome
    from fieldrig_devices.iec.testing.trial import Result


def mutate(
    paths: Paths,
    patterns: Keywords = None,
    dialect: DialectOption = "epas-4",
    timeout: Timeout = 30.0,
    workers: Workers = 1,
    most: Annotated[
        int | None,
        typer.Option("--most", metavar="N", min=1, help="Try at most N changes, evenly over the program."),
    ] = None,
    accepted: Annotated[
        Path | None,
        typer.Option(
            "--accepted",
            metavar="FILE",
            help="Leave out the changes in this file: lines of the report, each with a reason behind #.",
            show_default=False,
        ),
    ] = None,
    only: Annotated[
        Path | None,
        typer.Option(
            "--only", metavar="FILE", help="Try only the changes in this file: lines of a report.", show_default=False
        ),
    ] = None,
    least: Annotated[
        float | None,
        typer.Option(
            "--fail-under",
            metavar="PERCENT",
            min=0.0,
            max=100.0,
            help="Exit with 1 if tests notice less.",
            show_default=False,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Change a program in small ways, and list the changes that none of its tests notices.

    \b
        fieldrig iec mutate pid_test.st
        fieldrig iec mutate project/ -j 2 --most 100 --fail-under 90
        fieldrig iec mutate pid_test.st test_pid.py --accepted pid.txt

    A change is another comparison, constant or operator, a contact that opens instead of closing, a missing reset or
    statement, a transition that fires at once or never. The tests have to pass without any.
    """
    from fieldrig.system.stopwatch import Stopwatch
    from fieldrig_devices.iec.mutation import accepted as files
    from fieldrig_devices.iec.testing import trial
    from fieldrig_devices.iec.testing.case import Limits
    from fieldrig_devices.iec.testing.reports import changes as report

    watch, limits = Stopwatch(), Limits(timeout)
    work = chosen_work(paths, patterns or [], dialect_named(dialect))
    before, reached = trial.baseline(work, limits)
    if before.bad:
        _tell_failures(before.bad)
    if not before.changes:
        raise UsageError(
            "the tests run no program that can be changed",
            "expected one of IEC 61131-3; applications of a PAM and programs of ARP cards are not changed",
        )
    known = files.accepted(accepted, before.changes) if accepted is not None else {}
    changes: Sequence[Change] = before.changes
    if only is not None:
        again = files.chosen(only, changes)
        changes = [change for change in changes if change in again]
    changes = _evenly(changes, most)
    results = list["Result"]()
    if not as_json:
        typer.echo(f"{counted(len(changes), 'change')} of {len(before.changes)}; those that no test notices:")
    for result in trial.results(changes, known, before, reached, work, limits, workers):
        results.append(result)
        if not as_json and result.fate in (trial.Fate.MISSED, trial.Fate.NOT_RUN):
            typer.echo(report.line_of(result))
    if as_json:
        echo_json(report.as_json(results))
    else:
        for line in report.summary(results, watch.seconds):
            typer.echo(line)
    if least is not None and report.score(results) < least:
        typer.echo(f"the tests notice {report.score(results):.1f} %: expected at least {least:g} %", err=True)
        raise typer.Exit(Exit.TESTS_FAILED)


def _tell_failures(bad: "Sequence[Outcome]") -> None:
    """Show the tests that fail without any change.  Ends the command."""
    from fieldrig_devices.iec.testing.reports import people

    for line in people.details(bad):
        typer.echo(line, err=True)
    typer.echo("the tests have to pass before the program is changed", err=True)
    raise typer.Exit(Exit.TESTS_FAILED)


def _evenly(changes: "Sequence[Change]", most: int | None) -> "Sequence[Change]":
    """Return at most this number of changes, at even distances."""
    if most is None or len(changes) <= most:
        return changes
    return [changes[number * len(changes) // most] for number in range(most)]
