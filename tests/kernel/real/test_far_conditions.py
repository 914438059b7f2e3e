"""Conditions of faults on points of another process: what the two processes say to each other, without a rig."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from fieldrig.clock import MS, VirtualClock
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError
from fieldrig.points.names import split_point
from fieldrig.real import far_conditions
from fieldrig.real.far_conditions import MOST_CONDITIONS, ConditionsOfOthers, FarConditions


class Clock(VirtualClock):
    def handle(self, call: Callable[..., Any], *arguments: Any) -> None:
        call(*arguments)


class Points:
    """One point, `tank/level`."""

    level = 0.5

    def get(self, point: str, key: str | None = None) -> Value:
        device, key = split_point(point, key)
        if (device, key) != ("tank", "level"):
            raise ControlError(f"{device} has no value {key!r}")
        return self.level

    def on_change(self, point: str, call: Callable[[Value], None]) -> Callable[[], None]:
        return lambda: None


class Line:
    """Both processes at one line."""

    def __init__(self) -> None:
        self.clock, self.points = Clock(), Points()
        others: Any = self.clock
        self.here = ConditionsOfOthers(others, self.points, lambda: None, self)
        self.handlers: dict[str, Callable[[str, Any], None]] = {}
        self.said: list[tuple[str, Any]] = []
        self.is_there = True

    def publish(self, path: str, message: Any) -> None:
        self.said.append((path, message))
        if path in self.handlers:
            self.handlers[path]("", message)

    async def ask(self, path: str, message: Any, timeout_s: float) -> Any:
        if not self.is_there:
            raise ControlError(f"there is no answer to {path}")
        return await self.here.answers("tank")("await", message)

    def listen_to(self, path: str, handler: Callable[[str, Any], None]) -> Callable[[], None]:
        self.handlers[path] = handler
        return lambda: None

    async def pass_ms(self, count: int) -> None:
        for _ in range(count):
            await asyncio.sleep(0)
            self.clock.advance_to(self.clock.instant_ns + MS)
        await asyncio.sleep(0)


def answered(message: Any) -> Any:
    async def ask() -> Any:
        return await Line().here.answers("tank")("await", message)

    return asyncio.run(ask())


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(far_conditions, "AGAIN_S", 0.0)


def begun(line: Line, far: FarConditions) -> list[tuple[str, int]]:
    faults: list[tuple[str, int]] = []
    far.listen(lambda name, fault: faults.append((name, fault)))
    return faults


def test_a_fault_begins_once_when_the_condition_is_met_elsewhere() -> None:
    async def run() -> None:
        line = Line()
        far = FarConditions("can0", line)
        faults = begun(line, far)
        far.add("can0", 1, "tank", "tank/level > 1")
        far.add("can0", 2, "tank", "tank/level > 1")
        far.add("wires", 2, "tank", "tank/level > 2")
        await line.pass_ms(3)
        far.forget("can0", 2)
        await line.pass_ms(3)
        line.points.level = 1.5
        await line.pass_ms(5)
        assert faults == [("can0", 1)]
        assert line.said == [("met/can0", {"number": 1})]

    asyncio.run(run())


def test_a_process_that_starts_is_given_all_conditions_again() -> None:
    async def run() -> None:
        line = Line()
        far = FarConditions("can0", line)
        faults = begun(line, far)
        line.is_there = False
        far.add("can0", 1, "tank", "tank/level > 1")
        await line.pass_ms(3)
        line.is_there = True
        await line.pass_ms(5)
        clock: Any = line.clock
        line.here = ConditionsOfOthers(clock, line.points, lambda: None, line)  # another process in its place
        line.handlers["ready/*"]("tank", {"pid": 1})
        await line.pass_ms(3)
        line.points.level = 1.5
        await line.pass_ms(3)
        assert faults == [("can0", 1)]

    asyncio.run(run())


def test_a_point_may_come_later() -> None:
    async def run() -> None:
        line = Line()
        far = FarConditions("can0", line)
        faults = begun(line, far)
        far.add("can0", 1, "tank", "tank/g_iPart == 3")
        await line.pass_ms(5)
        monkey: Any = line.points
        monkey.get = lambda point, key=None: 3
        await line.pass_ms(5)
        assert faults == [("can0", 1)]
        far.close()

    asyncio.run(run())


@pytest.mark.parametrize(
    "message",
    [
        None,
        [],
        {"process": "can0"},
        {"process": 1, "conditions": []},
        {"process": "can0", "conditions": {}},
        {"process": "can0", "conditions": [[1]]},
        {"process": "can0", "conditions": [["1", "tank/level > 1"]]},
        {"process": "can0", "conditions": [[1, "tank/level > 1"]] * (MOST_CONDITIONS + 1)},
    ],
)
def test_any_other_question_is_refused(message: Any) -> None:
    with pytest.raises(MalformedError):
        answered(message)


@pytest.mark.parametrize("text", ["", "tank", "tank/level >", "io/level > 1", "tank/levle > 1", "tank/level > [1]"])
def test_a_condition_that_cannot_be_met_is_said(text: str) -> None:
    answer = answered({"process": "can0", "conditions": [[1, text]]})
    assert [number for number, _ in answer["unknown"]] == [1]


def test_any_message_about_a_milestone_is_survived() -> None:
    async def run() -> None:
        line = Line()
        faults = begun(line, FarConditions("can0", line))
        messages: list[Any] = [None, 1, [], {}, {"number": "1"}, {"number": 99}]
        for message in messages:
            line.publish("met/can0", message)
        assert faults == []

    asyncio.run(run())


def test_too_many_conditions_are_refused() -> None:
    async def run() -> None:
        far = FarConditions("can0", Line())
        for number in range(MOST_CONDITIONS):
            far.add("can0", number, "tank", "tank/level > 1")
        with pytest.raises(ControlError, match=f"{MOST_CONDITIONS} faults wait for points of tank"):
            far.add("can0", MOST_CONDITIONS, "tank", "tank/level > 1")
        far.close()

    asyncio.run(run())
