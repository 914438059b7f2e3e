"""Configuration objects as types and values of IEC programs: MC_4, D_IN, D_OUT, LOGIC_ENC and so on.

Source: PacDrive manual 3055-3074 (digest PD-023 to PD-025): the types are declared automatically from the
configuration.  Objects of one type may have different parameters, for example the modules of a field bus; their type
has all of them, each with a number of its own.
"""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.types import ObjectParameter, ObjectType, StringType
from fieldrig_devices.max4.configuration.tree import OBJECT_STEP, Access, Object, ObjectTree, Parameter, Type

TYPES: Final[Mapping[Type, Elementary | StringType]] = {
    Type.BOOL: Elementary.BOOL,
    Type.INT: Elementary.INT,
    Type.UINT: Elementary.UINT,
    Type.DINT: Elementary.DINT,
    Type.UDINT: Elementary.UDINT,
    Type.LREAL: Elementary.LREAL,
    Type.STRING: StringType(),
}


class ObjectTypes:
    """The types of the objects in a tree, and its parameters by the addresses that programs compute for them."""

    def __init__(self, tree: ObjectTree) -> None:
        members: dict[str, dict[str, ObjectParameter]] = {}
        names: dict[str, str] = {}
        for node in tree.objects():
            key = node.type_name.casefold()
            names.setdefault(key, node.type_name)
            _extend(members.setdefault(key, {}), node)
        self.types = {key: ObjectType(names[key], tuple(own.values())) for key, own in members.items()}
        """Types by the name in small letters."""
        self.objects = {
            node.symbol.casefold(): ConfiguredObject(node.symbol, self._type(node), node.log_adr)
            for node in tree.objects()
            if node.symbol
        }
        """The objects that programs can name, by symbolic name in small letters."""
        self.parameters: dict[int, Parameter] = {}
        """Parameters by the address of their object plus their number in its type."""
        self.slow: dict[int, tuple[Object, Parameter]] = {}
        """The parameters that go through SERCOS, with their objects."""
        for node in tree.objects():
            numbers = members[node.type_name.casefold()]
            for parameter in node.parameters:
                address = node.log_adr + numbers[parameter.name.casefold()].number
                self.parameters.setdefault(address, parameter)
                if _is_slow(node, parameter):
                    self.slow[address] = node, parameter

    def _type(self, node: Object) -> ObjectType:
        return self.types[node.type_name.casefold()]


def _extend(members: dict[str, ObjectParameter], node: Object) -> None:
    """Add those parameters of an object that its type does not have yet."""
    for parameter in node.parameters:
        name = parameter.name.casefold()
        if name not in members:
            taken = {known.number for known in members.values()}
            number = parameter.address % OBJECT_STEP
            while number in taken:
                number += 1
            members[name] = ObjectParameter(
                parameter.name,
                number,
                TYPES[parameter.type],
                is_writable=parameter.is_writable,
                is_slow=_is_slow(node, parameter),
            )


def _is_slow(node: Object, parameter: Parameter) -> bool:
    """True if reading or writing holds the task up: parameters in the drive, and error quit (PD-028)."""
    return parameter.access is Access.SLOW or (node.type_name, parameter.name) == ("MC_4", "DiagQuit")
