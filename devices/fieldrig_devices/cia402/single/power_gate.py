"""The supply without which a drive stays in 'switch on disabled', and what an open STO input does at the start.

Source: docs/devices/drive-personalities.md.  By the book a drive without power passes to 'ready to switch on' and waits
there.
"""

from collections.abc import Callable

from fieldrig.clock import MS, Alarm, Clock
from fieldrig_devices.cia402.single.personality import PersonalitySettings
from fieldrig_devices.cia402.single.servo import Servo


class PowerGate:
    """`changed` is called when the time without mains has passed."""

    def __init__(self, clock: Clock, motor: Servo, manner: PersonalitySettings, changed: Callable[[], None]) -> None:
        self._motor, self._manner, self._changed = motor, manner, changed
        self._due = Alarm(clock)
        self._had_mains = True
        self._is_over = False

    def is_open(self) -> bool:
        """Return False as long as the drive has to stay in 'switch on disabled'."""
        return (not self._manner.needs_mains or self._has_mains()) and (
            not self._manner.needs_sto or self._motor.may_turn
        )

    def _has_mains(self) -> bool:
        """True while there are mains, and for some time after they are lost."""
        has_mains, had_mains = self._motor.has_mains, self._had_mains
        self._had_mains = has_mains
        if has_mains:
            self._due.stop()
            self._is_over = False
        elif had_mains:
            self._is_over = not self._manner.mains_ms
            self._due.after(round(self._manner.mains_ms * MS), self._end)
        return not self._is_over

    def _end(self) -> None:
        self._is_over = True
        self._changed()
