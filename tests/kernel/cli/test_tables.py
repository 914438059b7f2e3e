"""Tables of the command line with many parts, long names and long values: on a narrow terminal and in a pipe."""

import re
from typing import Any

import pytest

from fieldrig.cli import help as help_command
from fieldrig.cli import status
from fieldrig.cli.common import echo_table
from fieldrig.text.listed import listed

TERMINAL = 80
DEVICES = [f"device_with_a_long_name_{number:03}" for number in range(500)]
BUSES = [f"a_rather_long_name_of_a_bus_{number}" for number in range(4)]


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make every output that of a terminal of 80 columns."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", str(TERMINAL))
    monkeypatch.delenv("NO_COLOR", raising=False)


def shown(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return re.sub(r"\x1b\[[0-9;]*m", "", capsys.readouterr().out).splitlines()


def rig_in_one_process() -> dict[str, Any]:
    process = {
        "state": "ready",
        "pid": 123456,
        "uptime_s": 4000.5,
        "restarts": 12,
        "memory_mb": 131.5,
        "own_mb": 12.3,
        "cpu_s": 1234.567,
        "devices": DEVICES,
        "buses": BUSES,
    }
    statistics = {"frames": 12345678, "load_percent": 12.5, "errors": 12}
    return {
        "rig": "big",
        "state": "ready",
        "uptime_s": 4000.5,
        "time": "real",
        "file": "big.yaml",
        "processes": {"all_devices": process},
        "devices": DEVICES,
        "buses": {bus: {"kind": "can.hub", "statistics": statistics} for bus in BUSES},
    }


def test_status_of_500_devices_in_a_pipe_has_short_lines_without_blanks_at_their_end(
    capsys: pytest.CaptureFixture[str],
) -> None:
    status._show(rig_in_one_process())
    lines = shown(capsys)
    assert max(map(len, lines)) < 140
    assert [line for line in lines if line != line.rstrip()] == []
    assert "a_rather_long_name_of_a_bus_0 and 503 more" in "\n".join(lines)


def test_status_of_500_devices_fits_on_a_terminal(terminal: None, capsys: pytest.CaptureFixture[str]) -> None:
    status._show(rig_in_one_process())
    lines = shown(capsys)
    assert max(map(len, lines)) <= TERMINAL
    assert len(lines) < 24


@pytest.mark.parametrize("width", [40, 80, 200])
def test_a_folded_cell_keeps_all_its_characters(
    width: int, terminal: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    value = "x" * 150
    echo_table(("key", "value", "took"), [("speed", value, "1 h 06 min")])
    text = "".join(shown(capsys))
    assert text.count("x") == len(value)
    assert "1 h 06 min" in text


def test_a_long_cell_of_a_pipe_stays_in_its_line(capsys: pytest.CaptureFixture[str]) -> None:
    value = "word " * 5000
    echo_table(("key", "value"), [("speed", value.strip())])
    assert len(shown(capsys)) == 2


def test_an_empty_table_has_its_headings(capsys: pytest.CaptureFixture[str]) -> None:
    echo_table(("key", "value"), [])
    assert shown(capsys) == ["key  value"]


def test_help_of_a_bus_names_the_devices_that_fit(capsys: pytest.CaptureFixture[str]) -> None:
    answer = {"name": "can0", "kind": "can.hub", "sort": "bus", "linked": DEVICES, "connections": [], "tools": []}
    help_command._show(answer, "tcp/127.0.0.1:7447")
    lines = shown(capsys)
    assert max(map(len, lines)) <= 100
    assert lines[0].endswith(" and 498 more")


@pytest.mark.parametrize(
    ("names", "room", "expected"),
    [
        (["a", "b"], 4, "a, b"),
        (["a", "b", "c"], 12, "a, b, c"),
        (["aaaa", "bbbb", "cccc"], 12, "aaaa and 2 more"),
        (["a" * 30], 12, "a" * 30),
        ([], 12, ""),
    ],
)
def test_names_that_fit(names: list[str], room: int, expected: str) -> None:
    assert listed(names, room) == expected
