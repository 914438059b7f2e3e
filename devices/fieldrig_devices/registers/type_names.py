"""The names that other tools and languages have for the types of registers, for the message about a wrong one."""

from typing import Any, Final

from pydantic import BeforeValidator

OTHER_NAMES: Final = {
    "bool": ("boolean", "bit", "coil", "flag"),
    "u8": ("uint8", "usint", "byte", "uchar", "unsigned8", "ui8"),
    "s8": ("int8", "sint", "char", "i8", "signed8", "integer8", "si8"),
    "u16": ("uint16", "uint", "word", "ushort", "unsigned", "unsigned16", "ui16", "enum16", "bitfield16", "acc16"),
    "s16": ("int16", "int", "short", "i16", "signed", "signed16", "integer", "integer16", "sint16", "si16", "sunssf"),
    "u32": ("uint32", "udint", "dword", "ulong", "unsigned32", "ui32", "enum32", "bitfield32", "acc32"),
    "s32": ("int32", "dint", "long", "i32", "signed32", "integer32", "sint32", "si32"),
    "u64": ("uint64", "ulint", "lword", "qword", "unsigned64", "ui64", "bitfield64", "acc64"),
    "s64": ("int64", "lint", "i64", "signed64", "integer64", "sint64", "si64"),
    "f32": ("float", "float32", "real", "real32", "single"),
    "f64": ("double", "float64", "lreal", "real64"),
    "bcd16": ("bcd", "bcd4", "word_bcd"),
    "bcd32": ("bcd8", "dword_bcd", "lbcd"),
    "string[n]": ("string", "str", "text", "ascii", "chars", "visible_string"),
}
"""The names in C, IEC 61131-3, CANopen, SunSpec, Modbus tools and historians, in lower case and without `_t`."""
_MEANT: Final = {other: name for name, others in OTHER_NAMES.items() for other in others}


def meant(text: str) -> str | None:
    """Return the type that another name stands for; None if it is no name that is known."""
    word = text.strip().casefold()
    return _MEANT.get(word.removesuffix("_t").replace("-", "_")) or (word if word in OTHER_NAMES else None)


def naming(*known: str) -> BeforeValidator:
    """Return a validator that refuses the other names with the one that is meant, if it is among those known."""

    def check(value: Any) -> Any:
        name = meant(value) if isinstance(value, str) and value not in known else None
        if name is None:
            return value
        if name in ("u8", "s8") and name not in known:  # a register has 16 bits
            name = name.replace("8", "16")
        if name in known:
            raise ValueError(f"{value!r} is no type here; did you mean {name}?")
        return value

    return BeforeValidator(check)
