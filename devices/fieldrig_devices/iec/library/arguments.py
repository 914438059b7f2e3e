"""The types of arguments: what a value may become without a conversion in the source, and what several have in common.

Rules: a value never goes implicitly into a smaller type (PacDrive manual 2564 to 2572).  Integers and bit strings of
the same size may be mixed, and integers become real numbers, both as in CoDeSys V2.3.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.elementary import SHORT_TIMES, Elementary, Family, are_twins, is_longer
from fieldrig_devices.iec.types import EnumType, StringType, SubrangeType, Type


@dataclass(frozen=True, slots=True)
class Untyped:
    """The type of a literal such as 7 or 2.5, which takes the type of its surroundings if its value fits."""

    value: int | float

    @property
    def is_real(self) -> bool:
        return isinstance(self.value, float)

    def __str__(self) -> str:
        return f"the number {self.value}"


Argument = Type | Untyped

BIT_STRINGS: Final = (Elementary.BYTE, Elementary.WORD, Elementary.DWORD, Elementary.LWORD)
INTEGERS: Final = (Elementary.INT, Elementary.DINT, Elementary.UDINT, Elementary.LINT, Elementary.ULINT)
"""The types that an integer without surroundings tries, in this order."""
ANY_INTEGER: Final = frozenset(kind for kind in Elementary if kind.is_integer)
ANY_NUMBER: Final = ANY_INTEGER | {Elementary.REAL, Elementary.LREAL}


def plain(argument: Argument) -> Argument:
    """The elementary type behind an enumeration or a subrange; any other type as it is."""
    return argument.base if isinstance(argument, SubrangeType | EnumType) else argument


def fits(value: int | float, into: Elementary) -> bool:
    """True if a literal with this value may have the type `into`."""
    if into.is_real:
        return True
    if isinstance(value, float) or not (into.is_integer or into.family is Family.BOOL):
        return False
    return into.low <= value <= into.high


def smallest(value: int | float, kinds: Sequence[Elementary]) -> Elementary | None:
    return next((kind for kind in kinds if fits(value, kind)), None)


def widens(argument: Argument, into: Type) -> bool:
    """True if a value of the type `argument` becomes one of type `into` without a conversion in the source."""
    given, target = plain(argument), plain(into)
    if isinstance(given, Untyped):
        return isinstance(target, Elementary) and fits(given.value, target)
    if isinstance(target, StringType):
        is_text = isinstance(given, StringType) and given.is_wide is target.is_wide
        return is_text or given is (Elementary.WCHAR if target.is_wide else Elementary.CHAR)
    if not isinstance(given, Elementary) or not isinstance(target, Elementary) or given is target:
        return given == target
    if is_longer(given, target) or (given in SHORT_TIMES and target in SHORT_TIMES) or are_twins(given, target):
        return True
    if target.is_real:
        return given.is_integer or given is Elementary.REAL
    return given.is_integer and target.is_integer and given.size <= target.size


def common(arguments: Sequence[Argument], wanted: Type | None = None) -> Type | None:
    """The type in which several arguments are compared or selected; None if they have none in common.

    The largest type wins; at the same size a signed type wins over an unsigned one, and that over a bit string.
    Literals join the others.  Where there are only literals, `wanted` decides if all fit it; otherwise INT comes first.
    """
    typed = [argument for argument in arguments if not isinstance(argument, Untyped)]
    literals = [argument for argument in arguments if isinstance(argument, Untyped)]
    if not typed:
        return _of_literals(literals, wanted)
    first = typed[0]
    if all(argument == first for argument in typed) and all(widens(literal, first) for literal in literals):
        return first
    kinds = [plain(argument) for argument in typed]
    texts = [kind for kind in kinds if isinstance(kind, StringType)]
    if len(texts) == len(kinds) and not literals:
        return max(texts, key=lambda kind: kind.length) if len({text.is_wide for text in texts}) == 1 else None
    best = _largest([kind for kind in kinds if isinstance(kind, Elementary)])
    if best is None or len(kinds) != len([kind for kind in kinds if isinstance(kind, Elementary)]):
        return None
    for literal in literals:
        if not fits(literal.value, best):
            joined = Elementary.REAL if literal.is_real else smallest(literal.value, INTEGERS)
            best = _largest([best, joined]) if joined else None
        if best is None:
            return None
    return best if all(widens(argument, best) for argument in arguments) else None


def _of_literals(literals: Sequence[Untyped], wanted: Type | None) -> Elementary | None:
    target = plain(wanted) if wanted is not None else None
    if isinstance(target, Elementary) and all(fits(literal.value, target) for literal in literals):
        return target
    if any(literal.is_real for literal in literals):
        return Elementary.REAL
    return next((kind for kind in INTEGERS if all(fits(literal.value, kind) for literal in literals)), None)


_RANK: Final = {Family.BOOL: 0, Family.BITS: 0, Family.UNSIGNED: 1, Family.SIGNED: 2, Family.REAL: 3}


def _largest(kinds: Sequence[Elementary]) -> Elementary | None:
    """The largest of several types of numbers; None if one is no number and they are not all the same."""
    if len(set(kinds)) == 1:
        return kinds[0]
    if not kinds or not all(kind in ANY_NUMBER for kind in kinds):
        return None
    reals = [kind for kind in kinds if kind.is_real]
    if reals:
        return max(reals, key=lambda kind: kind.size)
    size = max(kind.size for kind in kinds)
    sign = max((kind.family for kind in kinds), key=lambda family: _RANK[family])
    return next(kind for kind in Elementary if kind.family is sign and kind.size == size)
