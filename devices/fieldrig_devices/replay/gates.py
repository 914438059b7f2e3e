"""Gates: a message of the log waits for the answer of the rig that the log shows before it.

A gate belongs to one conversation: an SDO channel, a Modbus exchange, a serial line.  It is open for what is played as
long as the rig has sent as much of it as the log.
"""

from collections import deque
from typing import Final, Protocol

ABORT: Final = 0x80
EXPEDITED: Final = 0x02
LAST: Final = 0x01
MOST: Final = 100_000
"""Messages of one conversation that may be ahead of the other side."""


class Gate(Protocol):
    """One conversation that the next message of the log may have to wait for."""

    @property
    def since_ns(self) -> int | None:
        """The instant at which the log has what is awaited; None if nothing is."""

    @property
    def came_ns(self) -> int:
        """The instant at which the last awaited message came."""

    def give_up(self) -> None:
        """Wait no longer."""


class FrameGate:
    """The frames of the rig in an SDO channel, or its answers to remote requests and LSS commands."""

    def __init__(self) -> None:
        self._expected: deque[tuple[int, int]] = deque(maxlen=MOST)
        self._actual: deque[tuple[int, int]] = deque(maxlen=MOST)
        self.came_ns = 0
        self.is_broken = False
        """True if the rig has answered so that the log's next frames do not fit; until the next transfer."""

    @property
    def since_ns(self) -> int | None:
        return self._expected[-1][0] if self._expected else None

    def expect(self, at_ns: int, head: int) -> None:
        """Take a frame of the log by its first byte."""
        self._expected.append((at_ns, head))
        self._match()

    def heard(self, at_ns: int, head: int) -> None:
        """Take a frame of the rig."""
        self._actual.append((at_ns, head))
        self._match()

    def begin(self) -> None:
        """Begin another transfer."""
        self._expected.clear()
        self._actual.clear()
        self.is_broken = False

    def give_up(self) -> None:
        self._expected.clear()
        self.is_broken = True

    def _match(self) -> None:
        while self._expected and self._actual:
            _, expected = self._expected.popleft()
            self.came_ns, actual = self._actual.popleft()
            if not _goes_on_alike(expected, actual):
                self.is_broken = True
        if self.is_broken:
            self._expected.clear()


def _goes_on_alike(expected: int, actual: int) -> bool:
    """Return whether a client goes on in the same way after these two answers (CiA 301, 7.2.4.3)."""
    if expected >> 5 != actual >> 5 or (expected == ABORT) != (actual == ABORT):
        return False
    match expected >> 5:
        case 2:
            return not (expected ^ actual) & EXPEDITED
        case 0:
            return not (expected ^ actual) & LAST
    return True


class ByteGate:
    """The bytes of the rig on a serial line."""

    def __init__(self) -> None:
        self._owed = 0
        self._since_ns = 0
        self.came_ns = 0

    @property
    def since_ns(self) -> int | None:
        return self._since_ns if self._owed > 0 else None

    def expect(self, at_ns: int, count: int) -> None:
        self._owed += count
        self._since_ns = at_ns

    def heard(self, at_ns: int, count: int) -> None:
        self._owed -= count
        self.came_ns = at_ns

    def give_up(self) -> None:
        self._owed = 0


class AnswerGate:
    """One answer, such as that of a Modbus exchange."""

    def __init__(self, since_ns: int, number: int = 0) -> None:
        """`number` is that of the request of ours that is answered."""
        self._since_ns: int | None = since_ns
        self.number = number
        self.came_ns = 0

    @property
    def since_ns(self) -> int | None:
        return self._since_ns

    def heard(self, at_ns: int) -> None:
        self.came_ns, self._since_ns = at_ns, None

    def give_up(self) -> None:
        self._since_ns = None
