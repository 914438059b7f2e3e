"""The source files that a command is given, and the dialect that they are written in."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import argument
from fieldrig.errors import UsageError
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.source_texts import SUFFIXES, files_in, read_text

if TYPE_CHECKING:
    from fieldrig_devices.iec.dialect import Dialect
    from fieldrig_devices.languages.source_file import SourceFile


Files = Annotated[list[Path], argument("FILE...", "The source files of the program; a folder means all files in it.")]
DialectOption = Annotated[
    str,
    typer.Option("--dialect", metavar="DIALECT", help=f"The language rules that apply: {', '.join(DIALECTS)}."),
]
ResourceOption = Annotated[
    str,
    typer.Option(
        "--resource", metavar="NAME", help="The RESOURCE that runs, if there are several.", show_default=False
    ),
]


def dialect_named(name: str) -> "Dialect":
    """Return the dialect of an option.  BadParameter for an unknown name."""
    if name not in DIALECTS:
        near = get_close_matches(name, DIALECTS, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise typer.BadParameter(f"expected {_listed(DIALECTS)}, got {name!r}{hint}", param_hint="--dialect")
    return DIALECTS[name]


def read_sources(paths: Sequence[Path]) -> "list[SourceFile]":
    """Return the texts of files, and of all source files in folders.  UsageError if there are none.

    XML files in folders that are of other formats are left out.
    """
    from fieldrig_devices.iec.imports import is_foreign
    from fieldrig_devices.languages.source_file import SourceFile

    texts: list[SourceFile] = []
    for path in paths:
        sources = [SourceFile(str(file), read_text(file)) for file in files_in(path)]
        texts += [one for one in sources if one.name == str(path) or not is_foreign(one.text)]
    if not texts:
        raise UsageError("there are no source files", f"expected files that end in {', '.join(SUFFIXES)}")
    return texts


def _listed(names: Iterable[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} or {last}"
