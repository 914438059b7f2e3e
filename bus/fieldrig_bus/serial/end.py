"""The end of an outside client on a serial line, as its port sees it, regardless of how the client is connected."""

from dataclasses import replace

from fieldrig.clock import Clock, S
from fieldrig.link import Link
from fieldrig_bus.sending_ahead import SendingAhead
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage

MOST_WAITING = 4096
"""Number of waiting characters from which on the port should stop reading."""
OFF = ControlLines(dtr=False, rts=False)


class LineEnd(SendingAhead):
    """`on_room(False)` is called when the client should be stopped, `on_room(True)` when it may go on."""

    def __init__(
        self, link: Link[SerialMessage], clock: Clock, form: Format, is_paced: bool, most_waiting: int = MOST_WAITING
    ) -> None:
        super().__init__(clock, link.send, most_waiting, most_waiting)
        self._link, self._paced = link, is_paced
        self._default = self.form = form
        self.lines = ControlLines()

    @property
    def _is_paced(self) -> bool:
        return self._paced

    @property
    def _character_ns(self) -> int:
        return self.form.bits_per_character * S // self.form.baud

    def _characters_in(self, duration_ns: int) -> int:
        return duration_ns // self._character_ns

    def _duration_ns(self, characters: int) -> int:
        return characters * self._character_ns

    def _has_emptied(self) -> None:
        """No port waits for this."""

    def send_at_once(self, data: bytes) -> None:
        """Send `data`, such as a flow control character, ahead of everything that waits, whether held or not."""
        if data:
            self._link.send(data)

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
