"""The results of the stages, and their summary for the user."""

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self
from xml.etree import ElementTree


@dataclass(frozen=True, slots=True)
class Tally:
    """The tests of one stage, out of its JUnit file."""

    passed: int = 0
    failed: int = 0
    skipped: tuple[str, ...] = ()
    """Reasons, with how many tests each stopped."""
    failures: tuple[str, ...] = ()
    """The names of the tests that failed."""

    @property
    def failed_files(self) -> int:
        """The number of files with tests that failed; those of one file may fail because of a rig that they share."""
        return len({name.partition("::")[0] for name in self.failures})

    @classmethod
    def of(cls, report: Path) -> Self:
        """Nothing, if pytest never came to write the file."""
        if not report.exists():
            return cls()
        cases = list(ElementTree.parse(report).iter("testcase"))
        skips = [skip for case in cases for skip in case.iter("skipped") if skip.get("type") == "pytest.skip"]
        reasons = Counter(skip.get("message", "") for skip in skips)
        failed = [case for case in cases if case.find("failure") is not None or case.find("error") is not None]
        skipped = tuple(f"{count} skipped: {reason}" for reason, count in reasons.items())
        names = tuple(f"{case.get('classname')}::{case.get('name')}" for case in failed)
        return cls(len(cases) - len(failed) - reasons.total(), len(failed), skipped, names)


@dataclass(frozen=True, slots=True)
class Outcome:
    stage: str
    is_ok: bool | None
    """None: it was left out."""
    seconds: float = 0.0
    tally: Tally = Tally()
    left_out: Sequence[str] = field(default_factory=tuple)
    unsteady: Sequence[str] = field(default_factory=tuple)
    """Tests that failed beside the others and passed when they ran again, alone."""
    cpu_s: float = 0.0
    """CPU time of its processes in seconds, without what a daemon or a guest did for it."""

    @property
    def times(self) -> str:
        cpu = f", {self.cpu_s:.1f} s of CPU time" if self.cpu_s else ""
        return f"{self.seconds:.1f} s{cpu}"

    @property
    def word(self) -> str:
        return {True: "ok", False: "FAILED", None: "left out"}[self.is_ok]


def summary(outcomes: Sequence[Outcome], seconds: float, in_ci: bool) -> int:
    """Say it, and give the exit code: 1 if anything failed, or in CI was left out."""
    lines = ["", "--- summary", *(_row(outcome) for outcome in outcomes)]
    left_out = [text for outcome in outcomes for text in outcome.left_out]
    if left_out:
        lines += ["", "left out" + (" (which is a failure with CI=true):" if in_ci else ":")]
        lines += [f"  {text}" for text in dict.fromkeys(left_out)]
    unsteady = [f"  {name}" for outcome in outcomes for name in outcome.unsteady]
    if unsteady:
        lines += [
            "",
            "passed only at the second try, alone (look at them: a test should not need a quiet host):",
            *unsteady,
        ]
    has_failed = any(outcome.is_ok is False for outcome in outcomes) or (in_ci and bool(left_out))
    if any(outcome.tally.passed or outcome.tally.failed for outcome in outcomes):
        lines += ["", _closing(outcomes, seconds)]
    sys.stdout.write("\n".join(lines) + "\n")
    return 1 if has_failed else 0


def _row(outcome: Outcome) -> str:
    cpu = f"{outcome.cpu_s:6.1f} s CPU  " if outcome.cpu_s else ""
    return f"{outcome.stage:<8} {outcome.word:<8} {outcome.seconds:6.1f} s  {cpu}{_counts([outcome])}".rstrip()


def _closing(outcomes: Sequence[Outcome], seconds: float) -> str:
    """Return the results of all stages in one line of pytest's form."""
    return f"{_counts(outcomes)} in {seconds:.2f}s"


def _counts(outcomes: Sequence[Outcome]) -> str:
    counts = {
        "failed": sum(outcome.tally.failed for outcome in outcomes),
        "passed": sum(outcome.tally.passed for outcome in outcomes),
    }
    return ", ".join(f"{count} {word}" for word, count in counts.items() if count)
