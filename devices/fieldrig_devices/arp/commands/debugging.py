"""The command `fieldrig arp debug`, on a terminal and in scripts."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from fieldrig_devices.arp.commands.card import Baud, Card, Port, Rig, file_to_read, opened

if TYPE_CHECKING:
    from fieldrig_devices.arp.user_port.client import ArpPort
    from fieldrig_devices.arp.user_port.listing import Listing

PROMPT: Final = "(arp) "


def debug(
    source: Annotated[
        Path | None, file_to_read("[SOURCE]", "Source of the program.  [default: the object in the card]")
    ] = None,
    port: Port = None,
    rig: Rig = None,
    card: Card = None,
    baud: Baud = None,
) -> None:
    """Debug the program in a card: breakpoints by line, steps, values, and the call stack.

    \b
        fieldrig arp debug cam.I01 --port /dev/ttyUSB0
        echo 'break 12; run; where; print V1; quit' | tr ';' '\\n' | fieldrig arp debug cam.I01

    `help` at the prompt explains the commands. Commands from a file or a pipe are echoed. The first one that fails ends
    the session, with exit code 6 if the card refused it or the program did not stop within 30 s, else 2.
    """
    from fieldrig_devices.arp.user_port.client import RefusedByCardError
    from fieldrig_devices.arp.user_port.debugger import Debugger
    from fieldrig_devices.languages.debugging.prompt import SCRIPT_LIMIT_S, converse, is_script

    with opened(port, rig, card, baud) as arp_port:
        listing = _listing(arp_port, source)
        debugger = Debugger(arp_port, listing, typer.echo, SCRIPT_LIMIT_S if is_script() else None)
        typer.echo(f"{listing.title} in card {arp_port.number:02}; `help` explains the commands")
        debugger.show_place()
        converse(debugger, PROMPT, (RefusedByCardError,))


def _listing(card: "ArpPort", source: Path | None) -> "Listing":
    from fieldrig.errors import RigError
    from fieldrig_devices.arp.user_port import listing
    from fieldrig_devices.languages.mistakes import CompileError

    data = card.upload()
    if source is None:
        return listing.of_object(data)
    try:
        own = listing.of_source(source)
    except CompileError as cause:
        raise RigError(f"{source} cannot be compiled", f"fieldrig arp compile {source} lists its mistakes") from cause
    if not own.is_of(data):
        typer.echo(
            f"note: the program in the card is not {source}; `fieldrig arp download {source}` downloads it", err=True
        )
    return own
