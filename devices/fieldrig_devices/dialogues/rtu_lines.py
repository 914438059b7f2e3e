"""The serial lines of a log that carry Modbus RTU or ASCII: their bytes become requests and responses.

A line is recognised by its first frames with a right checksum.  Until then its messages are kept, up to a bound; those
of a line with another protocol stay what they are.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.dialogues.rtu_line import RtuLine

ENOUGH: Final = 2
"""Frames with a right checksum that no other protocol has by chance: one in 65536 for each."""
MOST_KEPT: Final = 512
MOST_BYTES: Final = 8_192
"""Messages and bytes of a line among which those frames are looked for."""
MOST_LINES: Final = 64


class _Line:
    """A line of which it is not known, or is known, that it carries Modbus."""

    def __init__(self) -> None:
        self.rtu = RtuLine()
        self.is_modbus: bool | None = None
        self._kept: list[TraceEntry] = []
        self._messages: list[TraceEntry] = []
        self._bytes = 0

    def take(self, entry: TraceEntry) -> Iterator[TraceEntry]:
        if self.is_modbus is False:
            yield entry
            return
        found = self.rtu.take(entry)
        if self.is_modbus:
            yield from found
            return
        self._messages += found
        self._kept.append(entry)
        self._bytes += len(entry.data)
        if self.rtu.frames >= ENOUGH:
            yield from self._decide(is_modbus=True)
        elif len(self._kept) > MOST_KEPT or self._bytes > MOST_BYTES:
            yield from self._decide(is_modbus=False)

    def end(self) -> Iterator[TraceEntry]:
        """Yield what is kept at the end of the log: a single frame is enough then, if there is nothing else."""
        if self.is_modbus is None:
            yield from self._decide(is_modbus=self.rtu.frames > 0 and not self.rtu.skipped)

    def _decide(self, *, is_modbus: bool) -> Iterator[TraceEntry]:
        self.is_modbus = is_modbus
        yield from self._messages if is_modbus else self._kept
        self._messages, self._kept = [], []


class RtuLines:
    """The serial lines of a log."""

    def __init__(self, is_left_out: Callable[[str], bool] = lambda bus: False) -> None:
        """`is_left_out` says which serial lines, by their names, the rig reads itself."""
        self._is_left_out = is_left_out
        self._lines: OrderedDict[str, _Line] = OrderedDict()

    def of(self, entries: Iterable[TraceEntry]) -> Iterator[TraceEntry]:
        """Yield the messages of a log, with Modbus messages instead of the bytes of lines that carry it.

        Messages that were kept for a while may come after others of a later time.
        """
        for entry in entries:
            if entry.family != "serial" or self._is_left_out(entry.bus):
                yield entry
                continue
            line = self._lines.get(entry.bus)
            if line is None and len(self._lines) < MOST_LINES:
                line = self._lines[entry.bus] = _Line()
            if line is None:
                yield entry
            else:
                yield from line.take(entry)
        for line in self._lines.values():
            yield from line.end()

    def carries_modbus(self, bus: str) -> bool:
        """Return whether this is a serial line that was found to carry Modbus."""
        line = self._lines.get(bus)
        return line is not None and line.is_modbus is True

    @property
    def skipped(self) -> dict[str, int]:
        """The bytes of each line with Modbus that are in no frame."""
        return {bus: line.rtu.skipped for bus, line in self._lines.items() if line.is_modbus and line.rtu.skipped}
