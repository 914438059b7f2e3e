"""`fieldrig replay`: exit codes, words, JSON, JUnit, and input that is wrong."""

import json
from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest
from recorded_logs import MS, recorded
from typer.testing import CliRunner, Result

from fieldrig import Rig
from fieldrig.cli.app import app
from fieldrig.errors import ConfigError, UsageError
from fieldrig.traces import trace_files
from fieldrig_bus.can import CanFrame

LAB = Path(__file__).parents[3] / "configs" / "lab.yaml"


def master(rig: Rig) -> None:
    can = rig.attach("plc").link("can0")
    rig.run_until(100 * MS)
    for identifier, data in ((0x000, "01 00"), (0x605, "40 00 10 00 00 00 00 00"), (0x205, "55 00 00 00")):
        can.send(CanFrame(identifier, bytes.fromhex(data)))
        rig.run_for(500 * MS)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("logs") / "lab.jsonl"
    trace_files.write(recorded(LAB, master), path)
    return path


def run(log: Path, *words: str | Path) -> Result:
    return CliRunner().invoke(app, ["replay", str(log), "--rig", str(LAB), *map(str, words)])


def test_the_exit_code_is_0_without_a_difference(log: Path) -> None:
    done = run(log)
    assert done.exit_code == 0
    assert done.stdout.startswith("no difference; 3 messages played, ")


def test_the_exit_code_is_1_with_a_difference_in_words(log: Path) -> None:
    done = run(log, "--set", "devices.io.objects.1017:00=400")
    assert done.exit_code == 1
    assert done.stdout.startswith("at 0.000 s node 5 (io) sent a heartbeat every 400 ms, the log says 1 s\n")


def test_json_has_the_differences(log: Path) -> None:
    found = json.loads(run(log, "--set", "devices.tank.initial_level_m=0.6", "--json").stdout)
    assert (found["same"], found["played"]) == (False, 3)
    keys = {value["key"]: (value["log"], value["rig"]) for each in found["differences"] for value in each["values"]}
    assert keys["6401h:01"] == (5000, 6000)


def test_junit_has_a_case_for_each_object(log: Path, tmp_path: Path) -> None:
    run(log, "--set", "devices.tank.initial_level_m=0.6", "--junit", tmp_path / "replay.xml")
    [suite] = Xml.parse(tmp_path / "replay.xml").getroot()
    cases = {case.get("name"): case.find("failure") for case in suite.findall("testcase")}
    assert cases["node 5 (io) 1000h Device type"] is None
    failed = cases["io TPDO 2"]
    assert failed is not None
    assert "6401h:01 Analogue input 1 6000, the log says 5000" in str(failed.get("message"))
    assert cases["tank tank.level"] is not None
    assert (suite.get("tests"), suite.get("failures")) == (str(len(cases)), "3")


def within(*tolerances: str) -> list[str]:
    return [word for each in tolerances for word in ("--value-tolerance", each)]


def test_tolerances_are_taken(log: Path) -> None:
    change = ("--set", "devices.tank.initial_level_m=0.501")
    assert run(log, *change).exit_code == 1
    assert run(log, *change, *within("tank.level=0.0011", "6401h:01=10", "9130h:01=1")).exit_code == 0
    assert run(log, *change, "--leave-out", "6401h:01", "--leave-out", "TPDO 1", "--leave-out", "wires").exit_code == 0


@pytest.mark.parametrize(
    "words",
    [("--time-tolerance", "soon"), ("--timeout", "5"), ("--bus", "can0"), ("--speed", "0"), ("--settle", "-1s")],
)
def test_a_wrong_option_is_wrong_usage(log: Path, words: tuple[str, str]) -> None:
    assert run(log, *words).exit_code == 2


@pytest.mark.parametrize("words", [("--value-tolerance", "6064h"), ("--value-tolerance", "=3"), ("--play", "node=0")])
def test_a_word_that_is_not_understood_is_named(log: Path, words: tuple[str, str]) -> None:
    done = run(log, *words)
    assert isinstance(done.exception, UsageError)
    assert words[1] in done.exception.what


def test_a_rig_with_mistakes_is_refused(log: Path) -> None:
    assert isinstance(run(log, "--set", "devices.io.node_id=200").exception, ConfigError)


def test_a_bus_that_is_not_there_is_refused(log: Path) -> None:
    done = run(log, "--bus", "can0=can7")
    assert isinstance(done.exception, UsageError)
    assert "can7" in done.exception.what


def test_a_file_that_is_no_log_is_named(tmp_path: Path) -> None:
    (tmp_path / "wrong.log").write_bytes(bytes(range(256)))
    done = run(tmp_path / "wrong.log")
    assert isinstance(done.exception, UsageError)
    assert "wrong.log" in done.exception.what
