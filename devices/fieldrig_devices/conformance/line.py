"""The suite's connection to the bus: records all frames with their times, and runs the steps of the cases.

Steps are a generator that yields what it waits for, and resumes with the frame, or with None after a time-out.  As it
depends on no event loop and no thread, the same steps run in virtual and in real time.
"""

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from fieldrig.clock import Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame

T = TypeVar("T")
Matcher = Callable[[CanFrame], bool]


@dataclass(slots=True)
class Wait:
    """Waits for a frame that `wanted` accepts, or until an instant; None waits for no frame."""

    wanted: Matcher | None
    until_ns: int


Steps = Generator[Wait, CanFrame | None, T]


class Seen(NamedTuple):
    """A frame that this member has received or sent."""

    time_ns: int
    is_ours: bool
    frame: CanFrame


class Line:
    def __init__(self, clock: Clock, link: Link[CanFrame]) -> None:
        self.clock, self._link = clock, link
        self.seen: list[Seen] = []
        self._steps: Steps[None] | None = None
        self._wait: Wait | None = None
        self._timer = Alarm(self.clock)
        self._on_end: Callable[[Exception | None], None] = _forget
        link.on_receive(self._on_frame)

    def send(self, frame: CanFrame) -> None:
        self.seen.append(Seen(self.clock.now_ns(), True, frame))
        self._link.send(frame)

    def play(self, steps: Steps[None], on_end: Callable[[Exception | None], None]) -> None:
        """Run the steps; `on_end` is called at their end, with the exception if there was one."""
        self._steps, self._on_end = steps, on_end
        self._resume(None)

    def _on_frame(self, frame: CanFrame) -> None:
        self.seen.append(Seen(self.clock.now_ns(), False, frame))
        wait = self._wait
        if wait is not None and wait.wanted is not None and wait.wanted(frame):
            self._resume(frame)

    def _on_time(self) -> None:
        self._resume(None)

    def _resume(self, frame: CanFrame | None) -> None:
        self._timer.stop()
        steps, self._wait = self._steps, None
        if steps is None:
            return
        try:
            wait = steps.send(frame)
        except StopIteration:
            self._end(None)
        except Exception as fault:  # noqa: BLE001  the caller of `play` raises it in its own context
            self._end(fault)
        else:
            self._wait = wait
            self._timer.at(wait.until_ns, self._on_time)

    def _end(self, fault: Exception | None) -> None:
        self._steps = None
        self._on_end(fault)


def _forget(fault: Exception | None) -> None:
    """Do nothing at the end: the handler before the first `play`."""
