"""An undisturbed cycle of a drive that only follows its set position, as one function: from MST and MDT to the AT.

Slave, ring side and axis do the same one after the other.  But where each drive has a process, all that a cycle touches
is cold, for forty others have had the processor since; then what counts is how little that is.  Whatever is otherwise
than in the cycle before it leaves to them, and has changed nothing.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Final, NamedTuple, cast

from fieldrig_bus.ring.message import BROADCAST, Straight
from fieldrig_devices.mc4.folded import Arrangement, Numbers, compiled, course_lines, following_lines
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.service import CONTROL_MASK
from fieldrig_devices.sercos.slave import RUNNING_MST

BEGINNING: Final = RUNNING_MST + bytes((BROADCAST,))
ENDING: Final = words.APPLICATION_MASK | CONTROL_MASK
"""Bits of the control word that ask for more than to follow when they change."""


class Frame(NamedTuple):
    """Where in MST and MDT a drive finds what it needs."""

    cycle_ns: int
    length: int
    """Of both, in bytes."""
    position: int
    """Of its record, in bytes from the beginning of the MST."""
    place: int
    """Of the set position among the values of the record."""


@lru_cache(maxsize=256)
def straight(arrangement: Arrangement, numbers: Numbers, frame: Frame, *, is_told: bool) -> Callable[..., Straight]:
    """Makes the way of one drive; of `is_told`, others are told where its load is, and must not be led astray.

    It takes axis, machine and slave, the reader of the record, control word, the time at which slow things are due,
    the largest following error (rad), head and end of the AT, and what was told last (`Course`) or None.
    """
    slack_ns = frame.cycle_ns // 2
    checks = course_lines(arrangement.plant.elastic is not None) if is_told else []
    lines = [
        f"if now_ns >= until_ns or len(data) != start + {frame.length} or data[start : start + 3] != {BEGINNING!r}:",
        "    return None",
        f"at_ns = machine.at_ns + {frame.cycle_ns}",
        f"if not {-slack_ns} < now_ns - at_ns < {slack_ns}:",
        "    return None",
        f"values = read(data, start + {frame.position})",
        f"if (values[0] ^ control) & {ENDING}:",
        "    return None",
        f"wanted = values[{frame.place}]",
        *(line[4:] for line in following_lines(arrangement, checks)),
        "machine.at_ns = at_ns",
        "slave.values = values",
        "slave.heard += 1",
        "watchdog.due_ns = now_ns + window_ns",
        f"return head + {numbers.packed} + standing",
    ]
    text = [
        "def lay(axis, machine, slave, read, control, until_ns, most_error, head, standing, course):",
        "    watchdog, window_ns = slave.watchdog, slave.window_ns",
        "    def straight(now_ns, data, start):",
        *("        " + line for line in lines),
        "    return straight",
    ]
    return cast(Callable[..., Straight], compiled("\n".join(text), "lay", pack=numbers.pack, len=len))
