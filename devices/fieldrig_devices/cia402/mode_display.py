"""When 6061h shows the mode of operation: at once, after a time, or only while the drive is enabled."""

from collections.abc import Callable

from fieldrig.clock import MS, Alarm, Clock
from fieldrig_devices.cia402.behaviour import Behaviour, ModeDisplay


class ModeDisplayed:
    """The value of 6061h; `changed` is called when it changes by itself."""

    def __init__(self, clock: Clock, behaviour: Behaviour, changed: Callable[[], None]) -> None:
        self._behaviour, self._changed = behaviour, changed
        self._due = Alarm(clock)
        self._delay_ns = round(behaviour.mode_display_ms * MS)
        self._shown = self._coming = 0

    def restart(self) -> None:
        """Show no mode, as after power-on."""
        self._due.stop()
        self._shown = self._coming = 0

    def of(self, mode: int, is_enabled: bool) -> int:
        """Return what is shown while the drive is in `mode`."""
        if self._behaviour.mode_display is ModeDisplay.ENABLED and not is_enabled:
            return self._shown
        if mode == self._coming:
            return self._shown
        self._coming = mode
        if self._delay_ns:
            self._due.after(self._delay_ns, self._show)
        else:
            self._shown = mode
        return self._shown

    def _show(self) -> None:
        self._shown = self._coming
        self._changed()
