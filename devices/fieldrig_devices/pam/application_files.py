"""The files of an application: source, included files and cams, all in the folder of the source."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

from fieldrig.text.source_text import decoded
from fieldrig_devices.languages.source_file import found_beside
from fieldrig_devices.pam.pipes.cam import Shape
from fieldrig_devices.pam.pipes.shapes import shape_of

CAM_SUFFIX: Final = ".cam"
"""Suffix of the file that FILE of a PROFILE names (PAML-441)."""


def reader_beside(source: Path) -> Callable[[str], str | None]:
    """Return what reads included files: only those in the folder of the application and below it.

    It raises ValueError for a file that cannot be read.
    """

    def read(name: str) -> str | None:
        path = found_beside(source.parent, name)
        return None if path is None else decoded(_content(path))

    return read


def paths_beside(source: Path) -> Callable[[str], str]:
    """Return what gives the path of a file that messages name as an include does; another name stays as it is."""

    def path_of(name: str) -> str:
        return str(found_beside(source.parent, name) or name)

    return path_of


def shapes_beside(source: Path) -> Callable[[str], Shape]:
    """Return what reads cam files.  It raises ValueError, with the line, for a file that is missing or wrong."""

    def read(name: str) -> Shape:
        path = found_beside(source.parent, name + CAM_SUFFIX)
        if path is None:
            raise ValueError(f"there is no cam file {name}{CAM_SUFFIX} beside {source.name}")
        return shape_of(_content(path))

    return read


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as cause:
        raise ValueError(f"{path.name} cannot be read: {cause.strerror}") from cause
