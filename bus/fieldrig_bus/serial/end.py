"""The end of an outside client on a serial line, as its port sees it, regardless of how the client is connected.

A client may send data far faster than the line transmits it.  The data are kept here and passed to the line some
milliseconds ahead, as the FIFO of a UART would be.  When much of it is waiting, the port is asked to stop reading.
"""

from collections.abc import Callable
from dataclasses import replace

from fieldrig.clock import MS, Clock, S, Timer
from fieldrig.link import Link
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage

AHEAD_NS = 20 * MS
"""Time by which data are passed to the line ahead.  After CTS has gone off, this much is still sent."""
MOST_WAITING = 4096
"""Number of waiting characters from which on the port should stop reading."""
OFF = ControlLines(dtr=False, rts=False)


class LineEnd:
    """`on_room(False)` is called when the client should be stopped, `on_room(True)` when it may go on."""

    def __init__(self, link: Link[SerialMessage], clock: Clock, form: Format, is_paced: bool) -> None:
        self._link, self._clock, self._is_paced = link, clock, is_paced
        self._default = self.form = form
        self.lines = ControlLines()
        self.on_room: Callable[[bool], None] = lambda _has_room: None
        self._waiting = bytearray()
        self._free_ns = 0
        self._timer: Timer | None = None
        self._is_held = False
        self.has_room = True

    @property
    def waiting(self) -> int:
        """The number of bytes that the line does not have yet."""
        return len(self._waiting)

    def send(self, data: bytes) -> None:
        self._waiting += data
        self._feed()

    def send_at_once(self, data: bytes) -> None:
        """Send `data`, such as a flow control character, ahead of everything that waits, whether held or not."""
        if data:
            self._link.send(data)

    def hold(self, is_held: bool) -> None:
        """Hold the data while the other end is not ready, or send it again."""
        self._is_held = is_held
        self._feed()

    def purge(self) -> None:
        """Discard the data that are not yet on the line."""
        self._waiting.clear()
        self._feed()

    def set_lines(self, lines: ControlLines) -> None:
        if lines != self.lines:
            self.lines = lines
            self._link.send(lines)

    def set_dtr(self, dtr: bool) -> None:
        self.set_lines(replace(self.lines, dtr=dtr))

    def set_rts(self, rts: bool) -> None:
        self.set_lines(replace(self.lines, rts=rts))

    def set_format(self, form: Format) -> None:
        if form != self.form:
            self.form = form
            self._link.send(form)

    def send_break(self, duration_ms: int) -> None:
        self._link.send(Break(duration_ms))

    def plug_in(self) -> None:
        """Connect a client: its lines go on, as when a program opens a serial port."""
        self.set_lines(ControlLines())

    def hang_up(self) -> None:
        """Disconnect the client: its lines go off, and the configured format applies again."""
        self._is_held = False
        self.purge()
        self.set_format(self._default)
        self.set_lines(OFF)

    def _feed(self) -> None:
        """Pass on as much as the line transmits in the next `AHEAD_NS`, and the rest later."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        waiting = self._waiting
        if waiting and not self._is_held:
            if self._is_paced:
                self._feed_paced(waiting)
            else:
                self._link.send(bytes(waiting))
                waiting.clear()
        has_room = len(waiting) < MOST_WAITING
        if has_room != self.has_room:
            self.has_room = has_room
            self.on_room(has_room)

    def _feed_paced(self, waiting: bytearray) -> None:
        now_ns = self._clock.now_ns()
        begin_ns = max(self._free_ns, now_ns)
        character_ns = self.form.bits_per_character * S // self.form.baud
        ahead_ns = now_ns + AHEAD_NS - begin_ns
        if ahead_ns > 0:
            portion = bytes(waiting[: max(1, ahead_ns // character_ns)])
            del waiting[: len(portion)]
            begin_ns = self._free_ns = begin_ns + len(portion) * character_ns
            self._link.send(portion)
        if waiting:
            self._timer = self._clock.call_at(begin_ns - AHEAD_NS // 2, self._feed)
