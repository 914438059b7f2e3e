"""The command `fieldrig iec check`."""

import dataclasses
from typing import TYPE_CHECKING

import typer

from fieldrig.cli.common import AsJson, echo_json
from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands.compiling import DeviceOption, RigOption, compiled
from fieldrig_devices.iec.commands.sources import DialectOption, Files, ResourceOption, read_sources

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.languages.mistakes import Mistake


def check(
    files: Files,
    dialect: DialectOption = "epas-4",
    resource: ResourceOption = "",
    rig: RigOption = None,
    device: DeviceOption = None,
    as_json: AsJson = False,
) -> None:
    """Compile a program, and list all its mistakes at once.

    \b
        fieldrig iec check conveyor.st
        fieldrig iec check project/ --dialect codesys
        fieldrig iec check conveyor.st --rig line.yaml --device controller

    All files together are one program. A program that names objects of a controller needs --rig. The exit code is 0
    if it compiles, and 2 if it has mistakes.
    """
    from fieldrig_devices.languages.mistakes import CompileError

    try:
        program = compiled(read_sources(files), dialect, rig, device, resource)
    except CompileError as wrong:
        _show(wrong.mistakes, as_json)
        raise typer.Exit(Exit.WRONG) from wrong
    _show(program.notes, as_json)
    if not as_json:
        typer.echo(f"Code Size: {program.code_size} bytes\nData Size: {program.data_size} bytes")


def _show(mistakes: "Sequence[Mistake]", as_json: bool) -> None:
    if as_json:
        echo_json([dataclasses.asdict(mistake) for mistake in mistakes])
        return
    for mistake in mistakes:
        typer.echo(str(mistake), err=not mistake.is_note)
