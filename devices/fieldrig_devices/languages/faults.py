"""Run-time faults: what a user's program did that stops its task, and where."""

from types import FrameType, TracebackType
from typing import Final

from fieldrig_devices.languages.resumable import Activation, Code, file_name
from fieldrig_devices.languages.writer import Build, Line


class RunError(Exception):
    """Raised by the functions that generated code calls, for a fault of the program itself."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


CAUGHT: Final = (RunError, ZeroDivisionError, IndexError, OverflowError, ValueError)
"""Exceptions that generated code may raise because of the program; everything else is a fault of ours."""


def places(code: Code, build: Build, fault: BaseException) -> tuple[list[Activation], int]:
    """Return the routines that were running, outermost first, and the budget that was left.

    Each place is the instruction that was running, a call for all but the last.
    """
    files = {file_name(number): number for number in range(len(code.routines))}
    calls, budget = [], 0
    trace: TracebackType | None = fault.__traceback__
    while trace is not None:
        number = files.get(trace.tb_frame.f_code.co_filename)
        if number is not None:
            line = code.lines(number, build)[trace.tb_lineno - 1]
            calls += _places(number, line, trace.tb_frame)
            budget = trace.tb_frame.f_locals["n"] - line.spent
        trace = trace.tb_next
    return calls, budget


def running(code: Code, build: Build, frame: FrameType | None) -> list[Activation]:
    """Return the routines that are running, outermost first, for a function that they have called with this frame."""
    files = {file_name(number): number for number in range(len(code.routines))}
    calls: list[Activation] = []
    while frame is not None:
        number = files.get(frame.f_code.co_filename)
        if number is not None:
            calls[:0] = _places(number, code.lines(number, build)[frame.f_lineno - 1], frame)
        frame = frame.f_back
    return calls


def _places(number: int, line: Line, frame: FrameType) -> list[Activation]:
    """Return the place in a routine, and those in the routines that are inlined there."""
    where = frame.f_locals["frame"], frame.f_locals["base"]
    return [Activation(routine, pc, *where) for routine, pc in ((number, line.pc), *line.calls)]
