"""Both families of rings, the PAM's and SERCOS, with what a suite for both needs to know of each."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, NamedTuple

import pam_ring_kinds as pam
import ring_kinds as sercos

from fieldrig.link import Link
from fieldrig_bus.ring.pam.message import Reception

Kinds = Mapping[str, Callable[..., AbstractContextManager[Any]]]


class Family(NamedTuple):
    kinds: Kinds
    stars: Kinds
    """The kinds over processes."""
    master: Callable[[Link[Any]], Any]
    addresses: Callable[[Any], list[int]]
    """Returns the stations of which the master hears, in their order, from what it hears."""
    is_closed: Callable[[Any], bool]
    """Returns whether what the master sent came back to it."""
    is_whole: Callable[[Any], bool]
    """Returns whether a station has heard all of a cycle."""
    faults: Sequence[Mapping[str, Any]]
    """One of each sort that can happen to such a ring."""


FAMILIES: Mapping[str, Family] = {
    "sercos": Family(
        sercos.KINDS,
        sercos.STARS,
        sercos.Master,
        lambda answers: [at[0] for at in answers.ats],
        lambda answers: answers.ring_closed,
        lambda cycle: bool(cycle.mst and cycle.mdt),
        (
            {"what": "break", "after": "lift"},
            {"what": "off", "station": "knife"},
            {"what": "distort", "station": "belt", "telegram": "mdt"},
            {"what": "distort", "after": "belt", "probability": 0.5},
            {"what": "distort", "after": "master", "telegram": "mst"},
            {"what": "distort", "station": "door", "telegram": "at", "probability": 0.5},
            {"what": "late", "station": "lift", "probability": 0.5},
        ),
    ),
    "pam": Family(
        pam.KINDS,
        pam.STARS,
        pam.Pam,
        lambda reports: [address for address, _ in reports.reports],
        lambda reports: reports.reception is not Reception.NO_CARRIER,
        lambda cycle: cycle.reception is Reception.GOOD,
        (
            {"what": "break", "after": "lift"},
            {"what": "off", "station": "knife"},
            {"what": "distort", "after": "belt", "probability": 0.5},
            {"what": "distort", "after": "master", "count": 2},
            {"what": "halt", "station": "door"},
        ),
    ),
}
