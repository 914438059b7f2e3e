"""A process with signals and a line to it that loses what a test says, for readers of recordings."""

import json
from collections.abc import Awaitable, Callable, Sequence
from functools import partial
from typing import Any, ClassVar

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.recording.record_set import RecordSet
from fieldrig.recording.recorders import Recorders
from fieldrig.recording.signals import Described, End, OnCycle, RecordedPart


class HandPart:
    """A device with signals that the test sets."""

    is_bus: ClassVar[bool] = False

    def __init__(self) -> None:
        self.values: dict[str, Value] = {"x": 0, "y": 0.5, "on": False, "word": "idle"}
        self.cycles: list[OnCycle] = []
        self.changes: list[tuple[Sequence[str], Callable[[int, int, Value], None]]] = []

    def describe(self, keys: Sequence[str]) -> list[Described]:
        for key in keys:
            if key not in self.values:
                raise ControlError(f"hand has no value {key!r}")
        return [Described(self.values[key], "m") for key in keys]

    def reader(self, keys: Sequence[str]) -> Callable[[], Sequence[Value]]:
        return lambda: [self.values[key] for key in keys]

    def on_cycle(self, action: OnCycle) -> End:
        self.cycles.append(action)
        return lambda: self.cycles.remove(action) if action in self.cycles else None

    def close(self) -> None:
        """There is nothing to release."""

    def on_change(self, keys: Sequence[str], action: Callable[[int, int, Value], None]) -> End:
        change = keys, action
        self.changes.append(change)
        return lambda: self.changes.remove(change) if change in self.changes else None

    def change(self, now_ns: int, key: str, value: Value) -> None:
        self.values[key] = value
        for keys, action in self.changes:
            if key in keys:
                action(now_ns, keys.index(key), value)


class HandSource:
    """A process with one device, `hand`; its cycles come when the test says so."""

    def __init__(self) -> None:
        self.hand, self.at_ns = HandPart(), 0
        self.ticks: list[Callable[[int, int], None]] = []
        self.on_rows: Callable[[], None] = lambda: None

    def now_ns(self) -> int:
        return self.at_ns

    def part(self, name: str) -> RecordedPart:
        if name != "hand":
            raise ControlError(f"there is no {name}")
        return self.hand

    def every(self, period_ns: int, action: Callable[[int, int], None]) -> End:
        self.ticks.append(action)
        return lambda: self.ticks.remove(action) if action in self.ticks else None

    def cycle(self) -> None:
        """Count in `x`, and end a cycle."""
        self.at_ns += 1_000_000
        self.hand.values["x"] = int(self.hand.values["x"]) + 1
        for action in tuple(self.hand.cycles):
            action(self.at_ns, 0)


class HandOutlet:
    def __init__(self, line: "HandLine", path: str) -> None:
        self._line, self._path = line, path

    def put(self, data: bytes) -> None:
        self._line.published += 1
        if not self._line.loses():
            for handler in tuple(self._line.ears.get(self._path, ())):
                handler(self._path.rpartition("/")[2], data)

    def end(self) -> None:
        """Nothing is published any more."""


class HandLine:
    """Both ends of the control messages in one object; what passes is what JSON holds."""

    rig = "lab"

    def __init__(self, loses: Callable[[], bool] = lambda: False) -> None:
        self.loses = loses
        self.published = 0
        self.ears: dict[str, list[Callable[[str, bytes], None]]] = {}
        self._answers: dict[str, Callable[[str, Any], Awaitable[Any]]] = {}
        self._lives: list[str] = []
        self._watchers: list[Callable[[str, bool], None]] = []

    # ---- the process

    def serve(self, path: str, answer: Callable[[str, Any], Awaitable[Any]]) -> None:
        self._answers[path] = answer

    def outlet(self, path: str) -> HandOutlet:
        return HandOutlet(self, path)

    def watch_life(self, path: str, handler: Callable[[str, bool], None]) -> None:
        self._watchers.append(handler)
        for name in self._lives:
            handler(name, True)

    # ---- the reader

    async def ask(self, path: str, message: Any, timeout_s: float) -> Any:
        if path == "rig/status":
            return {
                "time": "virtual",
                "processes": {"p": {"buses": []}},
                "buses": {"can0": {}},
                "devices": {"hand": {"process": "p"}},
            }
        return json.loads(json.dumps(await self._answer(path, message)))

    async def ask_bytes(self, path: str, message: Any, timeout_s: float) -> bytes:
        data: bytes = await self._answer(path, message)
        return data

    async def _answer(self, path: str, message: Any) -> Any:
        if path not in self._answers:
            raise ControlError("there is no answer")
        return await self._answers[path](path.rpartition("/")[2], json.loads(json.dumps(message)))

    def listen_to_bytes(self, path: str, handler: Callable[[str, bytes], None]) -> Callable[[], None]:
        self.ears.setdefault(path, []).append(handler)
        return lambda: self.ears[path].remove(handler) if handler in self.ears[path] else None

    def show_life(self, path: str) -> Callable[[], None]:
        name = path.rpartition("/")[2]
        self._lives.append(name)
        self._tell(name, True)
        return lambda: self.die(name)

    def die(self, name: str) -> None:
        """End the life of a reader, as its process does that ends."""
        if name in self._lives:
            self._lives.remove(name)
            self._tell(name, False)

    def _tell(self, name: str, is_alive: bool) -> None:
        for watcher in self._watchers:
            watcher(name, is_alive)


def process_on(line: HandLine, *, is_lossless: bool = False) -> tuple[HandSource, Recorders]:
    """Return the signals and recordings of the process `p` at the end of a line."""
    source = HandSource()
    make = partial(RecordSet, source, is_lossless=is_lossless)
    return source, Recorders(line, "p", source, make, is_lossless=is_lossless)
