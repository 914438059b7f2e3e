"""A device in real time with a mains switch, which faults of power use.

Without power a device has no timers and no handlers, so it does nothing; a hub treats its end as one that has gone.
Work that it has given to the background before that still ends, and its result finds nothing.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from fieldrig.clock import Clock
from fieldrig.device import Device, Point, Value
from fieldrig.errors import ControlError
from fieldrig.faults.faults import fault_of
from fieldrig.faults.mains import Mains
from fieldrig.faults.note import FaultNote
from fieldrig.faults.noted import Noted
from fieldrig.faults.power import MODELS, loses_power
from fieldrig.faults.waiting import WaitingFaults
from fieldrig.link import Link, PoweredLink
from fieldrig.points.hooks import Hook
from fieldrig.points.watched_points import Change, WatchedPoints


def _deaf(_: Any) -> None:
    """Hear nothing."""


def _untraced(_: FaultNote) -> None:
    """Add a fault to no trace."""


class Switched(Device):
    """The device of a process, as it is between two losses of power."""

    def __init__(
        self,
        name: str,
        clock: Clock,
        build: Callable[[], Device],
        links: Sequence[Link[Any]],
        cancel: Callable[[], None],
        waiting: WaitingFaults | None = None,
        note: Callable[[FaultNote], None] = _untraced,
    ) -> None:
        """`build` returns a new device on these links, and `cancel` ends all timers of the former one.

        `waiting` holds the faults of the process that wait for a point, and `note` adds one to the traces of the buses.
        """
        self._name, self._clock, self._build, self._links, self._cancel = name, clock, build, links, cancel
        self._mains = Mains(clock, self._switch, lambda _, fault: note(fault))
        self.present = build()
        """The device as it was built last."""
        self.watched = WatchedPoints(self.present)
        """The points whose changes are watched."""
        self.cycle_hook = Hook("end_of_cycle", self.present)
        self.is_on, self._waiting = True, waiting
        if waiting is not None:
            waiting.know(name, self)
        self._noted = Noted(note)
        self._noted.follow(self.present.injected, clock)

    def start(self) -> None:
        self.present.start()

    def stop(self) -> None:
        if self.is_on:
            self.present.stop()

    def points(self) -> Mapping[str, Point]:
        self._check_on()
        return self.present.points()

    def further_point(self, key: str) -> Point | None:
        self._check_on()
        return self.present.further_point(key)

    def front_words(self) -> dict[str, Any]:
        """Return the front, which is there without power too."""
        return self.present.front_words()

    def troubles(self) -> Mapping[str, Value]:
        return self.present.troubles() if self.is_on else {}

    def limits_reached(self) -> Mapping[str, float]:
        return self.present.limits_reached()

    def answer(self, question: str, message: Any) -> Any:
        self._check_on()
        return self.present.answer(question, message)

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        number = self._add_fault(fault)
        if self._waiting is not None:
            self._waiting.arm(self._name, number)
        return number

    def _add_fault(self, fault: Mapping[str, Any]) -> int:
        own = self.present.injected
        if loses_power(type(self.present), fault):
            above = 0 if own is None else own.given
            return self._mains.add(self._clock.now_ns(), self._name, fault_of(fault, MODELS), above)
        if own is not None:
            own.records.reserve(self._mains.given(self._name))
        with self._powerless():
            return self.present.add_fault(fault)

    def restart(self) -> None:
        """Switch the device off and on again at this instant.  ControlError for one that a fault has switched off."""
        if not self.is_on:
            raise ControlError(f"{self._name} is switched off", "clear the fault that has switched it off")
        for is_on in (False, True):
            self._switch(self._name, is_on)

    def begin_fault(self, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""
        if self._mains.has(self._name, number):
            self._mains.begin(self._clock.now_ns(), self._name, number)
        elif self.present.injected is not None:
            with self._powerless():
                self.present.injected.begin(number)

    def clear_fault(self, number: int) -> None:
        if self._waiting is not None:
            self._waiting.forget(self._name, number)
        if self._mains.has(self._name, number):
            self._mains.clear(self._clock.now_ns(), self._name, number)
        else:
            with self._powerless():
                self.present.clear_fault(number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        power = self._mains.about(self._clock.now_ns(), self._name)
        return dict(sorted({**self.present.faults(), **power}.items()))

    def changes(self) -> list[Change]:
        """Return the changes of watched points since the last call; without power there are none."""
        return self.watched.take() if self.is_on else []

    def _check_on(self) -> None:
        if not self.is_on:
            raise ControlError(f"{self._name} is switched off", "it answers when the fault that did it ends")

    @contextmanager
    def _powerless(self) -> Iterator[None]:
        """Keep a device without power from its links and timers: a fault may change what it listens to."""
        try:
            yield
        finally:
            if not self.is_on:
                self._silence()

    def _silence(self) -> None:
        """End all timers of the device, and let it hear nothing."""
        self._cancel()
        for link in self._links:
            link.on_receive(_deaf, ())

    def _switch(self, _: str, is_on: bool) -> None:
        self.is_on = is_on
        if not is_on:
            self._silence()
        for link in self._links:
            if isinstance(link, PoweredLink):
                link.switch(is_on)
        if is_on:
            former, self.present = self.present, self._build()
            if former.injected is not None and self.present.injected is not None:
                self.present.injected.adopt(former.injected)
            self._noted.follow(self.present.injected, self._clock)
            self.watched.move_to(self.present)
            self.cycle_hook.move_to(self.present)
            self.present.start()
