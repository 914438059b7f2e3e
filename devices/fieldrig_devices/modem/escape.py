"""The escape sequence: three characters of S2 alone, with silence around them, lead from a call to the command state.

Source: the Hayes command set (S2, S12).  The characters belong to the data as well, as the modem sends them before it
knows what follows.  Data arrive in chunks; the characters of one chunk count as of one instant.
"""

from fieldrig.clock import MS

UNIT_NS = 20 * MS
"""The unit of S12."""
HIGHEST_CHARACTER = 127


class Escape:
    def __init__(self) -> None:
        self._last_ns = 0
        self._count = 0

    def restart(self, now_ns: int) -> None:
        """Begin with a call, or with the return to it."""
        self._last_ns, self._count = now_ns, 0

    def hear(self, now_ns: int, data: bytes, character: int, guard_ns: int) -> bool:
        """Return whether the sequence is complete, if nothing follows for `guard_ns` from now."""
        if character > HIGHEST_CHARACTER:
            return False
        if guard_ns and now_ns - self._last_ns >= guard_ns:
            self._count = 0
            is_alone = True
        else:
            is_alone = not guard_ns
        for byte in data:
            continues = 0 < self._count < 3 or (is_alone and self._count in (0, 3))
            if byte == character and continues:
                self._count = self._count % 3 + 1
            else:
                self._count = -1 if guard_ns else 0
            is_alone = not guard_ns
        self._last_ns = now_ns
        return self._count == 3
