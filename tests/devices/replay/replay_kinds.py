"""A device of tests at the end of a serial line: it answers each line of text."""

from functools import partial

from fieldrig import MS, Clock, Device, Link


class Scale(Device):
    """A scale: `W?` is answered with the weight, anything else with an error, both after a while."""

    def __init__(self, clock: Clock, line: Link[bytes]) -> None:
        self._clock, self._line = clock, line
        self._heard = b""
        line.on_receive(self._on_bytes)

    def _on_bytes(self, data: bytes) -> None:
        self._heard += data
        while b"\r" in self._heard:
            line, _, self._heard = self._heard.partition(b"\r")
            answer = b"12.5 kg\r" if line == b"W?" else b"ERR\r"
            self._clock.call_at(self._clock.now_ns() + 30 * MS, partial(self._line.send, answer))
