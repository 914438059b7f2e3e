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

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Final

from fieldrig_devices.iec.library import conversions, fixed, integers, reals
from fieldrig_devices.iec.library.arguments import (
    ANY_INTEGER,
    ANY_NUMBER,
    BIT_STRINGS,
    Argument,
    Untyped,
    common,
    fits,
    plain,
    smallest,
    widens,
)
from fieldrig_devices.iec.library.integers import wrapped
from fieldrig_devices.iec.library.overload import REAL_NS, SIMPLE_NS, Implementation, Overload, expand
from fieldrig_devices.iec.program import Operator
from fieldrig_devices.iec.types import Elementary, Family, Type, Value

OPERATORS: Final[Mapping[str, Operator]] = {
    **{operator.name: operator for operator in Operator if operator is not Operator.NEG},
}
"""NOT has one operand, SUB, DIV, MOD and NE two, the others two or more.  GT(a, b, c) is a > b AND b > c."""

BINARY_ONLY: Final = frozenset({Operator.SUB, Operator.DIV, Operator.MOD, Operator.NE})

IMPLEMENTATIONS: Final[Mapping[str, object]] = {
    "MAX": max,
    "MIN": min,
    "ABS": abs,
    "TWO": tuple(2**number for number in range(65)),
    "MULTIPLEX": integers.multiplex,
    "INTEGER_POWER": integers.integer_power,
    "BCD_TO_INTEGER": integers.bcd_to_integer,
    "INTEGER_TO_BCD": integers.integer_to_bcd,
    "POWER": reals.power,
    "SINGLE": reals.single,
    **{
        name: getattr(reals, name) for name in ("SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT", "EXP", "LN", "LOG")
    },
    **conversions.FUNCTIONS,
    **fixed.FUNCTIONS,
}
"""Everything that the Python of a function may name.  Nothing here raises for values of the parameter types."""

REAL_FUNCTIONS: Final = frozenset({"SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT", "EXP", "LN", "LOG"})
SHIFTS: Final = frozenset({"SHL", "SHR", "ROL", "ROR"})
SELECTIONS: Final = frozenset({"SEL", "MUX", "MOVE"})


def is_standard(name: str) -> bool:
    """True for the name of a standard function, in any case of letters."""
    key = name.upper()
    return key in _RULES or key in fixed.FIXED or key in OPERATORS or conversions.pair(key) is not None or _bcd(key)


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
    return f"{name} is no standard function"


@cache
def implementation(name: str) -> Implementation:
    """Return the Python of the function that an Overload named; KeyError for a name that none has."""
    base, _, type_name = name.partition(".")
    if base in fixed.FIXED:
        return fixed.FIXED[base].implementation
    pair = conversions.pair(base)
    if pair is not None and not type_name:
        return Implementation(conversions.python_of(*pair), conversions.cost_of(*pair))
    return _TEMPLATES[base](base, Elementary[type_name] if type_name else Elementary.BOOL)


@cache
def _callable(name: str, count: int) -> Callable[..., Value]:
    names = [f"a{number}" for number in range(count)]
    text = f"lambda {', '.join(names)}: {expand(implementation(name).python, names)}"
    found: Callable[..., Value] = eval(text, {**IMPLEMENTATIONS, "__builtins__": {}})
    return found


def evaluate(name: str, values: Sequence[Value]) -> Value:
    """Return what the function gives for constants, for example in a start value."""
    return _callable(name, len(values))(*values)


def formal_names(name: str, count: int) -> tuple[str, ...]:
    """Return the names of the `count` parameters, as in LIMIT(MN := 1, IN := x, MX := 5)."""
    key = name.upper()
    if key in fixed.FIXED and fixed.FIXED[key].names:
        return fixed.FIXED[key].names[:count]
    known = {
        "SEL": ("G", "IN0", "IN1"),
        "LIMIT": ("MN", "IN", "MX"),
        "MUX": ("K", *(f"IN{number}" for number in range(count - 1))),
        **dict.fromkeys(SHIFTS, ("IN", "N")),
    }
    if key in known:
        return known[key]
    return ("IN",) if count == 1 else tuple(f"IN{number}" for number in range(1, count + 1))


# ---- the rules for argument types


def _expected(name: str, expected: str, arguments: Sequence[Argument]) -> str:
    got = ", ".join(str(argument) for argument in arguments) or "nothing"
    return f"{name}: expected {expected}, got {got}"


def _overload(name: str, parameters: Sequence[Type], result: Type) -> Overload:
    return Overload(name, tuple(parameters), result, implementation(name))


def _absolute(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    kind = common(arguments, wanted) if len(arguments) == 1 else None
    base = plain(kind) if kind is not None else None
    if kind is None or base not in ANY_NUMBER:
        return _expected(name, "one number", arguments)
    return _overload(f"{name}.{base}", [kind], kind)


def _real_kind(arguments: Sequence[Argument], wanted: Type | None) -> Elementary | None:
    """LREAL if an argument is one, or if there are only literals and an LREAL is wanted; REAL for other numbers."""
    kinds = [plain(argument) for argument in arguments]
    if not all(isinstance(kind, Untyped) or kind in ANY_NUMBER for kind in kinds):
        return None
    if Elementary.LREAL in kinds or (wanted is Elementary.LREAL and all(isinstance(kind, Untyped) for kind in kinds)):
        return Elementary.LREAL
    return Elementary.REAL


def _real_function(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    kind = _real_kind(arguments, wanted)
    if kind is None or len(arguments) != 1:
        return _expected(name, "one number", arguments)
    return _overload(f"{name}.{kind}", [kind], kind)


def _power(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    """Two integers give an integer (manual: EXPT(7, 2) is 49, and OUT may be an INT); otherwise a real number."""
    real = _real_kind(arguments, wanted)
    if real is None or len(arguments) != 2:
        return _expected(name, "two numbers", arguments)
    kind = common(arguments, None if wanted in (Elementary.REAL, Elementary.LREAL) else wanted)
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


def _selection(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    first: Type = Elementary.BOOL if name == "SEL" else Elementary.DINT
    if name == "SEL" and (len(arguments) != 3 or not widens(arguments[0], first)):
        return _expected(name, "a BOOL and two values", arguments)
    if name == "MUX" and (len(arguments) < 2 or not _is_integer(arguments[0])):
        return _expected(name, "an integer and the values", arguments)
    kind = common(arguments[1:], wanted)
    if kind is None:
        return _expected(name, "values of the same type", arguments)
    return _overload(name, [first, *[kind] * (len(arguments) - 1)], kind)


def _move(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    kind = common(arguments, wanted) if len(arguments) == 1 else None
    return _overload(name, [kind], kind) if kind is not None else _expected(name, "one value", arguments)


def _extreme(name: str, arguments: Sequence[Argument], wanted: Type | None) -> Overload | str:
    kind = common(arguments, wanted)
    count = {"LIMIT": len(arguments) == 3}.get(name, len(arguments) >= 2)
    if kind is None or not count:
        return _expected(name, "three values" if name == "LIMIT" else "at least two values", arguments)
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
    if known.is_open and len(arguments) > len(parameters):
        parameters += parameters[-1:] * (len(arguments) - len(parameters))
    if len(arguments) != len(parameters) or not all(map(widens, arguments, parameters)):
        return _expected(name, ", ".join(map(str, known.parameters)) or "no argument", arguments)
    return _overload(name, parameters, known.result)


def _conversion(
    name: str, source: conversions.Plain, target: conversions.Plain, arguments: Sequence[Argument]
) -> Overload | str:
    """As in CoDeSys, a smaller type than the name says is accepted: INT_TO_REAL(byte)."""
    if len(arguments) != 1 or not (widens(arguments[0], source) or _same_width(arguments[0], source)):
        return _expected(name, f"one {source}", arguments)
    return _overload(conversions.name_of(source, target), [source], target)


def _same_width(argument: Argument, source: conversions.Plain) -> bool:
    """A literal of a negative number for a bit string, as in INT_TO_WORD: it is cut."""
    return isinstance(argument, Untyped) and source in (Elementary.REAL, Elementary.LREAL)


def _bcd(name: str) -> bool:
    before, _, after = name.partition("_TO_")
    return {before, after} & {"BCD"} != set() and any(
        other in Elementary.__members__ and Elementary[other] in ANY_INTEGER for other in (before, after)
    )


def _bcd_conversion(name: str, arguments: Sequence[Argument]) -> Overload | str:
    """BCD_TO_INT takes any bit string; INT_TO_BCD gives the bit string that is as wide as the integer."""
    before, _, after = name.partition("_TO_")
    if len(arguments) != 1 or not _is_integer(arguments[0]):
        return _expected(name, "one integer or bit string", arguments)
    if before == "BCD":
        return _overload(f"BCD_TO.{after}", [Elementary.DWORD], Elementary[after])
    kind = Elementary[before]
    if not widens(arguments[0], kind):
        return _expected(name, f"one {kind}", arguments)
    result = next(bits for bits in BIT_STRINGS if bits.size == kind.size)
    return _overload(f"TO_BCD.{kind}", [kind], result)


_RULES: Final[dict[str, Callable[[str, Sequence[Argument], Type | None], Overload | str]]] = {
    "ABS": _absolute,
    **dict.fromkeys(REAL_FUNCTIONS, _real_function),
    "EXPT": _power,
    **dict.fromkeys(SHIFTS, _shift),
    "SEL": _selection,
    "MUX": _selection,
    "MOVE": _move,
    **dict.fromkeys(("MAX", "MIN", "LIMIT"), _extreme),
    "TRUNC": _truncate,
}


# ---- the Python


def _absolute_python(_: str, kind: Elementary) -> Implementation:
    if kind.family is Family.SIGNED:
        return Implementation(wrapped("ABS({0})", kind))  # ABS(-32768) is -32768
    return Implementation("ABS({0})")


def _real_python(name: str, kind: Elementary) -> Implementation:
    call = f"{name}({{0}})"
    return Implementation(f"SINGLE({call})" if kind is Elementary.REAL else call, REAL_NS)


def _power_python(_: str, kind: Elementary) -> Implementation:
    if not kind.is_real:
        return Implementation(wrapped("INTEGER_POWER({0}, {1})", kind), REAL_NS)
    call = "POWER({0}, {1})"
    return Implementation(f"SINGLE({call})" if kind is Elementary.REAL else call, 2 * REAL_NS)


def _shift_python(name: str, kind: Elementary) -> Implementation:
    """A shift by the width or more leaves zeros, or the sign of a signed integer to the right; rotations go round."""
    bits, mask = kind.bits, 2**kind.bits - 1
    twice = f"({{0}} & {mask}) * {2**bits + 1}"  # the operand twice in a row, for rotations
    python = {
        "SHL": wrapped(f"{{0}} * TWO[MIN({{1}}, {bits})]", kind),
        "SHR": f"({{0}} // TWO[MIN({{1}}, {bits})])",
        "ROL": wrapped(f"{twice} * TWO[{{1}} & {bits - 1}] // {2**bits}", kind),
        "ROR": wrapped(f"{twice} // TWO[{{1}} & {bits - 1}]", kind),
    }[name]
    return Implementation(python)


def _truncate_python(_: str, kind: Elementary) -> Implementation:
    return Implementation(wrapped("TRUNCATE({0})", kind), REAL_NS)


_TEMPLATES: Final[dict[str, Callable[[str, Elementary], Implementation]]] = {
    "ABS": _absolute_python,
    **dict.fromkeys(REAL_FUNCTIONS, _real_python),
    "EXPT": _power_python,
    **dict.fromkeys(SHIFTS, _shift_python),
    "SEL": lambda *_: Implementation("({2} if {0} else {1})"),
    "MUX": lambda *_: Implementation("MULTIPLEX({*})", 2 * SIMPLE_NS),
    "MOVE": lambda *_: Implementation("{0}", 0),
    "MAX": lambda *_: Implementation("MAX({*})"),
    "MIN": lambda *_: Implementation("MIN({*})"),
    "LIMIT": lambda *_: Implementation("MIN(MAX({1}, {0}), {2})", 2 * SIMPLE_NS),
    "TRUNC": _truncate_python,
    "BCD_TO": lambda _, kind: Implementation(wrapped("BCD_TO_INTEGER({0})", kind), REAL_NS),
    "TO_BCD": lambda _, kind: Implementation(f"INTEGER_TO_BCD({{0}}, {kind.size * 2})", REAL_NS),
}
