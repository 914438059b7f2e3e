"""A rig in a keeper that goes back, and its answers about time as `fieldrig up` gives them, without messages."""

import asyncio
from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import Any

from fieldrig.config.rig_file import RigConfig
from fieldrig.virtual.journey import Journey, Search
from fieldrig.virtual.keeper import keep

SLICE_S = 600.0
"""Longer than any slice of a test."""


class TravellingRig:
    """A rig that the test lets run."""

    def __init__(self, journey: Journey, device: str) -> None:
        self.journey, self._device = journey, device
        self.is_running = True
        """False after a way back, until a user lets the rig run."""

    @property
    def now_ns(self) -> int:
        return self.journey.now_ns

    def run_until(self, until_ns: int) -> None:
        while not self.journey.play(until_ns, SLICE_S).is_reached:
            pass

    def run_for(self, duration_ns: int) -> None:
        self.run_until(self.now_ns + duration_ns)

    def ask(self, message: Any) -> dict[str, Any]:
        """Put a question to the debugging service."""
        answer: dict[str, Any] = self.journey.answer(self._device, "debug", message)
        return answer

    def ask_rig(self, verb: str, message: Any) -> dict[str, Any]:
        """Put a question to the rig."""
        match verb, message:
            case "run", None:
                self.is_running = True
            case "back", {"ns": int(ns)}:
                self.is_running = False
                self.journey.back(ns)
            case (("back" | "last"), {"search": search}):
                self.is_running &= verb != "back"
                find = self.journey.go_to if verb == "back" else self.journey.find
                return {"found": asyncio.run(find(Search(**search), message.get("before_ns")))}
        state = "running" if self.is_running else "paused"
        return {"state": state, "now_ns": self.now_ns, "time": "virtual", "first_ns": self.journey.first_ns}


@contextmanager
def travelling(config: RigConfig, device: str) -> Iterator[TravellingRig]:
    """Yield a rig at its start; `device` has the program."""
    kept = keep(config)
    kept.wait_until_built()
    kept.trace_hash()
    with closing(Journey(kept)) as journey:
        yield TravellingRig(journey, device)
