"""Cyclic sending and filtered receiving, as the CAN broadcast manager of Linux does it for clients of socketcand.

Source: Linux, Documentation/networking/can.rst, 4.2, and net/can/bcm.c for the order of events.
Left out: time-outs of reception, sequences of frames, answers to remote frames; socketcand offers none of them.
"""

from collections.abc import Callable, Sequence

from fieldrig.clock import Alarm, Clock
from fieldrig_bus.can.frame import CanFrame


class CyclicJob:
    """Sends a frame at once and then every `interval_ns`; with an interval of 0 it sends the frame only once."""

    def __init__(self, clock: Clock, send: Callable[[CanFrame], None], frame: CanFrame, interval_ns: int) -> None:
        self.frame = frame
        """The frame that is sent next.  Replacing it does not affect the timer."""
        self._clock, self._send, self._interval_ns = clock, send, interval_ns
        self._due_ns = clock.now_ns()
        self._timer = Alarm(self._clock)
        self._on_due()

    def stop(self) -> None:
        self._timer.stop()

    def _on_due(self) -> None:
        if self._interval_ns:
            # After a stall the cycle starts again; missed frames are not sent.
            self._due_ns = max(self._due_ns + self._interval_ns, self._clock.now_ns())
            self._timer.at(self._due_ns, self._on_due)
        self._send(self.frame)


class Subscription:
    """Passes on the frames of one identifier, at most one frame every `interval_ns` (0: any number).

    Without `masks` it passes every frame; with one mask, each frame whose data differ from those of the last frame in a
    bit of the mask.  With several, the first mask says which bits of the data are the multiplex page; each of the
    others is the value of a page and its mask in one.  Of the frames that come too early, the latest of each page is
    kept until the interval is over.
    """

    def __init__(
        self, clock: Clock, notify: Callable[[CanFrame], None], interval_ns: int, masks: Sequence[bytes] = ()
    ) -> None:
        self._clock, self._notify, self._interval_ns = clock, notify, interval_ns
        self._masks = [_number(mask) for mask in masks]
        self._last: dict[int, int] = {}  # page: data
        self._waiting: dict[int, CanFrame] = {}  # page: frame
        self._told_ns: int | None = None
        self._timer = Alarm(self._clock)

    def hear(self, frame: CanFrame) -> None:
        content = _number(frame.data)
        page = self._page_of(content)
        if page is None:
            return
        if self._masks and page in self._last and not self._is_changed(page, frame, content):
            return
        self._last[page] = content
        if not self._interval_ns:
            self._notify(frame)
        else:
            self._waiting[page] = frame
            self._tell_when_due()

    def stop(self) -> None:
        self._timer.stop()

    def _page_of(self, content: int) -> int | None:
        if len(self._masks) < 2:
            return 0
        where, *pages = self._masks
        for page, mask in enumerate(pages, start=1):
            if where & content == where & mask:
                return page
        return None

    def _is_changed(self, page: int, frame: CanFrame, content: int) -> bool:
        # bcm.c compares the data there are, so a frame without data never differs
        return bool(frame.data) and bool((content ^ self._last[page]) & self._masks[page])

    def _tell_when_due(self) -> None:
        if self._timer.is_set:
            return
        now_ns = self._clock.now_ns()
        if self._told_ns is None or now_ns - self._told_ns >= self._interval_ns:
            self._told_ns = now_ns
            self._tell()
        else:
            self._timer.at(self._told_ns + self._interval_ns, self._on_due)

    def _on_due(self) -> None:
        if self._waiting:
            self._timer.after(self._interval_ns, self._on_due)
            self._tell()
        else:
            self._told_ns = None

    def _tell(self) -> None:
        waiting, self._waiting = self._waiting, {}
        for page in sorted(waiting):
            self._notify(waiting[page])


def _number(data: bytes) -> int:
    return int.from_bytes(data.ljust(8, b"\0"), "big")
