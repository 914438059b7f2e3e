"""The calls that every test of a rig in virtual time writes: time, conditions, and points by their names."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fieldrig import MS, ArgumentError, ControlError, Rig, RigError, RigMaker, S, UnmetError, from_dict

DICE: dict[str, Any] = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {"dice": {"kind": "rig_kinds:Dice", "links": {"wires": "wires"}}},
}


@pytest.fixture
def rig() -> Iterator[Rig]:
    """A rig whose dice are thrown at 0, 10, 20 ... ms."""
    with Rig(from_dict(DICE, Path(__file__).parents[1])) as rig:
        yield rig


# ---- time


def test_a_rig_runs_for_a_duration(rig: Rig) -> None:
    rig.run_for(25 * MS)
    rig.run_for(0)
    rig.run_for(10 * MS)
    assert (rig.now_ns, rig.get("dice/throws")) == (35 * MS, 4)


# ---- conditions


def test_a_condition_is_met_at_its_instant(rig: Rig) -> None:
    assert rig.until(lambda: rig.get("dice/throws") == 3, within=5 * S) is True
    assert rig.now_ns == 20 * MS


def test_a_condition_that_holds_already_takes_no_time(rig: Rig) -> None:
    rig.run_for(15 * MS)
    assert rig.until(lambda: rig.get("dice/throws"), within=0) == 2
    assert rig.now_ns == 15 * MS


def test_a_condition_is_met_by_what_a_member_from_outside_hears(rig: Rig) -> None:
    heard: list[Any] = []
    rig.attach("bench").link("wires").on_receive(heard.append, ["dice.thrown"])
    first = rig.until(lambda: heard[1:], within=S)
    assert (len(first), rig.now_ns) == (1, 10 * MS)


def test_a_value_that_changes_without_an_event_is_seen_within_a_millisecond(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig({**DICE, "devices": {}})
    rig.until(lambda: rig.now_ns >= 2_500_000, within=S)
    assert rig.now_ns == 3 * MS


def test_a_condition_that_never_holds_tells_what_it_saw(rig: Rig) -> None:
    rig.run_for(5 * MS)
    with pytest.raises(UnmetError) as unmet:
        rig.until(lambda: rig.get("dice", "throws") == 9, within=32 * MS)
    assert unmet.value.what == "the condition did not hold within 0.032 s, from 0.005 s to 0.037 s"
    assert unmet.value.remedy == "dice/throws = 4 since 0.03 s; before that 1 at 0.005 s, 2 at 0.01 s, 3 at 0.02 s"
    assert rig.now_ns == 37 * MS


def test_a_condition_tells_the_last_changes_of_many(rig: Rig) -> None:
    with pytest.raises(UnmetError, match=r"throws = 101 since 1 s; before that 97 at 0.96 s, 98"):
        rig.until(lambda: rig.get("dice/throws") == 0, within=S)


def test_a_condition_without_points_says_how_to_read_one(rig: Rig) -> None:
    with pytest.raises(UnmetError, match=r'it read no point of the rig, such as rig.get\("tank/level"\)'):
        rig.until(lambda: False, within=MS)


def test_what_a_condition_raises_reaches_the_test(rig: Rig) -> None:
    with pytest.raises(ControlError, match=r"dice has no value 'throw'\n  did you mean throws\?"):
        rig.until(lambda: rig.get("dice/throw"), within=S)
    rig.get("dice/throws")
    with pytest.raises(UnmetError, match="it read no point"):
        rig.until(lambda: False, within=0)


def test_a_condition_stays_true_for_a_time(rig: Rig) -> None:
    rig.stays(lambda: rig.get("dice/throws") in (1, 2), during=15 * MS)
    assert rig.now_ns == 15 * MS
    with pytest.raises(UnmetError) as unmet:
        rig.stays(lambda: rig.get("dice/throws") != 4, during=S)
    assert unmet.value.what == "the condition no longer held at 0.03 s, 0.015 s after 0.015 s"
    assert unmet.value.remedy == "dice/throws = 4 since 0.03 s; before that 2 at 0.015 s, 3 at 0.02 s"


def test_a_condition_is_never_true_for_a_time(rig: Rig) -> None:
    rig.never(lambda: rig.get("dice/throws") == 4, during=29 * MS)
    with pytest.raises(UnmetError, match=r"the condition held at 0.03 s, 0.001 s after 0.029 s"):
        rig.never(lambda: rig.get("dice/throws") == 4, during=S)


def test_a_condition_stays_true_until_another_one_is(rig: Rig) -> None:
    rig.stays(lambda: rig.get("dice/throws") != 9, during=S, until=lambda: rig.get("dice/throws") == 5)
    assert rig.now_ns == 40 * MS
    with pytest.raises(UnmetError, match=r"the end did not come within 0.05 s"):
        rig.stays(lambda: True, during=50 * MS, until=lambda: False)


@pytest.mark.parametrize("call", ["stays", "never"])
def test_what_is_no_condition_is_refused(rig: Rig, call: str) -> None:
    with pytest.raises(ArgumentError, match="cannot take True"):
        getattr(rig, call)(True, during=S)
    with pytest.raises(ArgumentError, match="cannot take -1"):
        getattr(rig, call)(lambda: True, during=-1)
    with pytest.raises(ArgumentError, match="cannot take 5"):
        rig.stays(lambda: True, during=S, until=5)  # type: ignore[arg-type]


# ---- points


def test_a_point_has_one_name_in_python_and_on_the_command_line(rig: Rig) -> None:
    rig.set("dice/throws", 7)
    assert rig.get("dice/throws") == rig.get("dice", "throws") == 7
    rig.set("dice", "throws", 8)
    assert rig.get("dice/throws") == 8


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (("dice",), "'dice' is not a point\n  expected DEVICE/KEY, such as \"dice/level\""),
        (("/throws",), "'/throws' is not a point\n  expected DEVICE/KEY, such as \"tank/level\""),
        ((5,), '5 is not a point\n  expected a text, such as "tank/level"'),
        (("dice", 5), "'dice', 5 is not a point\n  expected a text"),
        ((None, "throws"), "None, 'throws' is not a point\n  expected a text"),
    ],
)
def test_what_is_no_name_of_a_point_is_refused(rig: Rig, name: tuple[Any, ...], message: str) -> None:
    for call in (lambda: rig.get(*name), lambda: rig.set(*name, 3)):  # type: ignore[call-overload]
        with pytest.raises(ArgumentError) as wrong:
            call()
        assert str(wrong.value).startswith(message)


def test_a_point_is_not_set_to_nothing(rig: Rig) -> None:
    with pytest.raises(ArgumentError, match="cannot be set to nothing"):
        rig.set("dice/throws")  # type: ignore[call-overload]


@pytest.mark.parametrize("duration", [-1, 1.5, "10", None, True])
def test_a_duration_is_a_number_of_whole_nanoseconds(rig: Rig, duration: Any) -> None:
    for call, name in ((rig.run_for, "run_for"), (lambda within: rig.until(lambda: True, within), "until")):
        with pytest.raises(
            ArgumentError, match=f"{name} cannot take {duration!r}\n  expected a duration in whole nano"
        ):
            call(duration)
    assert issubclass(ArgumentError, RigError | TypeError)


# ---- listeners


def test_several_listeners_hear_every_message_until_they_end(rig: Rig) -> None:
    heard: dict[str, list[int]] = {"a": [], "b": []}
    end_a = rig.on_delivery(lambda _bus, delivery: heard["a"].append(delivery.time_ns))

    def hear_once(_bus: Any, delivery: Any) -> None:
        heard["b"].append(delivery.time_ns)
        end_b()

    end_b = rig.on_delivery(hear_once)
    rig.run_until(20 * MS)
    end_a()
    end_a()
    rig.run_until(40 * MS)
    assert heard == {"a": [0, 10 * MS, 20 * MS], "b": [0]}


def test_the_end_of_an_instant_comes_after_everything_of_it(rig: Rig) -> None:
    seen: list[tuple[int, Any]] = []
    end = rig.on_instant(lambda: seen.append((rig.now_ns, rig.get("dice/throws"))))
    rig.run_until(20 * MS)
    end()
    rig.run_until(40 * MS)
    assert seen == [(0, 1), (10 * MS, 2), (20 * MS, 3)]


def test_what_is_called_at_the_end_of_an_instant_does_not_run_the_rig(rig: Rig) -> None:
    rig.on_instant(rig.step)  # type: ignore[arg-type]
    with pytest.raises(RigError, match="a call of on_change or on_instant cannot run the rig"):
        rig.run_until(20 * MS)
