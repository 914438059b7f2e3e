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


Place = tuple[str, int]
"""The bus of a node or unit, and its number; an empty bus is any."""
Files = Mapping[int, Path] | Mapping[Place, Path]
"""Files by number, or by bus and number."""


def described(words: Iterable[str] | None, numbers: range, example: str) -> dict[Place, Path]:
    """Return files by place, from words such as `5=io32.eds`, or `can1:5=io32.eds` for one bus of several.

    ValueError, with the example, for anything else.
    """
    found: dict[Place, Path] = {}
    for word in words or ():
        place, equals, path = word.partition("=")
        bus, _, number = place.rpartition(":")
        if not equals or not path or not number.isascii() or not number.isdigit():
            raise ValueError(f"{word!r} is not NUMBER=FILE\nsuch as {example}")
        if int(number) not in numbers:
            raise ValueError(f"{word!r}: expected {numbers.start} to {numbers.stop - 1} before the =, found {number}")
        if (bus, int(number)) in found:
            raise ValueError(f"{word!r}: {place} already has the file {found[bus, int(number)]}")
        found[bus, int(number)] = Path(path)
    return found


def read_eds(files: Files) -> dict[Place, Dictionary]:
    """Return dictionaries by place.  ConfigError with the mistakes of all files."""
    return _read(files, load_for)


def load_for(place: Place, path: Path) -> Dictionary:
    """Return the dictionary of the node at this place."""
    return load(path, place[1])


def read_registers(files: Files) -> dict[Place, Table]:
    """Return register tables by place, from YAML files or CSV lists.  ConfigError with the mistakes of all files."""
    return _read(files, lambda place, path: _from_list(path) if path.suffix.lower() == ".csv" else load_table(path))


def of_bus(found: Mapping[Place, Read], bus: str) -> dict[int, Read]:
    """Return what is described of one bus, by number."""
    return {number: read for where in ("", bus) for (of, number), read in found.items() if of == where}


def _from_list(path: Path) -> Table:
    from fieldrig_devices.begin.register_list import read_list

    try:
        return validated(Table, {space: entries for space, entries in read_list(path).entries.items() if entries})
    except (ValueError, WrongSettingsError) as cause:
        remedy = "expected CSV with names of columns in the first line: address, name, type, unit, scale"
        raise UsageError(f"{path} is no list of registers: {cause}", remedy) from cause


def _read(files: Files, read: Callable[[Place, Path], Read]) -> dict[Place, Read]:
    found: dict[Place, Read] = {}
    mistakes: list[Mistake] = []
    for key, path in files.items():
        place = ("", key) if isinstance(key, int) else key
        try:
            with reading(path):
                found[place] = read(place, path)
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
