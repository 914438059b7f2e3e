"""DiagCode, DiagExtCode and DiagMsg of the controller and of its axes.

Source: PacDrive manual 4163-4196 (digest PD-091 to PD-098).  A diagnosis that is shown is replaced only by a more
severe one (with a lower class number), and is reset only when it is acknowledged ("quit").  A code is the class and
three digits.
"""

from collections.abc import Callable
from typing import Final, NamedTuple

MESSAGE_CLASS: Final = 8
"""First class of messages, which are logged and never pending (our reading of 8002 to 8016)."""
ERROR_CLASSES: Final = range(1, 6)
"""Classes of errors, which have a reaction; 6 is a warning, 7 a notice (digest 3)."""


class Sender(NamedTuple):
    """The source of a report: type and instance of the object, as the logger shows them."""

    object: str
    instance: str


MAX4: Final = Sender("MAX4", "MAX4")
"""The controller itself."""
LZS: Final = Sender("LZS", "LZS")
"""The run-time system."""


class Pending(NamedTuple):
    """A diagnosis that is pending."""

    code: int
    """The code as it is shown: class and three digits."""
    ext: str
    msg: str
    is_quittable: bool

    @property
    def diagnosis_class(self) -> int:
        return self.code // 1000


NOTHING: Final = Pending(0, "", "", True)


class Diagnosis:
    """The pending diagnoses of one object.  `reports.Reports` maintains them; faces only read them."""

    def __init__(self, on_change: Callable[[], None]) -> None:
        self._on_change = on_change
        self._shown = NOTHING
        self._pending: list[Pending] = []

    @property
    def code(self) -> int:
        """DiagCode; 0 if no diagnosis is pending."""
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
        """The pending diagnoses in the order of their arrival."""
        return tuple(self._pending)

    @property
    def is_error(self) -> bool:
        """True if an error is pending."""
        return any(pending.diagnosis_class in ERROR_CLASSES for pending in self._pending)

    def add(self, pending: Pending) -> None:
        """Add a diagnosis, unless the same one is pending from the same place."""
        if all((other.code, other.ext) != (pending.code, pending.ext) for other in self._pending):
            self._pending.append(pending)
        if self._shown.code == 0 or pending.diagnosis_class < self._shown.diagnosis_class:
            self._shown = pending
        self._on_change()

    def quit(self, is_gone: Callable[[Pending], bool] = lambda _pending: True) -> None:
        """Acknowledge the diagnoses for which `is_gone` is true; the most severe of the others is shown."""
        self._keep([pending for pending in self._pending if not (pending.is_quittable and is_gone(pending))])

    def reset(self) -> None:
        """Remove all diagnoses, at power-off and at a boot."""
        self._keep([])

    def withdraw(self, code: int) -> None:
        """Remove a diagnosis that cannot be acknowledged, such as a task error when the tasks are reset."""
        self._keep([pending for pending in self._pending if pending.code != code])

    def _keep(self, rest: list[Pending]) -> None:
        if len(rest) != len(self._pending):
            self._pending = rest
            self._shown = min(rest, key=lambda pending: pending.diagnosis_class, default=NOTHING)
            self._on_change()
