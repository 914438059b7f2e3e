"""The facts that a recording has of a Modbus unit, and those that it lacks, in sentences."""

from collections.abc import Iterator
from typing import Final

from fieldrig.clock import MS
from fieldrig.points.values import counted
from fieldrig.traces.instants import span
from fieldrig_bus.modbus.codec import EXCEPTIONS, FUNCTIONS
from fieldrig_devices.from_recording.modbus_log import UnitLog
from fieldrig_devices.from_recording.register_log import Group, GroupLog
from fieldrig_devices.from_recording.rhythm import period_of
from fieldrig_devices.registers.table import SPACES

NAMES: Final = dict(zip(SPACES, ("coil", "discrete input", "holding register", "input register"), strict=True))
"""The word for one value of a space."""


def seen(log: UnitLog, asked_as: int, unit_id: int, turnaround_ms: float, silences: int) -> Iterator[str]:
    """Yield what the recording says of a unit that it calls `asked_as`, and the rig `unit_id`."""
    counts = [counted(len(log.spaces[space]), NAMES[space]) for space in SPACES if log.spaces[space]]
    words = f"unit {asked_as}: {', '.join(counts) or 'no register'}"
    if log.answers_of:
        words += f"; it answers after {span(round(turnaround_ms * MS))}, at most {span(log.longest_answer_ns)}"
    yield words
    if silences:
        yield f"{counted(log.unanswered, 'request')} had no answer: its faults `silent` are silent in the same times"
    if asked_as != unit_id:
        yield f"unit {asked_as} is the device itself, which has the unit id {unit_id} here"


def unknown(log: UnitLog) -> Iterator[str]:
    """Yield what is not known."""
    yield "registers that no master read or wrote: they do not exist here (exception 02)"
    yield "names, units and types: a value in several registers is several numbers here, unless its type is certain"
    if log.unanswered:
        yield f"why {counted(log.unanswered, 'request')} had no answer"
    for function, count in sorted(log.functions.items()):
        yield f"what function {function} has answered {counted(count, 'time')}: nothing is taken of it"
    if log.left_out:
        yield f"{counted(log.left_out, 'request')} of further groups, which are too many"


def group_words(group: Group) -> str:
    """Return a group as in `read holding registers 0 to 9`."""
    what = FUNCTIONS.get(group.function, f"function {group.function}")
    last = group.address + group.quantity - 1
    return f"{what} {group.address}" + (f" to {last}" if group.quantity > 1 else "")


def exception_words(code: int) -> str:
    return f"exception {code:02d} ({EXCEPTIONS.get(code, 'unknown')})"


def use_words(group: Group, log: GroupLog) -> str:
    """Return how a master uses a group."""
    words = f"{group_words(group)}: {counted(log.count, 'time')}"
    if log.count > 2:
        words += f", every {span(period_of(log.instants))}"
    refused = [f"{exception_words(code)} {counted(times, 'time')}" for code, times in log.refused.items()]
    return words + (f"; {', '.join(refused)}" if refused else "")
