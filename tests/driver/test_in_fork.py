"""Tests in forks, in pytest runs of their own."""

import pytest

pytest_plugins = ["pytester"]

TESTS = """
import os, pytest

pytestmark = pytest.mark.in_fork

@pytest.fixture(scope="module")
def shared():
    return [os.getpid()]

def test_adds(shared):
    shared.append(1)
    assert shared == [os.getppid(), 1]

def test_finds_what_was_made(shared):
    assert len(shared) == 1

def test_fails(shared):
    assert shared == "the wrong thing"

def test_ends(shared):
    os._exit(0)

@pytest.mark.parametrize("number", [1, 2])
def test_takes_its_parameter(number, tmp_path):
    (tmp_path / "file").touch()
    assert number > 0
"""


@pytest.mark.long
def test_each_finds_the_fixture_as_it_was_made_and_fails_by_itself(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTEST_ADDOPTS", "-p in_fork --strict-markers")
    pytester.makepyfile(TESTS)
    result = pytester.runpytest_inprocess()
    result.assert_outcomes(passed=4, failed=2)
    result.stdout.fnmatch_lines(
        ["*test_fails*", "*the wrong thing*", "*test_ends*", "the fork of this test ended before the test"]
    )
