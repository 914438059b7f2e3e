"""The paths of instances by their addresses, as TcUnit names a suite: `PRG_TEST.Suite`, `GVL.suites[2]`."""

from collections.abc import Iterator, Mapping

from fieldrig_devices.iec.layout import members
from fieldrig_devices.iec.program import Program
from fieldrig_devices.iec.tcunit import library
from fieldrig_devices.iec.types import ArrayType, BlockType, StructType, Type


def suites(program: Program, lists: Mapping[str, str]) -> dict[int, tuple[str, str]]:
    """Return the paths of all instances of suites by address, each with the name of its block.

    `lists` has the names of the lists of global variables by those of their variables, in small letters.
    """
    found: dict[int, tuple[str, str]] = {}
    for name, variable in program.globals.items():
        if variable.location is not None:
            continue
        listed = lists.get(name)
        path = f"{listed}.{variable.name}" if listed else variable.name
        for inside, address, block in _below(path, variable.type, variable.offset):
            found[address] = inside, block
    return found


def _below(path: str, kind: Type, address: int) -> Iterator[tuple[str, int, str]]:
    if not _may_have_suites(kind):
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
            if _is_suite(kind):
                yield path, address, kind.name
            for member in members(kind):
                if not member.is_reference:
                    yield from _below(f"{path}.{member.name}", member.type, address + member.offset)


def _may_have_suites(kind: Type) -> bool:
    while isinstance(kind, ArrayType):
        kind = kind.element
    return isinstance(kind, StructType | BlockType)


def _is_suite(kind: BlockType) -> bool:
    mark = kind.pou.variables.get(library.MARK.casefold()) if kind.pou is not None else None
    return mark is not None and mark.file == library.FILE
