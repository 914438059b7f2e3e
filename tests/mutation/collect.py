"""A pytest plugin: which tests show each row of the manuals, as JSON in the file that LINES_FILE names."""

import json
import os
from pathlib import Path

import pytest
from tests.mutation.record import VARIABLE


def pytest_collection_finish(session: pytest.Session) -> None:
    tests: dict[str, list[str]] = {}
    for item in session.items:
        for mark in item.iter_markers("manual"):
            for row in mark.args:
                tests.setdefault(row, []).append(item.nodeid)
    Path(os.environ[VARIABLE]).write_text(json.dumps(tests), encoding="utf-8")
