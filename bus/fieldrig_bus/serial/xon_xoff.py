"""Software flow control at one end of a serial line: XOFF (DC3) stops the data of the other end, XON (DC1) resumes it.

The characters are those of ITU-T T.50, and they are not data: an end that obeys them passes none of them on.
"""

XON, XOFF = 0x11, 0x13


class Obedience:
    """The transmitter of this end, which the other end stops and resumes."""

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
    """The receiver of this end, which stops and resumes the other end by the level of its buffer."""

    def __init__(self, size: int) -> None:
        """Ask for a stop at three quarters of `size` bytes, and for more at one quarter."""
        self._high, self._low = 3 * size // 4, size // 4
        self.has_stopped = False
        """True between the XOFF and the XON of this end."""

    def at(self, level: int) -> bytes:
        """Return the character to send now that `level` bytes wait; empty if there is nothing to ask for."""
        if not self.has_stopped and level >= self._high:
            self.has_stopped = True
            return bytes((XOFF,))
        return self.end() if level <= self._low else b""

    def end(self) -> bytes:
        """Return the character that resumes the other end; empty if it was not stopped."""
        if not self.has_stopped:
            return b""
        self.has_stopped = False
        return bytes((XON,))
