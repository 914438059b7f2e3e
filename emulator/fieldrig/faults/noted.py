"""The faults of a device in the traces of its buses: when each begins to act and is over, or each use of it."""

from collections.abc import Callable
from typing import Any

from fieldrig.clock import Clock
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.faults.note import FaultNote

OVER = "over"

Note = Callable[[FaultNote], None]


class Noted:
    """Notes the faults of one device, over its losses of power."""

    def __init__(self, note: Note) -> None:
        self._note = note
        self._on: set[int] = set()
        """The numbers of the faults that have begun and are not over."""

    def follow(self, injected: InjectedFaults[Any] | None, clock: Clock) -> None:
        """Note these faults from now on, beginning with those that are on."""
        if injected is not None:
            injected.records.on_use = self._on_use
            injected.also(lambda: self.look(injected.records, clock.now_ns()))
            self.look(injected.records, clock.now_ns())

    def look(self, faults: Faults[Any], now_ns: int) -> None:
        """Note what has changed since the last look.  A fault of messages is noted at each use instead."""
        present = {fault.number: fault for fault in faults if fault.is_on(now_ns) and not fault.settings.counts_uses}
        for number in sorted(self._on - present.keys()):
            self._note(FaultNote(number, OVER))
        for number, fault in present.items():
            if number not in self._on:
                self._note(FaultNote(number, fault.settings.what))
        self._on = set(present)

    def _on_use(self, fault: Fault[Any]) -> None:
        if fault.settings.counts_uses:
            self._note(FaultNote(fault.number, fault.settings.what))
