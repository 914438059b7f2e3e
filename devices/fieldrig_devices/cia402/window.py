"""A condition that counts only after it has held for some time: windows and time-outs of CiA 402."""

from fieldrig.clock import MS


class Window:
    def __init__(self) -> None:
        self._since_ns = 0
        self.is_held = False

    def update(self, holds: bool, needed_ms: int, passed_ns: int) -> bool:
        """True if the condition has held for more than `needed_ms`; `passed_ns` have passed since the last call."""
        self._since_ns = self._since_ns + passed_ns if holds else 0
        self.is_held = holds and self._since_ns > needed_ms * MS
        return self.is_held

    def reset(self) -> None:
        self._since_ns, self.is_held = 0, False
