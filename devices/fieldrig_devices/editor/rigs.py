"""The rig files that belong to a program, for an editor: those that name it, in its folder and above it."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from fieldrig.config.rig_file import look_through
from fieldrig.settings import Settings

YAML: Final = (".yaml", ".yml")
_IS_RIG: Final = re.compile(r"^(?:devices|buses|extends)\s*:", re.MULTILINE)
"""A key that only rig files have at their top, among the YAML files that lie beside them."""


def is_rig(file: Path) -> bool:
    """True for a YAML file that looks like a rig file."""
    return file.suffix.lower() in YAML and _IS_RIG.search(_text(file)) is not None


def rigs_with(program: Path, root: Path) -> Iterator[Path]:
    """Yield each rig file in which a device has the program, from the program's folder up to the root."""
    wanted = program.resolve()
    for rig in _rigs_above(program, root):
        if program.name not in _text(rig):
            continue
        _, devices, _ = look_through(rig)
        if any(path.resolve() == wanted for device in devices for path in _files(device.settings)):
            yield rig


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:  # a folder, or a file that this user may not read
        return ""


def _rigs_above(file: Path, root: Path) -> Iterator[Path]:
    folder, root = file.absolute().parent, root.absolute()
    for above in (folder, *folder.parents):
        yield from (path for path in sorted(above.iterdir()) if is_rig(path))
        if above == root or root not in above.parents:
            return


def _files(settings: Settings) -> Iterator[Path]:
    """Yield the files that are settings of a device itself, alone or in a list."""
    for _, value in settings:
        yield from (one for one in (value if isinstance(value, list) else [value]) if isinstance(one, Path))
