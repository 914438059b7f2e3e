"""The plugin that names the tests and files with the most CPU time, itself run in a process of its own."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from tests.driver.cpu import cpu_s

pytestmark = pytest.mark.system

ROOT = Path(__file__).parents[2]
WORKING = """\
import subprocess, sys, time

def work(seconds):
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass

def test_own_work():
    work(0.3)

def test_work_of_a_child():
    subprocess.run([sys.executable, "-c", "import time\\nwhile time.process_time() < 0.6: pass"], check=True)

def test_no_work():
    pass
"""


@pytest.mark.parametrize("forks", [(), ("-p", "tests.driver.forks", "--forks")], ids=["alone", "forks"])
def test_the_most_costly_are_named_with_the_processes_that_they_started(tmp_path: Path, forks: tuple[str, ...]) -> None:
    file = tmp_path / "test_working.py"
    file.write_text(WORKING, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-p", "tests.driver.cpu", "--cpu=2", "-p", "no:cacheprovider", *forks]
    done = subprocess.run(
        [*command, f"--rootdir={tmp_path}", str(file)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    named = re.findall(r"^ +([\d.]+) s  (\S+)$", done.stdout, re.MULTILINE)
    assert [name for _, name in named] == [
        "test_working.py::test_work_of_a_child",
        "test_working.py::test_own_work",
        "test_working.py",
    ]
    child, own, whole = (float(spent_s) for spent_s, _ in named)
    assert child >= 0.6
    assert own >= 0.3
    assert whole >= child + own - 0.02  # each is rounded


def test_a_process_that_still_runs_is_counted() -> None:
    busy = [sys.executable, "-c", "import time\nwhile time.process_time() < 0.2: pass\nprint(flush=True)\ninput()"]
    before = cpu_s()
    with subprocess.Popen(busy, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        assert cpu_s() - before >= 0.15  # the system counts in hundredths
