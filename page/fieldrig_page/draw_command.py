"""`fieldrig draw`: a timing diagram of the wires of a trace, or the picture of a rig file."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import argument, writing
from fieldrig.errors import UsageError
from fieldrig.points.values import counted

SECTION = "Files"
"""The group of the command in the help of `fieldrig`."""


def draw(
    file: Annotated[Path, argument("FILE", "The trace file; with --rig, the rig file.")],
    target: Annotated[Path, argument("TARGET", "The picture to write, an SVG file.")],
    wires: Annotated[list[str] | None, argument("[WIRE]...", "Only these wires; a * matches any characters.")] = None,
    begin: Annotated[
        str | None,
        typer.Option("--from", metavar="TIME", help="Begin at this time, such as 1.5s.", show_default=False),
    ] = None,
    end: Annotated[
        str | None, typer.Option("--to", metavar="TIME", help="End at this time, such as 2s.", show_default=False)
    ] = None,
    is_rig: Annotated[bool, typer.Option("--rig", help="Draw the devices and buses of a rig file.")] = False,
    columns: Annotated[
        int | None,
        typer.Option(min=1, max=40, help="Devices beside each other, with --rig.", show_default="8"),
    ] = None,
) -> None:
    """Draw the wires of a trace as a timing diagram, or the devices and buses of a rig file.

    \b
        fieldrig draw lab.jsonl lab.svg
        fieldrig draw lab.jsonl tank.svg "tank.*" pump.run --from 1s --to 2500ms
        fieldrig draw --rig lab.yaml lab.svg

    Times count from the start of a rig in virtual time, and from the first message of a trace of real time.
    """
    from fieldrig_bus.traces import draw_command as traces

    if not is_rig:
        if columns is not None:
            raise UsageError("--columns is for the picture of a rig", "add --rig, or leave it out")
        traces.draw(file, target, wires, begin, end)
        return
    if wires or begin is not None or end is not None:
        raise UsageError("the picture of a rig has no wires and no time", "leave WIRE, --from and --to out")
    traces.check_target(target)
    _draw_rig(file, target, columns)


def _draw_rig(file: Path, target: Path, columns: int | None) -> None:
    from fieldrig.config.rig_file import load
    from fieldrig_page.drawing import COLUMNS, draw_rig
    from fieldrig_page.graph import graph_of

    graph = graph_of(load(file))
    with writing(target):
        target.write_text(draw_rig(graph, columns or COLUMNS), encoding="utf-8")
    what = f"{counted(len(graph.devices), 'device')} and {counted(len(graph.buses), 'bus', 'buses')}"
    typer.echo(f"{target}: {what}", err=True)
