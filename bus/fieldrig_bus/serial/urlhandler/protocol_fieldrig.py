"""The class behind `fieldrig://NAME` of pyserial.  The name of the module and of the class is that of its interface.

In a block of `virtual_time` the calls of the system know the URL, so it is the serial port of pyserial itself.
"""

import serial

from fieldrig.master_time.active import waiting_scheduler


class Serial(serial.Serial):  # type: ignore[misc, name-defined]
    """A serial line of the rig in whose time the program is."""

    def open(self) -> None:
        """SerialException outside of a block, and for a name that is no serial line."""
        if waiting_scheduler() is None:
            raise serial.SerialException(
                f"{self.portstr} needs `with virtual_time(rig):`; `fieldrig help` shows the ports of a rig in real time"
            )
        super().open()
