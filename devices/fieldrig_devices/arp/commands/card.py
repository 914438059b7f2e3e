"""The options that select the card for a command."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from fieldrig.cli.common import port_option

if TYPE_CHECKING:
    from fieldrig_devices.arp.user_port.client import ArpPort

Port = Annotated[
    str | None,
    port_option("The card's USER port", "FIELDRIG_ARP_PORT"),
]
Rig = Annotated[
    Path | None,
    typer.Option(
        "--rig",
        metavar="FILE",
        help="The file of a running rig, instead of --port.",
        exists=True,
        dir_okay=False,
        show_default=False,
    ),
]
Card = Annotated[
    str | None,
    typer.Option("--card", metavar="NAME", help="The card in the rig, if --rig has several.", show_default=False),
]
Baud = Annotated[
    int | None, typer.Option("--baud", min=300, help="Bit rate in bit/s.  [default: 9600]", show_default=False)
]

DEFAULT_BAUD: Final = 9600
PROGRESS_FROM: Final = 4_000
"""Smallest transfer with a progress bar, in bytes."""


def file_to_read(metavar: str, about: str) -> Any:
    """Argument for a file that must exist."""
    return typer.Argument(metavar=metavar, help=about, exists=True, dir_okay=False, show_default=False)


def optional(metavar: str, about: str, default: str) -> Any:
    """Argument that may be left out; `default` says in words what happens then."""
    return typer.Argument(metavar=metavar, help=f"{about}  [default: {default}]", show_default=False)


@contextmanager
def opened(
    port: str | None, rig: Path | None, card: str | None, baud: int | None, number: int | None = None
) -> Iterator["ArpPort"]:
    """Open the card's port, with `number` as the expected card number if it is given."""
    from fieldrig_devices.arp.user_port.client import ArpPort

    where, usual_baud = _where(port, rig, card)
    with ArpPort.open(where, number, baud or usual_baud) as arp_port:
        yield arp_port


def _where(port: str | None, rig: Path | None, card: str | None) -> tuple[str, int]:
    if rig is not None:
        from fieldrig_devices.arp.commands.address import port_in_rig

        return port_in_rig(rig, card)
    if card is not None:
        raise typer.BadParameter("--card needs --rig FILE")
    if port is None:
        raise typer.BadParameter("no card is given; expected --port PORT, FIELDRIG_ARP_PORT, or --rig FILE")
    return port, DEFAULT_BAUD
