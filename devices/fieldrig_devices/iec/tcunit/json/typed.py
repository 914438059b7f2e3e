"""The native functions behind FB_JsonReadWriteDatatype: variables of a type as JSON, and back.

The members of a structure have the names of its components; enumerations, times and pointers are numbers, DATE_AND_TIME
is a text of ISO 8601.  What is read changes the components that the text names, and all or nothing of them.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

from fieldrig_devices.iec import characters
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.host import Results
from fieldrig_devices.iec.layout import kind_number, members, storage
from fieldrig_devices.iec.memory import Memory, limiter
from fieldrig_devices.iec.program import Program, Variable
from fieldrig_devices.iec.tcunit.json.iso import DATE_AND_TIME, is_time
from fieldrig_devices.iec.tcunit.json.nodes import Node, parsed, written
from fieldrig_devices.iec.tcunit.json.sax import Writers
from fieldrig_devices.iec.tcunit.json.texts import Given, put_text, short, size_of, text_at
from fieldrig_devices.iec.types import ArrayType, BlockType, StringType, StructType, Type, Value

T = TypeVar("T")


class WrongJsonError(Exception):
    """A text that has no value of the type."""


class Typed:
    """`types` are those of the program by their names in small letters, once it is loaded."""

    def __init__(self, given: Given, writers: Writers) -> None:
        self._given, self._writers = given, writers
        self.types: Mapping[str, Type] = {}
        self.variables: Mapping[str, Variable] = {}

    def use(self, program: Program) -> None:
        self.types, self.variables = program.types, program.globals

    def functions(self) -> dict[str, Callable[..., Results]]:
        return {
            "AddJsonValueFromSymbol": lambda _, writer, *symbol: self._add(writer, None, *symbol),
            "AddJsonKeyValueFromSymbol": lambda _, writer, key, *symbol: self._add(writer, key, *symbol),
            "GetJsonStringFromSymbol": lambda _, *symbol: short(self._text(*symbol) or ""),
            "GetSizeJsonStringFromSymbol": lambda _, *symbol: size_of(self._text(*symbol) or ""),
            "CopyJsonStringFromSymbol": self._copy,
            "SetSymbolFromJson": self._set,
            "GetDatatypeNameByAddress": lambda _, size, address: short(self._at(size, address)[1]),
            "GetSymbolNameByAddress": lambda _, size, address: short(self._at(size, address)[0]),
        }

    @property
    def _memory(self) -> Memory:
        assert self._given.memory is not None
        return self._given.memory

    # ---- writing

    def _text(self, name: int, size: int, address: int) -> str | None:
        """Return the JSON of a variable; None if there is no such type, or one of another size."""
        kind = self._type(self._given.text(name), size)
        return written(self._node(kind, address)) if kind is not None else None

    def _type(self, name: str, size: int) -> Type | None:
        plain = name.strip().rpartition(".")[2].casefold()
        kind = self.types.get(plain) or next((one for one in Elementary if one.name.casefold() == plain), None)
        return kind if kind is not None and kind.size == size else None

    def _add(self, writer: int, key: int | None, *symbol: int) -> Results:
        text = self._text(*symbol)
        if text is None:
            return (False,)
        if key is not None:
            self._writers.writer(writer).key(self._given.text(key))
        self._writers.writer(writer).raw(text)
        return (True,)

    def _copy(self, _: int, name: int, size: int, variable: int, into: int, room: int) -> Results:
        return self._given.copy(self._text(name, size, variable) or "", into, room)

    def _node(self, kind: Type, address: int) -> Node:
        if isinstance(kind, ArrayType):
            size = kind.element.size
            return Node(elements=[self._node(kind.element, address + place * size) for place in range(kind.count)])
        if isinstance(kind, StructType | BlockType):
            return Node(members=[(name, self._part(part, address)) for name, part in _parts(kind).items()])
        return Node(self._scalar(kind, address))

    def _part(self, part: "_Part", address: int) -> Node:
        kind, offset, bit = part
        if bit >= 0:
            return Node(bool(int(self._memory.value_of(address + offset, Elementary.BYTE)) >> bit & 1))
        return self._node(kind, address + offset)

    def _scalar(self, kind: Type, address: int) -> Value:
        stored = storage(kind)
        if isinstance(stored, StringType):
            if stored.is_wide:
                return _utf_8(self._memory.text_of(address, is_wide=True))
            return text_at(self._memory, address)
        assert stored is not None
        value = self._memory.value_of(address, stored)
        return DATE_AND_TIME.text(int(value)) if stored is Elementary.DT else value

    # ---- reading

    def _set(self, _: int, text: int, name: int, size: int, address: int) -> Results:
        kind, node = self._type(self._given.text(name), size), parsed(self._given.text(text))
        if kind is None or node is None:
            return (False,)
        try:
            changes = list(self._changes(kind, address, node))
        except WrongJsonError:
            return (False,)
        for change in changes:
            change()
        return (True,)

    def _changes(self, kind: Type, address: int, node: Node) -> Iterator[Callable[[], Any]]:
        """Yield what writes the values of a text; WrongJsonError for one that the type does not have."""
        if isinstance(kind, ArrayType):
            for place, one in enumerate((_list(node.elements))[: kind.count]):
                yield from self._changes(kind.element, address + place * kind.element.size, one)
        elif isinstance(kind, StructType | BlockType):
            parts = {name.casefold(): part for name, part in _parts(kind).items()}
            for name, one in _list(node.members):
                if (part := parts.get(name.casefold())) is not None:
                    yield from self._part_changes(part, address, one)
        else:
            yield self._change(kind, address, node.scalar)

    def _part_changes(self, part: "_Part", address: int, node: Node) -> Iterator[Callable[[], Any]]:
        kind, offset, bit = part
        if bit < 0:
            yield from self._changes(kind, address + offset, node)
        elif isinstance(node.scalar, bool):
            yield lambda: self._put_bit(address + offset, bit, is_on=bool(node.scalar))
        else:
            raise WrongJsonError

    def _put_bit(self, address: int, bit: int, *, is_on: bool) -> None:
        byte = int(self._memory.value_of(address, Elementary.BYTE)) & ~(1 << bit)
        self._memory.put_value(address, kind_number(Elementary.BYTE), byte | is_on << bit)

    def _change(self, kind: Type, address: int, value: object) -> Callable[[], Any]:
        stored = storage(kind)
        if isinstance(stored, StringType):
            if not isinstance(value, str):
                raise WrongJsonError
            if stored.is_wide:
                wide = _wide(value)[: stored.length]
                return lambda: self._memory.put_value(address, kind_number(stored), wide)
            return lambda: put_text(self._memory, address, value[: stored.length], stored.size)
        assert stored is not None
        number = _number(stored, value)
        return lambda: self._memory.put_value(address, kind_number(stored), number)

    # ---- names

    def _at(self, size: int, address: int) -> tuple[str, str]:
        """Return the path and the type of the variable of this size at an address; empty texts for what has no name."""
        for variable in self.variables.values():
            if variable.location is None and variable.offset <= address < variable.offset + variable.type.size:
                return _within(variable.name, variable.type, variable.offset, address, size)
        return "", ""


_Part = tuple[Type, int, int]
"""The type of a component, where it is in the structure, and its bit or -1."""


def _parts(kind: StructType | BlockType) -> dict[str, _Part]:
    if isinstance(kind, StructType):
        return {field.name: (field.type, field.offset, field.bit) for field in kind.fields.values()}
    return {one.name: (one.type, one.offset, -1) for one in members(kind) if not one.is_reference}


def _list(given: list[T] | None) -> list[T]:
    if given is None:
        raise WrongJsonError
    return given


def _utf_8(text: str) -> str:
    """Return a wide text as a STRING of JSON has it, with a character for each byte of UTF-8."""
    whole = text.encode("utf-16-le", "surrogatepass").decode("utf-16-le", "replace")
    return whole.encode().decode("latin-1")


def _wide(text: str) -> str:
    data = text.encode("latin-1", "replace")
    try:
        return characters.widened(data.decode())
    except UnicodeDecodeError:
        return text


def _number(stored: Elementary, value: object) -> Value:
    """Return a number for a variable; WrongJsonError for what is none, or outside of its range."""
    if stored is Elementary.BOOL:
        if not isinstance(value, bool):
            raise WrongJsonError
        return value
    if stored is Elementary.DT and isinstance(value, str) and is_time(value):
        return DATE_AND_TIME.value(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise WrongJsonError
    if not stored.is_real and (value != int(value) or not stored.low <= value <= stored.high):
        raise WrongJsonError
    return limiter(stored)(value)


def _within(path: str, kind: Type, offset: int, address: int, size: int) -> tuple[str, str]:
    if offset == address and kind.size == size:
        return path, str(kind)
    if isinstance(kind, ArrayType) and kind.element.size:
        place = (address - offset) // kind.element.size
        inner = offset + place * kind.element.size
        return _within(f"{path}[{kind.low + place}]", kind.element, inner, address, size)
    if isinstance(kind, StructType | BlockType):
        for name, (part, inner, _) in _parts(kind).items():
            if offset + inner <= address < offset + inner + part.size:
                found = _within(f"{path}.{name}", part, offset + inner, address, size)
                if found[0]:
                    return found
    return "", ""
