"""A pytest plugin: which lines of the devices each test runs, as JSON in the file that LINES_FILE names.

Before the run the file has the list of the tests; a test that fails has no lines.

Lines that run when a module is imported belong to no test, so tables and constants are left out.
"""

import json
import os
from collections.abc import Iterator
from pathlib import Path

import coverage
import pytest

VARIABLE = "LINES_FILE"


class Recorder:
    def __init__(self, source: Path, file: Path) -> None:
        self._root, self._file = source.parent, file
        self._nodeids: list[str] = []
        self._failed: set[str] = set()
        self._coverage = coverage.Coverage(data_file=None, source=[str(source)], config_file=False)
        self._coverage.start()

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        asked = set(json.loads(self._file.read_text()))
        items[:] = [item for item in items if item.nodeid in asked]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self._nodeids.append(item.nodeid)
        self._coverage.switch_context(item.nodeid)
        result = yield
        self._coverage.switch_context("")
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self._failed.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        self._coverage.stop()
        data = self._coverage.get_data()
        lines: dict[str, dict[str, list[int]]] = {nodeid: {} for nodeid in self._nodeids}
        for file in sorted(data.measured_files()):
            for line, contexts in data.contexts_by_lineno(file).items():
                for nodeid in {*contexts} - {*self._failed, ""}:
                    lines[nodeid].setdefault(str(Path(file).relative_to(self._root)), []).append(line)
        self._file.write_text(json.dumps(lines))


def pytest_configure(config: pytest.Config) -> None:
    file = os.environ[VARIABLE]
    config.pluginmanager.register(Recorder(config.rootpath / "devices", Path(file)))
