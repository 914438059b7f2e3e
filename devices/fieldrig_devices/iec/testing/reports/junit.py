"""The report for CI in JUnit's form."""

from collections.abc import Sequence
from itertools import groupby

from fieldrig.text import junit as form
from fieldrig_devices.iec.testing.case import Failure, Outcome, Verdict
from fieldrig_devices.iec.testing.reports.people import place, said, source_line


def junit(outcomes: Sequence[Outcome]) -> bytes:
    """Return the report of all tests."""
    ordered = sorted(outcomes, key=lambda outcome: outcome.case.suite)
    groups = groupby(ordered, key=lambda outcome: outcome.case.suite)
    return form.junit("fieldrig", {suite: [_case(outcome) for outcome in group] for suite, group in groups})


def _case(outcome: Outcome) -> form.Case:
    case = outcome.case
    is_error = outcome.verdict is not Verdict.FAILED
    return form.Case(
        case.name,
        outcome.wall_s,
        [_failed(failure, is_error=is_error) for failure in outcome.failures],
        outcome.reason if outcome.verdict is Verdict.SKIPPED else None,
        str(case.file),
        case.line,
        outcome.asserts,
        "\n".join(outcome.output),
    )


def _failed(failure: Failure, *, is_error: bool) -> form.Failed:
    lines = [place(failure), source_line(failure.file, failure.line), said(failure), *failure.diagram]
    return form.Failed(said(failure), "\n".join(line for line in lines if line), failure.kind, is_error)
