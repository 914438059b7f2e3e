"""Waveforms of wires as a value change dump (IEEE 1364-2005, clause 18), by pyvcd, for GTKWave and PulseView.

A wire is a variable by its values: digital a wire of one bit, whole numbers an integer, others a real.  Pulse trains
and PWM are digital, with each of their edges.  Times are in nanoseconds from the start of a rig in virtual time, else
from the first message; a comment has that instant, and the names and units of the wires.  Before its first value a wire
is x, or NaN if it is a real.

The file begins with the list of its variables, so it is written after the last message.  It has no senders and no other
buses, so it cannot be read back as a trace.
"""

from collections.abc import Iterable, Iterator
from heapq import merge
from math import nan
from typing import IO, BinaryIO, cast

from vcd.common import VarType
from vcd.writer import Variable, VCDWriter

from fieldrig.clock import NEVER_NS
from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.vcd_text import Ascii, Exact, Path, legal_paths, quoted
from fieldrig_bus.traces.waves import FAMILIES as FAMILIES
from fieldrig_bus.traces.waves import Value, Wave, Waves, check_size, waves_of

SUFFIXES = (".vcd",)
_SIZES = (32, 64)
"""Usual sizes of an integer in bits, which simulators have as well; an unsigned one of 64 bits needs one bit more."""


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write the waveforms; `start_unix_ns` is the time of day at instant 0.  Returns the number of messages in them."""
    waves = waves_of(entries)
    check_size(waves.waves, waves.origin_ns, waves.end_ns)
    paths = legal_paths((wave.bus, wave.name) for wave in waves.waves)
    output = cast(IO[str], Ascii(file))
    comment = _comment(waves, paths, start_unix_ns)
    with VCDWriter(output, "1 ns", date="", comment=comment, version="fieldrig") as writer:
        variables = [_declare(writer, wave, path) for wave, path in zip(waves.waves, paths, strict=True)]
        writer.flush()  # ends the list, so that changes at instant 0 are written one by one
        for time_ns, number, value in _in_order(waves):
            writer.change(variables[number], time_ns - waves.origin_ns, value)
        writer.close(waves.end_ns - waves.origin_ns)
    return waves.count


def recognises(head: bytes) -> bool:
    return head.lstrip().startswith((b"$date", b"$version", b"$comment", b"$timescale", b"$scope"))


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Raise UsageError: there are no messages in such a file."""
    raise UsageError(
        "a .vcd file has values of wires, and no messages",
        "open it in GTKWave or PulseView; keep the .jsonl file for `fieldrig trace`",
    )


def _declare(writer: VCDWriter, wave: Wave, path: Path) -> Variable[object]:
    scope, name = path[:-1], path[-1]
    if wave.is_digital:
        return writer.register_var(scope, name, VarType.wire, size=1)
    if wave.is_whole:
        return writer.register_var(
            scope, name, VarType.integer, size=_size(value for _, value in wave.values(-NEVER_NS, NEVER_NS))
        )
    return writer.register_var(scope, name, VarType.real, init=nan)


def _size(values: Iterable[Value]) -> int:
    """The size of a two's complement that holds all of these whole numbers."""
    needed = max((int(value) if value >= 0 else ~int(value)).bit_length() + 1 for value in values)
    return next((size for size in _SIZES if size >= needed), needed)


def _in_order(waves: Waves) -> Iterator[tuple[int, int, Value]]:
    """Yield the changes of all wires: instant, number of the wire, value as its variable takes it."""
    changes = (_numbered(number, wave, waves) for number, wave in enumerate(waves.waves))
    return merge(*changes, key=lambda change: change[0])


def _numbered(number: int, wave: Wave, waves: Waves) -> Iterator[tuple[int, int, Value]]:
    is_whole = wave.is_digital or wave.is_whole
    for time_ns, value in wave.values(waves.origin_ns - 1, waves.end_ns):
        yield time_ns, number, int(value) if is_whole else Exact(value)


def _comment(waves: Waves, paths: Iterable[Path], start_unix_ns: int) -> str:
    """The lines of the comment.  Names are in JSON without a dollar sign, so that none can end the comment."""
    lines = [f"fieldrig: instant 0 is {start_unix_ns + waves.origin_ns} ns"]
    for wave, path in zip(waves.waves, paths, strict=True):
        unit = f" in {quoted(wave.unit)}" if wave.unit else ""
        lines.append(f"{'.'.join(path)} is {quoted(wave.name)} of {quoted(wave.bus)}{unit}")
    return "\n".join(lines)
