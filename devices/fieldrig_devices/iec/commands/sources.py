"""The source files that a command is given, and the dialect that they are written in."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from fieldrig.cli.common import argument, reading
from fieldrig.errors import UsageError
from fieldrig_devices.iec.dialect import DIALECTS

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
SUFFIXES: Final = (".st", ".il", ".exp", ".xml", ".tcpou", ".tcgvl", ".tcdut", ".tcio", ".tctto")


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
        inside = sorted(path.rglob("*")) if path.is_dir() else [path]
        chosen = [file for file in inside if file.suffix.lower() in SUFFIXES or file == path]
        sources = [SourceFile(str(file), read_text(file)) for file in chosen]
        texts += [one for one in sources if one.name == str(path) or not is_foreign(one.text)]
    if not texts:
        raise UsageError("there are no source files", f"expected files that end in {', '.join(SUFFIXES)}")
    return texts


def read_text(path: Path) -> str:
    """Return the text of a file.  UsageError if it cannot be read."""
    from fieldrig_devices.iec.imports.project_files import CHECKED, is_no_text, said_of
    from fieldrig_devices.languages.source_file import decoded

    with reading(path):
        data = path.read_bytes()
    said = said_of(path.name)
    if said is not None and is_no_text(data[:CHECKED].decode("latin-1")):
        raise UsageError(f"{path} is {said[0]}", said[1])
    try:
        return decoded(data)
    except ValueError as cause:
        raise UsageError(f"{path} cannot be read", str(cause)) from cause


def _listed(names: Iterable[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} or {last}"
