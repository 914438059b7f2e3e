"""Function blocks with VAR_GENERIC CONSTANT: one block for each list of constants, `stack : Stack<10>;`.

Each use gets a copy of the block whose generic constants are plain ones, under a name such as `Stack<10>`, so that
nothing behind this has to know of them (CODESYS V3, "Generic Constant Variables").
"""

from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.printer.expressions import expression_text
from fieldrig_devices.languages.mistakes import Mistake

MOST_COPIES: Final = 1_000
"""Copies of blocks in a project; a block that needs another one of itself with each copy would never end."""

Constants = Mapping[str, tree.Expression]
"""The values of the constants of a block, by the form in which names are compared."""


def expanded(units: Sequence[tree.Unit], dialect: Dialect) -> tuple[Sequence[tree.Unit], list[Mistake]]:
    """Return the units with a block for each list of constants, and mistakes in these lists."""
    if not dialect.has_generic_constants:
        return units, []
    blocks = {
        dialect.key(one.name): _Generic(one, unit.file)
        for unit in units
        for one in unit.declarations
        if isinstance(one, tree.Pou) and _parameters(one)
    }
    if not blocks and not any(_has_uses(one) for unit in units for one in unit.declarations):
        return units, []
    expansion = _Expansion(blocks, dialect)
    made = [replace(unit, declarations=tuple(expansion.declarations(unit))) for unit in units]
    copies: dict[str, list[tree.Declaration]] = {}
    for file, pou in expansion.copies():
        copies.setdefault(file, []).append(pou)
    made = [
        replace(unit, declarations=(*copies.pop(unit.file, ()), *unit.declarations)) if unit.file in copies else unit
        for unit in made
    ]
    return made, expansion.mistakes


@dataclass(slots=True)
class _Generic:
    pou: tree.Pou
    file: str


def _parameters(pou: tree.Pou) -> list[tree.Variable]:
    if pou.kind is not tree.PouKind.FUNCTION_BLOCK:
        return []
    return [one for block in pou.blocks if block.section is tree.Section.GENERIC for one in block.variables]


def _has_uses(declaration: tree.Declaration) -> bool:
    if isinstance(declaration, tree.Pou) and declaration.extends_with:
        return True
    return any(isinstance(part, tree.NamedType) and part.parameters for part in tree.walk(declaration))


@dataclass(slots=True)
class _Expansion:
    blocks: dict[str, _Generic]
    dialect: Dialect
    mistakes: list[Mistake] = field(default_factory=list)
    _waiting: list[tuple[str, tree.Pou]] = field(default_factory=list)
    _made: set[str] = field(default_factory=set)

    def declarations(self, unit: tree.Unit) -> Iterator[tree.Declaration]:
        """Yield the declarations of a file that are no generic blocks, with the names of the copies that they use."""
        for one in unit.declarations:
            parameters = _parameters(one) if isinstance(one, tree.Pou) else []
            if isinstance(one, tree.Pou) and parameters:
                if all(parameter.initial is not None for parameter in parameters):
                    yield self._named(_with_constants(one, []), unit.file)
            elif _has_uses(one):
                yield self._named(one, unit.file)
            else:
                yield one

    def copies(self) -> Iterator[tuple[str, tree.Pou]]:
        """Yield the copies with their files, those that other copies need among them."""
        while self._waiting:
            file, pou = self._waiting.pop()
            self._name(pou, file)
            yield file, pou

    def _named(self, declaration: tree.Declaration, file: str) -> tree.Declaration:
        """Return a declaration with the names of the copies that it uses."""
        declaration = deepcopy(declaration)
        self._name(declaration, file)
        return declaration

    def _name(self, declaration: tree.Declaration, file: str) -> None:
        constants = dict(self._constants(declaration))
        if isinstance(declaration, tree.Pou) and declaration.extends_with:
            at = tree.NamedType(declaration.extends, position=declaration.position)
            declaration.extends = self._copy(at, declaration.extends_with, constants, file)
            declaration.extends_with = ()
        for part in tree.walk(declaration):
            if isinstance(part, tree.NamedType) and part.parameters:
                part.name, part.parameters = self._copy(part, part.parameters, constants, file), ()

    def _constants(self, declaration: tree.Declaration) -> Iterator[tuple[str, tree.Expression]]:
        for block in declaration.blocks if isinstance(declaration, tree.Pou) else ():
            for one in block.variables if block.is_constant else ():
                if isinstance(one.initial, tree.Literal | tree.Name | tree.Member | tree.Unary | tree.Binary):
                    yield self.dialect.key(one.name), one.initial

    def _copy(self, at: tree.NamedType, given: Sequence[tree.Expression], constants: Constants, file: str) -> str:
        """Return the name of a block with these constants, which is made if it has not been."""
        name = at.name.rpartition(".")[2]
        generic = self.blocks.get(self.dialect.key(name))
        parameters = [] if generic is None else _parameters(generic.pou)
        if generic is None or len(given) > len(parameters):
            most = len(parameters)
            what = f"{at.name} has {most or 'no'} generic constant{'s' * (most != 1)}"
            expected = f"at most {most} between < and >" if most else f"{at.name} without < and >"
            self.mistakes.append(Mistake(*at.position, what, expected, file=file))
            return at.name
        values = [_value(one, constants, self.dialect) for one in given]
        own = f"{generic.pou.name}<{','.join(_short_text(one) for one in values)}>"
        if self.dialect.key(own) not in self._made:
            self._made.add(self.dialect.key(own))
            if len(self._made) > MOST_COPIES:
                what = f"{at.name} needs another copy of a generic block with each copy"
                self.mistakes.append(Mistake(*at.position, what, f"at most {MOST_COPIES} of them", file=file))
                return at.name
            copy = _with_constants(generic.pou, values)
            copy.name = own
            self._waiting.append((generic.file, copy))
        return own


def _with_constants(pou: tree.Pou, values: Sequence[tree.Expression]) -> tree.Pou:
    """Return a copy of a generic block with these values for its constants, and start values for the others."""
    copy = deepcopy(pou)
    given = iter(values)
    for block in copy.blocks:
        if block.section is tree.Section.GENERIC:
            block.section, block.is_constant = tree.Section.LOCAL, True
            for one in block.variables:
                one.initial = deepcopy(next(given, one.initial))
    return copy


def _value(node: tree.Expression, constants: Constants, dialect: Dialect) -> tree.Expression:
    """Return the value of a constant, as a number if it is known without the rest of the project."""
    match node:
        case tree.Name(text) if dialect.key(text) in constants:
            others = {name: value for name, value in constants.items() if name != dialect.key(text)}
            return _value(constants[dialect.key(text)], others, dialect)
        case tree.Unary(operator, operand):
            return _number(replace(node, operand=_value(operand, constants, dialect)), operator)
        case tree.Binary(operator, left, right):
            sides = _value(left, constants, dialect), _value(right, constants, dialect)
            return _number(replace(node, left=sides[0], right=sides[1]), operator)
    return node


def _number(node: tree.Unary | tree.Binary, operator: str) -> tree.Expression:
    """Return the result of simple arithmetic with integers; what is no such arithmetic stays as it is."""
    parts = [node.operand] if isinstance(node, tree.Unary) else [node.left, node.right]
    numbers = [
        int(one.value) for one in parts if isinstance(one, tree.Literal) and one.kind is tree.LiteralKind.INTEGER
    ]
    if len(numbers) < len(parts):
        return node
    match operator, numbers:
        case "-", [number]:
            result = -number
        case "+", [first, second]:
            result = first + second
        case "-", [first, second]:
            result = first - second
        case "*", [first, second]:
            result = first * second
        case _:
            return node
    return tree.Literal(tree.LiteralKind.INTEGER, result, str(result), position=node.position)


def _short_text(node: tree.Expression) -> str:
    """Return the text of a constant in the name of a block, in which a point would be that behind a library."""
    if isinstance(node, tree.Literal) and node.kind is tree.LiteralKind.INTEGER:
        return str(node.value)
    return expression_text(node).replace(".", "_")
