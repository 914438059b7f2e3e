"""The faults that are injected into a running device, or into a device's end of a bus.

A device declares its faults as settings models (`faults.Timed`) and says what each of them does; everything
else is here: the check of what a user types, start and end by the device's clock, the list of faults and its end.
A model of a bus reads no clock: it keeps its faults in `faults.Faults`.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Generic, TypeVar

from fieldrig.clock import Clock
from fieldrig.faults.faults import Fault, Faults, Timed, fault_of

F = TypeVar("F", bound=Fault[Any])
T = TypeVar("T", bound=Timed)


class InjectedFaults(Generic[F]):
    """The faults of one device, with their times."""

    def __init__(
        self,
        clock: Clock,
        models: Mapping[str, type[Timed]],
        faults: Faults[F],
        *,
        on_change: Callable[[], None] | None = None,
        check: Callable[[Any], None] | None = None,
    ) -> None:
        """`models` are the settings models of the faults by their `what`.

        `on_change` is called when a fault was added or cleared, when it begins, and when its time is over.  `check`
        is called with the settings of a new fault; it raises ValueError for a fault that cannot be.
        """
        self._clock, self._models, self._check = clock, models, check
        self._listeners = [] if on_change is None else [on_change]
        self.records = faults
        """The faults as records, for a device that counts what each of them did."""

    def also(self, on_change: Callable[[], None]) -> None:
        """Call this too when a fault was added or cleared, when it begins, and when its time is over."""
        had_none = not self._listeners
        self._listeners.append(on_change)
        if had_none:
            for fault in self.records:
                self._call_at_turns(fault)

    def _on_change(self) -> None:
        for listener in self._listeners:
            listener()

    def adopt(self, faults: "InjectedFaults[F]") -> None:
        """Take over the faults of the same device before it was switched off, instead of those from its start."""
        self.records.adopt(faults.records)
        for fault in self.records:
            self._call_at_turns(fault)
        self._on_change()

    @property
    def given(self) -> int:
        """The highest number of a fault so far."""
        return self.records.given

    def add(self, settings: Timed, number: int | None = None) -> int:
        """Add a fault that has been read already, such as one of a rig file, and return its number."""
        if self._check is not None:
            self._check(settings)
        fault = self.records.add(self._clock.now_ns(), settings, number)
        if not self.records.is_held(fault.number):
            self._call_at_turns(fault)
        self._on_change()
        return fault.number

    def begin(self, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""
        fault = self.records.release(self._clock.now_ns(), number)
        if fault is not None:
            self._call_at_turns(fault)
            self._on_change()

    def _call_at_turns(self, fault: F) -> None:
        """Call `on_change` when the fault begins, and when its time is over."""
        for when_ns in (fault.start_ns, fault.until_ns):
            if self._listeners and when_ns is not None and when_ns > self._clock.now_ns():
                self._clock.call_at(when_ns, self._on_change)

    def add_fault(self, fault: Mapping[str, Any], number: int | None = None) -> int:
        """Add a fault whose values may be texts, as people type them, and return its number.

        ValueError: its first line says what is wrong, further lines say what was expected.
        """
        return self.add(fault_of(fault, self._models), number)

    def clear_fault(self, number: int) -> None:
        """Remove a fault.  ValueError if there is none with this number."""
        self.records.clear(number)
        self._on_change()

    def faults(self) -> dict[int, dict[str, Any]]:
        """Return the faults that were added and not cleared, by number, each with its state and use.

        One that is a state was applied when it began to act.
        """
        now_ns = self._clock.now_ns()
        found = self.records.about(now_ns)
        for fault in self.records:
            if not fault.settings.counts_uses and now_ns >= fault.start_ns:
                found[fault.number]["applied"] = max(fault.applied, 1)
        return found

    def active(self, kind: type[T]) -> Iterator[T]:
        """Yield the settings of the faults of this kind that are on at present, in the order of adding."""
        now_ns = self._clock.now_ns()
        return (fault.settings for fault in self.records.of(kind) if fault.is_on(now_ns))

    def first(self, kind: type[T]) -> T | None:
        """Return the settings of the first fault of this kind that is on at present; None if there is none."""
        return next(self.active(kind), None)
