"""A device for the tests of serial lines; the processes of their rig import this module by name."""

from collections.abc import Mapping
from dataclasses import replace

from fieldrig.device import Device, Point, Value
from fieldrig.link import Link
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage


class Parrot(Device):
    """Repeats all data, and keeps the other messages that it receives; its own control lines are set by hand."""

    about = "a parrot on a serial line, for tests"

    def __init__(self, line: Link[SerialMessage]) -> None:
        self._line = line
        self._own, self._other = ControlLines(dcd=True), ControlLines(dtr=False, rts=False)
        self._format, self._break_ms = Format(), 0
        line.on_receive(self._on_message, ["data", "lines", "format", "break"])

    def start(self) -> None:
        self._line.send(self._own)

    def points(self) -> Mapping[str, Point]:
        return {
            "dtr": Point(lambda: self._other.dtr, about="of the other end"),
            "rts": Point(lambda: self._other.rts, about="of the other end"),
            "format": Point(self._shown_format, about="of the other end"),
            "break_ms": Point(lambda: self._break_ms, about="the last break"),
            "ring": Point(lambda: self._own.ri, lambda is_on: self._set(replace(self._own, ri=bool(is_on)))),
            "carrier": Point(lambda: bool(self._own.dcd), lambda is_on: self._set(replace(self._own, dcd=bool(is_on)))),
            "ready": Point(lambda: self._own.rts, lambda is_on: self._set(replace(self._own, rts=bool(is_on)))),
        }

    def _set(self, lines: ControlLines) -> None:
        self._own = lines
        self._line.send(lines)

    def _shown_format(self) -> Value:
        form = self._format
        return f"{form.baud} {form.data_bits}{form.parity}{form.stop_bits}"

    def _on_message(self, message: SerialMessage) -> None:
        match message:
            case bytes():
                self._line.send(message)
            case ControlLines():
                self._other = message
            case Format():
                self._format = message
            case Break():
                self._break_ms = message.duration_ms
