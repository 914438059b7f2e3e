"""What the settings of a kind are made of: strict pydantic models, and the field types they share.

A bus or device names its model by the annotation of its `settings` parameter.
"""

from collections.abc import Collection, Hashable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, ValidationInfo

from fieldrig.errors import Mistake


class WrongKey(NamedTuple):
    """One mistake in settings: the keys that lead to it from their top, what is wrong, and what was expected."""

    path: tuple[str | int, ...]
    what: str
    remedy: str = ""


class Claim(NamedTuple):
    """Something that a device has, or needs, on a bus at one of its links, such as a node-ID."""

    link: str
    """Parameter of the device; without a bus there, nothing is claimed."""
    what: str
    """What it is called there: `node-ID`, `unit`, `wire`."""
    value: Hashable
    path: tuple[str | int, ...]
    """The key in the device's entry that says so."""
    place: int | None = None
    """Which one, of several buses at this link; None: all of them."""


class Settings(BaseModel):
    """Keys of one `kind` in a rig file.  Unknown keys and wrong types are refused."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    def claims(self, device: str) -> Iterator[Claim]:
        """What the device of this name has, of which there can be only one on a bus."""
        yield from ()

    def needs(self, device: str) -> Iterator[Claim]:
        """What the device of this name expects another one to have on a bus."""
        yield from ()

    def leads_to(self, what: str, value: Hashable) -> bool:
        """True if somebody outside the rig may have on this bus what a device needs there."""
        return True

    def wrong_for(self, members: Sequence[str], masters: Collection[str]) -> Iterator[WrongKey]:
        """The keys of a bus that can't be meant, given the devices of the rig file that are linked to it.

        `masters` are the members that claim to be the master of this bus.  A bus that outsiders join under names of
        their own can't refuse a name that it doesn't know.
        """
        yield from ()

    def doubts(self) -> Iterator[Mistake]:
        """What is odd in the files that these settings name, though a rig can run with them.

        `fieldrig check` prints it as warnings.
        """
        yield from ()


MASTER = "master"
"""`what` of a claim to be the master of a bus; its value is the same for all."""


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
    folders = [Path(folder) for folder in context.get("folders", [context.get("folder", ".")])]
    try:
        paths = [(folder / value).resolve() for folder in folders]
        found = next((path for path in paths if path.is_file()), None)
        if found is None:
            raise ValueError(f"no such file: {_short(str(paths[0]))}")
        with found.open("rb") as file:
            while file.read(_PIECE):  # whatever the disk has against it is found out here
                pass
    except OSError as cause:
        raise ValueError(f"{_short(str(value))} can't be read: {cause.strerror or cause}") from cause
    return found


def _short(path: str) -> str:
    """A path in a message, cut in the middle where nobody would read all of it."""
    return path if len(path) <= _LONGEST_SHOWN else f"{path[: _LONGEST_SHOWN // 2]}...{path[-_LONGEST_SHOWN // 2 :]}"


_PIECE = 1 << 20
_LONGEST_SHOWN = 200


ConfigFile = Annotated[
    Path,
    PlainValidator(_existing_file, json_schema_input_type=str),
    Field(description="a file, relative to the folder of the configuration"),
]
