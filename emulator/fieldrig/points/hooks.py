"""Calls that a device makes while it is observed, for several observers at once and over its power cycles."""

from collections.abc import Callable
from typing import Literal

from fieldrig.device import Device


class Hook:
    """All that is called by one attribute of a device: `end_of_cycle`, or `look`."""

    def __init__(self, name: Literal["end_of_cycle", "look"], device: Device) -> None:
        self._name, self._device = name, device
        self._actions: list[Callable[[], None]] = []

    def add(self, action: Callable[[], None]) -> Callable[[], None]:
        """Call `action` too, from now on until the returned function is called."""
        self._actions = [*self._actions, action]
        self._set()

        def end() -> None:
            self._actions = [other for other in self._actions if other is not action]
            self._set()

        return end

    def move_to(self, device: Device) -> None:
        """Have the same calls made by the same device after it was built again."""
        self._device = device
        self._set()

    def _set(self) -> None:
        actions = self._actions
        call = None if not actions else actions[0] if len(actions) == 1 else self._call_all
        if self._actions or getattr(self._device, self._name) is not None:
            setattr(self._device, self._name, call)

    def _call_all(self) -> None:
        for action in self._actions:
            action()
