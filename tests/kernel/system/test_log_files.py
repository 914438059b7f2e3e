"""A process's log is bounded, and what it said last is there."""

import subprocess
import sys
from pathlib import Path

import pytest

from fieldrig.real.child import Child
from fieldrig.system import log_files
from fieldrig.system.log_files import LOG_BYTES, LONGEST_TEXT, OLD_LOGS, older

CHATTER = """
import logging, sys
from pathlib import Path
from fieldrig.system import log_files
log_files.take_over(Path(sys.argv[1]))
logging.basicConfig(level="INFO")
line = 1000 * "x"
for number in range(int(sys.argv[2])):
    logging.info("%06d %s", number, line)
    print(f"{number:06} {line}")
print(20 * log_files.LOG_BYTES * "y")
print("the end")
"""


def chatter(log: Path, lines: int) -> None:
    subprocess.run([sys.executable, "-c", CHATTER, str(log), str(lines)], check=True)


@pytest.mark.long
def test_a_process_that_says_too_much_keeps_a_bounded_number_of_bounded_files(tmp_path: Path) -> None:
    log = tmp_path / "io.log"
    chatter(log, 3 * OLD_LOGS * LOG_BYTES // 2000)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["io.log", "io.log.1", "io.log.2", "io.log.3"]
    assert all(path.stat().st_size <= LOG_BYTES + LONGEST_TEXT for path in tmp_path.iterdir())
    assert log.read_text().endswith("the end\n")


@pytest.mark.long
def test_nothing_is_lost_between_two_files(tmp_path: Path) -> None:
    log = tmp_path / "io.log"
    chatter(log, LOG_BYTES // 1500)
    said = "".join(path.read_text() for path in (older(log, 2), older(log, 1), log) if path.exists())
    numbers = [line.split(":")[2][:6] for line in said.splitlines() if line.startswith("INFO")]
    assert numbers == [f"{number:06}" for number in range(LOG_BYTES // 1500)]


def test_a_log_begins_anew_with_the_rig_and_the_tail_follows_it_into_another_file(tmp_path: Path) -> None:
    log = tmp_path / "io.log"
    older(log, 1).write_text("of another rig")
    log_files.begin_anew(log)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["io.log"]
    child = Child((), log, 0)
    child.note("first")
    child._begin_log()
    child.note("second")
    assert child.tail().endswith("supervisor: second")
    log_files.rotate(log)
    child.note("third")
    assert child.tail().endswith("supervisor: third")
