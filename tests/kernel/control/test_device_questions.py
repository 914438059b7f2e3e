"""Questions that only one kind of device understands, in one process and in two, and through the control service."""

import asyncio
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import pytest

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.control.device_questions import RealPoints, Source, answers
from fieldrig.device import Device, Point
from fieldrig.errors import ControlError
from fieldrig.loop.real_clock import RealClock
from fieldrig.virtual.journey import Journey
from fieldrig.virtual.keeper import NO_KEEPER
from fieldrig.virtual.rig import Rig
from fieldrig.virtual.served import ServedRig
from fieldrig.virtual.service import VirtualPoints

HERE, BESIDE = Path(__file__).parents[1], Path(__file__).parent
DICE: dict[str, Any] = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {"dice": {"kind": "rig_kinds:Dice", "links": {"wires": "wires"}}},
}


@pytest.mark.long
@pytest.mark.parametrize("processes", ["one", "each"])
def test_a_device_answers_at_the_present_instant(processes: str) -> None:
    with Rig(from_dict({**DICE, "processes": processes}, HERE)) as rig:
        rig.run_until(25 * MS)
        assert rig.answer("dice", "rethrow", {"times": 4}) == {"throws": 7, "now_ns": 25 * MS}
        assert rig.get("dice", "throws") == 7


@pytest.mark.long
@pytest.mark.parametrize("processes", ["one", "each"])
def test_a_refusal_says_what_was_expected(processes: str) -> None:
    with Rig(from_dict({**DICE, "processes": processes}, HERE)) as rig:
        with pytest.raises(ControlError) as refused:
            rig.answer("dice", "rethrow", {"times": "many"})
        assert (refused.value.what, refused.value.remedy) == ("dice: nothing to throw", "expected a number of times")


def test_the_control_service_passes_on_what_it_does_not_know_itself() -> None:
    with ServedRig(from_dict(DICE, HERE)) as rig:
        control = answers(VirtualPoints(Journey(rig, NO_KEEPER), "dice"))

        async def answer(verb: str, message: Any) -> Any:
            return await control(verb, message)

        assert asyncio.run(answer("rethrow", {"times": 1}))["throws"] == 2
        with pytest.raises(ControlError, match="this device cannot answer dance"):
            asyncio.run(answer("dance", None))
        with pytest.raises(ControlError, match="a device cannot get"):
            asyncio.run(answer("get", 5))


class Many(Device):
    """A device that makes its points again whenever it is asked, as authors of small devices do."""

    def __init__(self) -> None:
        self.values, self.asked = [0] * 40, 0

    def points(self) -> Mapping[str, Point]:
        self.asked += 1
        points = {f"v{place}": self._point(place) for place in range(len(self.values))}
        return points | {"asked": Point(lambda: self.asked)}

    def _point(self, place: int) -> Point:
        return Point(lambda: self.values[place], lambda value: self.values.__setitem__(place, int(value)), "m")


@contextmanager
def in_real_time() -> Iterator[Source]:
    loop = asyncio.new_event_loop()
    clock = RealClock(loop)
    try:
        yield RealPoints("many", Many(), clock, lambda: "")
    finally:
        clock.close()
        loop.close()


@contextmanager
def in_virtual_time() -> Iterator[Source]:
    config = from_dict({"time": "virtual", "devices": {"many": {"kind": "test_device_questions:Many"}}}, BESIDE)
    with ServedRig(config) as rig:
        yield VirtualPoints(Journey(rig, NO_KEEPER), "many")


def answer_of(source: Source, verb: str, message: Any) -> Any:
    async def ask() -> Any:
        return await answers(source)(verb, message)

    return asyncio.run(ask())


@pytest.mark.parametrize("source", [in_real_time, in_virtual_time])
@pytest.mark.parametrize("message", [None, {"keys": [f"v{place}" for place in range(40)] + ["asked"]}])
def test_a_question_for_many_values_asks_the_device_for_its_points_once(
    source: Callable[[], AbstractContextManager[Source]], message: Any
) -> None:
    with source() as points:
        before = answer_of(points, "get", message)["asked"]
        values = answer_of(points, "get", message)
    assert values == {f"v{place}": 0 for place in range(40)} | {"asked": before + 1}


@pytest.mark.parametrize("source", [in_real_time, in_virtual_time])
def test_the_facts_are_the_same_in_both_times(source: Callable[[], AbstractContextManager[Source]]) -> None:
    with source() as points:
        facts = answer_of(points, "keys", None)
        assert facts["v3"] == {"unit": "m", "about": "", "writable": True}
        assert answer_of(points, "set", {"values": {"v3": 7}}) == {"v3": 7}


@pytest.mark.parametrize("wrong", [{"w3": 1}, {"v4": "much"}])
def test_nothing_is_set_if_a_name_or_a_type_is_wrong(wrong: dict[str, Any]) -> None:
    with in_virtual_time() as points:
        with pytest.raises(ControlError):
            answer_of(points, "set", {"values": {"v3": 7, **wrong}})
        assert answer_of(points, "get", {"keys": ["v3"]}) == {"v3": 0}
