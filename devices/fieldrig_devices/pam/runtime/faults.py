"""Faults of an application, which stop it, as far as they are its own."""

from dataclasses import dataclass

from fieldrig_devices.languages.faults import RunError
from fieldrig_devices.pam.runtime import arithmetic


@dataclass(frozen=True, slots=True)
class Fault:
    """Why the application has stopped."""

    code: str
    text: str
    title: str
    """The program, such as TSK_a.SEQ_b."""
    file: str
    line: int

    def __str__(self) -> str:
        where = f" in {self.title}" if self.title else ""
        return f"{self.code}: {self.text}{where} ({self.file}:{self.line})"


def reason(cause: BaseException) -> tuple[str, str]:
    """Return the code and the text of a fault.  One of an object, and not of the program, is raised again.

    Only generated code and the functions of numbers compute for the program.
    """
    if isinstance(cause, RunError):
        return cause.code, cause.text
    if not _is_of_program(cause):
        raise cause
    if isinstance(cause, ZeroDivisionError):
        return arithmetic.REAL_FAULT, "a division of a real by zero"
    return arithmetic.REAL_FAULT, "an overflow or an invalid operation of reals"


def _is_of_program(fault: BaseException) -> bool:
    trace = fault.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    file = "<" if trace is None else trace.tb_frame.f_code.co_filename
    return file.startswith("<") or file == arithmetic.__file__
