"""Name plates as YAML files."""

from collections.abc import Mapping
from pathlib import Path

from fieldrig.config.settings_file import load_settings, settings_of
from fieldrig.config.yaml_source import Source, read
from fieldrig.system.whole_file import replace_file
from fieldrig_devices.hiperface.plate import NamePlate

HEADING = "# Name plate of a motor; `fieldrig schema name-plate` describes its keys.\n"


def load_plate(path: Path) -> NamePlate:
    """Return the plate that a file holds.  ConfigError with every mistake in the file."""
    return load_settings(path, NamePlate)


def edited(plate: NamePlate, changes: Mapping[str, str]) -> NamePlate:
    """Return the plate with other values, given as texts as in a plate file.  ConfigError for values it cannot have."""
    values = plate.model_dump()
    texts = {name for name, field in NamePlate.model_fields.items() if field.annotation is str}
    for key, text in changes.items():
        values[key] = text if key in texts else read(text, "").data
    return settings_of(Source(data=values), NamePlate)


def save_plate(plate: NamePlate, path: Path) -> None:
    """Write the plate to a file, with every value, defaults included."""
    replace_file(path, as_yaml(plate).encode())


def as_yaml(plate: NamePlate) -> str:
    """Return the text of a plate file."""
    return HEADING + "".join(f"{key}: {_scalar(value)}\n" for key, value in plate.model_dump().items())


def _scalar(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return f"{value}"
