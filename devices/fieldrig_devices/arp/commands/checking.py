"""The command `fieldrig arp check`."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from fieldrig.cli.common import AsJson, argument, reading
from fieldrig.errors import UsageError
from fieldrig_devices.languages.told_mistakes import tell

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.languages.mistakes import Mistake

File = Annotated[Path, argument("FILE", "Source file, NAME.Inn.")]


def read_text(file: Path) -> str:
    """Return the text of a source file.  UsageError if it cannot be read."""
    from fieldrig.text.source_text import decoded

    with reading(file):
        data = file.read_bytes()
    try:
        return decoded(data)
    except ValueError as cause:
        raise UsageError(f"{file} cannot be read", str(cause)) from cause


def looked_through(file: Path) -> "Sequence[Mistake]":
    """Return the mistakes and notes of a program, each with its file."""
    from fieldrig_devices.arp.language.compiler import compile_text
    from fieldrig_devices.languages.mistakes import CompileError

    try:
        found: Sequence[Mistake] = compile_text(read_text(file)).notes
    except CompileError as wrong:
        found = wrong.mistakes
    return [dataclasses.replace(mistake, file=str(file)) for mistake in found]


def check(file: File, as_json: AsJson = False) -> None:
    """Check a program, and list all its mistakes at once; nothing is written.

    \b
        fieldrig arp check cam.I01

    The exit code is 0 if the program is right, and 2 if it has mistakes.
    """
    tell(looked_through(file), f"{file} is right.", as_json=as_json)
