"""What the settings of a kind are made of: strict pydantic models, and the field types they share.

A bus or device names its model by the annotation of its `settings` parameter.
"""

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo


class Settings(BaseModel):
    """Keys of one `kind` in a rig file.  Unknown keys and wrong types are refused."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


def _existing_file(value: Any, info: ValidationInfo) -> Any:
    """A path relative to the configuration file (validation context `folder`), made absolute."""
    if not isinstance(value, str | Path):
        raise ValueError("a path to a file, relative to the folder of this configuration")
    folder = Path((info.context or {}).get("folder", "."))
    path = (folder / value).resolve()
    if not path.is_file():
        raise ValueError(f"no such file: {path}")
    return path


ConfigFile = Annotated[
    Path,
    BeforeValidator(_existing_file),
    Field(
        description="a file, relative to the folder of the configuration",
        json_schema_extra={"type": "string"},
    ),
]
