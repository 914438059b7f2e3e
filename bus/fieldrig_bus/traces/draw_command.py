"""A timing diagram of the wires of a trace, as `fieldrig draw` draws it."""

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Final

import typer

from fieldrig.cli.common import duration_ns, writing
from fieldrig.clock import S
from fieldrig.errors import UsageError
from fieldrig.points.values import counted, show_number
from fieldrig.text.nearest import closest

if TYPE_CHECKING:
    from fieldrig_bus.traces.timing_diagram import Window
    from fieldrig_bus.traces.waves import Wave, Waves

SUFFIX: Final = ".svg"
MOST_NAMED: Final = 20
"""Number of wires that a message names."""


def draw(
    file: Path, target: Path, wires: list[str] | None = None, begin: str | None = None, end: str | None = None
) -> None:
    """Draw the wires of a trace as a timing diagram.

    UsageError for another name than that of an SVG file, a wire that is not there, and a time with nothing to draw.
    """
    from fieldrig.traces.trace_files import read
    from fieldrig_bus.traces.timing_diagram import timing_diagram
    from fieldrig_bus.traces.waves import check_size, waves_of

    check_target(target)
    waves = waves_of(read(file))
    chosen = _chosen(file, waves.waves, wires)
    window = _window(waves, begin, end)
    check_size(chosen, window.start_ns, window.end_ns)
    from_s, to_s = (_seconds(instant - waves.origin_ns) for instant in (window.start_ns, window.end_ns))
    about = f"The values of {_listed(chosen)} from {from_s} to {to_s}."
    with writing(target):
        target.write_text(timing_diagram(chosen, window, f"Wires of {file.stem}", about), encoding="utf-8")
    typer.echo(f"{target}: {counted(len(chosen), 'wire')} from {from_s} to {to_s}", err=True)


def check_target(target: Path) -> None:
    """UsageError for a picture that is not an SVG file."""
    if target.suffix.lower() != SUFFIX:
        raise UsageError(f"{target}: expected a name that ends in {SUFFIX}", "the picture is an SVG file")


def _chosen(file: Path, waves: "Sequence[Wave]", patterns: list[str] | None) -> "list[Wave]":
    """The wires in the order of the patterns, or all of them."""
    if not waves:
        raise UsageError(f"{file}: there is no message of a bus of wires", "other buses have no waveform")
    if not patterns:
        return list(waves)
    chosen: list[Wave] = []
    for pattern in patterns:
        fitting = [wave for wave in waves if fnmatchcase(wave.name, pattern)]
        if not fitting:
            names = [ascii(wave.name)[1:-1] for wave in waves]
            raise UsageError(f"{file}: there is no wire {pattern!r}", closest(pattern, names))
        chosen += [wave for wave in fitting if wave not in chosen]
    return chosen


def _window(waves: "Waves", begin: str | None, end: str | None) -> "Window":
    from fieldrig_bus.traces.timing_diagram import Window

    start_ns = waves.origin_ns + (0 if begin is None else duration_ns(begin))
    end_ns = max(waves.end_ns, waves.origin_ns + 1) if end is None else waves.origin_ns + duration_ns(end)
    if end_ns <= start_ns:
        last = _seconds(end_ns - waves.origin_ns)
        raise UsageError(
            f"there is nothing to draw from {_seconds(start_ns - waves.origin_ns)} to {last}",
            "expected --from to be before --to, and before the last message",
        )
    return Window(start_ns, end_ns, waves.origin_ns)


def _listed(waves: "Sequence[Wave]") -> str:
    names = [ascii(wave.name)[1:-1] for wave in waves[:MOST_NAMED]]
    return ", ".join([*names, f"{len(waves) - MOST_NAMED} more"] if len(waves) > MOST_NAMED else names)


def _seconds(time_ns: int) -> str:
    return f"{show_number(time_ns / S)} s"
