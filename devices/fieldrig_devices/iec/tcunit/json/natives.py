"""The native functions behind the blocks of Tc3_JsonXml."""

import base64
import binascii
from collections.abc import Callable
from functools import partial
from typing import Final

from fieldrig_devices.iec.host import Library, NativeFunction, Results
from fieldrig_devices.iec.memory import Memory
from fieldrig_devices.iec.program import Program
from fieldrig_devices.iec.tcunit.json import declared, iso, parsers
from fieldrig_devices.iec.tcunit.json.nodes import INT32, INT64, UINT32, UINT64, Kind, Node, parsed, written
from fieldrig_devices.iec.tcunit.json.parsers import Handles, Parser
from fieldrig_devices.iec.tcunit.json.sax import Writers
from fieldrig_devices.iec.tcunit.json.texts import COST_NS, Given, limit, short, size_of
from fieldrig_devices.iec.tcunit.json.typed import Typed
from fieldrig_devices.iec.types import Value

RANGES: Final = {"Int": INT32, "Uint": UINT32, "Int64": INT64, "Uint64": UINT64}
KINDS: Final = {
    "Array": {Kind.ARRAY},
    "Object": {Kind.OBJECT},
    "String": {Kind.STRING},
    "Number": {Kind.NUMBER},
    "Null": {Kind.NULL},
    "Bool": {Kind.TRUE, Kind.FALSE},
    "True": {Kind.TRUE},
    "False": {Kind.FALSE},
}


class Documents:
    """The documents and writers of one run."""

    def __init__(self) -> None:
        self._given = Given()
        self._handles = Handles()
        self._parsers: dict[int, Parser] = {}
        self._writers = Writers(self._given)
        self._typed = Typed(self._given, self._writers)

    def use(self, memory: Memory, program: Program) -> None:
        """Work in the memory of a program that is loaded."""
        self._given.memory = memory
        self._typed.use(program)

    def library(self) -> Library:
        """Return the library with its text and its functions."""
        functions = {f"{declared.PREFIX}new".lower(): NativeFunction(lambda: (self._handles.new(),), COST_NS)}
        sorts = {"DOM": self._of_parsers(), "SAX": self._writers.functions(), "TYPE": self._typed.functions()}
        for kind, known in sorts.items():
            for name in declared.methods(kind):
                functions[declared.native_name(kind, name)] = NativeFunction(known[name], COST_NS)
        return Library(declared.FILE, declared.text(), functions, {})

    # ---- the parser

    def _of_parsers(self) -> dict[str, Callable[..., Results]]:
        made: dict[str, Callable[..., Results]] = {
            "NewDocument": self._new,
            "ParseDocument": self._parse,
            "GetDocumentRoot": lambda parser: (self._handles.of(self._parser(parser).root),),
            "GetDocument": lambda parser: short(self._document(parser)),
            "GetDocumentLength": lambda parser: (len(self._document(parser)) + 1,),
            "CopyDocument": lambda parser, *into: self._given.copy(self._document(parser), *into),
            "ExceptionRaised": lambda parser: (self._parser(parser).has_failed,),
            "GetMaxDecimalPlaces": lambda parser: (self._parser(parser).places,),
            "SetMaxDecimalPlaces": lambda parser, places: limit(self._parser(parser), places),
            "FindMember": self._find,
            "FindMemberPath": self._find_path,
            "HasMember": lambda parser, v, name: (bool(self._find(parser, v, name)[0]),),
            "GetArraySize": lambda parser, v: (len(self._elements(v)),),
            "GetArrayValue": lambda parser, place: self._value(place),
            "GetArrayValueByIdx": lambda parser, v, index: self._at(v, index),
            "ArrayBegin": lambda parser, v: self._begin(v, Kind.ARRAY),
            "ArrayEnd": lambda parser, v: self._begin(v, Kind.ARRAY, is_end=True),
            "NextArray": lambda parser, place: self._next(place),
            "ClearArray": lambda parser, v, place: self._clear(v, Kind.ARRAY),
            "RemoveArray": lambda parser, v, place: self._remove(v, place),
            "MemberBegin": lambda parser, v: self._begin(v, Kind.OBJECT),
            "MemberEnd": lambda parser, v: self._begin(v, Kind.OBJECT, is_end=True),
            "NextMember": lambda parser, place: self._next(place),
            "GetMemberName": lambda parser, place: self._name(place),
            "GetMemberValue": lambda parser, place: self._value(place),
            "RemoveMember": lambda parser, v, place, keeps_order: self._remove(v, place),
            "RemoveMemberByName": self._remove_name,
            "RemoveAllMembers": lambda parser, v: self._clear(v, Kind.OBJECT),
            "Swap": self._swap,
            "GetBool": lambda parser, v: (self._kind(v) is Kind.TRUE,),
            "GetDouble": lambda parser, v: (self._number(v),),
            "GetJson": lambda parser, v: short(self._written(parser, v)),
            "GetJsonLength": lambda parser, v: size_of(self._written(parser, v)),
            "CopyJson": lambda parser, v, *into: self._given.copy(self._written(parser, v), *into),
            "GetString": lambda parser, v: short(self._string(v)),
            "GetStringLength": lambda parser, v: (len(self._string(v)),),
            "CopyString": lambda parser, v, *into: self._given.copy(self._string(v), *into),
            "GetType": lambda parser, v: (int(self._kind(v) or 0),),
            "IsDouble": lambda parser, v: (self._kind(v) is Kind.NUMBER and self._whole(v) is None,),
            "IsISO8601TimeFormat": lambda parser, v: (iso.is_time(self._string(v)),),
        }
        for name, clock in iso.CLOCKS.items():
            made[f"Get{name}"] = lambda parser, v, clock=clock: (clock.value(self._string(v)),)
        for name, numbers in RANGES.items():
            made[f"Get{name}"] = partial(self._integer, numbers)
            made[f"Is{name}"] = partial(self._is_integer, numbers)
        for name, kinds in KINDS.items():
            made[f"Is{name}"] = lambda parser, v, kinds=kinds: (self._kind(v) in kinds,)
        for form, read in (("Base64", _of_base64), ("HexBinary", _of_hex)):
            made[f"Get{form}"] = partial(self._bytes, read)
            made[f"Is{form}"] = partial(self._has_bytes, read)
        for name, make in self._makers().items():
            made[f"Set{name}"] = partial(self._set, make)
            made[f"Add{name}Member"] = partial(self._add, make)
            made[f"Pushback{name}Value"] = partial(self._push, make)
        return made

    def _makers(self) -> dict[str, Callable[..., Node | None]]:
        """Return how a value is made of the arguments of a method, by the type in its name."""
        scalars = dict.fromkeys(("Bool", "Double", "Int", "Int64", "Uint", "Uint64"), Node)
        times = {name: (lambda value, clock=clock: Node(clock.text(value))) for name, clock in iso.CLOCKS.items()}
        encoded = {
            form: (lambda address, size, form=form: Node(self._given.encoded(form, address, size)))
            for form in ("Base64", "HexBinary")
        }
        return {
            **scalars,
            **times,
            **encoded,
            "Null": Node,
            "String": lambda address: Node(self._given.text(address)),
            "Json": lambda address: parsed(self._given.text(address)),
            "Object": lambda: Node(members=[]),
            "Array": lambda reserve: Node(elements=[]),
        }

    def _parser(self, handle: int) -> Parser:
        return self._parsers.setdefault(handle, Parser())

    def _new(self, handle: int) -> Results:
        parsers.replace(self._parser(handle), self._handles, Node(members=[]))
        return (self._handles.of(self._parser(handle).root),)

    def _parse(self, handle: int, address: int) -> Results:
        return (self._handles.of(parsers.load(self._parser(handle), self._handles, self._given.text(address))),)

    def _document(self, handle: int) -> str:
        parser = self._parser(handle)
        return "" if parser.root is None else written(parser.root, parser.places)

    def _written(self, handle: int, v: int) -> str:
        node = self._handles.node(v)
        return "" if node is None else written(node, self._parser(handle).places)

    # ---- values

    def _kind(self, v: int) -> Kind | None:
        node = self._handles.node(v)
        return None if node is None else node.kind

    def _whole(self, v: int) -> int | None:
        node = self._handles.node(v)
        return None if node is None else node.whole

    def _is_integer(self, numbers: range, parser: int, v: int) -> Results:
        whole = self._whole(v)
        return (whole is not None and whole in numbers,)  # a range is searched for what is no number

    def _integer(self, numbers: range, parser: int, v: int) -> Results:
        whole = self._whole(v)
        return (whole if whole is not None and whole in numbers else 0,)

    def _number(self, v: int) -> float:
        node = self._handles.node(v)
        is_number = node is not None and node.kind is Kind.NUMBER
        return float(node.scalar or 0) if node is not None and is_number else 0.0

    def _string(self, v: int) -> str:
        node = self._handles.node(v)
        return node.scalar if node is not None and isinstance(node.scalar, str) else ""

    def _bytes(self, read: Callable[[str], bytes | None], parser: int, v: int, address: int, size: int) -> Results:
        data = read(self._string(v))
        if not data or len(data) > size:
            return (0,)
        self._given.put_bytes(address, data)
        return (len(data),)

    def _has_bytes(self, read: Callable[[str], bytes | None], parser: int, v: int) -> Results:
        return (self._kind(v) is Kind.STRING and read(self._string(v)) is not None,)

    def _set(self, make: Callable[..., Node | None], parser: int, v: int, *given: Value) -> Results:
        node, new = self._handles.node(v), make(*given)
        if node is None or new is None:
            return (0,)
        self._handles.forget(node.children())
        node.become(new)
        return (v,)

    def _swap(self, parser: int, a: int, b: int) -> Results:
        one, other = self._handles.node(a), self._handles.node(b)
        if one is not None and other is not None:
            kept = Node(one.scalar, one.members, one.elements)
            one.become(other)
            other.become(kept)
        return ()

    # ---- members

    def _add(self, make: Callable[..., Node | None], parser: int, v: int, name: int, *given: Value) -> Results:
        """Add a member.  A null gets an object by its first member."""
        node, new = self._handles.node(v), make(*given)
        if node is None or new is None or node.kind not in (Kind.OBJECT, Kind.NULL):
            return (0,)
        if node.members is None:
            node.members = []
        node.members.append((self._given.text(name), new))
        return (self._handles.of(new),)

    def _find(self, parser: int, v: int, name: int) -> Results:
        node = self._handles.node(v)
        return (0 if node is None else self._handles.of(node.member(self._given.text(name))),)

    def _find_path(self, parser: int, v: int, path: int) -> Results:
        node = self._handles.node(v)
        for name in self._given.text(path).split("/"):
            node = None if node is None else node.member(name)
        return (self._handles.of(node),)

    def _remove_name(self, parser: int, v: int, name: int, keeps_order: bool) -> Results:
        node, wanted = self._handles.node(v), self._given.text(name)
        names = [known for known, _ in node.members or ()] if node is not None else []
        if node is None or node.members is None or wanted not in names:
            return (False,)
        self._handles.forget([node.members.pop(names.index(wanted))[1]])
        return (True,)

    def _name(self, place: int) -> Results:
        found = self._handles.place(place)
        members = found.node.members or [] if found is not None else []
        return short(members[found.index][0]) if found is not None and found.index < len(members) else ("",)

    # ---- elements and places

    def _push(self, make: Callable[..., Node | None], parser: int, v: int, *given: Value) -> Results:
        """Add an element.  A null gets an array by its first element."""
        node, new = self._handles.node(v), make(*given)
        if node is None or new is None or node.kind not in (Kind.ARRAY, Kind.NULL):
            return (0,)
        if node.elements is None:
            node.elements = []
        node.elements.append(new)
        return (self._handles.of(new),)

    def _elements(self, v: int) -> list[Node]:
        node = self._handles.node(v)
        return node.elements or [] if node is not None else []

    def _at(self, v: int, index: int) -> Results:
        elements = self._elements(v)
        return (self._handles.of(elements[index]) if index < len(elements) else 0,)

    def _begin(self, v: int, kind: Kind, *, is_end: bool = False) -> Results:
        """Return where the values of a kind begin or end, which is nowhere if there are none."""
        node = self._handles.node(v)
        if node is None or node.kind is not kind or not node.children():
            return (0,)
        return (self._handles.of_place(node, len(node.children()) if is_end else 0),)

    def _next(self, place: int) -> Results:
        found = self._handles.place(place)
        return (0 if found is None else self._handles.of_place(found.node, found.index + 1),)

    def _value(self, place: int) -> Results:
        found = self._handles.place(place)
        return (0 if found is None else self._handles.of(found.value()),)

    def _clear(self, v: int, kind: Kind) -> Results:
        node = self._handles.node(v)
        if node is None or node.kind is not kind:
            return (False,)
        self._handles.forget(node.children())
        for values in (node.members, node.elements):
            if values is not None:
                values.clear()
        return (True,)

    def _remove(self, v: int, place: int) -> Results:
        node, found = self._handles.node(v), self._handles.place(place)
        if node is None or found is None or found.node is not node or found.value() is None:
            return (False,)
        self._handles.forget([node.children()[found.index]])
        for values in (node.members, node.elements):
            if values is not None:
                values.pop(found.index)
        return (True,)


def _of_base64(text: str) -> bytes | None:
    try:
        return base64.b64decode(text, validate=True)
    except binascii.Error:
        return None


def _of_hex(text: str) -> bytes | None:
    try:
        return bytes.fromhex(text) if " " not in text else None
    except ValueError:
        return None
