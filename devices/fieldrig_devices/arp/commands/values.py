"""Commands for values of a running card: get, set, watch."""

import csv
import io
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing, suppress
from datetime import UTC, datetime
from itertools import islice
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from fieldrig.cli.common import AsJson, Count, For, duration_ns, echo_json, wrong_usage
from fieldrig_devices.arp.commands.card import Baud, Card, Port, Rig, opened

if TYPE_CHECKING:
    from fieldrig_devices.arp.user_port.client import ArpPort
    from fieldrig_devices.arp.user_port.messages import Quantity

NAMES = "V1, F3, I101, O101, POS1, VEL1, TERR1, ADC1, DAC1, PAR.5, PAR1.7, FLAG1, STATE, ERROR, WARNING"
Names = Annotated[list[str], typer.Argument(metavar="NAME...", help=NAMES, show_default=False)]


def get(
    names: Names, port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None, as_json: AsJson = False
) -> None:
    """Read values of the card.

    \b
        fieldrig arp get V1 F3 POS1
        fieldrig arp get PAR1.7 --json          @Par1[7], the copy in RAM
    """
    from fieldrig_devices.arp.user_port import quantities

    wanted = _wanted(names)
    with opened(port, rig, card, baud) as arp_port:
        raws = arp_port.values(wanted)
    if as_json:
        echo_json(_as_data(wanted, raws))
        return
    for quantity, raw in zip(wanted, raws, strict=True):
        typer.echo(f"{quantities.name_of(quantity)} = {quantities.text_of(quantity, raw)}")


def set_(
    values: Annotated[
        list[str], typer.Argument(metavar="NAME=VALUE...", help="V, F, O, PAR (in RAM).", show_default=False)
    ],
    port: Port = None,
    rig: Rig = None,
    card: Card = None,
    baud: Baud = None,
) -> None:
    """Write variables, flags, outputs, and parameters in RAM.

    \b
        fieldrig arp set V1=2.5 F3=1 O101=on
        fieldrig arp set PAR1.11=3              until the next reset; `fieldrig arp params save` makes it permanent
    """
    from fieldrig_devices.arp.user_port import quantities

    with wrong_usage():
        pairs = [quantities.assigned(text) for text in values]
    with opened(port, rig, card, baud) as arp_port:
        for quantity, raw in pairs:
            arp_port.set(quantity, raw)
            typer.echo(f"{quantities.name_of(quantity)} = {quantities.text_of(quantity, raw)}")


class Row(NamedTuple):
    """Values at one instant; `loop` and `lost` are only set in a trace."""

    time: str
    raws: Sequence[int]
    loop: int | None = None
    lost: int = 0


Rows = Generator[Row | None, None, None]
"""None stands for a moment without a new row."""


def watch(
    names: Names,
    port: Port = None,
    rig: Rig = None,
    card: Card = None,
    baud: Baud = None,
    every: Annotated[str, typer.Option(metavar="DURATION", help="Period of the requests.")] = "200ms",
    loops: Annotated[
        int | None,
        typer.Option(
            min=1, max=65535, metavar="N", help="Trace a sample in every Nth control loop instead.", show_default=False
        ),
    ] = None,
    count: Count = None,
    duration: For = None,
    as_csv: Annotated[bool, typer.Option("--csv", help="Print CSV.")] = False,
    as_json: AsJson = False,
) -> None:
    """Show values as they change, until Ctrl-C, as a table, CSV or JSON lines.

    \b
        fieldrig arp watch V1 V10 F3 POS1
        fieldrig arp watch POS1 TERR1 --loops 1 --csv > trace.csv       the card samples in every loop
        fieldrig arp watch STATE ERROR --every 1s --json

    A slow line cannot carry every sample of the card; `lost` counts the samples that were left out.
    """
    wanted = _wanted(names)
    every_s = duration_ns(every) / 1_000_000_000
    limit_s = None if duration is None else duration_ns(duration) / 1_000_000_000
    with opened(port, rig, card, baud) as arp_port, closing(_rows(arp_port, wanted, every_s, loops)) as rows:
        chosen = islice(_until(rows, limit_s), count)
        with suppress(KeyboardInterrupt):
            _printer(wanted, as_csv, as_json, loops is not None)(chosen)


def _wanted(names: list[str]) -> "list[Quantity]":
    from fieldrig_devices.arp.user_port import quantities

    with wrong_usage():
        return [quantities.named(name) for name in names]


def _rows(card: "ArpPort", wanted: "list[Quantity]", every_s: float, loops: int | None) -> Rows:
    return _polled(card, wanted, every_s) if loops is None else _traced(card, wanted, loops)


def _polled(card: "ArpPort", wanted: "list[Quantity]", every_s: float) -> Rows:
    for raws in card.polled(wanted, every_s):
        yield Row(_now(), raws)


def _traced(card: "ArpPort", wanted: "list[Quantity]", loops: int) -> Rows:
    from fieldrig_devices.arp.user_port.messages import MOST_TRACED

    if len(wanted) > MOST_TRACED:
        raise typer.BadParameter(f"expected at most {MOST_TRACED} values in a trace")
    card.trace(loops, wanted)
    try:
        while True:
            sample = card.sample(0.2)
            yield None if sample is None else Row(_now(), sample.values, sample.loop, sample.lost)
    finally:
        card.end_trace()


def _until(rows: Iterable[Row | None], limit_s: float | None) -> Iterator[Row]:
    started = datetime.now(UTC)
    for row in rows:
        if limit_s is not None and (datetime.now(UTC) - started).total_seconds() > limit_s:
            return
        if row is not None:
            yield row


def _printer(wanted: "list[Quantity]", as_csv: bool, as_json: bool, is_trace: bool) -> Callable[[Iterable[Row]], None]:
    if as_json:
        return lambda rows: _print_json(wanted, rows)
    if as_csv:
        return lambda rows: _print_csv(wanted, rows, is_trace)
    return lambda rows: _print_table(wanted, rows)


def _print_json(wanted: "list[Quantity]", rows: Iterable[Row]) -> None:
    for row in rows:
        head: dict[str, Any] = {"time": row.time}
        if row.loop is not None:
            head |= {"loop": row.loop, "lost": row.lost}
        echo_json({**head, **_as_data(wanted, row.raws)})


def _print_csv(wanted: "list[Quantity]", rows: Iterable[Row], is_trace: bool) -> None:
    from fieldrig_devices.arp.user_port import quantities

    head = ["time", "loop", "lost"] if is_trace else ["time"]
    _echo_csv([*head, *map(quantities.name_of, wanted)])
    for row in rows:
        own = [row.time, row.loop, row.lost] if is_trace else [row.time]
        _echo_csv([*own, *(quantities.value_of(quantity, raw) for quantity, raw in zip(wanted, row.raws, strict=True))])


def _echo_csv(cells: Iterable[object]) -> None:
    line = io.StringIO()
    csv.writer(line).writerow(cells)
    typer.echo(line.getvalue().rstrip("\r\n"))


def _print_table(wanted: "list[Quantity]", rows: Iterable[Row]) -> None:
    """Print a table, in place on a terminal; elsewhere, a line each time that a value has changed."""
    from rich.console import Console
    from rich.live import Live
    from rich.table import Table

    from fieldrig_devices.arp.user_port import quantities

    names = [quantities.name_of(quantity) for quantity in wanted]
    console = Console(highlight=False, markup=False)

    def texts(row: Row) -> list[str]:
        return [quantities.text_of(quantity, raw) for quantity, raw in zip(wanted, row.raws, strict=True)]

    if not console.is_terminal:
        before: Sequence[int] = ()
        for row in rows:
            if row.raws != before:
                pairs = zip(names, texts(row), strict=True)
                typer.echo(f"{row.time}  {'  '.join(f'{name} = {text}' for name, text in pairs)}")
                before = row.raws
        return
    with Live(console=console, auto_refresh=False) as live:
        for row in rows:
            table = Table(box=None, pad_edge=False, header_style="bold")
            table.add_column(row.time if row.loop is None else f"loop {row.loop}, {row.lost} lost")
            table.add_column("", justify="right")
            for name, text in zip(names, texts(row), strict=True):
                table.add_row(name, text)
            live.update(table, refresh=True)


def _as_data(wanted: "list[Quantity]", raws: Sequence[int]) -> dict[str, Any]:
    from fieldrig_devices.arp.user_port import quantities

    return {
        quantities.name_of(quantity): quantities.value_of(quantity, raw)
        for quantity, raw in zip(wanted, raws, strict=True)
    }


def _now() -> str:
    return datetime.now(UTC).astimezone().isoformat(timespec="milliseconds")
