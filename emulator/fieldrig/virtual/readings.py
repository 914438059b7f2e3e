"""The points that a condition reads, with their last changes: what a test sees if the condition is never met."""

from collections import deque
from typing import Final

from fieldrig.clock import S
from fieldrig.device import Value

MOST_CHANGES: Final = 5
"""Number of values that are kept of each point."""
MOST_POINTS: Final = 20
"""Number of points that a message shows."""


class Readings:
    def __init__(self) -> None:
        self._changes: dict[str, deque[tuple[int, Value]]] = {}

    def note(self, device: str, key: str, now_ns: int, value: Value) -> None:
        """Keep a value that was read, if it differs from the one before."""
        point = f"{device}/{key}"
        changes = self._changes.setdefault(point, deque(maxlen=MOST_CHANGES))
        if not changes or changes[-1][1] != value:
            changes.append((now_ns, value))

    def text(self) -> str:
        """Return a line for each point with its value and the values before it, or a hint if no point was read."""
        if not self._changes:
            return 'it read no point of the rig, such as rig.get("tank/level")'
        lines = [_line(point, list(changes)) for point, changes in self._changes.items()]
        more = [f"and {len(lines) - MOST_POINTS} more points"] if len(lines) > MOST_POINTS else []
        return "\n  ".join(lines[:MOST_POINTS] + more)


def seconds(time_ns: int) -> str:
    """Return a time with its unit and all of its digits, such as `2.0005 s`."""
    whole, rest = divmod(abs(time_ns), S)
    sign = "-" if time_ns < 0 else ""
    return f"{sign}{whole}.{rest:09}".rstrip("0").rstrip(".") + " s"


def _line(point: str, changes: list[tuple[int, Value]]) -> str:
    (since_ns, value), before = changes[-1], changes[:-1]
    told = ", ".join(f"{earlier!r} at {seconds(at_ns)}" for at_ns, earlier in before)
    return f"{point} = {value!r}" + (f" since {seconds(since_ns)}; before that {told}" if told else ", unchanged")
