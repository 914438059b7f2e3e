"""DiagCode, DiagExtCode and DiagMsg of the controller and of its axes.

Source: PacDrive manual 4163-4196 (digest PD-091 to PD-098).  What is shown is overwritten only by a diagnosis of a
higher class (a lower number), and reset only by quitting.  A code is the class and three digits.
"""

from collections.abc import Callable
from typing import Final, NamedTuple

MESSAGE_CLASS: Final = 8
"""From here on entries are messages: logged, and never pending (our reading: 8002 to 8016 are no diagnoses)."""
ERROR_CLASSES: Final = range(1, 6)
"""Classes that have a reaction; 6 is a warning, 7 a notice (digest 3)."""


class Sender(NamedTuple):
    """Who reports: the object's type and its instance, as the logger shows them."""

    object: str
    instance: str


class Pending(NamedTuple):
    code: int
    """Class and three digits, as shown."""
    ext: str
    msg: str
    is_quittable: bool

    @property
    def diagnosis_class(self) -> int:
        return self.code // 1000


NOTHING: Final = Pending(0, "", "", True)


class Diagnosis:
    """What is pending for one object.  Kept by `reports.Reports`; faces only read it."""

    def __init__(self, on_change: Callable[[], None]) -> None:
        self._on_change = on_change
        self._shown = NOTHING
        self._pending: list[Pending] = []

    @property
    def code(self) -> int:
        """DiagCode; 0: nothing is pending."""
        return self._shown.code

    @property
    def ext(self) -> str:
        """DiagExtCode."""
        return self._shown.ext

    @property
    def msg(self) -> str:
        """DiagMsg."""
        return self._shown.msg

    @property
    def pending(self) -> tuple[Pending, ...]:
        """In the order of coming."""
        return tuple(self._pending)

    @property
    def is_error(self) -> bool:
        return any(one.diagnosis_class in ERROR_CLASSES for one in self._pending)

    def add(self, one: Pending) -> None:
        """What is pending already, from the same place, stays where it is."""
        if all((other.code, other.ext) != (one.code, one.ext) for other in self._pending):
            self._pending.append(one)
        if self._shown.code == 0 or one.diagnosis_class < self._shown.diagnosis_class:
            self._shown = one
        self._on_change()

    def quit(self, goes: Callable[[Pending], bool] = lambda _one: True) -> None:
        """Everything goes that may be quitted and that `goes`; of the rest the most severe is shown."""
        self._keep([one for one in self._pending if not (one.is_quittable and goes(one))])

    def reset(self) -> None:
        """Power-off, or a boot: nothing is pending."""
        self._keep([])

    def withdraw(self, code: int) -> None:
        """One goes though it can't be quitted, as a task error with the reset of the tasks."""
        self._keep([one for one in self._pending if one.code != code])

    def _keep(self, rest: list[Pending]) -> None:
        if len(rest) != len(self._pending):
            self._pending = rest
            self._shown = min(rest, key=lambda one: one.diagnosis_class, default=NOTHING)
            self._on_change()
