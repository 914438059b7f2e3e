"""ANY: an input that takes a value of any type, as a description of the value.

Source: the public description of CODESYS V3 and TwinCAT 3.  Within the POU, the input is a structure with the class of
the type, the address of the value, and its size in bytes.  `__SYSTEM.TYPE_CLASS` numbers the classes, and
`__SYSTEM.AnyType` is the structure.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple, Self

from fieldrig_devices.iec.elementary import UNSIGNED, Elementary
from fieldrig_devices.iec.types import (
    ArrayType,
    BlockType,
    EnumType,
    Field,
    InterfaceType,
    OpenArrayType,
    PointerType,
    StringType,
    StructType,
    SubrangeType,
    Type,
    Value,
)

_E: Final = Elementary
CLASS_NAMES: Final = (
    "BOOL", "BIT", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT",
    "REAL", "LREAL", "STRING", "WSTRING", "TIME", "DATE", "DATEANDTIME", "TIMEOFDAY", "POINTER", "REFERENCE",
    "SUBRANGE", "ENUM", "ARRAY", "PARAMS", "USERDEF", "NONE", "ANY", "ANYBIT", "ANYDATE", "ANYINT", "ANYNUM", "ANYREAL",
    "LAZY", "LTIME", "BITCONST", "INTERFACE", "XWORD", "XINT", "XSTRING", "VARLENARRAY", "ANYSTRING", "VECTOR",
    "LDATE", "LDATEANDTIME", "LTIMEOFDAY",
)  # fmt: skip
"""The classes in the order of their numbers, without TYPE_ in front."""
_OTHER_NAMES: Final = {
    _E.DT: "DATEANDTIME",
    _E.TOD: "TIMEOFDAY",
    _E.LDT: "LDATEANDTIME",
    _E.LTOD: "LTIMEOFDAY",
    _E.SIGNED_TIME: "TIME",
    _E.UNSIGNED_LTIME: "LTIME",
    _E.UNSIGNED_LDATE: "LDATE",
    _E.UNSIGNED_LDT: "LDATEANDTIME",
}
CLASSES: Final = {
    kind: CLASS_NAMES.index(_OTHER_NAMES.get(kind, kind.name))
    for kind in Elementary
    if _OTHER_NAMES.get(kind, kind.name) in CLASS_NAMES
}
"""The classes of the elementary types that have one."""
ELEMENTARY: Final = {number: kind for kind, number in CLASSES.items() if kind not in (_E.SIGNED_TIME, *UNSIGNED)}
STRING: Final = CLASS_NAMES.index("STRING")
WSTRING: Final = CLASS_NAMES.index("WSTRING")
NONE: Final = CLASS_NAMES.index("NONE")

NAMES: Final = frozenset(
    {"any", "any_num", "any_int", "any_real", "any_bit", "any_string", "any_date", "any_elementary", "anytype"}
)
"""The names of the type, in small letters.  What a narrower one leaves out is taken too."""
DESCRIPTION: Final = StructType(
    "ANY",
    {
        "typeclass": Field("TypeClass", Elementary.INT, 0),
        "pvalue": Field("pValue", PointerType(Elementary.BYTE), 2),
        "disize": Field("diSize", Elementary.DINT, 6),
    },
    size=10,
)
"""The structure behind an input of type ANY.  All projects share it, so it is laid out as each of them would do it."""


def class_of(kind: Type) -> int:
    """Return the number of the class of a type."""
    match kind:
        case Elementary():
            return CLASSES.get(kind, NONE)
        case StringType(is_wide=is_wide):
            return WSTRING if is_wide else STRING
        case InterfaceType():
            name = "INTERFACE"
        case PointerType(is_reference=is_reference):
            name = "REFERENCE" if is_reference else "POINTER"
        case SubrangeType():
            name = "SUBRANGE"
        case EnumType():
            name = "ENUM"
        case ArrayType() | OpenArrayType():
            name = "ARRAY"
        case StructType() | BlockType():
            name = "USERDEF"
        case _:
            name = "NONE"
    return CLASS_NAMES.index(name)


class Described(NamedTuple):
    """The value behind an ANY, for native functions."""

    type_class: int
    address: int
    size: int

    @classmethod
    def of(cls, cells: Sequence[Value]) -> Self:
        """Return the description in the cells of an input."""
        return cls(*(int(cells[field.offset]) for field in DESCRIPTION.fields.values()))

    @property
    def class_name(self) -> str:
        return CLASS_NAMES[self.type_class] if 0 <= self.type_class < len(CLASS_NAMES) else str(self.type_class)
