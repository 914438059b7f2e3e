"""The conditions of faults on points of devices in other processes of a rig in real time.

The process of a fault gives the process of the device, or of a bus with signals, all conditions that it waits for
there, and hears once of each that it is met:

    condition/DEVICE/await   {"process": "can0", "conditions": [[1, "axis/6041:00 & 0x6f == 0x27"]]}
                             -> {"unknown": [[1, "axis has no value ..."]]}
    met/PROCESS              {"number": 1}
    condition/BUS/present    {"key": "tank.level"} -> {"value": 0.5}

It gives them again when they change, when a process of the rig has started, and each second while the device does not
answer, or does not have a point yet, such as a variable of a program that is still compiled.
"""

import asyncio
import logging
from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple, Protocol

from fieldrig.control.messages import Answer
from fieldrig.errors import ControlError
from fieldrig.faults.condition import Condition, condition_of
from fieldrig.faults.triggers import Points, Triggers
from fieldrig.loop.real_clock import RealClock
from fieldrig.outside.untrusted import MalformedError, field, shown

log = logging.getLogger(__name__)

MOST_CONDITIONS: Final = 1_000
"""Most conditions that one process waits for at one device."""
LONGEST_NAME: Final = 200
PATIENCE_S: Final = 5.0
AGAIN_S: Final = 1.0


class Line(Protocol):
    """The control messages of the process, as far as conditions need them."""

    def publish(self, path: str, message: Any) -> None: ...

    async def ask(self, path: str, message: Any, timeout_s: float) -> Any: ...

    def listen_to(self, path: str, handler: Callable[[str, Any], None]) -> Callable[[], None]: ...


class ConditionsOfOthers:
    """The conditions on the devices of this process that faults in other processes wait for."""

    def __init__(self, clock: RealClock, points: Points, tell: Callable[[], None], line: Line) -> None:
        """`tell` reports the changes of the points since its last call."""
        self._clock, self._line, self._points = clock, line, points
        self._triggers = Triggers(clock, points, self._met, tell=tell)
        self._armed: dict[tuple[str, str], dict[int, str]] = {}
        """The conditions that are waited for, by process of the fault, device, and number."""

    def answers(self, device: str) -> Answer:
        """Answer questions about a device or a bus."""

        async def answer(verb: str, message: Any) -> Any:
            if verb == "present":
                return {"value": self._points.get(f"{device}/{field(message, 'key', str)[:LONGEST_NAME]}")}
            process, wanted = field(message, "process", str)[:LONGEST_NAME], _conditions(message)
            unknown: dict[int, str] = {}
            self._clock.handle(lambda: unknown.update(self._keep(process, device, wanted)))
            return {"unknown": [[number, why] for number, why in unknown.items()]}

        return answer

    def _keep(self, process: str, device: str, wanted: Mapping[int, str]) -> Mapping[int, str]:
        """Wait for these conditions, and for no others of this process; return why some cannot be waited for."""
        armed, unknown = self._armed.setdefault((process, device), {}), dict[int, str]()
        for number in [number for number, text in armed.items() if wanted.get(number) != text]:
            self._triggers.forget(process, number)
            del armed[number]
        for number, text in wanted.items():
            if number not in armed:
                try:
                    self._triggers.add(self._clock.now_ns(), process, number, _condition_on(device, text))
                except ControlError as cause:
                    unknown[number] = cause.what
                else:
                    armed[number] = text
        return unknown

    def _met(self, process: str, number: int) -> None:
        for (asker, _), armed in self._armed.items():
            if asker == process:
                armed.pop(number, None)
        self._line.publish(f"met/{process}", {"number": number})


def _conditions(message: Any) -> dict[int, str]:
    """Return the conditions of a question by number.  MalformedError for anything else."""
    given = field(message, "conditions", list)
    if len(given) > MOST_CONDITIONS:
        raise MalformedError(f"conditions: expected at most {MOST_CONDITIONS}")
    wanted = {}
    for one in given:
        match one:
            case [int(number), str(text)]:
                wanted[number] = text
            case _:
                raise MalformedError(f"conditions: expected number and text, found {shown(one)}")
    return wanted


def _condition_on(device: str, text: str) -> Condition:
    """Return a condition that is about this device.  ControlError for any other text."""
    try:
        condition = condition_of(text)
    except ValueError as wrong:
        what, _, remedy = str(wrong).partition("\n")
        raise ControlError(what, remedy) from None
    if condition.device != device:
        raise ControlError(f"{text} is not about {device}")
    return condition


class _Wait(NamedTuple):
    name: str
    """The bus, end or device in this process that has the fault."""
    fault: int
    text: str


class FarConditions:
    """The conditions on devices of other processes that faults in this process wait for."""

    def __init__(self, process: str, line: Line) -> None:
        self._process, self._line = process, line
        self._begin: Callable[[str, int], None] = lambda name, fault: None
        self._waits: dict[str, dict[int, _Wait]] = {}
        """The conditions, by device and number."""
        self._last = 0
        self._changed: set[str] = set()
        self._tasks: dict[str, asyncio.Task[None]] = {}

    def listen(self, begin: Callable[[str, int], None]) -> None:
        """Call `begin` with the part and the number of a fault when its condition is met."""
        self._begin = begin
        self._line.listen_to(f"met/{self._process}", self._on_met)
        self._line.listen_to("ready/*", self._on_ready)

    def add(self, name: str, fault: int, device: str, text: str) -> None:
        """Wait for the condition of a fault from now on.  ControlError if too many wait for the device."""
        waits = self._waits.setdefault(device, {})
        if len(waits) >= MOST_CONDITIONS:
            raise ControlError(f"{MOST_CONDITIONS} faults wait for points of {device}", "clear some of them")
        self._last += 1
        waits[self._last] = _Wait(name, fault, text)
        self._give(device)

    def forget(self, name: str, fault: int) -> None:
        """Wait no longer for the condition of a fault, if it waits for one."""
        for device, waits in self._waits.items():
            for number in [number for number, wait in waits.items() if (wait.name, wait.fault) == (name, fault)]:
                del waits[number]
                self._give(device)

    def close(self) -> None:
        for task in self._tasks.values():
            task.cancel()

    def _on_met(self, _: str, message: Any) -> None:
        match message:
            case {"number": int(number)}:
                for waits in self._waits.values():
                    if (wait := waits.pop(number, None)) is not None:
                        self._begin(wait.name, wait.fault)

    def _on_ready(self, _process: str, _message: Any) -> None:
        """Give all conditions again, as a process that has started knows none."""
        for device, waits in self._waits.items():
            if waits:
                self._give(device)

    def _give(self, device: str) -> None:
        self._changed.add(device)
        if device not in self._tasks or self._tasks[device].done():
            self._tasks[device] = asyncio.get_running_loop().create_task(self._give_all(device))

    async def _give_all(self, device: str) -> None:
        """Give the process of a device the conditions until it waits for all of them."""
        said = ""
        while device in self._changed:
            self._changed.discard(device)
            why = await self._given(device)
            if why:
                self._changed.add(device)
                if why != said:
                    log.info("%s; asking again", why)
                said = why
                await asyncio.sleep(AGAIN_S)

    async def _given(self, device: str) -> str:
        """Return why its process does not wait for all of the conditions; "" if it does."""
        conditions = [[number, wait.text] for number, wait in self._waits[device].items()]
        question = {"process": self._process, "conditions": conditions}
        try:
            answer = await self._line.ask(f"condition/{device}/await", question, PATIENCE_S)
        except ControlError as refusal:
            return refusal.what
        unknown = answer.get("unknown") if isinstance(answer, dict) else None
        return "; ".join(str(why) for _, why in unknown) if unknown else ""
