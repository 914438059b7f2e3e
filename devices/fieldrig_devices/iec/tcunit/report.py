"""The end of TcUnit's report: results of suites and tests, and the totals."""

from collections.abc import Iterator, Sequence

from fieldrig.clock import S
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library import texts
from fieldrig_devices.iec.tcunit.session import Session, Suite, Test


def summary(session: Session) -> list[str]:
    """Return the lines behind the last test; none if the run was aborted."""
    if session.is_aborted:
        return []
    suites = list(session.suites.values())
    extended = [line for suite in suites for line in _of_suite(suite)] if session.parameters.is_extended else []
    return [*extended, *_totals(suites)]


def _of_suite(suite: Suite) -> Iterator[str]:
    tests = suite.tests.values()
    failed = sum(test.has_failed for test in tests)
    yield f"| Test suite ID={suite.number} '{suite.path}'"
    counts = f"number of tests={len(tests)}, number of failed tests={failed}"
    yield f"| ID={suite.number} {counts}, duration={seconds(suite.duration_ns)}"
    for test in tests:
        yield from _of_test(test, suite)


def _of_test(test: Test, suite: Suite) -> Iterator[str]:
    yield f"| Test name={test.shown}"
    yield f"| Test class name={suite.path}"
    yield f"| Test status={status(test)}, number of asserts={test.asserts}, duration={seconds(test.duration_ns)}"
    message = next((failure.message for failure in test.failures if failure.message), "")
    if message:
        yield f"| Test assert message={message}"
    if test.failures:
        yield f"| Test assert type={test.failures[0].kind}"


def status(test: Test) -> str:
    return "FAIL" if test.has_failed else "SKIP" if test.is_skipped else "PASS"


def _totals(suites: Sequence[Suite]) -> Iterator[str]:
    tests = [test for suite in suites for test in suite.tests.values()]
    failed = sum(test.has_failed for test in tests)
    starts = [suite.started_ns for suite in suites if suite.started_ns is not None]
    ends = [suite.ended_ns for suite in suites if suite.ended_ns is not None]
    yield "| ==========TESTS FINISHED RUNNING=========="
    yield f"| Test suites: {len(suites)}"
    yield f"| Tests: {len(tests)}"
    yield f"| Successful tests: {len(tests) - failed}"
    yield f"| Failed tests: {failed}"
    yield f"| Duration: {seconds(max(ends, default=0) - min(starts, default=0))}"
    yield "| ======================================"


def seconds(duration_ns: int) -> str:
    """Return a duration in seconds, as LREAL_TO_STRING writes it."""
    return texts.writer(Elementary.LREAL)(duration_ns / S)
