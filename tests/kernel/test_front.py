"""The front of a device as data: the one that points make, its JSON, and the question for it in real time."""

import asyncio
import json
from collections.abc import Mapping
from typing import Any

import pytest

from fieldrig.control.device_questions import RealPoints, answers
from fieldrig.device import Device, Point
from fieldrig.errors import ControlError
from fieldrig.front import MOST_PARTS, Clamp, Drawing, Front, Gap, Group, Key, Led, Plate
from fieldrig.loop.real_clock import RealClock
from fieldrig.real.switched import Switched


def ignore(_value: object) -> None:
    """Take a value that a test writes."""


class Press(Device):
    about = "a press"

    def points(self) -> Mapping[str, Point]:
        return {
            "closed": Point(lambda: False, about="the limit switch"),
            "light": Point(lambda: True, ignore),
            "force": Point(lambda: 12.5, unit="kN"),
            "stroke": Point(lambda: 100, ignore, "mm"),
            "state": Point(lambda: "open", states=["open", "closed"]),
            "mode": Point(lambda: "manual", ignore, states=["manual", "automatic"]),
            "order": Point(lambda: "", ignore),
            "axis1.position": Point(lambda: 0.0),
            "axis1.speed": Point(lambda: 0.0),
            "6000:01": Point(lambda: 0),
            "can/state": Point(lambda: "operational"),
        }


class Lamp(Press):
    def front(self) -> Front:
        return Front(Plate("Acme", "L1"), [Group([Led("lit", "light", lit=[True]), Gap()], columns=2)])


def test_what_is_written_is_operated_and_everything_else_is_shown() -> None:
    front = Press().front()
    assert {part.point: part.sort for part in front.parts} == {
        "closed": "led", "light": "switch", "force": "number", "stroke": "knob", "state": "text", "mode": "switch",
        "order": "entry", "axis1.position": "number", "axis1.speed": "number", "6000:01": "number", "can/state": "text",
    }  # fmt: skip
    assert [part.point for part in front.parts if part.is_operated] == ["light", "stroke", "mode", "order"]


def test_points_with_the_same_beginning_are_a_group() -> None:
    groups = {group.title: [part.label for part in group.parts] for group in Press().front().groups}
    assert list(groups) == ["", "axis1", "can"]
    assert groups["axis1"] == ["position", "speed"]
    assert "6000:01" in groups[""]


def test_a_device_with_very_many_points_has_a_front_with_the_first_of_them() -> None:
    points = {f"V{number}": Point(lambda: 0) for number in range(5_000)}
    assert len([*Front.of_points(points).parts]) == MOST_PARTS


def test_a_front_is_json_with_units_and_without_what_is_empty() -> None:
    words = Press().front_words()
    assert json.loads(json.dumps(words)) == words
    assert words["units"] == {"force": "kN", "stroke": "mm"}
    [lit, gap] = Lamp().front_words()["groups"][0]["parts"]
    assert lit == {
        "sort": "led", "name": "light", "operated": False,
        "label": "lit", "point": "light", "colour": "green", "lit": [True],
    }  # fmt: skip
    assert gap == {"sort": "gap", "name": "", "operated": False}


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (Key("F1", "key.F1"), {"name": "key.F1", "pressed": True, "released": False, "operated": True}),
        (Key("Quit", "quit", released=None), {"name": "quit", "pressed": True, "operated": True}),
        (Key("Run", "state", "", "run", "run", None), {"name": "run", "pressed": "run", "operated": True}),
        (Clamp("0", "6000:01", bit=0, is_set=True), {"name": "6000:01.0", "bit": 0, "operated": True}),
        (Clamp("O1", "O1", side="out"), {"name": "O1", "side": "out", "operated": False}),
    ],
)
def test_a_part_says_what_is_written(part: Key | Clamp, words: Mapping[str, Any]) -> None:
    told = part.words()
    assert {key: told[key] for key in words} == words
    assert ("released" in told) is ("released" in words)


def test_a_drawing_needs_the_roles_of_its_shape() -> None:
    with pytest.raises(ValueError, match="a winder needs the roles angle"):
        Drawing("roll", shape="winder", roles={"radius": "radius"})


def test_in_real_time_a_device_has_its_front_without_power_too() -> None:
    async def play() -> tuple[Any, Any]:
        clock = RealClock(asyncio.get_running_loop())
        device = Switched("lamp", clock, Lamp, (), lambda: None)
        answer = answers(RealPoints("lamp", device, clock, str))
        front = await answer("front", None)
        device.add_fault({"what": "power_off"})
        with pytest.raises(ControlError, match="switched off"):
            await answer("get", {"keys": ["light"]})
        dark = await answer("front", None)
        with pytest.raises(ControlError, match="a device cannot front"):
            await answer("front", 5)
        clock.close()
        return front, dark

    front, dark = asyncio.run(play())
    assert front == dark
    assert front["plate"]["model"] == "L1"
