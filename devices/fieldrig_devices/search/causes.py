"""Makes failing runs small, and keeps one of each cause: hundreds of runs may fail for one mistake of a program.

Two runs have one cause if the programs took the same way to it: the same branches in the last 50 ms.  With the same
actions (verbs, places and faults) it is enough if one way is a part of the other, as the begin of the 50 ms is not the
same.  Without a program the actions alone have to tell.  A run that has all actions of a finding, and holds without
them, is explained by it.
"""

import re
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from hashlib import sha256
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.errors import RigError
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.scenarios.guard import OF_EVERY_RIG
from fieldrig_devices.scenarios.property import Violation
from fieldrig_devices.scenarios.report import told
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.choices import kind_of
from fieldrig_devices.search.corpus import Corpus, Finding
from fieldrig_devices.search.minimal import fewest_acts, minimal
from fieldrig_devices.search.piece import Piece, Run, World, acts_text

MOST_CAUSES: Final = 12
"""Findings of one property."""
MOST_SHRUNK: Final = 16
"""Runs of one property that are made small; most of them turn out to be known."""
MOST_ALIKE: Final = 3
"""Runs of one property with the same actions at other instants that are made small."""
MOST_EXPLAINED: Final = 100
"""Runs of one property for which it is asked whether a known finding explains them."""

MOST_TRIES: Final = 80
"""Runs in which one finding is made small; a finding with many actions may stay larger."""

Sorts = frozenset[tuple[str, str, str]]


class NotRepeatedError(RigError):
    """A run broke a property, and the same actions broke it no more: something in it depends on chance or on the host.

    That is a fault of the master under test, or of a device.  What does not repeat cannot be made small.
    """

    def __init__(self, name: str) -> None:
        super().__init__(f"a run that broke `{name}` did not break it again", "does its master depend on chance?")


class Causes:
    def __init__(self, bench: Bench, corpus: Corpus) -> None:
        self._bench, self._corpus = bench, corpus
        self._before: Sequence[Finding] = corpus.findings()
        """The findings of earlier searches, whose ways are not known yet."""
        self._seen: set[tuple[str, Sorts, str]] = set()
        self._known: dict[str, list[tuple[Sorts, bytes]]] = {}
        """The actions and the way of each finding of a property."""
        self._outcomes: dict[tuple[str, World, int], Run] = {}
        """The runs that one failing run was made small with."""
        self._shrunk: Counter[str] = Counter()
        self._alike: Counter[tuple[str, Sorts]] = Counter()
        self._asked: Counter[str] = Counter()
        self.not_repeated: Counter[str] = Counter()
        """Runs that broke a property and did not break it again, by property."""

    def take(self, failing: Run) -> list[str]:
        """Take a run in which a property does not hold, and note it as a finding if its cause is new.

        The names of the properties for which it was made small are returned.
        """
        self._learn()
        self._outcomes.clear()
        shrunk: list[str] = []
        for violation in failing.violations:
            name, sorts, way = _name(violation), sorts_of(failing.acts), _digest(failing.way)
            if (name, sorts, way) not in self._seen and self._is_worth(name, sorts):
                self._seen.add((name, sorts, way))
                self._asked[name] += 1
                if not self._is_explained(name, failing):
                    shrunk.append(name)
                    self._shrunk[name] += 1
                    self._alike[name, sorts] += 1
                    try:
                        self._note(name, failing)
                    except NotRepeatedError:
                        self.not_repeated[name] += 1
        return shrunk

    def recall(self, failing: Run, shrunk: Collection[str]) -> None:
        """Take a run that an earlier search has made small for the properties `shrunk`."""
        for violation in failing.violations:
            name, sorts, way = _name(violation), sorts_of(failing.acts), _digest(failing.way)
            if (name, sorts, way) not in self._seen and (name in shrunk or self._is_worth(name, sorts)):
                self._seen.add((name, sorts, way))
                self._asked[name] += 1
                if name in shrunk:
                    self._shrunk[name] += 1
                    self._alike[name, sorts] += 1

    def _learn(self) -> None:
        """Play the findings of earlier searches for their ways, so that what they explain is not made small again."""
        before, self._before = self._before, ()
        for one in before:
            played = self._bench.play(Piece(one.acts, 0, one.length_ns, world=one.world))
            if (found := _of_property(played.violations, one.property)) is not None:
                self._known.setdefault(_name(found), []).append((sorts_of(one.acts), played.way))

    def small(self, violation: Violation, failing: Run) -> Finding:
        """Return a finding of a property that does not hold in a run, as small as possible.

        NotRepeatedError if it holds in the same run now.
        """
        self._outcomes.clear()
        return self._small(_name(violation), failing)[0]

    def _small(self, name: str, failing: Run) -> tuple[Finding, bytes]:
        """Return the finding, and the way to it."""
        length_ns = max(failing.length_ns, self._bench.plan.scenario.length_ns)
        found = self._broken(name, failing, failing.acts, length_ns)
        length_ns = self._shortest(name, failing, failing.acts, found, length_ns)
        broken = self._breaks(name, failing, length_ns, MOST_TRIES)
        acts = fewest_acts(failing.acts, lambda some: broken(some) is not None)
        first = self._broken(name, failing, acts, length_ns)

        def is_same(some: Schedule) -> bool:
            """Return whether actions fail for the same mistake: moved in time they may come to another one."""
            found = broken(some)
            return found is not None and _is_along(found.way, first.way)

        acts = minimal(acts, is_same, self._bench.choices)
        world = failing.world
        if world and self._breaks(name, failing._replace(world=()), length_ns)(acts) is not None:
            world = ()
        return self._told(name, failing._replace(world=world), acts, length_ns)

    def _is_worth(self, name: str, sorts: Sorts) -> bool:
        is_room = len(self._known.get(name, ())) < MOST_CAUSES and self._shrunk[name] < MOST_SHRUNK
        return is_room and self._alike[name, sorts] < MOST_ALIKE and self._asked[name] < MOST_EXPLAINED

    def _is_explained(self, name: str, failing: Run) -> bool:
        """True if the run is one of a known finding."""
        broken = self._breaks(name, failing, failing.length_ns)
        for sorts, way in self._known.get(name, ()):
            if any(way) and way == failing.way:
                return True
            rest = tuple(act for act in failing.acts if sort_of(act) not in sorts)
            if sorts and rest and sorts <= sorts_of(failing.acts) and broken(rest) is None:
                return True
        return False

    def _note(self, name: str, failing: Run) -> None:
        finding, way = self._small(name, failing)
        if any((one.property, one.cause) == (finding.property, finding.cause) for one in self._corpus.findings()):
            return
        known, sorts = self._known.setdefault(name, []), sorts_of(finding.acts)
        for others, other in known:
            if (any(way) and way == other) or (sorts == others and _is_along(way, other)):
                return
        known.append((sorts, way))
        self._corpus.note(finding)

    def _breaks(
        self, name: str, failing: Run, length_ns: int, most: int | None = None
    ) -> Callable[[Schedule], Run | None]:
        """Return a function that plays actions, and returns the run if the property does not hold.

        What was played is not played again, and after `most` further runs nothing fails any more.
        """
        end = None if most is None else len(self._outcomes) + most

        def broken(acts: Schedule) -> Run | None:
            if not acts and not failing.world:
                return None  # the control run was clean
            key = (acts_text(acts), failing.world, length_ns)
            if key not in self._outcomes:
                if end is not None and len(self._outcomes) >= end:
                    return None
                self._outcomes[key] = self._bench.play(Piece(acts, 0, length_ns, world=failing.world))
            played = self._outcomes[key]
            return played if _of(played.violations, name) is not None else None

        return broken

    def _broken(self, name: str, failing: Run, acts: Schedule, length_ns: int) -> Run:
        """Return the run in which these actions break a property, which they are known to do."""
        found = self._breaks(name, failing, length_ns)(acts)
        if found is None:
            raise NotRepeatedError(name)
        return found

    def _told(self, name: str, failing: Run, acts: Schedule, length_ns: int) -> tuple[Finding, bytes]:
        found = self._broken(name, failing, acts, length_ns)
        length_ns = self._shortest(name, failing, acts, found, length_ns)
        played = self._bench.told(Piece(acts, 0, length_ns, world=failing.world))
        violation = _of(played.violations, name)
        if violation is None:
            raise NotRepeatedError(name)
        words = tuple(told(played, violation))
        cause = _digest(found.way) or _digest(repr(sorted(sorts_of(acts))).encode())
        finding = Finding(
            0,
            violation.property,
            acts,
            failing.acts,
            length_ns,
            violation.at_ns,
            violation.what,
            failing.world,
            cause,
            words,
            played.hash,
        )
        return finding, found.way

    def _shortest(self, name: str, failing: Run, acts: Schedule, found: Run, length_ns: int) -> int:
        """Return the roundest time after which it is over."""
        violation = _of(found.violations, name)
        assert violation is not None, "`found` breaks it"
        at_ns = violation.at_ns
        for grid_ns in (1 * S, 100 * MS):
            shorter_ns = (at_ns // grid_ns + 1) * grid_ns
            if shorter_ns < length_ns and self._breaks(name, failing, shorter_ns)(acts) is not None:
                length_ns = shorter_ns
        return length_ns


def sort_of(act: Act) -> tuple[str, str, str]:
    """Return what an action does, whenever and for however long."""
    return act.verb, act.where, kind_of(act)


def sorts_of(acts: Schedule) -> Sorts:
    return frozenset(map(sort_of, acts))


def _name(violation: Violation) -> str:
    """Return the name of a property; for what is raised also what that is, as each is a fault of its own."""
    raised = re.sub(r"0x[\da-f]+|\d+", "#", violation.what) if violation.property in OF_EVERY_RIG else ""
    return f"{violation.property}{raised and f': {raised}'}"


def _of(violations: tuple[Violation, ...], name: str) -> Violation | None:
    """Return the violation of this name; None if the property holds."""
    return next((one for one in violations if _name(one) == name), None)


def _of_property(violations: tuple[Violation, ...], name: str) -> Violation | None:
    """Return the violation of the property of a finding; None if it holds."""
    return next((one for one in violations if one.property == name), None)


def _is_along(way: bytes, other: bytes) -> bool:
    """True if one of two ways has all branches of the other."""
    one, two = int.from_bytes(way, "little"), int.from_bytes(other, "little")
    return one & two in (one, two)


def _digest(way: bytes) -> str:
    return sha256(way).hexdigest()[:12] if any(way) else ""
