"""How long a unit of a recording takes to answer: its usual time, and the single times of requests that differ from it.

A gateway asks its devices for some registers and has others itself, and any device is late at times, so one time is not
enough.
"""

from collections.abc import Callable, Collection, Sequence
from itertools import chain
from statistics import median
from typing import Final

from fieldrig.clock import MS
from fieldrig_devices.from_recording.answer_log import AnswerLog
from fieldrig_devices.from_recording.modbus_log import UnitLog
from fieldrig_devices.modbus.answer_times import ADDRESS, EXCEPTION, FUNCTION, QUANTITY, TIME, Answer, Kind

FEWEST: Final = 3
"""Answers that tell the usual time of a kind of requests."""
LEAST_NS: Final = 1 * MS
"""Times that differ by no more than this are one."""
MOST_ROWS: Final = 50_000
"""Rows of the file of a unit."""


class AnswerTimes:
    """The usual time in ns, and the answers to each kind of requests that takes another one, or not always the same."""

    def __init__(
        self, log: UnitLog, on_line_ns: Callable[[int], int], end_ns: int, refused: Collection[Kind] = ()
    ) -> None:
        """`on_line_ns` returns the time that an answer with a PDU of this size itself takes.

        Requests after `end_ns` that have no answer say nothing.  The kinds in `refused` have exceptions that nothing
        else repeats.
        """
        self._silences, self._end_ns, self._refused = log.silences, end_ns, refused
        every = {kind: self._answers(kind, of_kind, on_line_ns) for kind, of_kind in log.answers_of.items()}
        times = [_times(answers) for answers in every.values()]
        usual = [round(median(of_kind)) for of_kind in times if len(of_kind) >= FEWEST]
        self.usual_ns = min(usual, default=round(median(chain(*times))) if any(times) else 0)
        self.single = {kind: _steady(answers) for kind, answers in every.items() if self._differs(answers)}

    def _answers(self, kind: Kind, log: AnswerLog, on_line_ns: Callable[[int], int]) -> list[Answer]:
        line_ns = on_line_ns(log.size)
        return [
            Answer(
                None if answer.after_ns is None else max(answer.after_ns - line_ns, 0),
                answer.exception if kind in self._refused else 0,
            )
            for begin_ns, answer in log.rows()
            if answer.after_ns is not None or self._silences.single(kind.function or 0, begin_ns, self._end_ns)
        ]

    def _differs(self, answers: Sequence[Answer]) -> bool:
        return any(
            answer.after_ns is None or answer.exception or abs(answer.after_ns - self.usual_ns) > LEAST_NS
            for answer in answers
        )

    @property
    def file(self) -> bytes:
        """The file of the emulated device that takes these answers in turn."""
        rows = sum(map(len, self.single.values()))
        every = -(-rows // MOST_ROWS)
        lines = [",".join((FUNCTION, ADDRESS, QUANTITY, TIME, EXCEPTION))]
        for kind in sorted(self.single, key=_by_number):
            head = ",".join("" if number is None else str(number) for number in kind[1:])
            lines += (f"{head},{_ms(answer)},{answer.exception or ''}" for answer in self.single[kind][::every])
        return ("\n".join(lines) + "\n").encode()


def _times(answers: Sequence[Answer]) -> list[int]:
    return [answer.after_ns for answer in answers if answer.after_ns is not None]


def _steady(answers: Sequence[Answer]) -> Sequence[Answer]:
    """Return one answer for those that are always the same."""
    times, exceptions = _times(answers), {answer.exception for answer in answers}
    is_steady = len(times) == len(answers) and len(exceptions) == 1 and max(times) - min(times) <= LEAST_NS
    return [Answer(round(median(times)), *exceptions)] if is_steady else answers


def _ms(answer: Answer) -> str:
    return "" if answer.after_ns is None else f"{round(answer.after_ns / MS, 3):g}"


def _by_number(kind: Kind) -> tuple[int, ...]:
    return tuple(-1 if number is None else number for number in kind)
