"""The files that describe nodes and units, as a command names them: `5=io32.eds`, `1=meter.yaml`."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Final, TypeVar

from fieldrig.cli.common import reading
from fieldrig.config.settings_file import validated
from fieldrig.errors import ConfigError, Mistake, UsageError
from fieldrig.settings import WrongSettingsError
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds.reader import load
from fieldrig_devices.canopen.eds.text import EdsError
from fieldrig_devices.registers.table import Table, load_table

NODES: Final = range(1, 128)
UNITS: Final = range(256)

Read = TypeVar("Read")


def described(words: Iterable[str] | None, numbers: range, example: str) -> dict[int, Path]:
    """Return files by number, from words such as `5=io32.eds`.  ValueError, with the example, for anything else."""
    found: dict[int, Path] = {}
    for word in words or ():
        number, equals, path = word.partition("=")
        if not equals or not path or not number.strip().isascii() or not number.strip().isdigit():
            raise ValueError(f"{word!r} is not NUMBER=FILE\nsuch as {example}")
        if int(number) not in numbers:
            raise ValueError(f"{word!r}: expected {numbers.start} to {numbers.stop - 1} before the =, found {number}")
        if int(number) in found:
            raise ValueError(f"{word!r}: {number} already has the file {found[int(number)]}")
        found[int(number)] = Path(path)
    return found


def read_eds(files: Mapping[int, Path]) -> dict[int, Dictionary]:
    """Return dictionaries by node-ID.  ConfigError with the mistakes of all files."""
    return _read(files, lambda node_id, path: load(path, node_id))


def read_registers(files: Mapping[int, Path]) -> dict[int, Table]:
    """Return register tables by unit, from YAML files or CSV lists.  ConfigError with the mistakes of all files."""
    return _read(files, lambda unit, path: _from_list(path) if path.suffix.lower() == ".csv" else load_table(path))


def _from_list(path: Path) -> Table:
    from fieldrig_devices.begin.register_list import read_list

    try:
        return validated(Table, {space: entries for space, entries in read_list(path).entries.items() if entries})
    except (ValueError, WrongSettingsError) as cause:
        remedy = "expected CSV with names of columns in the first line: address, name, type, unit, scale"
        raise UsageError(f"{path} is no list of registers: {cause}", remedy) from cause


def _read(files: Mapping[int, Path], read: Callable[[int, Path], Read]) -> dict[int, Read]:
    found: dict[int, Read] = {}
    mistakes: list[Mistake] = []
    for number, path in files.items():
        try:
            with reading(path):
                found[number] = read(number, path)
        except ConfigError as cause:
            mistakes += cause.mistakes
        except EdsError as cause:
            mistakes += [
                Mistake(str(path), each.line or None, each.place, each.what, each.remedy) for each in cause.findings
            ]
        except UnicodeDecodeError as cause:
            raise UsageError(f"{path} is not a text file: {cause}") from cause
    if mistakes:
        raise ConfigError(mistakes)
    return found
