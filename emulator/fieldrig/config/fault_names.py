"""Names and numbers in the faults of a bus that nothing on this bus has."""

from collections.abc import Collection, Hashable, Iterator, Mapping
from typing import Any, Final

from fieldrig.config.entries import BusEntry
from fieldrig.settings import MEMBER, WIRE, Settings, WrongKey
from fieldrig.text.nearest import closest

FOR_ALL: Final = {"unit": (0, 255)}
"""Numbers that stand for no single one: broadcasts, and the unit that is not significant."""


def named_in_vain(
    buses: Mapping[str, BusEntry],
    owners: Mapping[tuple[str, str, Hashable], Collection[str]],
    unsure: Collection[str],
    *,
    is_real: bool,
) -> Iterator[WrongKey]:
    """Yield them, given the devices by bus, kind and value of what they claim.

    `unsure` are the buses with a device whose claims are not known.  Unless the time `is_real`, a test may attach
    members of any name; in real time, those from outside have a colon in theirs.
    """
    for bus, entry in buses.items():
        members = [str(member) for member in entry.members]
        for index, fault in enumerate(getattr(entry.bus.settings, "faults", ())):
            for key, what, value in named_by(fault):
                path = ("buses", bus, "faults", index, key)
                if what == WIRE:  # one may be driven from outside (`near_names`)
                    continue
                if what == MEMBER:
                    if is_real and value not in members and ":" not in str(value):
                        yield WrongKey(path, f"{value} has no link to this bus", closest(str(value), members))
                    continue
                there = sorted({owned for at, kind, owned in owners if (at, kind) == (bus, what)}, key=str)
                is_known = value in there or value in FOR_ALL.get(what, ()) or entry.bus.settings.leads_to(what, value)
                if there and not is_known and bus not in unsure:
                    remedy = f"there are: {', '.join(map(str, there))}"
                    yield WrongKey(path, f"nothing on {bus} has {what} {value}", remedy)


def named_by(fault: Settings) -> Iterator[tuple[str, str, Any]]:
    """Yield the key, the kind and the value of everything on its bus that a fault names by its `names`."""
    names: Mapping[str, str] = getattr(fault, "names", {})
    for key, what in names.items():
        given = getattr(fault, key)
        for value in given if isinstance(given, list) else [given]:
            if value is not None:
                yield key, what, value
