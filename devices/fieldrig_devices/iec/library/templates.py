"""The Python of the standard functions, by the names that an Overload has."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Final

from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.library import conversions, fixed, integers, reals
from fieldrig_devices.iec.library.integers import wrapped
from fieldrig_devices.iec.library.overload import REAL_NS, SIMPLE_NS, Implementation, expand
from fieldrig_devices.iec.types import Value

IMPLEMENTATIONS: Final[Mapping[str, object]] = {
    "MAX": max,
    "MIN": min,
    "ABS": abs,
    "TWO": tuple(2**number for number in range(65)),
    "MULTIPLEX": integers.multiplex,
    "INTEGER_POWER": integers.integer_power,
    "BCD_TO_INTEGER": integers.bcd_to_integer,
    "INTEGER_TO_BCD": integers.integer_to_bcd,
    "IS_BCD": integers.is_bcd,
    "SWAPPED": integers.swapped,
    "SWAPPED_SINGLE": reals.swapped_single,
    "SWAPPED_DOUBLE": reals.swapped_double,
    "POWER": reals.power,
    "SINGLE": reals.single,
    "ATAN2": reals.ATAN2,
    "IS_VALID": reals.IS_VALID,
    **{
        name: getattr(reals, name) for name in ("SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT", "EXP", "LN", "LOG")
    },
    **conversions.FUNCTIONS,
    **fixed.FUNCTIONS,
}
"""The names that the Python of a function may use.

Nothing here raises for values of the parameter types.
"""

TODAY: Final = "TODAY"
"""The end of the name of a conversion to the text that CODESYS V3 and TwinCAT write."""
TRANSFER: Final = "BITS"
"""The end of the name of a conversion that transfers bits, `DWORD_TO_REAL.BITS`."""
AWAY: Final = "AWAY"
"""The end of the name of a conversion that rounds halves away from zero, `REAL_TO_INT.AWAY`."""
REAL_FUNCTIONS: Final = frozenset({"SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT", "EXP", "LN", "LOG"})
SHIFTS: Final = frozenset({"SHL", "SHR", "ROL", "ROR"})


def _absolute_python(_: str, kind: Elementary) -> Implementation:
    if kind.family is Family.SIGNED:
        return Implementation(wrapped("ABS({0})", kind))  # ABS(-32768) is -32768
    return Implementation("ABS({0})")


def _rounded(call: str, kind: Elementary, cost_ns: int) -> Implementation:
    """A call whose result is rounded to single precision for REAL."""
    return Implementation(f"SINGLE({call})" if kind is Elementary.REAL else call, cost_ns)


def _real_python(name: str, kind: Elementary) -> Implementation:
    return _rounded(f"{name}({{0}})", kind, REAL_NS)


def _angle_python(_: str, kind: Elementary) -> Implementation:
    return _rounded("ATAN2({0}, {1})", kind, 2 * REAL_NS)


def _power_python(_: str, kind: Elementary) -> Implementation:
    if not kind.is_real:
        return Implementation(wrapped("INTEGER_POWER({0}, {1})", kind), REAL_NS)
    return _rounded("POWER({0}, {1})", kind, 2 * REAL_NS)


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
    return Implementation(wrapped(conversions.integer_of("{0}", kind, is_cut=True), kind), REAL_NS)


def _swap_python(_: str, kind: Elementary) -> Implementation:
    if kind.is_real:
        return Implementation(f"SWAPPED_{'SINGLE' if kind is Elementary.REAL else 'DOUBLE'}({{0}})", REAL_NS)
    return Implementation(wrapped(f"SWAPPED({{0}}, {kind.size})", kind), REAL_NS)


_TEMPLATES: Final[dict[str, Callable[[str, Elementary], Implementation]]] = {
    "ABS": _absolute_python,
    **dict.fromkeys(REAL_FUNCTIONS, _real_python),
    "ATAN2": _angle_python,
    "IS_VALID": lambda *_: Implementation("IS_VALID({0})", REAL_NS),
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
    "IS_VALID_BCD": lambda *_: Implementation("IS_BCD({0})", REAL_NS),
    "SWAP": _swap_python,
    "TO_BCD": lambda _, kind: Implementation(f"INTEGER_TO_BCD({{0}}, {kind.size * 2})", REAL_NS),
}


@cache
def implementation(name: str) -> Implementation:
    """Return the Python of the function that an Overload named; KeyError for a name that none has."""
    base, _, type_name = name.partition(".")
    if base in fixed.FIXED:
        return fixed.FIXED[base].implementation
    pair = conversions.pair(base)
    if type_name == TODAY:
        return Implementation(conversions.TODAYS[base], conversions.cost_of(*pair) if pair is not None else 0)
    if type_name == AWAY and pair is not None:
        source, target = pair
        assert isinstance(source, Elementary)
        assert isinstance(target, Elementary)
        return Implementation(conversions.python_away(source, target), conversions.cost_of(source, target))
    if type_name == TRANSFER:
        return Implementation(conversions.TRANSFERS[base])
    if pair is not None and not type_name:
        return Implementation(conversions.python_of(*pair), conversions.cost_of(*pair))
    return _TEMPLATES[base](base, Elementary[type_name] if type_name else Elementary.BOOL)


@cache
def _callable(name: str, count: int) -> Callable[..., Value]:
    names = [f"a{number}" for number in range(count)]
    text = f"lambda {', '.join(names)}: {expand(implementation(name).python, names)}"
    function: Callable[..., Value] = eval(text, {**IMPLEMENTATIONS, "__builtins__": {}})
    return function


def evaluate(name: str, values: Sequence[Value]) -> Value:
    """Return what the function gives for constants, for example in a start value."""
    return _callable(name, len(values))(*values)
