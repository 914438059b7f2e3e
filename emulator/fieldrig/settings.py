"""What the settings of a kind are made of: strict pydantic models, and the field types they share.

A bus or device names its model by the annotation of its `settings` parameter.
"""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, ValidationInfo

from fieldrig.errors import Mistake


class WrongKey(NamedTuple):
    """One mistake that settings found in themselves, and the keys that lead to it from where they stand."""

    path: tuple[str | int, ...]
    what: str
    remedy: str = ""


class Settings(BaseModel):
    """Keys of one `kind` in a rig file.  Unknown keys and wrong types are refused."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    def wrong_for(self, members: Sequence[str]) -> Iterator[WrongKey]:
        """Of a bus: what can't be meant, now that it is known which devices of the rig file are linked to it.

        A bus that outsiders join under names of their own can't refuse a name that it doesn't know.
        """
        yield from ()

    def doubts(self) -> Iterator[Mistake]:
        """What is odd in the files that these settings name, though a rig can run with them.

        `fieldrig check` prints it as warnings.
        """
        yield from ()


class WrongSettingsError(ValueError):
    """What a validator raises when it found several mistakes: `fieldrig check` tells each, at its key."""

    def __init__(self, wrong: Iterable[WrongKey]) -> None:
        self.wrong = tuple(wrong)
        super().__init__("; ".join(f"{'.'.join(map(str, one.path))}: {one.what}" for one in self.wrong))


def refuse_all(wrong: Iterator[WrongKey]) -> None:
    """WrongSettingsError with all of them, if there are any."""
    found = tuple(wrong)
    if found:
        raise WrongSettingsError(found)


def _existing_file(value: Any, info: ValidationInfo) -> Path:
    """A path relative to the configuration file, made absolute.

    Validation context: `folder`, or `folders` to look in, if the configuration extends one that lies elsewhere.
    """
    if not isinstance(value, str | Path):
        raise ValueError("a path to a file, relative to the folder of this configuration")
    context = info.context or {}
    paths = [(Path(folder) / value).resolve() for folder in context.get("folders", [context.get("folder", ".")])]
    found = next((path for path in paths if path.is_file()), None)
    if found is None:
        raise ValueError(f"no such file: {paths[0]}")
    return found


ConfigFile = Annotated[
    Path,
    PlainValidator(_existing_file, json_schema_input_type=str),
    Field(description="a file, relative to the folder of the configuration"),
]
