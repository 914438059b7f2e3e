"""The things that a log expects and a rig cannot give: buses, nodes and units that it does not have, unplayed senders.

Each of them is one difference, unless the user leaves it out: a rig that lacks a device is not as the machine was.
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

from fieldrig.points.values import counted
from fieldrig_devices.replay.grounds import Grounds
from fieldrig_devices.replay.replay_result import Difference, What

MOST: Final = 1_000


class Thing(NamedTuple):
    """Something that the rig does not have."""

    sort: str
    """The kind: `bus`, `node`, `unit`, or `sender`."""
    bus: str
    name: str

    @property
    def words(self) -> str:
        """The thing as a user names it."""
        return {"bus": self.bus, "sender": self.name}.get(self.sort, f"{self.sort} {self.name}")


@dataclass(slots=True)
class _Tally:
    first_ns: int
    count: int = 0
    is_sure: bool = False


class Absent:
    """The things that were missed, each with the number of its messages."""

    def __init__(self) -> None:
        self._tallies: dict[Thing, _Tally] = {}

    def __bool__(self) -> bool:
        return bool(self._tallies)

    def take(self, sort: str, bus: str, name: str, time_ns: int, *, is_sure: bool = True) -> None:
        """Count a message; it is not `is_sure` if it may come from a master."""
        thing = Thing(sort, bus, name)
        tally = self._tallies.get(thing)
        if tally is None:
            if len(self._tallies) >= MOST:
                return
            tally = self._tallies[thing] = _Tally(time_ns)
        tally.count += 1
        tally.is_sure |= is_sure

    def tell(self, grounds: Grounds, log_ns: int) -> None:
        """Report them; `log_ns` is the instant of the log at which it begins."""
        for thing, tally in self._tallies.items():
            if grounds.tolerances.is_left_out(thing.words, thing.bus, thing.words):
                continue
            words = _WORDS[thing.sort].format(name=thing.words, bus=thing.bus, count=counted(tally.count, "message"))
            if not tally.is_sure:
                grounds.result.note(words)
                continue
            subject, since_ns = thing.words, max(tally.first_ns - log_ns, 0)
            grounds.result.add(Difference(since_ns, What.MISSING, thing.bus, subject, "", words))

    @property
    def text(self) -> str:
        """All of them in one line."""
        return ", ".join(thing.words for thing in self._tallies)


_WORDS: Final = {
    "bus": "the rig has no bus that {name} is (--bus): {count}",
    "node": "the rig has no {name}, so the log played {count} of it",
    "unit": "the rig has no {name}: {count} from and to it",
    "sender": "no device of the rig sends what {name} sent on {bus}: {count} (--play master plays the rest)",
}
