"""`fieldrig draw`: a timing diagram of the wires of a trace."""

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from fieldrig.cli.common import argument, duration_ns, writing
from fieldrig.clock import S
from fieldrig.errors import UsageError
from fieldrig.points.values import counted, show_number
from fieldrig.text.nearest import closest

if TYPE_CHECKING:
    from fieldrig_bus.traces.timing_diagram import Window
    from fieldrig_bus.traces.waves import Wave, Waves

SECTION = "Files"
"""The group of the command in the help of `fieldrig`."""
SUFFIX: Final = ".svg"
MOST_NAMED: Final = 20
"""Number of wires that a message names."""


def draw(
    file: Annotated[Path, argument("FILE", "The trace file.")],
    target: Annotated[Path, argument("TARGET", "The picture to write, an SVG file.")],
    wires: Annotated[list[str] | None, argument("[WIRE]...", "Only these wires; a * matches any characters.")] = None,
    begin: Annotated[
        str | None,
        typer.Option("--from", metavar="TIME", help="Begin at this time, such as 1.5s.", show_default=False),
    ] = None,
    end: Annotated[
        str | None, typer.Option("--to", metavar="TIME", help="End at this time, such as 2s.", show_default=False)
    ] = None,
) -> None:
    """Draw the wires of a trace as a timing diagram.

    \b
        fieldrig draw lab.jsonl lab.svg
        fieldrig draw lab.jsonl tank.svg "tank.*" pump.run --from 1s --to 2500ms

    Times count from the start of a rig in virtual time, and from the first message of a trace of real time.
    """
    from fieldrig.traces.trace_files import read
    from fieldrig_bus.traces.timing_diagram import timing_diagram
    from fieldrig_bus.traces.waves import check_size, waves_of

    if target.suffix.lower() != SUFFIX:
        raise UsageError(f"{target}: expected a name that ends in {SUFFIX}", "the picture is an SVG file")
    waves = waves_of(read(file))
    chosen = _chosen(file, waves.waves, wires)
    window = _window(waves, begin, end)
    check_size(chosen, window.start_ns, window.end_ns)
    from_s, to_s = (_seconds(instant - waves.origin_ns) for instant in (window.start_ns, window.end_ns))
    about = f"The values of {_listed(chosen)} from {from_s} to {to_s}."
    with writing(target):
        target.write_text(timing_diagram(chosen, window, f"Wires of {file.stem}", about), encoding="utf-8")
    typer.echo(f"{target}: {counted(len(chosen), 'wire')} from {from_s} to {to_s}", err=True)


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
