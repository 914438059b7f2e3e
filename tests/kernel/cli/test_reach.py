"""The ways into a rig, as `up` and `help` print them."""

import sys
from pathlib import Path
from typing import Any

import pytest
from shipped import in_virtual_time

from fieldrig.cli import reach
from fieldrig.cli.display import Display
from fieldrig.cli.width import PIPE_WIDTH
from fieldrig.config.rig_file import RigConfig, load

CONFIGS = Path(__file__).parents[3] / "configs"
REAL = sorted(path for path in CONFIGS.glob("*.yaml") if "time: real" in path.read_text(encoding="utf-8"))


def rig(name: str) -> RigConfig:
    return load(CONFIGS / f"{name}.yaml")


def introduced(config: RigConfig, capsys: pytest.CaptureFixture[str]) -> list[str]:
    Display(config, 0.0, is_quiet=False).introduce(
        5, {"operate": "http://127.0.0.1:8372/?token=o", "look": "http://127.0.0.1:8372/?token=l"}
    )
    return capsys.readouterr().out.splitlines()


def lines(config: RigConfig, name: str) -> dict[str, str]:
    return {tool["label"]: tool["line"] for tool in reach.help_of(config, name)["tools"]}


def test_up_has_one_line_for_each_address_of_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    assert introduced(rig("lab"), capsys)[-3:] == [
        "page to operate: http://127.0.0.1:8372/?token=o",
        "page to look:    http://127.0.0.1:8372/?token=l",
        "",
    ]


def test_up_has_one_line_for_each_connection(capsys: pytest.CaptureFixture[str]) -> None:
    shown = introduced(rig("lab"), capsys)
    assert [line.split() for line in shown[2:6]] == [
        ["can0", "socketcand", "127.0.0.1:29536", "io,", "sensor"],
        ["can0", "Lawicel", "(slcan)", "run/lab/slcan", "io,", "sensor"],
        ["mb_tcp", "Modbus", "TCP", "127.0.0.1:5020", "drive"],
        ["mb_rtu", "Modbus", "RTU", "run/lab/modbus-rtu", "drive"],
    ]
    assert shown[7] == "devices: tank, io, sensor, drive"


@pytest.mark.long
@pytest.mark.parametrize("path", REAL, ids=lambda path: path.stem)
def test_up_stays_short_for_every_rig(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = load(path)
    shown = introduced(config, capsys)
    assert len(shown) == 8 + len(list(reach.connections(config)))
    assert max(map(len, shown)) <= PIPE_WIDTH


def test_a_rig_in_virtual_time_has_no_connections(capsys: pytest.CaptureFixture[str]) -> None:
    config = in_virtual_time("lab.yaml")
    assert list(reach.connections(config)) == []
    assert reach.help_of(config, "can0")["connections"] == []
    assert lines(config, "drive") == {"all values": "fieldrig get drive", "its faults": "fieldrig fault drive"}
    assert introduced(config, capsys)[2] == "devices: tank, io, sensor, drive"


@pytest.mark.long
@pytest.mark.parametrize("path", REAL, ids=lambda path: path.stem)
def test_every_line_has_a_label_of_its_own(path: Path) -> None:
    config = load(path)
    for name in (*config.buses, *config.devices):
        labels = [tool["label"] for tool in reach.help_of(config, name)["tools"]]
        assert len(labels) == len(set(labels)), name


def test_lines_have_absolute_paths_until_they_are_typed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    config = rig("lab")
    line = lines(config, "drive")["coils: run, alarm_reset by mb_rtu"]
    assert line.endswith(f" {tmp_path}/run/lab/modbus-rtu")
    assert reach.as_typed(line, config.control).endswith(" run/lab/modbus-rtu")
    monkeypatch.chdir("/")
    assert reach.as_typed(line, config.control) == line


def test_only_whole_paths_are_shortened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    line = f"od /srv{tmp_path}/run {tmp_path}er/run '{tmp_path}/run'"
    assert reach.as_typed(line, "") == f"od /srv{tmp_path}/run {tmp_path}er/run 'run'"


def test_tools_of_the_rig_are_given_its_endpoint() -> None:
    assert reach.as_typed("fieldrig get io", "tcp/127.0.0.1:7452").endswith("get io --control tcp/127.0.0.1:7452")
    assert reach.as_typed("fieldrig arp state", "tcp/127.0.0.1:7452").endswith("fieldrig arp state")
    assert reach.as_typed("fieldrig get io", "tcp/127.0.0.1:7447").endswith("get io")


def test_programs_that_are_missing_are_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert reach.missing_program("mbpoll -m tcp 127.0.0.1") == "mbpoll"
    assert reach.missing_program("sudo slcand -o can0") == "slcand"
    assert reach.missing_program("python -c 'import canopen'") is None
    (tmp_path / "mbpoll").symlink_to(sys.executable)
    assert reach.missing_program("mbpoll -m tcp 127.0.0.1") is None


def test_lines_for_a_missing_program_are_left_out_with_what_brings_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from fieldrig.cli.help import _show

    monkeypatch.setenv("PATH", str(tmp_path))
    found: dict[str, Any] = reach.help_of(rig("lab"), "drive")
    _show(found, "tcp/127.0.0.1:7447")
    shown = capsys.readouterr().out
    assert "\n      mbpoll" not in shown
    assert "ModbusTcpClient" in shown
    assert shown.endswith("14 more lines for mbpoll, which is not installed; on Debian: sudo apt-get install mbpoll\n")
