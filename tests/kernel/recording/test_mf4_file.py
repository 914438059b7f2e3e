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
from fieldrig.recording.mf4_file import EXACT, Mf4File
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


INT, UINT = 1 << 63, 1 << 64
WHOLE = [
    ([INT - 1, -INT, EXACT + 1, 0], "int64"),
    ([UINT - 1, 0, EXACT + 1, 1 << 60], "uint64"),
    ([UINT - 1, -1, 0, 0], "float64"),
    ([EXACT + 1, 0.5, 0, 0], "float64"),
    ([EXACT + 1, float("inf"), 0, 0], "float64"),
    ([UINT, 0, 0, 1], "float64"),
    ([EXACT, 1, -EXACT, 2], "float64"),
]


@pytest.mark.parametrize(("numbers", "kind"), WHOLE)
def test_whole_numbers_of_64_bits_and_instants_are_exact(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, numbers: list[float], kind: str
) -> None:
    """The exact number is beside the float that rounds it, if it does, as in `Recording.whole`."""
    monkeypatch.setattr(mf4_file, "ROWS", 3)
    path, begin_ns = tmp_path / "x.mf4", 1_700_000_000_123_456_789
    times_ns = [begin_ns + 1 + number * 10_000_000_000_000_001 for number in range(5)]
    values = [*numbers, float("nan")]
    whole = {(0, row): each for row, each in enumerate(values) if isinstance(each, int) and float(each) != each}
    with path.open("wb") as file:
        writer = Mf4File(file, [Column("plc/count", Sort.NUMBER, "", [], is_held=True)], begin_ns)
        writer.take(Rows("p", (0,), 0, 0, array("q", times_ns), [array("d", values)], whole))
        writer.close()
    with MDF(path) as mdf:
        found: Any = mdf.get("plc/count")
        raw: Any = mdf.get(group=0, index=mdf.masters_db[0], raw=True)
    assert found.samples.dtype.name == kind
    assert raw.samples.tolist() == [each - begin_ns for each in times_ns]
    if kind == "float64":
        assert found.samples.tolist()[:4] == [float(each) for each in numbers]
        assert found.samples.tolist()[4] != found.samples.tolist()[4]
    else:
        assert found.samples.tolist() == numbers
        assert len(found.timestamps) == 4  # where it has no value it is invalid


def test_the_extra_is_named_where_it_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "asammdf", None)
    with (tmp_path / "x.mf4").open("wb") as file, pytest.raises(UsageError, match="MF4 needs the package asammdf"):
        Mf4File(file, COLUMNS, 0)
