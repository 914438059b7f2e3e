"""Programs of IEC 61131-3 under test in Python: a language of `fieldrig.programs`."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fieldrig.errors import ArgumentError
from fieldrig.text.nearest import closest

if TYPE_CHECKING:
    from fieldrig_devices.iec.bench.iec_bench import IecBench

ENDINGS: Final = (".st", ".il", ".exp", ".xml", ".tcpou", ".tcgvl", ".tcdut", ".tctleo", ".tcio", ".tctto")
OPTIONS: Final = ("dialect", "resource")


def takes(path: Path) -> bool:
    return path.is_dir() or path.suffix.lower() in ENDINGS


def load(paths: list[Path], options: Mapping[str, Any]) -> "IecBench":
    """Load source files.  ConfigError with every mistake, ArgumentError for an unknown option."""
    from fieldrig_devices.iec.bench.iec_bench import IecBench
    from fieldrig_devices.iec.dialect import DIALECTS
    from fieldrig_devices.iec.imports import is_foreign
    from fieldrig_devices.iec.source_texts import files_in, read_text
    from fieldrig_devices.languages.source_file import SourceFile

    for name in options:
        if name not in OPTIONS:
            raise ArgumentError(f"program has no option {name!r}", closest(name, OPTIONS))
    dialect = options.get("dialect", "epas-4")
    if dialect not in DIALECTS:
        raise ArgumentError(f"there is no dialect {dialect!r}", closest(str(dialect), list(DIALECTS)))
    files = [SourceFile(str(file), read_text(file)) for path in paths for file in files_in(path)]
    files = [file for file in files if not is_foreign(file.text)]
    return IecBench(files, dialect, options.get("resource", ""))
