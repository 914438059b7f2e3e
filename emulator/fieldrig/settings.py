"""The base of all settings: strict pydantic models, and the field types they share.

A bus or device names its model by the annotation of its `settings` parameter.
"""

from collections.abc import Collection, Hashable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PlainValidator, ValidationInfo

from fieldrig.errors import Mistake
from fieldrig.outside.addresses import split_address
from fieldrig.system.own_files import checked_path
from fieldrig.text.nearest import nearest_file

RunPath = Annotated[str, Field(min_length=1), AfterValidator(checked_path)]
"""A path of a rig file that stays in its run folder."""


def _checked(address: str) -> str:
    split_address(address)
    return address


Address = Annotated[
    str,
    AfterValidator(_checked),
    Field(description="host:port, such as 127.0.0.1:5020"),
]
"""`host:port` in settings; `split_address` splits it."""


class WrongKey(NamedTuple):
    """One mistake in settings: the keys that lead to it from their top, what is wrong, and what was expected."""

    path: tuple[str | int, ...]
    what: str
    remedy: str = ""


class Claim(NamedTuple):
    """Something that a device has, or needs, on a bus at one of its links, such as a node-ID."""

    link: str
    """The parameter of the device; nothing is claimed if no bus is linked there."""
    what: str
    """The name of the claimed thing: `node-ID`, `unit`, `wire`."""
    value: Hashable
    path: tuple[str | int, ...]
    """The key in the device's entry that makes the claim."""
    place: int | None = None
    """The position of the bus, if the link has several; None for all of them."""


class Settings(BaseModel):
    """The keys of one `kind` in a rig file.  Unknown keys and wrong types are refused."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    def claims(self, device: str) -> Iterator[Claim]:
        """Yield what the device of this name has that exists only once on a bus."""
        yield from ()

    def needs(self, device: str) -> Iterator[Claim]:
        """Yield what the device of this name needs from another one on a bus."""
        yield from ()

    def leads_to(self, what: str, value: Hashable) -> bool:
        """Return whether something outside the rig may have on this bus what a device needs there."""
        return True

    def serves(self) -> Iterator[Claim]:
        """Yield what the device answers to on its buses, which others may have too, such as services by TCP."""
        yield from ()

    def offers(self) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
        """Yield what a bus has for a device, or says about it: its key, and kind and value of what a device has.

        A value that no device has is no mistake, but one that is nearly that of a device is a doubt.
        """
        yield from ()

    def cycle_ns(self) -> int | None:
        """Return the cycle of the buses of which the device is the master; None without one."""
        return None

    def wrong_for(self, members: Sequence[str], masters: Collection[str]) -> Iterator[WrongKey]:
        """Yield the wrong keys of a bus, given the devices of the rig file that are linked to it.

        `masters` are the members that claim to be the master of this bus.  A bus whose outside clients choose their
        names cannot refuse a name that it does not know.
        """
        yield from ()

    def wire_for(self, device: str, what: str) -> str:
        """Return the wire for `what`: the value of the key `what_wire`, or else `device.what`."""
        given: str | None = getattr(self, f"{what}_wire")
        return given or f"{device}.{what}"

    def doubts(self) -> Iterator[Mistake | WrongKey]:
        """Yield what is unusual in these settings, or in the files that they name, though a rig can run with them.

        `fieldrig check` prints it as warnings.
        """
        yield from ()


WIRE = "wire"
"""The `what` of a claim to drive a wire."""
MASTER = "master"
"""The `what` of a claim to be the master of a bus; its value is the same for all."""
MEMBER = "member"
"""The kind of a name in a fault that is the name of a member of its bus; other kinds are the `what` of claims."""


class WrongSettingsError(ValueError):
    """Several mistakes that a validator has found; `fieldrig check` prints each at its key."""

    def __init__(self, wrong: Iterable[WrongKey]) -> None:
        self.wrong = tuple(wrong)
        super().__init__("; ".join(f"{'.'.join(map(str, key.path))}: {key.what}" for key in self.wrong))


def refuse_all(wrong: Iterable[WrongKey]) -> None:
    """Raise WrongSettingsError with all of the mistakes, if there are any."""
    mistakes = tuple(wrong)
    if mistakes:
        raise WrongSettingsError(mistakes)


def _existing_file(value: Any, info: ValidationInfo) -> Path:
    """Return a path relative to the configuration file as an absolute path.

    Validation context: `folder`, or `folders` to search, if the configuration extends a file in another folder.
    """
    if not isinstance(value, str | Path):
        raise ValueError("a path to a file, relative to the folder of this configuration")
    context = info.context or {}
    folders = [Path(folder) for folder in context.get("folders", [context.get("folder", ".")])]
    try:
        paths = [(folder / value).resolve() for folder in folders]
        existing = next((path for path in paths if path.is_file()), None)
        if existing is None:
            raise ValueError(f"no such file: {_short(str(paths[0]))}\n{nearest_file(paths[0])}".rstrip())
        with existing.open("rb") as file:
            while file.read(_PIECE):  # whatever the disk has against it is found out here
                pass
    except OSError as cause:
        raise ValueError(f"{_short(str(value))} cannot be read: {cause.strerror or cause}") from cause
    return existing


def _short(path: str) -> str:
    """Return a path for a message, cut in the middle if it is very long."""
    return path if len(path) <= _LONGEST_SHOWN else f"{path[: _LONGEST_SHOWN // 2]}...{path[-_LONGEST_SHOWN // 2 :]}"


_PIECE = 1 << 20
_LONGEST_SHOWN = 200


ConfigFile = Annotated[
    Path,
    PlainValidator(_existing_file, json_schema_input_type=Path),
    Field(description="a file, relative to the folder of the configuration"),
]
"""A file that a rig file names, relative to the folder of the rig file; it exists and can be read."""
