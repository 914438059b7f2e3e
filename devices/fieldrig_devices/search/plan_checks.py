"""Checks, before anything is searched, that a rig has all that its plan names; each mistake has its line."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from fieldrig.config.yaml_source import KeyPath
from fieldrig.errors import RigError
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.checks import refuse_at
from fieldrig_devices.scenarios.places import RigPlace, place_of
from fieldrig_devices.search.plan import Plan
from fieldrig_devices.search.run import try_all, try_alone
from fieldrig_devices.search.vary import choices_for

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

Refused = list[tuple[KeyPath, Act]]


def check_plan(rig: "Rig", plan: Plan) -> Refused:
    """Return the values that the rig has refused, maybe because of those tried before; nothing may run the rig later.

    ConfigError, with every mistake, for places, faults and devices that it does not have.
    """
    refused: Refused = []
    refuse_at(plan.scenario.source, (*_of_entries(rig, plan, refused), *_of_places(rig, plan)))
    return refused


def check_alone(rig: "Rig", plan: Plan, path: KeyPath, act: Act) -> None:
    """ConfigError for a value that a rig refuses to which nothing else has happened."""
    try:
        try_alone(rig, act)
    except RigError as wrong:
        refuse_at(plan.scenario.source, [(path, wrong)])


def _of_entries(rig: "Rig", plan: Plan, refused: Refused) -> Iterator[tuple[KeyPath, RigError]]:
    places: dict[str, RigPlace] = {}
    for number, given in enumerate(plan.vary):
        path: KeyPath = ("vary", number, given.key)
        try:
            refused += [(path, act) for act in try_all(rig, choices_for(rig, given), places)]
        except RigError as wrong:
            yield path, wrong


def _of_places(rig: "Rig", plan: Plan) -> Iterator[tuple[KeyPath, RigError]]:
    """Yield the further places of the plan that there are not."""
    data = plan.scenario.source.data if plan.scenario.source is not None else None
    for key in ("edges", "states"):
        for number, name in enumerate((data or {}).get(key) or ()):
            try:
                place_of(rig, name).read()
            except RigError as wrong:
                yield (key, number), wrong
