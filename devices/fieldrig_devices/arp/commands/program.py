"""The card's program as a whole: download, upload, run, stop, reset, state."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import AsJson, echo_json, writing
from fieldrig_devices.arp.commands.card import PROGRESS_FROM, Baud, Card, Port, Rig, opened

if TYPE_CHECKING:
    from fieldrig_devices.arp.user_port.client import ArpPort, OnProgress

Program = Annotated[
    Path,
    typer.Argument(
        metavar="FILE",
        help="A source, NAME.Inn, or an object, NAME.Dnn.",
        exists=True,
        dir_okay=False,
        show_default=False,
    ),
]


def download(
    file: Program,
    port: Port = None,
    rig: Rig = None,
    card: Card = None,
    baud: Baud = None,
    stop_first: Annotated[bool, typer.Option("--stop", help="Stop the program that runs, before.")] = False,
    run_after: Annotated[bool, typer.Option("--run", help="Run it, after.")] = False,
) -> None:
    """Put a program into the card's permanent memory; a source is compiled first.

    \b
    The nn in the file's name must be the card's number. The old program stays until the new one is whole.
        fieldrig arp download cam.I01 --port /dev/ttyUSB0
        fieldrig arp download cam.I01 --stop --run
    """
    from fieldrig_devices.arp.language.files import system_of
    from fieldrig_devices.arp.language.program_file import read_program

    named = system_of(file)
    data = read_program(file, named) if named is not None else b""
    with opened(port, rig, card, baud, named) as found:
        number = found.number
        data = data or read_program(file, number)
        _make_stand(found, stop_first)
        with _bar(f"to card {number:02}", len(data)) as on_progress:
            found.download(data, on_progress)
        if run_after:
            found.run()
    typer.echo(f"{file}: {len(data)} bytes in card {number:02}{', which runs it' if run_after else ''}")


def upload(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="Where to write; on the screen.", show_default=False)
    ] = None,
    port: Port = None,
    rig: Rig = None,
    card: Card = None,
    baud: Baud = None,
) -> None:
    """Read the object file of the program in the card.

    \b
    It is the program with all names replaced by what they mean; comments were never in the card.
        fieldrig arp upload cam.D01 --port /dev/ttyUSB0
    """
    from fieldrig.store import replace_file

    with opened(port, rig, card, baud) as found, _bar(f"from card {found.number:02}", PROGRESS_FROM) as on_progress:
        data = found.upload(on_progress if file is not None else lambda _done, _all: None)
    if file is None:
        typer.echo(data.decode(), nl=False)
        return
    with writing(file):
        replace_file(file, data)
    typer.echo(f"{file}: {len(data)} bytes")


def run(port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None) -> None:
    """Run the program: from its first instruction, or on from where it is paused.

    Enable (I108) must be closed; closing it runs the program too.
    """
    with opened(port, rig, card, baud) as found:
        found.run()
        _show(found)


def stop(port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None) -> None:
    """Stop the program; outputs and axes stay as they are."""
    with opened(port, rig, card, baud) as found:
        found.stop()
        _show(found)


def reset(port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None) -> None:
    """Reset the card, as Ctrl-F2 does: outputs and axes off, errors and warnings cleared, the program held."""
    with opened(port, rig, card, baud) as found:
        found.reset()
        _show(found)


def state(port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None, as_json: AsJson = False) -> None:
    """Say in which state the card is, what its program does, its last error and warning."""
    with opened(port, rig, card, baud) as found:
        _show(found, as_json)


def _make_stand(card: "ArpPort", may_stop: bool) -> None:
    """A card takes no program while one runs (manual 5.2)."""
    from fieldrig_devices.arp.outside import CardState
    from fieldrig_devices.arp.user_port.client import RefusedByCardError
    from fieldrig_devices.arp.user_port.messages import Status

    if may_stop:
        card.make_stand()
    elif card.condition().state == CardState.RUN:
        what = "a program runs in the card, so it takes no other"
        raise RefusedByCardError(Status.REFUSED, what, "say --stop, or open Enable (I108), or: fieldrig arp stop")


def _show(card: "ArpPort", as_json: bool = False) -> None:
    from fieldrig_devices.arp.user_port import wording

    identity, condition = card.hello(), card.condition()
    if as_json:
        echo_json(wording.as_data(identity, condition))
        return
    for line in wording.lines(identity, condition):
        typer.echo(line)


@contextmanager
def _bar(what: str, size: int) -> Iterator["OnProgress"]:
    """On a terminal, and for what takes a while."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal or size < PROGRESS_FROM:
        yield lambda _done, _all: None
        return
    from rich.progress import Progress

    with Progress(console=console, transient=True) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, whole: progress.update(task, completed=done, total=whole)
