"""The control messages of a rig within one process: the same JSON as over Zenoh, without a session.

The rig's services and the page share one `MemoryControl`, so that a test needs no socket and no second process.
"""

import asyncio
import json
from collections.abc import Callable, Collection
from types import SimpleNamespace
from typing import Any

from fieldrig.control.messages import Answer, NoAnswerError
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import read_json


class MemoryControl:
    """The same calls as `fieldrig.control.messages.Control`, for one process."""

    def __init__(self, rig: str) -> None:
        self.rig = rig
        self.session = SimpleNamespace(info=SimpleNamespace(links=list))
        self.asked: list[str] = []
        """The paths of all questions so far."""
        self._answers: dict[str, Answer] = {}
        self._around: dict[str, Callable[[], object]] = {}
        self._listeners: dict[str, list[Callable[[str, bytes], None]]] = {}
        self._streams: list[MemoryStream] = []
        self._lives: set[str] = set()
        self._watchers: list[tuple[str, Callable[[str, bool], None]]] = []

    @property
    def served(self) -> Collection[str]:
        """The paths that are served."""
        return self._answers

    def limits(self) -> dict[str, float]:
        return {}

    def serve(self, path: str, answer: Answer) -> None:
        self._answers[path] = answer

    def around(self, verbs: Collection[str], look: Callable[[], object]) -> None:
        self._around |= dict.fromkeys(verbs, look)

    def silence(self, path: str) -> None:
        """Serve a path no longer, as when the process behind it has ended."""
        del self._answers[path]

    def publish(self, path: str, message: Any) -> None:
        self.put(path, json.dumps(message).encode())

    def put(self, path: str, data: bytes) -> None:
        for pattern, listeners in tuple(self._listeners.items()):
            if _fits(pattern, path):
                for listener in tuple(listeners):
                    listener(path.rpartition("/")[2], data)

    def listen_to(self, path: str, handler: Callable[[str, Any], None]) -> Callable[[], None]:
        return self.listen_to_bytes(path, lambda name, data: handler(name, read_json(data, takes_nan=True)))

    def listen_to_bytes(self, path: str, handler: Callable[[str, bytes], None]) -> Callable[[], None]:
        self._listeners.setdefault(path, []).append(handler)
        self._look()

        def end() -> None:
            if handler in self._listeners[path]:
                self._listeners[path].remove(handler)
                self._look()

        return end

    def stream(self, path: str, on_listeners: Callable[[bool], None]) -> "MemoryStream":
        stream = MemoryStream(self, path, on_listeners)
        self._streams.append(stream)
        stream.look()
        return stream

    def has_listeners(self, path: str) -> bool:
        return any(listeners and _fits(pattern, path) for pattern, listeners in self._listeners.items())

    async def ask(self, path: str, message: Any, timeout_s: float) -> Any:
        self.asked.append(path)
        look = self._around.get(path.rpartition("/")[2], lambda: None)
        for pattern, answer in self._answers.items():
            if _fits(pattern, path):
                look()
                try:
                    async with asyncio.timeout(timeout_s):
                        return await _answer(answer, path, message)
                finally:
                    look()
        raise NoAnswerError(f"there is no answer to {path}", "the rig may have been stopped")

    async def ask_bytes(self, path: str, message: Any, timeout_s: float) -> bytes:
        async with asyncio.timeout(timeout_s):
            data: bytes = await self._answers[path](path.rpartition("/")[2], message)
        return data

    def outlet(self, path: str) -> "MemoryOutlet":
        return MemoryOutlet(self, path)

    def show_life(self, path: str) -> Callable[[], None]:
        name = path.rpartition("/")[2]
        self._tell_life(path, name, True)
        return lambda: self._tell_life(path, name, False)

    def watch_life(self, path: str, handler: Callable[[str, bool], None]) -> None:
        self._watchers.append((path, handler))
        for life in sorted(self._lives):
            if _fits(path, life):
                handler(life.rpartition("/")[2], True)

    def _tell_life(self, path: str, name: str, is_alive: bool) -> None:
        (self._lives.add if is_alive else self._lives.discard)(path)
        for pattern, handler in tuple(self._watchers):
            if _fits(pattern, path):
                handler(name, is_alive)

    async def ask_all(self, path: str, timeout_s: float) -> dict[str, Any]:
        self.asked.append(path)
        star, found = path.split("/").index("*"), {}
        for pattern, answer in self._answers.items():
            own = pattern.rpartition("/")[0] + "/" + path.rpartition("/")[2]
            if _fits(path, own) and _fits(pattern, own):
                async with asyncio.timeout(timeout_s):
                    found[own.split("/")[star]] = await _answer(answer, own, None)
        return found

    async def close(self) -> None:
        self._answers.clear()
        self._listeners.clear()

    def _look(self) -> None:
        for stream in self._streams:
            stream.look()


class MemoryStream:
    """The same calls as `fieldrig.control.messages.Stream`."""

    def __init__(self, control: MemoryControl, path: str, on_listeners: Callable[[bool], None]) -> None:
        self._control, self._path, self._on_listeners = control, path, on_listeners

    def put(self, message: str) -> None:
        self._control.put(self._path, message.encode())

    def look(self) -> None:
        self._on_listeners(self._control.has_listeners(self._path))


class MemoryOutlet:
    """The `fieldrig.control.messages.Outlet` of one process."""

    def __init__(self, control: MemoryControl, path: str) -> None:
        self._control, self._path = control, path

    def put(self, data: bytes) -> None:
        self._control.put(self._path, data)

    def end(self) -> None:
        """Nothing has to be undeclared."""


async def _answer(answer: Answer, path: str, message: Any) -> Any:
    try:
        given = await answer(path.rpartition("/")[2], read_json(json.dumps(message)))
    except ControlError:
        raise
    except ValueError as cause:
        raise ControlError(f"not understood: {cause}") from cause
    return read_json(json.dumps(given), 64 << 20, takes_nan=True)


def _fits(pattern: str, path: str) -> bool:
    """Return whether a path has the form of a pattern, in which `*` is any one part."""
    wanted, given = pattern.split("/"), path.split("/")
    return len(wanted) == len(given) and all(one in ("*", other) for one, other in zip(wanted, given, strict=True))
