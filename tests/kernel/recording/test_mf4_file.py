"""Recordings of signals as MF4, as asammdf reads them."""

import sys
from array import array
from pathlib import Path
from typing import Any

import can  # noqa: F401  before asammdf, or its own reader of MF4 does not work
import pytest
from asammdf import MDF

from fieldrig.errors import UsageError
from fieldrig.recording import mf4_file
from fieldrig.recording.file_formats import format_of
from fieldrig.recording.mf4_file import Mf4File
from fieldrig.recording.reader import Rows
from fieldrig.recording.signals import Column, Sort

pytestmark = pytest.mark.long

COLUMNS = [
    Column("tank/level", Sort.NUMBER, "m", [], is_held=True),
    Column("io/on", Sort.TRUTH, "", [], is_held=True),
    Column("plc/state", Sort.TEXT, "", ["idle", "l\u00e4uft"], is_held=True),
]


def rows(columns: tuple[int, ...], times_ns: list[int], *values: list[float]) -> Rows:
    return Rows("p", columns, 0, 0, array("q", times_ns), [array("d", column) for column in values])


def test_each_signal_is_a_channel_with_its_instants_unit_and_type(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mf4_file, "ROWS", 2)
    path, nan = tmp_path / "x.mf4", float("nan")
    with path.open("wb") as file:
        writer = format_of(path)(file, COLUMNS, 5)
        assert isinstance(writer, Mf4File)
        writer.take(rows((0, 1), [5, 1_000_000_005, 2_000_000_005], [0.5, nan, 0.75], [0.0, 1.0, nan]))
        writer.take(rows((2,), [1_500_000_005], [1.0]))
        writer.close()
    with MDF(path) as mdf:
        found: dict[str, Any] = {column.name: mdf.get(column.name) for column in COLUMNS}
        assert "instant 0 is 5 ns" in str(mdf.header.comment)
    level, on, state = found.values()
    assert (level.timestamps.tolist(), level.unit) == ([0.0, 1.0, 2.0], "m")
    assert [str(value) for value in level.samples.tolist()] == ["0.5", "nan", "0.75"]
    assert (on.timestamps.tolist(), on.samples.tolist()) == ([0.0, 1.0], [0, 1])
    assert [text.decode() for text in state.samples.tolist()] == ["l\u00e4uft"]


def test_the_extra_is_named_where_it_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "asammdf", None)
    with (tmp_path / "x.mf4").open("wb") as file, pytest.raises(UsageError, match="MF4 needs the package asammdf"):
        Mf4File(file, COLUMNS, 0)
