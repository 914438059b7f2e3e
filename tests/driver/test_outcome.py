"""The summary of a test run and its exit code."""

from pathlib import Path

import pytest
from tests.driver.outcome import Outcome, Tally, summary

# As pytest 9 writes it, shortened.
JUNIT = """<?xml version="1.0" encoding="utf-8"?>
<testsuites name="pytest tests"><testsuite name="pytest" errors="1" failures="1" skipped="3" tests="6" time="0.1">
<testcase classname="test_a" name="test_passes" />
<testcase classname="test_a" name="test_fails"><failure message="assert 0">E</failure></testcase>
<testcase classname="test_a" name="test_errs"><error message="boom">E</error></testcase>
<testcase classname="test_a" name="test_1"><skipped type="pytest.skip" message="no mbpoll">x</skipped></testcase>
<testcase classname="test_a" name="test_2"><skipped type="pytest.skip" message="no mbpoll">x</skipped></testcase>
<testcase classname="test_a" name="test_3"><skipped type="pytest.xfail" message="known" /></testcase>
</testsuite></testsuites>
"""


def test_tally_counts_what_junit_says(tmp_path: Path) -> None:
    report = tmp_path / "report.xml"
    report.write_text(JUNIT)
    failures = ("test_a::test_fails", "test_a::test_errs")
    # An xfail is as expected.
    assert Tally.of(report) == Tally(passed=2, failed=2, skipped=("2 skipped: no mbpoll",), failures=failures)


def test_tally_of_a_pytest_that_never_ran_is_empty(tmp_path: Path) -> None:
    assert Tally.of(tmp_path / "none.xml") == Tally()


@pytest.mark.parametrize(
    ("outcome", "code", "code_in_ci"),
    [
        (Outcome("unit", True, 1.0, Tally(passed=3)), 0, 0),
        (Outcome("unit", False, 1.0, Tally(passed=3, failed=1)), 1, 1),
        (Outcome("docker", None, 0.0, left_out=["docker needs Docker: apt-get install docker.io"]), 0, 1),
        (Outcome("real", True, 1.0, Tally(passed=3), ["2 skipped: no mbpoll"]), 0, 1),
    ],
)
def test_leaving_something_out_fails_only_in_ci(outcome: Outcome, code: int, code_in_ci: int) -> None:
    assert summary([outcome], 1.0, in_ci=False) == code
    assert summary([outcome], 1.0, in_ci=True) == code_in_ci


def test_summary_says_what_was_left_out_and_ends_like_pytest(capsys: pytest.CaptureFixture[str]) -> None:
    outcomes = [
        Outcome("vcan", None, 0.0, left_out=["vcan needs a kernel with vcan: apt-get install user-mode-linux"]),
        Outcome("unit", True, 2.0, Tally(passed=3), cpu_s=3.25),
        Outcome("real", False, 2.0, Tally(passed=1, failed=1)),
    ]
    summary(outcomes, 12.3456, in_ci=False)
    said = capsys.readouterr().out
    assert "  vcan needs a kernel with vcan: apt-get install user-mode-linux\n" in said
    assert "\nunit     ok          2.0 s     3.2 s CPU  3 passed\n" in said
    assert said.endswith("\n1 failed, 4 passed in 12.35s\n")
