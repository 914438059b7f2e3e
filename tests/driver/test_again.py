"""A stage in real time repeats the few tests that failed, alone, and says so."""

import os
import re
import sys
from pathlib import Path

import pytest
from tests.driver import __main__ as driver
from tests.driver.outcome import Outcome, Tally, summary
from tests.driver.stages import Stage, Turn

FAILURE = '<testcase classname="tests.system.test_a" name="test_late"><failure message="late">E</failure></testcase>'
PASS = '<testcase classname="tests.system.test_a" name="test_good" />'
TIMES = re.compile(r"\d+\.\d s, \d+\.\d s of CPU time")
NAME = "tests.system.test_a::test_late"


def python(code: str) -> list[str]:
    return [sys.executable, "-c", code]


def stage_of(report: Path, cases: str, again_code: int | None) -> Stage:
    """A stage whose tests have these results, and whose second try ends with this code."""
    junit = f"<testsuites><testsuite>{cases}</testsuite></testsuites>"
    command = python(f"import pathlib, sys; pathlib.Path({str(report)!r}).write_text({junit!r}); sys.exit(1)")
    again = None if again_code is None else lambda: python(f"raise SystemExit({again_code})")
    return Stage("system", "processes", lambda: command, report=report, again=again)


@pytest.mark.parametrize(
    ("cases", "again_code", "is_ok", "unsteady"),
    [
        (FAILURE + PASS, 0, True, (NAME,)),
        (FAILURE + PASS, 1, False, ()),
        (FAILURE + PASS, None, False, ()),
        (FAILURE * 6, 0, True, (NAME,) * 6),  # the tests of one file share a rig
        ("".join(FAILURE.replace("test_a", f"test_{n}") for n in range(6)), 0, False, ()),  # a common cause
        (PASS, 0, False, ()),  # pytest failed without a test that did
    ],
)
def test_second_try(tmp_path: Path, cases: str, again_code: int | None, is_ok: bool, unsteady: tuple[str, ...]) -> None:
    outcome = driver.run_stage(stage_of(tmp_path / "report.xml", cases, again_code))
    assert outcome.is_ok is is_ok
    assert outcome.unsteady == unsteady


def test_summary_names_what_needed_a_second_try(capsys: pytest.CaptureFixture[str]) -> None:
    assert summary([Outcome("system", True, 1.0, Tally(passed=2), unsteady=(NAME,))], 1.0, in_ci=True) == 0
    assert f"second try, alone (look at them: a test should not need a quiet host):\n  {NAME}\n" in (
        capsys.readouterr().out
    )


def test_stages_run_together_and_each_has_its_outcome(capfd: pytest.CaptureFixture[str]) -> None:
    checks = [
        Stage("types", "about types", lambda: python("print('all typed')"), turn=Turn.FIRST),
        Stage("prose", "about prose", lambda: python("print('a finding'); raise SystemExit(1)"), turn=Turn.FIRST),
    ]
    assert [(outcome.stage, outcome.is_ok) for outcome in driver.run_together(checks)] == [
        ("types", True),
        ("prose", False),
    ]
    assert TIMES.sub("TIMES", capfd.readouterr().out) == (
        "\n--- side by side: types, prose\n"
        "\n--- types: about types\nall typed\n\n--- types: ok after TIMES\n"
        "\n--- prose: about prose\na finding\n\n--- prose: FAILED after TIMES\n"
    )


def test_stages_run_in_their_turns(capfd: pytest.CaptureFixture[str]) -> None:
    """The stages behind run one after the other, and the one that comes after the others waits for these only."""
    code = "import os, time; print(os.nice(0), time.monotonic_ns()); time.sleep(0.01); print(time.monotonic_ns())"
    turns = {"lean": Turn.BEHIND, "unit": Turn.BEHIND, "real": Turn.BESIDE, "system": Turn.AFTER}
    stages = [Stage(name, f"about {name}", lambda: python(code), turn=turn) for name, turn in turns.items()]
    outcomes = driver.run_together(stages)
    assert [(outcome.stage, outcome.is_ok) for outcome in outcomes] == [
        (name, True) for name in ("real", "system", "lean", "unit")
    ]
    said = re.findall(r"(?m)^(\d+) (\d+)\n(\d+)$", capfd.readouterr().out)
    niceness, begins, ends = zip(*(map(int, each) for each in said), strict=True)
    ours, behind = os.nice(0), min(os.nice(0) + 10, 19)  # this test may run behind others itself
    assert niceness == (ours, ours, behind, behind)
    assert ends[0] < begins[1]
    assert ends[2] < begins[3]


def test_byte_code_is_kept_where_the_user_wants_none_beside_the_sources() -> None:
    environment = {"PYTHONDONTWRITEBYTECODE": "1", "HOME": "/"}
    driver.keep_bytecode(environment)
    assert environment == {"HOME": "/", "PYTHONPYCACHEPREFIX": str(Path("build/bytecode").resolve())}
