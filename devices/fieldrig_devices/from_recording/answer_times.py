"""How long a unit of a recording takes to answer: its usual time, and the groups of registers that take longer.

A gateway asks its devices for some registers and has others itself, so one time is not enough.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from statistics import median
from typing import Any, Final

from fieldrig.clock import MS
from fieldrig_devices.from_recording.modbus_log import UnitLog
from fieldrig_devices.from_recording.register_log import Group

FEWEST: Final = 3
"""Answers that tell the time of a group."""
LEAST_NS: Final = 5 * MS
LEAST_SHARE: Final = 0.25
"""A group that takes longer by no more than this takes the usual time."""
MOST: Final = 50
"""Groups whose times are repeated."""


class AnswerTimes:
    """The usual time in ns, and the time by which each slow group takes longer."""

    def __init__(self, log: UnitLog, on_line_ns: Callable[[int], int]) -> None:
        """`on_line_ns` returns the time that an answer with a PDO of this size itself takes."""
        groups = {
            group: max(round(median(of_group.answer_ns)) - on_line_ns(len(of_group.sample[1])), 0)
            for group, of_group in log.groups.items()
            if of_group.sample is not None and len(of_group.answer_ns) >= FEWEST
        }
        every = [time_ns - on_line_ns(size) for time_ns, size in zip(log.answer_ns, log.answer_sizes, strict=True)]
        self.usual_ns = max(min(groups.values(), default=round(median(every)) if every else 0), 0)
        least_ns = max(LEAST_NS, round(LEAST_SHARE * self.usual_ns))
        slow = {group: time_ns - self.usual_ns for group, time_ns in groups.items()}
        self._slow = {group: later_ns for group, later_ns in slow.items() if later_ns > least_ns}
        self._groups = log.groups.keys()

    @property
    def faults(self) -> list[dict[str, Any]]:
        """The faults of the emulated device that answers slow groups later."""
        return [
            {"what": "slow", "function": group.function, "address": address, "delay_ms": round(later_ns / MS, 1)}
            for group, address, later_ns in _placed(self._slow, self._groups)
        ][:MOST]


def _placed(slow: Mapping[Group, int], groups: Iterable[Group]) -> Iterator[tuple[Group, int, int]]:
    """Yield the slow groups, each with an address that no other group has which is not yielded before.

    The first fault that names an address of a request counts, so large groups come before their parts.  A group without
    such an address is left out.
    """
    others = set(groups)
    for group, later_ns in sorted(slow.items(), key=lambda item: (-item[0].quantity, item[0])):
        taken = {
            address for other in others - {group} if other.function == group.function for address in other.addresses
        }
        free = next((address for address in group.addresses if address not in taken), None)
        if free is not None:
            others.discard(group)
            yield group, free, later_ns
