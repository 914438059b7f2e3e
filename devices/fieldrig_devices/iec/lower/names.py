"""The names that generated Python may use besides its own variables, `frame` and `base`.

`M` is the memory and `K` the kinds of its cells (`layout.py`).  `F` rounds to single precision: a value that has been
stored in it is read back as a REAL, exactly as IEEE 754 prescribes, with infinities and subnormal numbers.
"""

from typing import Final

from fieldrig.coverage.marks import HIT
from fieldrig.sandbox import Values
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library.intrinsics import IMPLEMENTATIONS

REALS: Final = 64  # elements of F
CUTS: Final = {kind: f"as_{kind.name}" for kind in Elementary if kind.is_integer or kind.is_signed}
"""Functions that cut an integer to a type, for those types where that is no simple mask."""
AREA_TABLES: Final = {"I": "I", "Q": "Q", "M": "X"}

TABLES: Final = frozenset({"M", "K", "F", *AREA_TABLES.values(), "INFINITY", "NAN"})
CHECKS: Final = frozenset({"outside_array", "outside_range", "null_reference", "thrown"})
POINTERS: Final = frozenset(
    {
        "allocate",
        "free",
        "peek",
        "poke",
        "peek_cells",
        "poke_cells",
        "swapped_cells",
        "of_form",
        "mark",
        "mark_on_stack",
    }
)
AREAS: Final = frozenset({"fetch", "put", "on_output"})
PARAMETERS: Final = frozenset({"parameter", "set_parameter", "begin_read", "begin_write"})
WAITING: Final = frozenset({"is_waiting", "taken", "finish"})
NATIVE: Final = "native_{}"
BEGIN: Final = "begin_{}"

_VALUES: Final = frozenset(name for name, function in IMPLEMENTATIONS.items() if not callable(function))
FIXED: Final = (
    TABLES
    | CHECKS
    | POINTERS
    | AREAS
    | PARAMETERS
    | WAITING
    | frozenset(IMPLEMENTATIONS)
    | {*CUTS.values(), "now_ms", "LENGTH", "FIND_IN"}
)


def names_of(images: int, natives: int, *, has_marks: bool = False) -> frozenset[str]:
    """Return all names of a program with these numbers of constant images and native POUs."""
    own = {f"image_{number}" for number in range(images)}
    own |= {name.format(number) for number in range(natives) for name in (NATIVE, BEGIN)}
    return FIXED | own | ({HIT} if has_marks else set())


def rules_of(images: int, *, has_marks: bool = False) -> Values:
    """Return the rules under which generated code runs."""
    own = {f"image_{number}" for number in range(images)}
    return Values(TABLES | _VALUES | own | ({HIT} if has_marks else set()))
