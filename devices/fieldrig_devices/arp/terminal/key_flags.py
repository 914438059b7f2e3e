"""F225 to F256: the keys as flags of the program.

Each pass of the scheduler takes one image of the keys, so that the program sees even a short press.
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
        """Take the data of TPDO 1."""
        bits = unpacked(int.from_bytes(data, "little"))
        if len(data) == _SIZE and bits != (self._waiting[-1] if self._waiting else self._present):
            self._waiting.append(bits)

    def let_go(self) -> None:
        """Release all keys, because the terminal is lost."""
        self._waiting.clear()
        self._present = unpacked(0)

    def refresh(self) -> None:
        """Update the flags, once per pass of the scheduler.  Writes of the program are overwritten (manual 4.5: R)."""
        if self._waiting:
            self._present = self._waiting.popleft()
        if self._flags[_FLAGS] != self._present:
            self._flags[_FLAGS] = self._present
