"""What calls the blocks and functions under test: a hidden block for each, with variables for their arguments."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final
from zlib import crc32

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.testing.extension import CaseExtension, begin_unit

BLOCK: Final = "tested"
"""The instance under test."""
RESULT: Final = "result of function"
_FILE: Final = "fieldrig.program"
_ARGUMENTS: Final = (tree.Section.INPUT, tree.Section.IN_OUT, tree.Section.OUTPUT)


@dataclass(frozen=True, slots=True)
class Wrapper:
    """One call under test; `number` tells several instances of one block apart."""

    name: str
    number: int

    @property
    def pou(self) -> str:
        # Names count to their 32nd character in EPAS-4 (PD-350), so that of the block would not tell them apart.
        return f"BENCH {crc32(self.name.casefold().encode()):08x} {self.number}"

    @property
    def instance(self) -> str:
        return f"{self.pou} instance"


class BenchExtension(CaseExtension):
    """Adds the wrappers to the program."""

    def __init__(self, wrappers: Sequence[Wrapper], mocked: Sequence[str]) -> None:
        super().__init__(mocked)
        self._wrappers = wrappers

    def units(self, units: Sequence[tree.Unit]) -> Sequence[tree.Unit]:
        known = {one.name.casefold(): one for unit in units for one in unit.declarations if isinstance(one, tree.Pou)}
        made: list[tree.Declaration] = []
        for wrapper in self._wrappers:
            made += _declarations(wrapper, known)
        plain = [replace(unit, tests=()) for unit in units]  # tests of the same file do not matter here
        self._files.add(_FILE)
        return [*plain, tree.Unit(_FILE, tuple(made)), begin_unit()]


def _declarations(wrapper: Wrapper, known: Mapping[str, tree.Pou]) -> list[tree.Declaration]:
    pou = known.get(wrapper.name.casefold())
    is_function = pou is not None and pou.kind is tree.PouKind.FUNCTION
    line = _line_of(pou, known)
    variables: list[tree.Variable] = []
    arguments: list[tree.Argument] = []
    for block in (block for one in line for block in one.blocks if block.section in _ARGUMENTS):
        is_own = is_function or block.section is tree.Section.IN_OUT
        for variable in block.variables if is_own else ():
            if variable.name.casefold() in {known.name.casefold() for known in variables}:
                continue
            is_output = block.section is tree.Section.OUTPUT
            variables.append(replace(variable, location=None, edge="", narrow=None))
            arguments.append(tree.Argument(tree.Name(variable.name), variable.name, is_output=is_output))
    body: tree.AnyStatement
    if is_function and pou is not None:
        call = tree.Call(tree.Name(pou.name), tuple(arguments))
        body = tree.CallStatement(call)
        if pou.result is not None:
            variables.append(tree.Variable(RESULT, pou.result))
            body = tree.Assign(tree.Name(RESULT), call)
    else:
        variables.append(tree.Variable(BLOCK, tree.NamedType(wrapper.name)))
        body = tree.CallStatement(tree.Call(tree.Name(BLOCK), tuple(arguments)))
    blocks = (tree.Variables(tree.Section.LOCAL, tuple(variables)),)
    made = tree.Pou(tree.PouKind.FUNCTION_BLOCK, wrapper.pou, None, blocks, tree.StBody((body,)))
    instance = tree.Variable(wrapper.instance, tree.NamedType(wrapper.pou))
    return [made, tree.Variables(tree.Section.GLOBAL, (instance,))]


def _line_of(pou: tree.Pou | None, known: Mapping[str, tree.Pou]) -> list[tree.Pou]:
    """Return a block and those that it extends, as far as the project has them."""
    line: list[tree.Pou] = []
    while pou is not None and pou not in line:
        line.append(pou)
        pou = known.get(pou.extends.casefold()) if pou.extends else None
    return line
