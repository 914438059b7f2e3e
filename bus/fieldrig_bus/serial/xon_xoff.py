"""Software flow control at one end of a serial line: XOFF (DC3) stops the other end's data, XON (DC1) lets it go on.

The characters are those of ITU-T T.50, and they are not data: an end that obeys them passes none of them on.
"""

XON, XOFF = 0x11, 0x13


class Obedience:
    """What the other end has asked of our transmitter."""

    def __init__(self) -> None:
        self.is_stopped = False

    def filter(self, data: bytes) -> bytes:
        """Return `data` without XON and XOFF; the last of them decides `is_stopped`."""
        last = max(data.rfind(XON), data.rfind(XOFF))
        if last < 0:
            return data
        self.is_stopped = data[last] == XOFF
        return data.translate(None, bytes((XON, XOFF)))


class Request:
    """What we ask of the other end's transmitter, by how full our receive buffer is."""

    def __init__(self, size: int) -> None:
        """Ask for a stop at three quarters of `size` bytes, and for more at one quarter."""
        self._high, self._low = 3 * size // 4, size // 4
        self.has_stopped = False
        """True from our XOFF to our XON."""

    def at(self, level: int) -> bytes:
        """Return the character to send now that `level` bytes wait; empty if there is nothing to ask for."""
        if not self.has_stopped and level >= self._high:
            self.has_stopped = True
            return bytes((XOFF,))
        return self.end() if level <= self._low else b""

    def end(self) -> bytes:
        """Return what releases the other end if we stopped it."""
        if not self.has_stopped:
            return b""
        self.has_stopped = False
        return bytes((XON,))
