"""Declared types, in any order: names, arrays, strings, subranges, pointers, enumerations and structures."""

import re
from collections.abc import Collection, Mapping
from functools import partial
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.expressions import Expressions
from fieldrig_devices.iec.check.project import UNKNOWN, Pending, Project
from fieldrig_devices.iec.check.texts import a
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Constant, Pou
from fieldrig_devices.iec.types import (
    ArrayType,
    EnumType,
    Field,
    InterfaceType,
    OpenArrayType,
    PointerType,
    StringType,
    StructType,
    SubrangeType,
    Type,
)
from fieldrig_devices.languages.mistakes import Code

BIT: Final = "bit"
"""The name of a BOOL that has one bit of a byte in a structure."""
LONGEST_DOCUMENT: Final = 1_000_000
"""Characters of a STRING that has a document."""
DEEPEST: Final = 40
"""Levels of declared types of which each is needed for the one before."""

_ATTRIBUTE: Final = re.compile(r"\{\s*attribute\s+'(\w+)'\s*\}", re.IGNORECASE)
_OF_OTHER_LANGUAGES: Final[Mapping[str, str]] = {
    "boolean": "BOOL",
    "bit": "BOOL",
    "char": "STRING",
    "text": "STRING",
    "integer": "INT",
    "short": "INT",
    "int8": "SINT",
    "int16": "INT",
    "int32": "DINT",
    "long": "DINT",
    "uint8": "USINT",
    "uint16": "UINT",
    "uint32": "UDINT",
    "unsigned": "UINT",
    "float": "REAL",
    "single": "REAL",
    "double": "LREAL",
    "timer": "TON",
    "counter": "CTU",
}
"""Names of types in other languages, and the types that they mean."""
SHORT_OF_LONG: Final = {Elementary.LWORD: "DWORD", Elementary.LINT: "DINT", Elementary.ULINT: "UDINT"}


class TypeSpecs:
    def __init__(self, project: Project) -> None:
        self._project = project
        self._key = project.key
        self._declared: dict[str, tuple[tree.TypeDeclaration, Context]] = {}
        self._busy: set[str] = set()
        self._depth = 0
        self._pending: dict[EnumType, dict[str, Pending]] = {}
        """The values of enumerations whose numbers are not worked out, by their names as names are compared."""
        self.structures: list[tuple[StructType, tree.StructSpec, Context]] = []

    def add(self, name: str, declaration: tree.TypeDeclaration, context: Context) -> None:
        """Note a declared type; `resolve_all` works it out, or the first use does."""
        self._declared[name] = (declaration, context)
        if isinstance(declaration.type, tree.EnumSpec):
            has_attributes = self._project.dialect.has_enumeration_attributes
            attributes = {found[1].casefold() for one in declaration.comments for found in _ATTRIBUTE.finditer(one)}
            is_qualified = has_attributes and "qualified_only" in attributes
            kind = self._enumeration(declaration.name, declaration.type, context, name, is_qualified=is_qualified)
            kind.is_strict = has_attributes and "strict" in attributes

    @property
    def names(self) -> Collection[str]:
        return self._declared.keys()

    def forget(self, name: str) -> None:
        """Forget a declared type of a library, which the project redefines."""
        self._declared.pop(name, None)

    def resolve_all(self) -> None:
        for name, (declaration, context) in self._declared.items():
            self._named(name, tree.NamedType(declaration.name, position=declaration.position), context)

    def declared(self) -> dict[str, Type]:
        return {name: self._project.types[name] for name in self._declared if name in self._project.types}

    def default_sources(self) -> list[tuple[str, tree.TypeDeclaration, Context]]:
        """The declared types that have a start value of their own."""
        return [
            (name, *declaration) for name, declaration in self._declared.items() if declaration[0].initial is not None
        ]

    # ---- the kinds of specifications

    def resolve(self, spec: tree.TypeSpec, context: Context) -> Type:
        """Return the type; UNKNOWN after a message."""
        if self._depth >= DEEPEST:
            return self._no(context, spec, f"types are nested more than {DEEPEST} deep", "declare inner types first")
        self._depth += 1
        kind = self._of_spec(spec, context)
        self._depth -= 1
        return kind

    def _of_spec(self, spec: tree.TypeSpec, context: Context) -> Type:
        match spec:
            case tree.NamedType(""):  # the parser reported this declaration
                return UNKNOWN
            case tree.NamedType():
                return self._named(self._key(spec.name), spec, context)
            case tree.StringSpec():
                return self._string(spec, context)
            case tree.SubrangeSpec():
                return self._subrange(spec, context)
            case tree.ArraySpec():
                return self._array(spec, context)
            case tree.OpenArraySpec():
                hint = "VAR_IN_OUT of a function, method or function block takes arrays with any limits"
                context.say(spec, "ARRAY[*] is no type of a variable here", "limits such as ARRAY[1..10]", hint)
                return UNKNOWN
            case tree.PointerSpec():
                to = self.resolve(spec.to, context)
                return UNKNOWN if to is UNKNOWN else PointerType(to, spec.is_reference)
            case tree.EnumSpec():
                name = f"${len(self._project.names)}"
                return self._enumeration("", spec, context, name)
            case tree.StructSpec():
                return self._structure("", spec, context)

    def _named(self, name: str, spec: tree.NamedType, context: Context) -> Type:
        declared = self._project.types.get(name)
        if declared is not None:
            if (
                isinstance(declared, Elementary)
                and declared in SHORT_OF_LONG
                and not self._project.dialect.has_long_types
            ):
                return self._no(
                    context, spec, f"{declared} is not supported by the controller", f"use {SHORT_OF_LONG[declared]}"
                )
            return declared
        if name in self._busy:
            return self._no(context, spec, f"the type {spec.name} is defined by itself")
        if name in self._declared:
            declaration, home = self._declared[name]
            self._busy.add(name)
            if isinstance(declaration.type, tree.StructSpec):
                kind: Type = self._structure(declaration.name, declaration.type, home, name)
            else:
                kind = self.resolve(declaration.type, home)
            self._busy.discard(name)
            self._project.types[name] = kind
            return kind
        return self._pou(name, spec, context)

    def _pou(self, name: str, spec: tree.NamedType, context: Context) -> Type:
        pou = self._project.pous.get(name)
        if pou is not None and pou.type is not None and pou.kind.has_instances:
            return pou.type
        if pou is not None:
            kind = pou.kind.value
            hint = "call it by its name" if pou.kind is tree.PouKind.FUNCTION else "a program has no instances (PD-356)"
            return self._no(context, spec, f"{spec.name} is {a(kind)}, not a type", hint)
        if name in self._project.interfaces:
            return InterfaceType(self._project.facades[name].type or UNKNOWN)
        library, _, plain = spec.name.rpartition(".")
        if library and library.casefold() not in self._project.lists and self._is_known(self._key(plain)):
            return self._named(self._key(plain), tree.NamedType(plain, position=spec.position), context)
        blocks = [known for known, known_pou in self._project.pous.items() if known_pou.type is not None]
        meant = _OF_OTHER_LANGUAGES.get(name)
        if meant is not None:
            return self._no_type(context, spec, f"the type is called {meant}")
        hint = self._project.reports.closest(spec.name, [*self._project.types, *self._declared, *blocks])
        return self._no_type(context, spec, hint)

    def _is_known(self, name: str) -> bool:
        project = self._project
        return any(name in known for known in (project.types, self._declared, project.pous, project.interfaces))

    def _no_type(self, context: Context, spec: tree.NamedType, hint: str) -> Type:
        what, expected = f"the type {spec.name} is not declared", "" if hint else "a type"
        context.say(spec, what, expected, hint, Code.NO_TYPE, spec.name.rpartition(".")[2])
        return UNKNOWN

    def _no(self, context: Context, node: tree.Node, what: str, hint: str = "") -> Type:
        context.say(node, what, "" if hint else "a type", hint)
        return UNKNOWN

    def _string(self, spec: tree.StringSpec, context: Context) -> Type:
        if spec.length is None:
            return StringType(is_wide=spec.is_wide)
        length = Expressions(context).constant_integer(spec.length)
        if length is None:
            return UNKNOWN
        dialect = context.project.dialect
        most = LONGEST_DOCUMENT if dialect.has_documents else dialect.longest_string
        least = 0 if dialect.has_empty_strings else 1
        if not least <= length <= most:
            name = StringType(is_wide=spec.is_wide).name
            context.say(spec.length, f"a {name} of {length} characters", f"{least} to {most} characters")
            return UNKNOWN
        return StringType(length, spec.is_wide)

    def _subrange(self, spec: tree.SubrangeSpec, context: Context) -> Type:
        base = self.resolve(spec.base, context)
        if base is UNKNOWN:
            return UNKNOWN
        if not isinstance(base, Elementary) or not base.is_integer:
            return self._no(context, spec.base, f"{base} cannot have a subrange", "write an integer type")
        expressions = Expressions(context)
        low, high = expressions.constant_as(spec.low, base), expressions.constant_as(spec.high, base)
        if low is None or high is None:
            return UNKNOWN
        if int(low.value) > int(high.value):
            return self._no(
                context, spec.low, f"the subrange {low.value}..{high.value} is empty", "write the lower limit first"
            )
        return SubrangeType(base, int(low.value), int(high.value), context.project.dialect.opens_subranges)

    def _array(self, spec: tree.ArraySpec, context: Context) -> Type:
        most = context.project.dialect.array_dimensions
        if len(spec.dimensions) > most:
            context.say(spec, f"an array of {len(spec.dimensions)} dimensions", f"1 to {most} dimensions (PD-361)")
            return UNKNOWN
        expressions = Expressions(context)
        element = self.resolve(spec.element, context)
        limits = [
            (part, expressions.constant_integer(part.low), expressions.constant_integer(part.high))
            for part in spec.dimensions
        ]
        for part, low, high in reversed(limits):
            if low is None or high is None or element is UNKNOWN:
                return UNKNOWN
            if low > high + self._project.dialect.has_empty_arrays:
                return self._no(context, part, f"the array {low}..{high} is empty", "write the lower limit first")
            element = ArrayType(low, high, element)
        return element

    def _structure(self, title: str, spec: tree.StructSpec, context: Context, name: str = "") -> Type:
        """Make the structure first and its fields afterwards, because a field may point to the structure itself."""
        spec, above = self._extended(spec, context)
        kind = StructType(title, is_union=spec.is_union, above=above)
        if name:
            self._project.types[name] = kind
        self.structures.append((kind, spec, context))
        self._project.unfinished.add(kind)
        for part in spec.fields:
            if part.edge:
                context.say(part, f"{part.name} has {part.edge}", "it in VAR_INPUT of a function block or program")
            if part.location is not None and self._project.dialect.allows_open_addresses:
                hint = f"the address of {part.name} in a structure is left out"
                context.note(part, hint, "link a variable to the address, and copy it in the program")
            elif part.location is not None:
                context.say(part, f"{part.name} in a structure has an address", "no AT in a structure (PD-360)")
            if self._key(part.name) in kind.fields:
                context.say(part, f"{part.name} is declared twice in {title or 'the structure'}", "another name")
                continue
            field_type = self.resolve(part.type, context)
            block = block_of(field_type)
            if spec.is_union and block is not None:
                context.say(part, f"the instance {part.name} in a UNION", "data without function blocks")
            elif block is not None and self._project.is_abstract(block):
                context.say(part, f"{part.name} is an instance of {block.name}, which is ABSTRACT", "another type")
            is_bit = isinstance(part.type, tree.NamedType) and self._key(part.type.name) == BIT
            bit = 0 if is_bit and self._project.dialect.has_bits else -1
            kind.fields[self._key(part.name)] = Field(part.name, field_type, comment=comment_of(part), bit=bit)
        self._project.unfinished.discard(kind)
        return kind

    def _extended(self, spec: tree.StructSpec, context: Context) -> tuple[tree.StructSpec, tuple[str, ...]]:
        """Return a structure with the components of those that it extends in front of its own, and their names."""
        fields, seen = spec.fields, dict[str, None]()
        extends = spec.extends
        while extends:
            plain = self._key(extends.rpartition(".")[2])
            declaration, _ = self._declared.get(plain, (None, None))
            above = declaration.type if declaration is not None else None
            if declaration is None:
                hint = self._project.reports.closest(extends, self._declared)
                what = "union" if spec.is_union else "structure"
                context.say(spec, f"the {what} {extends} is not declared", f"the name of another {what}", hint)
                break
            if not isinstance(above, tree.StructSpec) or above.is_union is not spec.is_union or plain in seen:
                what = "union" if spec.is_union else "structure"
                context.say(spec, f"{extends} is no {what} that can be extended", f"the name of another {what}")
                break
            if len(seen) == DEEPEST:
                context.say(spec, f"the structure extends more than {DEEPEST} others", f"at most {DEEPEST} levels")
                return tree.StructSpec(spec.fields, spec.is_union, position=spec.position), ()
            seen[plain] = None
            fields, extends = (*above.fields, *fields), above.extends
        return tree.StructSpec(fields, spec.is_union, position=spec.position), tuple(seen)

    # ---- enumerations

    def _enumeration(
        self, title: str, spec: tree.EnumSpec, context: Context, name: str, *, is_qualified: bool = False
    ) -> EnumType:
        """Make the names of the values known in the whole project (PD-359); their numbers follow at the first use."""
        project = self._project
        base = Elementary[spec.base] if spec.base else Elementary.INT
        dialect = project.dialect
        kind = EnumType(title, {}, base, not dialect.allows_numbers_between, dialect.opens_enumerations)
        project.types[name] = kind
        project.enumerations[kind] = partial(self._number, kind, spec, context)
        for value in spec.values:
            known = self._key(value.name)
            if is_qualified:
                continue
            if title and project.dialect.repeats_enumeration_values and isinstance(project.names.get(known), Pou):
                project.enumerated.setdefault(known, []).append(kind)
                continue
            if known in project.names and known not in project.library_names:
                if project.dialect.repeats_enumeration_values:
                    continue  # its type is in front of it, or is that of what it is given to
                context.say(
                    value,
                    f"the name {value.name} is used already, {project.where(known)}",
                    "names of enumeration values occur once in the project (PD-359)",
                )
                continue
            if known in project.library_names:
                project.replace(known)
            pending = Pending(partial(self._value, kind, known))
            self._pending.setdefault(kind, {})[known] = pending
            project.declare(known, pending, context.file, value.position)
            if title and project.dialect.repeats_enumeration_values:
                project.enumerated.setdefault(known, []).append(kind)
        return kind

    def _value(self, kind: EnumType, wanted: str) -> Constant:
        """Return the first value that is asked for; with it, all others become known."""
        values = self._project.values_of(kind)
        return Constant(next((number for name, number in values.items() if self._key(name) == wanted), 0), kind)

    def _given_number(self, value: tree.Expression, base: Elementary, context: Context) -> int | None:
        """Return the number of a value of an enumeration; None after a message."""
        written = value.value if isinstance(value, tree.Literal) and type(value.value) is int else 0
        if base.low < 0 and base.high < written < 1 << base.bits and self._project.dialect.wraps_enumeration_values:
            return written - (1 << base.bits)
        found = Expressions(context).constant_as(value, base)
        return int(found.value) if found is not None else None

    def _number(self, kind: EnumType, spec: tree.EnumSpec, context: Context) -> None:
        """Work out the numbers; a value may stand on those in front of it, and one behind it is not known there."""
        number, base, names, pending = -1, kind.base, self._project.names, self._pending.pop(kind, {})
        for waiting in pending.values():
            waiting.is_busy = True
        for value in spec.values:
            given = self._given_number(value.value, base, context) if value.value is not None else None
            previous, number = number, given if given is not None else number + 1
            if kind.values and number <= previous and not self._project.dialect.repeats_enumeration_values:
                context.say(value, f"{value.name} is {number} after {previous}", "ascending numbers (PD-359)")
            elif number > base.high:
                context.say(value, f"{value.name} is {number}", f"at most {base.high}, as for {a(base)}")
            kind.values[value.name] = number
            known = self._key(value.name)
            if known in pending and names.get(known) is pending[known]:
                names[known] = Constant(number, kind)

    def finish_enumerations(self) -> None:
        """Work out all numbers, so that mistakes in unused enumerations are found too."""
        for name in [name for name, entity in self._project.names.items() if type(entity) is Pending]:
            self._project.find(name)
        for kind in list(self._project.enumerations):
            self._project.values_of(kind)


def block_of(kind: Type) -> Pou | None:
    """Return the function block if a variable of this type contains an instance; None otherwise."""
    while isinstance(kind, ArrayType | OpenArrayType):
        kind = kind.element
    return getattr(kind, "pou", None)


def comment_of(node: tree.Variable) -> str:
    """The comment of a declaration without its brackets."""
    shown = node.remark or (node.comments[-1] if node.comments else "")
    text = shown.removeprefix("(*").removesuffix("*)").removeprefix("//")
    return text.removeprefix("/*").removesuffix("*/").strip()
