"""Forked processes run the tests that were collected once, and their reports are those of an ordinary run."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

pytestmark = pytest.mark.system

ROOT = Path(__file__).parents[2]
MIXED = """
import os, pathlib, pytest, sys
HERE = pathlib.Path(__file__).parent

@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shared")
    yield folder
    (HERE / f"torn-{os.getpid()}").touch()

@pytest.mark.parametrize("number", range(50))
def test_one(number, shared, tmp_path, capfd):
    print("heard", number)
    assert capfd.readouterr().out == f"heard {number}\\n"
    (HERE / f"ran-{number}-{os.getpid()}").touch()
    assert tmp_path != shared
    if number == 7:
        os._exit(3)
    if number == 22:
        pytest.skip("not here")
    print("said", number)
    assert number != 9
"""
ENDLESS = """
import pathlib, pytest, time
HERE = pathlib.Path(__file__).parent

@pytest.fixture
def tidy():
    yield
    time.sleep(0.2)
    (HERE / "tidy").touch()

def test_endless(tidy):
    (HERE / "begun").touch()
    time.sleep(600)
"""


def forked(folder: Path, text: str, *options: str) -> "subprocess.Popen[str]":
    (folder / "test_it.py").write_text(text)
    command = [sys.executable, "-m", "pytest", "-p", "tests.driver.forks", "--forks", "-p", "no:cacheprovider"]
    return subprocess.Popen(
        [*command, "-c", os.devnull, f"--rootdir={folder}", *options, str(folder)],
        cwd=ROOT,
        env={**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_failures_skips_and_a_process_that_ends_are_reported(tmp_path: Path) -> None:
    report = tmp_path / "report.xml"
    output, _ = (process := forked(tmp_path, MIXED, f"--junitxml={report}")).communicate()
    assert process.returncode == pytest.ExitCode.TESTS_FAILED, output
    assert "2 failed, 47 passed, 1 skipped" in output
    assert "the process that ran this test ended with 3" in output
    assert re.search(r"-+ Captured stdout call -+\nsaid 9\n", output)
    ran = [path.name.split("-")[1] for path in tmp_path.glob("ran-*")]
    assert sorted(ran, key=int) == [str(number) for number in range(50)], "each test runs once"
    processes = {path.name.split("-")[2] for path in tmp_path.glob("ran-*")}
    torn = {path.name.split("-")[1] for path in tmp_path.glob("torn-*")}
    assert torn == processes - {path.name.split("-")[2] for path in tmp_path.glob("ran-7-*")}
    cases = [*ElementTree.parse(report).iter("testcase")]
    assert len(cases) == 50
    assert [case.get("name") for case in cases if case.find("failure") is not None] == ["test_one[7]", "test_one[9]"]


def test_an_interrupted_run_ends_its_fixtures(tmp_path: Path) -> None:
    with forked(tmp_path, ENDLESS) as process:
        while not (tmp_path / "begun").exists():
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate()
    assert process.returncode == pytest.ExitCode.INTERRUPTED, output
    assert (tmp_path / "tidy").exists()


def test_it_stops_after_the_first_failure_if_asked(tmp_path: Path) -> None:
    text = "import pytest\n@pytest.mark.parametrize('number', range(500))\ndef test_one(number): assert number != 3\n"
    output, _ = (process := forked(tmp_path, text, "-x")).communicate()
    assert process.returncode == pytest.ExitCode.TESTS_FAILED
    assert "stopping after 1 failures" in output


def test_a_part_begins_with_fixtures_that_no_test_has_used(tmp_path: Path) -> None:
    text = """
import pytest

@pytest.fixture(scope="module")
def before():
    return []

@pytest.mark.parametrize("number", range(500))
def test_one(number, before):
    assert before == [*range(number - number % 20, number)]
    before.append(number)
"""
    output, _ = (process := forked(tmp_path, text)).communicate()
    assert process.returncode == 0, output


def test_a_test_that_exceeds_its_limit_is_named_with_the_place_where_it_was(tmp_path: Path) -> None:
    text = "import time\ndef test_before(): pass\ndef test_endless(): time.sleep(600)\ndef test_after(): pass\n"
    options = "-p", "pytest_timeout", "--timeout-method=thread", "--timeout=0.1"
    output, _ = (process := forked(tmp_path, text, *options)).communicate()
    assert process.returncode == pytest.ExitCode.TESTS_FAILED, output
    assert "1 failed, 2 passed" in output
    assert "the process that ran this test ended with 1" in output
    assert "in test_endless\n" in output, "the stack of the thread"
