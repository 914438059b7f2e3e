"""The messages of a bus by name, as far as the rig knows it: which node, which service, which object, what value.

A namer belongs to a bus family.  It is found under the entry points "fieldrig.namers" by the name of the family, and
made from what the devices at the bus say of themselves in the rig file.  It needs no running rig, so a trace of a file
is named in the same way.  A namer reads the messages of one bus in their order, because an answer is named by its
request.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.metadata import entry_points
from typing import Any, Final, NamedTuple, Protocol, runtime_checkable

from fieldrig.bus import Bus
from fieldrig.config.entries import DeviceEntry
from fieldrig.config.rig_file import RigConfig
from fieldrig.settings import Claim

NAMERS: Final = "fieldrig.namers"


class Named(NamedTuple):
    """One message by name."""

    kind: str
    """The service, such as `SDO read` or `TPDO 1`; empty if it is not known."""
    node: str
    """The device that it comes from or goes to, by its name in the rig; empty if there is none, or several."""
    text: str
    """Its content, in one line."""
    nodes: tuple[str, ...] = ()
    """All devices that it comes from or goes to, if they are several."""
    aside: str = ""
    """How it arrived, such as `1 late`: a part of its text that is no content."""

    def concerns(self, word: str) -> bool:
        """Return whether a name of its devices contains this word, in small letters."""
        return any(word in name.lower() for name in (self.node, *self.nodes))


MOST_SHOWN: Final = 6
"""Devices in the text of one message."""


def of_several(empty: str, parts: Iterable[tuple[str, str, str]], head: str = "") -> Named:
    """Return a message that consists of parts, each with its kind, its device and its text.

    `empty` is the kind of a message without a part, and `head` begins the text.
    """
    listed = list(parts)
    kinds = tuple(dict.fromkeys(kind for kind, _, _ in listed))
    told: dict[str, list[str]] = {}
    for kind, node, text in listed:
        told.setdefault(node, []).append(f"{kind} {text}".rstrip() if len(kinds) > 1 else text)
    kind = ", ".join(kinds) or empty
    if len(told) == 1:
        node, texts = next(iter(told.items()))
        return Named(kind, node, "; ".join(filter(None, (head, *texts))))
    texts = [f"{node}: {', '.join(filter(None, texts))}".removesuffix(": ") for node, texts in told.items()]
    more = [f"{len(texts) - MOST_SHOWN} more"] if len(texts) > MOST_SHOWN else []
    return Named(kind, "", "; ".join(filter(None, (head, *texts[:MOST_SHOWN], *more))), tuple(told))


MOST_LISTED: Final = 8
"""Values in the text of one message."""


def listed(texts: Iterable[str]) -> str:
    """Return texts with commas between them: the first ones of many, and how many there are besides."""
    every = list(texts)
    rest = len(every) - MOST_LISTED
    return ", ".join(every[:MOST_LISTED]) + (f" and {rest} more" if rest > 0 else "")


def in_words(named: Named) -> str:
    """Return the whole of it in one line, such as `SDO read belt 6041:00 Statusword`."""
    return " ".join(part for part in named[:3] if part)


class Member(NamedTuple):
    """A device at the bus, with the parameters of its links to it."""

    entry: DeviceEntry
    links: tuple[str, ...]

    def claims(self, what: str) -> list[Claim]:
        """Return what the device claims at this bus of one sort, such as `node-ID`."""
        claims = self.entry.settings.claims(self.entry.name)
        return [claim for claim in claims if claim.what == what and claim.link in self.links]


class Namer(Protocol):
    """Names the messages of a bus."""

    def __call__(self, message: Any, sender: str = "") -> Named:
        """Return the name of a message; one that cannot be named has its usual text, without a kind.

        `sender` is the member that sent it, as the trace names it; bytes of one sender that follow each other are one
        stream.
        """


@runtime_checkable
class Learning(Protocol):
    """A namer that names more if it learns what was configured before it began to read."""

    def wants(self) -> Mapping[str, Sequence[str]]:
        """Return the points that say so, by device."""

    def learn(self, device: str, values: Mapping[str, Any]) -> None:
        """Take the values of these points of a device, by key."""


MakeNamer = Callable[[Bus[Any], Sequence[Member]], Namer]


class _Unnamed:
    """The namer of a family that has none."""

    def __init__(self, bus: Bus[Any]) -> None:
        self._bus = bus

    def __call__(self, message: Any, sender: str = "") -> Named:
        return Named("", "", self._bus.show(message))


def namer_of(config: RigConfig, bus: str) -> Namer:
    """Return the namer of a bus of a rig."""
    entry = config.buses[bus].bus
    points = entry_points(group=NAMERS, name=entry.family)
    if not points:
        return _Unnamed(entry)
    make: MakeNamer = next(iter(points)).load()
    return make(entry, members_of(config, bus))


def members_of(config: RigConfig, bus: str) -> list[Member]:
    """Return the devices that are linked to a bus."""
    found = (
        Member(entry, tuple(link for link, buses in entry.links.items() if bus in buses))
        for entry in config.devices.values()
    )
    return [member for member in found if member.links]
