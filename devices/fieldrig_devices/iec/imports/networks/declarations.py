"""The declarations around a body that is drawn: in its own file, in other files of the project, and in libraries."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cache

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.library.sources import parsed, sources

BOOL = tree.NamedType("BOOL")


@cache
def library_pous(dialect: Dialect) -> Mapping[str, tree.Pou]:
    """Return the functions and blocks of the libraries of the dialect, by their names in small letters."""
    units = [parsed(text, name, dialect) for name, text in sources(dialect.name)]
    pous = (node for unit in units for node in unit.declarations if isinstance(node, tree.Pou))
    return {pou.name.casefold(): pou for pou in pous}


class Declarations:
    """The declarations that a POU sees."""

    def __init__(self, dialect: Dialect) -> None:
        self.dialect = dialect
        self.variables: dict[str, tree.TypeSpec] = {}
        self.lists: dict[str, dict[str, tree.TypeSpec]] = {}
        """Global variables by the names of their lists: `GVL.x`."""
        self.pous: dict[str, tree.Pou] = {}
        self.types: dict[str, tree.TypeSpec] = {}
        self._values: dict[str, tree.TypeSpec] = {}
        """Enumerations by the names of their values."""

    def take(self, declarations: Iterable[tree.Declaration]) -> None:
        """Take what these declare; it hides what was declared before under the same names."""
        for declaration in declarations:
            match declaration:
                case tree.TypeDeclaration(name, of):
                    self._take_type(name, of)
                case tree.Variables() if declaration.section is tree.Section.GLOBAL:
                    self._take_variables(declaration)
                case tree.Configuration():
                    self._take_configuration(declaration)
                case tree.Pou(name=name):
                    self.pous[name.casefold()] = declaration

    def _take_type(self, name: str, node: tree.TypeSpec) -> None:
        self.types[name.casefold()] = node
        if isinstance(node, tree.EnumSpec):
            self._values.update((value.name.casefold(), tree.NamedType(name)) for value in node.values)

    def _take_variables(self, block: tree.Variables) -> None:
        types = {variable.name.casefold(): variable.type for variable in block.variables}
        self.variables.update(types)
        if block.name:
            self.lists.setdefault(block.name.casefold(), {}).update(types)

    def _take_configuration(self, configuration: tree.Configuration) -> None:
        for part in (configuration, *configuration.resources):
            for block in part.blocks:
                self._take_variables(block)

    # ---- expressions

    def declared(self, expression: tree.Expression | None) -> tree.TypeSpec | None:
        """Return the type that a declaration gives to a variable, a part of it, or a function."""
        match expression:
            case tree.Literal(type_name=name) if name:
                return tree.NamedType(name)
            case tree.Name(text):
                return self._named(text.casefold())
            case tree.Member(tree.Name(text), name) if text.casefold() not in self.variables:
                return self._qualified(text.casefold(), name)
            case tree.Member(of, name):
                return self._member(self.declared(of), name)
            case tree.Dereference(of):
                pointer = self.resolved(self.declared(of))
                return pointer.to if isinstance(pointer, tree.PointerSpec) else None
            case tree.Index(of, indices):
                return self._element(self.declared(of), len(indices))
            case tree.BitOf(size="") | tree.Direct(size="X" | ""):
                return BOOL
            case tree.Direct(size=size):
                return tree.NamedType({"B": "BYTE", "W": "WORD", "D": "DWORD", "L": "LWORD"}[size])
            case tree.Call(tree.Name(text)):
                return self.of_function(text)
            case tree.Call(tree.Member(of, name)):
                return self._method(self.declared(of), name)
        return None

    def _named(self, key: str) -> tree.TypeSpec | None:
        """Return the type of a variable, of a value of an enumeration, or of a program with its variables."""
        known = self.pous.get(key)
        is_program = known is not None and known.kind is tree.PouKind.PROGRAM
        program = tree.NamedType(known.name) if known is not None and is_program else None
        return self.variables.get(key) or self._values.get(key) or program

    def _qualified(self, key: str, name: str) -> tree.TypeSpec | None:
        """Return the type of `GVL.x`, `Color.RED` or `MAIN.x`."""
        if key in self.lists:
            return self.lists[key].get(name.casefold())
        of = self.types.get(key)
        return tree.NamedType(key) if isinstance(of, tree.EnumSpec) else self._member(self._named(key), name)

    # ---- POUs

    def pou(self, name: str) -> tree.Pou | None:
        key = name.casefold()
        return self.pous.get(key) or library_pous(self.dialect).get(key)

    def is_library_block(self, name: str) -> bool:
        return name.casefold() not in self.pous and name.casefold() in library_pous(self.dialect)

    def of_function(self, name: str) -> tree.TypeSpec | None:
        """Return the type of the result if it does not depend on the arguments."""
        known = self.pou(name)
        return known.result if known is not None else functions.result_of(name)

    def parameter(self, pou: str, pin: str) -> tree.TypeSpec | None:
        """The type of a pin or variable of a POU, of what it extends, or of a property."""
        key = pin.casefold()
        for known in self._lineage(pou):
            types = (v.type for block in known.blocks for v in block.variables if v.name.casefold() == key)
            if (of := next(types, None) or _result(known, key, "GET")) is not None:
                return of
        return None

    def _method(self, spec: tree.TypeSpec | None, name: str) -> tree.TypeSpec | None:
        """Return the type of the result of a method of a block."""
        resolved = self.resolved(spec)
        pous = self._lineage(resolved.name) if isinstance(resolved, tree.NamedType) else ()
        results = (_result(pou, name.casefold(), "") for pou in pous)
        return next((of for of in results if of is not None), None)

    def _lineage(self, name: str) -> Iterator[tree.Pou]:
        """Yield a POU and what it extends."""
        seen = set[str]()
        while name and name.casefold() not in seen:
            seen.add(name.casefold())
            known = self.pou(name)
            if known is None:
                return
            yield known
            name = known.extends

    def resolved(self, spec: tree.TypeSpec | None) -> tree.TypeSpec | None:
        """Return what the name of a type, or a reference, stands for."""
        seen = set[str]()
        while True:
            if isinstance(spec, tree.NamedType) and spec.name.casefold() in self.types and spec.name not in seen:
                seen.add(spec.name)
                spec = self.types[spec.name.casefold()]
            elif isinstance(spec, tree.PointerSpec) and spec.is_reference:
                spec = spec.to
            else:
                return spec

    def _member(self, spec: tree.TypeSpec | None, name: str) -> tree.TypeSpec | None:
        resolved = self.resolved(spec)
        if isinstance(resolved, tree.StructSpec):
            return next((f.type for f in resolved.fields if f.name.casefold() == name.casefold()), None)
        return self.parameter(resolved.name, name) if isinstance(resolved, tree.NamedType) else None

    def _element(self, spec: tree.TypeSpec | None, indices: int) -> tree.TypeSpec | None:
        resolved = self.resolved(spec)
        if not isinstance(resolved, tree.ArraySpec | tree.OpenArraySpec):
            return None
        count = len(resolved.dimensions) if isinstance(resolved, tree.ArraySpec) else resolved.count
        if indices < count:
            return None
        left = indices - count
        return self._element(resolved.element, left) if left else resolved.element


def _result(pou: tree.Pou, key: str, accessor: str) -> tree.TypeSpec | None:
    """Return the type of a method, or of a property by its accessor."""
    methods = (method for method in pou.methods if method.name.casefold() == key and method.accessor == accessor)
    return next((method.result for method in methods), None)
