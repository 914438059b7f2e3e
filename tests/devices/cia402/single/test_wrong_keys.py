"""Mistakes in the entry of a drive, each at the line of its key; power-on values are judged as a write by SDO."""

from pathlib import Path
from typing import Any

import pytest
from single_drive_bench import SingleDriveBench
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.config.rig_file import look_through

RIG = """time: virtual
buses:
  can0: {kind: can.virtual, bitrate: 1000000}
  io: {kind: wires.virtual}
devices:
  axis:
    kind: cia402.drive
    node_id: 3
    links: {can: can0, wires: io}
"""
FIRST = 10
"""Number of the first line behind `RIG`."""


def told(folder: Path, lines: str) -> list[tuple[int | None, str, str]]:
    """Line, key in the device, and words of each mistake."""
    path = folder / "rig.yaml"
    path.write_text(RIG + "".join(f"    {line}\n" for line in lines.splitlines()))
    return [
        (mistake.line, mistake.key.removeprefix("devices.axis."), f"{mistake.what}; {mistake.remedy}")
        for mistake in look_through(path)[2]
    ]


@pytest.mark.parametrize(
    ("lines", "line", "key", "remedy"),
    [
        ("low_stop_rad: 5\nhigh_stop_rad: -5", 0, "low_stop_rad", "less than -5"),
        ("boot_up_ms: 500", 0, "boot_up_ms", "write behaviour: {boot_up_ms: 500}"),
        ("initial_position_rad: 7\nhigh_stop_rad: 6", 0, "initial_position_rad", "at most 6"),
        ("high_stop_rad: 6\nlow_stop_rad: 2", None, "initial_position_rad", "at least 2"),
        ("switches:\n  hoem: {low: 0, high: 1}", 1, "switches.hoem", "home"),
        ("switches:\n  home:\n    low: 2\n    high: 1", 3, "switches.home.high", "more than low, 2"),
        ("switches:\n  home: {low: 2, high: 3}\nhome_wire: x", 2, "home_wire", "remove the wire or the switch"),
        ("motor:\n  rated_torque_nm: 2\n  peak_torque_nm: 1", 2, "motor.peak_torque_nm", "at least 2"),
        ("load:\n  stiffness_nm_per_rad: 3", 1, "load.stiffness_nm_per_rad", "inertia_kg_m2 above 0"),
    ],
)
def test_a_mistake_of_the_whole_drive_is_at_its_key(
    tmp_path: Path, lines: str, line: int | None, key: str, remedy: str
) -> None:
    ((where, what, wanted),) = told(tmp_path, lines)
    assert what == key
    assert remedy in wanted
    assert line is None or where == FIRST + line


@pytest.mark.parametrize(
    ("index", "subindex", "wrong", "right", "behaviour"),
    [
        (0x6060, 0, 55, 8, None), (0x6060, 0, 2, 3, {"modes": [1, 3]}), (0x6060, 0, -1, 1, None),
        (0x6098, 0, 36, 33, None), (0x60D0, 2, 3, 5, None), (0x60B8, 0, 0x0C, 0x18, None), (0x60F2, 0, 3, 0x42, None),
        (0x6007, 0, 4, 3, None), (0x60C2, 1, 0, 2, None), (0x1029, 1, 7, 2, None),
        (0x1400, 2, 250, 254, None), (0x1802, 2, 245, 252, None), (0x1400, 1, 0x601, 0x8000_0205, None),
    ],
)  # fmt: skip
def test_a_power_on_value_is_judged_as_a_write(
    tmp_path: Path, index: int, subindex: int, wrong: int, right: int, behaviour: dict[str, Any] | None
) -> None:
    keys: dict[str, Any] = {} if behaviour is None else {"behaviour": behaviour}
    drive, key = SingleDriveBench(**keys), f"{index:04X}:{subindex:02X}"
    given = "".join(f"{name}: {value}\n" for name, value in keys.items())
    assert drive.try_put(index, wrong, subindex) != ""
    ((where, what, wanted),) = told(tmp_path, f'{given}objects:\n  "{key}": {wrong}')
    assert (where, what) == (FIRST + given.count("\n") + 1, f"objects.{key}")
    assert "expected" in wanted
    assert drive.try_put(index, right, subindex) == ""
    assert told(tmp_path, f'{given}objects:\n  "{key}": {right}') == []


def test_reversed_software_limits_are_a_doubt_as_a_master_may_write_them(tmp_path: Path) -> None:
    lines = 'objects:\n  "607D:01": 10\n  "607D:02": -10'
    assert told(tmp_path, lines) == []
    printed = CliRunner().invoke(app, ["check", str(tmp_path / "rig.yaml")])
    assert printed.exit_code == 0
    assert "warning: " in printed.output
    assert "devices.axis.objects.607D:01: the lower software limit, 10, is above the upper one, -10" in printed.output
