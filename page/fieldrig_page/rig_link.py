"""The connection of the page's process to the rig: questions, their answers, and what the rig publishes.

It is the only way from the page to a rig, and the same as that of the command line, so the page can do nothing that
`fieldrig` cannot.
"""

import asyncio
from collections.abc import Callable
from typing import Any, Final

from fieldrig.config.rig_file import RigConfig
from fieldrig.control.messages import Control

ANSWER_S: Final = 5.0
"""Time limit of a question, in seconds."""
ALL_ANSWERS_S: Final = 1.0
"""Time limit of a question to many: a process that is stopped is left out then."""
FRESH_S: Final = 0.4
"""Longest age of an answer of `recent`, in seconds."""

End = Callable[[], None]
"""Ends a subscription; a second call does nothing."""


class RigLink:
    """The rig, as the modules of the page see it.  Call everything in the thread of the loop."""

    def __init__(self, config: RigConfig, control: Control) -> None:
        self.config = config
        """The rig file as the rig was started with it, with its `--set`."""
        self.control = control
        self._recent: dict[str, tuple[float, asyncio.Task[Any]]] = {}

    async def ask(self, path: str, message: Any = None, timeout_s: float = ANSWER_S) -> Any:
        """Return the answer to a question such as `device/tank/get`.

        ControlError, with `what` and `remedy`, if the rig refuses; NoAnswerError if there is no answer in time.
        """
        return await self.control.ask(path, message, timeout_s)

    async def ask_all(self, path: str, timeout_s: float = ALL_ANSWERS_S) -> dict[str, Any]:
        """Return every positive answer to a path with a `*`, by the key part in its place."""
        return await self.control.ask_all(path, timeout_s)

    async def recent(self, path: str) -> Any:
        """Return an answer that is at most `FRESH_S` old; a path with a `*` is asked as `ask_all` does.

        Topics, pages and the HTTP API that want the same at the same time share one question.
        """
        loop = asyncio.get_running_loop()
        asked_s, answer = self._recent.get(path, (0.0, None))
        if answer is None or (answer.done() and loop.time() - asked_s > FRESH_S):
            question = self.ask_all(path) if "*" in path else self.ask(path)
            answer = loop.create_task(question)
            self._recent[path] = loop.time(), answer
        return await asyncio.shield(answer)  # one that waits and is cancelled takes nothing from the others

    def listen_to(self, path: str, handler: Callable[[str, Any], None]) -> End:
        """Call `handler(last key part, message)` for every message published at the path, until it is ended."""
        return self.control.listen_to(path, handler)

    def subscribe_bytes(self, path: str, handler: Callable[[str, bytes], None]) -> End:
        """Call `handler(last key part, bytes)` for everything published in binary at the path, until it is ended."""
        return self.control.listen_to_bytes(path, handler)
