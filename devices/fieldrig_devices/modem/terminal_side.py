"""The side of a modem where the terminal is: data at the rate of the serial line, control lines, and flow control.

Source: TIA-232, ITU-T V.250 and PD-246 for &C, &D, &K, &R and &S.  The line is a null modem, so DTR of our end is DSR
of the terminal, and RTS is CTS.  RTS holds nothing while DTR is off: nothing of a call is kept for the next terminal.
"""

from dataclasses import replace
from enum import IntEnum
from typing import Final

from fieldrig.clock import Clock
from fieldrig_bus.serial.end import LineEnd
from fieldrig_bus.serial.message import ControlLines, Format
from fieldrig_bus.serial.xon_xoff import XOFF, XON, Obedience
from fieldrig_devices.modem.extended import DTE_RATES
from fieldrig_devices.modem.plugs import ALL_OFF, SerialPlug

MOST_WAITING: Final = 64 * 1024
"""Bytes kept for a terminal that takes nothing; what comes beyond that is lost."""


class Flow(IntEnum):
    """Values of +IFC (V.250, 6.2.12)."""

    NONE = 0
    XON_XOFF = 1
    HARDWARE = 2
    XON_XOFF_PASSED = 3
    """The modem obeys XON and XOFF, and passes them on to the other modem."""


OBEYING: Final = frozenset({Flow.XON_XOFF, Flow.XON_XOFF_PASSED})


class TerminalSide:
    def __init__(self, clock: Clock, plug: SerialPlug, form: Format, is_paced: bool) -> None:
        self.end = LineEnd(plug, clock, form, is_paced)
        self.end.lines = ALL_OFF
        self.terminal = ControlLines()
        """The lines that the terminal sets."""
        self._flow = self._flow_of_terminal = Flow.NONE
        self._obedience = Obedience()
        self._is_stopping = False

    def set_flow(self, of_modem: Flow, of_terminal: Flow) -> None:
        """Set how the terminal stops what the modem sends, and how the modem stops the terminal."""
        if of_terminal is not self._flow_of_terminal:
            was_stopping = self._is_stopping
            self.stop_terminal(False)
            self._flow_of_terminal = of_terminal
            self.stop_terminal(was_stopping)
        if of_modem is not self._flow:
            self._flow, self._obedience = of_modem, Obedience()
        self._hold_or_send()

    def on_lines(self, lines: ControlLines) -> None:
        self.terminal = lines
        self._hold_or_send()

    def show(self, is_ready: bool, has_carrier: bool, rings: bool) -> None:
        """Set DSR, DCD and RI; CTS says whether the terminal may send."""
        cts = not (self._is_stopping and self._flow_of_terminal is Flow.HARDWARE)
        self.end.set_lines(ControlLines(dtr=is_ready, rts=cts, ri=rings, dcd=has_carrier))

    def power_off(self) -> None:
        self._is_stopping, self._obedience = False, Obedience()
        self.end.hold(False)
        self.end.purge()
        self.end.set_lines(ALL_OFF)

    def stop_terminal(self, is_stopping: bool) -> None:
        """Ask the terminal to stop sending, or to go on."""
        if is_stopping is self._is_stopping:
            return
        self._is_stopping = is_stopping
        if self._flow_of_terminal is Flow.HARDWARE:
            self.end.set_lines(replace(self.end.lines, rts=not is_stopping))
        elif self._flow_of_terminal is Flow.XON_XOFF:
            self.end.send_at_once(bytes((XOFF if is_stopping else XON,)))

    def taken(self, data: bytes) -> bytes:
        """Return the data among what the terminal has sent."""
        if self._flow not in OBEYING:
            return data
        rest = self._obedience.filter(data)
        self._hold_or_send()
        return data if self._flow is Flow.XON_XOFF_PASSED else rest

    def send(self, data: bytes) -> None:
        self.end.send(data[: max(0, MOST_WAITING - self.end.waiting)])

    def follow(self, form: Format) -> None:
        """Take a format, unless its rate is none of a modem."""
        if form.baud in DTE_RATES:
            self.end.set_format(form)

    def _hold_or_send(self) -> None:
        is_held = self._obedience.is_stopped
        if self._flow is Flow.HARDWARE:
            is_held = self.terminal.dtr and not self.terminal.rts
        self.end.hold(is_held)
