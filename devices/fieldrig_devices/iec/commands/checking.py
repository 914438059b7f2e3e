"""The command `fieldrig iec check`."""

import dataclasses
from typing import TYPE_CHECKING

import typer

from fieldrig.cli.common import AsJson, echo_json
from fieldrig.exits import Exit
from fieldrig_devices.iec.commands.sources import DialectOption, Files, dialect_named, read_sources

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.languages.mistakes import Mistake


def check(files: Files, dialect: DialectOption = "epas-4", as_json: AsJson = False) -> None:
    """Compile a program, and list all its mistakes at once.

    \b
        fieldrig iec check conveyor.st
        fieldrig iec check project/ --dialect edition-3

    All files together are one program. The exit code is 0 if it compiles, and 2 if it has mistakes.
    """
    from fieldrig.clock import VirtualClock
    from fieldrig_devices.iec.compiler import compile_project
    from fieldrig_devices.iec.standalone import StandaloneHost
    from fieldrig_devices.languages.mistakes import CompileError

    rules = dialect_named(dialect)
    sources = read_sources(files)
    try:
        compiled = compile_project(sources, StandaloneHost(VirtualClock()), rules)
    except CompileError as wrong:
        _show(wrong.mistakes, as_json)
        raise typer.Exit(Exit.WRONG) from wrong
    _show(compiled.notes, as_json)
    if not as_json:
        typer.echo(f"Code Size: {compiled.code_size} bytes\nData Size: {compiled.data_size} bytes")


def _show(mistakes: "Sequence[Mistake]", as_json: bool) -> None:
    if as_json:
        echo_json([dataclasses.asdict(mistake) for mistake in mistakes])
        return
    for mistake in mistakes:
        typer.echo(str(mistake), err=not mistake.is_note)
