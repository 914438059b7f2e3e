"""Source files on the disk: which belong to a program, and their texts."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from fieldrig.cli.common import reading
from fieldrig.errors import UsageError

SUFFIXES: Final = (".st", ".il", ".exp", ".xml", ".tcpou", ".tcgvl", ".tcdut", ".tctleo", ".tcio", ".tctto")


def files_in(path: Path) -> Iterator[Path]:
    """Yield the source files in a folder, in the order of their names; a path of a file is that file."""
    inside = sorted(path.rglob("*")) if path.is_dir() else [path]
    yield from (file for file in inside if file == path or (file.suffix.lower() in SUFFIXES and file.is_file()))


def read_text(path: Path) -> str:
    """Return the text of a file.  UsageError if it cannot be read."""
    from fieldrig.text.source_text import decoded
    from fieldrig_devices.iec.imports.project_files import CHECKED, is_no_text, said_of

    with reading(path):
        data = path.read_bytes()
    said = said_of(path.name)
    if said is not None and is_no_text(data[:CHECKED].decode("latin-1")):
        raise UsageError(f"{path} is {said[0]}", said[1])
    try:
        return decoded(data)
    except ValueError as cause:
        raise UsageError(f"{path} cannot be read", str(cause)) from cause
