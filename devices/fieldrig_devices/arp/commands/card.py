"""Which card a command talks to, and what it says when that goes wrong."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from fieldrig.exits import Exit

if TYPE_CHECKING:
    from fieldrig_devices.arp.user_port.client import ArpPort

Port = Annotated[
    str | None,
    typer.Option(
        "--port",
        metavar="PORT",
        envvar="FIELDRIG_ARP_PORT",
        help="The card's USER port: a device, a pty, socket://HOST:PORT or rfc2217://HOST:PORT.",
        show_default=False,
    ),
]
Rig = Annotated[
    Path | None,
    typer.Option(
        "--rig",
        metavar="FILE",
        help="Instead: the rig file of a rig that runs.",
        exists=True,
        dir_okay=False,
        show_default=False,
    ),
]
Card = Annotated[
    str | None,
    typer.Option("--card", metavar="NAME", help="With --rig: which card, if it has several.", show_default=False),
]
Baud = Annotated[
    int | None, typer.Option("--baud", min=300, help="Bits a second.  [default: 9600]", show_default=False)
]

DEFAULT_BAUD: Final = 9600
PROGRESS_FROM: Final = 4_000
"""Bytes: what is shorter is there at once."""


@contextmanager
def opened(
    port: str | None, rig: Path | None, card: str | None, baud: int | None, number: int | None = None
) -> Iterator["ArpPort"]:
    """The card, greeted.  What it refuses ends the command with exit code 6."""
    from fieldrig_devices.arp.user_port.client import ArpPort, RefusedByCardError

    where, usual_baud = _where(port, rig, card)
    try:
        with ArpPort.open(where, number, baud or usual_baud) as found:
            yield found
    except RefusedByCardError as cause:
        typer.echo(f"error: {cause.what}", err=True)
        if cause.remedy:
            typer.echo(f"  {cause.remedy}", err=True)
        raise typer.Exit(Exit.REFUSED) from cause


def _where(port: str | None, rig: Path | None, card: str | None) -> tuple[str, int]:
    if rig is not None:
        from fieldrig_devices.arp.commands.address import port_in_rig

        return port_in_rig(rig, card)
    if card is not None:
        raise typer.BadParameter("--card goes with --rig FILE")
    if port is None:
        raise typer.BadParameter("which card? say --port PORT, set FIELDRIG_ARP_PORT, or say --rig FILE")
    return port, DEFAULT_BAUD


@contextmanager
def usage() -> Iterator[None]:
    """A ValueError as wrong usage: its first line is what is wrong, the others what would be right."""
    try:
        yield
    except ValueError as cause:
        what, _, remedy = str(cause).partition("\n")
        raise typer.BadParameter(f"{what}; {remedy}" if remedy else what) from cause
