"""The class behind `fieldrig://NAME` of pyserial.  The name of the module and of the class is that of its interface.

In a block of `virtual_time` the calls of the system know the URL, so it is the serial port of pyserial itself, except
where the system has no such calls.
"""

from contextlib import suppress
from typing import Any

import serial

from fieldrig.master_time.active import waiting_scheduler
from fieldrig_bus.serial.urlhandler.line_socket import LineSocket

_Base: Any = LineSocket
with suppress(ImportError):
    import termios  # noqa: F401  it has the calls

    _Base = vars(serial)["Serial"]  # pyserial has no types


class Serial(_Base):  # type: ignore[misc]
    """A serial line of the rig in whose time the program is."""

    def open(self) -> None:
        """SerialException outside of a block, and for a name that is no serial line."""
        if waiting_scheduler() is None:
            raise serial.SerialException(
                f"{self.portstr} needs `with virtual_time(rig):`; `fieldrig help` shows the ports of a rig in real time"
            )
        super().open()
