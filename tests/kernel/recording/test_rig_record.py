"""`Rig.record`: what is sampled, when, and that the rig is the same with it and without."""

import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from vcd_reader import VCDVCD

from fieldrig import MS, US, ArgumentError, ControlError, Rig, S, from_dict
from fieldrig.recording.recording import Recording

HERE = Path(__file__).parent
BEATS: dict[str, Any] = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {
        "beat": {"kind": "record_kinds:Beat", "links": {"wires": "wires"}},
        "slow": {"kind": "record_kinds:Beat", "cycle_ms": 30, "links": {"wires": "wires"}},
        "shifting": {"kind": "record_kinds:Shifting"},
        "ramp": {"kind": "record_kinds:Ramp"},
    },
}


@pytest.fixture
def rig() -> Iterator[Rig]:
    with Rig(from_dict(BEATS, HERE)) as rig:
        yield rig


def test_a_device_is_sampled_at_the_end_of_each_of_its_cycles(rig: Rig) -> None:
    recording = rig.record(["beat/count", "slow/count"])
    rig.run_for(95 * MS)
    assert list(recording.times_ns["beat/count"]) == [number * 10 * MS for number in range(1, 10)]
    assert list(recording.values["beat/count"]) == [1, 2, 3, 4, 5, 6, 7, 8, 9]
    assert list(recording.times_ns["slow/count"]) == [30 * MS, 60 * MS, 90 * MS]
    rig.run_for(10 * MS)
    assert list(recording.values["beat/count"]) == [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]


@pytest.mark.parametrize("rhythm", ["cycle", "change", 5 * MS])
def test_whole_numbers_beyond_every_float_are_exact_in_the_recording_and_in_its_files(
    rig: Rig, rhythm: Any, tmp_path: Path
) -> None:
    big = [2**53 + 1, -(2**63) + 1, 2**64 - 1, 2**60, 5]
    recording = rig.record(["beat/offset", "beat/count"], rhythm)
    for value in big:
        rig.run_for(10 * MS)
        rig.set("beat", "offset", value)
    rig.run_for(10 * MS)
    exact = recording.whole["beat/offset"]
    found = [exact.get(place, value) for place, value in enumerate(recording.values["beat/offset"])]
    assert list(dict.fromkeys(found)) == [0, *big]
    assert recording.whole["beat/count"] == {}
    recording.write_csv(tmp_path / "a.csv")
    recording.write_vcd(tmp_path / "a.vcd")
    fields = [line.split(",")[1] for line in (tmp_path / "a.csv").read_text().splitlines()[1:]]
    assert list(dict.fromkeys(field for field in fields if field)) == ["0", *map(str, big)]
    changes = re.findall(r"^r(-?[\d.]+) ", (tmp_path / "a.vcd").read_text(), re.MULTILINE)
    assert [value for value in changes if value in map(str, big)] == list(map(str, big[:-1])), "5 is 5.0 there"


def test_a_device_without_a_cycle_is_sampled_once_in_a_millisecond(rig: Rig) -> None:
    rig.run_for(300 * US)
    recording = rig.record("ramp/millis")
    rig.run_for(3 * MS)
    assert list(recording.values["ramp/millis"]) == [1.0, 2.0, 3.0]
    assert list(recording.times_ns["ramp/millis"]) == [MS, 2 * MS, 3 * MS]


def test_a_device_whose_cycle_rests_is_sampled_ten_times_a_second(rig: Rig) -> None:
    fault = rig.add_fault("beat", {"what": "power_off"})
    recording = rig.record("beat/count")
    rig.run_for(S)
    assert len(recording.values["beat/count"]) == 10
    assert all(map(math.isnan, recording.values["beat/count"]))
    rig.clear_fault("beat", fault)
    rig.run_for(50 * MS)
    assert list(recording.values["beat/count"])[10:] == [1, 2, 3, 4, 5]


def test_a_period_samples_all_signals_at_the_same_instants_with_what_happened_at_them(rig: Rig) -> None:
    recording = rig.record(["beat/count", "ramp/millis"], 25 * MS)
    rig.run_for(100 * MS)
    instants = [25 * MS, 50 * MS, 75 * MS, 100 * MS]
    assert list(recording.times_ns["beat/count"]) == list(recording.times_ns["ramp/millis"]) == instants
    assert list(recording.values["beat/count"]) == [2, 5, 7, 10]
    assert list(recording.values["ramp/millis"]) == [25, 50, 75, 100]


@pytest.mark.parametrize("processes", ["one", "each"])
@pytest.mark.long
def test_every_change_is_recorded_also_a_pulse_within_a_reaction(processes: str) -> None:
    with Rig(from_dict({**BEATS, "processes": processes}, HERE)) as rig:
        recording = rig.record(["beat/pulse", "slow/count"], "change")
        rig.run_for(100 * MS)
        pulses = zip(recording.times_ns["beat/pulse"], recording.values["beat/pulse"], strict=True)
        assert list(pulses) == [(0, 0), (50 * MS, 1), (50 * MS, 0), (100 * MS, 1), (100 * MS, 0)]
        assert list(recording.times_ns["slow/count"]) == [0, 30 * MS, 60 * MS, 90 * MS]


def test_wires_are_recorded_at_their_changes(rig: Rig) -> None:
    rig.run_for(30 * MS)
    recording = rig.record(["wires/beat.count", "wires/slow.count", "beat/count"])
    rig.run_for(30 * MS)
    assert list(recording.times_ns["wires/beat.count"]) == [30 * MS, 40 * MS, 50 * MS, 60 * MS]
    assert list(recording.values["wires/beat.count"]) == [3, 4, 5, 6]
    assert list(recording.values["wires/slow.count"]) == [1, 2]
    assert [column.unit for column in recording.columns] == ["1", "1", "1"]
    sampled = rig.record("wires/beat.count", 20 * MS)
    rig.run_for(40 * MS)
    assert list(sampled.values["wires/beat.count"]) == [8, 10]


def test_a_wire_has_the_value_that_its_receivers_get(rig: Rig) -> None:
    rig.run_for(30 * MS)
    sampled, changes = rig.record("wires/beat.count", 10 * MS), rig.record("wires/beat.count", "change")
    stuck = rig.add_fault("wires", {"what": "stuck", "wire": "beat.count", "value": 77})
    rig.run_for(20 * MS)
    rig.clear_fault("wires", stuck)
    rig.run_for(20 * MS)
    assert list(sampled.values["wires/beat.count"]) == [77, 77, 6, 7]
    assert list(changes.values["wires/beat.count"])[-2:] == [6, 7]
    assert 77 in changes.values["wires/beat.count"]
    for recording in (sampled, changes):
        recording.end()


def test_texts_are_recorded_as_their_places(rig: Rig) -> None:
    recording = rig.record(["beat/word", "beat/level"])
    rig.run_for(30 * MS)
    words, levels = recording.columns
    assert [words.states[int(value)] for value in recording.values["beat/word"]] == ["odd", "even", "odd"]
    assert list(recording.values["beat/level"]) == [2, 0, 2]
    assert levels.states == ["low", "mid", "high"]


def test_a_number_that_becomes_a_text_or_too_large_has_no_value(rig: Rig) -> None:
    recording = rig.record(["beat/offset", "beat/count"])
    rig.set("beat/offset", "far")
    rig.run_for(10 * MS)
    rig.set("beat/offset", 10**400)
    rig.run_for(10 * MS)
    rig.set("beat/offset", True)
    rig.run_for(10 * MS)
    assert [math.isnan(value) or value for value in recording.values["beat/offset"]] == [True, True, 1.0]
    assert list(recording.values["beat/count"]) == [1, 2, 3]


def test_points_that_were_made_anew_are_read(rig: Rig) -> None:
    recording = rig.record("beat/count")
    rig.run_for(20 * MS)
    rig.set("beat/offset", "new")
    rig.run_for(10 * MS)
    rig.restart("beat")
    rig.run_for(20 * MS)
    assert list(recording.values["beat/count"]) == [1, 2, -3, 1, 2]


def test_a_point_that_has_gone_has_no_value_any_more(rig: Rig) -> None:
    recording = rig.record(["shifting/left", "shifting/right"])
    rig.run_for(6 * MS)
    assert list(recording.values["shifting/right"]) == [3, 4, 5, 6, 7, 8]
    assert list(recording.values["shifting/left"])[:3] == [1, 1, 1]
    assert all(map(math.isnan, list(recording.values["shifting/left"])[3:]))


def test_what_was_recorded_is_there_when_the_rig_is_closed(rig: Rig) -> None:
    recordings = [rig.record("beat/count", rhythm) for rhythm in ("cycle", 10 * MS, "change")]
    rig.run_for(20 * MS)
    rig.close()
    assert [list(recording.values["beat/count"]) for recording in recordings] == [[1, 2], [1, 2], [0, 1, 2]]
    for recording in recordings:
        recording.end()


def test_two_recordings_run_beside_each_other_and_end_alone(rig: Rig) -> None:
    first, second = rig.record("beat/count"), rig.record(["beat/count", "slow/count"])
    rig.run_for(20 * MS)
    first.end()
    rig.run_for(20 * MS)
    assert list(first.values["beat/count"]) == [1, 2]
    assert list(second.values["beat/count"]) == [1, 2, 3, 4]


@pytest.mark.parametrize("rhythm", ["cycle", "change", 3 * MS])
def test_the_trace_is_the_same_with_a_recording(rhythm: Any) -> None:
    signals = ["beat/count", "slow/word", "ramp/millis", "wires/beat.count"]

    def trace(begin: Callable[[Rig], object]) -> list[Any]:
        heard: list[Any] = []
        with Rig(from_dict(BEATS, HERE), on_delivery=lambda bus, delivery: heard.append((bus.name, delivery))) as rig:
            rig.run_for(15 * MS)
            begin(rig)
            rig.run_for(300 * MS)
        return heard

    assert trace(lambda rig: rig.record(signals, rhythm)) == trace(lambda rig: None)


@pytest.mark.parametrize(
    ("signal", "said"),
    [
        ("beat/cont", "beat has no value 'cont'"),
        ("bet/count", "the rig has no device or bus 'bet'"),
        ("wires/beat.cont", "nothing drives 'beat.cont' on wires"),
        ("beat", "'beat' is not a signal"),
    ],
)
def test_a_signal_that_does_not_exist_is_refused_with_the_nearest(rig: Rig, signal: str, said: str) -> None:
    rig.run_for(10 * MS)
    with pytest.raises(ControlError, match=said):
        rig.record(["beat/count", signal])
    rig.run_for(10 * MS)
    assert rig.get("beat/count") == 2


@pytest.mark.parametrize("rhythm", ["often", 0, -5, 1.5, None, True])
def test_a_rhythm_that_is_none_is_refused(rig: Rig, rhythm: Any) -> None:
    with pytest.raises(ArgumentError, match="record cannot have the rhythm"):
        rig.record("beat/count", rhythm)


@pytest.mark.parametrize("signals", [[], 5, [5], None])
def test_names_that_are_none_are_refused(rig: Rig, signals: Any) -> None:
    with pytest.raises(ArgumentError, match="record cannot take"):
        rig.record(signals)


@pytest.fixture
def recording(rig: Rig) -> Recording:
    rig.run_for(30 * MS)
    recording = rig.record(["beat/count", "beat/pulse", "slow/word", "wires/slow.count"])
    rig.run_for(40 * MS)
    return recording


def test_a_csv_has_a_line_for_each_instant(recording: Recording, tmp_path: Path) -> None:
    recording.write_csv(tmp_path / "beat.csv")
    assert (tmp_path / "beat.csv").read_text().splitlines() == [
        "time_s,beat/count [1],beat/pulse,slow/word,wires/slow.count [1]",
        "0.000000000,,,,1",
        "0.010000000,4,0,,",
        "0.020000000,5,0,,",
        "0.030000000,6,0,even,2",
        "0.040000000,7,0,,",
    ]


def test_a_vcd_has_each_signal_as_a_foreign_reader_sees_it(recording: Recording, tmp_path: Path) -> None:
    recording.write_vcd(tmp_path / "beat.vcd")
    read = VCDVCD(str(tmp_path / "beat.vcd"))
    assert [(time, float(value)) for time, value in read["beat.count"].tv if value != "nan"] == [
        (10 * MS, 4),
        (20 * MS, 5),
        (30 * MS, 6),
        (40 * MS, 7),
    ]
    assert read["beat.pulse"][15 * MS] == "0"
    assert read["beat.pulse"][5 * MS] == "x"
    assert float(read["wires.slow.count"][35 * MS]) == 2
