"""The SYNC that a drive in operation misses: after some periods of 1006h it acts as if the connection were lost.

Source: docs/devices/drive-personalities.md; CiA 301, 1006h, for the period.  Error code 8700h is 'SYNC controller'.
"""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import US, Alarm, Clock
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.service import Reset, Service, State

PERIOD: Final = 0x1006
SYNC_LOST: Final = 0x8700


class SyncWatch(Service):
    """Calls `lost` once `missed` periods have passed without a SYNC, from the first SYNC on."""

    def __init__(self, clock: Clock, dictionary: Dictionary, missed: int, lost: Callable[[], None]) -> None:
        self._dictionary, self._missed, self._lost = dictionary, missed, lost
        self._due = Alarm(clock)
        self._is_operational = False

    def reset(self, scope: Reset) -> None:
        self._due.stop()

    def enter(self, state: State) -> None:
        self._is_operational = state is State.OPERATIONAL
        self._due.stop()

    def on_sync(self) -> None:
        """Take a SYNC."""
        period_ns = self._dictionary.number(PERIOD, 0) * US
        if period_ns and self._is_operational:
            self._due.after((self._missed + 1) * period_ns, self._lost)
