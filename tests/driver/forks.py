"""A plugin for pytest that collects the tests once and runs them in forked processes: `-p tests.driver.forks --forks`.

A worker of pytest-xdist collects all tests itself, which costs 30 s of CPU time for 20,000 of them.  A forked process
has them, with all modules, in memory that it shares.  It runs some tests of one module after the other, asks for more,
and sends its reports to the process that collected, where they are like those of tests that ran there.

Left out on purpose: anything that threads of the collecting process would need, which a fork does not have.
"""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from itertools import groupby, pairwise
from multiprocessing.connection import Connection, Pipe, wait
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, NoReturn

import pytest
from tests.driver.time_limits import TimeLimits

MOST_AT_ONCE: Final = 20
"""Longest part in tests: less would separate tests that share a fixture, more would let processes end late."""
NO_PART: Final = range(0)
PROCESSORS: Final = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--forks", action="store_true", help="run the tests in a forked process for each processor")


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> bool | None:
    config = session.config
    if not config.getoption("forks") or config.option.collectonly or session.testsfailed or not session.items:
        return None
    Forks(session).run()
    return True


def parts(session: pytest.Session) -> Iterator[range]:
    """The tests in their order, cut into parts of at most `MOST_AT_ONCE` tests of one module."""
    first = 0
    for _, items in groupby(session.items, key=lambda item: item.path):
        end = first + len([*items])
        yield from (range(start, min(start + MOST_AT_ONCE, end)) for start in range(first, end, MOST_AT_ONCE))
        first = end


class Fork:
    """A process that runs tests."""

    def __init__(self, pid: int, connection: Connection) -> None:
        self.pid, self.connection = pid, connection
        self.part: list[int] = []
        """The tests that it has been given and that have not ended, by their numbers."""


class Forks:
    """The side of the collecting process."""

    def __init__(self, session: pytest.Session) -> None:
        self._session, self._config = session, session.config
        self._parts = parts(session)
        self._again: list[range] = []
        self._forks: dict[Connection, Fork] = {}
        self._folder: Path = self._config._tmp_path_factory.getbasetemp()  # type: ignore[attr-defined]

    def run(self) -> None:
        reporter = self._config.pluginmanager.get_plugin("terminalreporter")
        if reporter is not None:
            reporter.showfspath = False  # the tests of several modules end in turn
        try:
            for _ in range(PROCESSORS):
                self._fork()
            self._follow()
        except BaseException:
            # SIGINT lets a process end its fixtures, as in pytest itself.
            for fork in self._forks.values():
                os.kill(fork.pid, signal.SIGINT)
            raise
        finally:
            while self._forks:
                self._end(next(iter(self._forks.values())))
        if self._session.shouldfail:
            raise self._session.Failed(self._session.shouldfail)

    def _fork(self) -> None:
        ours, theirs = Pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        pid = os.fork()
        if pid == 0:
            ours.close()
            for other in self._forks:
                other.close()
            Worker(self._session, theirs).run(self._folder / str(os.getpid()))
        theirs.close()
        self._forks[ours] = Fork(pid, ours)

    def _follow(self) -> None:
        while self._forks:
            for connection in wait([*self._forks]):
                assert isinstance(connection, Connection)
                fork = self._forks[connection]
                try:
                    self._take(fork, connection.recv())
                except (EOFError, ConnectionResetError):
                    self._lost(fork)

    def _take(self, fork: Fork, message: Any) -> None:
        match message:
            case None:
                part = NO_PART if self._session.shouldfail else self._next()
                fork.part += part
                fork.connection.send(part)
            case int(number), reports:
                fork.part.remove(number)
                hook = self._config.hook
                for data in reports:
                    report = hook.pytest_report_from_serializable(config=self._config, data=data)
                    hook.pytest_runtest_logreport(report=report)

    def _next(self) -> range:
        return self._again.pop() if self._again else next(self._parts, NO_PART)

    def _lost(self, fork: Fork) -> None:
        """Go on after the end of a process; if tests are left, the first is to blame, and the others run elsewhere."""
        code = self._end(fork)
        if not fork.part or self._session.shouldfail:
            return
        number, *others = fork.part
        item = self._session.items[number]
        text = f"the process that ran this test ended with {code}"
        report = pytest.TestReport(item.nodeid, item.location, {}, "failed", text, "call")
        self._config.hook.pytest_runtest_logreport(report=report)
        self._again += [range(other, other + 1) for other in reversed(others)]
        self._fork()

    def _end(self, fork: Fork) -> int:
        """Wait for the end of a process, and return its exit code."""
        del self._forks[fork.connection]
        fork.connection.close()
        return os.waitstatus_to_exitcode(os.waitpid(fork.pid, 0)[1])


class Worker:
    """The side of a forked process, which never returns to its caller."""

    def __init__(self, session: pytest.Session, connection: Connection) -> None:
        self._session, self._config, self._connection = session, session.config, connection
        self._reports: list[dict[str, Any]] = []
        """The reports of the test that runs."""

    def run(self, folder: Path) -> NoReturn:
        """Run tests to the end, with temporary files in `folder`."""
        code = 1
        try:
            os.setpgid(0, 0)  # Ctrl-C reaches the collecting process, which passes it on
            folder.mkdir()
            self._config._tmp_path_factory._basetemp = folder  # type: ignore[attr-defined]
            self._become_a_worker()
            code = self._work()
        except KeyboardInterrupt:
            code = pytest.ExitCode.INTERRUPTED
        finally:
            with suppress(BaseException):
                runner: Any = self._config.pluginmanager.get_plugin("runner")
                runner.pytest_sessionfinish(self._session)  # ends the fixtures that are left
            os._exit(code)

    def _become_a_worker(self) -> None:
        """Capture into files of its own, and print nothing but what pytest-timeout says at the end of a process."""
        plugins = self._config.pluginmanager
        capture: Any = plugins.get_plugin("capturemanager")
        reporter: Any = plugins.get_plugin("terminalreporter")
        capture.stop_global_capturing()
        capture.start_global_capturing()
        for name in ("terminalreporter", "terminalprogress"):
            if plugins.has_plugin(name):
                plugins.unregister(name=name)
        plugins.register(SimpleNamespace(_tw=reporter._tw), "terminalreporter")
        if hasattr(self._config.hook, "pytest_timeout_set_timer"):
            plugins.register(TimeLimits())
        plugins.register(self)

    def _work(self) -> int:
        while part := self._given():
            if not self._run(part):
                break
        return 0

    def _run(self, part: range) -> bool:
        """Run a part, and return whether another one may follow.

        A part leaves no fixture but those of the session: what a test finds does not depend on the parts that this
        process had before, and a run on another host tries the same.
        """
        items: list[Any] = [self._session.items[number] for number in part]
        for number, (item, following) in zip(part, pairwise([*items, self._session]), strict=True):
            self._config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            self._connection.send((number, self._reports))
            self._reports = []
            if self._session.shouldfail or self._session.shouldstop:
                return False
        return True

    def _given(self) -> range:
        self._connection.send(None)
        part: range = self._connection.recv()
        return part

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._reports.append(self._config.hook.pytest_report_to_serializable(config=self._config, report=report))
