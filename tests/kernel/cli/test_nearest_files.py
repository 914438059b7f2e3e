"""A file that is not there is answered with the nearest one in its folder, by each command that reads files."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from fieldrig.cli.app import app

FILES = (
    "io32.eds",
    "meter.csv",
    "night.jsonl",
    "pid.st",
    "found.sqlite",
    "lab.yaml",
    "line.arp",
    "cutter.pam",
    "run.py",
)


@pytest.mark.parametrize(
    ("command", "near"),
    [
        (["new", "--eds", "oi32.eds"], "io32.eds"),
        (["new", "--registers", "metre.csv"], "meter.csv"),
        (["new", "--from", "nigth.jsonl"], "night.jsonl"),
        (["eds", "check", "oi32.eds"], "io32.eds"),
        (["trace", "show", "nihgt.jsonl"], "night.jsonl"),
        (["trace", "convert", "nihgt.jsonl", "x.log"], "night.jsonl"),
        (["diff", "nihgt.jsonl", "night.jsonl"], "night.jsonl"),
        (["replay", "nihgt.jsonl", "--rig", "lba.yaml"], "lab.yaml"),
        (["check", "lba.yaml"], "lab.yaml"),
        (["export", "lba.yaml", "--dbc", "x.dbc"], "lab.yaml"),
        (["scenario", "run", "lba.yaml"], "lab.yaml"),
        (["search", "run", "lba.yaml"], "lab.yaml"),
        (["search", "show", "fuond.sqlite"], "found.sqlite"),
        (["iec", "test", "pdi.st"], "pid.st"),
        (["iec", "check", "pdi.st"], "pid.st"),
        (["iec", "run", "pdi.st"], "pid.st"),
        (["arp", "check", "lien.arp"], "line.arp"),
        (["pam", "check", "cuter.pam"], "cutter.pam"),
        (["coverage", "nigth.jsonl"], "night.jsonl"),
        (["exec", "lba.yaml", "--", "run.py"], "lab.yaml"),
    ],
)
def test_the_nearest_file_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: list[str], near: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in FILES:
        (tmp_path / name).write_text("")
    done = CliRunner().invoke(app, command)
    said = f"{done.output} {done.exception}"
    assert f"did you mean {near}?" in said, said
