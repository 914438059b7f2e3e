"""The power of devices, and the faults that switch it off."""

from collections.abc import Callable
from functools import partial
from typing import Any

from fieldrig.clock import Clock
from fieldrig.faults.faults import Fault, Faults, Timed
from fieldrig.faults.note import FaultNote
from fieldrig.faults.noted import Noted


class Mains:
    """Switches devices off and on by faults.  A device is off while it has one that is on."""

    def __init__(
        self, clock: Clock, switch: Callable[[str, bool], None], note: Callable[[str, FaultNote], None]
    ) -> None:
        """`switch` is called with a device and whether it has power, and `note` with its faults for the trace."""
        self._clock, self._switch, self._note = clock, switch, note
        self._faults: dict[str, Faults[Fault[Any]]] = {}
        self._noted: dict[str, Noted] = {}
        self._off: set[str] = set()

    def given(self, device: str) -> int:
        """Return the highest number of such a fault of the device."""
        return self._faults[device].given if device in self._faults else 0

    def add(self, now_ns: int, device: str, settings: Timed, above: int) -> int:
        """Add a loss of power under a number above `above`, and return it."""
        faults = self._faults.setdefault(device, Faults(Fault))
        faults.reserve(above)
        added = faults.add(now_ns, settings)
        if not faults.is_held(added.number):
            self._plan(now_ns, device, added)
        return added.number

    def begin(self, now_ns: int, device: str, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""
        fault = self._faults[device].release(now_ns, number)
        if fault is not None:
            self._plan(now_ns, device, fault)

    def _plan(self, now_ns: int, device: str, fault: Fault[Any]) -> None:
        for when_ns in (fault.start_ns, fault.until_ns):
            if when_ns is not None and when_ns > now_ns:
                self._clock.call_at(when_ns, lambda: self._look_at(self._clock.now_ns(), device))
        self._look_at(now_ns, device)

    def has(self, device: str, number: int) -> bool:
        return device in self._faults and number in self._faults[device].about(0)

    def clear(self, now_ns: int, device: str, number: int) -> None:
        self._faults[device].clear(number)
        self._look_at(now_ns, device)

    def about(self, now_ns: int, device: str) -> dict[int, dict[str, Any]]:
        return self._faults[device].about(now_ns) if device in self._faults else {}

    def is_off(self, device: str) -> bool:
        return device in self._off

    def _look_at(self, now_ns: int, device: str) -> None:
        """Switch the device if its faults say so, and count each that does it."""
        active = [fault for fault in self._faults[device] if fault.is_on(now_ns)]
        for fault in active:
            fault.applied = 1
        self._noted.setdefault(device, Noted(partial(self._note, device))).look(self._faults[device], now_ns)
        if bool(active) is not (device in self._off):
            (self._off.add if active else self._off.remove)(device)
            self._switch(device, not active)
