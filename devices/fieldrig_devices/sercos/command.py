"""Procedure commands: what a drive is asked to do, and takes its time for.

Source: IEC 61491 by its public facts: the master writes 3 to set and enable the command, reads its status as the first
element, and writes 0 to clear it.
"""

from collections.abc import Callable

from fieldrig_devices.sercos.datum import Datum
from fieldrig_devices.sercos.idn import Code, ServiceError


class Command:
    """A procedure command: the master sets it to 3, then its status tells how it goes."""

    CLEARED, DONE, INTERRUPTED, ACTIVE, FAILED = 0x0, 0x3, 0x5, 0x7, 0xF

    def __init__(
        self,
        datum: Datum,
        start: Callable[["Command"], None],
        on_change: Callable[[bool], None],
        cancel: Callable[[], None] | None = None,
    ) -> None:
        """`start` ends, now or later, with `finish`; it may raise ServiceError.

        `on_change` tells whether the command has ended and is not yet cleared.
        """
        self._datum, self._start, self._on_change, self._cancel = datum, start, on_change, cancel
        datum.writer = self._write

    @property
    def is_active(self) -> bool:
        return self._datum.status == self.ACTIVE

    def finish(self, *, is_good: bool = True) -> None:
        if self.is_active:
            self._datum.status = self.DONE if is_good else self.FAILED
            self._on_change(True)

    def reset(self) -> None:
        """The ring went down: nothing is asked for any more."""
        if self.is_active and self._cancel is not None:
            self._cancel()
        self._datum.data, self._datum.status = b"\0\0", self.CLEARED

    def _write(self, data: bytes) -> None:
        match data[0] & 3:
            case 3:
                if self.is_active:
                    raise ServiceError(Code.COMMAND_ACTIVE)
                self._datum.data, self._datum.status = data, self.ACTIVE
                self._start(self)
            case 1:
                self._datum.data, self._datum.status = data, self.INTERRUPTED
            case _:
                if self.is_active and self._cancel is not None:
                    self._cancel()
                self._datum.data, self._datum.status = data, self.CLEARED
                self._on_change(False)
