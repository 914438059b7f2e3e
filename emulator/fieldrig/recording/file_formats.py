"""The formats of recordings of signals, by the endings of file names."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from fieldrig.errors import UsageError
from fieldrig.recording.files import CsvFile, RowsFile, VcdFile
from fieldrig.recording.mf4_file import Mf4File
from fieldrig.text.nearest import closest

FORMATS: Final[Mapping[str, type[RowsFile]]] = {".csv": CsvFile, ".vcd": VcdFile, ".mf4": Mf4File}
"""The formats by the endings of file names."""


def format_of(path: Path) -> type[RowsFile]:
    """Return the format of a file.  UsageError, with the known endings, for an unknown one."""
    try:
        return FORMATS[path.suffix.lower()]
    except KeyError:
        near = closest(path.suffix.lower(), list(FORMATS))
        remedy = near if near.startswith("did you mean") else f"expected {', '.join(FORMATS)}"
        raise UsageError(f"{path}: no format of recordings ends in {path.suffix!r}", remedy) from None
