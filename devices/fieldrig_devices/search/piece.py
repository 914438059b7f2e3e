"""Pieces of a search: runs, or parts of them, that depend on nothing but what they say.

A piece has the same outcome on each machine and in each order.  A worker that has a branch of the rig at the begin of
the piece goes on from there; another one plays what comes before it first.
"""

import json
from collections.abc import Mapping
from typing import NamedTuple, get_args

from fieldrig.outside.untrusted import shown
from fieldrig_devices.scenarios.act import Act, Schedule, Verb
from fieldrig_devices.scenarios.property import Violation

World = tuple[str, ...]
"""Other overrides of the rig, such as another seed or load, or other times of the scenario."""


class Piece(NamedTuple):
    acts: Schedule
    """All actions besides those of the scenario, from its begin on."""
    from_ns: int
    """The instant of the scenario at which the piece begins; what was before has been played by another one."""
    until_ns: int
    """The instant at which it ends."""
    is_whole: bool = True
    """True if it is judged at its end what had to happen until then; false if other pieces may go on from there."""
    world: World = ()

    @property
    def before(self) -> Schedule:
        """The actions that come before the piece."""
        return tuple(act for act in self.acts if act.at_ns < self.from_ns)


class Run(NamedTuple):
    """The outcome of a piece."""

    acts: Schedule
    """The actions besides those of the scenario, from its begin on."""
    violations: tuple[Violation, ...]
    length_ns: int
    """The instant at which the piece ends; with a violation it may have been over before."""
    states: frozenset[bytes] = frozenset()
    """The digests of the states of the machine in a piece that others may go on from."""
    world: World = ()
    marks: bytes = b""
    """A byte for each mark of the programs: 1 if it was passed since the begin of the scenario."""
    way: bytes = b""
    """The same of the last 50 ms, if a property did not hold."""
    cpu_s: float = 0.0
    """The time for which its process had a processor; it is no part of what a run is."""
    refused: str = ""
    """The answer of the rig if it has refused an action, such as a second fault of the same kind; it ends the run."""


def acts_text(acts: Schedule) -> str:
    """Return actions as JSON."""
    return json.dumps([list(act) for act in acts])


def acts_of(text: str) -> Schedule:
    """Return the actions of `acts_text`.  TypeError or ValueError for any other text."""
    acts = tuple(Act(*fields) for fields in json.loads(text))
    for act in acts:
        times = (act.at_ns, act.hold_ns, act.nth)
        if not all(type(one) is int and one >= 0 for one in times) or act.verb not in get_args(Verb):
            raise ValueError(f"{shown(list(act))} is no action")
        is_fault = isinstance(act.value, Mapping)
        if not isinstance(act.where, str) or not isinstance(act.when, str) or is_fault != (act.verb == "fault"):
            raise ValueError(f"{shown(list(act))} is no action")
    return acts
