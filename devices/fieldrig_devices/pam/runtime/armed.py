"""The exception of a sequence that is armed (section 2.17)."""

from typing import Protocol

from fieldrig_devices.pam.runtime.lower.lowered import ExceptionSite
from fieldrig_devices.pam.runtime.readings import Readings
from fieldrig_devices.pam.runtime.waits import Waiting
from fieldrig_devices.pam.runtime.watches import is_polled_event


class Interrupted(Waiting, Protocol):
    """A task as the exception of its sequence knows it."""

    readings: Readings

    def on_exception(self) -> None:
        """The event of the exception has occurred: the present statement is completed first (PAML-377)."""


class Armed:
    """An exception with its time-out.

    Its event is remembered while the sequence is suspended, and wakes its task (PAML-376, G-21).  An exception that has
    fired is armed again when its event has been false (G-44).
    """

    def __init__(self, task: Interrupted, site: ExceptionSite, deadline: int | None) -> None:
        self._task, self.site, self.deadline = task, site, deadline
        self._is_polled = is_polled_event(site.formula, task.readings)
        self._is_armed = True
        self.is_latched = False

    def begin(self) -> None:
        """Arm it; an event that is true already occurs at once (PAML-373)."""
        task, formula = self._task, self.site.formula
        task.watches.add(formula, task.item, self.look)
        if self.deadline is not None:
            task.enter(self.deadline)
        self.look()
        self.poll()

    def look(self) -> None:
        """Evaluate the event; called at each change."""
        now = self._task.value(self.site.formula)
        if now is None:
            return
        if not now:
            self._is_armed = True
        elif self._is_armed and not self.is_latched:
            self.is_latched = True
            self._task.on_exception()

    def poll(self) -> None:
        if self._is_polled:
            self._task.enter(self._task.cycle + 1)

    @property
    def is_late(self) -> bool:
        return self.deadline is not None and self._task.cycle >= self.deadline

    @property
    def has_occurred(self) -> bool:
        if self._is_polled:
            self.look()
            self.poll()
        return self.is_latched or self.is_late

    def take(self) -> bool:
        """Consume the event; return True if it was the time-out."""
        is_timeout = not self.is_latched
        self.is_latched = False
        if is_timeout:
            self.deadline = None
        else:
            self._is_armed = self._task.value(self.site.formula) is False
        return is_timeout

    def end(self) -> None:
        self._task.watches.remove(self.site.formula, self._task.item, self.look)
