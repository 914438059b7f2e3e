"""The files of an application: source, included files and cams, all in the folder of the source."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

from fieldrig_devices.languages.source_file import decoded
from fieldrig_devices.pam.pipes.cam import Shape
from fieldrig_devices.pam.pipes.shapes import shape_of

CAM_SUFFIX: Final = ".cam"
"""Suffix of the file that FILE of a PROFILE names (PAML-441)."""


def reader_beside(source: Path) -> Callable[[str], str | None]:
    """Return what reads included files: only those in the folder of the application and below it."""

    def read(name: str) -> str | None:
        path = _beside(source, name.replace("\\", "/"))
        return None if path is None else decoded(path.read_bytes())

    return read


def shapes_beside(source: Path, *, closed_is_periodic: bool = False) -> Callable[[str], Shape]:
    """Return what reads cam files.  It raises ValueError, with the line, for a file that is missing or wrong."""

    def read(name: str) -> Shape:
        path = _beside(source, name + CAM_SUFFIX)
        if path is None:
            raise ValueError(f"there is no cam file {name}{CAM_SUFFIX} beside {source.name}")
        return shape_of(path.read_bytes(), closed_is_periodic=closed_is_periodic)

    return read


def _beside(source: Path, name: str) -> Path | None:
    folder = source.resolve().parent
    path = (folder / name).resolve()
    return path if path.is_relative_to(folder) and path.is_file() else None
