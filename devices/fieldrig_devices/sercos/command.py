"""Procedure commands: actions of a drive that take some time.

Source: IEC 61491 by its public facts: the master writes 3 to set and enable the command, reads its status as the first
element, and writes 0 to clear it.
"""

from collections.abc import Callable
from copy import copy

from fieldrig_devices.sercos.datum import Datum
from fieldrig_devices.sercos.idn import Code, ServiceError


class Command:
    """A procedure command: the master sets it to 3, then its status shows the progress."""

    CLEARED, DONE, INTERRUPTED, ACTIVE, FAILED = 0x0, 0x3, 0x5, 0x7, 0xF

    def __init__(
        self,
        datum: Datum,
        start: Callable[["Command"], None],
        on_change: Callable[[bool], None],
        cancel: Callable[[], None] | None = None,
    ) -> None:
        """`start` has to call `finish`, at once or later.

        `on_change` gets True when the command has ended, and False when it is cleared.
        """
        self._datum, self._start, self._on_change, self._cancel = datum, start, on_change, cancel
        self._run: Command | None = None
        """The command of the current run, a copy, so that an earlier run cannot finish it."""
        self._is_over = False
        datum.writer = self._write

    @property
    def is_active(self) -> bool:
        return self._datum.status == self.ACTIVE and not self._is_over

    def finish(self, *, is_good: bool = True) -> None:
        if self.is_active:
            self._datum.status = self.DONE if is_good else self.FAILED
            self._on_change(True)

    def reset(self) -> None:
        """Cancel the command when the ring goes down."""
        if self.is_active and self._cancel is not None:
            self._cancel()
        self._leave(b"\0\0", self.CLEARED)

    def _leave(self, data: bytes, status: int) -> None:
        if self._run is not None:
            self._run._is_over = True
        self._datum.data, self._datum.status = data, status

    def _write(self, data: bytes) -> None:
        match data[0] & 3:
            case 3:
                if self.is_active:
                    raise ServiceError(Code.COMMAND_ACTIVE)
                self._leave(data, self.ACTIVE)
                self._run = copy(self)
                self._start(self._run)
            case 1:
                if self.is_active:
                    self._leave(data, self.INTERRUPTED)
            case _:
                if self.is_active and self._cancel is not None:
                    self._cancel()
                self._leave(data, self.CLEARED)
                self._on_change(False)
