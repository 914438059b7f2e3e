"""The command `fieldrig export`: what it writes where, and what it says of what it cannot write."""

import sys
from pathlib import Path

import pytest
from shipped import CONFIGS
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig_devices.export.dbc import ENCODING


@pytest.mark.long
def test_the_command_writes_a_file_or_one_for_each_bus(tmp_path: Path) -> None:
    run = CliRunner().invoke
    one, folder = tmp_path / "lab.dbc", tmp_path / "networks"
    assert run(app, ["export", str(CONFIGS / "lab.yaml"), "--dbc", str(one)]).output == f"{one}\n"
    assert "BO_ 389 io_TPDO1: 4 io" in one.read_text(ENCODING)
    assert run(app, ["export", str(CONFIGS / "machine.yaml"), "--dbc", str(folder)]).exit_code == 0
    assert sorted(file.name for file in folder.iterdir()) == ["can0.dbc", "can1.dbc", "can2.dbc", "can3.dbc"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["machine.yaml", "--dbc", "one.dbc"], "is one file, but there are can0, can3, can1, can2"),
        (["modems.yaml", "--dbc", "none.dbc"], "has no CAN bus"),
        (["modems.yaml", "--csv", "none.csv"], "has no register table"),
        (["modems.yaml", "--markdown", "none.md"], "has no register table"),
        (["lab.yaml"], "nothing is to be written"),
        (["lab.yaml", "--dbc", "lab.txt"], "name a file that ends in .dbc, or a folder"),
        (["lab.yaml", "--markdown", "/dev/null/x.md"], "cannot be written"),
        (["lab.yaml", "--dbc", "/dev/null/x.dbc"], "cannot be written"),
    ],
)
def test_what_cannot_be_written_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["export", str(CONFIGS / arguments[0]), *arguments[1:]])
    assert result.exit_code != 0
    assert message in str(result.exception)
    assert list(tmp_path.iterdir()) == []


def test_without_cantools_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cantools.database", None)
    monkeypatch.delitem(sys.modules, "fieldrig_devices.export.dbc", raising=False)
    result = CliRunner().invoke(app, ["export", str(CONFIGS / "lab.yaml"), "--dbc", str(tmp_path / "x.dbc")])
    assert "fieldrig[dbc]" in str(result.exception)


@pytest.mark.skipif(sys.platform == "win32", reason="a limit of the size of files")
@pytest.mark.parametrize(("option", "name"), [("--dbc", "lab.dbc"), ("--csv", "lab.csv"), ("--markdown", "lab.md")])
def test_a_file_that_the_disk_does_not_take_is_not_there_in_part(tmp_path: Path, option: str, name: str) -> None:
    import resource

    (tmp_path / name).write_text("as it was", encoding="utf-8")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    try:
        result = CliRunner().invoke(app, ["export", str(CONFIGS / "lab.yaml"), option, str(tmp_path / name)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert "cannot be written: File too large" in str(result.exception)
    assert [(file.name, file.read_text("utf-8")) for file in tmp_path.iterdir()] == [(name, "as it was")]
