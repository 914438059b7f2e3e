"""The command `fieldrig iec symbols`."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import Endpoint, argument, writing
from fieldrig.cli.names import Parts
from fieldrig.errors import UsageError
from fieldrig.outside.addresses import DEFAULT_ENDPOINT
from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands.compiling import RigOption, compiled
from fieldrig_devices.iec.commands.sources import DialectOption, ResourceOption, read_sources
from fieldrig_devices.iec.source_texts import SUFFIXES


def symbols(
    output: Annotated[Path, argument("OUTPUT", "The file that is written.")],
    files: Annotated[
        list[Path] | None,
        argument("[FILE]...", "The source files; without them, --device of the running rig is asked."),
    ] = None,
    device: Annotated[
        str | None,
        typer.Option("--device", metavar="NAME", help="The controller, in --rig or in the running rig."),
    ] = None,
    rig: RigOption = None,
    dialect: DialectOption = "epas-4",
    resource: ResourceOption = "",
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Write the list of a program's variables and types in XML, as CODESYS does for HMIs and gateways.

    \b
        fieldrig iec symbols conveyor.xml conveyor.st
        fieldrig iec symbols conveyor.xml --device controller

    The exit code is 2 if the sources have mistakes.
    """
    from fieldrig.system.whole_file import replace_file

    suffix = output.suffix.lower()
    if output in (files or ()) or (suffix in SUFFIXES and suffix != ".xml"):
        raise UsageError(f"{output} is a source file", "expected a file for the list first, such as conveyor.xml")
    if files:
        data = _of_sources(files, dialect, rig, device, resource)
    elif device is not None:
        data = _of_device(device, endpoint)
    else:
        raise UsageError("there is no program", "expected source files, or --device NAME")
    with writing(output):
        replace_file(output, data)
    typer.echo(f"{output}: {len(data)} bytes")


def _of_sources(files: list[Path], dialect: str, rig: Path | None, device: str | None, resource: str) -> bytes:
    from fieldrig_devices.iec.symbol_list import symbol_list
    from fieldrig_devices.languages.mistakes import CompileError

    try:
        program = compiled(read_sources(files), dialect, rig, device, resource)
    except CompileError as wrong:
        for mistake in wrong.mistakes:
            typer.echo(str(mistake), err=True)
        raise typer.Exit(Exit.WRONG) from wrong
    return symbol_list(program.symbols, files[0].stem, device or "Device")


def _of_device(device: str, endpoint: str) -> bytes:
    from fieldrig.control.messages import Client

    with Client(endpoint) as client:
        text: str = Parts(client).ask_device(device, "symbols")["xml"]
    return text.encode()
