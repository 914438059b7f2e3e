"""The command `fieldrig iec download`."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from fieldrig.cli.common import Endpoint
from fieldrig.outside.addresses import DEFAULT_ENDPOINT
from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands.sources import Files, read_sources
from fieldrig_devices.languages.debugging.debug_command import DeviceName, moments

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.languages.source_file import SourceFile

LONGEST_S: Final = 600.0
"""Time that compiling may take, in seconds."""


def download(
    device: DeviceName,
    files: Files,
    is_online: Annotated[
        bool, typer.Option("--online", help="Change the running program; variables keep their values.")
    ] = False,
    is_started: Annotated[bool, typer.Option("--start", help="Start the program afterwards.")] = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Load a program into a controller of a running rig.

    \b
        fieldrig iec download controller conveyor.st --start
        fieldrig iec download controller conveyor.st --online

    The controller compiles it beside the running program. A program with mistakes changes nothing: all mistakes are
    listed, and the exit code is 2. It is 6 if the controller refuses the download.
    """
    from fieldrig.control.messages import Client
    from fieldrig.errors import RefusedError
    from fieldrig_devices.languages.debugging import questions

    texts = _named(read_sources(files))
    with Client(endpoint) as client, _bar(device) as on_progress:
        ask = questions.asker(client, device)
        try:
            problem = questions.download(ask, texts, moments(LONGEST_S), on_progress, is_online=is_online)
        except TimeoutError as cause:
            raise RefusedError(str(cause), "`fieldrig debug` shows its progress with `state`") from cause
        if not problem and is_started:
            ask({"command": "start"})
        state = ask({"command": "state"})["state"]
    if problem:
        typer.echo(problem, err=True)
        raise typer.Exit(Exit.WRONG)
    how = "changed online" if is_online else "downloaded"
    typer.echo(f"{device}: {', '.join(texts)} {how}; the program is {state}")


def _named(sources: "Sequence[SourceFile]") -> Mapping[str, str]:
    """Return the texts by file names, with their folders only where two files have the same name."""
    names = [Path(source.name).name for source in sources]
    return {
        name if names.count(name) == 1 else source.name: source.text
        for name, source in zip(names, sources, strict=True)
    }


@contextmanager
def _bar(device: str) -> Iterator[Callable[[str], None]]:
    """Show the work of the device on a terminal."""
    from rich.console import Console

    console = Console(stderr=True)
    with console.status(device) as status:
        yield lambda progress: status.update(f"{device}: {progress or 'done'}")
