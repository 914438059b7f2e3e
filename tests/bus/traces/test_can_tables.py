# ruff: noqa: E501  lines of logs are long
"""Rows of python-can's tables, CSV and SQLite, that are none."""

import io
import sqlite3
from pathlib import Path

import pytest

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.can.codec import decode, encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.traces import can_csv


def test_a_csv_line_that_is_none_is_reported() -> None:
    odd = Oddities()
    good = "1e-05,0x123,0,0,0,1,AQ==\n"
    text = f"{can_csv.HEAD}\n{good}1.0,0x123,0,0,0\n1.0,0xFFF,0,0,0,0,\n1.0,0x1,0,1,0,x,\n1.0,0x1,0,0,0,1,%%\nnan,0x1,0,0,0,0,\n"
    (found,) = can_csv.read(io.BytesIO(text.encode()), odd)
    assert (found.time_ns, decode(found.data)) == (10_000, CanFrame(0x123, b"\x01"))
    assert [(oddity.place, oddity.count) for oddity in odd] == [("line 3", 5)]


def test_a_database_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.db"
    with sqlite3.connect(path) as database:
        database.execute("CREATE TABLE people (name TEXT)")
    database.close()
    with pytest.raises(UsageError, match=r"x\.db: no such table: messages"):
        list(read(path))


COLUMNS = "ts, arbitration_id, extended, remote, error, dlc"


ENDLESS = f"""CREATE VIEW messages({COLUMNS}, data) AS
    WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT x, 1, 0, 0, 0, 0, x'' FROM c"""
LARGE = f"CREATE TABLE messages ({COLUMNS}, data BLOB GENERATED ALWAYS AS (zeroblob(500000000)))"


@pytest.mark.parametrize(
    ("statement", "expected"),
    [(ENDLESS, "messages is a view and no table"), (LARGE, "the column data of messages is computed")],
)
def test_messages_that_the_file_computes_are_refused(tmp_path: Path, statement: str, expected: str) -> None:
    path = tmp_path / "x.db"
    with sqlite3.connect(path) as database:
        database.execute(statement)
        if "TABLE" in statement:
            database.execute("INSERT INTO messages VALUES (1, 2, 0, 0, 0, 0)")
    database.close()
    with pytest.raises(UsageError, match=expected):
        list(read(path))


@pytest.mark.long
def test_pages_that_lead_to_each_other_end(tmp_path: Path) -> None:
    """All pointers of the table's root become those to one page, and all of that to a third: millions of rows."""
    path = tmp_path / "x.db"
    with sqlite3.connect(path) as database:
        database.execute("PRAGMA page_size = 512")
        database.execute(f"CREATE TABLE messages ({COLUMNS}, data)")
        row = (None,) * 7
        database.executemany("INSERT INTO messages VALUES (?, ?, ?, ?, ?, ?, ?)", [row] * 100_000)
    database.close()
    data = path.read_bytes()
    pages = [bytearray(data[start : start + 512]) for start in range(0, len(data), 512)]
    root, second, third, *_ = [number for number, page in enumerate(pages) if number and page[0] == 5]
    for number, child in ((root, second), (second, third)):
        page = pages[number]
        for place in range(int.from_bytes(page[3:5], "big")):
            at = int.from_bytes(page[12 + 2 * place : 14 + 2 * place], "big")
            page[at : at + 4] = (child + 1).to_bytes(4, "big")
    path.write_bytes(b"".join(pages))
    odd = Oddities()
    with pytest.raises(UsageError, match=r"after row \d+: .*more rows than a file of this size"):
        list(read(path, odd=odd))


def test_rows_of_a_database_may_hold_anything(tmp_path: Path) -> None:
    path, odd = tmp_path / "x.db", Oddities()
    write([TraceEntry(0, "can0", "can", "", encode(CanFrame(0x605)))], path)
    with sqlite3.connect(path) as database:
        database.executemany(
            "INSERT INTO messages VALUES (?, ?, ?, ?, ?, ?, ?)",
            [
                ("soon", 1, 0, 0, 0, 0, b""),
                (1.0, None, 0, 0, 0, 0, b""),
                (float("inf"), 1, 0, 0, 0, 0, b""),
                (1.0, 1 << 40, 0, 0, 0, 0, b""),
                (1.0, 1, 0, 0, 0, 0, bytes(100_000)),
            ],
        )
    database.close()
    assert len(list(read(path, odd=odd))) == 1
    assert [(oddity.place, oddity.count) for oddity in odd][:1] == [("row 2", 5)]
