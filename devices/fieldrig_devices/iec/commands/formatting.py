"""The command `fieldrig iec fmt`."""

from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import writing
from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands.sources import DialectOption, Files, dialect_named, read_sources
from fieldrig_devices.languages.standard_streams import is_standard, read_standard, write_standard

if TYPE_CHECKING:
    from fieldrig_devices.iec.dialect import Dialect


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
        fieldrig iec fmt - < conveyor.st

    Only text files are formatted; a file with mistakes stays as it is, and its mistakes are listed. With -, the
    standard input is formatted and written to the standard output.
    """
    from pathlib import Path

    from fieldrig.storage.store import replace_file

    rules = dialect_named(dialect)
    if is_standard(files):
        printed = _printed(read_standard(), "-", rules)
        if printed is None:
            raise typer.Exit(Exit.WRONG)
        write_standard(printed)
        return
    is_wrong = False
    for source in read_sources(files):
        if source.text.lstrip().startswith("<"):
            continue
        printed = _printed(source.text, source.name, rules)
        is_wrong = is_wrong or printed is None
        if printed is None or printed == source.text:
            continue
        typer.echo(f"{source.name}: {'not formatted' if is_check else 'formatted'}")
        if is_check:
            is_wrong = True
        else:
            with writing(Path(source.name).parent):
                replace_file(Path(source.name), printed.encode())
    if is_wrong:
        raise typer.Exit(Exit.WRONG)


def _printed(text: str, name: str, rules: "Dialect") -> str | None:
    """Return a text in one layout, or None if it has mistakes, which are listed."""
    from fieldrig_devices.iec.parser import parse
    from fieldrig_devices.iec.printer import print_unit

    unit, mistakes = parse(text, name, rules)
    for mistake in mistakes:
        typer.echo(str(mistake), err=True)
    return None if any(not mistake.is_note for mistake in mistakes) else print_unit(unit)
