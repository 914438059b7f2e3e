"""A search that is interrupted: what it has found until then is shown and written, and its corpus goes on."""

import os
import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from lamp_search import PLAN, PROGRAM
from running_rig import until
from st_tests import LAMP_RIG

pytestmark = [pytest.mark.system, pytest.mark.timeout(600)]

SECOND_PRESS = "IF presses >= 2 THEN lamp := TRUE; END_IF"


def begun(folder: Path, bug: str) -> subprocess.Popen[str]:
    (folder / "rig.yaml").write_text(LAMP_RIG)
    (folder / "lamp.st").write_text(PROGRAM.format(bug=bug))
    (folder / "plan.yaml").write_text(PLAN)
    command = [sys.executable, "-m", "fieldrig", "search", "run", "plan.yaml", "--budget", "1h", "--findings", "found"]
    return subprocess.Popen(
        command, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
    )


def count(corpus: Path, table: str) -> int:
    if not corpus.exists():
        return 0
    with closing(sqlite3.connect(f"file:{corpus}?mode=ro", uri=True)) as store:
        is_there = store.execute("SELECT 1 FROM sqlite_master WHERE name = ?", (table,)).fetchone()
        rows: int = store.execute(f"SELECT count(*) FROM {table}").fetchone()[0] if is_there else 0
    return rows


@pytest.mark.parametrize(("bug", "table", "code"), [(SECOND_PRESS, "finding", 1), ("lamp := lamp;", "run", 130)])
def test_ctrl_c_shows_and_writes_what_was_found_until_then(tmp_path: Path, bug: str, table: str, code: int) -> None:
    with begun(tmp_path, bug) as process:
        until(lambda: count(tmp_path / "search.sqlite", table) > 0)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does it: the branches get it too
        out, err = process.communicate()
    assert (process.returncode, err) == (code, "")
    assert out.startswith("interrupted after ")
    found = [file.name for file in sorted((tmp_path / "found").glob("finding-*.yaml"))]
    if table == "finding":
        assert "1. the lamp goes out: at " in out
        assert "finding-1.yaml" in found
    else:
        assert "nothing was found" in out
        assert found == []
