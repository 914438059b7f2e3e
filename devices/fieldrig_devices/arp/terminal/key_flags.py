"""F225 to F256: the keys as the program sees them.

One image of the keys in each pass of the scheduler, so that the program sees a key that was only touched.
"""

from collections import deque
from typing import Final

from fieldrig_devices.arp.runtime.words import unpacked
from fieldrig_devices.arp.terminal import panel

_MOST_WAITING: Final = 32
_FLAGS: Final = slice(panel.FIRST_KEY_FLAG, panel.LAST_KEY_FLAG + 1)
_SIZE: Final = 4  # bytes of TPDO 1


class KeyFlags:
    def __init__(self, flags: list[int]) -> None:
        self._flags = flags
        self._present = unpacked(0)
        self._waiting: deque[list[int]] = deque(maxlen=_MOST_WAITING)

    def take(self, data: bytes) -> None:
        """TPDO 1."""
        bits = unpacked(int.from_bytes(data, "little"))
        if len(data) == _SIZE and bits != (self._waiting[-1] if self._waiting else self._present):
            self._waiting.append(bits)

    def let_go(self) -> None:
        """The terminal is gone: no key stays pressed that nobody can let go."""
        self._waiting.clear()
        self._present = unpacked(0)

    def refresh(self) -> None:
        """What the program has written there doesn't stay (manual 4.5: R)."""
        if self._waiting:
            self._present = self._waiting.popleft()
        if self._flags[_FLAGS] != self._present:
            self._flags[_FLAGS] = self._present
