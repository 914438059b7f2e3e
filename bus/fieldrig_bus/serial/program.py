"""The end of a program in virtual time that opens a serial line by its name, `fieldrig://NAME`, with pyserial.

It is a pty with what a pty does not have: control lines in both directions, and breaks.
"""

from dataclasses import replace
from typing import Any, Final, Protocol, runtime_checkable

from fieldrig.bus import Hub
from fieldrig.master_time.terminals import CD, CTS, DSR, RI
from fieldrig_bus.serial.message import ControlLines, inputs_from
from fieldrig_bus.serial.pty import PtyPort

BREAK_MS: Final = 250
"""Duration of a break, that of pyserial's `send_break`."""


@runtime_checkable
class SerialTerminal(Protocol):
    """A serial port with control lines."""

    inputs: int
    on_outputs: Any
    on_break: Any


class ProgramPort(PtyPort):
    async def open(self, hub: Hub) -> None:
        await super().open(hub)
        made: Any = self._pty
        self._port: Any = made if isinstance(made, SerialTerminal) else None
        if self._port is not None:
            self._port.on_outputs, self._port.on_break = self._on_outputs, self._on_break
        self._link.on_receive(self._on_message, ["data", "lines"])

    def _on_message(self, message: Any) -> None:
        if isinstance(message, bytes):
            self._on_line(message)
        elif isinstance(message, ControlLines) and self._port is not None:
            cts, dsr, dcd, ri = inputs_from(message)
            self._port.inputs = CTS * cts | DSR * dsr | CD * dcd | RI * ri

    def _on_outputs(self, dtr: bool, rts: bool) -> None:
        if self._end is not None:
            self._end.set_lines(replace(self._end.lines, dtr=dtr, rts=rts))

    def _on_break(self) -> None:
        if self._end is not None:
            self._end.send_break(BREAK_MS)
