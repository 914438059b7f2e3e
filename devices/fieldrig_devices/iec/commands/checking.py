"""The command `fieldrig iec check`."""

import dataclasses
from typing import TYPE_CHECKING

import typer

from fieldrig.cli.common import AsJson, echo_json
from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands.compiling import DeviceOption, RigOption, compiled
from fieldrig_devices.iec.commands.sources import DialectOption, Files, ResourceOption, dialect_named, read_sources

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from fieldrig_devices.iec.dialect import Dialect
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

    All files together are one program. A program that names objects of a controller needs --rig. Files with TEST
    blocks are checked with the code that they test, as `fieldrig iec test` compiles it. The exit code is 0 if all of it
    compiles, and 2 if it has mistakes.
    """
    from fieldrig_devices.languages.mistakes import CompileError

    program, found = None, list["Mistake"]()
    try:
        program = compiled(read_sources(files), dialect, rig, device, resource)
        found += program.notes
    except CompileError as wrong:
        found += wrong.mistakes
    found += [one for one in _of_tests(files, dialect_named(dialect)) if one not in found]
    _show(found, as_json)
    if program is None or any(not mistake.is_note for mistake in found):
        raise typer.Exit(Exit.WRONG)
    if not as_json:
        typer.echo(f"Code Size: {program.code_size} bytes\nData Size: {program.data_size} bytes")


def _of_tests(files: "Sequence[Path]", dialect: "Dialect") -> "list[Mistake]":
    """Return the mistakes of the TEST blocks in these files."""
    from fieldrig_devices.iec.testing.blocks import BlockSource
    from fieldrig_devices.iec.testing.gathered import test_files

    found = [one for file in test_files(files) for one in BlockSource(file, dialect, files).mistakes()]
    return list(dict.fromkeys(found))


def _show(mistakes: "Sequence[Mistake]", as_json: bool) -> None:
    if as_json:
        echo_json([dataclasses.asdict(mistake) for mistake in mistakes])
        return
    for mistake in mistakes:
        typer.echo(str(mistake), err=not mistake.is_note)
