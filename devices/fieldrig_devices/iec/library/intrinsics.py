"""The standard functions: which implementation a call has for its argument types, and its Python.

    is_standard("LIMIT")                        True for every name that `find` knows
    OPERATORS["ADD"]                            functions that are only another form of an operator, such as ADD and GT;
                                                the checker turns them into Unary and Binary itself
    find("MAX", [INT, Untyped(3)])              an Overload, or a message with what is wrong
    implementation("MAX.INT")                   the Python of the name that an Overload, and so an Intrinsic, has
    formal_names("LIMIT", 3)                    the names for a call with named arguments: MN, IN, MX
    evaluate("MAX.INT", [2, 3])                 the result for constants

Source: PacDrive manual 1978 to 2813 (digest 2.3), CoDeSys V2.3 where that is silent, then IEC 61131-3.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final, TypeGuard

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library import conversions, fixed
from fieldrig_devices.iec.library.arguments import (
    ANY_INTEGER,
    ANY_NUMBER,
    BIT_STRINGS,
    INTEGERS,
    Argument,
    Untyped,
    common,
    fits,
    plain,
    smallest,
    widens,
)
from fieldrig_devices.iec.library.overload import Overload
from fieldrig_devices.iec.library.templates import (
    AWAY,
    IMPLEMENTATIONS,
    REAL_FUNCTIONS,
    SHIFTS,
    TODAY,
    TRANSFER,
    evaluate,
    implementation,
)
from fieldrig_devices.iec.library.timed import TIMED
from fieldrig_devices.iec.program import Operator
from fieldrig_devices.iec.types import (
    ArrayType,
    BlockType,
    EnumType,
    PointerType,
    StringType,
    StructType,
    SubrangeType,
    Type,
)

__all__ = [
    "BINARY_ONLY", "BYTE_ORDERS", "IMPLEMENTATIONS", "OPERATORS", "REAL_FUNCTIONS", "SHIFTS",
    "evaluate", "find", "formal_names", "has_byte_order", "implementation", "is_standard", "of_today", "transferring",
]  # fmt: skip

OPERATORS: Final[Mapping[str, Operator]] = {
    **{operator.name: operator for operator in Operator if operator is not Operator.NEG},
}
"""NOT has one operand, those in BINARY_ONLY have two, the others two or more.  GT(a, b, c) is a > b AND b > c."""

BINARY_ONLY: Final = frozenset({"SUB", "DIV", "MOD", "NE"})
"""Names of operators, which is to say of members of Operator."""


def is_standard(name: str) -> bool:
    """True for the name of a standard function, in any case of letters."""
    key = name.upper()
    if key in _RULES or key in fixed.FIXED or key in OPERATORS or key in TIMED:
        return True
    return conversions.pair(key) is not None or _bcd(key) or _overloaded(key) is not None


def alike(name: str) -> list[str]:
    """Return the standard functions that may have been meant by a name: as long, or a letter longer or shorter."""
    known = {*_RULES, *fixed.FIXED, *OPERATORS}
    return sorted(each for each in known if abs(len(each) - len(name)) <= 1 and each[0] == name[:1].upper())


def find(name: str, arguments: Sequence[Argument], wanted: Type | None = None) -> Overload | str:
    """Return the function for these arguments, or a message with what was expected.

    `wanted` is the type of the surroundings, if known; it decides where there are only literals, as in `lr := SQRT(2)`.
    """
    key = name.upper()
    if key in _RULES:
        return _RULES[key](key, arguments, wanted)
    if key in fixed.FIXED:
        return _fixed(key, arguments)
    pair = conversions.pair(key)
    if pair is not None:
        return _conversion(key, *pair, arguments)
    if _bcd(key):
        return _bcd_conversion(key, arguments)
    if _overloaded(key) is not None:
        return _overloaded_conversion(key, arguments)
    return f"{name} is no standard function"


def of_today(overload: Overload) -> Overload:
    """Return the conversion to a text as CODESYS V3 and TwinCAT have it."""
    if overload.name not in conversions.TODAYS:
        return overload
    return _overload(f"{overload.name}.{TODAY}", overload.parameters, overload.result)


def rounding_away(overload: Overload) -> Overload:
    """Return the conversion of a real number to a whole one of CODESYS V3 and TwinCAT: halves away from zero."""
    pair = conversions.pair(overload.name)
    if pair is None or not conversions.is_rounding(*pair):
        return overload
    return _overload(f"{overload.name}.{AWAY}", overload.parameters, overload.result)


def transferring(overload: Overload) -> Overload:
    """Return the conversion as edition 3 has it: from a bit string to REAL, LREAL or BOOL, and back, bits are kept."""
    if overload.name not in conversions.TRANSFERS:
        return overload
    return _overload(f"{overload.name}.{TRANSFER}", overload.parameters, overload.result)


def formal_names(name: str, count: int) -> tuple[str, ...]:
    """Return the names of the `count` parameters, as in LIMIT(MN := 1, IN := x, MX := 5)."""
    key = name.upper()
    if key in fixed.FIXED and fixed.FIXED[key].names:
        return fixed.FIXED[key].names[:count]
    known = {
        "ATAN2": ("Y", "X"),
        "SEL": ("G", "IN0", "IN1"),
        "LIMIT": ("MN", "IN", "MX"),
        "MUX": ("K", *(f"IN{number}" for number in range(count - 1))),
        **dict.fromkeys(SHIFTS, ("IN", "N")),
    }
    if key in known:
        return known[key]
    return ("IN",) if count == 1 else tuple(f"IN{number}" for number in range(1, count + 1))


def fewest(name: str) -> int:
    """Return how many arguments a standard function has at least."""
    key = name.upper()
    if key in fixed.FIXED:
        return len(fixed.FIXED[key].parameters)
    if key in ("SEL", "LIMIT"):
        return 3
    has_two = key in (*OPERATORS, *TIMED, *SHIFTS, "MUX", "MAX", "MIN", "EXPT", "ATAN2") and key != "NOT"
    return 2 if has_two else 1


# ---- the rules for argument types

Rule = Callable[[str, Sequence[Argument], Type | None], Overload | str]


def _expected(name: str, expected: str, arguments: Sequence[Argument]) -> str:
    got = ", ".join(str(argument) for argument in arguments) or "nothing"
    return f"{name}: expected {expected}, got {got}"


def _overload(name: str, parameters: Sequence[Type], result: Type) -> Overload:
    return Overload(name, tuple(parameters), result, implementation(name))


def _absolute(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    outer = wanted if wanted is not None and plain(wanted) in ANY_NUMBER else None  # BOOL around `d = ABS(1)`
    kind = common(arguments, outer) if len(arguments) == 1 else None
    base = plain(kind) if kind is not None else None
    if not isinstance(base, Elementary) or base not in ANY_NUMBER:
        return _expected(name, "one number", arguments)
    return _overload(f"{name}.{base}", [base], base)  # of a subrange, the result may be outside


def _real_kind(arguments: Sequence[Argument], wanted: Type | None) -> Elementary | None:
    """LREAL if an argument is one, or if there are only literals and an LREAL is wanted; REAL for other numbers."""
    kinds = [plain(argument) for argument in arguments]
    if not all(isinstance(kind, Untyped) or kind in ANY_NUMBER for kind in kinds):
        return None
    if Elementary.LREAL in kinds or (wanted is Elementary.LREAL and all(isinstance(kind, Untyped) for kind in kinds)):
        return Elementary.LREAL
    return Elementary.REAL


def _of_reals(count: int, result: Elementary | None = None) -> Rule:
    """The rule of a function of one or two real numbers, whose result has their type if it has no other one."""

    def rule(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
        kind = _real_kind(arguments, wanted)
        if kind is None or len(arguments) != count:
            return _expected(name, "one number" if count == 1 else "two numbers", arguments)
        return _overload(f"{name}.{kind}", [kind] * count, result or kind)

    return rule


def _power(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    """Two integers give an integer (manual: EXPT(7, 2) is 49, and OUT may be an INT); otherwise a real number."""
    real = _real_kind(arguments, wanted)
    if real is None or len(arguments) != 2:
        return _expected(name, "two numbers", arguments)
    kind = common(arguments, wanted)
    base = plain(kind) if kind is not None else real
    result = base if isinstance(base, Elementary) and base in ANY_INTEGER else real
    return _overload(f"{name}.{result}", [result, result], result)


def _shift(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    """The operand is as wide as its type; a literal is as wide as what is wanted, or the smallest bit string."""
    if len(arguments) != 2 or not _is_integer(arguments[1]):
        return _expected(name, "a bit string or integer and the number of bits", arguments)
    kind = plain(arguments[0])
    if isinstance(kind, Untyped):
        target = plain(wanted) if wanted is not None else None
        is_wanted = isinstance(target, Elementary) and target in ANY_INTEGER and fits(kind.value, target)
        signed = [Elementary.SINT, Elementary.INT, Elementary.DINT, Elementary.LINT]
        width = target if is_wanted else smallest(kind.value, [*BIT_STRINGS, *signed])
    else:
        width = kind
    if not isinstance(width, Elementary) or width not in ANY_INTEGER:
        return _expected(name, "a bit string or integer and the number of bits", arguments)
    return _overload(f"{name}.{width}", [width, Elementary.DWORD], width)


def _is_integer(argument: Argument) -> bool:
    kind = plain(argument)
    return kind in ANY_INTEGER or (isinstance(kind, Untyped) and not kind.is_real)


def _is_value(kind: Type | None) -> TypeGuard[Type]:
    """True for a type whose values are in one cell, which is to say no structure, array or instance."""
    return isinstance(kind, Elementary | StringType | EnumType | SubrangeType | PointerType)


def _selection(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    first: Type = Elementary.BOOL if name == "SEL" else Elementary.DINT
    if name == "SEL" and (len(arguments) != 3 or not widens(arguments[0], first)):
        return _expected(name, "a BOOL and two values", arguments)
    if name == "MUX" and (len(arguments) < 2 or not _is_integer(arguments[0])):
        return _expected(name, "an integer and the values", arguments)
    kind = common(arguments[1:], wanted)
    if not _is_value(kind):
        return _expected(name, "elementary values or texts of the same type", arguments)
    return _overload(name, [first, *[kind] * (len(arguments) - 1)], kind)


def _move(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    kind = common(arguments, wanted) if len(arguments) == 1 else None
    if kind is None or isinstance(kind, BlockType):
        return _expected(name, "one value", arguments)
    return _overload(name, [kind], kind)


def _extreme(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    kind = common(arguments, wanted)
    count = {"LIMIT": len(arguments) == 3}.get(name, len(arguments) >= 2)
    if not _is_value(kind) or not count:
        count_text = "three values" if name == "LIMIT" else "at least two values"
        return _expected(name, f"{count_text} of the same kind", arguments)
    return _overload(name, [kind] * len(arguments), kind)


def _truncate(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    """The manual's result is INT; where another integer type is wanted, nothing is cut off on the way to it."""
    real = _real_kind(arguments, Elementary.LREAL)
    target = plain(wanted) if wanted is not None else None
    if real is None or len(arguments) != 1:
        return _expected(name, "one real number", arguments)
    result = target if isinstance(target, Elementary) and target in ANY_INTEGER else Elementary.INT
    return _overload(f"{name}.{result}", [Elementary.LREAL if real is Elementary.LREAL else real], result)


def _fixed(name: str, arguments: Sequence[Argument]) -> Overload | str:
    known = fixed.FIXED[name]
    parameters = list(known.parameters)
    result = known.result
    if any(isinstance(argument, StringType) and argument.is_wide for argument in arguments):
        parameters, result = [*map(_widened, parameters)], _widened(result)
    if known.is_open and len(arguments) > len(parameters):
        parameters += parameters[-1:] * (len(arguments) - len(parameters))
    if len(arguments) != len(parameters) or not all(map(widens, arguments, parameters)):
        return _expected(name, ", ".join(map(str, known.parameters)) or "no argument", arguments)
    return _overload(name, parameters, result)


def _widened(kind: Type) -> Type:
    return replace(kind, is_wide=True) if isinstance(kind, StringType) else kind


def _conversion(
    name: str, source: conversions.Plain, target: conversions.Plain, arguments: Sequence[Argument]
) -> Overload | str:
    """Accept a smaller type than the name says as well, as CoDeSys does: INT_TO_REAL(byte)."""
    if len(arguments) != 1 or not (widens(arguments[0], source) or _same_width(arguments[0], source)):
        return _expected(name, f"one {source}", arguments)
    given = arguments[0]
    parameter = given if isinstance(given, StringType) else source  # a longer text is not cut first
    return _overload(conversions.name_of(source, target), [parameter], target)


def _same_width(argument: Argument, source: conversions.Plain) -> bool:
    """A literal of a negative number for a bit string, as in INT_TO_WORD: it is cut."""
    return isinstance(argument, Untyped) and source in (Elementary.REAL, Elementary.LREAL)


def _overloaded(name: str) -> conversions.Plain | None:
    """Return the target of TO_INT, ANY_TO_INT, TRUNC_INT or REAL_TRUNC_INT, by the type of the argument."""
    name = _TRUNCATION.sub("TRUNC_", name)
    for prefix in ("TO_", "ANY_TO_", "TRUNC_"):
        if name.startswith(prefix):
            kind = conversions.named(name.removeprefix(prefix))
            return kind if prefix != "TRUNC_" or kind in ANY_INTEGER else None
    return None


def _overloaded_conversion(name: str, arguments: Sequence[Argument]) -> Overload | str:
    target = _overloaded(name)
    kind = plain(arguments[0]) if len(arguments) == 1 else None
    if "TRUNC_" in name and isinstance(target, Elementary):
        if name.startswith("REAL_") and kind is Elementary.LREAL:
            return _expected(name, "one REAL", arguments)
        truncation = _truncate("TRUNC", arguments, target)
        return truncation.replace("TRUNC", name, 1) if isinstance(truncation, str) else truncation
    if isinstance(kind, Untyped):
        kind = Elementary.LREAL if kind.is_real else smallest(kind.value, INTEGERS)
    if isinstance(kind, PointerType):
        kind, arguments = Elementary.DWORD, [Elementary.DWORD]  # the number of the address
    if target is None or not isinstance(kind, Elementary | StringType):
        return _expected(name, "one value of an elementary type", arguments)
    is_same_text = isinstance(kind, StringType) and isinstance(target, StringType) and kind.is_wide is target.is_wide
    if is_same_text or kind is target:
        return _move("MOVE", arguments, target)
    return _overload(conversions.name_of(kind, target), [kind], target)


_TRUNCATION: Final = re.compile(r"L?REAL_TRUNC_")
_OF_BCD: Final = re.compile(r"(?:(?P<bits>BYTE|WORD|DWORD|LWORD)_)?BCD_TO_(?P<into>U?[SDL]?INT|BYTE|D?WORD|LWORD)")
_INTO_BCD: Final = re.compile(r"(?:(?P<of>U?[SDL]?INT|BYTE|D?WORD|LWORD)_)?TO_BCD(?:_(?P<bits>BYTE|WORD|DWORD|LWORD))?")


def _bcd(name: str) -> bool:
    into = _INTO_BCD.fullmatch(name)
    return bool(_OF_BCD.fullmatch(name)) or bool(into and (into["of"] or into["bits"]))


def _bcd_conversion(name: str, arguments: Sequence[Argument]) -> Overload | str:
    """Convert from and to BCD; without a bit string in its name, INT_TO_BCD gives the one as wide as the integer.

    The standard writes WORD_BCD_TO_UINT and BCD_TO_UINT, UINT_TO_BCD_WORD and TO_BCD_WORD (table 22).
    """
    given = plain(arguments[0]) if len(arguments) == 1 else None
    if given is None or not _is_integer(arguments[0]):
        return _expected(name, "one integer or bit string", arguments)
    if (match := _OF_BCD.fullmatch(name)) is not None:
        is_long = given in (Elementary.LWORD, Elementary.LINT, Elementary.ULINT)
        bits = Elementary[match["bits"]] if match["bits"] else Elementary.LWORD if is_long else Elementary.DWORD
        is_fitting = not match["bits"] or widens(arguments[0], bits)
        return (
            _overload(f"BCD_TO.{match['into']}", [bits], Elementary[match["into"]])
            if is_fitting
            else _expected(name, f"one {bits}", arguments)
        )
    match = _INTO_BCD.fullmatch(name)
    assert match is not None
    own = smallest(given.value, INTEGERS) if isinstance(given, Untyped) else given
    kind = Elementary[match["of"]] if match["of"] else own
    if not isinstance(kind, Elementary) or not widens(arguments[0], kind):
        return _expected(name, f"one {match['of'] or 'integer'}", arguments)
    by_size = next(bits for bits in BIT_STRINGS if bits.size == kind.size)
    result = Elementary[match["bits"]] if match["bits"] else by_size
    return _overload(f"TO_BCD.{result}", [kind], result)


def _valid_bcd(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    given = plain(arguments[0]) if len(arguments) == 1 else None
    kind = smallest(given.value, BIT_STRINGS) if isinstance(given, Untyped) else given
    if not isinstance(kind, Elementary) or kind not in BIT_STRINGS:
        return _expected(name, "one bit string", arguments)
    return _overload(name, [kind], Elementary.BOOL)


BYTE_ORDERS: Final = frozenset({"TO_BIG_ENDIAN", "FROM_BIG_ENDIAN", "TO_LITTLE_ENDIAN", "FROM_LITTLE_ENDIAN"})
_OF_ONE_BYTE: Final = frozenset(kind for kind in Elementary if kind.size == 1)
_NOT_OF_ALL_BITS: Final = frozenset({Elementary.TOD, Elementary.LTOD, Elementary.LDATE, Elementary.UNSIGNED_LDATE})
"""Types whose values do not use all of their bits, so that bytes in another order are no value."""


def has_byte_order(kind: Type) -> bool:
    """Return whether each value in a structure or an array is one of its type with its bytes in another order, too.

    The characters of a STRING are bytes, and stay where they are.
    """
    waiting, seen = [kind], set[int]()
    while waiting:
        part = waiting.pop()
        if id(part) in seen:
            continue
        seen.add(id(part))
        if isinstance(part, ArrayType):
            waiting.append(part.element)
        elif isinstance(part, StructType) and not part.is_union:
            waiting.extend(field.type for field in part.fields.values())
        elif not (isinstance(part, StringType) and not part.is_wide):
            base = plain(part)
            if not isinstance(base, Elementary) or base in _NOT_OF_ALL_BITS:
                return False
    return True


def _byte_order(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    """Convert between the order of the controller, whose lowest byte comes first, and another one (table 38)."""
    kind = common(arguments, wanted) if len(arguments) == 1 else None
    base = plain(kind) if kind is not None else None
    if not isinstance(base, Elementary) or base in _NOT_OF_ALL_BITS:
        return _expected(name, "one number, bit string, duration or date with time", arguments)
    if "LITTLE" in name or base in _OF_ONE_BYTE:
        return _overload("MOVE", [base], base)
    return _overload(f"SWAP.{base.name}", [base], base)


_RULES: Final[dict[str, Rule]] = {
    "ABS": _absolute,
    **dict.fromkeys(REAL_FUNCTIONS, _of_reals(1)),
    "ATAN2": _of_reals(2),
    "IS_VALID": _of_reals(1, Elementary.BOOL),
    "IS_VALID_BCD": _valid_bcd,
    **dict.fromkeys(BYTE_ORDERS, _byte_order),
    "EXPT": _power,
    **dict.fromkeys(SHIFTS, _shift),
    "SEL": _selection,
    "MUX": _selection,
    "MOVE": _move,
    **dict.fromkeys(("MAX", "MIN", "LIMIT"), _extreme),
    "TRUNC": _truncate,
}
