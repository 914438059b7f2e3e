"""Options and small words that several commands share."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from fieldrig.cli import completion

ENDPOINT_VARIABLE: Final = "FIELDRIG_CONTROL"
DEFAULT_ENDPOINT: Final = "tcp/127.0.0.1:7447"

RigFile = Annotated[
    Path,
    typer.Argument(metavar="FILE", help="The rig file.", show_default=False, autocompletion=completion.rig_file),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Lay a value over the rig file's, such as buses.can0.bitrate=250000. As often as you like.",
        show_default=False,
    ),
]
Endpoint = Annotated[
    str,
    typer.Option(
        "--control", metavar="ENDPOINT", envvar=ENDPOINT_VARIABLE, help="Where the rig's control service listens."
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, for scripts.")]
For = Annotated[
    str | None,
    typer.Option("--for", metavar="DURATION", help="Stop after this time, such as 10s.", show_default=False),
]

UNITS_NS: Final = {"ns": 1, "us": 1_000, "ms": 1_000_000, "s": 1_000_000_000, "min": 60_000_000_000}


def duration_ns(text: str) -> int:
    """`10ms`, `1.5s`, `2min`.  typer.BadParameter for anything else."""
    digits = text.rstrip("abcdefghijklmnopqrstuvwxyz")
    try:
        ns = round(float(digits) * UNITS_NS[text[len(digits) :]])
    except (KeyError, ValueError, OverflowError):
        ns = -1
    if ns < 0:
        raise typer.BadParameter(f"{text!r} is not a duration: write it like 10ms, 1.5s or 2min")
    return ns


def echo_json(value: Any) -> None:
    typer.echo(json.dumps(value, ensure_ascii=False))


def echo_table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Columns by rich on a terminal; plain columns elsewhere, none of them cut."""
    from rich.console import Console
    from rich.table import Table

    table = Table(*headings, box=None, pad_edge=False, header_style="bold")
    for row in rows:
        table.add_row(*("" if cell is None else str(cell) for cell in row))
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console.width = 10_000
    console.print(table)
