"""The functions of edition 3 for the parts of dates, against the calendar of Python."""

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st
from library_bench import Bench

from fieldrig_devices.iec.dialect import EDITION_3

BENCH = Bench(
    """PROGRAM PLC_PRG
    VAR
        given, made : DT; day : DATE; again : DATE; clock : TOD;
        y, m, d, h, mi, s, ms, week : INT;
    END_VAR
    SPLIT_DT(given, YEAR => y, MONTH => m, DAY => d, HOUR => h, MINUTE => mi, SECOND => s, MILLISECOND => ms);
    made := CONCAT_DT(y, m, d, h, mi, s, ms);
    day := DT_TO_DATE(given);
    again := CONCAT_DATE(YEAR := y, MONTH := m, DAY := d);
    clock := CONCAT_TOD(h, mi, s, 250);
    week := DAY_OF_WEEK(day);
    END_PROGRAM
    """,
    EDITION_3,
)
LAST = 2**32 - 1


@pytest.mark.parametrize("seconds", [0, 5_097_599, 951_782_400, 951_868_800, 4_107_542_399, LAST])
def test_parts_at_the_ends_of_years_and_of_february(seconds: int) -> None:
    check(seconds)


@given(st.integers(0, LAST))
def test_parts_of_any_date(seconds: int) -> None:
    check(seconds)


def check(seconds: int) -> None:
    BENCH.write("PLC_PRG.given", seconds)
    BENCH.call(0)
    wanted = datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=seconds)
    found = [BENCH.read(f"PLC_PRG.{name}") for name in ("y", "m", "d", "h", "mi", "s", "ms")]
    assert found == [wanted.year, wanted.month, wanted.day, wanted.hour, wanted.minute, wanted.second, 0]
    assert BENCH.read("PLC_PRG.made") == seconds
    assert BENCH.read("PLC_PRG.again") == BENCH.read("PLC_PRG.day") == seconds - seconds % 86_400
    assert BENCH.read("PLC_PRG.week") == wanted.isoweekday() % 7
    assert BENCH.read("PLC_PRG.clock") == seconds % 86_400 * 1_000 + 250
