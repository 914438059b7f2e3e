"""Events of a rig, such as the end of one of its processes, as they are published for `up`, `watch` and the page."""

import time
from typing import Any, NamedTuple


class Event(NamedTuple):
    """Something that a user may want to know: ready, died, gone, failed, late, warning, stopping, stopped."""

    what: str
    process: str
    """The name of the process; empty for the rig as a whole."""
    text: str
    time_s: float
    """The time of day."""


def event(what: str, process: str = "", text: str = "") -> Event:
    """Return an event of this moment."""
    return Event(what, process, text, time.time())


def in_words(event: Event) -> str:
    """Return `died: exit code 1`, or `ready` where there is no more to say."""
    return f"{event.what}: {event.text}" if event.text else event.what


def taken(message: Any) -> Event | None:
    """Return an event that was published; None for anything else."""
    match message:
        case {"what": str(what), "process": str(process), "text": str(text), "time_s": int() | float() as time_s}:
            return Event(what, process, text, float(time_s))
    return None
