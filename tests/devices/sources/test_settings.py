"""The key `source`: what may be said in it, and what is wrong with what may not."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from fieldrig import MS, S
from fieldrig.settings import Settings
from fieldrig_devices.sources.recording import Recording, read_recording
from fieldrig_devices.sources.settings import SourceSettings
from fieldrig_devices.sources.shapes import Source

ANY: TypeAdapter[Any] = TypeAdapter(SourceSettings)


def source(folder: Path | None = None, **keys: Any) -> Source:
    settings: Any = ANY.validate_python(keys, context={"folder": folder, "folders": [folder]})
    assert isinstance(settings, Settings)
    begun: Source = settings.begin("flow")  # type: ignore[attr-defined]
    return begun


def test_defaults() -> None:
    assert source(kind="square", period_ms=10.0).at(0) == 1
    assert source(kind="random_walk", low=-1.0, high=2.0, step=0.1).at(0) == 0.5
    assert source(kind="uptime").at(90 * S) == 90
    assert source(kind="clock").at(1 * S) == 1_577_836_801  # 1 January 2020, 00:00:01 UTC
    assert source(kind="constant", value=3.5).at(1 * S) == 3.5


@pytest.mark.parametrize("period_ms", [0.001, 2.0, 40.0, 100.0, 2000.0, 60_000.0])
def test_a_short_period_has_its_course_without_being_told(period_ms: float) -> None:
    """Changes every 100 ms would show a sine of 100 ms as a constant."""
    sine = source(kind="sine", low=0.0, high=1.0, period_ms=period_ms)
    ramp = source(kind="ramp", first=0.0, last=20.0, period_ms=period_ms)
    period_ns = round(period_ms * MS)
    quarters = [sine.at(period_ns * quarter // 4) for quarter in range(5)]
    assert quarters == pytest.approx([0.5, 1, 0.5, 0, 0.5])
    assert [ramp.at(period_ns * quarter // 4) for quarter in range(5)] == pytest.approx([0, 5, 10, 15, 0])


@given(st.sampled_from([1.0, 3.0, 7.0, 60_000.0, 3_600_000.0, 86_400_000.0]), st.integers(1, 100_000))
def test_an_uptime_counts_at_the_end_of_each_unit(unit_ms: float, count: int) -> None:
    """An hour of 3600 s is not a nanosecond longer because its share of a second has no end."""
    end_ns = count * round(unit_ms * MS)
    assert source(kind="uptime", unit_ms=unit_ms).at(end_ns - 1) == count - 1
    assert source(kind="uptime", unit_ms=unit_ms).at(end_ns) == count
    assert source(kind="uptime", unit_ms=unit_ms).next_ns(end_ns - 1) == end_ns


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"kind": "sine", "low": 2.0, "high": 1.0, "period_ms": 5.0}, "low 2 is above high 1"),
        ({"kind": "triangle"}, "does not match any of the expected tags"),
        (
            {"kind": "random_walk", "low": 0.0, "high": 1.0, "step": 0.1, "first": 2.0},
            "first: 2 is not between low and high",
        ),
        ({"kind": "counter", "per_s": 1e6, "step": 1e-6}, "step: these are 1e\\+12 changes a second"),
        ({"kind": "clock", "first": "yesterday"}, "expected a date such as"),
        ({"kind": "clock", "first": "9999-01-01"}, "up to the year 9000"),
        ({"kind": "sine", "low": 0.0, "high": float("inf"), "period_ms": 5.0}, "finite number"),
        ({"kind": "square", "period_ms": 0.001, "high_percent": 0.01}, "period_ms: a part of 0.001 ms is too short"),
    ],
)
def test_mistakes(keys: dict[str, Any], told: str) -> None:
    with pytest.raises(ValidationError, match=told):
        source(**keys)


def test_a_recording_is_replayed_by_its_times(tmp_path: Path) -> None:
    (tmp_path / "day.csv").write_text(
        "time;power\n2026-01-31 08:00:00;1,5\n2026-01-31 08:00:02;\n2026-01-31 08:00:03;-4"
    )
    replay = source(tmp_path, kind="replay", file="day.csv", column="power", time_column="time")
    assert [replay.at(age_s * S) for age_s in (0, 2, 3, 4, 7)] == [1.5, 1.5, -4, 1.5, -4]


def test_a_recording_without_times_is_replayed_row_by_row(tmp_path: Path) -> None:
    (tmp_path / "day.csv").write_text("a,b\n1,true\n2,false\n", encoding="utf-8-sig")
    once = source(tmp_path, kind="replay", file="day.csv", column="b", step_ms=10.0, repeats=False)
    assert [once.at(age_ms * MS) for age_ms in (0, 9, 10, 99)] == [1, 1, 0, 0]


@pytest.mark.parametrize(
    ("text", "time_column", "told"),
    [
        ("a\n1\n", "time", "there is no column 'time'"),
        ("a\n", None, "rows of values"),
        ("a\n1\nx\n", None, "line 3: expected a number in column 'a', got 'x'"),
        ("a\nnan\n", None, "line 2: expected a number"),
        ("t,a\n0,1\n0,2\n", "t", "line 3: expected a later time"),
        ("sep=;\na;b\n0,5;1\nx;1\n", None, "line 4: expected a number"),
        ("a,a\n1,2\n", None, "there are 2 columns 'a'; give each its own name"),
        ("t,a\nnoon,1\n", "t", "line 2: expected seconds or a date"),
        ("t,a\n0,\n", None, "line 2: expected a number in the first row"),
        ('a\n"' + "x" * 200_000 + '"\n', None, "line 2: field larger"),
    ],
)
def test_what_is_wrong_with_a_recording(tmp_path: Path, text: str, time_column: str | None, told: str) -> None:
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(ValueError, match=told):
        read_recording(tmp_path / "bad.csv", "a", time_column, S)


@given(text=st.text(st.sampled_from('a,;\t\n"0129.-e: '), max_size=60), timed=st.booleans())
def test_any_text_is_a_recording_or_a_mistake(tmp_path_factory: pytest.TempPathFactory, text: str, timed: bool) -> None:
    file = tmp_path_factory.getbasetemp() / "any.csv"
    file.write_text("a,b\n" + text)
    try:
        recording = read_recording(file, "b", "a" if timed else None, S)
    except ValueError:
        return
    assert isinstance(recording, Recording)
    assert len(recording.ages_ns) == len(recording.values) > 0
    assert list(recording.ages_ns) == sorted(set(recording.ages_ns))
    assert recording.ages_ns[0] == 0
