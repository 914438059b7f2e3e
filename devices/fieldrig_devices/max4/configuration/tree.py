"""The control configuration: a tree of objects with parameters, each with its logical address.

Source: PacDrive manual 3604-3640, 3862-3905 (digest PD-020 to PD-028).  A controller has parameter groups and objects
below it; an object has a default name and a symbolic name.  A path leads from the root through names of either kind, or
starts at a symbolic name, and may omit groups: "MAx-4.General.MsgFilter", "PacDriveM.Timer1", "belt.DiagCode".
Case does not matter.  The scheme of logical addresses is our choice: the number of the object times 65536, plus the
number of the parameter in its object.
"""

from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from typing import Final

from fieldrig.device import Value
from fieldrig.points.checks import choice_in, number_in, text_in, truth_in, whole_in

OBJECT_STEP: Final = 0x1_0000


class Access(Enum):
    """Kinds of access to a parameter (PD-026, PD-028); the manual names the second and the last."""

    INPUT = "input"
    """Writable; after a boot it has its first value."""
    INPUT_INIT = "input with user initialisation"
    """Writable, with its start value in the parameter file."""
    OUTPUT = "output"
    """Read-only, shown by the controller."""
    SLOW = "through SERCOS"
    """Located in a drive: a read returns the last value received, and a write arrives many cycles later."""


class Type(Enum):
    """IEC 61131-3 types of parameters, with their smallest and largest values."""

    BOOL = ("BOOL", 0, 1)
    INT = ("INT", -(2**15), 2**15 - 1)
    UINT = ("UINT", 0, 2**16 - 1)
    DINT = ("DINT", -(2**31), 2**31 - 1)
    UDINT = ("UDINT", 0, 2**32 - 1)
    LREAL = ("LREAL", 0, 0)
    STRING = ("STRING", 0, 80)
    """The largest value is the length of the text (PD-322)."""

    def __init__(self, text: str, low: int, high: int) -> None:
        self.text, self.low, self.high = text, low, high

    @property
    def number(self) -> int:
        """The number that windows show for the type, counted from 1 in the order of this table."""
        return list(Type).index(self) + 1


NO_WORDS: Final[Mapping[int, str]] = {}


class Parameter:
    """One parameter.  Without `read` it stores its value itself; without `write` it accepts any value that fits."""

    __slots__ = (
        "_read",
        "_value",
        "_write",
        "about",
        "access",
        "address",
        "first",
        "high",
        "is_secret",
        "low",
        "name",
        "only",
        "type",
        "underway",
        "unit",
        "watcher",
        "words",
    )

    def __init__(
        self,
        name: str,
        type: Type,
        access: Access = Access.OUTPUT,
        first: Value = 0,
        *,
        unit: str = "",
        low: int | None = None,
        high: int | None = None,
        only: tuple[int, ...] = (),
        about: str = "",
        read: Callable[[], Value] | None = None,
        write: Callable[[Value], None] | None = None,
        is_secret: bool = False,
        words: Mapping[int, str] = NO_WORDS,
    ) -> None:
        """`first` is the value after a boot; `low`, `high` and `only` restrict the values of the type.

        `words` has the meanings of numbers, for people.
        """
        self.is_secret, self.words = is_secret, words
        self.name, self.type, self.access, self.unit, self.about = name, type, access, unit, about
        self.low = type.low if low is None else low
        self.high = type.high if high is None else high
        self.only = only
        self.watcher: Callable[[Value], None] | None = None
        """Called with each value that is written, if the parameter stores it itself."""
        self.underway: Value | None = None
        """A value that has been written and is on its way to a drive, or None; it is shown until the drive answers."""
        self.address = 0
        """The logical address, once the parameter is in a tree."""
        self.first = first
        self._read, self._write = read, write
        self._value: Value = "" if type is Type.STRING and first == 0 else bool(first) if type is Type.BOOL else first

    @property
    def is_writable(self) -> bool:
        return self.access is not Access.OUTPUT

    @property
    def value(self) -> Value:
        return self._value if self._read is None else self._read()

    @property
    def shown(self) -> Value:
        """The value as anybody outside may read it: stars instead of a secret."""
        value = self.value if self.underway is None else self.underway
        return "*" * 8 if self.is_secret and value else value

    def set(self, value: Value) -> None:
        """Write a value from outside or from the program.  ValueError if the parameter cannot have this value."""
        if not self.is_writable:
            raise ValueError(f"{self.name}: expected no write, because the parameter is read-only")
        value = self.checked(value)
        if self._write is None:
            self._value = value
            if self.watcher is not None:
                self.watcher(value)
        else:
            self._write(value)

    def put(self, value: Value) -> None:
        """Set the value from inside the controller, without checks."""
        self._value = value

    def checked(self, value: Value) -> Value:
        """Return the value in the type of the parameter.  ValueError if the parameter cannot have this value."""
        match self.type:
            case Type.STRING:
                return text_in(value, self.high, self.name)
            case Type.BOOL:
                return truth_in(value, self.name)
            case Type.LREAL:
                return float(number_in(value, name=self.name))
        number = whole_in(value, self.low, self.high, name=self.name)
        return choice_in(number, self.only, self.name) if self.only else number


class Group:
    """Parameters of an object that belong together."""

    def __init__(self, owner: "Object", name: str) -> None:
        self.owner, self.name = owner, name
        self.parameters: dict[str, Parameter] = {}

    def add(self, parameter: Parameter) -> Parameter:
        self.parameters[parameter.name] = parameter
        parameter.address = self.owner.next_address()
        return parameter


class Object:
    """One object of the configuration."""

    def __init__(self, tree: "ObjectTree", parent: "Object | None", name: str, type_name: str, symbol: str) -> None:
        self.tree, self.parent = tree, parent
        self.name = name
        """The default name, such as "MC-4" or "output_0"."""
        self.type_name = type_name
        """The type in IEC code, such as "MC_4" or "D_IN"."""
        self.symbol = symbol
        self.groups: dict[str, Group] = {}
        self.children: list[Object] = []
        self.log_adr = tree.next_address()
        """The logical address, `object.logAdr` in IEC code (PD-025)."""
        self._parameters = 0

    def next_address(self) -> int:
        self._parameters += 1
        return self.log_adr + self._parameters

    def group(self, name: str) -> Group:
        """The group with this name, created if necessary."""
        if name not in self.groups:
            self.groups[name] = Group(self, name)
        return self.groups[name]

    def add(self, name: str, type_name: str, symbol: str) -> "Object":
        """Add an object below this object.  ValueError if the symbolic name is in use."""
        self.tree.check_symbol(symbol)
        child = Object(self.tree, self, name, type_name, symbol)
        self.children.append(child)
        return child

    @property
    def parameters(self) -> Iterator[Parameter]:
        return (parameter for group in self.groups.values() for parameter in group.parameters.values())

    @property
    def path(self) -> str:
        """The path from the root, by symbolic names."""
        return self.name if self.parent is None else f"{self.parent.path}.{self.symbol or self.name}"

    def __getitem__(self, name: str) -> Parameter:
        """A parameter by its name in any group; case does not matter.  KeyError if there is none."""
        wanted = name.casefold()
        for parameter in self.parameters:
            if parameter.name.casefold() == wanted:
                return parameter
        raise KeyError(name)

    def is_called(self, name: str) -> bool:
        return name.casefold() in (self.name.casefold(), self.symbol.casefold())


class ObjectTree:
    """All objects of a controller."""

    def __init__(self, name: str = "MAx-4", type_name: str = "MAX4", symbol: str = "PacDriveM") -> None:
        self._objects = 0
        self.root = Object(self, None, name, type_name, symbol)

    def next_address(self) -> int:
        self._objects += 1
        return self._objects * OBJECT_STEP

    def objects(self) -> Iterator[Object]:
        """All objects, parents before children."""
        waiting = [self.root]
        while waiting:
            node = waiting.pop(0)
            yield node
            waiting[:0] = node.children

    def parameters(self) -> Iterator[tuple[str, Parameter]]:
        """All parameters by their full paths, which include the group."""
        for owner in self.objects():
            for group in owner.groups.values():
                for parameter in group.parameters.values():
                    yield f"{owner.path}.{group.name}.{parameter.name}", parameter

    def check_symbol(self, symbol: str) -> None:
        """ValueError if an object has this name; names in IEC code are not case-sensitive (PD-350)."""
        if symbol and any(other.symbol.casefold() == symbol.casefold() for other in self.objects()):
            raise ValueError(f"expected a symbolic name that is not in use, got {symbol!r}")

    def object(self, path: str) -> Object:
        """An object by its path, or by "_" and its symbolic name (PD-025).  KeyError if there is none."""
        way = self._walk(path.removeprefix("_").split("."))
        if way is None or way[1]:
            raise KeyError(path)
        return way[0]

    def parameter(self, path: str) -> Parameter:
        """A parameter by its path.  KeyError if there is none."""
        way = self._walk(path.split("."))
        if way is not None:
            owner, rest = way
            match rest:
                case [name]:
                    return self._named(owner.parameters, name, path)
                case [group_name, name]:
                    for group in owner.groups.values():
                        if group.name.casefold() == group_name.casefold():
                            return self._named(iter(group.parameters.values()), name, path)
        raise KeyError(path)

    def get(self, path: str) -> Value:
        return self.parameter(path).value

    def set(self, path: str, value: Value) -> None:
        """Write a parameter.  KeyError for an unknown path, ValueError for a wrong value."""
        self.parameter(path).set(value)

    def by_address(self, address: int) -> Object | Parameter:
        """The object or parameter with this logical address.  KeyError if there is none."""
        for owner in self.objects():
            if owner.log_adr == address:
                return owner
            if owner.log_adr == address // OBJECT_STEP * OBJECT_STEP:
                for parameter in owner.parameters:
                    if parameter.address == address:
                        return parameter
        raise KeyError(address)

    def at(self, address: int) -> Object | Parameter | None:
        """The object or parameter with this logical address, or None if there is none."""
        try:
            return self.by_address(address)
        except KeyError:
            return None

    def parameter_at(self, address: int) -> Parameter | None:
        """The parameter with this logical address, or None if there is no parameter."""
        node = self.at(address)
        return node if isinstance(node, Parameter) else None

    @staticmethod
    def _named(parameters: Iterator[Parameter], name: str, path: str) -> Parameter:
        for parameter in parameters:
            if parameter.name.casefold() == name.casefold():
                return parameter
        raise KeyError(path)

    def _walk(self, names: list[str]) -> tuple[Object, list[str]] | None:
        """The object that a path leads to, with the rest of the path."""
        node = next((start for start in self.objects() if start.is_called(names[0])), None)
        if node is None:
            return None
        rest = names[1:]
        while rest:
            below = next((child for child in node.children if child.is_called(rest[0])), None)
            if below is None:
                break
            node, rest = below, rest[1:]
        return node, rest
