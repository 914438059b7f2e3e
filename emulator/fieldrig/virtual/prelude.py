"""A prelude to a rig in virtual time: what happens before its user has it, such as a scenario up to a failure."""

from collections.abc import Awaitable, Callable
from typing import Any, Final, Protocol

from fieldrig.virtual.journey import Journey

QUESTION: Final = "prelude"
"""The questions about it are `prelude/VERB`."""
RunUntil = Callable[[int], Awaitable[None]]
"""Lets the rig run to an instant."""


class Prelude(Protocol):
    name: str
    """Its name in `status`, under `prelude`."""

    async def play(self, journey: Journey, run_until: RunUntil) -> None:
        """Play it to the rig, which stands still afterwards.  RigError if that is not possible."""

    async def answer(self, verb: str, message: Any) -> Any:
        """Answer a question about it.  ControlError for a question that it does not know."""
