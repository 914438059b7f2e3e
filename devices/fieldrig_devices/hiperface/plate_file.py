"""Name plates as YAML files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fieldrig.errors import ConfigError, Mistake
from fieldrig.store import replace_file
from fieldrig.wording import explain
from fieldrig.yaml_source import Source, key_text, read
from fieldrig_devices.hiperface.plate import NamePlate

HEADING = "# Name plate of a motor; see docs/nameplate.md.\n"


def load_plate(path: Path) -> NamePlate:
    """ConfigError with every mistake in the file."""
    file = str(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as cause:
        raise ConfigError([Mistake(file, None, "", f"it can't be read: {cause}", "name a plate file")]) from cause
    source = read(text, file)
    if source.mistakes:
        raise ConfigError(source.mistakes)
    return _validated(source, file)


def edited(plate: NamePlate, changes: Mapping[str, str]) -> NamePlate:
    """The plate with other values, given as texts as they would stand in a file.  ConfigError if it can't be."""
    values = plate.model_dump()
    texts = {name for name, field in NamePlate.model_fields.items() if field.annotation is str}
    for key, text in changes.items():
        values[key] = text if key in texts else read(text, "").data
    return _validated(Source(data=values), "")


def save_plate(plate: NamePlate, path: Path) -> None:
    """With every value, also one that would be there without being said."""
    replace_file(path, as_yaml(plate).encode())


def as_yaml(plate: NamePlate) -> str:
    return HEADING + "".join(f"{key}: {_scalar(value)}\n" for key, value in plate.model_dump().items())


def _validated(source: Source, file: str) -> NamePlate:
    values: Any = source.data if source.data is not None else {}
    try:
        return NamePlate.model_validate(values)
    except ValidationError as cause:
        mistakes = []
        for finding in explain(cause, values, NamePlate):
            mark = source.marks.get(finding.path) or source.marks.get(finding.path[:-1])
            line = mark.line if mark else None
            mistakes.append(Mistake(file, line, key_text(finding.path), finding.what, finding.remedy))
        raise ConfigError(mistakes) from cause


def _scalar(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return f"{value}"
