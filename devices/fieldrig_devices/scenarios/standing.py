"""A scenario that was played to a rig up to where a property does not hold, and what a person sees of it there.

The rig plays it twice: in a branch, which is judged and says what was done and when, and then itself, by calls that its
past remembers.  So it can go back from there.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.virtual.prelude import RunUntil
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.followed import Followed
from fieldrig_devices.scenarios.hands import Hands
from fieldrig_devices.scenarios.places import has_power
from fieldrig_devices.scenarios.play import Played, play
from fieldrig_devices.scenarios.report import told
from fieldrig_devices.scenarios.scenario_file import Scenario

if TYPE_CHECKING:
    from fieldrig.virtual.journey import Journey
    from fieldrig.virtual.rig import Rig

MOST_SHOWN = 2_000
"""Changes of a place that are shown, the last of them."""

_hands: list[Hands] = []
"""The hands of this process, once it has done something: a bus knows them as members from then on."""


class Standing:
    """A prelude of a rig: the scenario, up to its first violation."""

    def __init__(self, name: str, scenario: Scenario) -> None:
        self.name, self._scenario = name, scenario
        self._begin_ns = 0
        self.played: Played | None = None
        """None before it is known."""
        self.is_there = False
        """True when the rig stands where the scenario ends."""

    async def play(self, journey: "Journey", run_until: RunUntil) -> None:
        await run_until(self._scenario.after_ns)
        self._begin_ns = journey.now_ns
        with journey.rig.branch() as branch:
            self.played = branch.call(_played, self._scenario)
        for act in self.played.done:
            await run_until(self._begin_ns + act.at_ns)
            journey.call(_do, act)
        await run_until(self._begin_ns + self._end_ns(self.played))
        self.is_there = True

    async def answer(self, verb: str, message: Any) -> dict[str, Any]:
        if verb != "timeline":
            raise ControlError(f"a scenario is not asked {verb!r}", "expected timeline")
        return self.timeline()

    def timeline(self) -> dict[str, Any]:
        """Return what was done, the violations and the signals of the properties over time, as JSON."""
        played = self.played
        shown: dict[str, Any] = {
            "name": self.name,
            "is_there": self.is_there,
            "begin_ns": self._begin_ns,
            "length_ns": self._scenario.length_ns,
            "acts": [],
            "violations": [],
            "signals": [],
        }
        if played is None:
            return shown
        return shown | {
            "length_ns": max(played.length_ns, 1),
            "acts": [{"at_ns": act.at_ns, "verb": act.verb, "what": str(act)} for act in played.done],
            "violations": [
                {"at_ns": one.at_ns, "property": one.property, "what": one.what, "told": told(played, one)}
                for one in played.violations
            ],
            "signals": [
                {"place": place, "changes": list(track[-MOST_SHOWN:])} for place, track in played.tracks.items()
            ],
        }

    def _end_ns(self, played: Played) -> int:
        """Return the instant of the violation; what was noticed later, such as a time that is over, was then."""
        last_ns = max((act.at_ns for act in played.done), default=0)
        return max(last_ns, *(one.at_ns for one in played.violations)) if played.violations else played.length_ns


def _played(rig: "Rig", scenario: Scenario) -> Played:
    return play(
        rig, scenario.schedule, scenario.properties, scenario.length_ns, recovery=scenario.recovery, stops_early=True
    )


def _do(rig: "Rig", act: Act) -> None:
    """Do an action as its scenario did; the end of a key that is pressed is an action of its own there."""
    if not _hands:
        places = Followed(rig, lambda _name, _value: None, lambda end: end())

        def read(name: str) -> Value:
            places.add(name, is_read=False)
            return places.read(name)

        def write(name: str, value: Value) -> None:
            places.add(name, is_read=False)
            places.write(name, value)

        _hands.append(Hands(rig, read, write, places.send, partial(has_power, rig)))
    _hands[0].do(act)
