"""The command `fieldrig iec fmt`."""

from typing import Annotated

import typer

from fieldrig.cli.common import writing
from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands.sources import DialectOption, Files, dialect_named, read_sources


def fmt(
    files: Files,
    dialect: DialectOption = "epas-4",
    is_check: Annotated[
        bool, typer.Option("--check", help="Change nothing; the exit code is 2 if a file is not formatted.")
    ] = False,
) -> None:
    """Write source files in one layout, with their comments.

    \b
        fieldrig iec fmt conveyor.st
        fieldrig iec fmt project/ --check

    Only text files are formatted; a file with mistakes stays as it is, and its mistakes are listed.
    """
    from pathlib import Path

    from fieldrig.storage.store import replace_file
    from fieldrig_devices.iec.parser import parse
    from fieldrig_devices.iec.printer import print_unit

    rules = dialect_named(dialect)
    is_wrong = False
    for source in read_sources(files):
        if source.text.lstrip().startswith("<"):
            continue
        unit, mistakes = parse(source.text, source.name, rules)
        for mistake in mistakes:
            typer.echo(str(mistake), err=True)
            is_wrong = is_wrong or not mistake.is_note
        if any(not mistake.is_note for mistake in mistakes):
            continue
        printed = print_unit(unit)
        if printed == source.text:
            continue
        typer.echo(f"{source.name}: {'not formatted' if is_check else 'formatted'}")
        if is_check:
            is_wrong = True
        else:
            with writing(Path(source.name).parent):
                replace_file(Path(source.name), printed.encode())
    if is_wrong:
        raise typer.Exit(Exit.WRONG)
