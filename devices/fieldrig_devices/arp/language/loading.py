"""Prepare an object file for the card, in a process beside it: the compilation, and the code that the card runs.

An object is compiled again by the card that gets it (`files`), which takes long for a long one.  `load` does all of
that, and returns only what the card needs to run, debug, show and upload the program.
"""

from dataclasses import dataclass, field
from typing import Final

from fieldrig.coverage.marks import HIT
from fieldrig.coverage.places import Marked
from fieldrig.loop.background import Bulk, Report
from fieldrig_devices.arp.language.files import ObjectError, decode, encode
from fieldrig_devices.arp.language.lower import NAMES
from fieldrig_devices.languages.instructions import Routine
from fieldrig_devices.languages.resumable import prepare

NS_PER_OCTET: Final = 5_000
"""Virtual time that a card takes to check one octet of an object, in nanoseconds: 5 s for the largest object."""


@dataclass(frozen=True, slots=True)
class Prepared:
    """The part of `Lowered` that a running program needs."""

    routines: dict[str, Routine]
    texts: list[str]
    marked: Marked = field(default_factory=Marked)


@dataclass(frozen=True, slots=True)
class Loaded:
    """A program that the card can run without compiling anything."""

    name: str
    text: Bulk
    """The object file in canonical form, for an upload."""
    main: str
    lowered: Prepared


@dataclass(frozen=True, slots=True)
class Unusable:
    """An object that the card cannot run."""

    why: str


def load(argument: tuple[bytes, int], report: Report) -> Loaded | Unusable:
    """Compile an object file for the card with this number."""
    data, number = argument
    try:
        decoded = decode(data, report)
    except ObjectError as cause:
        return Unusable(str(cause))
    if decoded.system != number:
        return Unusable(f"the object is for card {decoded.system:02}, and this is card {number:02}")
    compiled = decoded.compiled
    lowered = compiled.lowered
    routines = {name: Routine(instructions) for name, instructions in lowered.routines.items()}
    prepare(routines, NAMES | {HIT}, on_progress=lambda done, steps: report("building", done, steps), is_debugged=True)
    text = Bulk(encode(compiled, decoded.name, number))
    return Loaded(decoded.name, text, compiled.main, Prepared(routines, lowered.texts, lowered.marked))
