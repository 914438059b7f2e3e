"""Conversions between all elementary types: T1_TO_T2, and what the checker inserts without a name in the source.

Source: PacDrive manual 2564 to 2745 (PD-L37 to PD-L44).  What the manual leaves open is as in CoDeSys V2.3 on x86:

    to a smaller integer    the high bytes are cut off, without saturation (PD-L39)
    REAL to an integer      rounded to the nearest, halves to the even neighbour (1.5 and 2.5 give 2), because that is
                            what the floating-point unit does; in CODESYS V3 and TwinCAT halves away from zero (2.5
                            gives 3, and -0.5 gives -1); then cut like an integer of 64 bits; infinity, "not a number"
                            and anything larger give 0.  ULINT and LWORD take numbers up to 2**64
    DWORD and REAL          by number; in edition 3 (table 24), DWORD and REAL, and LWORD and LREAL, keep their bits;
                            a BOOL from a bit string is its last bit there (table 27)
    times and dates         are the number behind them: ms, or seconds since 1970 [X10]; DT_TO_TOD and DT_TO_DATE take
                            the value apart, as the standard says; a TOD is brought into one day, a DATE to midnight
    times in nanoseconds    are the number behind them too, but keep their meaning where they become another time or
                            date: LTIME_TO_TIME gives ms; what is too small is cut off, what is too large wraps around
    characters              are their codes; what is no character of the other kind becomes a question mark
    STRING, WSTRING         see `texts.py`; a STRING becomes a WSTRING as it is, and a character of a WSTRING that a
                            STRING does not have becomes a question mark
"""

import struct
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Final

from fieldrig_devices.iec import characters, literal_texts
from fieldrig_devices.iec.elementary import ALIASES, LONG_ALIASES, LONGER, UNITS_NS, Elementary, Family, are_twins
from fieldrig_devices.iec.library import reals, texts
from fieldrig_devices.iec.library.integers import wrapped
from fieldrig_devices.iec.library.overload import REAL_NS, SIMPLE_NS, TEXT_NS, expand
from fieldrig_devices.iec.types import EnumType, PointerType, StringType, SubrangeType, Type, Value

Plain = Elementary | StringType

DAY_S: Final = 86_400
_MASK: Final = 2**32 - 1
_DAY_NS: Final = 86_400_000_000_000
_TEXTS: Final = (StringType(), StringType(is_wide=True))
_NAMES: Final[Mapping[str, Plain]] = {
    **Elementary.__members__,
    **ALIASES,
    **LONG_ALIASES,
    **{text.name: text for text in _TEXTS},
}


def pair(name: str) -> tuple[Plain, Plain] | None:
    """Return the two types of a name such as INT_TO_REAL; None for any other name."""
    before, _, after = name.upper().partition("_TO_")
    source, target = _NAMES.get(before), _NAMES.get(after)
    return (source, target) if source is not None and target is not None and source != target else None


def of_dialect(name: str, durations: Mapping[Elementary, Elementary]) -> str:
    """Return the name of a conversion with the TIME and LTIME of the dialect.

    For TIME_TO_DINT, for example, it is SIGNED_TIME_TO_DINT.
    """
    types = pair(name)
    if types is not None:
        source, target = (durations.get(kind, kind) if isinstance(kind, Elementary) else kind for kind in types)
        return name_of(source, target)
    front, mark, last = name.rpartition("TO_")
    kind = _NAMES.get(last)
    if front not in ("", "ANY_") or not mark or not isinstance(kind, Elementary):
        return name
    return f"{front}TO_{durations[kind].name}" if kind in durations else name


def named(name: str) -> Plain | None:
    """Return the type with this name in capitals, also TIME_OF_DAY and DATE_AND_TIME."""
    return _NAMES.get(name)


def name_of(source: Plain, target: Plain) -> str:
    return f"{source.name}_TO_{target.name}"


def rounded(value: float) -> int:
    """The nearest integer, halves to even; 0 if it does not fit 64 bits with a sign."""
    return round(value) if -(2.0**63) <= value < 2.0**63 else 0


def rounded_away(value: float) -> int:
    """The nearest integer, halves away from zero; 0 if it does not fit 64 bits with a sign."""
    return _nearest_away(value) if -(2.0**63) <= value < 2.0**63 else 0


def rounded_unsigned_away(value: float) -> int:
    """The nearest integer, halves away from zero, for a type with 64 bits and no sign."""
    return _nearest_away(value) if -(2.0**63) <= value < 2.0**64 else 0


def _nearest_away(value: float) -> int:
    whole = int(value)
    if abs(value - whole) < 0.5:
        return whole
    return whole + 1 if value > 0 else whole - 1


def truncated(value: float) -> int:
    """The integer part; 0 if it does not fit 64 bits with a sign."""
    return int(value) if -(2.0**63) <= value < 2.0**63 else 0


def rounded_unsigned(value: float) -> int:
    """The nearest integer for a type with 64 bits and no sign, which a negative number wraps around in."""
    return round(value) if -(2.0**63) <= value < 2.0**64 else 0


def truncated_unsigned(value: float) -> int:
    """The integer part for a type with 64 bits and no sign."""
    return int(value) if -(2.0**63) <= value < 2.0**64 else 0


def integer_of(python: str, wanted: Elementary, *, is_cut: bool = False) -> str:
    """Return the Python of the integer for a real number, rounded or cut off; it may still exceed the type."""
    name = "TRUNCATE" if is_cut else "ROUND"
    return f"{name}_UNSIGNED({python})" if wanted.high >= 2**63 else f"{name}({python})"


def real_of_bits(bits: int) -> float:
    """The REAL whose bits these are."""
    return float(struct.unpack("<f", struct.pack("<I", bits))[0])


def bits_of_real(value: float) -> int:
    return int(struct.unpack("<I", struct.pack("<f", value))[0])


def long_real_of_bits(bits: int) -> float:
    """The LREAL whose bits these are."""
    return float(struct.unpack("<d", struct.pack("<Q", bits))[0])


def bits_of_long_real(value: float) -> int:
    return int(struct.unpack("<Q", struct.pack("<d", value))[0])


def midnight(value_ns: int) -> int:
    """The midnight before a time in nanoseconds since 1970; the first one of an LDATE before that."""
    return max(value_ns // _DAY_NS * _DAY_NS, Elementary.LDATE.low)


def whole_units(value: int, unit: int) -> int:
    """The units in a duration; what is left of a negative one is cut off too, as in constants and quotients."""
    return value // unit if value >= 0 else -(-value // unit)


def shortened(text: str, length: int) -> str:
    return text[:length]


FUNCTIONS: Final[Mapping[str, Callable[..., Value]]] = {
    "ROUND": rounded,
    "TRUNCATE": truncated,
    "WHOLE_UNITS": whole_units,
    "ROUND_UNSIGNED": rounded_unsigned,
    "ROUND_AWAY": rounded_away,
    "ROUND_UNSIGNED_AWAY": rounded_unsigned_away,
    "TRUNCATE_UNSIGNED": truncated_unsigned,
    "REAL_OF_BITS": real_of_bits,
    "BITS_OF_REAL": bits_of_real,
    "LONG_REAL_OF_BITS": long_real_of_bits,
    "BITS_OF_LONG_REAL": bits_of_long_real,
    "SINGLE": reals.single,
    "FLOAT": float,
    "SHORTEN": shortened,
    "MIDNIGHT": midnight,
    "NARROW": characters.narrowed,
    "NARROW_CODE": characters.narrowed_code,
    "DT_TEXT_OF_TODAY": texts.todays_dt_text,
    "TIME_OF_TEXT_OF_TODAY": texts.todays_time,
    "TIME_TEXT_OF_TODAY": literal_texts.time_text,
    "REAL_TEXT_OF_TODAY": partial(texts.todays_real_text, Elementary.REAL),
    "LREAL_TEXT_OF_TODAY": partial(texts.todays_real_text, Elementary.LREAL),
    **{f"{kind.name}_TO_{text.name}": texts.writer(kind) for kind in Elementary for text in _TEXTS},
    **{f"{text.name}_TO_{kind.name}": texts.reader(kind) for kind in Elementary for text in _TEXTS},
}
"""The names that the Python of conversions calls."""


TRANSFERS: Final[Mapping[str, str]] = {
    "DWORD_TO_REAL": "REAL_OF_BITS({0})",
    "REAL_TO_DWORD": "BITS_OF_REAL({0})",
    "LWORD_TO_LREAL": "LONG_REAL_OF_BITS({0})",
    "LREAL_TO_LWORD": "BITS_OF_LONG_REAL({0})",
    **{f"{bits}_TO_BOOL": "({0} & 1 != 0)" for bits in ("BYTE", "WORD", "DWORD", "LWORD")},
}
"""The Python of the conversions that keep the bits instead of the number in edition 3 (tables 24 and 27)."""


def plain(kind: Type) -> Plain:
    """The type whose rules apply: DWORD for a pointer, the base of an enumeration or a subrange."""
    if isinstance(kind, Elementary | StringType):
        return kind
    if isinstance(kind, SubrangeType | EnumType):
        return kind.base
    if isinstance(kind, PointerType):
        return Elementary.DWORD
    raise TypeError(f"{kind} has no conversions")


def convert(value: Value, source: Type, target: Type) -> Value:
    """Return the value in the type `target`.  Total: every value of `source` has a result in the range of `target`."""
    return _function(plain(source), plain(target))(value)


@cache
def _function(source: Plain, target: Plain) -> Callable[[Value], Value]:
    text = f"lambda value: {expand(python_of(source, target), ['value'])}"
    function: Callable[[Value], Value] = eval(text, {**FUNCTIONS, "__builtins__": {}})
    return function


def python_of(source: Type, target: Type) -> str:
    """Return the Python of the conversion, with {0} for the value; it uses the names in FUNCTIONS only."""
    given, wanted = plain(source), plain(target)
    if isinstance(given, StringType) and isinstance(wanted, StringType):
        text = "NARROW({0})" if given.is_wide and not wanted.is_wide else "{0}"
        return text if given.length <= wanted.length else f"SHORTEN({text}, {wanted.length})"
    if isinstance(wanted, StringType):
        text = f"{name_of(given, wanted)}({{0}})"
        if given is Elementary.WCHAR and not wanted.is_wide:
            text = f"NARROW({text})"
        return text if wanted.length >= texts.LONGEST else f"SHORTEN({text}, {wanted.length})"
    if isinstance(given, StringType):
        return f"{name_of(given, wanted)}({{0}})"
    if given is wanted:
        return "{0}"
    if wanted.is_real:
        return _to_real(given, wanted)
    if wanted is Elementary.BOOL:
        return "({0} != 0)"
    if given.is_real:
        return _number_to(wanted, integer_of("{0}", wanted))
    if given.is_time and wanted.is_time and not (given in LONGER and wanted in LONGER) and not are_twins(given, wanted):
        return _to_time(given, wanted)
    if given is Elementary.WCHAR and wanted is Elementary.CHAR:
        return "NARROW_CODE({0})"
    if given is Elementary.BOOL:
        return "(1 if {0} else 0)" if wanted not in _DAYS else "({0} * 0)"
    if given is Elementary.DT and wanted is Elementary.TOD:
        return f"({{0}} % {DAY_S} * 1000)"
    if given.low >= wanted.low and given.high <= wanted.high and wanted not in _DAYS:
        return "{0}"
    return _number_to(wanted, "{0}")


def _to_real(given: Elementary, wanted: Elementary) -> str:
    if wanted is Elementary.LREAL:
        return "{0}" if given is Elementary.REAL else "FLOAT({0})"
    return "SINGLE({0})"


def _number_to(wanted: Elementary, python: str) -> str:
    """The Python of an integer of any size, brought into the range of the type."""
    if wanted is Elementary.TOD:
        return f"(({python} & {_MASK}) % {_day(wanted)})"
    if wanted is Elementary.LTOD:
        return f"({python} % {_day(wanted)})"
    if wanted in _LONG_DAYS:
        return f"MIDNIGHT({wrapped(python, wanted)})"
    if wanted is Elementary.DATE:
        return f"({wrapped(python, wanted)} // {_day(wanted)} * {_day(wanted)})"
    return wrapped(python, wanted)


_LONG_DAYS: Final = (Elementary.LDATE, Elementary.UNSIGNED_LDATE)
_DAYS: Final = (Elementary.DATE, *_LONG_DAYS)


def _day(kind: Elementary) -> int:
    """A day in what the type counts in."""
    return _DAY_NS // UNITS_NS[kind]


def _to_time(given: Elementary, wanted: Elementary) -> str:
    """The Python of a time or date that keeps its meaning, as far as the other type has it."""
    before, after = UNITS_NS[given], UNITS_NS[wanted]
    if given.low < 0 and given.family is wanted.family is Family.TIME and before < after:
        python = f"WHOLE_UNITS({{0}}, {after // before})"
    else:
        python = f"{{0}} * {before // after}" if before >= after else f"({{0}} // {after // before})"
    return f"({python} % {_day(wanted)})" if wanted is Elementary.TOD else _number_to(wanted, python)


TODAYS: Final[Mapping[str, str]] = {
    **{
        f"{kind}_TO_{text.name}": f"{kind}_TEXT_OF_TODAY({{0}})"
        for kind in ("DT", "TIME", "REAL", "LREAL")
        for text in _TEXTS
    },
    **{f"{text.name}_TO_TIME": "TIME_OF_TEXT_OF_TODAY({0})" for text in _TEXTS},
}
"""The conversions of texts that CODESYS V3 and TwinCAT make otherwise, with their Python."""


def is_rounding(source: Plain, target: Plain) -> bool:
    """True for a conversion of a real number that rounds it to a whole one."""
    if isinstance(source, StringType) or isinstance(target, StringType):
        return False
    return source.is_real and not target.is_real and target is not Elementary.BOOL


def python_away(source: Elementary, target: Elementary) -> str:
    """Return the Python of such a conversion with halves away from zero."""
    return python_of(source, target).replace("ROUND_UNSIGNED(", "ROUND_UNSIGNED_AWAY(").replace("ROUND(", "ROUND_AWAY(")


def cost_of(source: Type, target: Type) -> int:
    """Processor time of the conversion in ns."""
    given, wanted = plain(source), plain(target)
    if isinstance(given, StringType) or isinstance(wanted, StringType):
        return TEXT_NS
    if given.family is Family.REAL:
        return REAL_NS
    return SIMPLE_NS
