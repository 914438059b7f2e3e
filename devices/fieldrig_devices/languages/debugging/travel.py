"""The way back in a rig in virtual time, by lines and changes of the program of one device.

A search of the past is a question to the rig (`virtual/journey.py`), which repeats the past in branches and has the
debugging service look there.  Breakpoints belong to the session and not to the past, so they are set again after it.
"""

from collections.abc import Callable, Mapping
from typing import Any, Final
from uuid import uuid4

from fieldrig_devices.languages.debugging.probes import OUTSIDE

Ask = Callable[[Mapping[str, Any]], dict[str, Any]]
"""Puts a question to the debugging service of the device."""
AskRig = Callable[[str, Any], dict[str, Any]]
"""Puts a question to the rig.  RigError if it refuses."""
DEEPEST: Final = 1_000
"""More callers than any routine has."""
REAL_TIME: Final = "a rig in real time cannot go back\nstart it with `time: virtual`"
NO_LINE: Final = "there is no line before this"


class Travel:
    """The past of a rig, as its program sees it."""

    def __init__(self, device: str, ask: Ask, ask_rig: AskRig) -> None:
        self._device, self._ask, self._ask_rig = device, ask, ask_rig
        self._is_held = False

    @property
    def is_possible(self) -> bool:
        """True if the rig can go back."""
        return self._ask_rig("status", None).get("first_ns") is not None

    @property
    def rig_pause_ns(self) -> int | None:
        """The instant at which the rig stands still; None while it runs."""
        status = self._ask_rig("status", None)
        return int(status["now_ns"]) if status.get("state") == "paused" else None

    @property
    def is_held(self) -> bool:
        """True if a program that goes on lets the paused rig run."""
        return self._is_held

    def back(self, ns: int) -> None:
        """Go back to an instant."""
        self._with_breakpoints(lambda: self._ask_rig("back", {"ns": ns}))

    def back_by_line(self, thread: int) -> Mapping[str, Any]:
        """Go back to the line before, over calls, or to the last one of a thread that is between two cycles.

        Return what was found.
        """
        frames = self._ask({"command": "stack", "thread": thread})["frames"]
        return self._go({"thread": thread, "depth": len(frames) - 1 if frames else DEEPEST}, NO_LINE)

    def back_to(self, file: str, line: int) -> Mapping[str, Any]:
        """Go back to the last time at a line, or else at the next one with an instruction.  ValueError if none has."""
        [place] = self._ask({"command": "breakpoints", "file": file, "lines": [line]})["places"]
        if place is None:
            raise ValueError(f"there is no instruction at or after {file}:{line}")
        return self._go({"places": [{"file": file, "line": place}]}, f"{file}:{place} has not run before this")

    def reverse_continue(self) -> Mapping[str, Any]:
        """Go back to the last breakpoint, or before the last change of a watched variable."""
        places = [stop for stop in self._ask({"command": "breakpoints"})["breakpoints"] if not stop["log"]]
        names = self._ask({"command": "watch"})["names"]
        if not places and not names:
            raise ValueError("there is nothing to stop at\nexpected a breakpoint or a watched variable first")
        return self._go({"places": places, "names": names}, "there is no breakpoint and no change before this")

    def last_change(self, name: str) -> Mapping[str, Any]:
        """Return where and when a variable got the value that it has.  ValueError if the past does not tell."""
        self._check()
        found = self._ask_rig("last", self._search({"names": [name]}))["found"]
        return self._checked(found, f"{name} has not changed")

    def hold(self) -> None:
        """Take note that the rig is paused, so that a program that goes on lets it run."""
        self._is_held = True

    def run(self) -> None:
        """Let the rig run on, if a way back has paused it."""
        if self._is_held:
            self._is_held = False
            self._ask_rig("run", None)

    def _go(self, wish: Mapping[str, Any], nothing: str) -> Mapping[str, Any]:
        message = self._search(wish)
        return self._checked(self._with_breakpoints(lambda: self._ask_rig("back", message))["found"], nothing)

    def _search(self, wish: Mapping[str, Any]) -> dict[str, Any]:
        """Return the question; the past of a program that stands ends where it has stopped.

        Changes alone are looked for up to now, if other tasks have run on meanwhile.
        """
        state, name = self._ask({"command": "state"}), uuid4().hex
        is_running = any(thread["state"] == "running" for thread in state["threads"])
        ends_at_stop = state["state"] == "paused" and not (
            is_running and not wish.get("places") and "thread" not in wish
        )
        search = {
            "device": self._device,
            "question": "debug",
            "begin": {"command": "probe", "probe": name, **wish},
            "look": {"command": "found", "probe": name},
        }
        return {"search": search} | ({"before_ns": state["stopped_ns"]} if ends_at_stop else {})

    def _checked(self, found: Mapping[str, Any], nothing: str) -> Mapping[str, Any]:
        if found["number"]:
            return found
        first_s = self._ask_rig("status", None)["first_ns"] / 1e9
        raise ValueError(f"{nothing}: the past that the rig remembers begins at {first_s:g} s")

    def _check(self) -> None:
        """ValueError or RigError, which say why, for a rig that cannot go back."""
        status = self._ask_rig("status", None)
        if status["time"] != "virtual":
            raise ValueError(REAL_TIME)
        if status["first_ns"] is None:
            self._ask_rig("back", {"ns": 0})  # the rig says why not

    def _with_breakpoints(self, go: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Go back, and have the breakpoints of now there too."""
        stops = self._ask({"command": "breakpoints"})["breakpoints"]
        names = self._ask({"command": "watch"})["names"]
        self._check()
        answer = go()
        self._is_held = True
        self._ask({"command": "probe", "over": self._ask({"command": "probe"})["due"]})
        self._ask({"command": "watch", "names": names})
        there = self._ask({"command": "breakpoints"})["breakpoints"]
        for file in sorted({stop["file"] for stop in (*stops, *there)}):
            wanted = [stop for stop in stops if stop["file"] == file]
            self._ask({"command": "breakpoints", "file": file, "breakpoints": wanted})
        return answer


def changed(found: Mapping[str, Any]) -> str:
    """Return a change that was found in words, such as `count 4 -> 5 at 1.25 s by count.st:7`."""
    change = found["change"]
    by = OUTSIDE if change["file"] is None else f"{change['file']}:{change['line']}"
    words = "from" if change["file"] is None else "by"
    return f"{change['name']} {change['before']} -> {change['after']} at {found['at_ns'] / 1e9:.9g} s {words} {by}"
