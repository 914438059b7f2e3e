"""Timing diagrams of wires: what is drawn where, and `fieldrig draw`."""

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS, S
from fieldrig.errors import UsageError
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import write
from fieldrig_bus.signals.codec import encode
from fieldrig_bus.traces.draw_command import draw
from fieldrig_bus.traces.timing_diagram import RIGHT, Window, steps_in, ticks, timing_diagram
from fieldrig_bus.traces.waves import Wave
from fieldrig_bus.wires import Signal

SVG = "{http://www.w3.org/2000/svg}"
DAY_NS = 1_700_000_000_000_000_000


def wave(*changes: tuple[int, Any], name: str = "cell.valve", unit: str = "") -> Wave:
    return Wave("wires", name, unit, list(changes))


def drawn(window: Window, *waves: Wave) -> tuple[dict[str, list[list[tuple[float, float]]]], list[str]]:
    """The lines of a picture by their class, and its texts."""
    root = ElementTree.fromstring(timing_diagram(waves, window, "title", "about"))
    lines: dict[str, list[list[tuple[float, float]]]] = {}
    for path in root.iter(f"{SVG}path"):
        points = re.findall(r"(-?[\d.]+) (-?[\d.]+)", path.attrib["d"])
        lines.setdefault(path.attrib["class"], []).append([(float(x), float(y)) for x, y in points])
    return lines, [text.text or "" for text in root.iter(f"{SVG}text")]


def test_a_digital_wire_is_low_and_high_with_edges_between() -> None:
    lines, texts = drawn(Window(0, 10), wave((0, False), (4, True), (6, False), name="ab"))
    (line,) = lines["curve"]
    left = line[0][0]
    rise, fall = left + (RIGHT - left) * 0.4, left + (RIGHT - left) * 0.6
    assert [x for x, _ in line] == pytest.approx([left, rise, rise, fall, fall, RIGHT], abs=0.1)
    low, high = line[0][1], line[2][1]
    assert [y for _, y in line] == [low, low, high, high, low, low]
    assert high < low  # y grows downwards
    assert "ab" in texts


def test_a_number_is_a_line_of_steps_with_its_values() -> None:
    lines, texts = drawn(Window(0, 100), wave((0, 0), (50, 10), (75, 2.5), name="level", unit="m"))
    (line,) = lines["second"]
    lowest, highest = line[0][1], line[2][1]
    assert line[-1][1] == pytest.approx(lowest + (highest - lowest) / 4, abs=0.1)
    assert {"level", "m", "0", "10", "2.5"} <= set(texts)


def test_a_window_begins_with_the_values_that_the_wires_have_then() -> None:
    changes = wave((0, 1), (5, 2), (20, 3), (99, 4))
    assert steps_in(changes, Window(10, 30)) == [(0.0, 2), (RIGHT / 2, 3)]
    assert steps_in(changes, Window(20, 30)) == [(0.0, 3)]
    assert steps_in(wave((50, True)), Window(0, 49)) == []


def test_a_value_that_is_sent_again_is_no_change() -> None:
    assert steps_in(wave((0, True), (5, True), (10, False)), Window(0, 10)) == [(0.0, True), (RIGHT, False)]


def test_a_burst_is_one_stroke_between_its_lowest_and_its_highest_value() -> None:
    burst = [(500_000 + number, number % 100) for number in range(1000)]
    found = steps_in(wave((0, 7), *burst), Window(0, 1_000_000_000))
    assert len(found) <= 5
    assert {value for _, value in found} >= {0, 99}
    assert found[-1][1] == burst[-1][1]


@pytest.mark.parametrize(
    ("window", "numbers"),
    [
        (Window(0, 10 * S), ["0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10"]),
        (Window(1200 * MS, 1500 * MS), ["1200", "1250", "1300", "1350", "1400", "1450", "1500"]),
        (Window(DAY_NS + 3, DAY_NS + 8, DAY_NS), ["3", "4", "5", "6", "7", "8"]),
        (Window(0, 1), ["0", "1"]),
        (Window(0, 12_500), ["0", "2", "4", "6", "8", "10", "12"]),
    ],
)
def test_the_axis_has_round_numbers_in_a_unit_that_fits(window: Window, numbers: list[str]) -> None:
    assert [number for _, number in ticks(window)] == numbers


VALUE = st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats(allow_nan=False, allow_infinity=False)
CHANGES = st.lists(st.tuples(st.integers(0, 2**62), VALUE), max_size=20).map(
    lambda found: sorted(found, key=lambda c: c[0])
)
WAVES = st.lists(st.builds(Wave, st.text(), st.text(max_size=60), st.text(max_size=9), CHANGES), min_size=1, max_size=4)


@given(WAVES, st.integers(0, 2**62), st.integers(1, 2**62))
@settings(deadline=None)
def test_every_picture_is_xml_within_its_sheet(waves: list[Wave], start_ns: int, length_ns: int) -> None:
    window = Window(start_ns, start_ns + length_ns)
    text = timing_diagram(waves, window, "title", "about")
    height = float(ElementTree.fromstring(text.encode("utf-8", "replace")).attrib["viewBox"].split()[3])
    lines, _ = drawn(window, *waves)
    for points in (points for style in ("curve", "second") for points in lines.get(style, [])):
        assert all(20 <= x <= RIGHT and 0 <= y <= height for x, y in points)
        assert [x for x, _ in points] == sorted(x for x, _ in points)


# fieldrig draw


@pytest.fixture
def source(tmp_path: Path) -> Path:
    signals = [
        (0, Signal("cell.valve", True)),
        (S, Signal("tank.level", 0.5, "m")),
        (2 * S, Signal("cell.valve", False)),
    ]
    entries = [TraceEntry(time_ns, "wires", "wires", "x", encode(signal)) for time_ns, signal in signals]
    write([*entries, TraceEntry(5 * S, "can0", "can", "io", b"")], tmp_path / "lab.jsonl")
    return tmp_path / "lab.jsonl"


def run(source: Path, *wires: str, target: str = "x.svg", **options: str) -> str:
    draw(source, source.parent / target, list(wires) or None, options.get("begin"), options.get("end"))
    return (source.parent / target).read_text(encoding="utf-8")


def test_draw_shows_all_wires_until_the_last_message(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = run(source)
    assert ">cell.valve</text>" in text
    assert ">tank.level</text>" in text
    assert capsys.readouterr().err.endswith("x.svg: 2 wires from 0 s to 5 s\n")


def test_draw_shows_chosen_wires_of_a_time(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = run(source, "tank.*", begin="500ms", end="1.5s")
    assert "cell.valve" not in text
    assert "The values of tank.level from 0.5 s to 1.5 s." in text
    assert capsys.readouterr().err.endswith("x.svg: 1 wire from 0.5 s to 1.5 s\n")


def test_draw_refuses_what_it_cannot_draw(source: Path) -> None:
    with pytest.raises(UsageError, match=r"there is no wire 'pump'\n  there are: cell\.valve, tank\.level"):
        run(source, "pump")
    with pytest.raises(UsageError, match="there is nothing to draw from 6 s to 5 s"):
        run(source, begin="6s")
    with pytest.raises(UsageError, match=r"expected a name that ends in \.svg"):
        run(source, target="x.png")
    source.write_text(source.read_text(encoding="utf-8").splitlines()[-1], encoding="utf-8")
    with pytest.raises(UsageError, match="there is no message of a bus of wires"):
        run(source)
    source.write_text("{}", encoding="utf-8")
    with pytest.raises(UsageError, match="line 1 is not a message of a trace"):
        run(source)
