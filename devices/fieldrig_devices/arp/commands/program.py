"""Commands for the program in a card: download, upload, run, stop, reset, state."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import AsJson, echo_json, writing
from fieldrig_devices.arp.commands.card import PROGRESS_FROM, Baud, Card, Port, Rig, file_to_read, opened, optional

if TYPE_CHECKING:
    from fieldrig_devices.arp.user_port.client import ArpPort, OnProgress

Program = Annotated[Path, file_to_read("FILE", "Source, NAME.Inn, or object, NAME.Dnn.")]


def download(
    file: Program,
    port: Port = None,
    rig: Rig = None,
    card: Card = None,
    baud: Baud = None,
    stop_first: Annotated[bool, typer.Option("--stop", help="Stop a running program first.")] = False,
    run_after: Annotated[bool, typer.Option("--run", help="Run the program afterwards.")] = False,
) -> None:
    """Download a program into the card's permanent memory; a source is compiled first.

    \b
    The nn in the file name must be the card's number. The card keeps the old program until the new one is complete.
        fieldrig arp download cam.I01 --port /dev/ttyUSB0
        fieldrig arp download cam.I01 --stop --run
    """
    from fieldrig_devices.arp.language.files import system_of
    from fieldrig_devices.arp.language.program_file import read_program

    named = system_of(file)
    data = read_program(file, named) if named is not None else b""
    with opened(port, rig, card, baud, named) as arp_port:
        number = arp_port.number
        data = data or read_program(file, number)
        _ensure_stopped(arp_port, stop_first)
        with _bar(f"to card {number:02}", len(data)) as on_progress:
            arp_port.download(data, on_progress, lambda _what, done, steps: on_progress(done, steps))
        if run_after:
            arp_port.run()
    typer.echo(f"{file}: {len(data)} bytes in card {number:02}{', which runs it' if run_after else ''}")


def upload(
    file: Annotated[Path | None, optional("[FILE]", "Output file.", "standard output")] = None,
    port: Port = None,
    rig: Rig = None,
    card: Card = None,
    baud: Baud = None,
) -> None:
    """Read the object file of the program in the card.

    \b
    It is the program without comments, with all names replaced by their meanings.
        fieldrig arp upload cam.D01 --port /dev/ttyUSB0
    """
    from fieldrig.system.whole_file import replace_file

    with (
        opened(port, rig, card, baud) as arp_port,
        _bar(f"from card {arp_port.number:02}", PROGRESS_FROM) as on_progress,
    ):
        data = arp_port.upload(on_progress if file is not None else lambda _done, _all: None)
    if file is None:
        typer.echo(data.decode(), nl=False)
        return
    with writing(file):
        replace_file(file, data)
    typer.echo(f"{file}: {len(data)} bytes")


def run(port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None) -> None:
    """Run the program from its first instruction, or continue it after a pause.

    Enable (I108) must be closed; closing it also runs the program.
    """
    with opened(port, rig, card, baud) as arp_port:
        arp_port.run()
        _show(arp_port)


def stop(port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None) -> None:
    """Stop the program; outputs and axes keep their state."""
    with opened(port, rig, card, baud) as arp_port:
        arp_port.stop()
        _show(arp_port)


def reset(port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None) -> None:
    """Reset the card, as Ctrl-F2 does: outputs and axes off, errors and warnings cleared, the program held."""
    with opened(port, rig, card, baud) as arp_port:
        arp_port.reset()
        _show(arp_port)


def state(port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None, as_json: AsJson = False) -> None:
    """Show the state of the card and its program, and the last error and warning."""
    with opened(port, rig, card, baud) as arp_port:
        _show(arp_port, as_json)


def _ensure_stopped(card: "ArpPort", may_stop: bool) -> None:
    """Stop the program, or refuse: a card accepts no program while one runs (manual 5.2)."""
    from fieldrig_devices.arp.card_access import CardState
    from fieldrig_devices.arp.user_port.client import RefusedByCardError
    from fieldrig_devices.arp.user_port.messages import Status

    if may_stop:
        card.ensure_stopped()
    elif card.condition().state == CardState.RUN:
        what = "a program is running in the card, so it accepts no other"
        raise RefusedByCardError(Status.REFUSED, what, "add --stop, open Enable (I108), or run: fieldrig arp stop")


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
    """Show a progress bar, for long transfers on a terminal."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal or size < PROGRESS_FROM:
        yield lambda _done, _all: None
        return
    from rich.progress import Progress

    with Progress(console=console, transient=True) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, whole: progress.update(task, completed=done, total=whole)
