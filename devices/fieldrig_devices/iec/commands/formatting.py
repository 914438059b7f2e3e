"""The command `fieldrig iec fmt`."""

from typing import TYPE_CHECKING

import typer

from fieldrig_devices.iec.commands.sources import DialectOption, Files, dialect_named, read_sources
from fieldrig_devices.languages.formatting import IsCheck, format_files

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from fieldrig_devices.iec.dialect import Dialect
    from fieldrig_devices.languages.source_file import SourceFile


def fmt(files: Files, dialect: DialectOption = "epas-4", is_check: IsCheck = False) -> None:
    """Write source files in one layout, with their comments.

    \b
        fieldrig iec fmt conveyor.st
        fieldrig iec fmt project/ --check
        fieldrig iec fmt - < conveyor.st

    Only text files are formatted; a file with mistakes stays as it is, and its mistakes are listed. With -, the
    standard input is formatted and written to the standard output.
    """
    rules = dialect_named(dialect)
    format_files(files, _texts, lambda text, name: _printed(text, name, rules), is_check=is_check)


def _texts(files: "Sequence[Path]") -> "Iterator[SourceFile]":
    """Yield the sources that are text."""
    return (source for source in read_sources(files) if not source.text.lstrip().startswith("<"))


def _printed(text: str, name: str, rules: "Dialect") -> str | None:
    """Return a text in one layout, or None if it has mistakes, which are listed."""
    from dataclasses import replace

    from fieldrig_devices.iec.parser import parse
    from fieldrig_devices.iec.printer import print_unit

    unit, mistakes = parse(text, name, replace(rules, has_conditional_code=False))  # a layout keeps all branches
    for mistake in mistakes:
        typer.echo(str(mistake), err=True)
    return None if any(not mistake.is_note for mistake in mistakes) else print_unit(unit)
