"""JSON for scripts is JSON in every encoding of the output, and completion takes the separators of the system."""

import io
import json
import os
from pathlib import Path

import pytest

from fieldrig.cli.common import echo_json
from fieldrig.cli.completion import rig_file

VALUE = {"unit": "°C", "name": "Förderer →"}


@pytest.mark.parametrize("encoding", ["utf-8", "UTF8", "cp1252", "ascii", "cp437"])
def test_json_is_json_in_every_encoding(monkeypatch: pytest.MonkeyPatch, encoding: str) -> None:
    written = io.BytesIO()
    with io.TextIOWrapper(written, encoding=encoding, errors="backslashreplace") as out:
        monkeypatch.setattr("sys.stdout", out)
        echo_json(VALUE)
        out.flush()
        assert json.loads(written.getvalue().decode(encoding)) == VALUE


def test_a_path_is_completed_by_the_separators_of_the_system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "rigs").mkdir()
    (tmp_path / "rigs" / "lab.yaml").touch()
    monkeypatch.chdir(tmp_path)
    assert rig_file("rigs/l") == ["rigs/lab.yaml"]
    monkeypatch.setattr(os, "sep", "\\")
    assert rig_file("rigs\\l") == ["rigs/lab.yaml"]
