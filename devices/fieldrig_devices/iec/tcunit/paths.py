"""The paths of instances by their addresses, as TcUnit names a suite: `PRG_TEST.Suite`, `GVL.suites[2]`.

A variable with the attribute 'instance-path' has the path of its instance, as TwinCAT gives it.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Final

from fieldrig_devices.iec.layout import members
from fieldrig_devices.iec.program import Program
from fieldrig_devices.iec.tcunit import library
from fieldrig_devices.iec.types import ArrayType, BlockType, StringType, StructType, Type
from fieldrig_devices.languages.source_file import SourceFile

_TOLD: Final = re.compile(r"\{\s*attribute\s+'instance-path'[^}]*\}\s*(?:\{[^}]*\}\s*)*(\w+)\s*:", re.IGNORECASE)


def suites(program: Program, lists: Mapping[str, str]) -> dict[int, tuple[str, str]]:
    """Return the paths of all instances of suites by address, each with the name of its block.

    `lists` has the names of the lists of global variables by those of their variables, in small letters.
    """
    return {address: (path, kind.name) for path, address, kind in _blocks(program, lists) if _is_suite(kind)}


def told(files: Iterable[SourceFile]) -> set[tuple[str, str]]:
    """Return the variables with the attribute 'instance-path': the names of their files, and their own."""
    return {(file.name, found[1].casefold()) for file in files for found in _TOLD.finditer(file.text)}


def head(project: str) -> str:
    """Return what TwinCAT has in front of the name of a program: the instance of the project, and the project."""
    return f"{project} Instance.{project}."


def texts(
    program: Program, lists: Mapping[str, str], wanted: Collection[tuple[str, str]], before: str
) -> Iterator[tuple[int, str]]:
    """Return the addresses of these variables, each with the path of its instance, cut to what it can have.

    `before` is what is in front of all paths.
    """
    if not wanted:
        return
    for path, address, kind in _blocks(program, lists):
        for member in members(kind):
            if isinstance(member.type, StringType) and (member.file, member.name.casefold()) in wanted:
                yield address + member.offset, f"{before}{path}"[: member.type.length]


def _blocks(program: Program, lists: Mapping[str, str]) -> Iterator[tuple[str, int, BlockType]]:
    for name, variable in program.globals.items():
        if variable.location is None:
            listed = lists.get(name)
            path = f"{listed}.{variable.name}" if listed else variable.name
            yield from _below(path, variable.type, variable.offset)


def _below(path: str, kind: Type, address: int) -> Iterator[tuple[str, int, BlockType]]:
    if not _may_have_blocks(kind):
        return
    match kind:
        case ArrayType():
            for number in range(kind.count):
                at = address + number * kind.element.size
                yield from _below(f"{path}[{kind.low + number}]", kind.element, at)
        case StructType():
            for field in kind.fields.values():
                yield from _below(f"{path}.{field.name}", field.type, address + field.offset)
        case BlockType():
            yield path, address, kind
            for member in members(kind):
                if not member.is_reference:
                    yield from _below(f"{path}.{member.name}", member.type, address + member.offset)


def _may_have_blocks(kind: Type) -> bool:
    while isinstance(kind, ArrayType):
        kind = kind.element
    return isinstance(kind, StructType | BlockType)


def _is_suite(kind: BlockType) -> bool:
    mark = kind.pou.variables.get(library.MARK.casefold()) if kind.pou is not None else None
    return mark is not None and mark.file == library.FILE
