"""Coverage of a rig that `fieldrig up` runs: at its end, on demand, and of a process that was killed."""

import os
import re
import signal
from pathlib import Path

import pytest
from running_rig import AskedRig, until

pytestmark = pytest.mark.system

RIG = """\
time: {time}
buses: {{wires: {{kind: {wires}}}}}
devices:
  card: {{kind: arp, number: 1, program: small.I01, links: {{wires: wires}}, inputs: {{I108: true}}}}
"""
PROGRAM = """\
BEG MAIN
AGAIN: IF F1 = ON, V1 == 2
IF F2 = ON, V1 == 3
IF F3 = ON, V1 == 4
WAIT 0.01
GOTO AGAIN
END
"""
OPTIONS = ("--coverage-data", "data.json", "--fail-under", "95")


def rig_with(program: Path, time: str, wires: str) -> AskedRig:
    return AskedRig(RIG.format(time=time, wires=wires), program, *OPTIONS)


@pytest.fixture
def program(tmp_path: Path) -> Path:
    file = tmp_path / "small.I01"
    file.write_text(PROGRAM)
    return file


def total(text: str) -> str:
    found = re.search(r"^total +(.*)$", text, re.MULTILINE)
    assert found is not None, text
    return " ".join(found[1].split())


def test_a_killed_process_keeps_what_it_has_run_and_a_restarted_one_adds_to_it(program: Path) -> None:
    with rig_with(program, "real", "wires.hub") as rig:
        rig.until_ready()
        until(lambda: total(rig.tool("coverage").stdout) == "5/5 3/6 72.7")  # the card starts its program by itself
        rig.set("card/F1", 1)
        until(lambda: total(rig.tool("coverage").stdout) == "5/5 4/6 81.8")
        os.kill(rig.pid("card"), signal.SIGKILL)
        rig.until_back("card")
        assert total(rig.tool("coverage").stdout) == "5/5 4/6 81.8"
        rig.set("card/F2", 1)
        until(lambda: rig.get("card/V1") == 3)
        assert rig.end() == 1
        assert total(rig.output()) == "5/5 5/6 90.9"
        assert "coverage is 90.9 %: expected at least 95 %" in rig.output()
        assert total(rig.tool("coverage", "data.json").stdout) == "5/5 5/6 90.9"


def test_runs_add_up(program: Path) -> None:
    with rig_with(program, "virtual", "wires.virtual") as rig:
        rig.until_ready()
        rig.set("card/F3", 1)
        until(lambda: rig.get("card/V1") == 4)
        assert rig.end() == 1
        (rig.folder / "data.json").rename(rig.folder / "first.json")
        rig.process = rig.up("--coverage-data", "second.json")
        rig.until_ready()
        rig.tool("set", "card/F1=1")
        until(lambda: rig.value("card/V1") == 2)
        assert total(rig.tool("coverage").stdout) == "5/5 4/6 81.8"
        assert rig.end() == 0
        done = rig.tool("coverage", "first.json", "second.json", "--lcov", "both.info")
        assert total(done.stdout) == "5/5 5/6 90.9"
        assert "BRH:5" in (rig.folder / "both.info").read_text()


def test_a_rig_without_marks_says_so() -> None:
    with AskedRig(RIG.format(time="virtual", wires="wires.virtual").replace("program: small.I01, ", ""), None) as rig:
        rig.until_ready()
        done = rig.tool("coverage")
        assert done.returncode == 6, done
        assert "the programs of this rig have no marks" in done.stderr
