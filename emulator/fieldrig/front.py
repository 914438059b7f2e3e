"""The front of a device as data: what a person at the machine sees and operates.

A device returns its front from `Device.front`.  Each part names points of the device by their keys, never values, so a
front is made once and may be shown by anything: the page of a rig draws it, and an answer carries it as JSON.  Parts
are the same without power, as sheet metal is.

    Front(
        Plate("ASA-RT", "TR4"),
        [Group([Led("F7", "led.F7")], "LEDs"), Group([Key("F1", "key.F1")], "keys", columns=4)],
    )

A name of a part is unique among the parts of its front that can be operated; it is the key of its point unless the
part is given one.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Final, Literal, Protocol, Self

__all__ = [
    "SHAPES",
    "Clamp",
    "Colour",
    "Drawing",
    "Entry",
    "Front",
    "Gap",
    "Gauge",
    "Group",
    "Key",
    "Knob",
    "Led",
    "Lines",
    "Number",
    "Part",
    "Plate",
    "SevenSegment",
    "Switch",
    "Text",
]

Value = bool | int | float | str
Colour = Literal["green", "red", "yellow", "blue", "white"]
"""The colour of a lamp."""
Names = Sequence[tuple[Value, str]]
"""Values with their names, such as the meaning of a state's number."""
OPERATED: Final = frozenset({"key", "switch", "knob", "entry"})
"""The sorts of parts that a person moves, besides terminals that no wire drives."""
OFF_ON: Final[Names] = ((False, "off"), (True, "on"))


class Shown(Protocol):
    """A point (`fieldrig.device.Point`), as a front needs to know it."""

    @property
    def read(self) -> Callable[[], Value]: ...

    @property
    def write(self) -> Callable[[Value], None] | None: ...

    @property
    def unit(self) -> str: ...

    @property
    def about(self) -> str: ...

    @property
    def states(self) -> Sequence[str]: ...


MOST_PARTS: Final = 96
"""Most parts of a front that is made from points; a device may have thousands."""


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a front.  `about` is a few words on what it shows or does."""

    sort: ClassVar[str] = ""

    label: str = ""
    point: str = ""
    about: str = ""
    name: str = ""

    @property
    def is_operated(self) -> bool:
        """True for what a person moves; its point can be written."""
        return self.sort in OPERATED

    @property
    def points(self) -> tuple[str, ...]:
        """Return the keys of all points that the part names."""
        return (self.point,) if self.point else ()

    def words(self) -> dict[str, Any]:
        """Return the part in values that JSON has; whatever is empty is left out."""
        own = {field.name: _plain(getattr(self, field.name)) for field in fields(self)}
        named = {"sort": self.sort, "name": self.name or self.point, "operated": self.is_operated}
        return named | {key: value for key, value in own.items() if key != "name" and value not in ("", [], {}, None)}


@dataclass(frozen=True, slots=True)
class Led(Part):
    """A lamp.  It is lit while the point has one of the values of `lit`, and blinks at one of `blinks`.

    An empty `lit` stands for every value but 0, False, "" and those of `blinks`.
    """

    sort: ClassVar[str] = "led"
    colour: Colour = "green"
    lit: Sequence[Value] = ()
    blinks: Sequence[Value] = ()


@dataclass(frozen=True, slots=True)
class Text(Part):
    """A value in words.  `names` has the meanings of values; `good` and `bad` are values with a colour."""

    sort: ClassVar[str] = "text"
    names: Names = ()
    good: Sequence[Value] = ()
    bad: Sequence[Value] = ()
    hex_digits: int | None = None
    """Digits of a number without a name, written as the words of CANopen are: `0237h`; None writes it as decimal."""


@dataclass(frozen=True, slots=True)
class Number(Part):
    """A number with its unit, which is that of the point."""

    sort: ClassVar[str] = "number"
    decimals: int | None = None
    """Digits after the point; None shows the number as it is."""


@dataclass(frozen=True, slots=True)
class Knob(Number):
    """A number that a person sets, within limits if there are any."""

    sort: ClassVar[str] = "knob"
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True)
class Gauge(Number):
    """A number as a bar or a needle between `low` and `high`."""

    sort: ClassVar[str] = "gauge"
    low: float = 0.0
    high: float = 100.0


@dataclass(frozen=True, slots=True)
class SevenSegment(Part):
    """Digits of seven segments.

    The point has the characters; or, in a display of one digit, `segments` has the letters a to g and p that are lit.
    """

    sort: ClassVar[str] = "seven-segment"
    digits: int = 1
    segments: str = ""
    blinks: str = ""
    """The point that is true while the display blinks."""

    @property
    def points(self) -> tuple[str, ...]:
        return tuple(key for key in (self.point, self.segments, self.blinks) if key)


@dataclass(frozen=True, slots=True)
class Lines(Part):
    """A text display.  The point has all its lines, or `lines` has a point for each."""

    sort: ClassVar[str] = "lines"
    columns: int = 16
    rows: int = 1
    lines: Sequence[str] = ()
    texts: str = ""
    """A point with lines of `line column height text`, for a display with characters of several heights."""
    cursor: str = ""
    """A point with line and column of the cursor, from 1."""
    blinks: str = ""
    """The point that is true while the display blinks."""

    @property
    def points(self) -> tuple[str, ...]:
        return tuple(key for key in (self.point, *self.lines, self.texts, self.cursor, self.blinks) if key)


@dataclass(frozen=True, slots=True)
class Key(Part):
    """A key that is pressed and held: `pressed` is written when it goes down, and `released` when it goes up.

    With None for `released` it does its work when it goes down, and nothing is written later.
    """

    sort: ClassVar[str] = "key"
    pressed: Value = True
    released: Value | None = False


@dataclass(frozen=True, slots=True)
class Switch(Part):
    """A switch that stays where it is put; `positions` are the names of its values."""

    sort: ClassVar[str] = "switch"
    positions: Names = OFF_ON


@dataclass(frozen=True, slots=True)
class Entry(Part):
    """A field for a text that a person types, such as a command in words."""

    sort: ClassVar[str] = "entry"


@dataclass(frozen=True, slots=True)
class Clamp(Part):
    """A terminal, whose level or value it shows.  One with `is_set` is set by a person, as no wire drives it."""

    sort: ClassVar[str] = "clamp"
    side: Literal["in", "out"] = "in"
    is_set: bool = False
    bit: int | None = None
    """The bit of the point's number, from 0, that is the level of this terminal."""

    @property
    def is_operated(self) -> bool:
        return self.is_set

    def words(self) -> dict[str, Any]:
        name = self.name or (self.point if self.bit is None else f"{self.point}.{self.bit}")
        return {**Part.words(self), "name": name}


@dataclass(frozen=True, slots=True)
class Gap(Part):
    """An empty place in a group with columns."""

    sort: ClassVar[str] = "gap"


SHAPES: Final[Mapping[str, frozenset[str]]] = {
    "tank": frozenset({"level"}),
    "winder": frozenset({"radius", "angle"}),
    "conveyor": frozenset({"position", "fronts"}),
    "shaft": frozenset({"angle"}),
    "slide": frozenset({"position"}),
    "heater": frozenset({"temperature"}),
}
"""The shapes of drawings, with the roles whose points each of them needs; further roles are extras."""


@dataclass(frozen=True, slots=True)
class Drawing(Part):
    """A plain drawing of one shape that moves with the points of its roles, to the measures of `scale`."""

    sort: ClassVar[str] = "drawing"
    shape: str = ""
    roles: Mapping[str, str] = field(default_factory=dict)
    """The keys of points by role, such as `{"level": "level"}`."""
    scale: Mapping[str, float] = field(default_factory=dict)
    """Measures that do not change, such as `{"height": 2.0}`."""

    def __post_init__(self) -> None:
        missing = SHAPES[self.shape] - self.roles.keys()
        if missing:
            raise ValueError(f"a {self.shape} needs the roles {', '.join(sorted(missing))}")

    @property
    def points(self) -> tuple[str, ...]:
        return tuple(self.roles.values())


@dataclass(frozen=True, slots=True)
class Plate:
    """The name plate: who made the machine, its model, and points with what is written on it, by label."""

    maker: str = ""
    model: str = ""
    points: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Group:
    """Parts that are beside each other under a title; with `columns` they are a grid, read row by row."""

    parts: Sequence[Part]
    title: str = ""
    columns: int = 0

    def words(self) -> dict[str, Any]:
        return {"title": self.title, "columns": self.columns, "parts": [part.words() for part in self.parts]}


@dataclass(frozen=True, slots=True)
class Front:
    """The front of a device: its name plate, and groups of parts from top to bottom."""

    plate: Plate
    groups: Sequence[Group]

    @property
    def parts(self) -> Iterator[Part]:
        for group in self.groups:
            yield from group.parts

    @property
    def points(self) -> set[str]:
        """Return the keys of all points that the front names."""
        return {key for part in self.parts for key in part.points} | set(self.plate.points.values())

    def words(self, kind: str, about: str, points: Mapping[str, Shown]) -> dict[str, Any]:
        """Return the front in values that JSON has, with the kind of the device and the units of its points."""
        plate = {"kind": kind, "about": about, "maker": self.plate.maker, "model": self.plate.model}
        return {
            "plate": plate | {"points": dict(self.plate.points)},
            "groups": [group.words() for group in self.groups],
            "units": {key: points[key].unit for key in sorted(self.points) if key in points and points[key].unit},
        }

    @classmethod
    def of_points(cls, points: Mapping[str, Shown]) -> Self:
        """Return a front made from points: what can be written is operated, and everything else is shown.

        Points whose keys have the same beginning, up to a dot or a slash, are a group.
        """
        groups: dict[str, list[Part]] = {}
        for key in list(points)[:MOST_PARTS]:
            head = _split(key)[0]
            groups.setdefault(head, []).append(part_of(key, points[key]))
        return cls(Plate(), [Group(parts, head) for head, parts in groups.items()])


def part_of(key: str, point: Shown) -> Part:
    """Return the part that fits a point, by the type of its present value."""
    value, label, is_operated = point.read(), _split(key)[1] or key, point.write is not None
    if isinstance(value, bool):
        return Switch(label, key, point.about) if is_operated else Led(label, key, point.about)
    if point.states and is_operated:
        return Switch(label, key, point.about, positions=[(state, state) for state in point.states])
    if isinstance(value, str):
        return Entry(label, key, point.about) if is_operated else Text(label, key, point.about)
    return Knob(label, key, point.about) if is_operated else Number(label, key, point.about)


def _split(key: str) -> tuple[str, str]:
    """Return the beginning of a key, up to its last dot or slash, and the rest."""
    at = max(key.rfind("."), key.rfind("/"))
    return key[: max(at, 0)], key[at + 1 :]


def _plain(value: Any) -> Any:
    """Return the value of a field as JSON has it."""
    if isinstance(value, Mapping):
        return dict(value)
    return [_plain(item) for item in value] if isinstance(value, Sequence) and not isinstance(value, str) else value
