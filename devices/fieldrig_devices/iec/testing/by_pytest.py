"""Tests in Python as tests of programs: pytest runs them, each run in a process of its own.

A module of tests may load its program when it is imported, and a process imports it once; so a program that is changed
between two runs (`iec.mutation`) would be the old one in the second.
"""

import os
import re
from collections.abc import Collection, Generator, Iterator, Sequence
from contextlib import closing
from importlib import import_module
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from fieldrig.coverage import collecting
from fieldrig.errors import UsageError
from fieldrig.system.limits import limit_busy_seconds
from fieldrig_devices.iec.mutation import switch
from fieldrig_devices.iec.mutation.changes import Change
from fieldrig_devices.iec.source_texts import files_in
from fieldrig_devices.iec.testing.case import FAULT, MISTAKE, TIMEOUT, Case, Failure, Limits, Outcome, Verdict

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    import pytest

SUFFIX: Final = ".py"
IMPORTS: Final = "the file can be imported"
"""The name of the case of a file whose tests cannot be found."""
_PLACE: Final = re.compile(r"^(.+?):(\d+): in ", re.MULTILINE)
"""A line of a traceback, with its file."""
_ALREADY_IMPORTED: Final = "ignore:Module already imported"
"""The warning that a plugin was there before pytest, which is an error for those who make each warning one."""
_BROKEN: Final = (2, 3, 4)
"""The exit codes of pytest that has been interrupted, has failed itself, or does not understand its settings."""
_START: Final = "fork" if hasattr(os, "fork") else "spawn"


class _Notes(NamedTuple):
    """The knowledge of a process of pytest about the programs that it has compiled."""

    changes: tuple[Change, ...]
    is_refused: bool
    """True if the changed one did not compile."""


class PytestSource:
    """Implements `case.Source` for one file with tests in Python."""

    def __init__(self, file: Path) -> None:
        """UsageError without pytest."""
        if find_spec("pytest") is None:
            raise UsageError(f"{file} has tests in Python", "pip install pytest")
        self._file = file

    def cases(self) -> Sequence[Case]:
        with closing(self._answers([], None)) as answers:
            for answer in answers:
                if isinstance(answer, list):
                    return answer
                if isinstance(answer, Outcome):
                    break
        return [Case(IMPORTS, str(self._file), self._file, 1)]

    @property
    def path(self) -> Path:
        return self._file

    def files(self) -> Collection[Path]:
        """Return the test file, and the sources beside it: which of them it loads, only its run would tell."""
        return {self._file, *files_in(self._file.parent)}

    def run(self, chosen: Sequence[Case], limits: Limits) -> Iterator[Outcome]:
        names = [case.name for case in chosen if case.name != IMPORTS]
        present: Case | None = None
        with closing(self._answers(names, limits.timeout_s)) as answers:
            for answer in answers:
                match answer:
                    case Case():
                        present = answer
                    case Outcome():
                        present = None
                        yield answer
                    case _Notes():
                        switch.note(answer.changes, is_refused=answer.is_refused)
        if present is not None:
            text = f"the process of the test has ended; at most {limits.timeout_s:g} s of a processor are allowed"
            yield Outcome(present, Verdict.ERROR, (Failure(TIMEOUT, "", text, "", present.file, present.line, 0),))

    def _answers(self, names: Sequence[str], timeout_s: float | None) -> Generator[Any]:
        """Run pytest, and yield what its process says; without a time-out it only finds the tests."""
        import_module("pytest")  # before the fork, as it takes a while
        context = get_context(_START)
        mine, its = context.Pipe(duplex=False)
        arguments = its, self._file, list(names), timeout_s, switch.present()
        process = context.Process(target=_play, args=arguments, daemon=False)  # type: ignore[attr-defined]
        process.start()
        its.close()
        try:
            while True:
                yield mine.recv()
        except EOFError:
            pass
        finally:
            mine.close()
            if process.is_alive():
                process.kill()
            process.join()


# ---- in the process of pytest


def _play(
    pipe: "Connection[Any, Any]", file: Path, names: Sequence[str], timeout_s: float | None, change: Change | None
) -> None:
    import pytest

    _be_quiet()
    chosen = [f"{file}::{name}" for name in names] or [str(file)]
    options = ["-q", "-p", "no:cacheprovider", "-W", _ALREADY_IMPORTED, *(["-n0"] if find_spec("xdist") else [])]
    options += ["--collect-only"] if timeout_s is None else []
    with switch.surveying() as survey, switch.applied(change) as applied:
        watcher = _Watcher(pipe, file, timeout_s, applied)
        try:
            code, wrong = pytest.main([*options, *chosen], plugins=[watcher]), ""
        except Exception as raised:  # noqa: BLE001  of a plugin or the settings, which is seen nowhere else
            code, wrong = pytest.ExitCode.INTERNAL_ERROR, repr(raised)
        if code in _BROKEN and not watcher.has_spoken:
            case = Case(IMPORTS, str(file), file, 1)
            text = wrong or f"pytest cannot begin; run it alone to see why: pytest {file}"
            pipe.send(Outcome(case, Verdict.ERROR, (Failure(FAULT, "", text, "", file, 1, 0),)))
        collecting.flush()
        pipe.send(_Notes(tuple(survey.changes), applied.is_refused))


def _be_quiet() -> None:
    """Keep what pytest and the tests write off the terminal."""
    with Path(os.devnull).open("w", encoding="utf-8") as nothing:
        for descriptor in (1, 2):
            os.dup2(nothing.fileno(), descriptor)


class _Watcher:
    """The plugin that says what pytest finds and runs."""

    def __init__(
        self, pipe: "Connection[Any, Any]", file: Path, timeout_s: float | None, applied: switch.Applied
    ) -> None:
        self._pipe, self._file, self._timeout_s, self._applied = pipe, file, timeout_s, applied
        self._cases: dict[str, Case] = {}
        self.has_spoken = False
        self._reports: list[pytest.TestReport] = []
        self._begin_s = 0.0

    def pytest_collection_finish(self, session: "pytest.Session") -> None:
        for item in session.items:
            _, line, _ = item.reportinfo()
            name = item.nodeid.partition("::")[2]
            self._cases[item.nodeid] = Case(name, str(self._file), self._file, (line or 0) + 1)
        self.has_spoken = True
        self._pipe.send(list(self._cases.values()))

    def pytest_collectreport(self, report: "pytest.CollectReport") -> None:
        if report.failed:
            self.has_spoken = True
            case = Case(IMPORTS, str(self._file), self._file, 1)
            self._pipe.send(Outcome(case, Verdict.ERROR, (_not_imported(report, case),)))

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self._reports.clear()
        self._begin_s = _busy_s()
        if self._timeout_s is not None:
            limit_busy_seconds(self._timeout_s)
        self._pipe.send(self._cases[nodeid])

    def pytest_runtest_logreport(self, report: "pytest.TestReport") -> None:
        self._reports.append(report)

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        if self._applied.is_refused:
            self._pipe.send(_Notes((), is_refused=True))
        self._pipe.send(_outcome(self._cases[nodeid], self._reports, _busy_s() - self._begin_s))


def _busy_s() -> float:
    """Return the time of a processor of this process and of its branches that have ended."""
    return sum(os.times()[:4])


def _outcome(case: Case, reports: Sequence["pytest.TestReport"], busy_s: float) -> Outcome:
    wall_s = sum(report.duration for report in reports)
    output = tuple(line for report in reports[-1:] for line in report.capstdout.splitlines())
    failed = [report for report in reports if report.failed]
    skipped = next((report for report in reports if report.skipped), None)
    if failed:
        failures = tuple(_failure(one, case, "assert" if one.when == "call" else FAULT) for one in failed)
        verdict = Verdict.FAILED if failed[0].when == "call" else Verdict.ERROR
        return Outcome(case, verdict, failures, wall_s=wall_s, output=output, busy_s=busy_s)
    if skipped is not None:
        return Outcome(case, Verdict.SKIPPED, wall_s=wall_s, reason=_reason(skipped), busy_s=busy_s)
    return Outcome(case, Verdict.PASSED, wall_s=wall_s, output=output, busy_s=busy_s)


def _reason(report: "pytest.TestReport") -> str:
    if isinstance(report.longrepr, tuple):
        return report.longrepr[2].removeprefix("Skipped: ")
    return str(getattr(report, "wasxfail", "")) or "it is expected to fail"


def _not_imported(report: "pytest.CollectReport", case: Case) -> Failure:
    """Return the last error of a traceback that pytest has written."""
    text = report.longreprtext
    errors = [line.removeprefix("E   ") for line in text.splitlines() if line.startswith("E   ")]
    first = max((place for place, line in enumerate(errors) if line[:1].strip()), default=0)
    lines = [int(line) for name, line in _PLACE.findall(text) if Path(name).name == case.file.name]
    what = "; ".join(line.strip() for line in errors[first:]) or text.strip().rpartition("\n")[2]
    return Failure(MISTAKE, "", what, "", case.file, lines[-1] if lines else 1, 0)


def _failure(report: "pytest.TestReport", case: Case, kind: str) -> Failure:
    """Return a failure at the last line of the test file that its traceback has."""
    crash = getattr(report.longrepr, "reprcrash", None)
    message = crash.message if crash is not None else report.longreprtext
    what, *others = [line for line in message.splitlines() if line.strip()] or ["it failed"]
    entries = getattr(getattr(report.longrepr, "reprtraceback", None), "reprentries", ())
    places = [entry.reprfileloc for entry in entries if getattr(entry, "reprfileloc", None) is not None]
    lines = [place.lineno for place in places if Path(place.path).name == case.file.name]
    told = [line for name, text in report.sections if name.startswith("last changes") for line in text.splitlines()]
    return Failure(kind, "", what, "", case.file, lines[-1] if lines else case.line, 0, (*others, *told))
