"""Wrong scenario files of all kinds: refused with their places, never with a traceback."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fieldrig.config.rig_file import load
from fieldrig.errors import ConfigError
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.checks import check
from fieldrig_devices.scenarios.running import check_file, played
from fieldrig_devices.scenarios.scenario_file import load_scenario

LAB = Path(__file__).parents[3] / "configs" / "lab.yaml"
GOOD: dict[str, Any] = {
    "rig": str(LAB),
    "overrides": ["seed=3"],
    "after": "1s",
    "for": "5s",
    "steps": [
        {"at": "1s", "set": {"drive/speed_set": 60, "drive/run": True}},
        {"at": "2s", "press": {"drive/alarm_reset": True}, "hold": "200ms"},
        {"when": "tank/level > 1", "nth": 2, "at": "1ms", "fault": "io power_off duration_ms=500"},
        {"at": "3s", "send": {"can0": "000#0101"}},
        {"at": "4s", "clear": "can0"},
        {"at": "4s", "restart": "io"},
    ],
    "recover": [{"at": "0s", "set": {"drive/run": False}}],
    "properties": {
        "a": {"never": "tank/level < 0.1", "longer": "1ms", "after": "drive/run"},
        "b": {"expect": "io/nmt.state == operational", "within": "1s", "after": "message(can0, id=0x0)"},
        "c": {"stays": "drive/run", "until": "tank/level > 1", "within": "3s"},
        "d": {"eventually": "count(can0, node=io) > 1 or diagnosis(io, 0x8130)", "within": "1s"},
    },
}
ODD = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-5, 10**20),
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from(
        ["", " ", "1s", "-1s", "1e9h", "1 s", "tank/level", "tank", "/", "a//b", "tank/", "wires/x", "can0 drop",
         "can0", "io power_off when=tank/level", "can0 drop probability=7", "message(can0", "message(can0, id=)",
         "since()", "diagnosis(io)", "count(can9) > 1", "not", "((((", "1 / 0", "tank/level & 1", "'", "000#", "00#1",
         "time=real", "!!python/object:os.system", "x" * 3000, "\u0000",
         "drive/run == 'a' > 3", "0x" + "f" * 900 + " / 3 > 1.5"]
    ),
    st.lists(st.integers(), max_size=2),
    st.dictionaries(st.sampled_from(["at", "set", "a/b", "never", "tank/level"]), st.integers(), max_size=2),
)  # fmt: skip


WRONG_TEXTS = [
    ({"properties": {"a": {"eventually": "io/nmt.state == opertaional", "within": "1s"}}},
     "io/nmt.state is never 'opertaional'", "did you mean operational?"),
    ({"properties": {"a": {"never": "not ( 'stoped' != io/nmt.state )"}}}, "io/nmt.state is never 'stoped'",
     "did you mean stopped?"),
    ({"properties": {"a": {"never": "tank/level > 9", "after": 'io/nmt.state == "Operational"'}}},
     "io/nmt.state is never 'Operational'", "did you mean operational?"),
    ({"properties": {"a": {"never": "drive/run == ture and tank/level > 9"}}}, "drive/run is never 'ture'",
     "did you mean true?"),
    ({"steps": [{"when": "io/nmt.state == run", "at": "1ms", "restart": "io"}]}, "io/nmt.state is never 'run'",
     "there are: initialising, stopped, operational, pre_operational"),
    ({"steps": [{"at": "1s", "set": {"drive/run": "ture"}}]}, "drive/run cannot be 'ture'", "did you mean true?"),
    ({"steps": [{"at": "1s", "press": {"drive/alarm_reset": "flase"}, "hold": "1s"}]},
     "drive/alarm_reset cannot be 'flase'", "did you mean false?"),
    ({"steps": [{"at": "1s", "fault": "io power_off when='io/nmt.state == stoped'"}]}, "io/nmt.state is never 'stoped'",
     "did you mean stopped?"),
]  # fmt: skip


WRONG_KEYS = [
    ({"steps": [{"at": "0s", "set": {"drive/run": True}, "hold": "1s"}]}, "steps[0].hold", "set takes no time"),
    ({"steps": [{"at": "0s", "fault": "tank leak", "hold": "1s"}]}, "steps[0].hold", "fault takes no time"),
    ({"steps": [{"at": "0s", "set": {}}]}, "steps[0].set", "{} doesn't fit"),
    ({"steps": [{"at": "0s", "send": {}}]}, "steps[0].send", "{} doesn't fit"),
    ({"jitter": "5ms"}, "jitter", "only a master wakes up late"),
    ({"vary": [{"restart": "io"}]}, "vary", "this is the plan of a search"),
    ({"overrides": ["devices.tank.hight_m=3"]}, "overrides[0]", "devices.tank.hight_m: there is no such key"),
    ({"properties": {"a": {"never": "tank/level == full"}}}, "properties.a.never", "tank/level is never 'full'"),
    ({"properties": {"a": {"never": "message(can0 unit=1)"}}}, "properties.a.never", "can0 has no units"),
    ({"properties": {"a": {"never": "message(can0 register=level)"}}}, "properties.a.never", "can0 has no registers"),
    ({"properties": {"a": {"never": "message(mb_tcp code=1)"}}}, "properties.a.never", "mb_tcp has no emergency"),
    ({"properties": {"a": {"never": "message(can0 data=xy)"}}}, "properties.a.never", "can0: data cannot be 'xy'"),
    ({"properties": {"a": {"never": "message(can0 sender=drive)"}}}, "properties.a.never", "can0 has no sender"),
    ({"properties": {"a": {"never": "message(can0 sender=sensro)"}}}, "properties.a.never", "can0 has no sender"),
]  # fmt: skip


@pytest.mark.parametrize(("part", "key", "what"), WRONG_KEYS)
def test_what_would_do_nothing_or_say_nothing_is_a_mistake_with_its_line(
    tmp_path: Path, part: dict[str, Any], key: str, what: str
) -> None:
    file = tmp_path / "scenario.yaml"
    file.write_text(json.dumps(GOOD | part, indent=1))
    with pytest.raises(ConfigError) as caught:
        check_file(file)
    [mistake] = caught.value.mistakes
    assert (mistake.file, mistake.key) == (str(file), key)
    assert mistake.what.startswith(what)
    assert mistake.line is not None
    line = file.read_text().splitlines()[mistake.line - 1]
    assert (f'"{key.rpartition(".")[2]}": ' in line) or ("hight_m" in line and key == "overrides[0]")


REFUSED = [
    ({"steps": [{"at": "0s", "set": {"drive/speed_set": 1_000}}]}, "steps[0].set.drive/speed_set"),
    ({"steps": [{"at": "0s", "press": {"drive/run": 7}}]}, "steps[0].press.drive/run"),
    ({"steps": [{"when": "tank/level > 0", "at": "5ms", "set": {"io/6411:01": 99_999}}]}, "steps[0].set.io/6411:01"),
    ({"steps": [], "recover": [{"at": "1s", "set": {"drive/speed_set": -1}}]}, "recover[0].set.drive/speed_set"),
]  # fmt: skip


@pytest.mark.parametrize(("part", "key"), REFUSED)
def test_a_value_that_the_device_refuses_is_a_mistake_in_the_line_of_its_step(
    tmp_path: Path, part: dict[str, Any], key: str
) -> None:
    file = tmp_path / "scenario.yaml"
    properties = {"properties": {"a": {"always": "tank/level > 0"}}}
    file.write_text(json.dumps(GOOD | {"steps": [], "recover": []} | properties | part, indent=1))
    with pytest.raises(ConfigError) as caught:
        played(file)
    [mistake] = caught.value.mistakes
    place = key.partition("et.")[2] or key.partition("ess.")[2]
    lines = file.read_text().splitlines()
    assert (mistake.file, mistake.key) == (str(file), key)
    assert mistake.line is not None
    assert json.dumps(place) in lines[mistake.line - 1]
    assert "expected" in f"{mistake.what} {mistake.remedy}"


@pytest.mark.parametrize(("part", "what", "remedy"), WRONG_TEXTS)
def test_a_text_that_a_place_never_has_is_answered_with_the_nearest_one(
    tmp_path: Path, part: dict[str, Any], what: str, remedy: str
) -> None:
    with pytest.raises(ConfigError) as wrong:
        checked(tmp_path, part)
    assert [(mistake.what.removeprefix("io: "), mistake.remedy) for mistake in wrong.value.mistakes] == [(what, remedy)]


@pytest.mark.parametrize(
    "text",
    [
        "io/nmt.state == operational", "'operational' == io/nmt.state", "io/nmt.state != pre_operational",
        "drive/run == true", "drive/location == lba", "drive/run != False", "tank/level + 1 > 3",
    ],
)  # fmt: skip
def test_texts_that_a_place_may_have(tmp_path: Path, text: str) -> None:
    checked(tmp_path, {"properties": {"a": {"eventually": text, "within": "1s"}}})


def checked(folder: Path, part: dict[str, Any]) -> None:
    file = folder / "wrong.yaml"
    file.write_text(json.dumps({"rig": str(LAB), "steps": [], "properties": {"z": {"never": "tank/level > 9"}}} | part))
    check_file(file, ["time=virtual"])


def places(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every value in the data."""
    children = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in children:
        yield (*path, key)
        yield from places(value, (*path, key))


EVERY = list(places(GOOD))


def changed(data: Any, path: tuple[Any, ...], odd: Any, *, is_key: bool) -> Any:
    copy = json.loads(json.dumps(data))
    inner = copy
    for key in path[:-1]:
        inner = inner[key]
    if is_key and isinstance(inner, dict):
        inner[str(odd)] = inner.pop(path[-1])
    else:
        inner[path[-1]] = odd
    return copy


@pytest.fixture(scope="module")
def lab() -> Iterator[Rig]:
    with Rig(load(LAB, ("time=virtual",))) as rig:
        yield rig


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(path=st.sampled_from(EVERY), odd=ODD, is_key=st.booleans())
def test_any_change_of_a_file_is_refused_with_its_place_or_plays(
    tmp_path: Path, lab: Rig, path: tuple[Any, ...], odd: Any, is_key: bool
) -> None:
    file = tmp_path / "it.yaml"
    file.write_text(json.dumps(changed(GOOD, path, odd, is_key=is_key), indent=1), encoding="utf-8")
    try:
        check(lab, load_scenario(file))
    except ConfigError as wrong:
        for mistake in wrong.mistakes:
            assert mistake.what
            assert mistake.file == str(file)
            assert mistake.line is not None


@given(st.text(max_size=200))
@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_text_is_no_scenario(tmp_path: Path, text: str) -> None:
    file = tmp_path / "it.yaml"
    file.write_text(text, encoding="utf-8", newline="")
    with pytest.raises(ConfigError):
        load_scenario(file)


def test_the_file_of_these_tests_is_right(tmp_path: Path, lab: Rig) -> None:
    file = tmp_path / "it.yaml"
    file.write_text(json.dumps(GOOD), encoding="utf-8")
    check(lab, load_scenario(file))


@pytest.mark.parametrize(
    ("text", "line", "key", "what", "remedy"),
    [
        ("steps: [{at: 1s, set: {tank/levle: 1}}]", 2, "steps[0].set.tank/levle", "levle", "did you mean level?"),
        ("steps: [{at: 1s, set: {tnak/level: 1}}]", 2, "steps[0].set.tnak/level", "tnak", "did you mean tank?"),
        ("steps: [{at: 1s, fault: can0 dorp}]", 2, "steps[0].fault", "dorp", "did you mean drop?"),
        ("steps: [{at: 1s, fault: can0 drop nod=io}]", 2, "steps[0].fault", "nod", "node"),
        ("steps: [{at: 1s, set: {drive/flow: 3}}]", 2, "steps[0].set.drive/flow", "cannot be written", "fieldrig set"),
        ("recover: [{at: 1s, restart: oi}]", 2, "recover[0].restart", "oi", "there are: tank, io"),
        ("steps: [{at: 1, restart: io}]", 2, "steps[0].at", "expected a time with a unit", ""),
        ("steps: [{at: 1s, reset: io}]", 2, "steps[0].reset", "no such key", "did you mean"),
    ],
)
def test_a_mistake_has_line_key_and_what_was_expected(
    tmp_path: Path, lab: Rig, text: str, line: int, key: str, what: str, remedy: str
) -> None:
    file = tmp_path / "it.yaml"
    file.write_text(f"rig: {LAB}\n{text}\nproperties: {{a: {{never: tank/level > 3}}}}\n")
    with pytest.raises(ConfigError) as caught:
        check(lab, load_scenario(file))
    [mistake, *_] = caught.value.mistakes
    assert (mistake.line, mistake.key) == (line, key)
    assert what in mistake.what
    assert remedy in mistake.remedy
