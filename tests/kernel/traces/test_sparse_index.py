"""A jump to a time in a long log: the same messages as without it, and hardly anything read."""

from pathlib import Path

import pytest

from fieldrig.clock import MS, S
from fieldrig.traces import sparse_index
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write

pytestmark = pytest.mark.long

COUNT = 3_000
FORMATS = [".log", ".jsonl", ".csv", ".asc"]


def entries(begin_ns: int) -> list[TraceEntry]:
    """Messages that are out of order by a little."""
    head = bytes.fromhex("2301000001")
    times_ns = [begin_ns + number * 7 * MS - number % 3 * MS for number in range(COUNT)]
    return [TraceEntry(time_ns, "can0", "can", "", head + bytes([n & 255])) for n, time_ns in enumerate(times_ns)]


@pytest.fixture(autouse=True)
def small_logs_count_as_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sparse_index, "SMALLEST", 1)
    monkeypatch.setattr(sparse_index, "PLACES", 50)


@pytest.mark.parametrize("ending", FORMATS)
@pytest.mark.parametrize("begin_ns", [3 * S, 1_700_000_000 * S])
def test_a_part_is_the_same_with_and_without_a_jump(
    ending: str, begin_ns: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, jumps = tmp_path / f"x{ending}", 0
    write(entries(begin_ns), path)
    if ending == ".asc":  # another program does not name its buses
        path.write_text(
            path.read_text(encoding="utf-8").replace('// fieldrig: channel 1 is "can0"\n', ""), encoding="utf-8"
        )
    for from_ns in range(0, 24 * S, 1_531 * MS):
        odd = Oddities()
        found = list(read(path, from_ns, S, odd))
        jumps += odd.jumped_to is not None
        monkeypatch.setattr(sparse_index, "SMALLEST", 1 << 40)
        assert found == list(read(path, from_ns, S))
        monkeypatch.setattr(sparse_index, "SMALLEST", 1)
        assert not [oddity for oddity in odd if "jumps forward" in oddity.what]
    assert jumps > 8


def test_a_log_whose_clock_was_set_back_is_read_from_its_beginning(tmp_path: Path) -> None:
    path, odd = tmp_path / "x.log", Oddities()
    sent = entries(1_700_000_000 * S)
    write([*sent, *sent], path)
    assert len(list(read(path, 10 * S, S, odd))) == 2 * len(
        [one for one in sent if 10 * S <= one.time_ns % (100_000 * S) < 11 * S]
    )
    assert odd.jumped_to is None


def test_a_place_after_a_jump_says_where_it_counts_from(tmp_path: Path) -> None:
    path, odd = tmp_path / "x.log", Oddities()
    write(entries(1_700_000_000 * S), path)
    path.write_bytes(path.read_bytes()[:-3])
    assert list(read(path, 20 * S, None, odd))
    (cut,) = (oddity for oddity in odd if "no end" in oddity.what)
    assert f" of the part from byte {odd.jumped_to}" in cut.place


def test_a_log_that_names_its_buses_later_is_read_from_its_beginning(tmp_path: Path) -> None:
    path, odd = tmp_path / "x.asc", Oddities()
    sent = [one._replace(bus="axis") for one in entries(1_700_000_000 * S)]
    write(sent, path)
    assert {one.bus for one in read(path, 10 * S, S, odd)} == {"axis"}
    assert odd.jumped_to is None
