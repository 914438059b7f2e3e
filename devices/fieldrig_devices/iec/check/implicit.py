"""Which type becomes which without a conversion in the source, and the type in which two operands meet.

EPAS-4: a value never goes into a smaller type (PacDrive manual 2564 to 2572, PD-367).  As in CoDeSys V2.3, integers and
bit strings of the same size may be mixed, and integers become real numbers.  Edition 3 of the standard also asks that
every value of the one type is a value of the other, and keeps bit strings and numbers apart.
"""

from functools import cache
from typing import Final

from fieldrig_devices.iec.elementary import SHORT_TIMES, Elementary, Family, are_twins
from fieldrig_devices.iec.library.arguments import common as common_type
from fieldrig_devices.iec.library.arguments import widens

Pair = tuple[Elementary, Elementary]

WIDENS: Final[frozenset[Pair]] = frozenset((a, b) for a in Elementary for b in Elementary if widens(a, b))
"""(from, to) in EPAS-4."""


def _mantissa(kind: Elementary) -> int:
    return 24 if kind is Elementary.REAL else 53


def is_exact(source: Elementary, target: Elementary) -> bool:
    """True if every value of `source` is a value of `target`."""
    if source is target:
        return True
    if target.is_real:
        return source is Elementary.REAL or (source.is_integer and source.bits <= _mantissa(target))
    return not source.is_real and target.low <= source.low and source.high <= target.high


def _strictly(source: Elementary, target: Elementary) -> bool:
    if (source in SHORT_TIMES and target in SHORT_TIMES) or are_twins(source, target):
        return True  # the same TIME of a program and of a library
    is_bits = Family.BITS in (source.family, target.family)
    return is_exact(source, target) and (not is_bits or source.family is target.family)


STRICT: Final[frozenset[Pair]] = frozenset(pair for pair in WIDENS if _strictly(*pair))
"""(from, to) in edition 3."""


@cache
def common(left: Elementary, right: Elementary, is_strict: bool) -> Elementary | None:
    """Return the type in which two operands meet; None if there is none."""
    if not is_strict:
        shared = common_type((left, right))
        return shared if isinstance(shared, Elementary) else None
    both = [kind for kind in Elementary if (left, kind) in STRICT and (right, kind) in STRICT]
    return min(both, key=lambda kind: (kind.is_real, kind.size), default=None)


@cache
def compared(left: Elementary, right: Elementary) -> Elementary | None:
    """Return a type that holds every value of both, for comparisons; 64 bits where 32 are not enough."""
    if left is right:
        return left
    if not (left.is_integer or left.is_real) or not (right.is_integer or right.is_real):
        return None
    both = [kind for kind in Elementary if is_exact(left, kind) and is_exact(right, kind)]
    both = [kind for kind in both if kind.is_integer or kind.is_real]
    return min(both, key=lambda kind: (kind.is_real, kind.size), default=Elementary.LREAL)
