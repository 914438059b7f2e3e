"""`fieldrig.covered`, and the options of pytest."""

import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

import fieldrig
from fieldrig.clock import MS

PUMP = """\
FUNCTION_BLOCK Pump
VAR_INPUT level : INT; END_VAR
VAR_OUTPUT run : BOOL; END_VAR
IF level > 80 THEN
  run := TRUE;
END_IF
END_FUNCTION_BLOCK
"""
RIG = """\
time: virtual
buses: {wires: {kind: wires.virtual}}
devices:
  card: {kind: arp, number: 1, program: small.I01, links: {wires: wires}, inputs: {I108: true}}
"""
CARD = "BEG MAIN\nAGAIN: IF F1 = ON, V1 == 2\nWAIT 0.01\nGOTO AGAIN\nEND\n"
TESTS = """\
from fieldrig.clock import MS

def test_full(fieldrig_program):
    fieldrig_program("pump.st").block("Pump")(level=90)

def test_branch(fieldrig_branch):
    rig = fieldrig_branch("rig.yaml", boot=50 * MS)
    rig.set("card/F1", 1)
    rig.run_for(50 * MS)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in (("pump.st", PUMP), ("rig.yaml", RIG), ("small.I01", CARD), ("test_it.py", TESTS)):
        (tmp_path / name).write_text(text)
    return tmp_path


def test_a_block_shows_what_its_programs_have_run(folder: Path) -> None:
    with fieldrig.covered() as seen:
        assert seen.per_cent == 100.0
        pump = fieldrig.program("pump.st").block("Pump")
        pump(level=10)
        assert seen.missed == ["pump.st:4 IF", "pump.st:5"]
        pump(level=90)
        assert (seen.missed, seen.per_cent) == ([], 100.0)
        assert "Pump" in str(seen)
        seen.write(data=folder / "d/a.json", lcov=folder / "a.info", cobertura=folder / "a.xml", html=folder / "html")
    for name in ("d/a.json", "a.info", "a.xml", "html/index.html"):
        assert b"pump.st" in (folder / name).read_bytes()


def test_what_was_seen_stays_behind_the_block(folder: Path) -> None:
    with fieldrig.covered() as seen:
        fieldrig.program("pump.st").block("Pump")(level=10)
    assert seen.missed == ["pump.st:4 IF", "pump.st:5"]
    assert seen.per_cent < 100.0
    assert "Pump" in str(seen)
    seen.write(lcov=folder / "behind.info")
    assert b"pump.st" in (folder / "behind.info").read_bytes()


def test_what_was_seen_stays_behind_a_block_that_fails(folder: Path) -> None:
    with suppress(ValueError), fieldrig.covered() as seen:
        fieldrig.program("pump.st").block("Pump")(level=10)
        raise ValueError("a test has failed")
    assert seen.missed == ["pump.st:4 IF", "pump.st:5"]


def test_what_a_branch_of_a_rig_runs_counts(folder: Path) -> None:
    with fieldrig.covered() as seen, fieldrig.Rig(fieldrig.load("rig.yaml")) as rig:
        rig.run_until(50 * MS)
        assert seen.missed == ["small.I01:2 IF"]
        with rig.branch() as branch:
            branch.set("card/F1", 1)
            branch.run_for(50 * MS)
            assert seen.missed == []


@pytest.mark.system
@pytest.mark.parametrize("processes", ["one", "each"])
def test_the_processes_of_a_virtual_rig_count(folder: Path, processes: str) -> None:
    with fieldrig.covered() as seen:
        with fieldrig.Rig(fieldrig.load("rig.yaml", [f"processes={processes}"])) as rig:
            rig.run_until(50 * MS)
        assert seen.missed == ["small.I01:2 IF"]


@pytest.mark.system
def test_pytest_shows_what_all_its_tests_have_run(folder: Path) -> None:
    options = ("--fieldrig-coverage", "--fieldrig-lcov=a.info", "--fieldrig-fail-under=99", "-p", "no:cacheprovider")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", *options],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "total 5/5 3/4 88.8" in " ".join(done.stdout.split()), done.stdout
    assert "coverage is 88.8 %: expected at least 99 %" in done.stdout
    assert done.returncode == 1
    assert (folder / "a.info").read_text().count("SF:") == 2
