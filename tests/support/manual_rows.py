"""Which rows of the manuals the tests show: `@pytest.mark.manual("ARP-012")` and `pytest --manual-rows`.

docs/developers/manual-rows.toml has the rows:

    [rows]
    ARP = ["1-85", "90-122"]                # ARP-001 to ARP-085, ARP-090 to ARP-122

    [aside]
    ARP-012 = "two parameters of which the manual only says that they are reserved"

A row is shown when a test that carries it passed and none that carries it failed.  A mark that names no row of the
file is an error at collection.  Left out on purpose: whether the test would fail if the behaviour were wrong; that is
for the reader of the test.
"""

import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import NamedTuple, Self

import pytest

FILE = "docs/developers/manual-rows.toml"
PROPERTY = "manual"  # the name of a test's rows in reports, including JUnit files


class Row(NamedTuple):
    manual: str
    number: int

    def __str__(self) -> str:
        return f"{self.manual}-{self.number:03}"

    @classmethod
    def parse(cls, text: str) -> Self:
        found = re.fullmatch(r"([A-Z]+)-(\d{3,})", text)
        if found is None:
            raise ValueError(f"{text!r}: a row is written as ABC-012")
        return cls(found[1], int(found[2]))


@dataclass(frozen=True, slots=True)
class RowList:
    """The rows there are, and those set aside with their reasons."""

    rows: frozenset[Row]
    aside: dict[Row, str]

    @classmethod
    def load(cls, path: Path) -> Self:
        """Load the rows.  ValueError, with the reason, for a file that contradicts itself."""
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        spans = content["rows"].items()
        rows = frozenset(Row(manual, n) for manual, texts in spans for text in texts for n in _numbers(text))
        aside = {Row.parse(text): reason for text, reason in content.get("aside", {}).items()}
        if strangers := aside.keys() - rows:
            raise ValueError(f"{path}: set aside, but not among the rows: {', '.join(map(str, sorted(strangers)))}")
        if mute := [str(row) for row, reason in aside.items() if not reason]:
            raise ValueError(f"{path}: set aside without a reason: {', '.join(mute)}")
        return cls(rows, aside)


def _numbers(text: str) -> range:
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def spans(rows: Sequence[Row]) -> str:
    """Return the rows of one manual as ranges: `001-003, 007`."""
    runs = groupby(enumerate(sorted(row.number for row in rows)), key=lambda place: place[1] - place[0])
    ends = [(run[0][1], run[-1][1]) for run in (list(run) for _, run in runs)]
    return ", ".join(f"{first:03}" if first == last else f"{first:03}-{last:03}" for first, last in ends)


def coverage(row_list: RowList, shown: frozenset[Row]) -> Iterator[str]:
    """Return the lines of the report: for each manual the rows shown, not shown, and set aside with the reason."""
    for manual in sorted({row.manual for row in row_list.rows}):
        rows = [row for row in row_list.rows if row.manual == manual]
        seen = [row for row in rows if row in shown]
        aside = sorted(row for row in rows if row in row_list.aside)
        missing = [row for row in rows if row not in shown and row not in row_list.aside]
        yield f"{manual}: {len(rows)} rows, {len(seen)} shown, {len(missing)} not shown, {len(aside)} set aside"
        for title, some in (("shown", seen), ("not shown", missing)):
            if some:
                yield f"  {title + ':':<10} {spans(some)}"
        for row in aside:
            also = " (but a test shows it)" if row in shown else ""
            yield f"  set aside: {row.number:03} {row_list.aside[row]}{also}"


class ManualRowsPlugin:
    """Checks the marks of the collected tests, keeps what their outcomes show, and reports at the end if asked."""

    def __init__(self, row_list: RowList, report: bool) -> None:
        self._row_list, self._report = row_list, report
        self._passed: set[Row] = set()
        self._failed: set[Row] = set()

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        wrong = []
        for item in items:
            for mark in item.iter_markers("manual"):
                for text in mark.args:
                    if reason := self._wrong(text):
                        wrong.append(f"{item.nodeid}: {reason}")
                    # A property of the test's report, so that it also arrives from a worker of pytest-xdist.
                    item.user_properties.append((PROPERTY, text))
        if wrong:
            raise pytest.UsageError("\n".join(wrong))

    def _wrong(self, text: str) -> str:
        try:
            return "" if Row.parse(text) in self._row_list.rows else f"{text} is no row of the manuals"
        except ValueError as fault:
            return str(fault)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        rows = {Row.parse(str(text)) for name, text in report.user_properties if name == PROPERTY}
        if report.failed:
            self._failed |= rows
        elif report.when == "call" and report.passed:
            self._passed |= rows

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Report an exit code of success even if no test shows a row yet."""
        if self._report and session.exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
            session.exitstatus = pytest.ExitCode.OK

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self._report:
            terminalreporter.section("rows of the manuals")
            for line in coverage(self._row_list, frozenset(self._passed - self._failed)):
                terminalreporter.write_line(line)


def pytest_addoption(parser: pytest.Parser) -> None:
    # An option and not a line of pyproject.toml: a pytest without this plugin stumbles over keys that it does not know.
    group = parser.getgroup("rows of the manuals")
    about = "say which rows of the manuals the tests that ran have shown"
    group.addoption("--manual-rows", action="store_true", help=about)
    group.addoption("--manual-rows-file", default=FILE, help="TOML file with the rows (default: %(default)s)")


def pytest_configure(config: pytest.Config) -> None:
    row_list = RowList.load(config.rootpath / config.getoption("manual_rows_file"))
    config.pluginmanager.register(ManualRowsPlugin(row_list, report=config.getoption("manual_rows")))
