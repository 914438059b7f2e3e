"""A serial line in virtual time as a port of pyserial, where the system has no calls for terminals (Windows).

Data goes over a pair of sockets, as with `socket://` of pyserial, whose class this is based on; rate, control lines and
breaks go to the line beside it.
"""

from typing import Any

import serial
from serial.urlhandler import protocol_socket

from fieldrig.master_time.active import waiting_scheduler
from fieldrig.master_time.terminals import CD, CTS, DSR, DTR, RI, RTS, Terminal


class LineSocket(protocol_socket.Serial):
    """The port behind `fieldrig://NAME`."""

    def open(self) -> None:
        """SerialException for a name that is no serial line, and for a port that is open already."""
        if self.is_open:
            raise serial.SerialException("Port is already open.")
        self.logger = None
        scheduler = waiting_scheduler()
        terminals: Any = getattr(scheduler.doors, "terminals", None) if scheduler is not None else None
        found: Terminal | None = None if terminals is None else terminals.find(self.portstr)
        if found is None:
            raise serial.SerialException(f"{self.portstr}: No such file: it is no serial line of the rig")
        self._line = found
        self._socket = terminals.connect(found)
        self.is_open = True
        self._reconfigure_port()
        self._update_dtr_state()

    def close(self) -> None:
        if self.is_open:
            self._socket.close()
        self.is_open = False

    def send_break(self, duration: float = 0.25) -> None:
        """Send a break; its duration is that of the line."""
        self._line.send_break()

    def _reconfigure_port(self) -> None:
        self._line.rate = self._baudrate

    def _update_dtr_state(self) -> None:
        self._line.set_outputs(DTR * bool(self._dtr_state) | RTS * bool(self._rts_state))

    _update_rts_state = _update_dtr_state

    @property
    def cts(self) -> bool:
        return bool(self._line.inputs & CTS)

    @property
    def dsr(self) -> bool:
        return bool(self._line.inputs & DSR)

    @property
    def ri(self) -> bool:
        return bool(self._line.inputs & RI)

    @property
    def cd(self) -> bool:
        return bool(self._line.inputs & CD)
