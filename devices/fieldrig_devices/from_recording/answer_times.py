"""How long a unit of a recording takes to answer: its usual time, and the single times of requests that differ from it.

A gateway asks its devices for some registers and has others itself, and any device is late at times, so one time is not
enough.
"""

from collections.abc import Callable, Sequence
from statistics import median
from typing import Final

from fieldrig.clock import MS
from fieldrig_devices.from_recording.answer_log import AnswerLog
from fieldrig_devices.from_recording.modbus_log import UnitLog
from fieldrig_devices.modbus.answer_times import ADDRESS, FUNCTION, QUANTITY, TIME, Kind

FEWEST: Final = 3
"""Answers that tell the usual time of a kind of requests."""
LEAST_NS: Final = 1 * MS
"""Times that differ by no more than this are one."""
MOST_ROWS: Final = 50_000
"""Rows of the file of a unit."""


class AnswerTimes:
    """The usual time in ns, and the times of each kind of requests that takes another one, or not always the same."""

    def __init__(self, log: UnitLog, on_line_ns: Callable[[int], int], end_ns: int) -> None:
        """`on_line_ns` returns the time that an answer with a PDU of this size itself takes.

        Requests after `end_ns` that have no answer say nothing.
        """
        self._silences, self._end_ns = log.silences, end_ns
        times = {kind: self._times(kind, of_kind, on_line_ns) for kind, of_kind in log.answers_of.items()}
        answered = [[time_ns for time_ns in of_kind if time_ns is not None] for of_kind in times.values()]
        usual = [round(median(of_kind)) for of_kind in answered if len(of_kind) >= FEWEST]
        every = [time_ns for of_kind in answered for time_ns in of_kind]
        self.usual_ns = min(usual, default=round(median(every)) if every else 0)
        self.single_ns = {kind: _steady(of_kind) for kind, of_kind in times.items() if self._differs(of_kind)}

    def _times(self, kind: Kind, log: AnswerLog, on_line_ns: Callable[[int], int]) -> list[int | None]:
        line_ns = on_line_ns(log.size)
        return [
            None if time_ns is None else max(time_ns - line_ns, 0)
            for begin_ns, time_ns in log.rows()
            if time_ns is not None or self._silences.single(kind.function or 0, begin_ns, self._end_ns)
        ]

    def _differs(self, times_ns: Sequence[int | None]) -> bool:
        return any(time_ns is None or abs(time_ns - self.usual_ns) > LEAST_NS for time_ns in times_ns)

    @property
    def file(self) -> bytes:
        """The file of the emulated device that takes these times in turn."""
        rows = sum(map(len, self.single_ns.values()))
        every = -(-rows // MOST_ROWS)
        lines = [",".join((FUNCTION, ADDRESS, QUANTITY, TIME))]
        for kind in sorted(self.single_ns, key=_by_number):
            head = ",".join("" if number is None else str(number) for number in kind[1:])
            lines += (f"{head},{_ms(time_ns)}" for time_ns in self.single_ns[kind][::every])
        return ("\n".join(lines) + "\n").encode()


def _steady(times_ns: Sequence[int | None]) -> Sequence[int | None]:
    """Return one time for those that are always the same."""
    answered = [time_ns for time_ns in times_ns if time_ns is not None]
    is_steady = len(answered) == len(times_ns) and max(answered) - min(answered) <= LEAST_NS
    return [round(median(answered))] if is_steady else times_ns


def _ms(time_ns: int | None) -> str:
    return "" if time_ns is None else f"{round(time_ns / MS, 3):g}"


def _by_number(kind: Kind) -> tuple[int, ...]:
    return tuple(-1 if number is None else number for number in kind)
