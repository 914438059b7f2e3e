"""Kinds for the tests of the configuration; a module of its own, because a rig file names classes by module."""

from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from random import Random
from typing import Any, ClassVar, Literal

from pydantic import Field

from fieldrig.bus import BusModel, DirectBus, ModelBus, Time
from fieldrig.clock import Clock
from fieldrig.device import Device
from fieldrig.errors import RigError
from fieldrig.link import Link
from fieldrig.settings import ConfigFile, Settings, WrongKey
from fieldrig.storage.store import Store


class Frame: ...


class Word: ...


class Gap: ...


class SignalSettings(Settings):
    wire: str
    scale: float = Field(1.0, gt=0)


class LineSettings(Settings):
    bitrate: int = Field(500_000, ge=10_000, le=1_000_000, description="bit/s")
    listen: str | None = None
    connect: str | None = None
    also: list[str] = Field(default_factory=list)
    first: str | None = None

    def wrong_for(self, members: Sequence[str], masters: Collection[str]) -> Iterator[WrongKey]:
        if self.first is not None and self.first not in members:
            yield WrongKey(("first",), f"{self.first} is not here", f"here are: {', '.join(members)}")


class _Line(ModelBus[Any]):
    def __init__(self, name: str, settings: LineSettings) -> None:
        super().__init__(name, settings)
        if settings.bitrate == 666_666:
            raise RigError("no crystal gives 666666 bit/s", "take 500000")

    def encode(self, message: Any) -> bytes:
        raise NotImplementedError

    def decode(self, data: bytes) -> Any:
        raise NotImplementedError

    def show(self, message: Any) -> str:
        raise NotImplementedError

    def model(self) -> BusModel[Any]:
        raise NotImplementedError


class CanLine(_Line):
    about: ClassVar[str] = "frames"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})
    family: ClassVar[str] = "can"
    messages: ClassVar[tuple[type, ...]] = (Frame,)


class WordLine(_Line):
    times: ClassVar[frozenset[Time]] = frozenset({"virtual", "real"})
    family: ClassVar[str] = "words"
    messages: ClassVar[tuple[type, ...]] = (Word, Gap)


class Unfinished(DirectBus[Any]):
    """A bus class as it must not be: not to be made."""


class NodeSettings(Settings):
    node_id: int = Field(ge=1, le=127, description="number on the bus")
    file: ConfigFile | None = None
    mode: Literal["fast", "slow"] = "fast"
    signals: dict[str, str | SignalSettings] = Field(default_factory=dict)
    pair: tuple[int, int] = (0, 0)
    folder: Path | None = None
    units: dict[int, str] = Field(default_factory=dict)


class Node(Device):
    about: ClassVar[str] = "a node on frames"

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: NodeSettings,
        store: Store,
        random: Random,
        can: Link[Frame],
        words: list[Link[Word | Gap]] | None = None,
    ) -> None:
        self.got = (clock, name, settings, store, random, can, words)
        if settings.file is not None and settings.file.read_text() == "broken":
            raise ValueError("line 1 is not an object")


class Reader(Device):
    """Asks for nothing but two links, one of which it can do without."""

    def __init__(self, words: Link[Word], frames: "Link[Frame] | None" = None) -> None:
        self.got = (words, frames)


class Listener(Device):
    """Takes any bus, and one or several."""

    def __init__(self, any_bus: Link[Any], several: list[Link[Frame]]) -> None:
        self.got = (any_bus, several)


class Idle(Device):
    """A device without a constructor of its own."""


class Odd(Device):
    def __init__(self, clock: Clock, colour: str) -> None:
        self.got = (clock, colour)


class Dangling(Device):
    def __init__(self, clock: "Clokc") -> None:  # type: ignore[name-defined]  # noqa: F821  # a user's slip
        self.got = clock


NOT_A_CLASS = 5
