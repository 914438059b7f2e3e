"""A plugin for pytest that says which tests and files take most CPU time: `-p tests.driver.cpu --cpu=30`.

It counts the process of the tests, all processes that they started and that are still there, and all that these waited
for.  It works under `--forks` as well.  Time in a fixture belongs to the test for which it was made or ended.

Left out on purpose: processes that have left their parents, such as daemons, and what these do for a test.
"""

import os
import resource
from collections import defaultdict
from collections.abc import Generator, Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any, Final

import pytest

TICKS_PER_S: Final = os.sysconf("SC_CLK_TCK")
PARENT, FIRST_TIME = 1, 11
"""Places in `/proc/PID/stat` behind the name of the program, which can have spaces; there are four times."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--cpu", type=int, metavar="N", help="name the N tests and files that take most CPU time")


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("cpu"):
        config.pluginmanager.register(Costs(config.getoption("cpu")))


class Costs:
    """The CPU time of each test, in seconds."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._until_now = 0.0
        self._tests = defaultdict[str, float](float)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self) -> Generator[None, Any, Any]:
        self._until_now = cpu_s()
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Generator[None, Any, Any]:
        report: Any = yield
        now = cpu_s()
        report.cpu_s, self._until_now = now - self._until_now, now
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._tests[report.nodeid] += getattr(report, "cpu_s", 0.0)  # a process that was lost has sent none

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        files = defaultdict[str, float](float)
        for name, spent_s in self._tests.items():
            files[name.partition("::")[0]] += spent_s
        for title, costs in (("tests", self._tests), ("files", files)):
            terminalreporter.section(f"CPU time of {title}, {sum(costs.values()):.1f} s in all")
            for name, spent_s in sorted(costs.items(), key=itemgetter(1), reverse=True)[: self._most]:
                terminalreporter.write_line(f"{spent_s:8.2f} s  {name}")


def cpu_s() -> float:
    """Return the CPU time of this process and of those that it started, also of ended ones, in seconds."""
    used = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    own_s = sum(times.ru_utime + times.ru_stime for times in used)
    return own_s + sum(_started_by(os.getpid())) / TICKS_PER_S


def _started_by(pid: int) -> Iterator[int]:
    """The CPU time in ticks of each process below this one, with those for which it waited."""
    children = defaultdict[int, list[tuple[int, int]]](list)
    for file in Path("/proc").glob("[0-9]*/stat"):
        try:
            values = file.read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        ticks = sum(map(int, values[FIRST_TIME : FIRST_TIME + 4]))
        children[int(values[PARENT])].append((int(file.parent.name), ticks))
    below = [pid]
    while below:
        for child, ticks in children[below.pop()]:
            yield ticks
            below.append(child)
